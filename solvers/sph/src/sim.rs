//! Substeps: their length, the sequence of passes, and the guard.

use cosplat_core::boundary::{Vec3, Wrench, scale};
use cosplat_core::plugin::{PluginError, Pulse, Signal};

use crate::compress::Compression;
use crate::felt::Around;
use crate::force::{Pass, Sums, largest};
use crate::gates::{drive, driven};
use crate::grid::{Grid, Sorted};
use crate::incompressible::{self, Parts, Projection, Solved};
use crate::lanes::Pack;
use crate::liquids::Liquids;
use crate::model::Model;
use crate::near::{CHUNK, Lists, for_chunks};
use crate::params::Pressure;
use crate::partner::Partners;
use crate::report::pulled;
use crate::single::WIDE;
use crate::store::{Listed, Store};
use crate::thick::Thick;
use crate::wall::Walls;

/// Largest `ν dt/h²` of explicit viscosity. The operator's diagonal is `8.05 ν/h²`, its largest eigenvalue at most twice that,
/// and walls that mirror velocities add to it: 2/16.1 = 0.12 less a margin.
pub(crate) const VISCOUS: f64 = 0.07;
/// Way of the fastest in a substep, in spacings, above which lists have no skin: they would hardly last two substeps.
const HASTE: f64 = 0.1;
/// Particles below which one thread is faster than several.
const SERIAL_BELOW: usize = 2000;

/// What happened in one step of the coupling.
#[derive(Clone, Debug, Default)]
pub(crate) struct Books {
    /// Gravity and walls, about the origin.
    pub(crate) external: Wrench,
    /// Energy of what entered and was driven, less that of what left \[J\].
    pub(crate) supplied: f64,
    /// Energy that the pressures of an incompressible liquid took in this substep, and what they gave back in others \[J\]:
    /// to undo what is too full raises it.
    pub(crate) pressed: f64,
    pub(crate) returned: f64,
    /// Substeps.
    pub(crate) substeps: u64,
    /// Term that bound the last one.
    pub(crate) bound: String,
    /// Times that the particles were sorted and lists made.
    pub(crate) sorts: u64,
    /// Boundary particles in reach at the end.
    pub(crate) boundary: u64,
    /// Particles put aside, let in and taken out.
    pub(crate) aside: u64,
    pub(crate) entered: u64,
    pub(crate) drained: u64,
    /// Iterations of incompressible solutions, and of those of viscosity.
    pub(crate) solved: Solved,
    pub(crate) thick: u64,
}

/// Working memory: nothing in it outlives a step.
#[derive(Clone, Debug, Default)]
pub(crate) struct Scratch {
    lists: Lists,
    walls: Walls,
    pack: Vec<Pack>,
    acceleration: Vec<Vec3>,
    next: Vec<f64>,
    sums: Vec<Sums>,
    compression: Compression,
    projection: Projection,
    thick: Thick,
    /// Whether the lists are those of `Store::listed`.
    made: bool,
}

/// One step of the coupling in progress.
pub(crate) struct Course<'a> {
    pub(crate) model: &'a Model,
    pub(crate) store: &'a mut Store,
    pub(crate) scratch: &'a mut Scratch,
    pub(crate) partners: Partners,
    pub(crate) books: Books,
    /// Start and length \[s\].
    pub(crate) start: f64,
    pub(crate) length: f64,
}

/// What binds a substep beside the model.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Motion {
    /// Largest speed \[m/s\] and acceleration \[m/s²\] of a particle.
    pub(crate) speed: f64,
    pub(crate) acceleration: f64,
    /// Largest pressure over density of an incompressible liquid \[m²/s²\].
    pub(crate) pressed: f64,
}

