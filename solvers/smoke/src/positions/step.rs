//! Substeps: their length and the sequence of passes.

use cosplat_core::boundary::{Vec3, Wrench, add, cross, norm, scale, sub};
use cosplat_core::plugin::{PluginError, Pulse, Signal};

use super::cloud::Fixed;
use super::density::Pass;
use super::near::Pairs;
use super::sampled::Meeting;
use super::touch::{Given, Walls};
use crate::model::{at, mean};
use crate::solids::Crossed;

/// The seeds' substep \[s\], for which their viscosity is meant.
const SEED_STEP: f64 = 1e-3;
/// Way that particles and solids go in a substep, in spacings.
const COURANT: f64 = 0.15;
/// Reach of lists over that of the kernel: by how much two particles come nearer in a substep.
const SKIN: f64 = 1.0 + COURANT;
/// Share of the differences to neighbours that viscosity takes in a substep: all neighbours together hold half of the
/// density, and five times as much keeps the sign.
const MOST_SHARE: f64 = 0.2;
/// Published viscosity acts on all components, here on one; the shear of a pair is then a third against a fifteenth.
const ALONG: f64 = 5.0;
/// Particles below which one thread is faster than several.
const SERIAL_BELOW: usize = 2000;
/// Speed above which the motion is lost \[m/s\].
const FASTEST: f64 = 100.0;

/// What happened in a step of the coupling.
#[derive(Clone, Debug, Default)]
pub(crate) struct Books {
    /// Lift, walls and the air around, about the origin.
    pub(crate) external: Wrench,
    pub(crate) crossed: Vec<Crossed>,
    pub(crate) substeps: u64,
    pub(crate) bound: String,
    /// Root of the mean square, and largest, of the density over what it may be, less one, where it is positive.
    pub(crate) crowded: [f64; 2],
    /// Most particles inside solids.
    pub(crate) swallowed: usize,
}

/// A step of the coupling in progress.
pub(crate) struct Course<'a> {
    pub(crate) fixed: &'a Fixed,
    pub(crate) x: &'a mut [Vec3],
    pub(crate) v: &'a mut [Vec3],
    pub(crate) walls: Walls,
    pub(crate) meetings: Vec<Meeting<'a>>,
    pub(crate) books: Books,
}

/// Longest substep for a speed \[m/s\], in seconds, and what binds it.
pub(crate) fn stable(fixed: &Fixed, speed: f64) -> (f64, String) {
    let mut best = (fixed.params.most.min(SEED_STEP), "that of the seed, 1 ms, or the user's".to_owned());
    let mut bind = |dt: f64, why: &str| {
        if dt < best.0 {
            best = (dt, why.to_owned());
        }
    };
    bind(COURANT * fixed.spacing / speed, "speed of the particles");
    bind(SEED_STEP * MOST_SHARE / fixed.viscosity, "viscosity");
    best
}

