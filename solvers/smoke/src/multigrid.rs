//! Poisson's equation for the pressure (`matrix`), in double precision: conjugate gradients, preconditioned by one
//! V-cycle of multigrid (`cycle`).
//!
//! `k` is 0 at closed sides, and outside of open ones the unknown is 0. All passes go plane by plane; what is summed is
//! summed in a plane and then over the planes, in a fixed order.

use crate::cycle::{Level, cycle};
use crate::grid::{for_chunks, map_chunks, map_planes};
use crate::matrix::{Matrix, dot};

/// Cells below which a level is not made coarser.
const FEW: usize = 64;

/// How a solution went.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Solved {
    /// Iterations.
    pub(crate) iterations: u64,
    /// Largest residual left.
    pub(crate) left: f64,
}

/// The equation, all levels of the cycle, the finest first, and the vectors of conjugate gradients.
#[derive(Clone, Debug, Default)]
pub(crate) struct Multigrid {
    pub(crate) matrix: Matrix<f64>,
    levels: Vec<Level>,
    r: Vec<f64>,
    p: Vec<f64>,
    ap: Vec<f64>,
}

/// The larger of two sizes; what is no number stays one.
fn larger(most: f64, v: f64) -> f64 {
    if v.is_nan() || v > most { v } else { most }
}

impl Multigrid {
    /// For that many cells.
    pub(crate) fn new(n: [usize; 3]) -> Self {
        let (mut levels, mut now) = (vec![Level::new(n)], n);
        while now.iter().all(|n| n % 2 == 0) && now.iter().product::<usize>() > FEW {
            now = now.map(|n| n / 2);
            levels.push(Level::new(now));
        }
        let matrix = Matrix::new(n);
        let none = vec![0.0; matrix.size()];
        Self { matrix, levels, r: none.clone(), p: none.clone(), ap: none }
    }

    /// Spoils the vectors that must not be read before they are written.
    #[cfg(test)]
    pub(crate) fn spoil(&mut self, value: f64) {
        self.levels.iter_mut().for_each(|level| level.spoil(value));
        let m = &self.matrix;
        for first in (1..=m.n[2]).flat_map(|z| m.rows(z).map(move |row| z * m.s[2] + row)) {
            for all in [&mut self.p, &mut self.ap, &mut self.r] {
                all[first..first + m.n[0]].fill(value);
            }
        }
    }

    /// Takes over the weights of the equation.
    pub(crate) fn prepare(&mut self) {
        let Some((finest, coarser)) = self.levels.split_first_mut() else { return };
        for (to, from) in finest.matrix.k.iter_mut().zip(&self.matrix.k) {
            to.iter_mut().zip(from).for_each(|(to, from)| *to = *from as f32);
        }
        finest.invert();
        let mut fine = &*finest;
        for coarse in coarser {
            coarse.coarsen(&fine.matrix);
            coarse.invert();
            fine = coarse;
        }
    }

    /// `r = b - A q`; the largest of it.
    fn start(&mut self, q: &[f64], b: &[f64], parallel: bool) -> f64 {
        let m = &self.matrix;
        let most = map_chunks(parallel, &mut self.r, m.s[2], &|z, plane| {
            let mut most = 0.0;
            for row in m.rows(z) {
                let first = z * m.s[2] + row;
                let out = &mut plane[row..row + m.n[0]];
                m.row(q, first, out);
                for (r, b) in out.iter_mut().zip(&b[first..]) {
                    *r = b - *r;
                    most = larger(most, r.abs());
                }
            }
            most
        });
        most.into_iter().fold(0.0, larger)
    }

    /// Runs the cycle for `r` as parts of `size`, the largest of it; `r` times its result, which is `size` times what
    /// the finest level holds then.
    fn guide(&mut self, size: f64, parallel: bool) -> f64 {
        let (m, r, by) = (&self.matrix, &self.r, 1.0 / size);
        let Some(finest) = self.levels.first_mut() else { return 0.0 };
        for_chunks(parallel, &mut finest.b, m.s[2], &|z, plane| {
            for row in m.rows(z) {
                let from = &r[z * m.s[2] + row..];
                plane[row..row + m.n[0]].iter_mut().zip(from).for_each(|(b, r)| *b = (by * r) as f32);
            }
        });
        cycle(&mut self.levels, parallel);
        let guided = &self.levels[0].x;
        let sums = map_planes(parallel, m.n[2] + 2, &|z| {
            let parts = m.rows(z).map(|row| z * m.s[2] + row..z * m.s[2] + row + m.n[0]);
            parts.map(|part| dot(&r[part.clone()], &guided[part])).sum()
        });
        size * sums.iter().sum::<f64>()
    }

