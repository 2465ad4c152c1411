//! A substep of an incompressible liquid: divergence-free smoothed particle hydrodynamics (Bender and Koschier,
//! "Divergence-free SPH for incompressible and viscous fluids", 2017), with both of its conditions in one solution.
//!
//! 1. Gravity and viscosity change the velocities;
//! 2. the smallest pressures are found by which no place is fuller than at rest after the step (`solve`);
//! 3. everything moves.
//!
//! How full a place is follows, as the density of the weakly compressible liquid does, from the divergence of the velocities.
//! What is full stays full, so its velocities are free of divergence; what is not may close its gaps. Density by summation
//! corrects it only where it says that a place is fuller: slowly, because a place that is emptied by velocities gains energy.
//!
//! The change of the filled share and the force of pressures are one operator and its transpose (`operator`, `wall`), so
//! that a solution never gains energy. The twists of rigid partners are unknowns of it (`contact`): a light body is moved by
//! the pressure that it causes.

mod contact;
mod operator;
mod solve;
mod wall;

use cosplat_core::boundary::{Vec3, Wrench, add, cross, dot, norm};

use crate::force::{Pass, Sums, largest};
use crate::lanes::Pack;
use crate::model::Model;
use crate::near::{CHUNK, for_chunks};
use crate::partner::Partners;
use crate::store::Store;
use crate::wall::{Liquids, Walls};
use contact::Contacts;
use operator::Operator;
use solve::{Problem, Search};

/// Spacings that the fastest particle may pass in a substep.
const COURANT: f64 = 0.4;
/// Share of the volume around a particle below which it is spray, whose gaps may close.
const SPRAY: f64 = 0.6;

/// Share of what a place is too full by measure that is undone in a substep.
const RETURN: f64 = 0.01;

/// What a substep tells.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Solved {
    /// Iterations.
    pub(crate) iterations: u64,
    /// Solutions that were not good enough when the iterations ended.
    pub(crate) unfinished: u64,
}

impl Solved {
    /// Counts another substep.
    pub(crate) fn add(&mut self, other: Self) {
        self.iterations += other.iterations;
        self.unfinished += other.unfinished;
    }
}

/// Working memory.
#[derive(Clone, Debug, Default)]
pub(crate) struct Projection {
    operator: Operator,
    contacts: Contacts,
    search: Search,
    /// Filled shares at the start of the substep.
    share: Vec<f64>,
    /// Velocities before pressure.
    v: Vec<Vec3>,
}

/// Everything that a substep works on.
pub(crate) struct Parts<'a> {
    pub(crate) pass: Pass<'a>,
    pub(crate) store: &'a mut Store,
    pub(crate) pack: &'a mut [Pack],
    pub(crate) walls: &'a mut Walls,
    pub(crate) partners: &'a mut Partners,
    pub(crate) acceleration: &'a mut [Vec3],
    pub(crate) sums: &'a mut [Sums],
}

/// Longest substep \[s\] for a largest speed, and what binds it.
pub(crate) fn stable(model: &Model, speed: f64) -> (f64, String) {
    let d = model.spacing;
    let mut best = (model.params.most, "maximum given by the user".to_owned());
    let mut bind = |dt: f64, why: &dyn Fn() -> String| {
        if dt < best.0 {
            best = (dt, why());
        }
    };
    bind(COURANT * d / speed, &|| format!("{COURANT} spacings of the fastest particle"));
    for liquid in &model.liquids {
        let h = model.kernel.h;
        // Monaghan (2005, §8.4).
        bind(0.125 * h * h * liquid.rho / liquid.viscosity, &|| format!("viscosity of `{}`", liquid.name));
    }
    let pull = model.gravity.iter().map(|g| norm(g.acceleration)).sum::<f64>();
    // From rest the way of COURANT spacings is fallen in √(2 COURANT d/g).
    bind((2.0 * COURANT * d / pull).sqrt(), &|| "gravity".to_owned());
    best
}

