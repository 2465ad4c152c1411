//! The mean displacement of the nearest particles.

use nalgebra::{Matrix3, Vector3};
use rayon::prelude::*;

use super::{BindError, Local, Particles};
use crate::grid::Grid;
use crate::linalg::wide;

/// The nearest particles of each Gaussian.
///
/// x' = x + Σ uᵢ / k, and nothing turns or stretches (Li et al. 2025, `WonderPlay`, with k = 10). It reproduces
/// translations alone: under a rotation by ω the centres are off by ω times the distance to the mean of the neighbours,
/// which [`super::Affine`] is not.
#[derive(Clone, Debug, PartialEq)]
pub struct Mean {
    neighbours: usize,
    particles: usize,
    /// Nearest first, `neighbours` a Gaussian.
    indices: Vec<u32>,
}

impl Mean {
    /// Binds to the `k` nearest particles, or to all where there are fewer.
    pub(super) fn new(positions: &[[f32; 3]], particles: &[[f32; 3]], k: usize) -> Result<Mean, BindError> {
        if particles.is_empty() || k == 0 {
            return Err(BindError::NoParticles(positions.len()));
        }
        super::finite(&[("particle", particles), ("Gaussian", positions)])?;
        let neighbours = k.min(particles.len());
        let grid = Grid::new(particles);
        let one = |found: &mut Vec<(f64, u32)>, p: &[f32; 3]| {
            grid.nearest(wide(*p), neighbours, found);
            found.iter().map(|n| n.1).collect::<Vec<u32>>()
        };
        let all: Vec<Vec<u32>> = positions.par_iter().map_init(Vec::new, one).collect();
        Ok(Mean { neighbours, particles: particles.len(), indices: all.concat() })
    }

    pub(super) fn check(&self, gaussians: usize, particles: usize) -> Result<(), BindError> {
        super::same_lengths(self.indices.len() / self.neighbours, gaussians, self.particles, particles)
    }

    pub(super) fn local(&self, i: usize, particles: &Particles<'_>) -> Local {
        let of = |p: &u32| wide(particles.now[*p as usize]) - wide(particles.rest[*p as usize]);
        let own = &self.indices[i * self.neighbours..(i + 1) * self.neighbours];
        // Against the first one, so that a translation is exact to the last bit.
        let first = own.first().map_or_else(Vector3::zeros, of);
        let rest: Vector3<f64> = own.iter().map(|p| of(p) - first).sum();
        Local { displacement: first + rest / self.neighbours as f64, gradient: Matrix3::identity() }
    }
}
