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
//! A particle-iteration reads about 1 kB, two passes over 60 pairs of 8 bytes (`pairs`), and costs about 570 cycles.
//!
//! The change of the filled share and the force of pressures are one operator and its transpose (`operator`, `wall`), so
//! that a solution never gains energy. The twists of rigid partners are unknowns of it (`contact`): a light body is moved by
//! the pressure that it causes.

mod contact;
mod measure;
mod operator;
mod solve;
mod wall;

use cosplat_core::boundary::{Vec3, add, dot, norm, scale};

use crate::force::{Pass, Sums, largest};
use crate::gates::{drive, driven};
use crate::lanes::Pack;
use crate::liquids::Liquids;
use crate::model::Model;
use crate::near::{CHUNK, for_chunks};
use crate::partner::Partners;
use crate::sim::{Books, Motion, VISCOUS};
use crate::store::Store;
use crate::thick::Thick;
use crate::wall::Walls;
use contact::Contacts;
use operator::Operator;
use solve::{Problem, Search};

/// Spacings that the fastest particle may pass in a substep.
const COURANT: f64 = 0.4;
/// Largest `dt √(p/ρ)/d`. Displaced across its wave, which no change of volume answers, a cubic lattice under pressure p is driven
/// back by at most 4.57 p/(ρ d²) (the largest eigenvalue of `2 p/ρ Σ V ∇∇W (1 - cos k·r)` over all waves), and a symplectic
/// step is stable up to 2/√4.57 = 0.935; three quarters of it.
const STIFF: f64 = 0.7;
/// Share of the volume around a particle below which it is spray, whose gaps may close.
const SPRAY: f64 = 0.6;

/// Share of what earlier solutions left too full that is undone in a substep: all at once it would be a noise of velocities
/// over substep and spacing, which particles out of their lattice answer by pressures.
const UNDONE: f64 = 0.2;
/// Share of what the places around one are too full by measure that is undone in a substep. The mean is taken because a
/// single sum over particles out of their lattice scatters by some hundredths.
const RETURN: f64 = 0.1;

/// Pressure over that of the liquid's height and speed above which it is of the undoing's own making.
const USUAL: f64 = 4.0;

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
    /// Velocities before the substep \[m/s\].
    before: Vec<Vec3>,
    /// Velocities before pressure \[m/s\] and filled shares, times volumes; then nobody's.
    moved: Vec<[f32; 4]>,
    /// Rates of the filled shares before pressure \[1/s\], and the means of the filled shares around.
    rates: Vec<f64>,
    means: Vec<f64>,
    /// Excess without pressure.
    base: Vec<f64>,
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
    pub(crate) thick: &'a mut Thick,
    pub(crate) books: &'a mut Books,
    /// End of the substep \[s\].
    pub(crate) end: f64,
}

/// Largest pressure over density in the last substep \[m²/s²\].
pub(crate) fn pressed(model: &Model, store: &Store) -> f64 {
    let all = store.warm.iter().zip(&store.id).filter(|(p, _)| **p > 0.0);
    all.map(|(p, &id)| p / model.liquids[model.body[id as usize] as usize].rho).fold(0.0, largest)
}

/// Share of `UNDONE` and `RETURN` that is undone where pressure is more than weight and motion make it.
///
/// What is undone in a substep needs a velocity over the substep, and so a pressure over its square: that makes the next
/// substep shorter, which would make the pressure higher.
fn ease(model: &Model, store: &Store) -> f64 {
    let (usual, now) = (model.head + store.fastest().powi(2), pressed(model, store));
    if now > USUAL * usual { (USUAL * usual / now).sqrt() } else { 1.0 }
}

/// Longest substep \[s\], and what binds it.
pub(crate) fn stable(model: &Model, motion: Motion) -> (f64, String) {
    let d = model.spacing;
    let mut best = (model.params.most, "maximum given by the user".to_owned());
    let mut bind = |dt: f64, why: &dyn Fn() -> String| {
        if dt < best.0 {
            best = (dt, why());
        }
    };
    bind(STIFF * d / motion.pressed.sqrt(), &|| "pressure, under which particles swing in their lattice".to_owned());
    bind(COURANT * d / motion.speed, &|| format!("{COURANT} spacings of the fastest particle"));
    for liquid in &model.liquids {
        let h = model.kernel.h;
        bind(VISCOUS * h * h * liquid.rho / liquid.viscosity, &|| format!("viscosity of `{}`", liquid.name));
        if liquid.tension > 0.0 {
            let dt = 0.25 * (liquid.rho * h * h * h / (std::f64::consts::PI * liquid.tension)).sqrt();
            bind(dt, &|| format!("surface tension of `{}`", liquid.name));
        }
    }
    let pull = model.gravity.iter().map(|g| norm(g.acceleration)).sum::<f64>();
    // From rest the way of COURANT spacings is fallen in √(2 COURANT d/g).
    bind((2.0 * COURANT * d / pull).sqrt(), &|| "gravity".to_owned());
    best
}

