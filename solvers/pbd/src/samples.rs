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
    /// Samples that each point of a cloth can meet in this window: where its list begins, and the lists.
    begin: Vec<u32>,
    near: Vec<u32>,
    /// Points with a list.
    points: Vec<u32>,
    /// Samples in any of the lists.
    active: Vec<u32>,
    /// Of the samples in the lists.
    facets: Vec<Facet>,
    /// Of each point of a cloth.
    pub(crate) sides: Vec<Option<Side>>,
    /// Points that have gone through a sample.
    pub(crate) pierced: u64,
    /// Largest speed of a sample \[m/s\].
    pub(crate) fastest: f64,
}

impl<'a> Swarm<'a> {
    /// Looks for the samples that each vertex, or point of a triangle, can meet; `reach` is how far it may move towards
    /// them \[m\], `sides` what is remembered of each.
    pub(crate) fn new(
        marks: &'a Marks,
        (samples, input): (&Samples, &PartnerInput),
        places: impl Iterator<Item = Option<Vec3>>,
        reach: f64,
        mut sides: Vec<Option<Side>>,
    ) -> Self {
        let all = &samples.position;
        let reach = reach + 2.0 * marks.widest;
        let fold = |f: fn(f64, f64) -> f64, start: f64| [0, 1, 2].map(|k| all.iter().map(|x| x[k]).fold(start, f));
        let (low, high) = (fold(f64::min, f64::INFINITY), fold(f64::max, f64::NEG_INFINITY));
        let inside = |x: &Vec3| (0..3).all(|k| x[k] > low[k] - reach && x[k] < high[k] + reach);
        // Sorted only once somebody is there.
        let mut cells = None;
        let (mut begin, mut near, mut points) = (vec![0], Vec::new(), Vec::new());
        for (place, x) in (0..).zip(places) {
            if let Some(x) = x.filter(inside) {
                let cells = cells.get_or_insert_with(|| Cells::new(all, reach));
                within(cells, all, (x, reach), |i| near.push(i));
            }
            if begin.last().is_some_and(|&b| near.len() > b as usize) {
                points.push(place);
            }
            begin.push(near.len() as u32);
        }
        let mut active = near.clone();
        active.sort_unstable();
        active.dedup();
        let mut facets = vec![Facet::Bead; all.len()];
        if let Some(cells) = &cells {
            let mut around = Vec::new();
            for &i in &active {
                around.clear();
                let radius = NEIGHBOURS * marks.width[i as usize];
                within(cells, all, (all[i as usize], radius), |k| around.push(all[k as usize]));
                facets[i as usize] = Facet::of(&around);
            }
        }
        sides.resize(begin.len() - 1, None);
        let alone = |place: usize| begin[place] == begin[place + 1];
        sides.iter_mut().enumerate().filter(|(place, _)| alone(*place)).for_each(|(_, side)| *side = None);
        Self {
            marks,
            path: (0..all.len()).map(|i| input.path(i)).collect(),
            moved: vec![[[0.0; 3]; 2]; all.len()],
            now: vec![[[0.0; 3]; 2]; all.len()],
            impulse: vec![[0.0; 3]; all.len()],
            begin,
            near,
            points,
            active,
            facets,
            sides,
            pierced: 0,
            fastest: samples.velocity.iter().map(|&v| norm(v)).fold(0.0, f64::max),
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
        &self.points
    }

    /// Distance of the middle of a cloth from that of a sample at which the thinnest of them touch \[m\].
    pub(crate) fn thinnest(&self, half: f64) -> f64 {
        self.marks.thinnest() + half
    }

    /// Finds the nearest sample of each point of a cloth and its side of it, for points at `position` \[m\] and surfaces
    /// that keep `half` \[m\] from the middle of the cloth.
    pub(crate) fn look(&mut self, position: impl Fn(usize) -> Vec3 + Sync, half: f64, parallel: bool) {
        let this = &*self;
        let one = |&place: &u32| this.side(place as usize, position(place as usize), half);
        let sides: Vec<Option<Side>> = if parallel {
            self.points.par_iter().with_min_len(256).map(one).collect()
        } else {
            self.points.iter().map(one).collect()
        };
        for (&place, side) in self.points.iter().zip(sides) {
            let before = std::mem::replace(&mut self.sides[place as usize], side);
            let was_beyond = before.is_some_and(|s| s.beyond);
            self.pierced += u64::from(side.is_some_and(|s| s.beyond) && !was_beyond);
        }
    }

    /// Side of a point of a cloth at `x`.
    fn side(&self, place: usize, x: Vec3, half: f64) -> Option<Side> {
        let list = &self.near[self.begin[place] as usize..self.begin[place + 1] as usize];
        let away = |i: u32| sub(x, self.now[i as usize][0]);
        let square = |i: u32| dot(away(i), away(i));
        let &sample = list.iter().min_by(|&&a, &&b| square(a).total_cmp(&square(b)))?;
        let i = sample as usize;
        let (facet, touching) = (&self.facets[i], self.marks.radius[i] + half);
        let off = facet.away(away(sample), self.marks.width[i]);
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
        i == j || (norm(d) < JOINED * self.marks.width[i as usize] && self.facets[i as usize].goes_on(d))
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

/// Calls `f` with the points within a distance of one \[m\].
fn within(cells: &Cells, all: &[Vec3], (x, reach): (Vec3, f64), mut f: impl FnMut(u32)) {
    cells.near(x, [reach; 3], |range| {
        for &i in &cells.items()[range] {
            let d = sub(all[i as usize], x);
            if dot(d, d) < reach * reach {
                f(i);
            }
        }
    });
}
