//! Substeps: their length, the sequence of passes, and the guard.

use cosplat_core::boundary::{Vec3, Wrench, norm, scale};
use cosplat_core::plugin::{PluginError, Pulse, Signal};

use crate::confine::confine;
use crate::flux::{Tensor, across_sides, add_tensor, sums, work};
use crate::grid::{Faces, Grid};
use crate::march::{Parts, lifted, marched};
use crate::model::Model;
use crate::multigrid::{Multigrid, Solved};
use crate::particles::drift;
use crate::project::Projection;
use crate::scalar::{carry, mean};
use crate::sides::{pad_field, pad_velocity};
use crate::solids::Solids;
use crate::store::Store;

/// Cells below which one thread is faster than several.
const SERIAL_BELOW: usize = 8000;
/// Divergence that the first guess of a substep may keep, over that of its end.
const ROUGH: f64 = 10.0;
/// Speed \[m/s\] above which air is no longer incompressible: three tenths of the speed of sound.
const FASTEST: f64 = 100.0;

/// What happened in one step of the coupling.
#[derive(Clone, Debug, Default)]
pub(crate) struct Books {
    /// Walls, sides, buoyancy and confinement, about the origin.
    pub(crate) external: Wrench,
    /// Work of buoyancy and confinement \[J\].
    pub(crate) pushed: f64,
    /// Substeps.
    pub(crate) substeps: u64,
    /// Term that bound the last one.
    pub(crate) bound: String,
    /// Iterations of projections, and projections that ended above their tolerance.
    pub(crate) iterations: u64,
    pub(crate) unfinished: u64,
    /// Largest divergence left, times the edge of a cell, over the largest speed.
    pub(crate) divergence: f64,
}

/// Working memory: nothing in it outlives a substep.
#[derive(Clone, Debug)]
pub(crate) struct Scratch {
    pub(crate) multigrid: Multigrid,
    tensor: Tensor,
    guess: Faces,
    before: Faces,
    body: Faces,
    first: Vec<f64>,
    second: Vec<f64>,
    q: Vec<f64>,
    b: Vec<f64>,
}

impl Scratch {
    /// Spoils what must not be read before it is written.
    #[cfg(test)]
    pub(crate) fn spoil(&mut self, which: usize, value: f64) {
        let Self { tensor, guess, before, body, first, second, q, b, .. } = self;
        match which {
            0 => tensor.iter_mut().for_each(|t| t.fill(value)),
            1 => guess.iter_mut().for_each(|t| t.fill(value)),
            2 => body.iter_mut().for_each(|t| t.fill(value)),
            3 => first.fill(value),
            4 => second.fill(value),
            5 => q.fill(value),
            6 => b.fill(value),
            7 => before.iter_mut().for_each(|t| t.fill(value)),
            _ => self.multigrid.spoil(value),
        }
    }

    pub(crate) fn new(grid: &Grid) -> Self {
        let multigrid = Multigrid::new(grid.n);
        let none = vec![0.0; multigrid.matrix.size()];
        let tensor = std::array::from_fn(|_| grid.field());
        let [guess, before, body] = std::array::from_fn(|_| grid.faces());
        let [first, second] = std::array::from_fn(|_| grid.field());
        Self { multigrid, tensor, guess, before, body, first, second, q: none.clone(), b: none }
    }

    /// Numbers on the finest level of the pressure.
    pub(crate) fn pressures(&self) -> usize {
        self.q.len()
    }
}

/// One step of the coupling in progress.
pub(crate) struct Course<'a> {
    pub(crate) model: &'a Model,
    pub(crate) store: &'a mut Store,
    pub(crate) scratch: &'a mut Scratch,
    pub(crate) solids: Solids,
    pub(crate) books: Books,
    /// Start and length \[s\].
    pub(crate) start: f64,
    pub(crate) length: f64,
}

/// Largest speed along each axis \[m/s\].
fn speeds(u: &Faces) -> Vec3 {
    // Not `max`: what is no number must be seen.
    [0, 1, 2].map(|a| u[a].iter().fold(0.0, |m, v| if v.is_nan() || v.abs() > m { v.abs() } else { m }))
}

