//! A step: cut where influences begin and end, then into equal substeps.

use std::collections::BTreeMap;

use cosplat_core::plugin::{Budget, Moving, PluginError, Pulse, Signal, Step, switches};

use crate::V3;
use crate::joints::Pushed;
use crate::model::{Model, State, Twist};
use crate::step::{budget, kick};
use crate::world::{Load, Shift, World};

/// Share of a step below which a stretch between two switches is not worth a substep of its own.
const NO_TIME: f64 = 1e-9;
/// Substeps of a step beyond which somebody has mistyped a parameter.
const MOST_SUBSTEPS: f64 = 1e7;

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

/// What a force is booked under.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Account {
    Gravity,
    /// Without a potential energy.
    Outside,
    View(usize),
}

/// Where a force acts.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Lever {
    /// At the centre of mass.
    Centre,
    /// At a point of the body, principal frame \[m\].
    Hook(V3),
    /// At a fixed point of the world, with a torque about it: what a contact gave back about the centre of mass at the
    /// start of the window. While the body moves, `(point - x) × F` turns it, so that the angular momentum about any
    /// fixed point changes by exactly what was given.
    Fixed {
        /// \[m\].
        point: V3,
        /// \[N m\].
        torque: V3,
    },
}

/// A force on a body over a substep.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Acting {
    /// \[N\].
    pub(crate) force: V3,
    pub(crate) lever: Lever,
    pub(crate) account: Account,
}

/// A step in progress.
pub(crate) struct Stage<'a> {
    pub(crate) model: &'a Model,
    pub(crate) world: &'a mut World,
    pub(crate) state: &'a mut State,
    pub(crate) external: Budget,
    /// Energy from outside, beside that of gravity \[J\].
    pub(crate) supplied_j: f64,
    pub(crate) received: Vec<Budget>,
    /// What contacts and joints gave each body.
    pub(crate) pushed: Vec<Pushed>,
    /// Bodies at the start of the substep.
    pub(crate) start_of_substep: Vec<Moving>,
    pub(crate) counters: BTreeMap<String, u64>,
    given: Vec<Option<Given>>,
    /// Bodies at the start of the step.
    start: Vec<Moving>,
    step: Step,
}

impl<'a> Stage<'a> {
    /// Starts a step: impulses that act at once are taken.
    pub(crate) fn new(
        model: &'a Model,
        world: &'a mut World,
        state: &'a mut State,
        given: Vec<Option<Given>>,
        step: &Step,
    ) -> Self {
        let start = state.bodies.clone();
        let mut received = vec![Budget::default(); model.views.len()];
        for (i, view) in model.views.iter().enumerate() {
            let body = &model.bodies[view.own];
            if let Some(Given { linear, angular, spread: false }) = given[i]
                && body.motion.is_none()
            {
                let moving = &mut state.bodies[view.own];
                let point = moving.position;
                received[i] = kick(body, moving, linear, point, angular);
            }
        }
        Self {
            model,
            world,
            state,
            external: Budget::default(),
            supplied_j: 0.0,
            received,
            pushed: vec![Pushed::default(); model.bodies.len()],
            start_of_substep: start.clone(),
            counters: BTreeMap::new(),
            given,
            start,
            step: *step,
        }
    }

    /// Covers the step; answers the substeps taken.
    pub(crate) fn run(&mut self, pulse: &mut dyn Pulse) -> Result<u64, PluginError> {
        let (first, end) = (self.step.start_s, self.model.clock.seconds(self.step.span.to));
        let least = NO_TIME * self.step.length_s;
        let mut cuts = vec![first];
        for cut in switches(&self.model.influences, first, end) {
            if cut - cuts[cuts.len() - 1] > least && end - cut > least {
                cuts.push(cut);
            }
        }
        cuts.push(end);
        let wanted = |length: f64| (length / self.model.params.substep * (1.0 - NO_TIME)).ceil().max(1.0);
        let of: f64 = cuts.windows(2).map(|c| wanted(c[1] - c[0])).sum();
        if of > MOST_SUBSTEPS || of.is_nan() {
            let what = format!("{of:.0} substeps in window {}; give a longer `substep_s`", self.step.window);
            return Err(PluginError::Unsupported(what));
        }
        let mut done = 0;
        for (i, cut) in cuts.windows(2).enumerate() {
            // What begins within the rounding of a cut begins at it.
            let until = if i + 2 == cuts.len() { cut[1] } else { cut[1] - least };
            self.begin(if i == 0 { cut[0] } else { cut[0] - least }, until);
            let n = wanted(cut[1] - cut[0]) as u64;
            let at = |k: u64| if k == n { cut[1] } else { cut[0] + (cut[1] - cut[0]) * (k as f64 / n as f64) };
            for k in 0..n {
                self.start_of_substep.clone_from(&self.state.bodies);
                self.substep(at(k), at(k + 1))?;
                self.count_travel(at(k + 1) - at(k));
                done += 1;
                if pulse.beat(done, of as u64) == Signal::Abort {
                    return Err(PluginError::Aborted);
                }
            }
        }
        self.count_gap();
        self.drive(end);
        self.check()?;
        Ok(done)
    }

    /// Begins the influences of `start..end` \[s\].
    fn begin(&mut self, start: f64, end: f64) {
        self.model.hook(self.state, start, end);
        for influence in self.model.influences.iter().filter(|i| i.begins_in(start, end)) {
            for &i in &influence.bodies {
                let (body, moving) = (&self.model.bodies[i], &mut self.state.bodies[i]);
                let blow = influence.blow(moving.position, moving.velocity * body.mass, moving.spin);
                let Some((impulse, point, angular)) = blow else { continue };
                let given = kick(body, moving, impulse, point, angular);
                self.supply(given);
            }
        }
    }

