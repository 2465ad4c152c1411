//! Poisson's equation with a weight on each face: conjugate gradients, preconditioned by one V-cycle of multigrid.
//!
//! `Σ_f k_f (q - q_neighbour) = b` in every cell; `k` is 0 at closed sides, and outside of open ones `q = 0`. Coarse
//! cells are eight fine ones with the mean of their faces' weights (the Galerkin operator of constant interpolation,
//! halved, which is the same equation on the coarse grid). Each level is smoothed by two Jacobi sweeps whose lengths
//! are the roots of Chebyshev's polynomial on [0.5, 2], the upper part of the spectrum, before and after: a polynomial
//! of the same matrix, so that the cycle is symmetric, as conjugate gradients need it, and no sweep depends on the
//! order of cells.

use crate::grid::for_chunks;

/// Lengths of Jacobi's sweeps, `1 / (1.25 ± 0.75 cos(π/4))`.
const SWEEPS: [f64; 2] = [0.561_751_3, 1.389_660_2];
/// Pairs of sweeps on the coarsest level.
const COARSEST: usize = 16;
/// Cells below which a level is not made coarser.
const FEW: usize = 64;

/// Unknowns on one level, padded by one cell on every side.
#[derive(Clone, Debug, Default)]
pub(crate) struct Level {
    n: [usize; 3],
    s: [usize; 3],
    /// Weight of the lower face of each cell along each axis.
    pub(crate) k: [Vec<f64>; 3],
    /// One over the sum of the weights around each cell; 0 where that is 0.
    inverse: Vec<f64>,
    x: Vec<f64>,
    b: Vec<f64>,
    other: Vec<f64>,
}

impl Level {
    fn new(n: [usize; 3]) -> Self {
        let all = n.map(|n| n + 2);
        let none = vec![0.0; all.iter().product()];
        let k = [none.clone(), none.clone(), none.clone()];
        let (inverse, x, b, other) = (none.clone(), none.clone(), none.clone(), none);
        Self { n, s: [1, all[0], all[0] * all[1]], k, inverse, x, b, other }
    }

    /// Number of the cell at `c`; -1 and `n` are outside.
    pub(crate) fn at(&self, c: [isize; 3]) -> usize {
        (0..3).map(|k| (c[k] + 1) as usize * self.s[k]).sum()
    }

    /// Length of its arrays.
    pub(crate) fn size(&self) -> usize {
        self.inverse.len()
    }

    /// First cells of the rows of a plane `z` of the padded arrays, in that plane; none in padding.
    fn rows(&self, z: usize) -> impl Iterator<Item = usize> + use<'_> {
        let inside = (1..=self.n[2]).contains(&z);
        (1..=if inside { self.n[1] } else { 0 }).map(|y| y * self.s[1] + 1)
    }

    fn invert(&mut self) {
        for z in 1..=self.n[2] {
            for row in self.rows(z).collect::<Vec<_>>() {
                for i in (z * self.s[2] + row)..(z * self.s[2] + row + self.n[0]) {
                    let sum: f64 = (0..3).map(|a| self.k[a][i] + self.k[a][i + self.s[a]]).sum();
                    self.inverse[i] = if sum > 0.0 { 1.0 / sum } else { 0.0 };
                }
            }
        }
    }

    /// `each(cell in the plane, A x there, cell)` along the rows of plane `z`.
    #[inline]
    fn applied(&self, x: &[f64], z: usize, mut each: impl FnMut(usize, f64, usize)) {
        let [_, sy, sz] = self.s;
        for row in self.rows(z) {
            let (first, n) = (z * sz + row, self.n[0]);
            let x0 = &x[first..first + n];
            let (west, east) = (&x[first - 1..first - 1 + n], &x[first + 1..first + 1 + n]);
            let (south, north) = (&x[first - sy..first - sy + n], &x[first + sy..first + sy + n]);
            let (down, up) = (&x[first - sz..first - sz + n], &x[first + sz..first + sz + n]);
            let (kw, ke) = (&self.k[0][first..first + n], &self.k[0][first + 1..first + 1 + n]);
            let (ks, kn) = (&self.k[1][first..first + n], &self.k[1][first + sy..first + sy + n]);
            let (kd, ku) = (&self.k[2][first..first + n], &self.k[2][first + sz..first + sz + n]);
            for i in 0..n {
                let c = x0[i];
                let a = kw[i] * (c - west[i])
                    + ke[i] * (c - east[i])
                    + ks[i] * (c - south[i])
                    + kn[i] * (c - north[i])
                    + kd[i] * (c - down[i])
                    + ku[i] * (c - up[i]);
                each(row + i, a, first + i);
            }
        }
    }

    /// One sweep of that length for `b` on its own unknowns.
    fn sweep(&mut self, length: f64, parallel: bool) {
        let mut other = std::mem::take(&mut self.other);
        for_chunks(parallel, &mut other, self.s[2], &|z, plane| {
            self.applied(&self.x, z, |at, a, i| plane[at] = self.x[i] + length * self.inverse[i] * (self.b[i] - a));
        });
        self.other = std::mem::replace(&mut self.x, other);
    }

    /// What is left of `b`, into `other`.
    fn residual(&mut self, parallel: bool) {
        let mut other = std::mem::take(&mut self.other);
        for_chunks(parallel, &mut other, self.s[2], &|z, plane| {
            self.applied(&self.x, z, |at, a, i| plane[at] = self.b[i] - a);
        });
        self.other = other;
    }

    /// `out = A x`.
    fn apply(&self, x: &[f64], out: &mut [f64], parallel: bool) {
        for_chunks(parallel, out, self.s[2], &|z, plane| self.applied(x, z, |at, a, _| plane[at] = a));
    }

    /// Sum over the cells of a product, plane by plane.
    fn product(&self, a: &[f64], b: &[f64]) -> f64 {
        let plane = |z: usize| {
            self.rows(z).map(move |row| {
                let first = z * self.s[2] + row;
                let (a, b) = (&a[first..first + self.n[0]], &b[first..first + self.n[0]]);
                // Four sums at a time: a fixed order, and one that the processor can keep up with.
                let mut sums = [0.0; 4];
                for (a, b) in a.chunks(4).zip(b.chunks(4)) {
                    for (sum, (a, b)) in sums.iter_mut().zip(a.iter().zip(b)) {
                        *sum += a * b;
                    }
                }
                sums.iter().sum::<f64>()
            })
        };
        (1..=self.n[2]).flat_map(plane).sum()
    }
}

