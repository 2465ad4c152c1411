//! Walls of bodies that flow: what nodes inside a wall may do, and how much of the room around a node is open.
//!
//! Solids meet walls at the surface of their single particles (`touch`). What flows would creep together there: nothing
//! but the nodes behind the wall, with very little mass, holds its particles apart, and its volume ratio, which is summed
//! from the velocity gradient, would not learn of it. So its nodes inside a wall do not move further in, with Coulomb
//! friction, or are held.
//!
//! The volume ratio still gathers small errors and forgets none, so it is compared with the density that the grid shows
//! (`law::Room`). At a wall a node sees only the open part of its kernel filled: its mass is divided by that part, the
//! integral `S(φ/dx)` of the quadratic B-spline from the wall on, before particles read it.
//!
//! The price: the surface of what flows stands where the nodes are, up to half a cell before or behind a wall that does
//! not go through them.

use std::collections::BTreeMap;
use std::sync::Arc;

use cosplat_core::boundary::{dot, scale, sub};
use cosplat_core::distance::SignedDistance;

use crate::grid::{Grid, Substep};
use crate::law::Law;
use crate::real::{Lanes, Real};
use crate::tally::Tally;
use crate::tile::{NODES, node_position};
use crate::topology::Topology;
use crate::walls::{Surface, Wall};

/// Radius of a ball around a grid block's nodes, in cells: half the diagonal of 3³ cells, and the reach of a kernel.
const RADIUS: f64 = 2.6 + 1.5;
/// Least open part; no particle in front of a wall gives a node with less a weight above 1e-3.
const LEAST: f64 = 1e-3;

/// Distance below which a node counts as inside, in cells: the wall goes through the nearest nodes. Between two layers of
/// nodes, an open one right in front of the wall would be as light as those behind it.
const ON: f64 = 0.5;

/// Nodes of a grid block near walls.
#[derive(Clone, Debug, Default)]
struct Shore {
    /// Node and one over its open part.
    cut: Vec<(usize, f64)>,
    /// Node inside a wall, the outward normal there and what the wall's surface does.
    inside: Vec<(usize, [f64; 3], Surface)>,
}

/// Nodes whose kernel a wall cuts. Walls do not move, so each grid block is looked at once in a run.
#[derive(Clone, Debug, Default)]
pub(crate) struct Shores {
    known: BTreeMap<([i32; 3], u32), Arc<Shore>>,
    /// By entry of the topology, for bodies that flow.
    near: Vec<(usize, Arc<Shore>)>,
}

impl Shores {
    /// Looks for the nodes near walls of the entries whose body flows.
    pub(crate) fn prepare<R: Real>(&mut self, topology: &Topology, walls: &[Wall], laws: &[Law<R>], dx: f64) {
        self.near.clear();
        for (e, entry) in topology.entries.iter().enumerate() {
            let law = &laws[entry.body as usize];
            if law.flows() {
                let glides = matches!(law, Law::Liquid(_));
                let shore = self
                    .known
                    .entry((entry.at, entry.body))
                    .or_insert_with(|| Arc::new(shore(entry.at, entry.body as usize, glides, walls, dx)));
                if !shore.cut.is_empty() {
                    self.near.push((e, Arc::clone(shore)));
                }
            }
        }
    }

    /// Keeps nodes from moving further into walls. Returns the walls' impulses and the energy lost to sliding.
    pub(crate) fn stop<R: Real>(&self, step: &Substep, grid: &mut Grid<R>) -> (Tally, f64) {
        let (mut tally, mut lost) = (Tally::default(), 0.0);
        for (e, shore) in &self.near {
            let at = step.topology.entries[*e].at;
            for &(n, normal, surface) in &shore.inside {
                let node = &mut grid.nodes[*e][n];
                let [x, y, z, m] = node.array();
                let before = [x, y, z].map(R::f64);
                let into = -dot(before, normal);
                if m.f64() <= step.empty || (into <= 0.0 && surface != Surface::Stick) {
                    continue;
                }
                let new = kept(surface, before, normal, into).map(R::of);
                *node = R::V::from_array([new[0], new[1], new[2], m]);
                let after = new.map(R::f64);
                tally.change(m.f64(), node_position(at, n, step.dx), before, after);
                lost -= m.f64() * dot(sub(after, before), after);
            }
        }
        (tally, lost)
    }

