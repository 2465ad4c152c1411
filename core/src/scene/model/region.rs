//! Parts of a body that are made of another material than the rest.

use serde::{Deserialize, Serialize};

use super::body::{Body, Pose, Source, Vec3};
use crate::boundary::{dot, sub};
use crate::scene::Material;

/// A part of a body of another material. It is no body of its own: the two stick together, touch others as one, and
/// share name, books and state.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Region {
    /// What this part is made of.
    pub material: Material,
    /// Its shape: a box, a sphere or a cylinder.
    pub source: Source,
    /// Pose of that shape in the body's own frame, metres with the up axis of the body.
    pub pose: Pose,
}

impl Region {
    /// Whether a point of the body's own frame \[m\] lies in it or on its surface.
    pub fn contains(&self, x: Vec3) -> bool {
        let away = sub(x, self.pose.position_m);
        let [x, y, z] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].map(|e| dot(away, self.pose.rotate(e)));
        match self.source {
            Source::Box { size_m } => [x, y, z].iter().zip(size_m).all(|(x, size)| x.abs() <= 0.5 * size),
            Source::Sphere { radius_m } => dot(away, away) <= radius_m * radius_m,
            Source::Cylinder { radius_m, height_m } => {
                x * x + y * y <= radius_m * radius_m && z.abs() <= 0.5 * height_m
            }
            _ => false,
        }
    }
}

impl Body {
    /// Materials of the whole body: its own, then those of its regions in the order of the scene.
    pub fn materials(&self) -> impl Iterator<Item = &Material> {
        std::iter::once(&self.material).chain(self.regions.iter().map(|r| &r.material))
    }

    /// Place in [`Body::materials`] of what is at a point of the own frame \[m\]; of regions that overlap, the last.
    pub fn material_at(&self, x: Vec3) -> usize {
        self.regions.iter().rposition(|region| region.contains(x)).map_or(0, |i| i + 1)
    }

    /// Speed of the fastest wave in any of its materials \[m/s\], where one has waves.
    pub fn wave_speed_m_s(&self) -> Option<f64> {
        self.materials().filter_map(Material::wave_speed_m_s).reduce(f64::max)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_region_holds_what_its_turned_shape_holds() {
        let half = std::f64::consts::FRAC_1_SQRT_2;
        // A quarter turn about z: the long edge lies along y.
        let pose = Pose { position_m: [1.0, 0.0, 0.0], orientation: [0.0, 0.0, half, half] };
        let of = |source| Region { material: Material::PointMass, source, pose };
        let long = of(Source::Box { size_m: [4.0, 1.0, 1.0] });
        assert!(long.contains([1.0, 1.9, 0.0]) && !long.contains([2.9, 0.0, 0.0]));
        let ball = of(Source::Sphere { radius_m: 0.5 });
        assert!(ball.contains([1.49, 0.0, 0.0]) && !ball.contains([1.5, 0.1, 0.0]));
        let rod = of(Source::Cylinder { radius_m: 0.5, height_m: 2.0 });
        assert!(rod.contains([1.0, 0.49, -0.99]) && !rod.contains([1.0, 0.0, 1.1]));
        assert!(!of(Source::Points { positions_m: vec![[1.0, 0.0, 0.0]] }).contains([1.0, 0.0, 0.0]));
    }
}
