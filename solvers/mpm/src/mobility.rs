//! How heavy a body's samples are to who pushes them.
//!
//! An impulse on a particle moves its neighbours on the grid along. Where all samples are pushed alike, the velocity of one
//! changes by `J Σ_n w_n N_n/m_n`, with the mass `m_n` of a node and the sum `N_n` of the weights with which samples reach it. That
//! is the row sum of the samples' mobility, which has no negative entry and so no eigenvalue above its largest row sum:
//! samples with the mass of one over it never give way by less than who pushes them takes them to. In a leaf as thin as its
//! particles each has its own mass, on the face of a block up to 1.8 of it.

use std::ops::Range;

use crate::kick::blocks;
use crate::model::Shown;
use crate::real::Real;
use crate::sim::Sim;
use crate::store::M;
use crate::tile::NODES;
use crate::touch::around;

/// Weights with which samples reach a node, and the mass there \[kg\].
#[derive(Clone, Copy, Debug, Default)]
struct Node {
    samples: f64,
    mass: f64,
}

impl<R: Real> Sim<R> {
    /// Masses that the samples of the body with the particles `ids` resist with where they are now \[kg\].
    pub(crate) fn resisting(&self, shown: &Shown, ids: Range<u64>) -> Vec<f64> {
        let (step, block_of) = (self.still(), blocks(&self.store));
        let slot = |id: u64| self.store.slot[id as usize];
        let reached = |slot: u32| {
            let nodes = around(&step, &self.store, block_of[slot as usize / 4], slot);
            nodes.map(|((entry, n), weight, _)| (entry as usize * NODES + n as usize, weight))
        };
        let mut nodes = vec![Node::default(); step.topology.entries.len() * NODES];
        for mark in &shown.surface {
            for (node, weight) in reached(slot(u64::from(mark.id))) {
                nodes[node].samples += weight;
            }
        }
        for slot in ids.map(slot) {
            let mass = self.store.field(slot as usize, M);
            for (node, weight) in reached(slot) {
                nodes[node].mass += weight * mass;
            }
        }
        let mobility = |(node, weight): (usize, f64)| {
            let Node { samples, mass } = nodes[node];
            if mass > 0.0 { weight * samples / mass } else { 0.0 }
        };
        let masses = shown.surface.iter().map(|mark| {
            let all: f64 = reached(slot(u64::from(mark.id))).into_iter().map(mobility).sum();
            // At least its own: roundings of nodes that hold next to nothing.
            if all > 0.0 { (1.0 / all).max(mark.mass) } else { mark.mass }
        });
        masses.collect()
    }
}