impl Course<'_> {
    fn parallel(&self) -> bool {
        self.fixed.threads > 1 && self.x.len() >= SERIAL_BELOW
    }

    fn speed(&self) -> f64 {
        // Not `max`: what is no number must be seen.
        let worse = |most: f64, v: f64| if v.is_nan() || v > most { v } else { most };
        let own = self.v.iter().map(|&v| norm(v)).fold(0.0, worse);
        self.meetings.iter().map(Meeting::speed).fold(own.max(self.walls.speed()), worse)
    }

    /// Covers the step from `start` over `length` \[s\].
    pub(crate) fn run(
        &mut self,
        [start, length]: [f64; 2],
        pulse: &mut dyn Pulse,
        pool: Option<&rayon::ThreadPool>,
    ) -> Result<(), PluginError> {
        let mut time = 0.0;
        while time < length {
            let (bound_dt, bound) = stable(self.fixed, self.speed());
            let count = ((length - time) / bound_dt - 1e-9).ceil().max(1.0);
            let dt = (length - time) / count;
            self.books.bound = if length < bound_dt { "coupling window".to_owned() } else { bound };
            match pool.filter(|_| self.parallel()) {
                Some(pool) => pool.install(|| self.substep(start + time, dt)),
                None => self.substep(start + time, dt),
            }
            self.books.substeps += 1;
            let speed = self.speed();
            if speed.is_nan() || speed > FASTEST {
                return Err(PluginError::Physics(format!(
                    "the smoke solver lost the motion at t = {:.6e} s: particles move at {speed:.3e} m/s; a smaller \
                     `max_substep_s` or more `density_iterations` would help",
                    start + time
                )));
            }
            time = if count > 1.0 { time + dt } else { length };
            if pulse.beat(self.books.substeps, self.books.substeps + count as u64 - 1) == Signal::Abort {
                return Err(PluginError::Aborted);
            }
        }
        Ok(())
    }

    /// One substep from `now` \[s\].
    fn substep(&mut self, now: f64, dt: f64) {
        let parallel = self.parallel();
        let Self { fixed, x, v, walls, meetings, books } = self;
        let (x, v): (&mut [Vec3], &mut [Vec3]) = (x, v);
        let kernel = &fixed.kernel;
        walls.fly(dt);
        walls.find(kernel, x, parallel);
        for meeting in meetings.iter_mut() {
            meeting.find(x);
        }
        let pairs = Pairs::new(x, SKIN * kernel.reach, parallel);
        let (mut densities, mut multipliers, mut change) = (Vec::new(), Vec::new(), Vec::new());

        let pass = Pass { kernel, pairs: &pairs, walls, parallel };
        pass.densities(x, v, 0.0, &mut densities);
        let lift = scale(mean(&fixed.gravity, now, now + dt), fixed.heavier);
        let (air, dragged) = (at(&fixed.wind, now), fixed.params.drag > 0.0);
        for ((&x, v), density) in x.iter().zip(&mut *v).zip(&densities) {
            let free = (1.0 - density).max(0.0);
            let taken = if dragged { -libm::expm1(-fixed.params.drag * free * dt) } else { 0.0 };
            let gained = add(scale(lift, dt), scale(sub(air, *v), taken));
            *v = add(*v, gained);
            let linear = scale(gained, fixed.mass);
            books.external = books.external.plus(Wrench { linear, angular: cross(x, linear) });
        }
        if fixed.viscosity > 0.0 {
            pass.rubbed(x, v, ALONG * fixed.viscosity * dt / SEED_STEP, &mut change);
            v.copy_from_slice(&change);
        }

        let mut then = x.to_vec();
        for _ in 0..fixed.params.sweeps {
            then.iter_mut().zip(&*x).zip(&*v).for_each(|((then, x), v)| *then = add(*x, scale(*v, dt)));
            let pass = Pass { kernel, pairs: &pairs, walls, parallel };
            pass.multipliers(&then, v, &fixed.rest, dt, &mut multipliers);
            pass.corrections(&then, &multipliers, dt, &mut change);
            v.iter_mut().zip(&change).for_each(|(v, change)| *v = add(*v, *change));
            let mut given = Given { external: &mut books.external, crossed: &mut books.crossed };
            walls.push(kernel, &multipliers, [fixed.mass, 0.5 * fixed.spacing, dt], x, v, &mut given);
            for meeting in meetings.iter_mut() {
                meeting.stop(fixed.mass, dt, x, v, &mut books.crossed);
            }
        }
        then.iter_mut().zip(&*x).zip(&*v).for_each(|((then, x), v)| *then = add(*x, scale(*v, dt)));
        let pass = Pass { kernel, pairs: &pairs, walls, parallel };
        pass.densities(&then, v, dt, &mut densities);
        let over = || densities.iter().zip(&fixed.rest).map(|(d, rest)| (d / rest - 1.0).max(0.0));
        let mean = over().map(|e| e * e).sum::<f64>() / densities.len().max(1) as f64;
        books.crowded = [mean.sqrt(), over().fold(0.0, f64::max)];
        books.swallowed = books.swallowed.max(walls.swallowed());
        x.copy_from_slice(&then);
    }
}
