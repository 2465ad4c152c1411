//! The projection: the pressure that leaves no divergence, with solids as heavy faces (see `solids`).

use cosplat_core::boundary::{Vec3, Wrench, cross};

use crate::grid::{Faces, Grid, for_chunks, map_chunks};
use crate::multigrid::{Multigrid, Solved};
use crate::sides::{Side, Sides, free};

/// Calls `each(number, number on the pressure's level, row)` for the rows of free faces of component `a` in `out`.
pub(crate) fn for_free(
    grid: &Grid,
    sides: Sides,
    a: usize,
    out: &mut [f64],
    parallel: bool,
    each: &(impl Fn(usize, usize, &mut [f64]) + Sync),
) {
    let mut range = grid.n.map(|n| [2, n + 1]);
    range[a] = free(grid, sides, a).map(|i| (i + 2) as usize);
    for_chunks(parallel, out, grid.s[2], &|plane, out| {
        if !(range[2][0]..=range[2][1]).contains(&plane) {
            return;
        }
        for row in (range[1][0]..=range[1][1]).map(|y| y * grid.s[1] + range[0][0]) {
            let at = plane * grid.s[2] + row;
            each(at, lower(grid, at), &mut out[row..=row + range[0][1] - range[0][0]]);
        }
    });
}

/// Number on the pressure's finest level of the cell at number `at` of the grid.
///
/// The level is padded by one cell below and one above, the grid by two and three.
#[inline]
pub(crate) fn lower(grid: &Grid, at: usize) -> usize {
    let [x, y, z] = [at % grid.s[1], at % grid.s[2] / grid.s[1], at / grid.s[2]];
    let row = grid.n[0] + 2;
    (x - 1) + (y - 1) * row + (z - 1) * row * (grid.n[1] + 2)
}

/// What a projection is made of.
pub(crate) struct Projection<'a> {
    pub(crate) grid: &'a Grid,
    pub(crate) sides: Sides,
    /// Mass of solids over that of the gas, and its product with their velocity \[m/s\].
    pub(crate) ratio: &'a Faces,
    pub(crate) pull: &'a Faces,
    /// Most iterations.
    pub(crate) most: u64,
    pub(crate) parallel: bool,
}

impl Projection<'_> {
    /// Sets the weights of faces; once for all solutions with the same solids.
    pub(crate) fn prepare(&self, multigrid: &mut Multigrid) {
        let matrix = &mut multigrid.matrix;
        for a in 0..3 {
            matrix.k[a].fill(0.0);
            crate::flux::visit(self.grid, self.sides, a, |cell, at| {
                let i = matrix.at(cell);
                matrix.k[a][i] = 1.0 / (1.0 + self.ratio[a][at]);
            });
        }
        multigrid.prepare();
    }

    /// Takes the divergence out of `u`, whose faces at walls and inlets are set; `q` is a guess of the pressure, in
    /// m/s, and becomes it. Up to `tolerance`: the largest divergence of a cell, times its edge, over the largest
    /// speed. Says how it went and the limit that it had.
    ///
    /// `slack` becomes, on faces of solids, what rounding leaves between the gas's gain and the solids' loss, over
    /// their mass: the loss is a small difference times a large mass.
    pub(crate) fn solve(
        &self,
        tolerance: f64,
        u: &mut Faces,
        q: &mut [f64],
        b: &mut [f64],
        multigrid: &mut Multigrid,
        mut slack: Option<&mut Faces>,
    ) -> (Solved, f64) {
        let (grid, sides, parallel) = (self.grid, self.sides, self.parallel);
        let steps = [1, grid.n[0] + 2, (grid.n[0] + 2) * (grid.n[1] + 2)];
        for a in 0..3 {
            let (ratio, pull) = (&self.ratio[a], &self.pull[a]);
            if let Some(slack) = &mut slack {
                slack[a].clone_from(&u[a]);
            }
            for_free(grid, sides, a, &mut u[a], parallel, &|at, _, row| {
                let (pull, ratio) = (&pull[at..at + row.len()], &ratio[at..at + row.len()]);
                for ((u, pull), ratio) in row.iter_mut().zip(pull).zip(ratio) {
                    *u = (*u + pull) / (1.0 + ratio);
                }
            });
        }
        let fastest = map_chunks(parallel, b, steps[2], &|plane, b| {
            b.fill(0.0);
            let mut speed = 0.0_f64;
            for y in (0..grid.n[1]).filter(|_| (1..=grid.n[2]).contains(&plane)) {
                let first = (plane + 1) * grid.s[2] + (y + 2) * grid.s[1] + 2;
                let ends = [0, 1, 2].map(|a| [0, grid.s[a]].map(|s| &u[a][first + s..first + s + grid.n[0]]));
                let row = (y + 1) * steps[1] + 1;
                for (i, b) in b[row..row + grid.n[0]].iter_mut().enumerate() {
                    let ends = ends.map(|e| e.map(|u| u[i]));
                    speed = ends.iter().flatten().fold(speed, |m, v| if v.abs() > m { v.abs() } else { m });
                    *b = ends.iter().map(|[low, high]| low - high).sum();
                }
            }
            speed
        });
        let limit = tolerance * fastest.into_iter().fold(0.0, f64::max);
        let solved = multigrid.solve(q, b, limit, self.most, parallel);
        for a in 0..3 {
            let ratio = &self.ratio[a];
            let q = &*q;
            for_free(grid, sides, a, &mut u[a], parallel, &|at, low, row| {
                let len = row.len();
                let (below, q) = (&q[low - steps[a]..low - steps[a] + len], &q[low..low + len]);
                for (((u, q), below), ratio) in row.iter_mut().zip(q).zip(below).zip(&ratio[at..at + len]) {
                    *u -= (q - below) / (1.0 + ratio);
                }
            });
            if let Some(slack) = &mut slack {
                let (u, pull) = (&u[a], &self.pull[a]);
                for_free(grid, sides, a, &mut slack[a], parallel, &|at, low, row| {
                    for (i, slack) in row.iter_mut().enumerate() {
                        let (ratio, u, pull) = (ratio[at + i], u[at + i], pull[at + i]);
                        let gain = u - *slack + (q[low + i] - q[low + i - steps[a]]);
                        *slack = if ratio > 0.0 { (gain - (pull - ratio * u)) / ratio } else { 0.0 };
                    }
                });
            }
        }
        (solved, limit)
    }

    /// Impulse of walls and inlets on the gas by the pressure, about the origin, per mass of a cell \[m/s, m²/s\].
    pub(crate) fn of_walls(&self, q: &[f64]) -> Wrench {
        let mut sum = Wrench::default();
        let grid = self.grid;
        for a in 0..3 {
            let [p, r] = [(a + 1) % 3, (a + 2) % 3];
            for (end, way) in [(0, 1.0), (1, -1.0)] {
                if self.sides[a][end] == Side::Open {
                    continue;
                }
                for j in 0..grid.n[r] as isize {
                    for i in 0..grid.n[p] as isize {
                        let mut cell = [0; 3];
                        (cell[p], cell[r]) = (i, j);
                        cell[a] = if end == 0 { 0 } else { grid.n[a] as isize - 1 };
                        let mut j: Vec3 = [0.0; 3];
                        j[a] = way * q[lower(grid, grid.at(cell))];
                        sum = sum.plus(Wrench { linear: j, angular: cross(grid.face(a, cell), j) });
                    }
                }
            }
        }
        sum
    }
}
