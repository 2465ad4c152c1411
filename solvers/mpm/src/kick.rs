//! Impulses that partners give to own samples: each acts on the particle it belongs to, spread evenly over the substeps.
//!
//! A small share of an impulse may vanish in the rounding of a velocity; what has arrived is therefore summed in f64,
//! and each substep gives what is missing.

use cosplat_core::boundary::{Vec3, Wrench, add, cross, dot, norm, scale, sub};

use crate::real::Real;
use crate::store::{M, Store, V};

/// Impulses of one interface.
#[derive(Clone, Debug, Default)]
pub(crate) struct Kick {
    /// Interface, by its index among those that take impulses.
    pub(crate) index: usize,
    /// Particles.
    pub(crate) ids: Vec<u32>,
    /// Impulses \[N s\].
    pub(crate) wanted: Vec<Vec3>,
    /// What has arrived of each.
    pub(crate) arrived: Vec<Vec3>,
    /// Whether it is spread over the step; otherwise it acts at its start.
    pub(crate) spread: bool,
    /// Angular impulse about the world origin so far.
    pub(crate) angular: Vec3,
    /// Work so far \[J\].
    pub(crate) work: f64,
}

/// Impulses of all interfaces in one step.
#[derive(Clone, Debug, Default)]
pub(crate) struct Kicks(pub(crate) Vec<Kick>);

impl Kick {
    /// A new one.
    pub(crate) fn new(index: usize, ids: Vec<u32>, wanted: Vec<Vec3>, spread: bool) -> Self {
        let arrived = vec![[0.0; 3]; ids.len()];
        Self { index, ids, wanted, arrived, spread, angular: [0.0; 3], work: 0.0 }
    }

    /// Impulse, angular impulse about the world origin, Σ|J| and work.
    pub(crate) fn totals(&self) -> (Wrench, f64, f64) {
        let linear = self.wanted.iter().fold([0.0; 3], |sum, &j| add(sum, j));
        (Wrench { linear, angular: self.angular }, self.wanted.iter().map(|&j| norm(j)).sum(), self.work)
    }
}

impl Kicks {
    /// Brings what has arrived to the share `done` of the step.
    pub(crate) fn apply<R: Real>(&mut self, store: &mut Store<R>, dx: f64, done: f64) {
        if self.0.is_empty() {
            return;
        }
        let corner: Vec<[i32; 3]> = corners(store);
        for kick in &mut self.0 {
            let share = if kick.spread { done.min(1.0) } else { 1.0 };
            for ((&id, &wanted), arrived) in kick.ids.iter().zip(&kick.wanted).zip(&mut kick.arrived) {
                let missing = sub(scale(wanted, share), *arrived);
                if missing.iter().all(|j| j.abs() < f64::MIN_POSITIVE) {
                    continue;
                }
                let slot = store.slot[id as usize] as usize;
                let mass = store.field(slot, M);
                let before = store.triple(slot, V);
                let after = [0, 1, 2].map(|k| store.set(slot, V + k, before[k] + missing[k] / mass));
                let taken = scale(sub(after, before), mass);
                let (x, lo) = (store.triple(slot, crate::store::X), store.triple(slot, crate::store::XLO));
                let at = corner[slot / 4];
                let x = [0, 1, 2].map(|k| (4.0 * f64::from(at[k]) + (x[k] - lo[k])) * dx);
                *arrived = add(*arrived, taken);
                kick.angular = add(kick.angular, cross(x, taken));
                kick.work += 0.5 * dot(taken, add(before, after));
            }
        }
    }
}

/// Corner of the block of each quad.
fn corners<R: Real>(store: &Store<R>) -> Vec<[i32; 3]> {
    store.blocks.iter().flat_map(|b| std::iter::repeat_n(b.at, b.quads as usize)).collect()
}
