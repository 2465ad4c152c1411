//! Substeps: choice of the length, the sequence of passes, guards with rollback.

use std::ops::Range;

use cosplat_core::plugin::{PartAction, PluginError, Pulse, Push, Signal};

use crate::contact::Pairs;
use crate::fbar::FBar;
use crate::grid::{EMPTY, Grid, Substep};
use crate::kick::{AtNodes, Kicks};
use crate::law::Law;
use crate::nodes::Nodes;
use crate::particles::Tiles;
use crate::proxy::{Partner, Proxy};
use crate::real::Real;
use crate::settle::{Others, collide};
use crate::shores::Shores;
use crate::stable::{Bound, Limits, Stable};
use crate::store::Store;
use crate::swarm::{Cloud, Swarm};
use crate::tally::Tally;
use crate::topology::Topology;
use crate::walls::Walls;

/// Substeps between two choices of their length, and between two safe copies of the state.
const SEGMENT: u64 = 32;
/// Halvings of the substep before a segment is given up.
const MOST_ROLLBACKS: u32 = 6;
/// Particle-substeps between two beats of the pulse: about a tenth of a second.
const BEAT: u64 = 1_000_000;
/// Particles below which one thread is faster than several.
const SERIAL_BELOW: usize = 8000;
/// Largest `dt |C|` of a substep: above it a cell would stretch by more than half.
pub(crate) const MOST_STRETCH: f64 = 0.5;
/// Largest way of a particle in one substep, in cells.
pub(crate) const MOST_WAY: f64 = 0.5;

/// What never changes in a run.
#[derive(Clone, Debug)]
pub(crate) struct Setting<R: Real> {
    /// Grid spacing \[m\].
    pub(crate) dx: f64,
    /// Material by part: that of each body, then those of regions.
    pub(crate) laws: Vec<Law<R>>,
    /// Body by part.
    pub(crate) owners: Vec<u32>,
    /// Bodies that carry total deformation gradients.
    pub(crate) carries: Vec<bool>,
    /// Time in which particles keep the e-th part of what their motion has beside the grid's, by body; 0: none \[s\].
    pub(crate) keeps: Vec<f64>,
    /// Outside influences.
    pub(crate) actions: Vec<PartAction>,
    /// Contact among own bodies.
    pub(crate) pairs: Pairs,
    /// Rigid partners.
    pub(crate) partners: Vec<Partner>,
    /// Partners that show samples.
    pub(crate) clouds: Vec<Cloud>,
    /// Names of the bodies.
    pub(crate) names: Vec<String>,
    /// Limits of the substep.
    pub(crate) limits: Limits,
    /// Mass of the lightest particle \[kg\].
    pub(crate) lightest: f64,
    /// Volume at rest of the largest particle \[m³\].
    pub(crate) largest: f64,
    /// More than one thread.
    pub(crate) threads: bool,
}

/// What happened in one step of the coupling.
#[derive(Clone, Debug, Default)]
pub(crate) struct Books {
    /// Outside influences and walls.
    pub(crate) external: Tally,
    /// Work of outside influences without a potential energy \[J\].
    pub(crate) supplied: f64,
    /// Energy lost to plastic flow, viscosity and friction since the start of the run \[J\].
    pub(crate) dissipated: f64,
    /// Substeps.
    pub(crate) substeps: u64,
    /// Term that bound the last substep.
    pub(crate) bound: Bound,
    /// Particles whose stretch was clamped, summed over substeps.
    pub(crate) clamped: u64,
    /// Segments repeated with half the substep.
    pub(crate) rollbacks: u64,
    /// Particles put into quarantine.
    pub(crate) quarantined: u64,
    /// Places where a body touched a collider, summed over substeps.
    pub(crate) places: u64,
    /// Passes over touching places that their impulses took.
    pub(crate) passes: u64,
    /// Substeps whose contact impulses had not settled.
    pub(crate) unsettled: u64,
    /// Re-sorts.
    pub(crate) sorts: u64,
}

/// All that changes, and the grid.
#[derive(Clone, Debug)]
pub(crate) struct Sim<R: Real> {
    pub(crate) setting: Setting<R>,
    pub(crate) store: Store<R>,
    pub(crate) walls: Walls,
    shores: Shores,
    topology: Topology,
    tiles: Tiles<R>,
    f_bar: FBar<R>,
    grid: Grid<R>,
    pub(crate) contact: Nodes,
    /// Impulses of partners at the nodes.
    at_nodes: AtNodes,
    /// Particles at the start of the segment.
    safe: Store<R>,
}

