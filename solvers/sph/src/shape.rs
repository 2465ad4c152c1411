//! Signed distances of shapes that are formulas, and places in the world.

use cosplat_core::boundary::{Vec3, norm, scale, sub};
use cosplat_core::scene::{Pose, Source};
use nalgebra::{Quaternion, UnitQuaternion, Vector3};

/// A shape in its own frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Shape {
    /// Half space below z = 0, or below a rectangle of half extents \[m\].
    Plane(Option<[f64; 2]>),
    /// Half edge lengths \[m\].
    Box(Vec3),
    /// Radius \[m\].
    Sphere(f64),
    /// Radius and half height along z \[m\].
    Cylinder(f64, f64),
}

impl Shape {
    /// Shape of a source that is a formula.
    pub(crate) fn of(source: &Source) -> Option<Self> {
        Some(match *source {
            Source::Plane { size_m } => Self::Plane(size_m.map(|s| s.map(|s| 0.5 * s))),
            Source::Box { size_m } => Self::Box(scale(size_m, 0.5)),
            Source::Sphere { radius_m } => Self::Sphere(radius_m),
            Source::Cylinder { radius_m, height_m } => Self::Cylinder(radius_m, 0.5 * height_m),
            _ => return None,
        })
    }

    /// Half edges of the box that holds it \[m\]; none for planes.
    pub(crate) fn half(&self) -> Option<Vec3> {
        match *self {
            Self::Plane(_) => None,
            Self::Box(half) => Some(half),
            Self::Sphere(r) => Some([r; 3]),
            Self::Cylinder(r, half) => Some([r, r, half]),
        }
    }

    /// Distance from the surface \[m\], negative inside.
    pub(crate) fn distance(&self, x: Vec3) -> f64 {
        match *self {
            Self::Plane(half) => {
                let beside = half.is_some_and(|h| x[0].abs() > h[0] || x[1].abs() > h[1]);
                if beside { f64::INFINITY } else { x[2] }
            }
            Self::Box(half) => of_box([0, 1, 2].map(|k| x[k].abs() - half[k])),
            Self::Sphere(r) => norm(x) - r,
            // A rectangle in the half plane of (distance from the axis, height).
            Self::Cylinder(r, half) => of_box([x[0].hypot(x[1]) - r, x[2].abs() - half, f64::NEG_INFINITY]),
        }
    }

    /// Direction in which the distance grows, by central differences over `step` \[m\].
    pub(crate) fn normal(&self, x: Vec3, step: f64) -> Vec3 {
        let slope = [0, 1, 2].map(|k| {
            let at = |s: f64| {
                let mut x = x;
                x[k] += s;
                self.distance(x)
            };
            at(step) - at(-step)
        });
        let length = norm(slope);
        if length > 0.0 && length.is_finite() { scale(slope, 1.0 / length) } else { [0.0, 0.0, 1.0] }
    }
}

fn of_box(d: Vec3) -> f64 {
    let inside = d.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    if inside <= 0.0 { inside } else { norm(d.map(|d| d.max(0.0))) }
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

    #[test]
    fn distances_are_those_of_geometry() {
        let cases = [
            (Shape::Box([1.0, 2.0, 3.0]), [1.5, 2.0, 0.0], 0.5),
            (Shape::Box([1.0, 2.0, 3.0]), [0.5, 1.9, 0.0], -0.1),
            (Shape::Sphere(2.0), [0.0, 1.0, 0.0], -1.0),
            (Shape::Cylinder(1.0, 0.5), [0.0, 4.0, 4.5], 5.0),
            (Shape::Cylinder(1.0, 0.5), [0.0, 0.7, 0.0], -0.3),
            (Shape::Plane(None), [5.0, 6.0, -0.25], -0.25),
            (Shape::Plane(Some([1.0, 1.0])), [5.0, 0.0, -0.25], f64::INFINITY),
        ];
        for (shape, x, wanted) in cases {
            let found = shape.distance(x);
            assert!(found.total_cmp(&wanted).is_eq() || (found - wanted).abs() < 1e-15, "{shape:?}: {found}");
        }
        let normal = Shape::Sphere(2.0).normal([0.0, 1.5, 0.0], 1e-3);
        assert!(norm(sub(normal, [0.0, 1.0, 0.0])) < 1e-6, "second order in the step");
        let frame = Frame::new([1.0, 2.0, 3.0], [0.0, 0.0, 0.6, 0.8]);
        assert!(norm(sub(frame.into_local(frame.out([0.1, 0.2, 0.3])), [0.1, 0.2, 0.3])) < 1e-15);
    }
}