/// How a solution went.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Solved {
    /// Iterations.
    pub(crate) iterations: u64,
    /// Largest residual left.
    pub(crate) left: f64,
}

/// All levels, the finest first, and the vectors of conjugate gradients.
#[derive(Clone, Debug, Default)]
pub(crate) struct Multigrid {
    levels: Vec<Level>,
    r: Vec<f64>,
    p: Vec<f64>,
    ap: Vec<f64>,
}

impl Multigrid {
    /// For that many cells.
    pub(crate) fn new(n: [usize; 3]) -> Self {
        let (mut levels, mut now) = (vec![Level::new(n)], n);
        while now.iter().all(|n| n % 2 == 0) && now.iter().product::<usize>() > FEW {
            now = now.map(|n| n / 2);
            levels.push(Level::new(now));
        }
        let none = vec![0.0; levels[0].size()];
        Self { levels, r: none.clone(), p: none.clone(), ap: none }
    }

    /// Spoils the vectors that must not be read before they are written.
    #[cfg(test)]
    pub(crate) fn spoil(&mut self, value: f64) {
        self.p.fill(value);
        for z in 1..=self.levels[0].n[2] {
            for row in self.levels[0].rows(z).collect::<Vec<_>>() {
                let first = z * self.levels[0].s[2] + row;
                let end = first + self.levels[0].n[0];
                let Level { x, b, other, .. } = &mut self.levels[0];
                for all in [x, b, other, &mut self.ap, &mut self.r] {
                    all[first..end].fill(value);
                }
            }
        }
    }

    /// The finest level, to set its weights.
    pub(crate) fn finest(&mut self) -> &mut Level {
        &mut self.levels[0]
    }

    /// Takes the weights of the finest level.
    pub(crate) fn prepare(&mut self) {
        for l in 1..self.levels.len() {
            let (fine, coarse) = self.levels.split_at_mut(l);
            let (fine, coarse) = (&fine[l - 1], &mut coarse[0]);
            for a in 0..3 {
                let [b, c] = [(a + 1) % 3, (a + 2) % 3];
                let mut last = coarse.n.map(|n| n as isize);
                last[a] += 1;
                for z in 0..last[2] {
                    for y in 0..last[1] {
                        for x in 0..last[0] {
                            let at = fine.at([2 * x, 2 * y, 2 * z]);
                            let four = [0, fine.s[b], fine.s[c], fine.s[b] + fine.s[c]];
                            let sum: f64 = four.iter().map(|s| fine.k[a][at + s]).sum();
                            let to = coarse.at([x, y, z]);
                            coarse.k[a][to] = 0.5 * sum;
                        }
                    }
                }
            }
        }
        self.levels.iter_mut().for_each(Level::invert);
    }

