//! What a substep does to velocities before the projection.

use crate::flux::{Tensor, acceleration};
use crate::grid::Grid;
use crate::project::for_free;
use crate::sides::Sides;

/// Where it is done, and on how many threads.
pub(crate) struct Parts<'a> {
    pub(crate) grid: &'a Grid,
    pub(crate) sides: Sides,
    pub(crate) parallel: bool,
}

/// Accelerations of the faces of component `a` \[m/s²\]: `lift` for each of the four shares of smoke on both sides of a
/// face at two moments, and those from elsewhere.
pub(crate) fn lifted(
    parts: &Parts,
    a: usize,
    lift: f64,
    moments: [&[f64]; 2],
    others: Option<&[f64]>,
    out: &mut [f64],
) {
    let s = parts.grid.s[a];
    for_free(parts.grid, parts.sides, a, out, parts.parallel, &|at, _, row| {
        let both = moments.map(|c| [&c[at - s..at - s + row.len()], &c[at..at + row.len()]]);
        for (i, out) in row.iter_mut().enumerate() {
            let sum = both[0][0][i] + both[0][1][i] + (both[1][0][i] + both[1][1][i]);
            *out = lift * sum + others.map_or(0.0, |f| f[at + i]);
        }
    });
}

/// Velocities of component `a` after `dt` \[s\] from `u` by the tensor, times a factor, and by other accelerations
/// \[m/s²\].
pub(crate) fn marched(
    parts: &Parts,
    a: usize,
    u: &[f64],
    (tensor, factor): (&Tensor, f64),
    others: &[f64],
    dt: f64,
    out: &mut [f64],
) {
    for_free(parts.grid, parts.sides, a, out, parts.parallel, &|at, _, row| {
        let len = row.len();
        acceleration(parts.grid, tensor, a, at, row);
        let (u, others) = (&u[at..at + len], &others[at..at + len]);
        for (i, out) in row.iter_mut().enumerate() {
            *out = u[i] + dt * (factor * *out + others[i]);
        }
    });
}
