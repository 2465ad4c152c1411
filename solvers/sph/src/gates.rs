//! Inflows and drains: where liquid enters and leaves.
//!
//! All that will enter is there from the start, as particles of density 0, which nobody sees: they have no mass in the books,
//! are in no list and stay in their opening. A layer enters in each time in which the last one has moved on by a spacing,
//! where it would be had it entered at its very moment, and is driven at its velocity until it has left the kernel's reach
//! of the opening, so that a jet enters against pressure too; the pressures of an incompressible liquid do not move it.
//! What a drain takes becomes such a particle again, in the middle of the drain. Momentum that comes, goes, or is given to
//! what is driven is external, and its energy is supplied.

use std::ops::Range;

use cosplat_core::boundary::{Vec3, Wrench, add, cross, dot, norm, scale, sub};
use cosplat_core::scene::Opening;

use crate::lanes::Pack;
use crate::model::Model;
use crate::params::Pressure;
use crate::sim::{Books, Course};
use crate::store::{Listed, Store};

/// Share of the time between two layers by which one may be early: rounding of times.
const EARLY: f64 = 1e-9;

/// An opening through which liquid enters.
#[derive(Clone, Debug)]
pub(crate) struct Inflow {
    /// Identities of the particles that enter, layer by layer.
    pub(crate) ids: Range<usize>,
    /// Particles of a layer.
    pub(crate) layer: usize,
    /// Velocity with which they enter \[m/s\].
    pub(crate) velocity: Vec3,
    /// First moment and time between two layers \[s\].
    pub(crate) from: f64,
    pub(crate) every: f64,
}

/// A box in which liquid leaves.
#[derive(Clone, Debug)]
pub(crate) struct Drain {
    /// Whether it takes each body.
    pub(crate) acts: Vec<bool>,
    /// Middle and half of the sides \[m\].
    pub(crate) center: Vec3,
    pub(crate) half: Vec3,
    /// First and last moment \[s\].
    pub(crate) from: f64,
    pub(crate) until: f64,
}

impl Inflow {
    /// Layers that have entered by `time` \[s\].
    fn due(&self, time: f64) -> usize {
        let layers = self.ids.len() / self.layer;
        if time < self.from { 0 } else { (((time - self.from) / self.every + EARLY) as usize + 1).min(layers) }
    }

    /// Layers that enter before `until` \[s\].
    pub(crate) fn layers(&self, until: f64) -> f64 {
        ((until - self.from) / self.every - EARLY).ceil().max(0.0)
    }

    /// When the layer of a particle enters \[s\].
    fn enters(&self, id: usize) -> f64 {
        self.every.mul_add(((id - self.ids.start) / self.layer) as f64, self.from)
    }
}

/// Places of one layer \[m\]: a lattice across an opening.
pub(crate) fn layer(opening: Opening, center: Vec3, velocity: Vec3, spacing: f64) -> Vec<Vec3> {
    let along = scale(velocity, 1.0 / norm(velocity));
    let level = [-along[1], along[0], 0.0];
    let upright = norm(level) < 1e-6;
    let first = if upright { [1.0, 0.0, 0.0] } else { scale(level, 1.0 / norm(level)) };
    let second = cross(along, first);
    let sides = match opening {
        Opening::Disc { radius_m } => [2.0 * radius_m; 2],
        Opening::Rectangle { size_m } => size_m,
    };
    let count = sides.map(|side| (side / spacing).round().max(1.0));
    let inside = |[a, b]: [f64; 2]| match opening {
        Opening::Disc { radius_m } => a.hypot(b) <= radius_m,
        Opening::Rectangle { .. } => true,
    };
    let at = |k: usize, i: usize| (i as f64 + 0.5 - 0.5 * count[k]) * spacing;
    let cells = (0..count[0] as usize).flat_map(|i| (0..count[1] as usize).map(move |j| [at(0, i), at(1, j)]));
    let mut all: Vec<Vec3> =
        cells.filter(|&cell| inside(cell)).map(|[a, b]| add(center, add(scale(first, a), scale(second, b)))).collect();
    if all.is_empty() {
        all.push(center);
    }
    all
}

fn momentum(mass: f64, x: Vec3, v: Vec3) -> Wrench {
    let p = scale(v, mass);
    Wrench { linear: p, angular: cross(x, p) }
}

