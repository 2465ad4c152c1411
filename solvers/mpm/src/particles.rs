//! The particles' half of a substep: to the tiles, back from the grid, strain, plastic flow.

use rayon::prelude::*;

use crate::fbar::FBar;
use crate::grid::{Grid, Substep};
use crate::law::{Law, Room, STRETCH};
use crate::math::{Full, all, det_minus_one};
use crate::parts::for_parts;
use crate::quarantine::released;
use crate::real::{Lanes, Real};
use crate::store::{B, Block, C, M, PAST, Quad, Store, V, VOL, X, XLO};
use crate::tile::{Extent, TILE, Tile};
use crate::transfer::{from_tile, gradient, strain, to_tile};

/// What one block says after a substep.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct BlockOut {
    /// Largest speed, squared \[m²/s²\]; not finite when any particle is not.
    pub(crate) speed: f64,
    /// Largest Frobenius norm of the velocity gradient, squared \[1/s²\].
    pub(crate) rate: f64,
    /// A particle is about to leave the tile.
    pub(crate) strayed: bool,
    /// Particles whose stretch was clamped.
    pub(crate) clamped: u64,
    /// Energy lost to plastic flow and viscosity \[J\].
    pub(crate) lost: f64,
}

/// Tiles of all blocks.
#[derive(Clone, Debug, Default)]
pub(crate) struct Tiles<R: Real> {
    pub(crate) list: Vec<Tile<R>>,
    /// The same without stress, for bodies that remember; else empty.
    pub(crate) before: Vec<Tile<R>>,
    pub(crate) extents: Vec<Extent>,
    pub(crate) out: Vec<BlockOut>,
    ends: Vec<usize>,
}

impl<R: Real> Tiles<R> {
    /// Room for a store's blocks.
    pub(crate) fn prepare(&mut self, store: &Store<R>, remembers: bool) {
        let blocks = store.blocks.len();
        self.list.resize(blocks, [R::V::default(); TILE]);
        self.before.resize(if remembers { blocks } else { 0 }, [R::V::default(); TILE]);
        self.extents.resize(blocks, Extent::default());
        self.out = vec![BlockOut::default(); blocks];
        self.ends = store.blocks.iter().map(|b| b.range().end).collect();
    }

    /// Particles to tiles. `keeps` says by body which also fill the tiles without stress.
    pub(crate) fn fill(
        &mut self,
        step: &Substep,
        store: &Store<R>,
        (laws, f_bar): (&[Law<R>], &FBar<R>),
        keeps: &[f64],
    ) {
        let before = remembered::<R>(&mut self.before, &store.blocks, keeps);
        let tiles = self.list.iter_mut().zip(&mut self.extents).zip(before);
        let mut work: Vec<_> = tiles.zip(store.blocks.iter().enumerate()).collect();
        let fill = |work: &mut Filled<R>| {
            let (((tile, extent), before), (b, block)) = work;
            let (quads, live, law) = (&store.quads[block.range()], block.live as usize, &laws[block.part as usize]);
            let average = f_bar.of(*b, law);
            to_tile::<R>(quads, live, (law, average), (step.dt, step.dx), (tile, before.as_deref_mut()), extent);
        };
        if step.parallel { work.par_iter_mut().for_each(fill) } else { work.iter_mut().for_each(fill) }
    }

    /// Grid to particles.
    pub(crate) fn empty(
        &mut self,
        step: &Substep,
        grid: &Grid<R>,
        store: &mut Store<R>,
        laws: &[Law<R>],
        keeps: &[f64],
    ) {
        let blocks = &store.blocks;
        let before = remembered::<R>(&mut self.before, blocks, keeps);
        let mut work: Vec<_> = self.list.iter_mut().zip(&mut self.out).zip(before).collect();
        let extents = &self.extents;
        for_parts(step.parallel, &self.ends, &mut store.quads, &mut work, &|b, quads, ((tile, out), before)| {
            let reached = &step.topology.reached[b];
            extents[b].load::<R>(tile, reached, &grid.nodes);
            let before = before.as_deref_mut().map(|before| {
                extents[b].load::<R>(before, reached, &grid.before);
                (&*before, all::<R>(libm::exp(-step.dt / keeps[blocks[b].body as usize])))
            });
            **out = advance(quads, blocks[b].live as usize, step, (tile, before), &laws[blocks[b].part as usize]);
        });
    }

