//! Moving least squares of degree one over the nearest particles.

use nalgebra::{Matrix3, Vector3};
use rayon::prelude::*;

use super::{BindError, Local, Particles, matrix};
use crate::grid::Grid;
use crate::linalg::{perpendicular, svd, wide};

/// Second moments below this fraction of the largest count as none: neighbours thinner than a hundredth of their width.
const FLAT: f64 = 1e-4;
/// The weight of a neighbour ends at this many times the distance of the last one.
const REACH: f64 = 1.1;

/// Between these ratios of the largest distance that the fit leaves over to that of the farthest neighbour, a Gaussian
/// goes over from the fit to its nearest particle: neighbours that part, as where material tears, have no common motion.
const TORN: [f64; 2] = [1.0, 2.0];
/// A fit of degree one explains any motion of four points. What moves against its neighbours by more than this many times
/// their distance has parted from them too: a half turn makes two of it, with a stretch of two it makes three.
const APART: f64 = 3.0;

/// Weights and gradient vectors of each Gaussian's neighbours.
///
/// With weights wᵢ, Σ wᵢ = 1, centroid x̄ = Σ wᵢ xᵢ, moments M = Σ wᵢ (xᵢ − x̄)(xᵢ − x̄)ᵀ and gᵢ = wᵢ M⁻¹ (xᵢ − x̄), the
/// fit to displacements uᵢ is F = 1 + Σ uᵢ gᵢᵀ and x' = x + Σ wᵢ uᵢ + (F − 1)(x − x̄). It reproduces every affine
/// motion. All displacements are taken against that of the nearest particle, so a translation is exact to the last bit.
#[derive(Clone, Debug, PartialEq)]
pub struct Affine {
    neighbours: usize,
    particles: usize,
    /// Nearest first, `neighbours` a Gaussian.
    indices: Vec<u32>,
    weights: Vec<f32>,
    gradients: Vec<[f32; 3]>,
    /// x − x̄.
    offsets: Vec<[f32; 3]>,
    /// Where the neighbours lie in a plane, its normal, which then stays one; else zero.
    normals: Vec<[f32; 3]>,
}

/// The part of one Gaussian.
struct One {
    indices: Vec<u32>,
    weights: Vec<f32>,
    gradients: Vec<[f32; 3]>,
    offset: [f32; 3],
    normal: [f32; 3],
}

impl Affine {
    /// Binds to the `k` nearest particles, or to all where there are fewer.
    pub(super) fn new(positions: &[[f32; 3]], particles: &[[f32; 3]], k: usize) -> Result<Affine, BindError> {
        if particles.is_empty() || k == 0 {
            return Err(BindError::NoParticles(positions.len()));
        }
        super::finite(&[("particle", particles), ("Gaussian", positions)])?;
        let neighbours = k.min(particles.len());
        let grid = Grid::new(particles);
        let all: Vec<One> =
            positions.par_iter().map_init(Vec::new, |found, &p| one(&grid, particles, p, neighbours, found)).collect();
        Ok(Affine {
            neighbours,
            particles: particles.len(),
            indices: all.iter().flat_map(|o| o.indices.iter().copied()).collect(),
            weights: all.iter().flat_map(|o| o.weights.iter().copied()).collect(),
            gradients: all.iter().flat_map(|o| o.gradients.iter().copied()).collect(),
            offsets: all.iter().map(|o| o.offset).collect(),
            normals: all.iter().map(|o| o.normal).collect(),
        })
    }

    pub(super) fn check(&self, gaussians: usize, particles: usize) -> Result<(), BindError> {
        super::same_lengths(self.offsets.len(), gaussians, self.particles, particles)
    }

    /// Gaussians whose neighbours lie in a plane.
    pub fn flat(&self) -> usize {
        self.normals.iter().filter(|n| is_direction(**n)).count()
    }

    /// The map around one Gaussian. The centre follows the fit; the gradient is the weighted mean of the particles'
    /// own where they are given, else that of the fit. Where the neighbours part, the nearest one is followed instead.
    pub(super) fn local(&self, i: usize, particles: &Particles<'_>) -> Local {
        let range = i * self.neighbours..(i + 1) * self.neighbours;
        let move_of = |p: u32| wide(particles.now[p as usize]) - wide(particles.rest[p as usize]);
        let first = move_of(self.indices[range.start]);
        let (mut mean, mut slope) = (Vector3::zeros(), Matrix3::zeros());
        for n in range.clone() {
            let relative = move_of(self.indices[n]) - first;
            mean += relative * f64::from(self.weights[n]);
            slope += relative * wide(self.gradients[n]).transpose();
        }
        let torn = self.torn(i, particles, &first, &mean, &slope);
        if is_direction(self.normals[i]) {
            slope += turn_normal(&slope, &wide(self.normals[i]));
        }
        let displacement = first + mean + slope * wide(self.offsets[i]);
        let gradient = match particles.gradients {
            // Against the first one, so that equal gradients have exactly their own value as mean.
            Some(all) => {
                let base = matrix(all[self.indices[range.start] as usize]);
                let differences =
                    range.clone().map(|n| (matrix(all[self.indices[n] as usize]) - base) * f64::from(self.weights[n]));
                differences.fold(base, |sum, d| sum + d)
            }
            None => Matrix3::identity() + slope,
        };
        if torn == 0.0 {
            return Local { displacement, gradient };
        }
        let own = particles.gradients.map_or_else(Matrix3::identity, |f| matrix(f[self.indices[range.start] as usize]));
        Local { displacement: displacement.lerp(&first, torn), gradient: gradient * (1.0 - torn) + own * torn }
    }

