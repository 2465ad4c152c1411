//! Static colliders at the grid's nodes: cached distance, non-penetration, Coulomb friction.

use std::collections::BTreeMap;
use std::sync::Arc;

use cosplat_core::boundary::{dot, norm, scale, sub};

use crate::shape::{Placed, SignedDistance};
use crate::tile::NODES;
use crate::topology::Topology;

/// What a surface does to what touches it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Surface {
    /// Holds on in every direction.
    Stick,
    /// Static and kinetic friction; may separate.
    Coulomb(f64, f64),
}

/// A static collider.
#[derive(Clone, Debug)]
pub(crate) struct Wall {
    /// Shape.
    pub(crate) shape: Placed,
    /// Surface for each body; `None` where the pair is left out.
    pub(crate) surface: Vec<Option<Surface>>,
}

/// A wall within reach of a node.
#[derive(Clone, Copy, Debug)]
pub(crate) struct WallNode {
    /// Node in the block.
    pub(crate) node: usize,
    /// Wall.
    pub(crate) wall: usize,
    /// Distance \[m\].
    pub(crate) phi: f64,
    /// Outward normal.
    pub(crate) normal: [f64; 3],
}

/// Walls near a block.
#[derive(Clone, Debug)]
pub(crate) struct Near {
    /// Node by node; at one node in the order of the scene.
    pub(crate) list: Vec<WallNode>,
    /// Distance of the nearest wall from each node \[m\].
    pub(crate) least: [f64; NODES],
}

/// Walls near a block, or nothing.
pub(crate) type WallNodes = Option<Arc<Near>>;

/// All static colliders and what is known of them at the nodes.
#[derive(Clone, Debug, Default)]
pub(crate) struct Walls {
    /// Colliders.
    pub(crate) list: Vec<Wall>,
    known: BTreeMap<[i32; 3], WallNodes>,
    /// By group of the topology.
    pub(crate) near: Vec<WallNodes>,
}

/// Node `n` of the block at `at` in the world.
pub(crate) fn node_position(at: [i32; 3], n: usize, dx: f64) -> [f64; 3] {
    let local = [n / 16, n / 4 % 4, n % 4];
    [0, 1, 2].map(|k| (4.0 * f64::from(at[k]) + local[k] as f64) * dx)
}

impl Walls {
    /// Colliders without a grid.
    pub(crate) fn new(list: Vec<Wall>) -> Self {
        Self { list, ..Self::default() }
    }

    /// Looks up every group's nodes; computes those seen for the first time.
    pub(crate) fn prepare(&mut self, topology: &Topology, dx: f64) {
        let (list, known) = (&self.list, &mut self.known);
        let near = (0..topology.group_count()).map(|g| {
            let at = topology.entries[topology.group(g).start].at;
            known.entry(at).or_insert_with(|| nearest(list, at, dx)).clone()
        });
        self.near = near.collect();
    }
}

fn nearest(walls: &[Wall], at: [i32; 3], dx: f64) -> WallNodes {
    let middle = at.map(|a| (4.0 * f64::from(a) + 1.5) * dx);
    let close: Vec<(usize, &Wall)> =
        walls.iter().enumerate().filter(|(_, w)| w.shape.at_least(middle, 2.7 * dx) < dx).collect();
    let mut near = Near { list: Vec::new(), least: [f64::INFINITY; NODES] };
    for (node, least) in near.least.iter_mut().enumerate() {
        for &(wall, Wall { shape, .. }) in &close {
            let (phi, normal) = shape.distance(node_position(at, node, dx));
            *least = least.min(phi);
            if phi < dx {
                near.list.push(WallNode { node, wall, phi, normal });
            }
        }
    }
    (!near.list.is_empty()).then(|| Arc::new(near))
}

/// Velocity of a node after contact with a surface at rest, or nothing when they do not touch.
///
/// `v_n' = max(v_n, -φ⁺/dt)`: only the excess over what would reach the surface in this substep is removed; the
/// tangential velocity loses at most μ times the normal change (Coulomb), all of it below the static limit.
pub(crate) fn slide(surface: Surface, phi: f64, n: [f64; 3], v: [f64; 3], dt: f64, dx: f64) -> Option<[f64; 3]> {
    if surface == Surface::Stick && phi <= 1e-6 * dx {
        return Some([0.0; 3]);
    }
    let (normal, allowed) = (dot(v, n), -phi.max(0.0) / dt);
    if normal >= allowed {
        return None;
    }
    let removed = allowed - normal;
    let along = sub(v, scale(n, normal));
    let speed = norm(along);
    let keep = match surface {
        Surface::Stick => 0.0,
        Surface::Coulomb(fixed, _) if speed <= fixed * removed => 0.0,
        Surface::Coulomb(_, kinetic) => (1.0 - kinetic * removed / speed).max(0.0),
    };
    Some([0, 1, 2].map(|k| along[k] * keep + n[k] * allowed))
}