/// Largest stable substep \[s\] and what binds it, for speeds along the axes \[m/s\] and gravity \[m/s²\].
pub(crate) fn stable(model: &Model, speeds: Vec3, gravity: Vec3) -> (f64, String) {
    let h = model.grid.h;
    let mut best = (model.params.most, "maximum given by the user".to_owned());
    let mut bind = |dt: f64, why: &dyn Fn() -> String| {
        if dt < best.0 {
            best = (dt, why());
        }
    };
    let courant = model.params.courant;
    bind(courant * h / speeds.iter().sum::<f64>(), &|| format!("speed of the gas (Courant number {courant})"));
    // Heun's rule takes decay rates up to 2/dt, and the stress of the fastest mode has 16 ν/h².
    bind(0.1 * h * h / model.nu, &|| "viscosity".to_owned());
    let lift = (model.heavier * norm(gravity)).abs();
    bind(0.5 * (h / lift).sqrt(), &|| "buoyancy".to_owned());
    best
}

/// A wrench times a number.
pub(crate) fn scaled(w: Wrench, s: f64) -> Wrench {
    Wrench { linear: scale(w.linear, s), angular: scale(w.angular, s) }
}

impl Course<'_> {
    fn parallel(&self) -> bool {
        self.model.threads > 1 && self.model.grid.cells() >= SERIAL_BELOW
    }

    /// Covers the step.
    pub(crate) fn run(&mut self, pulse: &mut dyn Pulse, pool: Option<&rayon::ThreadPool>) -> Result<(), PluginError> {
        self.solids.place(&self.model.grid, self.model.sides);
        let mut time = 0.0;
        while time < self.length {
            let now = self.start + time;
            let mut fast = speeds(&self.store.u);
            let others = norm(self.model.ambient(now)).max(self.solids.speed());
            fast[0] = fast[0].max(others);
            let (bound_dt, bound) = stable(self.model, fast, self.model.gravity(now, now + self.length));
            let count = ((self.length - time) / bound_dt - 1e-9).ceil().max(1.0);
            let dt = (self.length - time) / count;
            self.books.bound = if self.length < bound_dt { "coupling window".to_owned() } else { bound };
            match pool.filter(|_| self.parallel()) {
                Some(pool) => pool.install(|| self.substep(now, dt)),
                None => self.substep(now, dt),
            }
            self.books.substeps += 1;
            let speed = speeds(&self.store.u).into_iter().fold(0.0, |m, v| if v.is_nan() || v > m { v } else { m });
            if speed.is_nan() || speed > FASTEST {
                return Err(PluginError::Physics(format!(
                    "the smoke solver lost the motion at t = {now:.6e} s: gas moves at {speed:.3e} m/s; above \
                     {FASTEST} m/s it is not incompressible; a smaller `courant` or a shorter window would help"
                )));
            }
            time = if count > 1.0 { time + dt } else { self.length };
            if pulse.beat(self.books.substeps, self.books.substeps + count as u64 - 1) == Signal::Abort {
                return Err(PluginError::Aborted);
            }
        }
        self.books.external = self.books.external.plus(self.solids.external);
        Ok(())
    }

    /// One substep from `now` \[s\].
    fn substep(&mut self, now: f64, dt: f64) {
        let parallel = self.parallel();
        let Self { model, store, scratch, solids, books, .. } = self;
        let (model, grid) = (*model, &model.grid);
        let (sides, ambient) = (model.sides, model.ambient(now));
        let lift = scale(model.gravity(now, now + dt), 0.25 * model.heavier);
        let parts = Parts { grid, sides, parallel };
        solids.pull(grid);
        let Scratch { multigrid, tensor, guess, before, body, first, second, q, b } = &mut **scratch;

        // A first guess of the velocity at the end.
        pad_velocity(grid, sides, ambient, &mut store.u);
        solids.plugs.close(ambient, &solids.pull, &mut store.u);
        pad_field(grid, sides, &store.u, &mut store.c);
        for t in tensor.iter_mut() {
            t.fill(0.0);
        }
        add_tensor(grid, &store.u, model.nu, 0.5, tensor, parallel);
        let pushed = (model.params.confinement > 0.0).then(|| confine(grid, &store.u, model.params.confinement));
        let by = dt / grid.h;
        guess.clone_from(&store.u);
        for a in 0..3 {
            let pushed = pushed.as_ref().map(|f| &f[a][..]);
            lifted(&parts, a, lift[a], [&store.c, &store.c], pushed, &mut body[a]);
            marched(&parts, a, &store.u[a], (tensor, 2.0), &body[a], dt, &mut guess[a]);
        }
        let (tolerance, most) = (model.params.divergence, model.params.iterations);
        let projection = Projection { grid, sides, ratio: &solids.ratio, pull: &solids.pull, most, parallel };
        projection.prepare(multigrid);
        q.iter_mut().zip(&store.pressure).for_each(|(q, p)| *q = by * p);
        let (rough, _) = projection.solve(ROUGH * tolerance, guess, q, b, multigrid, None);
        books.iterations += rough.iterations;
        pad_velocity(grid, sides, ambient, guess);
        solids.plugs.close(ambient, &solids.pull, guess);

        // Heun's rule: the mean of what both velocities carry.
        first.clone_from(&store.c);
        carry(grid, &store.u, &store.c, dt, first, parallel);
        pad_field(grid, sides, guess, first);
        second.clone_from(first);
        carry(grid, guess, first, dt, second, parallel);
        add_tensor(grid, guess, model.nu, 0.5, tensor, parallel);
        for a in 0..3 {
            let pushed = pushed.as_ref().map(|f| &f[a][..]);
            lifted(&parts, a, lift[a], [&store.c, first], pushed, &mut body[a]);
        }
        mean(&mut store.c, second);
        model.source.iter().for_each(|&cell| store.c[cell] = 1.0);
        std::mem::swap(&mut store.u, before);
        store.u.clone_from(guess);
        for a in 0..3 {
            marched(&parts, a, &before[a], (tensor, 1.0), &body[a], dt, &mut store.u[a]);
        }

        let mass = model.cell_mass();
        let convected = scaled(across_sides(grid, sides, tensor), mass * by);
        let pushed = scaled(sums(grid, sides, body).0, mass * dt);
        let (solved, limit) = projection.solve(tolerance, &mut store.u, q, b, multigrid, Some(guess));
        store.pressure.iter_mut().zip(&*q).for_each(|(p, q)| *p = q / by);
        let walls = scaled(projection.of_walls(q), mass);
        books.external = books.external.plus(convected).plus(pushed).plus(walls);
        books.pushed += mass * dt * work(grid, sides, body, [before, &store.u]);
        books.take(solved, limit, tolerance);
        solids.book(grid, sides, &store.u, guess, mass, dt);
        pad_velocity(grid, sides, ambient, &mut store.u);
        solids.plugs.close(ambient, &solids.pull, &mut store.u);
        drift(model, before, &store.u, &mut store.x, now, dt, parallel);
    }
}

