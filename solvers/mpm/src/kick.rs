//! Impulses that partners give to own samples: each acts on the particle it belongs to, spread evenly over the substeps.
//!
//! A small share of an impulse may vanish in the rounding of a velocity; what has arrived is therefore summed in f64,
//! and each substep gives what is missing.

use cosplat_core::boundary::{Vec3, Wrench, add, cross, dot, norm, scale, sub};

use crate::grid::{Grid, Substep};
use crate::real::{Lanes, Real};
use crate::store::{M, Store, V};
use crate::tile::NODES;
use crate::touch::around;

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
    /// What came in this substep.
    fresh: Vec<Fresh>,
}

/// An impulse that has just come: block and slot of the particle, the impulse \[N s\], the velocity before it \[m/s\].
#[derive(Clone, Copy, Debug)]
struct Fresh {
    block: u32,
    slot: u32,
    impulse: Vec3,
    before: Vec3,
}

/// Impulses at the nodes in this substep \[N s\]; nothing but zeros between two substeps.
#[derive(Clone, Debug, Default)]
pub(crate) struct AtNodes(Vec<Vec3>);

/// Impulses of all interfaces in one step.
#[derive(Clone, Debug, Default)]
pub(crate) struct Kicks(pub(crate) Vec<Kick>);

impl Kick {
    /// A new one.
    pub(crate) fn new(index: usize, ids: Vec<u32>, wanted: Vec<Vec3>, spread: bool) -> Self {
        let arrived = vec![[0.0; 3]; ids.len()];
        Self { index, ids, wanted, arrived, spread, angular: [0.0; 3], work: 0.0, fresh: Vec::new() }
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
        let block_of = blocks(store);
        for kick in &mut self.0 {
            kick.fresh.clear();
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
                let block = block_of[slot / 4];
                let at = store.blocks[block as usize].at;
                let x = [0, 1, 2].map(|k| (4.0 * f64::from(at[k]) + (x[k] - lo[k])) * dx);
                *arrived = add(*arrived, taken);
                kick.angular = add(kick.angular, cross(x, taken));
                kick.fresh.push(Fresh { block, slot: slot as u32, impulse: taken, before });
            }
        }
    }

    /// Books the work of what came in this substep, once the masses of the nodes are known.
    pub(crate) fn book<R: Real>(&mut self, step: &Substep, store: &Store<R>, grid: &Grid<R>, at: &mut AtNodes) {
        if self.0.is_empty() {
            return;
        }
        at.0.resize(grid.nodes.len() * NODES, [0.0; 3]);
        for kick in &mut self.0 {
            for &Fresh { block, slot, impulse, before } in &kick.fresh {
                let (mut moved, mut inverse) = (before, 0.0);
                for ((entry, n), weight, _) in around(step, store, block, slot) {
                    let mass = grid.nodes[entry as usize][n as usize].array()[3].f64();
                    if mass > step.empty {
                        let given = &mut at.0[entry as usize * NODES + n as usize];
                        moved = add(moved, scale(*given, weight / mass));
                        inverse += weight * weight / mass;
                        *given = add(*given, scale(impulse, weight));
                    }
                }
                kick.work += dot(impulse, moved) + 0.5 * dot(impulse, impulse) * inverse;
            }
        }
        for &Fresh { block, slot, .. } in self.0.iter().flat_map(|kick| &kick.fresh) {
            for ((entry, n), ..) in around(step, store, block, slot) {
                at.0[entry as usize * NODES + n as usize] = [0.0; 3];
            }
        }
    }
}

/// Block of each quad.
pub(crate) fn blocks<R: Real>(store: &Store<R>) -> Vec<u32> {
    let each = store.blocks.iter().enumerate();
    each.flat_map(|(i, b)| std::iter::repeat_n(i as u32, b.quads as usize)).collect()
}
