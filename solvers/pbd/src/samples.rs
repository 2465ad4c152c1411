//! A partner that shows samples: where they are, and what of a cloth each of them meets.
//!
//! A sample is a bead as thick as its particle, and is met from either side (`cover`, `side`). It moves as the partner
//! said, from where contact left it (`behind`), and by the impulses it has taken in this window at its own mass, so that a
//! light body gives way.

use cosplat_core::boundary::{SampleStatics, Samples, Vec3, add, norm, scale, sub};
use cosplat_core::plugin::PartnerInput;
use rayon::prelude::*;

use crate::behind::{Behind, Left};
use crate::cover::{Contact, Cover, Found};
use crate::list::List;
use crate::own::Mesh;
use crate::seam::{self, Bead};
use crate::side::Sides;
use crate::vertex::Vertex;

/// Width of a sample that has neither an area nor a volume \[m\].
const NO_WIDTH: f64 = 1e-3;
/// Distance up to which a side is remembered, over that of touching surfaces: nothing moves further between two looks.
pub(crate) const REMEMBERED: f64 = 2.0;
/// Triangles are of one layer that are nearer at rest than this part of the distance at which surfaces touch, and so many
/// of the shortest edges.
const LAYER: [f64; 2] = [4.0, 2.0];
/// Samples of a task.
const TASK: usize = 128;

/// What never changes about a partner's samples.
#[derive(Clone, Debug, Default)]
pub(crate) struct Marks {
    /// Distance of the surface from the sample \[m\].
    radius: Vec<f64>,
    /// 1 / mass \[1/kg\].
    inverse: Vec<f64>,
    /// Greatest width and radius \[m\].
    widest: f64,
    thickest: f64,
}

impl Marks {
    /// From what a partner said; nothing where a sample has no mass.
    pub(crate) fn new(statics: &SampleStatics) -> Option<Self> {
        if !statics.mass_kg.iter().all(|m| m.is_finite() && *m > 0.0) {
            return None;
        }
        let radius: Vec<f64> = statics.volume_m3.iter().map(|&v| 0.5 * libm::cbrt(v.max(0.0))).collect();
        let width = |(&area, &radius): (&f64, &f64)| area.max(0.0).sqrt().max(2.0 * radius);
        let widest = statics.area_m2.iter().zip(&radius).map(width).fold(0.0, f64::max);
        let inverse = statics.mass_kg.iter().map(|m| 1.0 / m).collect();
        let thickest = radius.iter().copied().fold(0.0, f64::max);
        Some(Self { radius, inverse, widest: if widest > 0.0 { widest } else { NO_WIDTH }, thickest })
    }

    /// Least distance of surfaces from the middle of a sample \[m\].
    fn thinnest(&self) -> f64 {
        self.radius.iter().copied().fold(f64::INFINITY, f64::min)
    }

    /// Number of samples.
    pub(crate) fn len(&self) -> usize {
        self.radius.len()
    }
}

/// What is known of a partner's samples from one window to the next.
#[derive(Clone, Debug, Default)]
pub(crate) struct Known {
    /// Of each sample.
    pub(crate) sides: Vec<Sides>,
    /// Where contact left each of them.
    pub(crate) left: Left,
    pub(crate) list: List,
}

/// Samples of a partner over one window.
#[derive(Clone, Debug)]
pub(crate) struct Swarm<'a> {
    marks: &'a Marks,
    path: Vec<[Vec3; 4]>,
    behind: Behind,
    /// Displacement and velocity by the impulses of this window \[m, m/s\].
    moved: Vec<[Vec3; 2]>,
    /// Position and velocity in this substep.
    now: Vec<[Vec3; 2]>,
    /// Impulses on the samples \[N s\].
    pub(crate) impulse: Vec<Vec3>,
    /// Triangles that each sample can meet in this window.
    pub(crate) list: List,
    /// Samples that move: those in the list, and those that cloth is attached to.
    active: Vec<u32>,
    /// Samples that cloth is attached to.
    tied: Vec<u32>,
    /// Of each sample.
    pub(crate) sides: Vec<Sides>,
    /// What is near in this substep.
    pub(crate) contacts: Vec<Contact>,
    /// Samples that have gone through the cloth in this window.
    pub(crate) pierced: u64,
    /// Largest speed of a sample that can be met \[m/s\].
    pub(crate) fastest: Option<f64>,
}