impl Books {
    fn take(&mut self, solved: Solved, limit: f64, tolerance: f64) {
        self.iterations += solved.iterations;
        self.unfinished += u64::from(solved.left > limit);
        if limit > 0.0 {
            self.divergence = self.divergence.max(solved.left / limit * tolerance);
        }
    }
}

/// Takes the divergence out of the velocity at t = 0, with the static solids in it.
pub(crate) fn begin(model: &Model, store: &mut Store, scratch: &mut Scratch) {
    let (grid, sides, ambient) = (&model.grid, model.sides, model.ambient(0.0));
    let mut solids = Solids { filled: model.fixed.clone(), ..Solids::default() };
    solids.place(grid, sides);
    solids.pull(grid);
    pad_velocity(grid, sides, ambient, &mut store.u);
    solids.plugs.close(ambient, &solids.pull, &mut store.u);
    let (ratio, pull, most) = (&solids.ratio, &solids.pull, model.params.iterations);
    let projection = Projection { grid, sides, ratio, pull, most, parallel: false };
    projection.prepare(&mut scratch.multigrid);
    let tolerance = model.params.divergence;
    projection.solve(tolerance, &mut store.u, &mut scratch.q, &mut scratch.b, &mut scratch.multigrid, None);
    pad_velocity(grid, sides, ambient, &mut store.u);
    solids.plugs.close(ambient, &solids.pull, &mut store.u);
}