    /// Solves for `b` from a guess `q`, both on the finest level, until no residual is larger than `limit`.
    ///
    /// Without an open side `q` has no level of its own: every `b` then adds up to zero, and so does each residual.
    pub(crate) fn solve(&mut self, q: &mut [f64], b: &[f64], limit: f64, most: u64, parallel: bool) -> Solved {
        let mut solved = Solved::default();
        let fine = &self.levels[0];
        fine.apply(q, &mut self.ap, parallel);
        for (r, (b, ap)) in self.r.iter_mut().zip(b.iter().zip(&self.ap)) {
            *r = b - ap;
        }
        let mut old = 0.0;
        loop {
            solved.left = self.r.iter().fold(0.0, |m, r| if r.is_nan() || r.abs() > m { r.abs() } else { m });
            if solved.left <= limit || solved.iterations >= most || solved.left.is_nan() {
                return solved;
            }
            self.levels[0].b.copy_from_slice(&self.r);
            cycle(&mut self.levels, parallel);
            let fine = &self.levels[0];
            let now = fine.product(&self.r, &fine.x);
            let beta = now / old;
            for (p, z) in self.p.iter_mut().zip(&fine.x) {
                *p = if solved.iterations == 0 { *z } else { z + beta * *p };
            }
            old = now;
            fine.apply(&self.p, &mut self.ap, parallel);
            let steep = fine.product(&self.p, &self.ap);
            if steep <= 0.0 {
                // Nothing is left but a constant, which no equation sees.
                return solved;
            }
            let length = now / steep;
            for ((q, r), (p, ap)) in q.iter_mut().zip(&mut self.r).zip(self.p.iter().zip(&self.ap)) {
                *q += length * p;
                *r -= length * ap;
            }
            solved.iterations += 1;
        }
    }
}

/// One V-cycle for the first level's `b`, from nothing, into its `x`.
fn cycle(levels: &mut [Level], parallel: bool) {
    let Some((fine, coarser)) = levels.split_first_mut() else { return };
    let parallel = parallel && fine.size() > 8000;
    for ((x, b), inverse) in fine.x.iter_mut().zip(&fine.b).zip(&fine.inverse) {
        *x = SWEEPS[0] * inverse * b;
    }
    fine.sweep(SWEEPS[1], parallel);
    if let Some(coarse) = coarser.first_mut() {
        fine.residual(parallel);
        let [_, fy, fz] = fine.s;
        let eight = [0, 1, fy, fy + 1, fz, fz + 1, fz + fy, fz + fy + 1];
        let (n, [_, sy, sz]) = (coarse.n, coarse.s);
        let rows = move || (1..=n[2]).flat_map(move |z| (1..=n[1]).map(move |y| (z, y)));
        for (z, y) in rows() {
            for x in 1..=n[0] {
                let at = (2 * z - 1) * fz + (2 * y - 1) * fy + 2 * x - 1;
                coarse.b[z * sz + y * sy + x] = eight.iter().map(|s| fine.other[at + s]).sum();
            }
        }
        cycle(coarser, parallel);
        let coarse = &coarser[0];
        for (z, y) in rows() {
            for x in 1..=n[0] {
                let at = (2 * z - 1) * fz + (2 * y - 1) * fy + 2 * x - 1;
                let value = coarse.x[z * sz + y * sy + x];
                for s in eight {
                    fine.x[at + s] += value;
                }
            }
        }
    } else {
        for _ in 0..COARSEST {
            fine.sweep(SWEEPS[0], parallel);
            fine.sweep(SWEEPS[1], parallel);
        }
    }
    fine.sweep(SWEEPS[1], parallel);
    fine.sweep(SWEEPS[0], parallel);
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A box of weights 1 with a block of small ones, open or closed above.
    fn boxed(n: [usize; 3], open: bool) -> Multigrid {
        let mut all = Multigrid::new(n);
        let fine = all.finest();
        for a in 0..3 {
            let mut last = n.map(|n| n as isize);
            last[a] += 1;
            for z in 0..last[2] {
                for y in 0..last[1] {
                    for x in 0..last[0] {
                        let c = [x, y, z];
                        let inside = c[a] > 0 && c[a] < n[a] as isize;
                        let solid = c.iter().all(|c| (5..11).contains(c));
                        let i = fine.at(c);
                        let weight = if solid { 1e-4 } else { 1.0 };
                        let top = open && a == 2 && z == n[2] as isize;
                        fine.k[a][i] = if inside || top { weight } else { 0.0 };
                    }
                }
            }
        }
        all.prepare();
        all
    }

    #[test]
    fn what_is_solved_satisfies_the_equation() {
        for (n, open) in [([16, 16, 16], true), ([16, 24, 16], false), ([32, 32, 32], true)] {
            let mut all = boxed(n, open);
            let size = all.levels[0].size();
            let mut exact = vec![0.0; size];
            let level = &all.levels[0];
            for z in 0..n[2] as isize {
                for y in 0..n[1] as isize {
                    for x in 0..n[0] as isize {
                        exact[level.at([x, y, z])] = ((3 * x + 5 * y * y + 7 * z) as f64).sin();
                    }
                }
            }
            let mut b = vec![0.0; size];
            level.apply(&exact, &mut b, false);
            let mut q = vec![0.0; size];
            let solved = all.solve(&mut q, &b, 1e-9, 60, false);
            println!("{n:?} open {open}: {solved:?}");
            assert!(solved.left <= 1e-9);
            // Nine digits from a rough start; measured 13 to 20.
            assert!(solved.iterations < 30, "{solved:?}");
            let mut back = vec![0.0; size];
            all.levels[0].apply(&q, &mut back, false);
            let off = back.iter().zip(&b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            // The recursion's residual and the true one part by roundings, amplified by ten thousand.
            assert!(off < 1e-8, "{off}");
        }
    }
}
