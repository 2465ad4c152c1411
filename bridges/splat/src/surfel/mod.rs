//! Gaussians for bodies that were never captured: flat ones on their surface or cloth, round ones at particles.

mod dots;
mod fabric;
mod light;
mod mesh;
mod shade;

use nalgebra::{Matrix3, Vector3};

use crate::linalg::{perpendicular, quaternion_of};
use crate::splats::{Axes, Splats, dc_of_colour, logit_of_opacity};

pub use dots::{dots, puffs};
pub use fabric::{Fabric, fabric, topological};
pub use light::{Light, display_of_linear, grained, linear_of_display, lit};
pub use mesh::{MeshSurfels, Worn, colour_by_vertices};
pub use shade::lit_dots;

/// Standard deviation along the surface, in units of the square root of a sample's area. At 0.6 a lattice of samples
/// covers its surface without a visible grid.
const ALONG: f64 = 0.6;
/// Standard deviation across the surface, in units of that along it.
const ACROSS: f64 = 0.1;
const OPACITY: f64 = 0.99;

/// A sample of a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample {
    /// In scene units.
    pub position: [f32; 3],
    /// Normal of any length; zero is taken as +z.
    pub normal: [f32; 3],
    /// The share of the surface that the sample stands for, in scene units².
    pub area: f32,
    /// Red, green, blue from 0 to 1, display values.
    pub colour: [f32; 3],
}

/// One flat Gaussian a sample, of the same colour from every side.
pub fn surfels(samples: &[Sample]) -> Splats {
    let mut splats = Splats::with_capacity(samples.len(), 0);
    splats.axes = Axes::Scene;
    let logit = logit_of_opacity(OPACITY);
    for sample in samples {
        let along = ALONG * f64::from(sample.area.max(f32::MIN_POSITIVE)).sqrt();
        splats.positions.push(sample.position);
        splats.log_scales.push([along, along, along * ACROSS].map(|s| s.ln() as f32));
        splats.rotations.push(facing(sample.normal));
        splats.opacity_logits.push(logit);
        splats.sh_dc.push(sample.colour.map(|c| dc_of_colour(f64::from(c))));
    }
    splats
}

/// A rotation that brings z to the normal.
fn facing(normal: [f32; 3]) -> [f32; 4] {
    let identity = [1.0, 0.0, 0.0, 0.0];
    let Some(n) = Vector3::from(normal.map(f64::from)).try_normalize(0.0).filter(|n| n.iter().all(|v| v.is_finite()))
    else {
        return identity;
    };
    let t = perpendicular(&n);
    quaternion_of(&Matrix3::from_columns(&[t, n.cross(&t), n]), identity)
}
