//! One V-cycle of multigrid in single precision, the preconditioner of the pressure's conjugate gradients.
//!
//! Coarse cells are eight fine ones with the mean of their faces' weights (the Galerkin operator of constant
//! interpolation, halved, which is the same equation on the coarse grid). Each level is smoothed by two Jacobi sweeps
//! whose lengths are the roots of Chebyshev's polynomial on [0.5, 2], the upper part of the spectrum, before and after:
//! a polynomial of the same matrix, so that the cycle is symmetric to rounding, as conjugate gradients need it, and no
//! sweep depends on the order of cells. What it guides is solved in double precision, so that its seven digits cost
//! nothing but, rarely, an iteration.

use crate::grid::for_chunks;
use crate::matrix::Matrix;

/// Lengths of Jacobi's sweeps, `1 / (1.25 ± 0.75 cos(π/4))`.
const SWEEPS: [f32; 2] = [0.561_751_3, 1.389_660_2];
/// Pairs of sweeps on the coarsest level.
const COARSEST: usize = 16;
/// Numbers of a level below which one thread is faster than several.
const SERIAL_BELOW: usize = 8000;

/// Unknowns on one level.
#[derive(Clone, Debug, Default)]
pub(crate) struct Level {
    pub(crate) matrix: Matrix<f32>,
    /// One over the sum of the weights around each cell; 0 where that is 0.
    inverse: Vec<f32>,
    /// The solution, and the right side.
    pub(crate) x: Vec<f32>,
    pub(crate) b: Vec<f32>,
    other: Vec<f32>,
}

impl Level {
    pub(crate) fn new(n: [usize; 3]) -> Self {
        let matrix = Matrix::new(n);
        let none = vec![0.0; matrix.size()];
        Self { matrix, inverse: none.clone(), x: none.clone(), b: none.clone(), other: none }
    }

    /// Takes over new weights.
    pub(crate) fn invert(&mut self) {
        let m = &self.matrix;
        for z in 1..=m.n[2] {
            for row in m.rows(z) {
                for i in (z * m.s[2] + row)..(z * m.s[2] + row + m.n[0]) {
                    let sum: f32 = (0..3).map(|a| m.k[a][i] + m.k[a][i + m.s[a]]).sum();
                    self.inverse[i] = if sum > 0.0 { 1.0 / sum } else { 0.0 };
                }
            }
        }
    }

    /// Means of a finer level's weights.
    pub(crate) fn coarsen(&mut self, fine: &Matrix<f32>) {
        let coarse = &mut self.matrix;
        for a in 0..3 {
            let [b, c] = [(a + 1) % 3, (a + 2) % 3];
            let mut last = coarse.n.map(|n| n as isize);
            last[a] += 1;
            for z in 0..last[2] {
                for y in 0..last[1] {
                    for x in 0..last[0] {
                        let at = fine.at([2 * x, 2 * y, 2 * z]);
                        let four = [0, fine.s[b], fine.s[c], fine.s[b] + fine.s[c]];
                        let sum: f32 = four.iter().map(|s| fine.k[a][at + s]).sum();
                        let to = coarse.at([x, y, z]);
                        coarse.k[a][to] = 0.5 * sum;
                    }
                }
            }
        }
    }

    /// The first sweep from nothing.
    fn begin(&mut self, parallel: bool) {
        let (s, b, inverse) = (self.matrix.s[2], &self.b, &self.inverse);
        for_chunks(parallel, &mut self.x, s, &|z, plane| {
            let from = z * s..z * s + plane.len();
            for ((x, b), inverse) in plane.iter_mut().zip(&b[from.clone()]).zip(&inverse[from]) {
                *x = SWEEPS[0] * inverse * b;
            }
        });
    }

