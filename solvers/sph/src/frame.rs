//! Places in the world, and boxes around shapes.

use cosplat_core::boundary::{Vec3, scale, sub};
use cosplat_core::distance::Shape;
use cosplat_core::scene::Pose;
use nalgebra::{Quaternion, UnitQuaternion, Vector3};

/// Corners of the box around a shape in its own frame \[m\]; none for planes.
pub(crate) fn bounds(shape: &Shape) -> Option<[Vec3; 2]> {
    let half = match shape {
        Shape::Plane(_) => return None,
        Shape::HeightField(field) => return Some(field.bounds()),
        Shape::Mesh(mesh) => return Some(mesh.bounds()),
        Shape::Box(half) => *half,
        Shape::Sphere(r) => [*r; 3],
        Shape::Cylinder(r, half) => [*r, *r, *half],
    };
    Some([scale(half, -1.0), half])
}

/// A frame in the world.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Frame {
    /// Origin \[m\].
    pub(crate) origin: Vec3,
    /// Orientation.
    pub(crate) turn: UnitQuaternion<f64>,
}

impl Frame {
    /// At an origin with an orientation `[x, y, z, w]`.
    pub(crate) fn new(origin: Vec3, [x, y, z, w]: [f64; 4]) -> Self {
        Self { origin, turn: UnitQuaternion::from_quaternion(Quaternion::new(w, x, y, z)) }
    }

    /// At a pose.
    pub(crate) fn at(pose: &Pose) -> Self {
        Self::new(pose.position_m, pose.orientation)
    }

    /// A point of the frame in the world.
    pub(crate) fn out(&self, x: Vec3) -> Vec3 {
        let turned: Vec3 = (self.turn * Vector3::from(x)).into();
        [0, 1, 2].map(|k| self.origin[k] + turned[k])
    }

    /// A point of the world in the frame.
    pub(crate) fn into_local(self, x: Vec3) -> Vec3 {
        (self.turn.inverse() * Vector3::from(sub(x, self.origin))).into()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use cosplat_core::boundary::norm;

    #[test]
    fn into_a_frame_and_out_again() {
        let frame = Frame::new([1.0, 2.0, 3.0], [0.0, 0.0, 0.6, 0.8]);
        // Rounding of coordinates of some metres.
        assert!(norm(sub(frame.into_local(frame.out([0.1, 0.2, 0.3])), [0.1, 0.2, 0.3])) < 1e-15);
    }
}
