//! How heavy a body's samples are to who pushes them.
//!
//! An impulse on a particle moves its neighbours on the grid along. Where all samples are pushed alike, the velocity of one
//! changes by `J Σ_n w_n N_n/m_n`, with the mass `m_n` of a node and the sum `N_n` of the weights with which samples reach it. That
//! is the row sum of the samples' mobility, which has no negative entry and so no eigenvalue above its largest row sum:
//! samples with the mass of one over it never give way by less than who pushes them takes them to. In a leaf as thin as its
//! particles each has its own mass, on the face of a block up to 1.8 of it.

use std::collections::BTreeMap;
use std::ops::Range;

use crate::model::Shown;
use crate::real::Real;
use crate::sim::Sim;
use crate::store::M;

/// Weights with which samples reach a node, and the mass there \[kg\].
#[derive(Clone, Copy, Debug, Default)]
struct Node {
    samples: f64,
    mass: f64,
}

impl<R: Real> Sim<R> {
    /// Masses that the samples of the body with the particles `ids` resist with where they are now \[kg\].
    pub(crate) fn resisting(&self, shown: &Shown, ids: Range<u64>) -> Vec<f64> {
        let (store, dx, home) = (&self.store, self.setting.dx, self.homes());
        let reached = |id: u64| {
            let slot = store.slot[id as usize] as usize;
            (reached(store.position(home[slot / 4], slot, dx), dx), store.field(slot, M))
        };
        let mut nodes: BTreeMap<[i32; 3], Node> = BTreeMap::new();
        for mark in &shown.surface {
            for (node, weight) in reached(u64::from(mark.id)).0 {
                nodes.entry(node).or_default().samples += weight;
            }
        }
        for (around, mass) in ids.map(reached) {
            for (node, weight) in around {
                if let Some(node) = nodes.get_mut(&node) {
                    node.mass += weight * mass;
                }
            }
        }
        let mobility = |(node, weight): ([i32; 3], f64)| {
            nodes.get(&node).filter(|n| n.mass > 0.0).map_or(0.0, |n| weight * n.samples / n.mass)
        };
        let masses = shown.surface.iter().map(|mark| {
            let all: f64 = reached(u64::from(mark.id)).0.into_iter().map(mobility).sum();
            // At least its own: roundings of nodes that hold next to nothing.
            if all > 0.0 { (1.0 / all).max(mark.mass) } else { mark.mass }
        });
        masses.collect()
    }
}

/// Nodes around a place \[m\] with their weights, by the quadratic B-spline.
fn reached(x: [f64; 3], dx: f64) -> [([i32; 3], f64); 27] {
    let axis = x.map(|x| {
        let first = (x / dx - 0.5).floor();
        let d = x / dx - first - 1.0;
        (first as i32, [0.5 * (0.5 - d).powi(2), 0.75 - d * d, 0.5 * (0.5 + d).powi(2)])
    });
    std::array::from_fn(|i| {
        let at = [i / 9, i / 3 % 3, i % 3];
        let weight = (0..3).map(|k| axis[k].1[at[k]]).product();
        (std::array::from_fn(|k| axis[k].0 + at[k] as i32), weight)
    })
}