impl<'a> Swarm<'a> {
    /// Looks for the triangles that each sample can meet in a window in which they move towards each other by `way` \[m\],
    /// surfaces keeping `half` \[m\] from the cloth's middle.
    pub(crate) fn new(
        marks: &'a Marks,
        (samples, input): (&'a Samples, &PartnerInput),
        cover: &Cover,
        [way, half]: [f64; 2],
        Known { mut sides, left, mut list }: Known,
    ) -> Self {
        let behind = Behind::new(&left, &samples.position, input.length_s);
        let numbers = || 0..samples.position.len() as u32;
        let from = |i: u32| add(samples.position[i as usize], behind.at(i, 0.0)[0]);
        let all: Vec<Vec3> = numbers().map(from).collect();
        let way = way + numbers().map(|i| behind.speed(i)).fold(0.0, f64::max) * input.length_s;
        list.renew(cover, &all, (REMEMBERED * (marks.thickest + half), way, marks.widest));
        sides.resize(all.len(), Sides::default());
        let fast = |&i: &u32| norm(samples.velocity[i as usize]) + behind.speed(i);
        let fastest = list.samples.iter().map(fast).reduce(f64::max);
        Self {
            marks,
            path: (0..all.len()).map(|i| input.path(i)).collect(),
            behind,
            moved: vec![[[0.0; 3]; 2]; all.len()],
            now: vec![[[0.0; 3]; 2]; all.len()],
            impulse: vec![[0.0; 3]; all.len()],
            active: list.samples.clone(),
            tied: Vec::new(),
            list,
            sides,
            contacts: Vec::new(),
            pierced: 0,
            fastest,
        }
    }

    /// Moves on to `t` \[s\] from the start of the window.
    pub(crate) fn at(&mut self, t: f64) {
        for &i in &self.active {
            let ([a, b, c, d], [moved, v]) = (self.path[i as usize], self.moved[i as usize]);
            let [way, closing] = self.behind.at(i, t);
            let x = add(add(add(a, way), moved), scale(add(b, scale(add(c, scale(d, t)), t)), t));
            let u = add(add(v, closing), add(b, scale(add(scale(c, 2.0), scale(d, 3.0 * t)), t)));
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

    /// Distance of the middle of a cloth from that of a sample at which the thinnest of them touch \[m\].
    pub(crate) fn thinnest(&self, half: f64) -> f64 {
        self.marks.thinnest() + half
    }

    /// Finds what each sample meets of a cloth and its side of it, surfaces keeping `half` \[m\] from the middle of the
    /// cloth, whose shortest edge is `shortest` \[m\].
    pub(crate) fn look(&mut self, cover: &Cover, [half, shortest]: [f64; 2], parallel: bool) {
        let one = |found: &mut Vec<Found>, (place, &i): (usize, &u32)| {
            let touching = self.marks.radius[i as usize] + half;
            let sizes = [touching, LAYER[0] * touching + LAYER[1] * shortest];
            let x = self.now[i as usize][0];
            cover.meet((i, x), self.list.of(place), &self.sides[i as usize], sizes, found)
        };
        let samples = &self.list.samples;
        let met: Vec<_> = if parallel {
            samples.par_iter().enumerate().with_min_len(TASK).map_init(Vec::new, one).collect()
        } else {
            let mut found = Vec::new();
            samples.iter().enumerate().map(|item| one(&mut found, item)).collect()
        };
        self.contacts.clear();
        let mut all = vec![Sides::default(); self.sides.len()];
        for (&i, (sides, contacts)) in self.list.samples.iter().zip(met) {
            let through = |sides: &Sides| sides.iter().flatten().filter(|s| s.is_through).count();
            self.pierced += through(&sides).saturating_sub(through(&self.sides[i as usize])) as u64;
            all[i as usize] = sides;
            self.contacts.extend(contacts.iter().flatten());
        }
        self.sides = all;
        let mesh = cover.mesh;
        let beads = self.beads(half, |c| mesh.rim.get(c.triangle as usize).is_some_and(|bits| bits & 7 != 0));
        self.contacts.extend(seam::contacts(&beads, mesh, cover.vertices));
    }

    /// Samples with a contact of a kind.
    fn beads(&self, half: f64, takes: impl Fn(&Contact) -> bool) -> Vec<Bead> {
        let bead = |c: &Contact| {
            let [sample, _] = c.samples;
            let touching = self.marks.radius[sample as usize] + half;
            let distance = (c.gap + touching).abs();
            Bead { sample, x: self.now[sample as usize][0], touching, distance, triangle: c.triangle }
        };
        self.contacts.iter().filter(|c| c.share == 0.0 && takes(c)).map(bead).collect()
    }

    /// How many seams between samples go through the cloth at `t` \[s\] from the start of the window; `parallel` shares
    /// them out.
    pub(crate) fn cut(&mut self, (mesh, vertices): (&Mesh, &[Vertex]), half: f64, t: f64, parallel: bool) -> u64 {
        self.at(t);
        let beads = self.beads(half, |_| true);
        let mut near = Vec::new();
        seam::seams(&beads, |[a, b], _| {
            // Both ends of such a seam together are no further from the cloth than it is long, but for a last motion.
            if a.distance + b.distance <= norm(sub(b.x, a.x)) + 0.5 * a.touching {
                near.push(([a.sample, b.sample], [a.x, b.x]));
            }
        });
        near.sort_unstable_by_key(|(samples, _)| *samples);
        near.dedup_by_key(|(samples, _)| *samples);
        let corners = |t: u32| mesh.triangles[t as usize].map(|i| vertices[i as usize].x);
        let is_cut = |([sample, _], ends): &([u32; 2], [Vec3; 2])| {
            let known = self.list.samples.binary_search(sample).map_or(&[][..], |place| self.list.of(place));
            known.iter().any(|&t| seam::crosses(*ends, corners(t)))
        };
        let found = if parallel {
            near.par_iter().with_min_len(TASK).filter(|seam| is_cut(seam)).count()
        } else {
            near.iter().filter(|seam| is_cut(seam)).count()
        };
        found as u64
    }

    /// What is known of the samples at `t` \[s\], the end of the window.
    pub(crate) fn leave(mut self, t: f64) -> Known {
        self.at(t);
        let mut left = vec![None; self.now.len()];
        // What cloth is attached to is where the partner says: a bond closes its gap by itself.
        for &i in self.list.samples.iter().filter(|i| self.tied.binary_search(i).is_err()) {
            let i = i as usize;
            let met = norm(self.moved[i][0]) > 0.0 || self.sides[i].iter().any(Option::is_some);
            left[i] = met.then(|| self.now[i][0]);
        }
        Known { sides: self.sides, left, list: self.list }
    }

    /// How far a sample is at most beyond where cloth has it that it pushes \[m\].
    pub(crate) fn overrun(&self) -> f64 {
        let one = |(i, &impulse): (u32, &Vec3)| self.behind.overrun(i, impulse);
        (0..).zip(&self.impulse).map(one).fold(0.0, f64::max)
    }

    /// How many samples are beyond the cloth.
    pub(crate) fn beyond(&self) -> u64 {
        self.sides.iter().filter(|sides| sides.iter().flatten().any(|side| side.is_through)).count() as u64
    }

    /// Position and velocity of a sample \[m, m/s\].
    pub(crate) fn state(&self, sample: u32) -> (Vec3, Vec3) {
        let [x, u] = self.now[sample as usize];
        (x, u)
    }

    /// Also follows samples that cloth is attached to.
    pub(crate) fn follow(&mut self, samples: impl Iterator<Item = u32>) {
        self.tied = samples.collect();
        self.tied.sort_unstable();
        self.active.extend(&self.tied);
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

    /// Velocity \[m/s\] and velocity per impulse \[1/kg\] of a point between two samples.
    pub(crate) fn between(&self, [i, j]: [u32; 2], share: f64) -> (Vec3, f64) {
        let velocity = add(scale(self.velocity(i), 1.0 - share), scale(self.velocity(j), share));
        let [first, second] = [(i, 1.0 - share), (j, share)].map(|(i, share)| share * share * self.inverse(i));
        (velocity, first + second)
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