impl Projection {
    /// One substep but for the motion itself.
    pub(crate) fn substep(&mut self, parts: &mut Parts<'_>) -> Solved {
        let (model, dt, parallel) = (parts.pass.model, parts.pass.dt, parts.pass.parallel);
        let n = parts.store.len();
        parts.pass.pack(parts.store, &mut parts.pack[..n]);
        for (pack, &id) in parts.pack.iter_mut().zip(&parts.store.id) {
            let rho = model.liquids[model.body[id as usize] as usize].rho;
            (pack.volume, pack.pressure) = (model.mass[id as usize] / rho, 0.0);
        }
        self.operator.measure(&parts.pass, parts.store, parts.pack, parts.walls);
        self.contacts.find(model, parts.walls, parts.partners, parts.pack, &self.operator.edge);
        self.operator.weigh(&mut self.contacts, parts.pack);
        parts.walls.extrapolate(&Liquids { model, pack: parts.pack, gravity: parts.pass.gravity, parallel });
        parts.walls.let_go();
        parts.pass.accelerate(parts.store, parts.pack, parts.walls, parts.acceleration, parts.sums);
        let liquids = Liquids { model, pack: parts.pack, gravity: parts.pass.gravity, parallel };
        parts.walls.impulses(&liquids, parts.acceleration, dt);
        self.contacts.rub(model, parts.walls, parts.partners, dt);
        parts.pass.kick(parts.acceleration, parts.store, parts.pack, parts.sums);
        let solved = self.project(parts);
        let after = &parts.store.v;
        let (edge, pushed) = (&self.operator.edge, &self.search.pushed);
        self.contacts.press(parts.walls, &parts.pass, edge, parts.pack, after, pushed);
        parts.partners.book(model, parts.walls, dt);
        self.settle(parts);
        solved
    }

    /// Finds the pressures and takes their impulses.
    fn project(&mut self, parts: &mut Parts<'_>) -> Solved {
        let (model, dt) = (parts.pass.model, parts.pass.dt);
        let rest = |id: u32| model.liquids[model.body[id as usize] as usize].rho;
        self.share.clear();
        for ((&rho, &id), row) in parts.store.rho.iter().zip(&parts.store.id).zip(&self.operator.rows) {
            let share = rho / rest(id);
            let kept = share.max(row.filled.min(1.0)) + RETURN * (row.filled - 1.0).max(0.0);
            self.share.push(if row.filled < SPRAY { row.filled } else { kept });
        }
        let mut pack_v = std::mem::take(&mut self.v);
        pack_v.clone_from(&parts.store.v);
        let problem = Problem {
            pass: &parts.pass,
            walls: parts.walls,
            pack: parts.pack,
            v: &pack_v,
            share: &self.share,
            dt,
            accuracy: model.params.accuracy,
            most: model.params.iterations,
        };
        let found = self.search.run(&problem, &mut self.operator, &mut self.contacts, &parts.store.warm);
        self.v = pack_v;
        parts.store.warm.clone_from(&self.search.pressure);
        for (i, v) in parts.store.v.iter_mut().enumerate() {
            parts.store.rho[i] = rest(parts.store.id[i]) * (1.0 + self.search.relaxed[i].excess).max(SPRAY);
            *v = add(*v, self.search.gained[i]);
        }
        Solved { iterations: found.iterations, unfinished: u64::from(!found.enough) }
    }

    /// Books what static walls did, and finds the largest speed.
    fn settle(&self, parts: &mut Parts<'_>) {
        let (operator, pushed, pack) = (&self.operator, &self.search.pushed, &*parts.pack);
        let walls = &*parts.walls;
        let v = &parts.store.v;
        for_chunks(parts.pass.parallel, parts.acceleration, parts.sums, &|c, chunk, sums| {
            sums.speed = 0.0;
            for k in 0..chunk.len() {
                let i = c * CHUNK + k;
                sums.speed = largest(dot(v[i], v[i]), sums.speed);
                if !walls.near(i).is_empty() {
                    let force = operator.by_statics(walls, pack, i, pushed);
                    sums.walls = sums.walls.plus(Wrench { linear: force, angular: cross(pack[i].x, force) });
                }
            }
        });
    }
}