/// One step of the coupling in progress.
#[derive(Clone, Debug)]
pub(crate) struct Course {
    /// Start and length \[s\].
    pub(crate) start: f64,
    pub(crate) length: f64,
    /// Stand-ins of rigid partners.
    pub(crate) proxies: Vec<Proxy>,
    /// Stand-ins of partners that show samples.
    pub(crate) swarms: Vec<Swarm>,
    /// Impulses on own samples.
    pub(crate) kicks: Kicks,
    /// What happened.
    pub(crate) books: Books,
}

impl<R: Real> Sim<R> {
    /// Around sorted particles.
    pub(crate) fn new(setting: Setting<R>, store: Store<R>, walls: Walls) -> Self {
        let mut sim = Self {
            setting,
            store,
            walls,
            shores: Shores::default(),
            topology: Topology::default(),
            tiles: Tiles::default(),
            f_bar: FBar::default(),
            grid: Grid::default(),
            contact: Nodes::default(),
            at_nodes: AtNodes::default(),
            safe: Store::default(),
        };
        sim.rebuild(true);
        sim
    }

    /// Whether work is shared among threads.
    pub(crate) fn parallel(&self) -> bool {
        self.setting.threads && self.store.len() >= SERIAL_BELOW
    }

    /// Makes the grid fit the particles' blocks.
    pub(crate) fn rebuild(&mut self, changed: bool) {
        if changed {
            self.topology = Topology::new(&self.store.blocks);
            self.grid.prepare(&self.topology);
            self.walls.prepare(&self.store.blocks, &self.setting.laws, self.setting.dx);
            self.shores.prepare(&self.topology, &self.walls.list, &self.setting.laws, self.setting.dx);
        }
        self.tiles.prepare(&self.store, self.setting.keeps.iter().any(|&t| t > 0.0));
    }

    /// Covers one step of the coupling.
    pub(crate) fn run(
        &mut self,
        course: &mut Course,
        pool: Option<&rayon::ThreadPool>,
        pulse: &mut dyn Pulse,
    ) -> Result<(), PluginError> {
        let (mut time, mut halvings) = (0.0, 0_u32);
        while time < course.length {
            let left = course.length - time;
            let mut stable = self.stable(left);
            if stable.strained {
                self.isolate_strained(course.start + time, &mut course.books)?;
                stable = self.stable(left);
            }
            course.books.bound = stable.bound;
            let count = (left / (stable.dt / f64::from(1_u32 << halvings)) - 1e-9).ceil().max(1.0);
            let (now, dt) = (count.min(SEGMENT as f64), left / count);
            self.safe.copy_from(&self.store);
            let safe = course.clone();
            let at_once = (BEAT / self.store.len().max(1) as u64).max(1);
            let (mut done, mut from) = (true, 0);
            while done && from < now as u64 {
                let to = (from + at_once).min(now as u64);
                done = match pool.filter(|_| self.parallel()) {
                    Some(pool) => pool.install(|| self.substeps(course, time, dt, from..to)),
                    None => self.substeps(course, time, dt, from..to),
                };
                from = to;
                let beats = course.books.substeps;
                if pulse.beat(beats, beats + count as u64 - to) == Signal::Abort {
                    return Err(PluginError::Aborted);
                }
            }
            if done {
                time = if now < count { time + now * dt } else { course.length };
                halvings = halvings.saturating_sub(1);
                continue;
            }
            halvings += 1;
            let given_up =
                (halvings > MOST_ROLLBACKS).then(|| (self.complaint(course.start + time, dt), self.runaways(dt)));
            let rollbacks = course.books.rollbacks + 1;
            self.store.copy_from(&self.safe);
            *course = safe;
            course.books.rollbacks = rollbacks;
            self.rebuild(true);
            self.contact.start_afresh();
            if let Some((complaint, culprits)) = given_up {
                if !self.isolate(&culprits, course.start + time, &mut course.books, &complaint)? {
                    return Err(PluginError::Physics(complaint));
                }
                halvings = 0;
            }
        }
        Ok(())
    }

    /// Several substeps of one length. False when one left the range in which its result means anything.
    fn substeps(&mut self, course: &mut Course, time: f64, dt: f64, mut which: Range<u64>) -> bool {
        which.all(|i| {
            course.books.substeps += 1;
            self.substep(course, time + i as f64 * dt, dt)
        })
    }

