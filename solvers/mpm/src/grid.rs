//! The grid between the two transfers: sum of the tiles, outside influences.

use cosplat_core::boundary::{add, dot, sub};
use cosplat_core::plugin::Push;

use crate::parts::for_parts;
use crate::real::{Lanes, Real};
use crate::tally::Tally;
use crate::tile::{Extent, NODES, Nodes, Tile, node_position};
use crate::topology::{NONE, Topology};

/// Velocity and mass at the nodes, and what happened there in this substep.
#[derive(Clone, Debug, Default)]
pub(crate) struct Grid<R: Real> {
    /// By entry of the topology: velocity in three lanes, mass in the fourth.
    pub(crate) nodes: Vec<Nodes<R>>,
    /// The same before stress, outside influences and contact, for bodies that remember; else empty.
    pub(crate) before: Vec<Nodes<R>>,
    /// By group of the topology.
    pub(crate) groups: Vec<Group>,
    ends: Vec<usize>,
}

/// What happened in one group.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Group {
    /// Whether any particle reaches it.
    pub(crate) used: bool,
    /// Outside influences.
    pub(crate) pushed: Tally,
    /// Work of those without a potential energy \[J\].
    pub(crate) supplied: f64,
}

/// Mass below which a node is empty, as a share of the lightest particle. Momentum and mass of a node shrink with the
/// same weight, so the smallest weights do no harm, and every one left out would be momentum lost.
pub(crate) const EMPTY: f64 = 1e-20;

/// What a substep does on the grid.
#[derive(Clone, Copy)]
pub(crate) struct Substep<'a> {
    /// Grid blocks.
    pub(crate) topology: &'a Topology,
    /// Grid spacing \[m\].
    pub(crate) dx: f64,
    /// Length \[s\].
    pub(crate) dt: f64,
    /// Mass below which a node is empty \[kg\].
    pub(crate) empty: f64,
    /// Share work among threads.
    pub(crate) parallel: bool,
}

impl<R: Real> Grid<R> {
    /// Room for a topology.
    pub(crate) fn prepare(&mut self, topology: &Topology) {
        self.nodes.resize(topology.entries.len(), [R::V::default(); NODES]);
        self.groups = vec![Group::default(); topology.group_count()];
        self.ends = topology.groups.iter().skip(1).map(|&e| e as usize).collect();
    }

    /// Sums the tiles of bodies that remember in the same order, and divides by the mass.
    pub(crate) fn gather_before(&mut self, step: &Substep, tiles: &[Tile<R>], extents: &[Extent], keeps: &[f64]) {
        let topology = step.topology;
        self.before.resize(topology.entries.len(), [R::V::default(); NODES]);
        let mut none = vec![(); topology.group_count()];
        for_parts(step.parallel, &self.ends, &mut self.before, &mut none, &|g, nodes, ()| {
            let first = topology.group(g).start;
            for (i, nodes) in nodes.iter_mut().enumerate() {
                if keeps[topology.entries[first + i].body as usize] <= 0.0 {
                    continue;
                }
                sum::<R>(nodes, topology, first + i, tiles, extents);
                for node in nodes.iter_mut() {
                    let [px, py, pz, m] = node.array();
                    let empty = m.f64() <= step.empty;
                    *node = if empty { R::V::default() } else { R::V::from_array([px / m, py / m, pz / m, m]) };
                }
            }
        });
    }

    /// Sums the tiles in a fixed order, divides by the mass and adds outside influences.
    pub(crate) fn gather(&mut self, step: &Substep, tiles: &[Tile<R>], extents: &[Extent], push: &Push) {
        let topology = step.topology;
        for_parts(step.parallel, &self.ends, &mut self.nodes, &mut self.groups, &|g, nodes, group| {
            *group = Group::default();
            let first = topology.group(g).start;
            for (i, nodes) in nodes.iter_mut().enumerate() {
                let used = sum::<R>(nodes, topology, first + i, tiles, extents);
                group.used |= used;
                if used {
                    let entry = topology.entries[first + i];
                    velocities::<R>(nodes, step, entry.at, entry.body as usize, push, group);
                }
            }
        });
    }
}

/// Sum of all tiles that reach an entry. False where none does.
pub(crate) fn sum<R: Real>(
    nodes: &mut Nodes<R>,
    topology: &Topology,
    entry: usize,
    tiles: &[Tile<R>],
    extents: &[Extent],
) -> bool {
    nodes.fill(R::V::default());
    let mut used = false;
    for (from, &first) in topology.sources[entry].iter().enumerate() {
        let mut block = first;
        while block != NONE {
            if extents[block as usize].touches(26 - from) {
                used = true;
                let tile = &tiles[block as usize];
                extents[block as usize].runs(26 - from, |t, n, length| {
                    for (node, part) in nodes[n..n + length].iter_mut().zip(&tile[t..t + length]) {
                        *node += *part;
                    }
                });
            }
            block = topology.next[block as usize];
        }
    }
    used
}

fn velocities<R: Real>(
    nodes: &mut Nodes<R>,
    step: &Substep,
    at: [i32; 3],
    body: usize,
    push: &Push,
    group: &mut Group,
) {
    let weight = push.weight(body);
    let still = push.is_still(body);
    for (n, node) in nodes.iter_mut().enumerate() {
        let [px, py, pz, m] = node.array();
        if m.f64() <= step.empty {
            *node = R::V::default();
            continue;
        }
        let v = [px / m, py / m, pz / m];
        if still {
            *node = R::V::from_array([v[0], v[1], v[2], m]);
            continue;
        }
        let x = node_position(at, n, step.dx);
        let change = push.at(body, x);
        let after = [0, 1, 2].map(|k| R::of(v[k].f64() + change[k]));
        let (v, m64) = (v.map(R::f64), m.f64());
        group.pushed.change(m64, x, v, after.map(R::f64));
        group.supplied += 0.5 * m64 * dot(sub(change, weight), add(v, after.map(R::f64)));
        *node = R::V::from_array([after[0], after[1], after[2], m]);
    }
}
