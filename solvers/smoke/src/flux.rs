//! Momentum that crosses the faces of cells: convection and viscosity, as a symmetric tensor.
//!
//! `T_ab` is in the middle of a cell for a = b, and at its lower edge otherwise. It leaves the two faces of component
//! `a` along `b` with opposite signs, and those of component `b` along `a`: with `T_ab = T_ba` linear and angular
//! momentum are both kept to rounding.
//!
//! - Convection is the product of mean velocities (Harlow and Welch 1965): second order, and it keeps kinetic energy.
//! - `-½ (|u_b| δ_b u_a + |u_a| δ_a u_b)`, with `δ u = (u_0 - 3 u_1 + 3 u_2 - u_3)/6`, the jump between the values that
//!   parabolas from both sides give, takes out what the grid cannot carry. For a velocity without divergence it takes
//!   out of each Fourier mode exactly what third-order upwind differences take, though those are not symmetric; it is
//!   of third order.
//! - `-ν (∂_b u_a + ∂_a u_b)`.

use cosplat_core::boundary::{Vec3, Wrench, add, cross};

use crate::grid::{Faces, Grid, PAD, for_chunks};
use crate::sides::{Sides, free};

/// The tensor \[m²/s²\]: xx, yy, zz, then xy, yz, zx.
pub(crate) type Tensor = [Vec<f64>; 6];

/// Axes of each entry.
const AXES: [[usize; 2]; 6] = [[0, 0], [1, 1], [2, 2], [0, 1], [1, 2], [2, 0]];

/// Jump at the middle of four values in a row, a sixth of their third difference.
#[inline]
fn jump(u: [&[f64]; 4], i: usize) -> f64 {
    (u[0][i] - u[3][i] + 3.0 * (u[2][i] - u[1][i])) / 6.0
}

/// Rows of `len` numbers of `u` from number `at` on, moved by so many times `s`.
#[inline]
fn rows(u: &[f64], at: usize, len: usize, s: usize, by: [isize; 4]) -> [&[f64]; 4] {
    by.map(|k| {
        let from = at.wrapping_add_signed(k * s as isize);
        &u[from..from + len]
    })
}

/// Adds `share` of the tensor of `u` \[m/s\] at viscosity `nu` \[m²/s\] to `t`.
pub(crate) fn add_tensor(grid: &Grid, u: &Faces, nu: f64, share: f64, t: &mut Tensor, parallel: bool) {
    let rub = nu / grid.h;
    let n = grid.n;
    for (t, [a, b]) in t.iter_mut().zip(AXES) {
        let (sa, sb) = (grid.s[a], grid.s[b]);
        for_chunks(parallel, t, grid.s[2], &|plane, t| {
            // Middles of cells are needed from one beyond each side, edges from the side on.
            let least = if a == b { 1 } else { PAD };
            if plane < least || plane > n[2] + PAD {
                return;
            }
            let len = n[0] + PAD + 1 - least;
            for first in (least..=n[1] + PAD).map(|y| y * grid.s[1] + least) {
                let (at, t) = (plane * grid.s[2] + first, &mut t[first..first + len]);
                if a == b {
                    let u = rows(&u[a], at, len, sa, [-1, 0, 1, 2]);
                    for (i, t) in t.iter_mut().enumerate() {
                        let mean = 0.5 * (u[1][i] + u[2][i]);
                        let flux = mean * mean - mean.abs() * jump(u, i) - 2.0 * rub * (u[2][i] - u[1][i]);
                        *t += share * flux;
                    }
                    continue;
                }
                let around = [-2, -1, 0, 1];
                let (ua, ub) = (rows(&u[a], at, len, sb, around), rows(&u[b], at, len, sa, around));
                for (i, t) in t.iter_mut().enumerate() {
                    let (of_a, of_b) = (0.5 * (ua[1][i] + ua[2][i]), 0.5 * (ub[1][i] + ub[2][i]));
                    let jumps = of_b.abs() * jump(ua, i) + of_a.abs() * jump(ub, i);
                    let rubbed = rub * (ua[2][i] - ua[1][i] + ub[2][i] - ub[1][i]);
                    *t += share * (of_a * of_b - 0.5 * jumps - rubbed);
                }
            }
        });
    }
}

/// Acceleration by the tensor of the faces of component `a` from number `at` on, into `out` \[m/s²\].
pub(crate) fn acceleration(grid: &Grid, t: &Tensor, a: usize, at: usize, out: &mut [f64]) {
    let [b, c] = [(a + 1) % 3, (a + 2) % 3];
    let (len, by) = (out.len(), 1.0 / grid.h);
    // Entries 3, 4, 5 hold the pairs (0, 1), (1, 2), (2, 0).
    let (ab, ca) = (&t[3 + a], &t[3 + c]);
    let (low, high) = (&t[a][at - grid.s[a]..][..len], &t[a][at..][..len]);
    let (low_b, high_b) = (&ab[at..][..len], &ab[at + grid.s[b]..][..len]);
    let (low_c, high_c) = (&ca[at..][..len], &ca[at + grid.s[c]..][..len]);
    for (i, out) in out.iter_mut().enumerate() {
        *out = by * (low[i] - high[i] + (low_b[i] - high_b[i]) + (low_c[i] - high_c[i]));
    }
}

/// Visits the free faces of component `a`, row by row: `each(cell, number)`.
pub(crate) fn visit(grid: &Grid, sides: Sides, a: usize, mut each: impl FnMut([isize; 3], usize)) {
    let mut range = grid.n.map(|n| [0, n as isize - 1]);
    range[a] = free(grid, sides, a);
    for z in range[2][0]..=range[2][1] {
        for y in range[1][0]..=range[1][1] {
            for x in range[0][0]..=range[0][1] {
                each([x, y, z], grid.at([x, y, z]));
            }
        }
    }
}

