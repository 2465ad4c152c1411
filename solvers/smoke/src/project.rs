//! The projection: the pressure that leaves no divergence, with solids as heavy faces (see `solids`).

use cosplat_core::boundary::{Vec3, Wrench, cross};

use crate::grid::{Faces, Grid, for_chunks};
use crate::multigrid::{Multigrid, Solved};
use crate::sides::{Side, Sides, free};

/// Sets `out` on the free faces of component `a` to what `value(number)` says.
pub(crate) fn set_free(
    grid: &Grid,
    sides: Sides,
    a: usize,
    out: &mut [f64],
    parallel: bool,
    value: &(impl Fn(usize) -> f64 + Sync),
) {
    let mut range = grid.n.map(|n| [2, n + 1]);
    range[a] = free(grid, sides, a).map(|i| (i + 2) as usize);
    for_chunks(parallel, out, grid.s[2], &|plane, out| {
        if !(range[2][0]..=range[2][1]).contains(&plane) {
            return;
        }
        for y in range[1][0]..=range[1][1] {
            for x in range[0][0]..=range[0][1] {
                let at = y * grid.s[1] + x;
                out[at] = value(plane * grid.s[2] + at);
            }
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
        let level = multigrid.finest();
        for a in 0..3 {
            level.k[a].fill(0.0);
            crate::flux::visit(self.grid, self.sides, a, |cell, at| {
                let i = level.at(cell);
                level.k[a][i] = 1.0 / (1.0 + self.ratio[a][at]);
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
            let before = u[a].clone();
            set_free(grid, sides, a, &mut u[a], parallel, &|at| (before[at] + pull[at]) / (1.0 + ratio[at]));
            if let Some(slack) = &mut slack {
                slack[a] = before;
            }
        }
        let mut speed = 0.0_f64;
        b.fill(0.0);
        for z in 0..grid.n[2] as isize {
            for y in 0..grid.n[1] as isize {
                let (first, to) = (grid.at([0, y, z]), lower(grid, grid.at([0, y, z])));
                for x in 0..grid.n[0] {
                    let at = first + x;
                    let ends = [0, 1, 2].map(|a| [u[a][at], u[a][at + grid.s[a]]]);
                    speed = ends.iter().flatten().fold(speed, |m, v| m.max(v.abs()));
                    b[to + x] = ends.iter().map(|[low, high]| low - high).sum();
                }
            }
        }
        let limit = tolerance * speed;
        let solved = multigrid.solve(q, b, limit, self.most, parallel);
        for a in 0..3 {
            let ratio = &self.ratio[a];
            let before = u[a].clone();
            let q = &*q;
            set_free(grid, sides, a, &mut u[a], parallel, &|at| {
                let i = lower(grid, at);
                before[at] - (q[i] - q[i - steps[a]]) / (1.0 + ratio[at])
            });
            if let Some(slack) = &mut slack {
                let (star, u, pull) = (slack[a].clone(), &u[a], &self.pull[a]);
                set_free(grid, sides, a, &mut slack[a], parallel, &|at| {
                    let i = lower(grid, at);
                    let gain = u[at] - star[at] + (q[i] - q[i - steps[a]]);
                    if ratio[at] > 0.0 { (gain - (pull[at] - ratio[at] * u[at])) / ratio[at] } else { 0.0 }
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
