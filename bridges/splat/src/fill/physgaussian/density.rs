//! The density field of Gaussians on a lattice.

use nalgebra::{Matrix3, Vector3};
use rayon::prelude::*;

use crate::linalg::{rotation_of, wide};
use crate::splats::Splats;

/// Empty cells around the centres of all Gaussians.
const BORDER: f64 = 2.0;
/// Smallest standard deviation, in units of the longest side: eigenvalues of covariances are at least 1e-8 where that
/// side is one.
const THINNEST: f64 = 1e-4;
/// The box over which a Gaussian is spread reaches at most this part of the longest side to either side, so that a needle
/// costs no more than the lattice.
const WIDEST: usize = 8;

/// Cubic cells, x running fastest.
pub(super) struct Lattice {
    lower: Vector3<f64>,
    pub(super) cell: f64,
    pub(super) size: [usize; 3],
}

impl Lattice {
    /// Around all centres, which are finite.
    pub(super) fn around(splats: &Splats, cell: f64) -> Lattice {
        let ends = (Vector3::repeat(f64::INFINITY), Vector3::repeat(f64::NEG_INFINITY));
        let (lower, upper) = splats.positions.iter().fold(ends, |(l, u), p| (l.inf(&wide(*p)), u.sup(&wide(*p))));
        let lower = lower.add_scalar(-BORDER * cell);
        // Conversion to integers saturates.
        let size = [0, 1, 2].map(|k| ((upper[k] - lower[k]) / cell + BORDER) as usize + 1);
        Lattice { lower, cell, size }
    }

    /// Number of cells, which may be more than there is memory for.
    pub(super) fn cells(&self) -> f64 {
        self.size.iter().map(|n| *n as f64).product()
    }

    /// Cell of a point.
    pub(super) fn cell_of(&self, p: Vector3<f64>) -> [usize; 3] {
        [0, 1, 2].map(|k| (((p[k] - self.lower[k]) / self.cell) as usize).min(self.size[k] - 1))
    }

    /// Place of a cell in an array.
    pub(super) fn index(&self, c: [usize; 3]) -> usize {
        (c[2] * self.size[1] + c[1]) * self.size[0] + c[0]
    }

    /// A point of a cell; its parts from 0 to 1.
    pub(super) fn point(&self, index: usize, parts: [f64; 3]) -> Vector3<f64> {
        let [nx, ny, _] = self.size;
        let c = [index % nx, index / nx % ny, index / (nx * ny)];
        self.lower + Vector3::from_fn(|k, _| (c[k] as f64 + parts[k]) * self.cell)
    }
}

/// One Gaussian and the cells over which it is spread.
struct Blob {
    centre: Vector3<f64>,
    /// Inverse of the covariance.
    precision: Matrix3<f64>,
    opacity: f64,
    cell: [usize; 3],
    reach: usize,
}

/// Density of each cell, and how many Gaussians would have reached farther than they may.
///
/// A Gaussian adds its opacity times the mean of exp(−½ rᵀ A⁻¹ r) over the eight corners of each cell within as many cells
/// as its largest standard deviation has, rounded up.
pub(super) fn density(splats: &Splats, lattice: &Lattice) -> (Vec<f32>, usize) {
    let most = (lattice.size.into_iter().max().unwrap_or(1) / WIDEST).max(1);
    let longest = lattice.size.into_iter().max().unwrap_or(1) as f64 * lattice.cell;
    let blob = |i: usize| {
        let sigma = splats.scales(i).map(|s| s.max(THINNEST * longest));
        let centre = wide(splats.positions[i]);
        let axes = rotation_of(splats.rotations[i]);
        let precision = axes * Matrix3::from_diagonal(&Vector3::from(sigma.map(|s| s.powi(-2)))) * axes.transpose();
        // Conversion to integers saturates.
        let wanted = (sigma.into_iter().fold(0.0, f64::max) / lattice.cell).ceil() as usize;
        let blob = Blob {
            centre,
            precision,
            opacity: splats.opacity(i),
            cell: lattice.cell_of(centre),
            reach: wanted.min(most),
        };
        (blob, wanted > most)
    };
    let blobs: Vec<(Blob, bool)> = (0..splats.len()).into_par_iter().map(blob).collect();
    let mut of_layer: Vec<Vec<u32>> = vec![Vec::new(); lattice.size[2]];
    for (i, (blob, _)) in blobs.iter().enumerate() {
        let last = (blob.cell[2] + blob.reach).min(lattice.size[2] - 1);
        for layer in &mut of_layer[blob.cell[2].saturating_sub(blob.reach)..=last] {
            layer.push(i as u32);
        }
    }
    let mut field = vec![0.0_f32; lattice.size.iter().product()];
    let layers = field.par_chunks_mut(lattice.size[0] * lattice.size[1]).enumerate();
    // Each layer adds up its Gaussians in their order, so that threads change nothing.
    layers.for_each_init(Vec::new, |corners, (z, layer)| {
        of_layer[z].iter().for_each(|&i| blobs[i as usize].0.spread(lattice, z, layer, corners));
    });
    (field, blobs.iter().filter(|(_, cut)| *cut).count())
}

impl Blob {
    /// Adds to one layer of cells. `corners` is room for values at corners.
    fn spread(&self, lattice: &Lattice, z: usize, layer: &mut [f32], corners: &mut Vec<f64>) {
        let range =
            |k: usize| (self.cell[k].saturating_sub(self.reach), (self.cell[k] + self.reach).min(lattice.size[k] - 1));
        let ((x0, x1), (y0, y1)) = (range(0), range(1));
        let width = x1 - x0 + 2;
        let value = |x: usize, y: usize, z: usize| {
            let node = lattice.lower + Vector3::new(x as f64, y as f64, z as f64) * lattice.cell;
            let r = self.centre - node;
            (-0.5 * r.dot(&(self.precision * r))).exp()
        };
        corners.clear();
        for y in y0..=y1 + 1 {
            corners.extend((x0..=x1 + 1).map(|x| value(x, y, z) + value(x, y, z + 1)));
        }
        for y in 0..=y1 - y0 {
            for x in 0..=x1 - x0 {
                let at = y * width + x;
                let sum = corners[at] + corners[at + 1] + corners[at + width] + corners[at + width + 1];
                layer[(y0 + y) * lattice.size[0] + x0 + x] += (self.opacity * sum / 8.0) as f32;
            }
        }
    }
}