    /// `F ← (I + dt C) F` for bodies that carry total deformation gradients.
    pub(crate) fn carry(&self, step: &Substep, store: &mut Store<R>, carries: &[bool]) {
        if store.grads.is_empty() {
            return;
        }
        let (blocks, quads, dt) = (&store.blocks, &store.quads, all::<R>(step.dt));
        let mut none = vec![(); blocks.len()];
        for_parts(step.parallel, &self.ends, &mut store.grads, &mut none, &|b, grads, ()| {
            if !carries[blocks[b].body as usize] {
                return;
            }
            for (f, quad) in grads.iter_mut().zip(&quads[blocks[b].range()]) {
                let (c, old, zero) = (gradient::<R>(quad), *f, R::V::default());
                // What is in quarantine keeps its deformation.
                let dt = R::V::if_less(quad[PAST], zero, zero, dt);
                for i in 0..3 {
                    for j in 0..3 {
                        f[3 * i + j] += dt * (c[i][0] * old[j] + c[i][1] * old[3 + j] + c[i][2] * old[6 + j]);
                    }
                }
            }
        });
    }
}

/// A tile and its extent, the tile without stress, and the block whose particles fill them.
type Filled<'a, R> = (((&'a mut Tile<R>, &'a mut Extent), Option<&'a mut Tile<R>>), (usize, &'a Block));

/// What particles remember: their tile without stress, and the share of it.
type Before<'a, R> = (&'a Tile<R>, <R as Real>::V);

/// By block, the tile without stress where its body remembers.
fn remembered<'a, R: Real>(tiles: &'a mut [Tile<R>], blocks: &[Block], keeps: &[f64]) -> Vec<Option<&'a mut Tile<R>>> {
    let mut tiles = tiles.iter_mut();
    let one = |block: &Block| tiles.next().filter(|_| keeps[block.body as usize] > 0.0);
    blocks.iter().map(one).collect()
}

fn advance<R: Real>(
    quads: &mut [Quad<R>],
    live: usize,
    step: &Substep,
    (tile, before): (&Tile<R>, Option<Before<R>>),
    law: &Law<R>,
) -> BlockOut {
    let (dt, move_by) = (all::<R>(step.dt), all::<R>(step.dt / step.dx));
    let zero = R::V::default();
    let (mut speed, mut rate, mut sum) = (zero, zero, zero);
    let (mut low, mut high) = (all::<R>(1.0), all::<R>(1.0));
    let (mut clamped, mut lost) = (0, 0.0);
    let smallest = all::<R>(STRETCH[0].powi(6) - 1.0);
    let largest = R::of(3.0 * (STRETCH[1] * STRETCH[1] - 1.0));
    for (i, quad) in quads.iter_mut().enumerate() {
        let (mut v, c, mass) = from_tile::<R>(quad, live - 4 * i, 1.0 / step.dx, tile);
        let mut kept = c;
        if let Some((before, share)) = before {
            remember::<R>(quad, live - 4 * i, step, (before, share), (&mut v, &mut kept));
        }
        for k in 0..3 {
            quad[V + k] = v[k];
            quad[C + 3 * k..C + 3 * k + 3].copy_from_slice(&kept[k]);
            // Kahan's sum.
            let (x, change) = (quad[X + k], v[k] * move_by - quad[XLO + k]);
            let new = x + change;
            quad[XLO + k] = (new - x) - change;
            quad[X + k] = new;
            (low, high) = (low.min(new), high.max(new));
        }
        let mut b = {
            let row = |i: usize| [c[i][0] * dt, c[i][1] * dt, c[i][2] * dt];
            released::<R>(quad, law.moved(&[row(0), row(1), row(2)], &strain::<R>(quad)))
        };
        let past = quad[PAST];
        if let Some(new) = law.flow(&b, past, &room::<R>(quad, mass, step, law)) {
            give::<R>(quad, step.dx, R::V::if_less(past, zero, zero, new.put));
            // What is in quarantine does not flow.
            let on = |old: R::V, new: R::V| R::V::if_less(past, zero, old, new);
            b = [0, 1, 2, 3, 4, 5].map(|k| on(b[k], new.b[k]));
            quad[PAST] = on(past, new.past);
            lost += total::<R>(on(zero, new.lost) * quad[VOL]);
        }
        if let Some(power) = law.heat(&b, &c) {
            lost += total::<R>(power * dt * quad[VOL]);
        }
        let det = det_minus_one::<R>(&b);
        let trace = (b[0] + b[1] + b[2]).array();
        if R::V::if_less(smallest, det, zero, all::<R>(1.0)).array() != [R::default(); 4]
            || trace.iter().any(|&t| t > largest)
        {
            let (new, count) = Law::<R>::clamp(&b, quad[VOL]);
            (b, clamped) = (new, clamped + count);
        }
        quad[B..B + 6].copy_from_slice(&b);
        let v2 = v[0] * v[0] + v[1] * v[1] + v[2] * v[2];
        let c2 = c.iter().flatten().fold(zero, |s, c| s + *c * *c);
        (speed, rate, sum) = (speed.max(v2), rate.max(c2), sum + v2 + c2 + det);
    }
    let most = |v: R::V| v.array().iter().fold(0.0, |a: f64, b| a.max(b.f64()));
    let finite = sum.array().iter().all(|s| s.finite());
    let (first, last) = (low.array(), high.array());
    BlockOut {
        speed: if finite { most(speed) } else { f64::NAN },
        rate: most(rate),
        strayed: first.iter().any(|&x| x < R::of(-0.5)) || last.iter().any(|&x| x >= R::of(5.5)),
        clamped,
        lost,
    }
}

