//! A partner that shows samples: which of them each vertex can meet, and where they are.
//!
//! A sample is a small disc, piece of thread or bead (`facet`) as thick as its particle, and is met from either side
//! (`side`). It moves as the partner said, and by the impulses it has taken in this window at its own mass, so that a
//! light body gives way.

use cosplat_core::boundary::{SampleStatics, Samples, Vec3, add, dot, norm, scale, sub};
use cosplat_core::plugin::PartnerInput;
use rayon::prelude::*;

use crate::cells::Cells;
use crate::facet::{Facet, NEIGHBOURS};
use crate::list::{List, inside, within};
use crate::side::{Side, THROUGH};

/// Width of a sample that has neither an area nor a volume \[m\].
const NO_WIDTH: f64 = 1e-3;

/// Widths within which two samples may be of one surface.
const JOINED: f64 = 2.5;
/// Distance up to which a side is remembered, over that of touching surfaces: nothing moves further between two looks.
const REMEMBERED: f64 = 2.0;

/// What never changes about a partner's samples.
#[derive(Clone, Debug, Default)]
pub(crate) struct Marks {
    /// Distance of the surface from the sample \[m\].
    radius: Vec<f64>,
    /// Width of the patch that it stands for \[m\].
    width: Vec<f64>,
    /// 1 / mass \[1/kg\].
    inverse: Vec<f64>,
    /// Greatest width \[m\].
    widest: f64,
}

impl Marks {
    /// From what a partner said; nothing where a sample has no mass.
    pub(crate) fn new(statics: &SampleStatics) -> Option<Self> {
        if !statics.mass_kg.iter().all(|m| m.is_finite() && *m > 0.0) {
            return None;
        }
        let radius: Vec<f64> = statics.volume_m3.iter().map(|&v| 0.5 * libm::cbrt(v.max(0.0))).collect();
        let width = |(&area, &radius): (&f64, &f64)| match area.max(0.0).sqrt().max(2.0 * radius) {
            none if none <= 0.0 => NO_WIDTH,
            width => width,
        };
        let width: Vec<f64> = statics.area_m2.iter().zip(&radius).map(width).collect();
        let inverse = statics.mass_kg.iter().map(|m| 1.0 / m).collect();
        let widest = width.iter().copied().fold(0.0, f64::max);
        Some(Self { radius, width, inverse, widest })
    }

    /// How far apart points of a cloth may be for none of the samples to come through between them, where surfaces keep
    /// `half` \[m\] from the cloth's middle: the mean width, and so close that no bead fits between four of them.
    pub(crate) fn mesh(&self, half: f64) -> f64 {
        let mean = |all: &[f64]| all.iter().sum::<f64>() / all.len().max(1) as f64;
        let bead = std::f64::consts::SQRT_2 * (mean(&self.radius) + half);
        mean(&self.width).min(if bead > 0.0 { bead } else { f64::INFINITY })
    }

    /// Least distance of surfaces from the middle of a sample \[m\].
    pub(crate) fn thinnest(&self) -> f64 {
        self.radius.iter().copied().fold(f64::INFINITY, f64::min)
    }

    /// Number of samples.
    pub(crate) fn len(&self) -> usize {
        self.radius.len()
    }
}

/// Samples of a partner over one window.
#[derive(Clone, Debug)]
pub(crate) struct Swarm<'a> {
    marks: &'a Marks,
    path: Vec<[Vec3; 4]>,
    /// Displacement and velocity by the impulses of this window \[m, m/s\].
    moved: Vec<[Vec3; 2]>,
    /// Position and velocity in this substep.
    now: Vec<[Vec3; 2]>,
    /// Impulses on the samples \[N s\].
    pub(crate) impulse: Vec<Vec3>,
    /// Samples that each point of a cloth can meet in this window.
    pub(crate) list: List,
    /// Samples that move: those in the list, and those that cloth is attached to.
    active: Vec<u32>,
    /// Of the samples that have been met in this window.
    facets: Vec<Option<Facet>>,
    /// Where samples were at its start, sorted once somebody is near.
    start: &'a [Vec3],
    cells: Option<Cells>,
    /// Of each point of a cloth.
    pub(crate) sides: Vec<Option<Side>>,
    /// Points that have gone through a sample.
    pub(crate) pierced: u64,
    /// Largest speed of a sample \[m/s\], where the cloth is near at all.
    pub(crate) fastest: Option<f64>,
}

