//! The part of the domain that is computed: a box of blocks of 8 cells around smoke, solids and gas that moves.
//!
//! Beyond it air is as it is around: a side of the box that is not one of the domain is an open one, or an inlet of the
//! wind. The box follows at the start of a window, once it lacks a block or has two too many, and what comes into view
//! or leaves it is booked as external. What is neglected is the flow outside, less than `still` of the largest speed;
//! for a puff it falls as the third power of the distance, for a jet or a plume as the first.
//!
//! Blocks inside the box are all computed. In `smoke-past-plant` 21 to 28 % of the domain's blocks move less than a
//! hundredth of the largest speed beside the wind, and 8 to 17 % where a margin of a block is kept: leaving those out
//! would save less than the lists of blocks cost.

use cosplat_core::boundary::{BoundaryState, Vec3, Wrench, add, sub};
use cosplat_core::plugin::{Inputs, StateError, StateReader, StateSink};

use crate::flux::sums;
use crate::grid::Grid;
use crate::model::{Model, Partner};
use crate::sides::sides;
use crate::solids::{Filled, radius};
use crate::step::{Scratch, scaled};
use crate::store::Store;

/// Cells of a block along each axis; a domain has whole blocks.
pub(crate) const BLOCK: usize = 8;
/// Share of smoke above which a cell has some.
const TRACE: f64 = 1e-3;
/// Blocks between what is followed and the sides of the box.
const MARGIN: usize = 1;

/// Blocks of a domain, along each axis.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Part {
    pub(crate) first: [usize; 3],
    pub(crate) count: [usize; 3],
}

/// The whole domain, with what never changes in it.
#[derive(Clone, Debug)]
pub(crate) struct Whole {
    pub(crate) grid: Grid,
    pub(crate) fixed: Vec<Filled>,
    pub(crate) source: Vec<[isize; 3]>,
}

impl Part {
    /// All blocks of a grid.
    pub(crate) fn all(grid: &Grid) -> Self {
        Self { first: [0; 3], count: grid.n.map(|n| n / BLOCK) }
    }

    fn end(&self, k: usize) -> usize {
        self.first[k] + self.count[k]
    }

    /// Whether it holds another one.
    pub(crate) fn holds(&self, other: &Self) -> bool {
        (0..3).all(|k| self.first[k] <= other.first[k] && other.end(k) <= self.end(k))
    }

    /// Writes it.
    pub(crate) fn save(&self, sink: &mut dyn StateSink) {
        self.first.iter().chain(&self.count).for_each(|&n| sink.u64(n as u64));
    }

    /// Reads what `save` wrote, a part of `all`.
    pub(crate) fn load(reader: &mut StateReader<'_>, all: &Self) -> Result<Self, StateError> {
        let mut part = Self::default();
        for n in part.first.iter_mut().chain(&mut part.count) {
            *n = usize::try_from(reader.u64()?.min(u64::from(u32::MAX))).unwrap_or_default();
        }
        if part.count.contains(&0) || !all.holds(&part) {
            let [found, expected] = [&part, all].map(|p| p.count.iter().product::<usize>() as u64);
            return Err(StateError::Count { what: "blocks of the domain", found, expected });
        }
        Ok(part)
    }

    /// Cells between the first ones of two parts.
    fn shift(&self, from: &Self) -> [isize; 3] {
        [0, 1, 2].map(|k| (self.first[k] as isize - from.first[k] as isize) * BLOCK as isize)
    }
}

/// First and last block that is needed along each axis.
#[derive(Clone, Copy, Debug)]
struct Needed {
    low: [usize; 3],
    high: [usize; 3],
}

impl Needed {
    fn block(&mut self, at: [usize; 3]) {
        for (k, at) in at.into_iter().enumerate() {
            self.low[k] = self.low[k].min(at);
            self.high[k] = self.high[k].max(at);
        }
    }

    /// What is within a box of corners \[m\]; nothing where it lies outside the domain.
    fn space(&mut self, grid: &Grid, low: Vec3, high: Vec3) {
        let top = grid.high();
        if (0..3).all(|k| high[k] >= grid.low[k] && low[k] <= top[k]) {
            for x in [low, high] {
                self.block([0, 1, 2].map(|k| {
                    let cell = ((x[k] - grid.low[k]) / grid.h).clamp(0.0, grid.n[k] as f64 - 0.5);
                    cell as usize / BLOCK
                }));
            }
        }
    }

    /// With a margin, inside the domain; none where nothing is needed.
    fn part(&self, all: &Part) -> Option<Part> {
        let low = self.low.map(|low| low.saturating_sub(MARGIN));
        let end = [0, 1, 2].map(|k| (self.high[k] + 1 + MARGIN).min(all.count[k]));
        (0..3)
            .all(|k| self.low[k] <= self.high[k])
            .then(|| Part { first: low, count: [0, 1, 2].map(|k| end[k] - low[k]) })
    }
}