    /// One sweep of that length for `b` on its own unknowns.
    fn sweep(&mut self, length: f32, parallel: bool) {
        let (m, all, b, inverse) = (&self.matrix, &self.x, &self.b, &self.inverse);
        for_chunks(parallel, &mut self.other, m.s[2], &|z, plane| {
            for row in m.rows(z) {
                let first = z * m.s[2] + row;
                let part = first..first + m.n[0];
                let out = &mut plane[row..row + m.n[0]];
                m.row(all, first, out);
                let (x, b, inverse) = (&all[part.clone()], &b[part.clone()], &inverse[part]);
                for (((out, x), b), inverse) in out.iter_mut().zip(x).zip(b).zip(inverse) {
                    *out = x + length * inverse * (b - *out);
                }
            }
        });
        std::mem::swap(&mut self.x, &mut self.other);
    }

    /// What is left of `b`, into `other`.
    fn residual(&mut self, parallel: bool) {
        let (m, x, b) = (&self.matrix, &self.x, &self.b);
        for_chunks(parallel, &mut self.other, m.s[2], &|z, plane| {
            for row in m.rows(z) {
                let first = z * m.s[2] + row;
                let out = &mut plane[row..row + m.n[0]];
                m.row(x, first, out);
                out.iter_mut().zip(&b[first..]).for_each(|(out, b)| *out = b - *out);
            }
        });
    }

    /// Sums of eight cells of what a finer level has left, as the right side.
    fn restrict(&mut self, fine: &Self, parallel: bool) {
        let (m, [_, fy, fz]) = (&self.matrix, fine.matrix.s);
        for_chunks(parallel, &mut self.b, m.s[2], &|z, plane| {
            for (y, row) in (1..).zip(m.rows(z)) {
                let first = (2 * z - 1) * fz + (2 * y - 1) * fy + 1;
                let four = [0, fy, fz, fz + fy].map(|s| &fine.other[first + s..first + s + 2 * m.n[0]]);
                for (i, out) in plane[row..row + m.n[0]].iter_mut().enumerate() {
                    *out = four.iter().map(|f| f[2 * i] + f[2 * i + 1]).sum();
                }
            }
        });
    }

    /// Adds a coarser level's solution, the same to eight cells.
    fn correct(&mut self, coarse: &Self, parallel: bool) {
        let (m, [_, cy, cz]) = (&self.matrix, coarse.matrix.s);
        for_chunks(parallel, &mut self.x, m.s[2], &|z, plane| {
            for (y, row) in (1..).zip(m.rows(z)) {
                let first = z.div_ceil(2) * cz + usize::div_ceil(y, 2) * cy + 1;
                let from = &coarse.x[first..first + coarse.matrix.n[0]];
                for (two, value) in plane[row..row + m.n[0]].chunks_exact_mut(2).zip(from) {
                    two[0] += value;
                    two[1] += value;
                }
            }
        });
    }

    /// Spoils the vectors that must not be read before they are written.
    #[cfg(test)]
    pub(crate) fn spoil(&mut self, value: f64) {
        let m = &self.matrix;
        for first in (1..=m.n[2]).flat_map(|z| m.rows(z).map(move |row| z * m.s[2] + row)) {
            for all in [&mut self.x, &mut self.b, &mut self.other] {
                all[first..first + m.n[0]].fill(value as f32);
            }
        }
    }
}

/// One V-cycle for the first level's `b`, from nothing, into its `x`.
pub(crate) fn cycle(levels: &mut [Level], parallel: bool) {
    let Some((fine, coarser)) = levels.split_first_mut() else { return };
    let parallel = parallel && fine.matrix.size() > SERIAL_BELOW;
    fine.begin(parallel);
    fine.sweep(SWEEPS[1], parallel);
    if let Some(coarse) = coarser.first_mut() {
        fine.residual(parallel);
        coarse.restrict(fine, parallel);
        cycle(coarser, parallel);
        fine.correct(&coarser[0], parallel);
    } else {
        for _ in 0..COARSEST {
            fine.sweep(SWEEPS[0], parallel);
            fine.sweep(SWEEPS[1], parallel);
        }
    }
    fine.sweep(SWEEPS[1], parallel);
    fine.sweep(SWEEPS[0], parallel);
}
