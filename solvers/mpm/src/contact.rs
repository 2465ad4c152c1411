//! Contact of bodies of one process: each has its own velocity at a node; where both have mass and the space is full,
//! they exchange an impulse that is equal and opposite by construction.
//!
//! Normal: difference of the gradients of the two volume fractions. Gap: bodies touch where their fractions at the node
//! sum to [`FULL`]; a flat gap of 0.27 cells is the largest that counts as touching. Source: Bardenhagen et al., "An
//! improved contact algorithm for the material point method" (2001); the criterion replaces its pressure test.

use cosplat_core::boundary::{dot, norm, scale, sub};
use rayon::prelude::*;

use crate::grid::{Grid, Substep};
use crate::real::{Lanes, Real};
use crate::walls::Surface;

/// Sum of volume fractions from which on two bodies touch.
const FULL: f64 = 0.8;

/// How the bodies of a process meet.
#[derive(Clone, Debug, Default)]
pub(crate) struct Pairs {
    /// Surface by body and body; `None` where they pass through each other.
    pub(crate) surface: Vec<Vec<Option<Surface>>>,
    /// Density at rest by body \[kg/m³\].
    pub(crate) density: Vec<f64>,
}

/// New velocity of an entry's node.
type Change = (usize, usize, [f64; 3]);

impl Pairs {
    /// Exchanges impulses. Returns the energy lost and the number of touching nodes.
    pub(crate) fn exchange<R: Real>(&self, step: &Substep, grid: &mut Grid<R>) -> (f64, u64) {
        let topology = step.topology;
        let several = |&g: &usize| grid.groups[g].used && topology.group(g).len() > 1;
        let groups: Vec<usize> = (0..topology.group_count()).filter(several).collect();
        if groups.is_empty() {
            return (0.0, 0);
        }
        let one = |&g: &usize| self.in_group(step, grid, g);
        let changes: Vec<(Vec<Change>, f64, u64)> =
            if step.parallel { groups.par_iter().map(one).collect() } else { groups.iter().map(one).collect() };
        let (mut lost, mut count) = (0.0, 0);
        for (changes, loss, touching) in changes {
            lost += loss;
            count += touching;
            for (entry, n, v) in changes {
                let node = &mut grid.nodes[entry][n];
                let m = node.array()[3];
                *node = R::V::from_array([R::of(v[0]), R::of(v[1]), R::of(v[2]), m]);
            }
        }
        (lost, count)
    }

    fn in_group<R: Real>(&self, step: &Substep, grid: &Grid<R>, g: usize) -> (Vec<Change>, f64, u64) {
        let entries = step.topology.group(g);
        let (mut changes, mut lost, mut count) = (Vec::new(), 0.0, 0);
        let cell = step.dx * step.dx * step.dx;
        for n in 0..crate::tile::NODES {
            let mut here: Vec<(usize, usize, f64, [f64; 3], bool)> = entries
                .clone()
                .filter_map(|e| {
                    let [x, y, z, m] = grid.nodes[e][n].array().map(R::f64);
                    (m > step.empty).then(|| (e, step.topology.entries[e].body as usize, m, [x, y, z], false))
                })
                .collect();
            for b in 1..here.len() {
                for a in 0..b {
                    let ((ea, ba, ma, va, _), (eb, bb, mb, vb, _)) = (here[a], here[b]);
                    let Some(surface) = self.surface[ba][bb] else { continue };
                    let fraction = (ma / self.density[ba] + mb / self.density[bb]) / cell;
                    if fraction < FULL {
                        continue;
                    }
                    // Volume falls outwards: the difference points from a to b.
                    let [ga, gb] =
                        [(ea, ba), (eb, bb)].map(|(e, b)| scale(slope(step, grid, e, n), 1.0 / self.density[b]));
                    let towards = sub(gb, ga);
                    let length = norm(towards);
                    if length == 0.0 {
                        continue;
                    }
                    let reduced = ma * mb / (ma + mb);
                    let relative = sub(va, vb);
                    let Some(j) = impulse(surface, scale(towards, 1.0 / length), relative, reduced) else { continue };
                    // Sliding alone, with the relative velocity after contact.
                    lost -= dot(j, relative) + dot(j, j) / reduced;
                    count += 1;
                    here[a].3 = [0, 1, 2].map(|k| va[k] + j[k] / ma);
                    here[b].3 = [0, 1, 2].map(|k| vb[k] - j[k] / mb);
                    (here[a].4, here[b].4) = (true, true);
                }
            }
            changes.extend(here.iter().filter(|h| h.4).map(|h| (h.0, n, h.3)));
        }
        (changes, lost, count)
    }
}

/// Impulse on `a` for a relative velocity `v` of a to b and a normal from a to b.
fn impulse(surface: Surface, n: [f64; 3], v: [f64; 3], reduced: f64) -> Option<[f64; 3]> {
    let Surface::Coulomb(fixed, kinetic) = surface else { return Some(scale(v, -reduced)) };
    let approach = dot(v, n);
    if approach <= 0.0 {
        return None;
    }
    let along = sub(v, scale(n, approach));
    let speed = norm(along);
    let stop = if speed <= fixed * approach { 1.0 } else { (kinetic * approach / speed).min(1.0) };
    Some([0, 1, 2].map(|k| -reduced * (approach * n[k] + stop * along[k])))
}

/// Central differences of the nodal mass around a node, per two cells.
fn slope<R: Real>(step: &Substep, grid: &Grid<R>, entry: usize, n: usize) -> [f64; 3] {
    let here = step.topology.entries[entry];
    let local = [n / 16, n / 4 % 4, n % 4].map(|l| i32::from(l as u8));
    let mass = |axis: usize, by: i32| {
        let mut moved = local;
        moved[axis] += by;
        let mut at = here.at;
        at[axis] += moved[axis].div_euclid(4);
        moved[axis] = moved[axis].rem_euclid(4);
        let place = if at == here.at { Some(entry) } else { step.topology.find(at, here.body) };
        place.map_or(0.0, |e| grid.nodes[e][((moved[0] * 4 + moved[1]) * 4 + moved[2]) as usize].array()[3].f64())
    };
    [0, 1, 2].map(|axis| mass(axis, 1) - mass(axis, -1))
}