    /// Divides their mass by their open part.
    pub(crate) fn fill<R: Real>(&self, step: &Substep, grid: &mut Grid<R>) {
        for (e, shore) in &self.near {
            for &(node, factor) in &shore.cut {
                let [x, y, z, m] = grid.nodes[*e][node].array();
                if m.f64() > step.empty {
                    grid.nodes[*e][node] = R::V::from_array([x, y, z, R::of(m.f64() * factor)]);
                }
            }
        }
    }
}

/// Velocity of a node that moves into a wall with the speed `into`.
fn kept(surface: Surface, v: [f64; 3], normal: [f64; 3], into: f64) -> [f64; 3] {
    let Surface::Coulomb(fixed, kinetic) = surface else { return [0.0; 3] };
    let along = [0, 1, 2].map(|k| v[k] + into * normal[k]);
    let speed = dot(along, along).sqrt();
    if speed <= fixed * into { [0.0; 3] } else { scale(along, (1.0 - kinetic * into / speed).max(0.0)) }
}

/// Nodes near walls of the block `at`. Behind one that holds, a liquid `glides` on as it came, so that its shear reaches the wall
/// unchanged. Sand is held there too: its stress does not follow the rate of shear, and would drag those nodes, which
/// nothing holds, by `4 τ dt/ρ dx` in every substep: what rests on a slope would creep by a part of that.
fn shore(at: [i32; 3], body: usize, glides: bool, walls: &[Wall], dx: f64) -> Shore {
    let middle = at.map(|a| (4.0 * f64::from(a) + 1.5) * dx);
    let near: Vec<(&Wall, Surface)> = walls
        .iter()
        .filter(|w| w.shape.at_least(middle, RADIUS * dx) < 0.0)
        .filter_map(|w| w.surface[body].map(|surface| (w, surface)))
        .collect();
    let mut shore = Shore::default();
    if near.is_empty() {
        return shore;
    }
    for node in 0..NODES {
        let mut open = 1.0;
        for (wall, surface) in &near {
            let (distance, normal) = wall.shape.distance(node_position(at, node, dx));
            open *= open_part((distance / dx + ON).floor());
            if distance < ON * dx {
                let slips = glides && *surface == Surface::Stick && distance < -ON * dx;
                shore.inside.push((node, normal, if slips { Surface::Coulomb(0.0, 0.0) } else { *surface }));
            }
        }
        if open < 1.0 {
            shore.cut.push((node, 1.0 / open.max(LEAST)));
        }
    }
    shore
}

/// Part of a quadratic B-spline on this side of a wall at the distance `t` in cells.
fn open_part(t: f64) -> f64 {
    if t <= -1.5 {
        0.0
    } else if t < -0.5 {
        (t + 1.5).powi(3) / 6.0
    } else if t < 0.5 {
        0.5 + 0.75 * t - t * t * t / 3.0
    } else if t < 1.5 {
        1.0 - (1.5 - t).powi(3) / 6.0
    } else {
        1.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn open_part_is_the_integral_of_the_kernel() {
        let kernel = |u: f64| if u.abs() < 0.5 { 0.75 - u * u } else { 0.5 * (1.5 - u.abs()).max(0.0).powi(2) };
        let (n, mut sum) = (3000, 0.0);
        for i in 0..n {
            let t = -1.5 + f64::from(i) / 1000.0;
            // Midpoint rule of 1e-3: error below 1e-7.
            assert!((open_part(t) - sum).abs() < 1e-6, "{t}: {} instead of {sum}", open_part(t));
            sum += kernel(t + 5e-4) * 1e-3;
        }
    }
}
