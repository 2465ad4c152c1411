//! F-bar: volume ratios averaged over cells, for solids near incompressibility.
//!
//! Eight particles in a cell ask for eight volumes, and the grid has three numbers a node to give: where `K/μ` is large
//! a body may bend too little (it locks) and its pressure alternates from particle to particle. So the part `λ ln J` of the
//! stress becomes `λ ln J̄`,
//!
//! `ln J̄ = β Σ w θ_i + (1 - β) ln J`, `θ_i = Σ w V0 ln J / Σ w V0` over the particles of the body that are of such a material.
//!
//! For a fixed lattice this stress is the derivative of the energy `Σ V0 (λ/2) ln J ln J̄`, because the average has the
//! same weights to the nodes and back; so it makes no energy. What the average cannot see, the rest `1 - β` holds.
//! The kernel reaches over three cells, so little locks without it: Cook's membrane of ν = 0.49 bends by 0.5 % less.
//! Source: de Souza Neto et al., "Design of simple low order finite elements for large strain analysis of nearly
//! incompressible solids" (1996), with the grid's kernel in place of an element.

use crate::grid::{Substep, sum};
use crate::law::Law;
use crate::math::{Sym, all, det_minus_one, ln_1p};
use crate::parts::for_parts;
use crate::real::{Lanes, Real};
use crate::store::{Block, M, PAST, Quad, Store, VOL};
use crate::tile::{Extent, NODES, Nodes, TILE, Tile};
use crate::transfer::{average_from_tile, averages_to_tile, strain};

/// Share β of the average in the volume ratio.
const BLEND: f64 = 0.95;
/// Share of a cell's volume below which a node has no average: roundings of single precision, and far below any weight
/// that a particle gives it back.
const EMPTY: f64 = 1e-30;

/// Averages of the volume ratio at the nodes, and what each block of particles sees of them.
#[derive(Clone, Debug, Default)]
pub(crate) struct FBar<R: Real> {
    tiles: Vec<Tile<R>>,
    extents: Vec<Extent>,
    nodes: Vec<Nodes<R>>,
    ends: Vec<usize>,
}

impl<R: Real> FBar<R> {
    /// Averages of the state of now. Nothing is done where no body needs them.
    pub(crate) fn average(&mut self, step: &Substep, store: &Store<R>, laws: &[Law<R>]) {
        if laws.iter().all(|law| law.f_bar().is_none()) {
            return;
        }
        self.tiles.resize(store.blocks.len(), [R::V::default(); TILE]);
        self.extents.resize(store.blocks.len(), Extent::default());
        self.spread(step, store, laws);
        self.gather(step);
        self.read(step, store, laws);
    }

    /// What the particles of a block add to `λ ln J`, where their body needs it.
    pub(crate) fn of<'a>(&'a self, block: usize, law: &Law<R>) -> Option<Average<'a, R>> {
        let stiffness = law.f_bar()?;
        self.tiles.get(block).map(|tile| Average { tile, stiffness: all::<R>(stiffness * BLEND) })
    }

    fn spread(&mut self, step: &Substep, store: &Store<R>, laws: &[Law<R>]) {
        let cells = 1.0 / (step.dx * step.dx * step.dx);
        let mut work: Vec<_> = self.tiles.iter_mut().zip(&mut self.extents).zip(&store.blocks).collect();
        let one = |((tile, extent), block): &mut ((&mut Tile<R>, &mut Extent), &Block)| {
            if laws[block.part as usize].f_bar().is_some() {
                averages_to_tile::<R>(&store.quads[block.range()], block.live as usize, cells, tile, extent);
            } else {
                // Of a block that was in its place before.
                extent.clear::<R>(tile);
                **extent = Extent::default();
            }
        };
        for_each(step.parallel, &mut work, one);
    }

    fn gather(&mut self, step: &Substep) {
        let topology = step.topology;
        self.nodes.resize(topology.entries.len(), [R::V::default(); NODES]);
        self.ends = topology.groups.iter().skip(1).map(|&e| e as usize).collect();
        let (tiles, extents) = (&self.tiles, &self.extents);
        let mut none = vec![(); topology.group_count()];
        for_parts(step.parallel, &self.ends, &mut self.nodes, &mut none, &|g, nodes, ()| {
            let first = topology.group(g).start;
            for (i, nodes) in nodes.iter_mut().enumerate() {
                if !sum::<R>(nodes, topology, first + i, tiles, extents) {
                    continue;
                }
                for node in nodes.iter_mut() {
                    let [logs, volume, ..] = node.array();
                    let mean = if volume.f64() <= EMPTY { R::default() } else { logs / volume };
                    *node = R::V::from_array([mean, R::default(), R::default(), R::default()]);
                }
            }
        });
    }

    fn read(&mut self, step: &Substep, store: &Store<R>, laws: &[Law<R>]) {
        let (nodes, extents, topology) = (&self.nodes, &self.extents, step.topology);
        let mut work: Vec<_> = self.tiles.iter_mut().zip(&store.blocks).enumerate().collect();
        let one = |(b, (tile, block)): &mut (usize, (&mut Tile<R>, &Block))| {
            if laws[block.part as usize].f_bar().is_some() {
                extents[*b].load::<R>(tile, &topology.reached[*b], nodes);
            }
        };
        for_each(step.parallel, &mut work, one);
    }
}

fn for_each<T: Send>(parallel: bool, work: &mut [T], one: impl Fn(&mut T) + Sync + Send) {
    use rayon::prelude::*;
    if parallel { work.par_iter_mut().for_each(one) } else { work.iter_mut().for_each(one) }
}

/// The averages around one block of particles.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Average<'a, R: Real> {
    tile: &'a Tile<R>,
    /// λ β.
    stiffness: R::V,
}

impl<R: Real> Average<'_, R> {
    /// `λ (ln J̄ - ln J)` of four particles \[Pa\]; 0 in quarantine.
    #[inline]
    pub(crate) fn pressure(&self, quad: &Quad<R>, live: usize) -> R::V {
        let (own, zero) = (log_volume::<R>(&strain::<R>(quad)), R::V::default());
        let all = self.stiffness * (average_from_tile::<R>(quad, live, self.tile) - own);
        let alive = R::V::if_less(zero, quad[M], all, zero);
        R::V::if_less(quad[PAST], zero, zero, alive)
    }

    /// What it adds to the energy per volume at rest of four particles \[J/m³\].
    pub(crate) fn energy(&self, quad: &Quad<R>, live: usize) -> R::V {
        self.pressure(quad, live) * log_volume::<R>(&strain::<R>(quad)) * all::<R>(0.5)
    }
}

/// `ln J` of four strains.
#[inline]
fn log_volume<R: Real>(b: &Sym<R>) -> R::V {
    ln_1p::<R>(det_minus_one::<R>(b)) * all::<R>(0.5)
}

/// Volume of four particles in cells, 0 in quarantine, and the same times `ln J`.
#[inline]
pub(crate) fn weighted<R: Real>(quad: &Quad<R>, cells: f64) -> [R::V; 2] {
    let zero = R::V::default();
    let volume = R::V::if_less(quad[PAST], zero, zero, quad[VOL] * all::<R>(cells));
    [volume * log_volume::<R>(&strain::<R>(quad)), volume]
}