    /// How far the neighbours have parted, 0 to 1: a smooth step over [`TORN`].
    fn torn(
        &self,
        i: usize,
        particles: &Particles<'_>,
        first: &Vector3<f64>,
        mean: &Vector3<f64>,
        slope: &Matrix3<f64>,
    ) -> f64 {
        if *slope == Matrix3::zeros() {
            return 0.0;
        }
        let range = i * self.neighbours..(i + 1) * self.neighbours;
        let rest = |n: usize| wide(particles.rest[self.indices[n] as usize]);
        let weight = |n: usize| f64::from(self.weights[n]);
        let nearest = rest(range.start);
        let middle: Vector3<f64> = range.clone().map(|n| (rest(n) - nearest) * weight(n)).sum();
        let (mut left, mut spread) = (0.0_f64, 0.0_f64);
        for n in range {
            let arm = rest(n) - nearest - middle;
            let moved = wide(particles.now[self.indices[n] as usize]) - rest(n) - first;
            let over = (moved - mean - slope * arm).norm_squared();
            left = left.max(over).max((moved - mean).norm_squared() / (APART * APART));
            spread = spread.max(arm.norm_squared());
        }
        let ratio = if spread > 0.0 { (left / spread).sqrt() } else { 0.0 };
        let part = ((ratio - TORN[0]) / (TORN[1] - TORN[0])).clamp(0.0, 1.0);
        part * part * (3.0 - 2.0 * part)
    }
}

fn is_direction(n: [f32; 3]) -> bool {
    n.iter().any(|v| *v != 0.0)
}

/// What must be added to the slope F − 1 of a plane with unit normal n so that F n is the unit normal of the moved plane.
fn turn_normal(slope: &Matrix3<f64>, n: &Vector3<f64>) -> Matrix3<f64> {
    if *slope == Matrix3::zeros() {
        return Matrix3::zeros();
    }
    let t = perpendicular(n);
    let s = n.cross(&t);
    let moved = (t + slope * t).cross(&(s + slope * s));
    let length = moved.norm();
    if length > 1e-12 && length.is_finite() { (moved / length - n) * n.transpose() } else { Matrix3::zeros() }
}

fn one(grid: &Grid<'_>, particles: &[[f32; 3]], position: [f32; 3], k: usize, found: &mut Vec<(f64, u32)>) -> One {
    let x = wide(position);
    grid.nearest(x, k, found);
    let reach = found.last().map_or(0.0, |n| n.0) * REACH * REACH;
    // (1 − d²/r²)², and equal weights where all neighbours are in one place.
    let kernel = |d: f64| if reach > 0.0 { (1.0 - d / reach).powi(2) } else { 1.0 };
    let total: f64 = found.iter().map(|n| kernel(n.0)).sum();
    let weights: Vec<f64> = found.iter().map(|n| kernel(n.0) / total).collect();
    let points: Vec<Vector3<f64>> = found.iter().map(|n| wide(particles[n.1 as usize])).collect();
    // From the Gaussian, so that far coordinates cost no digits.
    let offset = -weights.iter().zip(&points).map(|(w, p)| (p - x) * *w).sum::<Vector3<f64>>();
    let arms: Vec<Vector3<f64>> = points.iter().map(|p| p - x + offset).collect();
    let moments: Matrix3<f64> = weights.iter().zip(&arms).map(|(w, a)| a * a.transpose() * *w).sum();
    let parts = svd(&moments);
    let largest = parts.s.iter().copied().fold(0.0, f64::max);
    let there = parts.s.map(|s| s > FLAT * largest && s > 0.0);
    let inverse = Vector3::from_fn(|r, _| if there[r] { 1.0 / parts.s[r] } else { 0.0 });
    let pseudo = parts.v * Matrix3::from_diagonal(&inverse) * parts.u.transpose();
    let normal = match there.iter().position(|t| !t) {
        Some(missing) if there.iter().filter(|t| **t).count() == 2 => parts.u.column(missing).into_owned(),
        _ => Vector3::zeros(),
    };
    One {
        indices: found.iter().map(|n| n.1).collect(),
        weights: weights.iter().map(|w| *w as f32).collect(),
        gradients: weights.iter().zip(&arms).map(|(w, a)| (pseudo * a * *w).map(|v| v as f32).into()).collect(),
        offset: offset.map(|v| v as f32).into(),
        normal: normal.map(|v| v as f32).into(),
    }
}
