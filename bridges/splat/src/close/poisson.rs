//! Screened Poisson reconstruction (Kazhdan, Bolitho, Hoppe 2006; Kazhdan & Hoppe 2013) on a regular grid.
//!
//! Wanted is χ that is negative behind the surface, positive before it and zero on it: it minimises
//! ∫ |∇χ − V|² + λ Σ a χ(p)², with V the normals n of the points, each times its area a, spread over the cells around it.
//! Differences of χ along edges of the grid are compared with V at the middles of these edges, so the operator is the
//! Laplacian of seven points with nothing crossing the border. Solved from coarse to fine by conjugate gradients, each
//! level beginning with the one before. No tree: memory is 20 bytes a node.

use nalgebra::Vector3;
use rayon::prelude::*;

use super::normals::Oriented;

/// Cells around the box of the points; no whole number, so that a flat ground does not lie in the nodes, where χ is zero
/// with either sign.
const BORDER: f64 = 4.4;
/// Cells along the longest side of the coarsest level.
const COARSEST: f64 = 8.0;
/// A level is done when the residual is this part of the right side, or after that many steps.
const RESIDUAL: f64 = 1e-4;
const STEPS: usize = 80;

/// Values at the nodes of a grid, x fastest.
pub(crate) struct Field {
    pub(crate) lower: Vector3<f64>,
    pub(crate) cell: f64,
    pub(crate) size: [usize; 3],
    pub(crate) values: Vec<f32>,
}

/// The eight nodes around a place, and the share of each.
struct Around {
    base: usize,
    part: [f32; 3],
    /// λ times the area of the point.
    weight: f32,
}

/// Nodes that a box needs at that size of cells.
pub(super) fn nodes(lower: Vector3<f64>, upper: Vector3<f64>, cell: f64) -> f64 {
    counts(lower, upper, cell, cell).product()
}

fn counts(lower: Vector3<f64>, upper: Vector3<f64>, finest: f64, cell: f64) -> Vector3<f64> {
    (((upper - lower).add_scalar(2.0 * BORDER * finest)) / cell).map(f64::ceil).add_scalar(1.0)
}

/// χ − its mean over the points, at cells of that size. `screening` is λ in units of 1/cell.
pub(super) fn solve(points: &[Oriented], lower: Vector3<f64>, upper: Vector3<f64>, cell: f64, screening: f64) -> Field {
    let mut levels = 0;
    while (upper - lower).max() / cell > COARSEST * f64::from(1 << levels) && levels < 20 {
        levels += 1;
    }
    let origin = lower.add_scalar(-BORDER * cell);
    let mut field: Option<Field> = None;
    for level in (0..=levels).rev() {
        let edge = cell * f64::from(1 << level);
        let size = <[f64; 3]>::from(counts(lower, upper, cell, edge)).map(|n| (n as usize).max(2));
        let mut next = Field { lower: origin, cell: edge, size, values: Vec::new() };
        next.values = match &field {
            Some(coarse) => coarse.at_nodes_of(&next),
            None => vec![0.0; size.iter().product()],
        };
        next.relax(points, screening);
        field = Some(next);
    }
    let mut field = field.unwrap_or(Field { lower: origin, cell, size: [0; 3], values: Vec::new() });
    let total: f64 = points.iter().map(|p| p.area).sum();
    let mean = points.iter().map(|p| field.at(p.place) * p.area).sum::<f64>() / total.max(f64::MIN_POSITIVE);
    field.values.par_iter_mut().for_each(|v| *v -= mean as f32);
    field
}

impl Field {
    fn strides(&self) -> [usize; 3] {
        [1, self.size[0], self.size[0] * self.size[1]]
    }

    /// First of the eight nodes around a place and how far it is from it, in cells; `shift` moves the nodes.
    fn around(&self, p: Vector3<f64>, shift: Vector3<f64>, size: [usize; 3]) -> ([usize; 3], [f32; 3]) {
        let q = (p - self.lower) / self.cell - shift;
        let base = [0, 1, 2].map(|k| (q[k].max(0.0) as usize).min(size[k].saturating_sub(2)));
        (base, [0, 1, 2].map(|k| (q[k] - base[k] as f64).clamp(0.0, 1.0) as f32))
    }

    /// Trilinear.
    pub(crate) fn at(&self, p: Vector3<f64>) -> f64 {
        let (base, part) = self.around(p, Vector3::zeros(), self.size);
        f64::from(gather(&self.values, self.index(base), part, self.strides()))
    }

    pub(crate) fn index(&self, c: [usize; 3]) -> usize {
        (c[2] * self.size[1] + c[1]) * self.size[0] + c[0]
    }

    fn at_nodes_of(&self, fine: &Field) -> Vec<f32> {
        let [nx, ny, nz] = fine.size;
        let mut values = vec![0.0; nx * ny * nz];
        values.par_chunks_mut(nx * ny).enumerate().for_each(|(z, plane)| {
            for (i, v) in plane.iter_mut().enumerate() {
                let node = Vector3::new((i % nx) as f64, (i / nx) as f64, z as f64);
                *v = self.at(fine.lower + node * fine.cell) as f32;
            }
        });
        values
    }