    /// All forces on body `i` in a substep around `middle` \[s\].
    pub(crate) fn acting(&self, i: usize, middle: f64) -> Vec<Acting> {
        if !self.is_free(i) {
            return Vec::new();
        }
        let mut acting: Vec<Acting> = self
            .model
            .forces(&self.state.hooks, i, middle)
            .map(|(force, arm, has_potential)| Acting {
                force,
                lever: arm.map_or(Lever::Centre, Lever::Hook),
                account: if has_potential { Account::Gravity } else { Account::Outside },
            })
            .collect();
        for (v, _) in self.model.views.iter().enumerate().filter(|(_, view)| view.own == i) {
            if let Some(Given { linear, angular, spread: true }) = self.given[v] {
                let lever = Lever::Fixed { point: self.start[i].position, torque: angular / self.step.length_s };
                acting.push(Acting { force: linear / self.step.length_s, lever, account: Account::View(v) });
            }
        }
        acting
    }

    /// Their sum at the start of the substep.
    pub(crate) fn load(&self, i: usize, acting: &[Acting]) -> Load {
        let moving = &self.state.bodies[i];
        Load { force: acting.iter().map(|a| a.force).sum(), torque: acting.iter().map(|a| a.torque_now(moving)).sum() }
    }

    /// Whether contacts and joints can move a thing.
    pub(crate) fn is_free(&self, thing: usize) -> bool {
        self.model.bodies.get(thing).is_some_and(|b| b.motion.is_none())
    }

    /// Velocities of all things at time `t` \[s\]; of walls that of their frame's origin.
    pub(crate) fn twists(&self, t: f64) -> Vec<Twist> {
        let bodies = self.model.bodies.iter().zip(&self.state.bodies).map(|(b, m)| b.twist(m));
        bodies.chain(self.model.walls.iter().map(|w| w.at(t).2)).collect()
    }

    /// Place of a wall's frame at time `t` \[s\].
    pub(crate) fn wall_place(&self, thing: usize, t: f64) -> V3 {
        self.model.walls.get(thing - self.model.bodies.len()).map_or_else(V3::zeros, |w| w.at(t).0)
    }

    /// Puts bodies with a motion told in advance where they are at time `t` \[s\].
    pub(crate) fn drive_to(&mut self, t: f64) {
        for (body, moving) in self.model.bodies.iter().zip(&mut self.state.bodies) {
            if let Some(motion) = &body.motion {
                *moving = body.driven(motion, t).0;
            }
        }
    }

    /// Books what the drives of bodies with a motion told in advance gave, up to time `end` \[s\].
    ///
    /// They take up whatever partners give and whatever the motion needs; that is outside impulse, known only from the
    /// motion. What they take from own bodies is booked where it is given.
    fn drive(&mut self, end: f64) {
        for (i, body) in self.model.bodies.iter().enumerate() {
            let Some(motion) = &body.motion else { continue };
            let before = self.start[i];
            let after = body.driven(motion, end).0;
            let wrench = after.momentum(body.mass).minus(before.momentum(body.mass));
            let mut drive = Budget { wrench, work_j: body.kinetic(&after) - body.kinetic(&before) };
            for (v, _) in self.model.views.iter().enumerate().filter(|(_, view)| view.own == i) {
                let Some(given) = self.given[v] else { continue };
                // Work at the mean velocities of the step: exact for a steady twist.
                let omega = body.twist(&before).mean(body.twist(&after)).angular;
                let way = after.position - before.position;
                let turning = given.angular - (way * 0.5).cross(&given.linear);
                let work = given.linear.dot(&way) / self.step.length_s + turning.dot(&omega);
                let taken = budget(given.linear, before.position.cross(&given.linear) + given.angular, work);
                drive.wrench = drive.wrench.minus(taken.wrench);
                drive.work_j -= taken.work_j;
                self.received[v].add(taken);
            }
            self.supply(drive);
        }
    }

    /// Books what comes from outside and has no potential energy.
    pub(crate) fn supply(&mut self, given: Budget) {
        self.supplied_j += given.work_j;
        self.external.add(given);
    }

    /// Counts something.
    pub(crate) fn count(&mut self, what: &str, n: u64) {
        *self.counters.entry(what.to_owned()).or_default() += n;
    }

    /// Notes by how much rapier set a body aside.
    pub(crate) fn count_shift(&mut self, shift: &Shift) {
        let most = self.counters.entry("largest-correction-1e-9-m".to_owned()).or_default();
        *most = (*most).max((shift.linear.norm() * 1e9) as u64);
    }

    /// Notes which part of its size the fastest body moved in a substep of that length \[s\]: below a half nothing
    /// passes through it.
    fn count_travel(&mut self, length: f64) {
        let bodies = self.model.bodies.iter().zip(&self.state.bodies).filter(|(body, _)| body.motion.is_none());
        let part = bodies.map(|(body, moving)| moving.velocity.norm() * length / body.extent).fold(0.0, f64::max);
        let most = self.counters.entry("largest-travel-1e-6".to_owned()).or_default();
        *most = (*most).max((part * 1e6) as u64);
    }

    /// The error for a body that blew up.
    pub(crate) fn blown(&self, body: usize, how: &str) -> PluginError {
        let (name, window) = (&self.model.bodies[body].name, self.step.window);
        let advice = "look for bodies that overlap at the start, or shorten `substep_s`";
        PluginError::Physics(format!("body `{name}` {how} in window {window}; {advice}"))
    }
}