impl Projection {
    /// One substep but for the motion itself; and the iterations of viscosity.
    pub(crate) fn substep(&mut self, parts: &mut Parts<'_>) -> (Solved, u64) {
        let (model, dt, parallel) = (parts.pass.model, parts.pass.dt, parts.pass.parallel);
        let n = parts.store.len();
        self.before.clone_from(&parts.store.v);
        parts.pass.rest(parts.store, &mut parts.pack[..n]);
        let driven = driven(model, parts.store, parts.end);
        self.operator.hold(model, parts.store, &driven);
        self.operator.measure(&parts.pass, parts.store, parts.pack, parts.walls);
        self.contacts.find(model, parts.walls, parts.partners, parts.pack, &self.operator.edge);
        self.operator.weigh(&mut self.contacts, parts.pack);
        parts.walls.extrapolate(&Liquids { model, pack: parts.pack, gravity: parts.pass.gravity, parallel });
        parts.walls.let_go();
        let found = (&mut *parts.acceleration, &mut *parts.sums);
        parts.pass.accelerate(parts.store, parts.pack, parts.walls, &self.operator, found);
        let liquids = Liquids { model, pack: parts.pack, gravity: parts.pass.gravity, parallel };
        parts.walls.impulses(&liquids, parts.acceleration, dt);
        self.contacts.rub(model, parts.walls, parts.partners, dt);
        parts.pass.kick(parts.acceleration, parts.store, parts.pack, parts.sums);
        let spread = if model.is_thick() {
            parts.thick.spread(&parts.pass, parts.store, parts.pack, parts.walls, parts.sums)
        } else {
            0
        };
        drive(model, parts.store, parts.pack, parts.books, &driven);
        let solved = self.project(parts);
        let flow = [&self.before[..], &parts.store.v[..]];
        let given = self.contacts.press(parts.walls, &parts.pass, &self.operator.edge, parts.pack, flow);
        parts.books.pressed -= given + dt * parts.sums.iter().map(|s| s.pressed).sum::<f64>();
        parts.partners.book(model, parts.walls, dt);
        (solved, spread)
    }

    /// Finds the pressures and takes their impulses.
    fn project(&mut self, parts: &mut Parts<'_>) -> Solved {
        let (model, dt, pass) = (parts.pass.model, parts.pass.dt, &parts.pass);
        let rest = |id: u32| model.liquids[model.body[id as usize] as usize].rho;
        let n = parts.store.len();
        self.excess(parts, rest);
        let problem = Problem {
            pass,
            pack: parts.pack,
            base: &self.base,
            count: parts.store.rho.iter().filter(|rho| **rho > 0.0).count(),
            accuracy: model.params.accuracy,
            most: model.params.iterations,
        };
        let found = self.search.run(&problem, &mut self.operator, &mut self.contacts, &parts.store.warm);
        for (i, t) in self.search.trials.iter().enumerate() {
            parts.store.warm[i] = t.pressure;
            parts.pack[i].pressure = t.pressure * self.operator.rows[i].swell;
            if parts.store.rho[i] > 0.0 {
                parts.store.rho[i] = rest(parts.store.id[i]) * (1.0 + t.excess).max(SPRAY);
            }
        }
        let gained = &mut *parts.acceleration;
        self.operator.press(pass, parts.walls, (parts.pack, &self.before), gained, parts.sums);
        for_chunks(pass.parallel, &mut parts.store.v[..n], parts.sums, &|c, v, sums| {
            sums.speed = 0.0;
            for (k, v) in v.iter_mut().enumerate() {
                *v = add(*v, scale(gained[c * CHUNK + k], dt));
                sums.speed = largest(dot(*v, *v), sums.speed);
            }
        });
        Solved { iterations: found.iterations, unfinished: u64::from(!found.enough) }
    }

    /// What each place would be fuller than at rest without pressure.
    fn excess(&mut self, parts: &Parts<'_>, rest: impl Fn(u32) -> f64) {
        let (n, dt) = (parts.store.len(), parts.pass.dt);
        let flow = parts.store.v.iter().zip(parts.pack.iter()).zip(&self.operator.rows);
        self.moved.clear();
        self.moved.extend(flow.map(|((v, pack), row)| {
            let [x, y, z, w] = [v[0], v[1], v[2], row.filled].map(|a| (a * pack.volume) as f32);
            [x, y, z, w]
        }));
        self.moved.push([0.0; 4]);
        self.rates.resize(n, 0.0);
        self.means.resize(n, 0.0);
        self.operator.means(&parts.pass, &self.moved, &mut self.means);
        let flow = (&self.moved[..], &mut self.rates[..]);
        self.operator.rates(&parts.pass, parts.pack, &self.contacts, true, flow);
        let half = parts.pass.model.kernel.half_space(parts.pass.model.spacing);
        let ease = ease(parts.pass.model, parts.store);
        let all = parts
            .store
            .rho
            .iter()
            .zip(&parts.store.id)
            .zip(self.operator.rows.iter().zip(self.rates.iter().zip(&self.means)));
        self.base.clear();
        self.base.extend(all.map(|((&rho, &id), (row, (rate, mean)))| {
            let share = if rho <= 0.0 {
                // Who waits or has left is in no list.
                0.0
            } else if row.filled < SPRAY {
                // Alone it is full where a wall is as near as to a lattice at rest, or it would sink in until it is.
                row.filled.max((row.by_walls / half).min(1.0))
            } else {
                let around = mean / row.by_liquid;
                let kept = (rho / rest(id)).max(row.filled.min(1.0));
                kept.min(1.0) + ease * (UNDONE * (kept - 1.0).max(0.0) + RETURN * (around - 1.0).max(0.0))
            };
            share - 1.0 + dt * rate
        }));
    }
}