/// Force of what is beyond the sides on the free faces, and its moment about the origin, per density and area
/// \[m²/s²\].
///
/// Between free faces all entries cancel, so only those at the sides are summed.
pub(crate) fn across_sides(grid: &Grid, sides: Sides, t: &Tensor) -> Wrench {
    let mut sum = Wrench::default();
    let all = grid.n.map(|n| n as isize);
    let is_free = |a: usize, c: [isize; 3]| {
        let [first, last] = free(grid, sides, a);
        (0..3).all(|k| if k == a { (first..=last).contains(&c[k]) } else { (0..all[k]).contains(&c[k]) })
    };
    let mut push = |a: usize, c: [isize; 3], force: f64| {
        if is_free(a, c) {
            let mut along = [0.0; 3];
            along[a] = force;
            sum = sum.plus(Wrench { linear: along, angular: cross(grid.face(a, c), along) });
        }
    };
    for (t, [a, b]) in t.iter().zip(AXES) {
        let others = |k: usize| 0..all[k];
        if a == b {
            let [first, last] = free(grid, sides, a);
            let [p, q] = [(a + 1) % 3, (a + 2) % 3];
            for j in others(q) {
                for i in others(p) {
                    let mut cell = [0; 3];
                    (cell[p], cell[q]) = (i, j);
                    cell[a] = first - 1;
                    let value = t[grid.at(cell)];
                    cell[a] = first;
                    push(a, cell, value);
                    cell[a] = last;
                    push(a, cell, -t[grid.at(cell)]);
                }
            }
            continue;
        }
        let c = 3 - a - b;
        for k in others(c) {
            for j in 0..=all[b] {
                let ends = [0, all[a]];
                let whole = j == 0 || j == all[b];
                let range = (0..=all[a]).filter(|i| whole || ends.contains(i));
                for i in range {
                    let mut edge = [0; 3];
                    (edge[a], edge[b], edge[c]) = (i, j, k);
                    let value = t[grid.at(edge)];
                    let below = |axis: usize| {
                        let mut cell = edge;
                        cell[axis] -= 1;
                        cell
                    };
                    push(a, edge, value);
                    push(a, below(b), -value);
                    push(b, edge, value);
                    push(b, below(a), -value);
                }
            }
        }
    }
    sum
}

/// What a row of values adds: their sum along component `a` with its moment about the origin, the sum of sizes and that
/// of squares.
fn row_sums(grid: &Grid, a: usize, cell: [isize; 3], values: &[f64]) -> (Wrench, f64, f64) {
    let first = grid.face(a, cell);
    let (mut sum, mut steps, mut gross, mut squares) = ([0.0; 4], [0.0; 4], [0.0; 4], [0.0; 4]);
    for (base, four) in (0..).step_by(4).zip(values.chunks(4)) {
        for (lane, v) in four.iter().enumerate() {
            sum[lane] += v;
            steps[lane] += v * f64::from(base + lane as i32);
            gross[lane] += v.abs();
            squares[lane] += v * v;
        }
    }
    let [sum, steps, gross, squares] = [sum, steps, gross, squares].map(|four| four.iter().sum::<f64>());
    let mut linear: Vec3 = [0.0; 3];
    linear[a] = sum;
    let mut along: Vec3 = [0.0; 3];
    along[a] = steps * grid.h;
    let angular = add(cross(first, linear), cross([1.0, 0.0, 0.0], along));
    (Wrench { linear, angular }, gross, squares)
}

/// Work of accelerations over the free faces, per mass and time, on a flow that has those velocities before and after.
pub(crate) fn work(grid: &Grid, sides: Sides, push: &Faces, [before, after]: [&Faces; 2]) -> f64 {
    let mut sum = 0.0;
    for (a, push) in push.iter().enumerate() {
        let mut range = grid.n.map(|n| [0, n as isize - 1]);
        range[a] = free(grid, sides, a);
        let len = (range[0][1] - range[0][0] + 1).max(0) as usize;
        for z in range[2][0]..=range[2][1] {
            for y in range[1][0]..=range[1][1] {
                let row = grid.at([range[0][0], y, z]);
                let row = row..row + len;
                let mean = before[a][row.clone()].iter().zip(&after[a][row.clone()]).map(|(b, u)| 0.5 * (b + u));
                sum += push[row].iter().zip(mean).map(|(f, u)| f * u).sum::<f64>();
            }
        }
    }
    sum
}

/// Sum over the free faces per value, with its moment about the origin, and the sums of sizes and of squares.
///
/// Row by row, then plane by plane: a sum of so many terms would lose digits that its parts have.
pub(crate) fn sums(grid: &Grid, sides: Sides, values: &Faces) -> (Wrench, f64, f64) {
    let (mut all, mut gross, mut squares) = (Wrench::default(), 0.0, 0.0);
    for (a, values) in values.iter().enumerate() {
        let mut range = grid.n.map(|n| [0, n as isize - 1]);
        range[a] = free(grid, sides, a);
        let len = (range[0][1] - range[0][0] + 1).max(0) as usize;
        for z in range[2][0]..=range[2][1] {
            let mut plane = Wrench::default();
            for y in range[1][0]..=range[1][1] {
                let cell = [range[0][0], y, z];
                let at = grid.at(cell);
                let (row, sizes, square) = row_sums(grid, a, cell, &values[at..at + len]);
                plane = plane.plus(row);
                gross += sizes;
                squares += square;
            }
            all = all.plus(plane);
        }
    }
    (all, gross, squares)
}