/// Energy of a particle by itself: of its motion, its place and its compression \[J\].
fn energy(model: &Model, store: &Store, i: usize) -> f64 {
    let id = store.id[i] as usize;
    let (body, mass) = (model.body[id] as usize, model.mass[id]);
    let liquid = &model.liquids[body];
    let pressed = match model.params.pressure {
        Pressure::Weak => liquid.stored(store.rho[i]),
        Pressure::Incompressible => 0.0,
    };
    let weight = model.gravity.iter().filter(|a| a.acts[body] && a.always);
    let place: f64 = weight.map(|a| -dot(a.acceleration, store.x[i])).sum();
    mass * (0.5 * dot(store.v[i], store.v[i]) + place + pressed)
}

impl Course<'_> {
    /// Lets in what enters by `time` \[s\] of the run.
    pub(crate) fn admit(&mut self, time: f64) {
        let Self { model, store, books, .. } = self;
        for (n, inflow) in model.inflows.iter().enumerate() {
            let (entered, due) = (store.entered[n] as usize, inflow.due(time));
            if due <= entered {
                continue;
            }
            let place = |layer: usize| inflow.ids.start + layer * inflow.layer;
            let ids = place(entered)..place(due);
            for i in 0..store.len() {
                let id = store.id[i] as usize;
                if ids.contains(&id) {
                    store.rho[i] = model.liquids[model.body[id] as usize].rho;
                    store.v[i] = inflow.velocity;
                    store.x[i] = add(model.start[id], scale(inflow.velocity, time - inflow.enters(id)));
                    books.external = books.external.plus(momentum(model.mass[id], store.x[i], store.v[i]));
                    books.supplied += energy(model, store, i);
                }
            }
            books.entered += ids.len() as u64;
            store.entered[n] = due as u64;
            store.listed = Listed::default();
        }
    }

    /// Takes out what is in a drain at `time` \[s\] of the run.
    pub(crate) fn drain(&mut self, time: f64) {
        let Self { model, store, books, .. } = self;
        let before = books.drained;
        for drain in model.drains.iter().filter(|d| (d.from..d.until).contains(&time)) {
            for i in 0..store.len() {
                let (id, way) = (store.id[i] as usize, sub(store.x[i], drain.center));
                let inside = (0..3).all(|k| way[k].abs() < drain.half[k]) && is_here(store.rho[i]);
                if !inside || !drain.acts[model.body[id] as usize] {
                    continue;
                }
                books.external = books.external.minus(momentum(model.mass[id], store.x[i], store.v[i]));
                books.supplied -= energy(model, store, i);
                books.drained += 1;
                (store.rho[i], store.x[i], store.v[i]) = (0.0, drain.center, [0.0; 3]);
                if let Some(pressure) = store.warm.get_mut(i) {
                    *pressure = 0.0;
                }
            }
        }
        if books.drained > before && model.params.pressure == Pressure::Incompressible {
            // An incompressible liquid counts the volume of all that is listed.
            store.listed = Listed::default();
        }
    }
}

/// Whether a particle of that density has entered and not left.
pub(crate) fn is_here(rho: f64) -> bool {
    rho.abs() > 0.0
}

/// Particles that have just entered and are driven in a substep that ends at `time` \[s\] of the run, with their velocities.
pub(crate) fn driven(model: &Model, store: &Store, time: f64) -> Vec<(usize, Vec3)> {
    let mut all = Vec::new();
    for inflow in &model.inflows {
        let hold = model.kernel.reach / norm(inflow.velocity);
        let own =
            store.id.iter().zip(&store.rho).enumerate().filter(|(_, (id, _))| inflow.ids.contains(&(**id as usize)));
        let held = own.filter(|(_, (id, rho))| **rho > 0.0 && time < inflow.enters(**id as usize) + hold);
        all.extend(held.map(|(i, _)| (i, inflow.velocity)));
    }
    all
}

/// Gives them their velocities.
pub(crate) fn drive(model: &Model, store: &mut Store, pack: &mut [Pack], books: &mut Books, driven: &[(usize, Vec3)]) {
    for &(i, velocity) in driven {
        let (mass, given) = (model.mass[store.id[i] as usize], sub(velocity, store.v[i]));
        books.external = books.external.plus(momentum(mass, store.x[i], given));
        books.supplied += mass * dot(given, add(store.v[i], scale(given, 0.5)));
        (store.v[i], pack[i].v) = (velocity, velocity);
    }
}
