//! One step of all bodies: what acts on each, stretch by stretch, and the books.

use cosplat_core::plugin::{Budget, PluginError, Signal, Step};
use cosplat_core::rotation::angular_velocity;

use crate::V3;
use crate::flight::{Lever, Push, budget, fastest, fly, kick};
use crate::model::{Model, State};
use crate::plugin::{bound_by, counted};

/// Impulse of a partner on one body, angular part about the centre of mass at the start of the step.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Given {
    /// \[N s\].
    pub(crate) linear: V3,
    /// \[N m s\].
    pub(crate) angular: V3,
    /// Over the whole step, or at once at its start.
    pub(crate) spread: bool,
}

/// What a push is booked under.
#[derive(Clone, Copy, Debug)]
enum Account {
    Gravity,
    /// Without a potential energy.
    Outside,
    View(usize),
}

/// A step in progress, on a copy of the state.
pub(crate) struct Stage<'a> {
    model: &'a Model,
    start: &'a State,
    step: Step,
    given: Vec<Option<Given>>,
    pub(crate) state: State,
    pub(crate) external: Budget,
    /// Energy from outside, beside that of gravity \[J\].
    pub(crate) supplied_j: f64,
    pub(crate) received: Vec<Budget>,
    /// Substeps of each body so far.
    taken: Vec<u64>,
    /// Fastest rotation so far \[rad/s\] and whose.
    fastest: (f64, usize),
}

impl<'a> Stage<'a> {
    /// Starts a step: impulses that act at once are taken.
    pub(crate) fn new(model: &'a Model, start: &'a State, given: Vec<Option<Given>>, step: &Step) -> Self {
        let mut stage = Self {
            model,
            start,
            step: *step,
            state: start.clone(),
            external: Budget::default(),
            supplied_j: 0.0,
            received: vec![Budget::default(); model.views.len()],
            taken: vec![0; model.bodies.len()],
            fastest: (0.0, 0),
            given,
        };
        for (i, view) in model.views.iter().enumerate() {
            if let Some(Given { linear, angular, spread: false }) = stage.given[i]
                && model.bodies[view.own].motion.is_none()
            {
                let moving = &mut stage.state.bodies[view.own];
                let point = moving.position;
                stage.received[i] = kick(&model.bodies[view.own], moving, linear, point, angular);
            }
        }
        stage
    }

    /// Begins the influences of `start..end` \[s\] and counts the substeps of each free body over `length` \[s\].
    pub(crate) fn prepare(&mut self, start: f64, end: f64, length: f64) -> Result<Vec<u64>, PluginError> {
        self.model.hook(&mut self.state, start, end);
        for influence in self.model.influences.iter().filter(|i| i.begins_in(start, end)) {
            for &i in &influence.bodies {
                let (body, moving) = (&self.model.bodies[i], &mut self.state.bodies[i]);
                let blow = influence.blow(moving.position, moving.velocity * body.mass, moving.spin);
                let Some((impulse, point, angular)) = blow else { continue };
                let given = kick(body, moving, impulse, point, angular);
                self.supplied_j += given.work_j;
                self.external.add(given);
            }
        }
        let mut planned = vec![0; self.model.bodies.len()];
        for (i, body) in self.model.bodies.iter().enumerate().filter(|(_, b)| b.motion.is_none()) {
            let pushes: Vec<Push> = self.pushes(i, start + 0.5 * length).iter().map(|p| p.0).collect();
            let rate = fastest(body, &self.state.bodies[i], &pushes, length);
            planned[i] = counted(rate, length).ok_or_else(|| {
                PluginError::Physics(format!(
                    "body `{}` spins at {rate:.3e} rad/s in window {}",
                    body.name, self.step.window
                ))
            })?;
            self.taken[i] += planned[i];
            if rate > self.fastest.0 {
                self.fastest = (rate, i);
            }
        }
        Ok(planned)
    }

