//! The staggered grid: components of the velocity on the faces that they cross, everything else in the middle of cells.
//!
//! Arrays are padded by two cells on every side, and one more above for the last face, so that all of them share one
//! numbering: component `a` at number `c` belongs to the lower face of cell `c` along axis `a`.

use cosplat_core::boundary::Vec3;
use rayon::prelude::*;

/// Cells of padding below.
pub(crate) const PAD: usize = 2;

/// Three components of a field on faces.
pub(crate) type Faces = [Vec<f64>; 3];

/// Sizes and place of the grid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Grid {
    /// Cells along each axis.
    pub(crate) n: [usize; 3],
    /// Distance in the arrays of neighbours along each axis.
    pub(crate) s: [usize; 3],
    /// Length of the arrays.
    pub(crate) size: usize,
    /// Edge of a cell \[m\].
    pub(crate) h: f64,
    /// Lower corner \[m\].
    pub(crate) low: Vec3,
}

impl Grid {
    /// `n` cells of edge `h` \[m\] above the corner `low` \[m\].
    pub(crate) fn new(low: Vec3, n: [usize; 3], h: f64) -> Self {
        let all = n.map(|n| n + 2 * PAD + 1);
        Self { n, s: [1, all[0], all[0] * all[1]], size: all.iter().product(), h, low }
    }

    /// Number of the cell at `c`, which may lie up to two cells outside.
    pub(crate) fn at(&self, c: [isize; 3]) -> usize {
        (0..3).map(|k| (c[k] + PAD as isize) as usize * self.s[k]).sum()
    }

    /// Upper corner \[m\].
    pub(crate) fn high(&self) -> Vec3 {
        [0, 1, 2].map(|k| self.low[k] + self.n[k] as f64 * self.h)
    }

    /// Cells.
    pub(crate) fn cells(&self) -> usize {
        self.n.iter().product()
    }

    /// Middle of a cell \[m\].
    pub(crate) fn middle(&self, c: [isize; 3]) -> Vec3 {
        [0, 1, 2].map(|k| self.low[k] + (c[k] as f64 + 0.5) * self.h)
    }

    /// Middle of the lower face of a cell along `axis` \[m\].
    pub(crate) fn face(&self, axis: usize, c: [isize; 3]) -> Vec3 {
        let mut x = self.middle(c);
        x[axis] -= 0.5 * self.h;
        x
    }

    /// An empty field in the middle of cells.
    pub(crate) fn field(&self) -> Vec<f64> {
        vec![0.0; self.size]
    }

    /// An empty field on faces.
    pub(crate) fn faces(&self) -> Faces {
        [self.field(), self.field(), self.field()]
    }

    /// The eight nodes around `x` \[m\] of a field that is offset from lower corners of cells by `offset` cells, and
    /// their weights: linear along each axis, so that they add up to one and their centre is `x`. Places beyond one
    /// cell outside are moved there, where nothing inside has a weight.
    pub(crate) fn around(&self, x: Vec3, offset: Vec3) -> [(usize, f64); 8] {
        let mut first = [0_isize; 3];
        let mut share = [0.0; 3];
        for k in 0..3 {
            let g = (x[k] - self.low[k]) / self.h - offset[k];
            let g = g.clamp(-1.0, self.n[k] as f64 + 1.0);
            first[k] = g.floor() as isize;
            share[k] = g - g.floor();
        }
        let base = self.at(first);
        let mut all = [(0, 0.0); 8];
        for (corner, node) in all.iter_mut().enumerate() {
            let up = [corner & 1, corner >> 1 & 1, corner >> 2];
            let weight = (0..3).map(|k| if up[k] == 1 { share[k] } else { 1.0 - share[k] }).product();
            *node = (base + (0..3).map(|k| up[k] * self.s[k]).sum::<usize>(), weight);
        }
        all
    }

    /// A velocity at a place \[m/s\].
    pub(crate) fn velocity(&self, u: &Faces, x: Vec3) -> Vec3 {
        [0, 1, 2].map(|a| self.around(x, offset(a)).iter().map(|&(i, w)| w * u[a][i]).sum())
    }
}

/// Offset of the faces along `axis` from lower corners of cells, in cells.
pub(crate) fn offset(axis: usize) -> Vec3 {
    let mut offset = [0.5; 3];
    offset[axis] = 0.0;
    offset
}

/// Calls `each(number, chunk)` for chunks of fixed size: what is in them cannot depend on who works on them.
pub(crate) fn for_chunks<T: Send>(
    parallel: bool,
    all: &mut [T],
    chunk: usize,
    each: &(impl Fn(usize, &mut [T]) + Sync),
) {
    if parallel {
        all.par_chunks_mut(chunk).enumerate().for_each(|(i, part)| each(i, part));
    } else {
        all.chunks_mut(chunk).enumerate().for_each(|(i, part)| each(i, part));
    }
}

/// As [`for_chunks`], with a number from each chunk, in order.
pub(crate) fn map_chunks(
    parallel: bool,
    all: &mut [f64],
    chunk: usize,
    each: &(impl Fn(usize, &mut [f64]) -> f64 + Sync),
) -> Vec<f64> {
    if parallel {
        all.par_chunks_mut(chunk).enumerate().map(|(i, part)| each(i, part)).collect()
    } else {
        all.chunks_mut(chunk).enumerate().map(|(i, part)| each(i, part)).collect()
    }
}

/// Numbers from `count` planes, in order.
pub(crate) fn map_planes(parallel: bool, count: usize, each: &(impl Fn(usize) -> f64 + Sync)) -> Vec<f64> {
    if parallel { (0..count).into_par_iter().map(each).collect() } else { (0..count).map(each).collect() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_linear_field_is_read_exactly_and_weights_keep_moments() {
        let grid = Grid::new([-0.3, 0.1, 0.0], [8, 8, 16], 0.1);
        let mut u = grid.faces();
        for (a, field) in u.iter_mut().enumerate() {
            for k in -2..18 {
                for j in -2..10 {
                    for i in -2..10 {
                        let x = grid.face(a, [i, j, k]);
                        field[grid.at([i, j, k])] = 1.0 + x[0] - 2.0 * x[1] + 3.0 * x[2] * (1.0 + a as f64);
                    }
                }
            }
        }
        let x = [0.123, 0.456, 1.234];
        for (a, found) in grid.velocity(&u, x).into_iter().enumerate() {
            // Rounding of numbers of order ten.
            assert!((found - (1.0 + x[0] - 2.0 * x[1] + 3.0 * x[2] * (1.0 + a as f64))).abs() < 1e-13);
        }
        let sum: f64 = grid.around(x, offset(1)).iter().map(|w| w.1).sum();
        assert!((sum - 1.0).abs() < 1e-15);
    }
}