impl Model {
    /// Computes that part of the domain from now on.
    pub(crate) fn show(&mut self, part: Part) {
        let whole = &self.whole;
        let first = part.first.map(|b| (b * BLOCK) as f64 * whole.grid.h);
        let grid = Grid::new(add(whole.grid.low, first), part.count.map(|c| c * BLOCK), whole.grid.h);
        let all = Part::all(&whole.grid);
        let at_side = |k: usize, end: usize| if end == 0 { part.first[k] == 0 } else { part.end(k) == all.count[k] };
        let open = [0, 1, 2].map(|k| [0, 1].map(|end| self.params.open[k][end] || !at_side(k, end)));
        let wind = self.wind.iter().fold([0.0; 3], |sum, w| add(sum, w.value));
        let shift = part.shift(&all);
        let moved = |cell: [isize; 3]| [0, 1, 2].map(|k| cell[k] - shift[k]);
        let n = grid.n.map(|n| n as isize);
        let inside = |a: usize, c: [isize; 3]| (0..3).all(|k| (0..n[k] + isize::from(k == a)).contains(&c[k]));
        self.fixed.clone_from(&whole.fixed);
        for solid in &mut self.fixed {
            let faces = solid.faces.iter().map(|&(a, cell)| (a, moved(cell)));
            solid.faces = faces.filter(|&(a, cell)| inside(a, cell)).collect();
        }
        let source = whole.source.iter().map(|&cell| moved(cell)).filter(|&cell| inside(3, cell));
        self.source = source.map(|cell| grid.at(cell)).collect();
        (self.grid, self.sides, self.part) = (grid, sides(open, wind), part);
    }

    /// What has to be computed at time `t` \[s\].
    fn needed(&self, store: &Store, inputs: &Inputs, t: f64) -> Needed {
        let (grid, whole) = (&self.grid, &self.whole.grid);
        let mut needed = Needed { low: [usize::MAX; 3], high: [0; 3] };
        for &cell in &self.whole.source {
            needed.block(cell.map(|c| c as usize / BLOCK));
        }
        for &x in &store.x[..self.born(t)] {
            needed.space(whole, x, x);
        }
        for face in &self.partners {
            let shown = inputs.partner(face.interface).map(|p| &p.now);
            match (&face.partner, shown) {
                (Partner::Rigid(shape), Some(BoundaryState::Proxy(record))) => {
                    let r = [radius(shape).unwrap_or(f64::INFINITY); 3];
                    needed.space(whole, sub(record.position, r), add(record.position, r));
                }
                (Partner::Samples, Some(BoundaryState::Samples(samples))) => {
                    samples.position.iter().for_each(|&x| needed.space(whole, x, x));
                }
                _ => {}
            }
        }
        let ambient = self.ambient(t);
        let off = |a: usize, at: usize| (store.u[a][at] - ambient[a]).abs();
        let fastest = store.u.iter().flatten().fold(0.0_f64, |m, v| m.max(v.abs()));
        let still = self.params.still * fastest;
        for z in 0..grid.n[2] {
            for y in 0..grid.n[1] {
                let row = grid.at([0, y as isize, z as isize]);
                for block in 0..self.part.count[0] {
                    let mut cells = row + block * BLOCK..row + (block + 1) * BLOCK;
                    if cells.any(|at| store.c[at] > TRACE || (0..3).any(|a| off(a, at) > still)) {
                        let here = [block, y / BLOCK, z / BLOCK];
                        needed.block([0, 1, 2].map(|k| self.part.first[k] + here[k]));
                    }
                }
            }
        }
        needed
    }
}

/// Moves the box where it has to; the momentum of gas that came into view, less that of what left it, about the origin.
pub(crate) fn follow(model: &mut Model, store: &mut Store, scratch: &mut Scratch, inputs: &Inputs, t: f64) -> Wrench {
    let all = Part::all(&model.whole.grid);
    let Some(wanted) = model.needed(store, inputs, t).part(&all).filter(|_| model.params.still > 0.0) else {
        return Wrench::default();
    };
    let now = model.part;
    if now.holds(&wanted) && (0..3).all(|k| now.count[k] < wanted.count[k] + 2) {
        return Wrench::default();
    }
    let mass = model.cell_mass();
    let before = sums(&model.grid, model.sides, &store.u).0;
    let old = model.grid;
    model.show(wanted);
    let grid = &model.grid;
    *scratch = Scratch::new(grid);
    let mut moved = Store::new(grid, scratch.pressures(), std::mem::take(&mut store.x));
    for (u, v) in moved.u.iter_mut().zip(model.ambient(t)) {
        u.fill(v);
    }
    let shift = wanted.shift(&now);
    let levels = |grid: &Grid| [1, grid.n[0] + 2, (grid.n[0] + 2) * (grid.n[1] + 2)];
    let level = |grid: &Grid, c: [isize; 3]| (0..3).map(|k| (c[k] + 1) as usize * levels(grid)[k]).sum::<usize>();
    let n = grid.n.map(|n| n as isize);
    for z in 0..=n[2] {
        for y in 0..=n[1] {
            for x in 0..=n[0] {
                let cell = [x, y, z];
                let from = [0, 1, 2].map(|k| cell[k] + shift[k]);
                let both = |k: usize, upper: isize| {
                    cell[k] < n[k] + upper && (0..old.n[k] as isize + upper).contains(&from[k])
                };
                let (to, at) = (grid.at(cell), from.map(|c| c.max(-1)));
                for a in (0..3).filter(|&a| (0..3).all(|k| both(k, isize::from(k == a)))) {
                    moved.u[a][to] = store.u[a][old.at(at)];
                }
                if (0..3).all(|k| both(k, 0)) {
                    moved.c[to] = store.c[old.at(at)];
                    moved.pressure[level(grid, cell)] = store.pressure[level(&old, at)];
                }
            }
        }
    }
    *store = moved;
    scaled(sums(grid, model.sides, &store.u).0.minus(before), mass)
}