    /// Flies all free bodies from `start` \[s\] for `length` \[s\]; nothing if told to stop.
    pub(crate) fn fly(
        &mut self,
        start: f64,
        length: f64,
        planned: &[u64],
        beat: &mut dyn FnMut() -> Signal,
    ) -> Option<()> {
        for (i, body) in self.model.bodies.iter().enumerate().filter(|(_, b)| b.motion.is_none()) {
            let acting = self.pushes(i, start + 0.5 * length);
            let pushes: Vec<Push> = acting.iter().map(|p| p.0).collect();
            let budgets = fly(body, &mut self.state.bodies[i], &pushes, length, planned[i], beat)?;
            for ((_, account), budget) in acting.iter().zip(budgets) {
                match *account {
                    Account::Gravity => self.external.add(budget),
                    Account::Outside => {
                        self.supplied_j += budget.work_j;
                        self.external.add(budget);
                    }
                    Account::View(view) => self.received[view].add(budget),
                }
            }
        }
        Some(())
    }

    /// All that pushes body `i` in a stretch around `middle` \[s\].
    fn pushes(&self, i: usize, middle: f64) -> Vec<(Push, Account)> {
        let mut pushes = Vec::new();
        for influence in self.model.influences.iter().filter(|f| f.acts_at(middle)) {
            let Some(k) = influence.bodies.iter().position(|&b| b == i) else { continue };
            if influence.is_sudden() {
                continue;
            }
            let lever = influence.hooks.map_or(Lever::Centre, |first| Lever::Hook(self.state.hooks[first + k]));
            let account = if influence.has_potential() { Account::Gravity } else { Account::Outside };
            pushes.push((Push { force: influence.force(self.model.bodies[i].mass), lever }, account));
        }
        for (v, _) in self.model.views.iter().enumerate().filter(|(_, view)| view.own == i) {
            if let Some(Given { linear, angular, spread: true }) = self.given[v] {
                let lever = Lever::Fixed { point: self.start.bodies[i].position, torque: angular / self.step.length_s };
                pushes.push((Push { force: linear / self.step.length_s, lever }, Account::View(v)));
            }
        }
        pushes
    }

    /// Moves bodies with a motion told in advance to time `end` \[s\].
    ///
    /// Their drive takes up whatever partners give and whatever the motion needs; that is outside impulse, known only
    /// from the motion.
    pub(crate) fn drive(&mut self, end: f64) {
        for (i, body) in self.model.bodies.iter().enumerate() {
            let Some(motion) = &body.motion else { continue };
            let before = self.start.bodies[i];
            let after = body.driven(motion, end).0;
            self.state.bodies[i] = after;
            let change = after.momentum(body.mass).minus(before.momentum(body.mass));
            let gained = body.kinetic(&after) - body.kinetic(&before);
            let mut drive = Budget { wrench: change, work_j: gained };
            for (v, _) in self.model.views.iter().enumerate().filter(|(_, view)| view.own == i) {
                let Some(given) = self.given[v] else { continue };
                // Work at the mean velocities of the step: exact for a steady twist.
                let omega = 0.5
                    * (angular_velocity(&before.turn, before.spin, body.inverse)
                        + angular_velocity(&after.turn, after.spin, body.inverse));
                let way = after.position - before.position;
                let turning = given.angular - (way * 0.5).cross(&given.linear);
                let work = given.linear.dot(&way) / self.step.length_s + turning.dot(&omega);
                let taken = budget(given.linear, before.position.cross(&given.linear) + given.angular, work);
                drive.wrench = drive.wrench.minus(taken.wrench);
                drive.work_j -= taken.work_j;
                self.received[v].add(taken);
            }
            self.supplied_j += drive.work_j;
            self.external.add(drive);
        }
    }

    /// Checks that the state still is one.
    pub(crate) fn check(&self, window: u64) -> Result<(), PluginError> {
        let broken = self.model.bodies.iter().zip(&self.state.bodies).find(|(_, f)| !f.is_finite());
        broken.map_or(Ok(()), |(body, _)| {
            Err(PluginError::Physics(format!("body `{}` is no longer finite in window {window}", body.name)))
        })
    }

    /// Most substeps of a body, and what bound them.
    pub(crate) fn finest(&self) -> (u64, String) {
        let most = self.taken.iter().copied().max().unwrap_or_default();
        let (rate, body) = self.fastest;
        let bound = if rate > 0.0 {
            bound_by(&self.model.bodies[body].name, rate)
        } else {
            "nothing: flight without rotation is exact".into()
        };
        (most, bound)
    }
}