/// Largest stable substep \[s\] and what binds it.
///
/// Courant's condition for sound and the conditions for forces and viscosity of Monaghan (2005, §3.3 and §8.4).
pub(crate) fn stable(model: &Model, motion: Motion) -> (f64, String) {
    let Motion { speed, acceleration, .. } = motion;
    if model.params.pressure == Pressure::Incompressible {
        return incompressible::stable(model, motion);
    }
    let h = model.kernel.h;
    let mut best = (model.params.most, "maximum given by the user".to_owned());
    let mut bind = |dt: f64, why: &dyn Fn() -> String| {
        if dt < best.0 {
            best = (dt, why());
        }
    };
    for liquid in &model.liquids {
        let courant = model.params.courant;
        bind(courant * h / (liquid.sound + speed), &|| {
            format!("sound in `{}` (Courant number {courant} over the smoothing length)", liquid.name)
        });
        bind(VISCOUS * h * h * liquid.rho / liquid.viscosity, &|| format!("viscosity of `{}`", liquid.name));
    }
    for liquid in model.liquids.iter().filter(|l| l.tension > 0.0) {
        // The shortest capillary wave, of two smoothing lengths, may pass a quarter of one (Brackbill et al. 1992, eq. 61).
        let dt = 0.25 * (liquid.rho * h * h * h / (std::f64::consts::PI * liquid.tension)).sqrt();
        bind(dt, &|| format!("surface tension of `{}`", liquid.name));
    }
    bind(0.25 * (h / acceleration).sqrt(), &|| "acceleration of particles".to_owned());
    best
}

/// Best width of the skin of lists, in spacings, where the fastest moves by `way` spacings in a substep.
///
/// Lists that reach beyond the kernel's 2.4 spacings by s cost (1 + s/2.4)³ of a substep, and last s/(2 way) of them; to make
/// them costs about as much as one. The sum is least near s² = 1.6 way.
fn skin(way: f64) -> f64 {
    if way < HASTE { (1.6 * way).sqrt() } else { 0.0 }
}