/// Adds what the particles' own motion had beside that of the grid, as far as they remember it: `share` of it.
///
/// Alone, a transfer to the grid and back loses it in every substep, and the more of them the more is lost. Of the
/// gradient only the spin is kept: so momentum and its moment stay what they were, and strain and viscosity see the grid
/// alone. Source: Fei et al., "Revisiting integration in the material point method" (2021), AFLIP with a share that
/// depends on the length of the substep, and with its moment.
#[inline]
fn remember<R: Real>(
    quad: &Quad<R>,
    live: usize,
    step: &Substep,
    (before, share): Before<R>,
    (v, c): (&mut [R::V; 3], &mut Full<R>),
) {
    let (v0, c0, _) = from_tile::<R>(quad, live, 1.0 / step.dx, before);
    let old = gradient::<R>(quad);
    let half = share * all::<R>(0.5);
    for i in 0..3 {
        v[i] += share * (quad[V + i] - v0[i]);
        for j in 0..3 {
            c[i][j] += half * ((old[i][j] - old[j][i]) - (c0[i][j] - c0[j][i]));
        }
    }
}

/// What the grid shows around four particles in a cell of that mass.
#[inline]
fn room<R: Real>(quad: &Quad<R>, mass: R::V, step: &Substep, law: &Law<R>) -> Room<R> {
    let (zero, one) = (R::V::default(), all::<R>(1.0));
    if !law.flows() {
        return Room { space: one, way: zero, dt: step.dt, gives: zero };
    }
    // A dead lane has neither mass nor volume: it has room.
    let alive = |v: R::V, other: R::V| R::V::if_less(zero, quad[M], v, other);
    let (m, volume, mass) = (alive(quad[M], one), alive(quad[VOL], one), alive(mass, one));
    let cell = all::<R>(step.dx * step.dx * step.dx);
    let sound = (all::<R>(law.stiffness()) * volume / m).sqrt();
    let gives = straining::<R>(quad, step.dx) * alive(quad[M] / volume, zero);
    Room { space: alive(m / volume * cell / mass, one), way: sound * all::<R>(step.dt / step.dx), dt: step.dt, gives }
}

/// Kinetic energy of the straining part of the particles' own motion, over their mass \[J/kg\]: `(dx²/8) |sym C|²`.
#[inline]
fn straining<R: Real>(quad: &Quad<R>, dx: f64) -> R::V {
    let (c, half) = (gradient::<R>(quad), all::<R>(0.5));
    let across = |i: usize, j: usize| (c[i][j] + c[j][i]) * half;
    let [xy, xz, yz] = [across(0, 1), across(0, 2), across(1, 2)];
    let sides = c[0][0] * c[0][0] + c[1][1] * c[1][1] + c[2][2] * c[2][2];
    (sides + (xy * xy + xz * xz + yz * yz) * all::<R>(2.0)) * all::<R>(dx * dx / 8.0)
}

/// Takes that energy per volume at rest \[J/m³\] from the straining part of the motion, which has neither momentum nor
/// moment: what the correction of a volume ratio puts in comes from nowhere else.
#[inline]
fn give<R: Real>(quad: &mut Quad<R>, dx: f64, energy: R::V) {
    let zero = R::V::default();
    if energy.array() == [R::default(); 4] {
        return;
    }
    let has = straining::<R>(quad, dx) * quad[M] / quad[VOL].max(all::<R>(1e-30));
    let left = (has - energy).max(zero) / has.max(all::<R>(1e-30));
    let slower = R::V::if_less(zero, energy, all::<R>(1.0) - left.sqrt(), zero) * all::<R>(0.5);
    let c = gradient::<R>(quad);
    for i in 0..3 {
        for j in 0..3 {
            quad[C + 3 * i + j] = c[i][j] - slower * (c[i][j] + c[j][i]);
        }
    }
}

fn total<R: Real>(v: R::V) -> f64 {
    v.array().iter().map(|e| e.f64()).sum()
}
