//! Which grid nodes touch which rigid partner.

use crate::grid::{Grid, Substep};
use crate::proxy::{Partner, Proxy};
use crate::real::{Lanes, Real};
use crate::shape::{Placed, SignedDistance};
use crate::tile::NODES;
use crate::walls::{Surface, Walls, node_position};

/// One node in reach.
pub(crate) struct Node {
    /// Entry of the topology.
    pub(crate) entry: usize,
    /// Node of the entry.
    pub(crate) n: usize,
    /// Own body.
    pub(crate) body: usize,
    /// Surface of the pair.
    pub(crate) surface: Surface,
    /// Mass \[kg\].
    pub(crate) mass: f64,
    /// Place \[m\].
    pub(crate) x: [f64; 3],
    /// Velocity before contact \[m/s\].
    pub(crate) velocity: [f64; 3],
    /// Outward normal of the partner.
    pub(crate) normal: [f64; 3],
    /// -φ⁺/dt.
    pub(crate) gap_speed: f64,
    /// How it touches.
    pub(crate) state: Touch,
    /// Friction impulse on the node while it slides.
    pub(crate) drag: [f64; 3],
    /// Impulse on the node \[N s\].
    pub(crate) impulse: [f64; 3],
}

/// How a node touches.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum Touch {
    /// Not at all.
    Off,
    /// Kept from passing, with friction.
    Slides,
    /// Moves with the partner.
    Sticks,
}

/// Nodes that belong to each stand-in: those it is nearest to, within one cell.
pub(crate) fn in_reach<R: Real>(
    step: &Substep,
    grid: &mut Grid<R>,
    walls: &Walls,
    partners: &[Partner],
    proxies: &[Proxy],
) -> (Vec<Vec<Node>>, u64) {
    let placed: Vec<Placed> = proxies.iter().map(|p| p.placed(partners[p.partner].shape)).collect();
    let mut sets: Vec<Vec<Node>> = proxies.iter().map(|_| Vec::new()).collect();
    let mut shared = 0;
    for g in 0..step.topology.group_count() {
        let entries = step.topology.group(g);
        let at = step.topology.entries[entries.start].at;
        let middle = at.map(|a| (4.0 * f64::from(a) + 1.5) * step.dx);
        let near: Vec<usize> =
            (0..proxies.len()).filter(|&i| placed[i].at_least(middle, 2.7 * step.dx) < step.dx).collect();
        if near.is_empty() || !grid.groups[g].used {
            continue;
        }
        for n in 0..NODES {
            let x = node_position(at, n, step.dx);
            let wall = walls.near.get(g).and_then(Option::as_ref).map_or(f64::INFINITY, |w| w.least[n]);
            let mut best = (wall, usize::MAX, [0.0; 3]);
            let mut close = u64::from(wall < step.dx);
            for &i in &near {
                let (phi, normal) = placed[i].distance(x);
                close += u64::from(phi < step.dx);
                if phi < best.0 {
                    best = (phi, i, normal);
                }
            }
            let (phi, owner, normal) = best;
            if owner == usize::MAX || phi >= step.dx {
                continue;
            }
            grid.groups[g].held |= 1 << n;
            for entry in entries.clone() {
                let [vx, vy, vz, m] = grid.nodes[entry][n].array().map(R::f64);
                let body = step.topology.entries[entry].body as usize;
                let Some((_, surface)) = partners[proxies[owner].partner].pairs[body].filter(|_| m > step.empty) else {
                    continue;
                };
                shared += u64::from(close > 1);
                sets[owner].push(Node {
                    entry,
                    n,
                    body,
                    surface,
                    mass: m,
                    x,
                    velocity: [vx, vy, vz],
                    normal,
                    gap_speed: -phi.max(0.0) / step.dt,
                    state: Touch::Off,
                    drag: [0.0; 3],
                    impulse: [0.0; 3],
                });
            }
        }
    }
    (sets, shared)
}