impl Course<'_> {
    fn parallel(&self) -> bool {
        self.model.threads > 1 && self.store.len() >= SERIAL_BELOW
    }

    /// Covers the step.
    pub(crate) fn run(&mut self, pulse: &mut dyn Pulse, pool: Option<&rayon::ThreadPool>) -> Result<(), PluginError> {
        let many = self.parallel();
        let mut time = 0.0;
        let mut speed = self.store.fastest();
        while time < self.length {
            self.admit(self.start + time);
            let (mut bound_dt, mut bound) = {
                let pressed = incompressible::pressed(self.model, self.store);
                stable(self.model, Motion { speed, acceleration: self.store.acceleration, pressed })
            };
            if self.model.params.pressure == Pressure::Weak
                && let Some((dt, solid)) = self.partners.lightest(self.model)
                && dt < bound_dt
            {
                (bound_dt, bound) = (dt, format!("mass of partner `{solid}`"));
            }
            let left = self.length - time;
            let count = (left / bound_dt - 1e-9).ceil().max(1.0);
            let dt = left / count;
            self.books.bound = if self.length < bound_dt { "coupling window".to_owned() } else { bound };
            let mut both = || {
                self.partners.place(time);
                self.list(speed, dt);
                self.substep(time, dt)
            };
            speed = match pool.filter(|_| many) {
                Some(pool) => pool.install(both),
                None => both(),
            };
            self.books.substeps += 1;
            speed = self.guard(self.start + time, speed)?;
            self.land();
            time = if count > 1.0 { time + dt } else { self.length };
            self.drain(self.start + time);
            if pulse.beat(self.books.substeps, self.books.substeps + count as u64 - 1) == Signal::Abort {
                return Err(PluginError::Aborted);
            }
        }
        Ok(())
    }

    /// Sorts the particles and finds what is near, where lists are missing or no longer hold.
    fn list(&mut self, speed: f64, dt: f64) {
        let places = self.partners.places(self.model);
        if self.store.hold(&places) {
            if !self.scratch.made {
                self.make();
            }
            return;
        }
        let (model, fastest) = (self.model, 0.5 * (speed + speed.max(self.partners.speed())));
        let skin = skin(fastest * dt / model.spacing) * model.spacing;
        self.store.sort(model.kernel.reach + skin);
        let part = self.store.rho.iter().filter(|rho| **rho > 0.0).count() as u64;
        self.store.listed = Listed { x: self.store.x.clone(), part, partners: places, skin };
        self.make();
    }

    /// Finds what was near when everything was where lists are made.
    fn make(&mut self) {
        let parallel = self.parallel();
        let Self { model, store, scratch, partners, .. } = self;
        let Scratch { lists, walls, pack, acceleration, next, sums, .. } = &mut **scratch;
        let (n, reach) = (store.len(), model.kernel.reach + store.listed.skin);
        let x = store.listed.those();
        // They are sorted for it already, so that the order is the one they have.
        let ((grid, _), sorted) = (Grid::new(x, reach), Sorted::new(x));
        lists.make(n, (WIDE, n), parallel, &|i, list| {
            if i < x.len() {
                grid.list(&sorted, x[i], reach, i as u32, list);
            }
        });
        walls.find(model, store, (&grid, &sorted), partners, reach, parallel);
        // The last one is nobody, with whom lists are filled up.
        pack.clear();
        pack.resize(n + 1, Pack::default());
        acceleration.resize(n, [0.0; 3]);
        next.resize(n, 0.0);
        sums.resize(n.div_ceil(CHUNK), Sums::default());
        scratch.made = true;
        self.books.sorts += 1;
    }

    /// One substep from `time` \[s\] after the start; the largest speed after it \[m/s\].
    fn substep(&mut self, time: f64, dt: f64) -> f64 {
        let parallel = self.parallel();
        let Self { model, store, scratch, partners, books, start, length } = self;
        let model = *model;
        let mut gravity = vec![[0.0; 3]; model.liquids.len()];
        for action in &model.gravity {
            let share = action.share(*start + time, *start + time + dt);
            for (g, _) in gravity.iter_mut().zip(&action.acts).filter(|(_, acts)| **acts) {
                *g = cosplat_core::boundary::add(*g, scale(action.acceleration, share));
            }
        }
        let Scratch { lists, walls, pack, acceleration, next, sums, compression, projection, thick, .. } =
            &mut **scratch;
        walls.place(model, partners);
        let pass = Pass { model, lists, gravity: &gravity, dt, parallel };
        if model.params.pressure == Pressure::Incompressible {
            let end = *start + time + dt;
            let mut parts = Parts { pass, store, pack, walls, partners, acceleration, sums, thick, books, end };
            let (solved, spread) = projection.substep(&mut parts);
            books.solved.add(solved);
            books.thick += spread;
            let lost = std::mem::take(&mut books.pressed);
            store.dissipated += lost;
            books.returned += (-lost).max(0.0);
        } else {
            // Densities first, from velocities before the impulses: those that samples show know what pressed on them in
            // the last window. With densities last, what a sample yields in a window would be missing from them, and each
            // window would make `(p A W)²/(2 m)` of energy for a mass m with the area A; so the exchange is a leapfrog.
            if walls.slides() {
                pass.unpressed(store, &mut pack[..store.len()]);
                walls.slide(&Liquids { model, pack, gravity: &gravity, parallel });
            }
            compression.pass(&pass, store, walls, next);
            std::mem::swap(next, &mut store.rho);
            pass.pack(store, &mut pack[..store.len()]);
            walls.extrapolate(&Liquids { model, pack, gravity: &gravity, parallel });
            walls.ease(&Liquids { model, pack, gravity: &gravity, parallel }, partners, *length);
            let around = Around { pass: &pass, store, pack, compression };
            pass.accelerate(store, pack, walls, &around, (acceleration, sums));
            walls.impulses(&Liquids { model, pack, gravity: &gravity, parallel }, acceleration, dt);
            partners.book(model, walls, dt);
            walls.refresh(model, partners);
            pass.kick(acceleration, store, pack, sums);
            if model.is_thick() {
                books.thick += thick.spread(&pass, store, &mut pack[..], walls, sums);
            }
            let driven = driven(model, store, *start + time + dt);
            drive(model, store, pack, books, &driven);
        }
        let Store { x, v, .. } = &mut **store;
        for_chunks(parallel, x, &mut vec![(); sums.len()], &|c, x, ()| {
            for (x, v) in x.iter_mut().zip(&v[c * CHUNK..]) {
                *x = cosplat_core::boundary::add(*x, scale(*v, dt));
            }
        });
        partners.drift(dt);
        books.supplied += pulled(model, store, *start + time, *start + time + dt);
        let (mut speed, mut most) = (0.0, 0.0);
        for sum in sums.iter() {
            speed = largest(sum.speed, speed);
            most = largest(sum.acceleration, most);
            store.dissipated += dt * sum.lost;
            books.supplied += dt * sum.driven;
            let force = sum.weight.plus(sum.walls);
            let impulse = Wrench { linear: scale(force.linear, dt), angular: scale(force.angular, dt) };
            books.external = books.external.plus(impulse);
        }
        store.acceleration = most.sqrt();
        books.boundary = walls.pieces.len() as u64;
        speed.sqrt()
    }
}