impl<'a> Swarm<'a> {
    /// Looks for the samples that each vertex, or point of a triangle, can meet: places at `points` \[m\] in a window in
    /// which they and the samples move towards each other by `way` \[m\], surfaces `thickness` \[m\] from each other.
    pub(crate) fn new(
        marks: &'a Marks,
        (samples, input): (&'a Samples, &PartnerInput),
        points: &[Vec3],
        [way, thickness]: [f64; 2],
        (mut list, mut sides): (List, Vec<Option<Side>>),
    ) -> Self {
        let all = &samples.position;
        let reach = thickness + 2.0 * marks.widest;
        list.renew(points, all, (reach, way, marks.widest));
        let inside = inside(all, reach + way);
        let fastest = samples.velocity.iter().map(|&v| norm(v)).fold(0.0, f64::max);
        sides.resize(points.len(), None);
        sides.iter_mut().enumerate().filter(|(i, _)| list.of(*i).is_empty()).for_each(|(_, side)| *side = None);
        Self {
            marks,
            path: (0..all.len()).map(|i| input.path(i)).collect(),
            moved: vec![[[0.0; 3]; 2]; all.len()],
            now: vec![[[0.0; 3]; 2]; all.len()],
            impulse: vec![[0.0; 3]; all.len()],
            active: list.active.clone(),
            list,
            facets: vec![None; all.len()],
            start: all,
            cells: None,
            sides,
            pierced: 0,
            fastest: points.iter().any(|&x| inside(x)).then_some(fastest),
        }
    }

    /// Moves on to `t` \[s\] from the start of the window.
    pub(crate) fn at(&mut self, t: f64) {
        for &i in &self.active {
            let ([a, b, c, d], [moved, v]) = (self.path[i as usize], self.moved[i as usize]);
            let x = add(add(a, moved), scale(add(b, scale(add(c, scale(d, t)), t)), t));
            let u = add(v, add(b, scale(add(scale(c, 2.0), scale(d, 3.0 * t)), t)));
            self.now[i as usize] = [x, u];
        }
    }

    /// Moves the samples by what they have taken.
    pub(crate) fn drift(&mut self, h: f64) {
        for &i in &self.active {
            let [x, v] = &mut self.moved[i as usize];
            *x = add(*x, scale(*v, h));
        }
    }

    /// Points of a cloth that can meet a sample in this window.
    pub(crate) fn points(&self) -> &[u32] {
        &self.list.points
    }

    /// Distance of the middle of a cloth from that of a sample at which the thinnest of them touch \[m\].
    pub(crate) fn thinnest(&self, half: f64) -> f64 {
        self.marks.thinnest() + half
    }

    /// Finds the nearest sample of each point of a cloth and its side of it, for points at `position` \[m\] and surfaces
    /// that keep `half` \[m\] from the middle of the cloth.
    pub(crate) fn look(&mut self, position: impl Fn(usize) -> Vec3 + Sync, half: f64, parallel: bool) {
        let nearest = each(parallel, &self.list.points, |&p| self.nearest(p as usize, position(p as usize), half));
        let found: Vec<(usize, u32)> =
            self.list.points.iter().zip(nearest).filter_map(|(&p, i)| Some((p as usize, i?))).collect();
        self.learn(&found, parallel);
        let sides = each(parallel, &found, |&(p, i)| self.side(p, i, position(p), half));
        let mut all = vec![None; self.sides.len()];
        for (&(p, _), side) in found.iter().zip(sides) {
            let was_beyond = self.sides[p].is_some_and(|s| s.beyond);
            self.pierced += u64::from(side.is_some_and(|s| s.beyond) && !was_beyond);
            all[p] = side;
        }
        self.sides = all;
    }

    /// Finds out how samples lie that have not been met before.
    fn learn(&mut self, found: &[(usize, u32)], parallel: bool) {
        let mut new: Vec<u32> = found.iter().map(|(_, i)| *i).filter(|&i| self.facets[i as usize].is_none()).collect();
        new.sort_unstable();
        new.dedup();
        if new.is_empty() {
            return;
        }
        let (all, widest) = (self.start, self.marks.widest);
        let cells = self.cells.get_or_insert_with(|| Cells::new(all, NEIGHBOURS * widest));
        let cells = &*cells;
        let facets = each(parallel, &new, |&i| {
            let mut around = Vec::new();
            let radius = NEIGHBOURS * self.marks.width[i as usize];
            within(cells, all, (all[i as usize], radius), |k| around.push(all[k as usize]));
            Facet::of(&around)
        });
        new.iter().zip(facets).for_each(|(&i, facet)| self.facets[i as usize] = Some(facet));
    }

    /// Nearest sample of a point of a cloth at `x`, where it can be touched.
    fn nearest(&self, place: usize, x: Vec3, half: f64) -> Option<u32> {
        let square = |i: u32| {
            let d = sub(x, self.now[i as usize][0]);
            dot(d, d)
        };
        let all = self.list.of(place).iter().map(|&i| (square(i), i));
        let (square, i) = all.min_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)))?;
        let reach = REMEMBERED * (self.marks.radius[i as usize] + half) + self.marks.width[i as usize];
        (square <= reach * reach).then_some(i)
    }

    /// Side of a point of a cloth at `x` whose nearest sample is known.
    fn side(&self, place: usize, sample: u32, x: Vec3, half: f64) -> Option<Side> {
        let i = sample as usize;
        let (facet, touching) = (self.facets[i].unwrap_or_default(), self.marks.radius[i] + half);
        let off = facet.away(sub(x, self.now[i][0]), self.marks.width[i]);
        let apart = norm(off);
        if apart > REMEMBERED * touching {
            return None;
        }
        let before = self.sides[place].filter(|side| self.joined(sample, side.sample));
        let out = match before {
            _ if apart > 0.0 => scale(off, 1.0 / apart),
            Some(side) => facet.facing(side.out),
            None => facet.facing([0.0, 0.0, 1.0]),
        };
        Some(match before {
            Some(side) if dot(out, side.out) < THROUGH => {
                Side { sample, out: facet.facing(side.out), gap: -apart - touching, beyond: true }
            }
            _ => Side { sample, out, gap: apart - touching, beyond: false },
        })
    }

    /// Whether what is remembered of one sample holds for another.
    fn joined(&self, i: u32, j: u32) -> bool {
        let d = sub(self.now[j as usize][0], self.now[i as usize][0]);
        i == j
            || (norm(d) < JOINED * self.marks.width[i as usize] && self.facets[i as usize].is_none_or(|f| f.goes_on(d)))
    }

    /// Position and velocity of a sample \[m, m/s\].
    pub(crate) fn state(&self, sample: u32) -> (Vec3, Vec3) {
        let [x, u] = self.now[sample as usize];
        (x, u)
    }

    /// Also follows samples that cloth is attached to.
    pub(crate) fn follow(&mut self, samples: impl Iterator<Item = u32>) {
        self.active.extend(samples);
        self.active.sort_unstable();
        self.active.dedup();
    }

    /// Velocity of a sample \[m/s\].
    pub(crate) fn velocity(&self, sample: u32) -> Vec3 {
        self.now[sample as usize][1]
    }

    /// 1 / mass of a sample \[1/kg\].
    pub(crate) fn inverse(&self, sample: u32) -> f64 {
        self.marks.inverse[sample as usize]
    }

    /// Gives a sample an impulse \[N s\].
    pub(crate) fn take(&mut self, sample: u32, impulse: Vec3) {
        let i = sample as usize;
        let change = scale(impulse, self.marks.inverse[i]);
        self.now[i][1] = add(self.now[i][1], change);
        self.moved[i][1] = add(self.moved[i][1], change);
        self.impulse[i] = add(self.impulse[i], impulse);
    }
}

/// What `f` says of each item, on one thread or several.
fn each<T: Sync, R: Send>(parallel: bool, items: &[T], f: impl Fn(&T) -> R + Sync + Send) -> Vec<R> {
    if parallel { items.par_iter().with_min_len(256).map(f).collect() } else { items.iter().map(f).collect() }
}