    /// `p = size z + beta p`, with the cycle's result z.
    fn turn(&mut self, size: f64, beta: f64, parallel: bool) {
        let (m, guided) = (&self.matrix, &self.levels[0].x);
        for_chunks(parallel, &mut self.p, m.s[2], &|z, plane| {
            for row in m.rows(z) {
                let first = z * m.s[2] + row;
                for (p, guided) in plane[row..row + m.n[0]].iter_mut().zip(&guided[first..]) {
                    let old = if beta == 0.0 { 0.0 } else { beta * *p };
                    *p = size * f64::from(*guided) + old;
                }
            }
        });
    }

    /// `ap = A p`; `p` times it.
    fn apply_to_p(&mut self, parallel: bool) -> f64 {
        let (m, p) = (&self.matrix, &self.p);
        let sums = map_chunks(parallel, &mut self.ap, m.s[2], &|z, plane| {
            let mut sum = 0.0;
            for row in m.rows(z) {
                let first = z * m.s[2] + row;
                let out = &mut plane[row..row + m.n[0]];
                m.row(p, first, out);
                sum += dot(out, &p[first..first + m.n[0]]);
            }
            sum
        });
        sums.iter().sum()
    }

    /// Goes along `p` by that length; the largest residual then.
    fn go(&mut self, q: &mut [f64], length: f64, parallel: bool) -> f64 {
        let Self { matrix: m, r, p, ap, .. } = self;
        let (p, ap) = (&*p, &*ap);
        for_chunks(parallel, q, m.s[2], &|z, plane| {
            for row in m.rows(z) {
                let from = &p[z * m.s[2] + row..];
                plane[row..row + m.n[0]].iter_mut().zip(from).for_each(|(q, p)| *q += length * p);
            }
        });
        let most = map_chunks(parallel, r, m.s[2], &|z, plane| {
            let mut most = 0.0;
            for row in m.rows(z) {
                for (r, ap) in plane[row..row + m.n[0]].iter_mut().zip(&ap[z * m.s[2] + row..]) {
                    *r -= length * ap;
                    most = larger(most, r.abs());
                }
            }
            most
        });
        most.into_iter().fold(0.0, larger)
    }

    /// Solves for `b` from a guess `q`, until no residual is larger than `limit`.
    ///
    /// Without an open side `q` has no level of its own: every `b` then adds up to zero, and so does each residual.
    pub(crate) fn solve(&mut self, q: &mut [f64], b: &[f64], limit: f64, most: u64, parallel: bool) -> Solved {
        let mut solved = Solved { iterations: 0, left: self.start(q, b, parallel) };
        let mut old = 0.0;
        while solved.left > limit && solved.left.is_finite() && solved.iterations < most {
            let now = self.guide(solved.left, parallel);
            let beta = if solved.iterations == 0 { 0.0 } else { now / old };
            self.turn(solved.left, beta, parallel);
            old = now;
            let steep = self.apply_to_p(parallel);
            if steep <= 0.0 {
                // Nothing is left but a constant, which no equation sees.
                return solved;
            }
            solved.left = self.go(q, now / steep, parallel);
            solved.iterations += 1;
        }
        solved
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A box of weights 1 with a block of small ones, open or closed above.
    fn boxed(n: [usize; 3], open: bool) -> Multigrid {
        let mut all = Multigrid::new(n);
        let fine = &mut all.matrix;
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
            let size = all.matrix.size();
            let mut exact = vec![0.0; size];
            let level = all.matrix.clone();
            let level = &level;
            for z in 0..n[2] as isize {
                for y in 0..n[1] as isize {
                    for x in 0..n[0] as isize {
                        exact[level.at([x, y, z])] = ((3 * x + 5 * y * y + 7 * z) as f64).sin();
                    }
                }
            }
            let left = |q: &[f64]| -> Vec<f64> {
                let inside = |z: usize| level.rows(z).map(move |row| z * level.s[2] + row);
                let mut out = vec![0.0; size];
                for first in (1..=n[2]).flat_map(inside) {
                    level.row(q, first, &mut out[first..first + n[0]]);
                }
                out
            };
            let b = left(&exact);
            let mut q = vec![0.0; size];
            let solved = all.solve(&mut q, &b, 1e-9, 60, false);
            println!("{n:?} open {open}: {solved:?}");
            assert!(solved.left <= 1e-9);
            // Nine digits from a rough start; measured 13 to 20.
            assert!(solved.iterations < 30, "{solved:?}");
            let back = left(&q);
            let off = back.iter().zip(&b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            // The recursion's residual and the true one part by roundings, amplified by ten thousand.
            assert!(off < 1e-8, "{off}");
        }
    }
}