    /// Largest stable substep of now, no longer than `longest` \[s\], and what binds it.
    pub(crate) fn stable(&self, longest: f64) -> Stable {
        let Setting { dx, limits, laws, .. } = &self.setting;
        limits.substep(&self.store, laws, *dx, longest, self.parallel())
    }

    /// A substep of no length: where everything is on the grid now.
    pub(crate) fn still(&self) -> Substep<'_> {
        let empty = EMPTY * self.setting.lightest;
        Substep { topology: &self.topology, dx: self.setting.dx, dt: 0.0, empty, parallel: self.parallel() }
    }

    /// Averages of the volume ratios of now.
    pub(crate) fn averages(&self) -> FBar<R> {
        let mut averages = FBar::default();
        averages.average(&self.still(), &self.store, &self.setting.laws);
        averages
    }

    /// One substep. False when it left the range in which its result means anything.
    fn substep(&mut self, course: &mut Course, from: f64, dt: f64) -> bool {
        let Self { setting, store, walls, shores, topology, tiles, f_bar, grid, contact, at_nodes, .. } = self;
        let parallel = setting.threads && store.len() >= SERIAL_BELOW;
        let step = Substep { topology, dx: setting.dx, dt, empty: EMPTY * setting.lightest, parallel };
        let start = course.start + from;
        let push = Push::new(&setting.actions, setting.names.len(), start, start + dt);
        course.kicks.apply(store, setting.dx, (from + dt) / course.length);
        f_bar.average(&step, store, &setting.laws);
        tiles.fill(&step, store, (&setting.laws, f_bar), &setting.keeps);
        grid.gather(&step, &tiles.list, &tiles.extents, &push);
        course.kicks.book(&step, store, grid, at_nodes);
        if !tiles.before.is_empty() {
            grid.gather_before(&step, &tiles.before, &tiles.extents, &setting.keeps);
        }
        let (lost, _) = setting.pairs.exchange(&step, grid);
        course.books.dissipated += lost;
        let (stopped, slid) = shores.stop(&step, grid);
        course.books.external.add(&stopped);
        course.books.dissipated += slid;
        let mut others = Others {
            partners: &setting.partners,
            proxies: &mut course.proxies,
            clouds: &setting.clouds,
            swarms: &mut course.swarms,
            half: 0.5 * libm::cbrt(setting.largest),
        };
        let met = collide(&step, (store, grid), walls, &mut others, contact);
        course.books.external.add(&met.walls);
        course.books.dissipated += met.lost;
        course.books.places += met.places;
        course.books.passes += met.passes;
        course.books.unsettled += u64::from(met.unsettled);
        shores.fill(&step, grid);
        tiles.empty(&step, grid, store, &setting.laws, &setting.keeps);
        tiles.carry(&step, store, &setting.carries);
        for group in &grid.groups {
            course.books.external.add(&group.pushed);
            course.books.supplied += group.supplied;
        }
        let (mut speed, mut rate, mut strayed) = (0.0_f64, 0.0_f64, false);
        for out in &tiles.out {
            // NaN must stay: f64::max would drop it.
            speed = if out.speed.is_nan() {
                f64::NAN
            } else if speed.is_nan() {
                speed
            } else {
                speed.max(out.speed)
            };
            rate = rate.max(out.rate);
            strayed |= out.strayed;
            course.books.clamped += out.clamped;
            course.books.dissipated += out.lost;
        }
        let fine = speed.sqrt() * dt <= MOST_WAY * setting.dx && rate.sqrt() * dt <= MOST_STRETCH;
        if fine && strayed {
            course.books.sorts += 1;
            let changed = store.sort(parallel);
            self.rebuild(changed);
        }
        fine
    }

    fn complaint(&self, time: f64, dt: f64) -> String {
        let mut worst = (0.0, 0, 0);
        for (block, slot) in self.store.each() {
            let rate: f64 = (0..9).map(|k| self.store.field(slot, crate::store::C + k).powi(2)).sum();
            if rate.is_nan() || rate > worst.0 {
                worst = (rate, self.store.ids[slot / 4][slot % 4], block.body);
            }
        }
        format!(
            "the material point solver lost the motion at t = {time:.6e} s: even substeps of {dt:.3e} s stretch a cell by \
             more than half or move a particle by more than half a cell (particle {} of body {}, velocity gradient \
             {:.3e} 1/s)",
            worst.1,
            worst.2,
            worst.0.sqrt()
        )
    }
}
