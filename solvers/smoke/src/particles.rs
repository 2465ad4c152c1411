//! Particles of smoke: they go where the gas goes, and nothing else.

use cosplat_core::boundary::{Vec3, add, scale};
use rayon::prelude::*;

use crate::grid::Faces;
use crate::model::Model;

/// Particles that one thread takes at a time.
const CHUNK: usize = 1024;

/// Moves particles by Heun's rule over `dt` \[s\] from `now`, between the velocities at its start and its end.
///
/// Those of an inflow that have not been let go stay where they are. What leaves through an open side goes on with the
/// speed that it had there.
pub(crate) fn drift(model: &Model, before: &Faces, after: &Faces, x: &mut [Vec3], now: f64, dt: f64, parallel: bool) {
    let grid = &model.grid;
    let (low, high) = (model.whole.grid.low, model.whole.grid.high());
    let born = model.born(now + dt);
    let one = |x: &mut Vec3| {
        let first = grid.velocity(before, *x);
        let then = grid.velocity(after, add(*x, scale(first, dt)));
        *x = add(*x, scale(add(first, then), 0.5 * dt));
        for k in 0..3 {
            let [below, above] = model.params.open[k];
            if !below && x[k] < low[k] {
                x[k] = low[k];
            }
            if !above && x[k] > high[k] {
                x[k] = high[k];
            }
        }
    };
    let moving = &mut x[..born];
    if parallel {
        moving.par_chunks_mut(CHUNK).for_each(|part| part.iter_mut().for_each(one));
    } else {
        moving.iter_mut().for_each(one);
    }
}
