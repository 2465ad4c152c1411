//! Nodes of the grid that touching particles reach, while the impulses at their places are sought.

use cosplat_core::plugin::{StateError, StateReader, StateSink};
use wide::f64x4;

use crate::grid::{Grid, Substep};
use crate::real::{Lanes, Real};
use crate::topology::NONE;
use crate::touch::Touch;

/// Nodes of all touching particles, each once.
#[derive(Clone, Debug, Default)]
pub(crate) struct Nodes {
    /// Entry of the topology and node in it.
    pub(crate) place: Vec<(u32, u32)>,
    /// Velocity \[m/s\], and 1 / mass \[1/kg\] in the fourth lane.
    state: Vec<f64x4>,
    /// Number of each node of the grid, [`NONE`] for those without one.
    known: Vec<u32>,
    /// Impulses of the last substep: a first guess.
    last: Vec<(Place, [f64; 3])>,
}

/// Impulses of the last substep, on their way back from bytes.
pub(crate) struct Memory(Vec<(Place, [f64; 3])>);

/// A particle and a collider.
type Place = (u32, usize);

impl Nodes {
    /// Forgets the nodes of the last substep, for a grid of so many entries.
    pub(crate) fn begin(&mut self, entries: usize) {
        for &(entry, n) in &self.place {
            if let Some(known) = self.known.get_mut(entry as usize * crate::tile::NODES + n as usize) {
                *known = NONE;
            }
        }
        self.place.clear();
        self.state.clear();
        self.known.resize(entries * crate::tile::NODES, NONE);
    }

    /// Number of a node of an entry.
    pub(crate) fn number<R: Real>(&mut self, (entry, n): (u32, u32), step: &Substep, grid: &Grid<R>) -> u32 {
        let known = &mut self.known[entry as usize * crate::tile::NODES + n as usize];
        if *known == NONE {
            *known = self.place.len() as u32;
            let [vx, vy, vz, m] = grid.nodes[entry as usize][n as usize].array().map(R::f64);
            self.place.push((entry, n));
            self.state.push(f64x4::from([vx, vy, vz, if m > step.empty { 1.0 / m } else { 0.0 }]));
        }
        *known
    }

    /// Impulse of a place in the last substep.
    pub(crate) fn guess(&self, place: Place) -> [f64; 3] {
        let found = self.last.binary_search_by_key(&place, |&(p, _)| p);
        found.map_or([0.0; 3], |i| self.last[i].1)
    }

    /// Keeps the impulses of a substep for the next.
    pub(crate) fn remember(&mut self, list: &[Touch]) {
        self.last.clear();
        self.last.extend(list.iter().map(|t| ((t.id, t.cause), t.impulse)));
        self.last.sort_unstable_by_key(|&(p, _)| p);
    }

    /// Forgets the impulses of the last substep.
    pub(crate) fn start_afresh(&mut self) {
        self.last.clear();
    }

    /// Writes what the next substep depends on.
    pub(crate) fn save(&self, sink: &mut dyn StateSink) {
        sink.u64(self.last.len() as u64);
        for &((id, cause), impulse) in &self.last {
            sink.u64(u64::from(id));
            sink.u64(cause as u64);
            sink.vec3(impulse);
        }
    }

    /// Reads what `save` wrote, for so many particles and colliders.
    pub(crate) fn load(reader: &mut StateReader, particles: u64, colliders: u64) -> Result<Memory, StateError> {
        let count = reader.u64()?;
        if count > particles * colliders {
            return Err(StateError::Count { what: "places", found: count, expected: particles * colliders });
        }
        let one = |_| Ok(((reader.u64()? as u32, reader.u64()? as usize), reader.vec3()?));
        (0..count).map(one).collect::<Result<_, StateError>>().map(Memory)
    }

    /// Goes on from what `load` read.
    pub(crate) fn resume(&mut self, memory: Memory) {
        self.last = memory.0;
    }

    /// 1 / mass of a node \[1/kg\].
    #[inline]
    pub(crate) fn inverse(&self, node: usize) -> f64 {
        self.state[node].as_array()[3]
    }

    /// Velocity at a place \[m/s\].
    #[inline]
    pub(crate) fn at(&self, touch: &Touch) -> [f64; 3] {
        let mut sum = f64x4::ZERO;
        for (&node, &weight) in touch.nodes.iter().zip(&touch.weights) {
            sum += self.state[node as usize] * f64x4::splat(weight);
        }
        let [x, y, z, _] = sum.to_array();
        [x, y, z]
    }

    /// Gives an impulse at a place.
    #[inline]
    pub(crate) fn give(&mut self, touch: &Touch, [x, y, z]: [f64; 3]) {
        let impulse = f64x4::from([x, y, z, 0.0]);
        for (&node, &weight) in touch.nodes.iter().zip(&touch.weights) {
            let state = &mut self.state[node as usize];
            *state += impulse * f64x4::splat(weight * state.as_array()[3]);
        }
    }
}