    /// Conjugate gradients on h (Laplacian) χ + λ Σ a φ φᵀ χ = Σ h² V over the edges at each node.
    fn relax(&mut self, points: &[Oriented], screening: f64) {
        let strides = self.strides();
        let lambda = screening / self.cell;
        let around = |p: &Oriented| {
            let (base, part) = self.around(p.place, Vector3::zeros(), self.size);
            Around { base: self.index(base), part, weight: (lambda * p.area) as f32 }
        };
        let around: Vec<Around> = points.par_iter().map(around).collect();
        let right = self.divergence(points);
        let scale = dot(&right, &right);
        if scale <= 0.0 {
            return;
        }
        let mut residual = vec![0.0; right.len()];
        self.apply(&self.values, &around, strides, &mut residual);
        residual.par_iter_mut().zip(&right).for_each(|(r, b)| *r = b - *r);
        drop(right);
        let mut along = residual.clone();
        let mut image = vec![0.0; residual.len()];
        let mut square = dot(&residual, &residual);
        for _ in 0..STEPS {
            if square <= RESIDUAL * RESIDUAL * scale {
                return;
            }
            self.apply(&along, &around, strides, &mut image);
            let curvature = dot(&along, &image);
            if curvature <= 0.0 {
                return;
            }
            let step = (square / curvature) as f32;
            self.values.par_iter_mut().zip(&along).for_each(|(x, p)| *x += step * p);
            residual.par_iter_mut().zip(&image).for_each(|(r, q)| *r -= step * q);
            let next = dot(&residual, &residual);
            let keep = (next / square) as f32;
            along.par_iter_mut().zip(&residual).for_each(|(p, r)| *p = r + keep * *p);
            square = next;
        }
    }

    /// Σ over the edges at each node of ± a n φ / h: V at an edge is that sum over the points, φ linear between edges.
    fn divergence(&self, points: &[Oriented]) -> Vec<f32> {
        let strides = self.strides();
        let mut right = vec![0.0; self.size.iter().product()];
        for p in points {
            for k in 0..3 {
                // Edges along k begin at the nodes but the last, and their middles are half a cell further.
                let mut size = self.size;
                size[k] -= 1;
                let (base, mut part) = self.around(p.place, Vector3::ith(k, 0.5), size);
                if size[k] < 2 {
                    // A single layer of edges takes all of it.
                    part[k] = 0.0;
                }
                let strength = (p.area * p.normal[k] / self.cell) as f32;
                for corner in 0..8 {
                    let Some((offset, share)) = corner_of(corner, part, strides) else { continue };
                    let at = self.index(base) + offset;
                    right[at] -= strength * share;
                    right[at + strides[k]] += strength * share;
                }
            }
        }
        right
    }

    fn apply(&self, x: &[f32], around: &[Around], strides: [usize; 3], out: &mut [f32]) {
        let [nx, ny, nz] = self.size;
        let h = self.cell as f32;
        let plane = nx * ny;
        out.par_chunks_mut(plane).enumerate().for_each(|(z, out)| {
            let below = (z > 0).then(|| &x[(z - 1) * plane..z * plane]);
            let above = (z + 1 < nz).then(|| &x[(z + 1) * plane..(z + 2) * plane]);
            let own = &x[z * plane..(z + 1) * plane];
            for y in 0..ny {
                for i in y * nx..(y + 1) * nx {
                    let c = own[i];
                    let mut sum = 0.0;
                    if i > y * nx {
                        sum += c - own[i - 1];
                    }
                    if i + 1 < (y + 1) * nx {
                        sum += c - own[i + 1];
                    }
                    if y > 0 {
                        sum += c - own[i - nx];
                    }
                    if y + 1 < ny {
                        sum += c - own[i + nx];
                    }
                    sum += below.map_or(0.0, |b| c - b[i]) + above.map_or(0.0, |a| c - a[i]);
                    out[i] = h * sum;
                }
            }
        });
        let values: Vec<f32> = around.par_iter().map(|a| a.weight * gather(x, a.base, a.part, strides)).collect();
        // In the order of the points, so that sums do not depend on threads.
        for (a, value) in around.iter().zip(values) {
            for corner in 0..8 {
                if let Some((offset, share)) = corner_of(corner, a.part, strides) {
                    out[a.base + offset] += value * share;
                }
            }
        }
    }
}

/// Offset and share of one of eight nodes; nothing where the share is none.
fn corner_of(corner: usize, part: [f32; 3], strides: [usize; 3]) -> Option<(usize, f32)> {
    let (mut offset, mut share) = (0, 1.0);
    for k in 0..3 {
        let upper = corner >> k & 1;
        offset += upper * strides[k];
        share *= if upper == 1 { part[k] } else { 1.0 - part[k] };
    }
    (share > 0.0).then_some((offset, share))
}

fn gather(x: &[f32], base: usize, part: [f32; 3], strides: [usize; 3]) -> f32 {
    (0..8).filter_map(|c| corner_of(c, part, strides)).map(|(offset, share)| x[base + offset] * share).sum()
}

/// Sums of pieces of one size, added in order: the same on any number of threads.
fn dot(a: &[f32], b: &[f32]) -> f64 {
    const PIECE: usize = 1 << 16;
    let piece = |(a, b): (&[f32], &[f32])| a.iter().zip(b).map(|(x, y)| f64::from(*x) * f64::from(*y)).sum::<f64>();
    a.par_chunks(PIECE).zip(b.par_chunks(PIECE)).map(piece).collect::<Vec<f64>>().iter().sum()
}
