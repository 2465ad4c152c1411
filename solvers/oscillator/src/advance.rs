//! One step: the exact flow between two switches of an influence, and the books.

use cosplat_core::boundary::{Impulses, Wrench};
use cosplat_core::plugin::{BodyState, BoundaryOutput, Budget, Energy, Outputs, PluginError, Report, Step};

use crate::V3;
use crate::budget::Pull;
use crate::heard::Heard;
use crate::model::Model;
use crate::modes::{Cubic, Motion};
use crate::plugin::State;

/// A step in progress, on a copy of the state.
#[derive(Clone, Debug)]
pub(crate) struct Stage<'a> {
    model: &'a Model,
    state: State,
    heard: Heard,
    external: Budget,
    /// Work of influences without a potential energy \[J\].
    supplied_j: f64,
    received: Vec<Budget>,
}

impl<'a> Stage<'a> {
    /// Starts a step.
    pub(crate) fn new(model: &'a Model, state: &State, heard: Heard) -> Self {
        let received = vec![Budget::default(); model.couplings.len()];
        Self { model, state: state.clone(), heard, external: Budget::default(), supplied_j: 0.0, received }
    }

    fn kick(&mut self, body: usize, impulse: V3) -> Budget {
        let (mass, x) = (self.model.bodies[body].mass, self.state.position[body]);
        let mut v = self.state.velocity[body].into();
        let budget = Budget::kick(impulse.into(), mass, x.into(), &mut v);
        self.state.velocity[body] = v.into();
        budget
    }

    /// Takes the impulses that act at once.
    pub(crate) fn kick_from_partners(&mut self) {
        for (i, coupling) in self.model.couplings.iter().enumerate() {
            if let Some((impulse, false)) = self.heard.impulses[i] {
                let budget = self.kick(coupling.own, impulse);
                self.received[i].add(budget);
            }
        }
    }

    /// Takes sudden outside impulses of the moments `start..end` \[s\].
    pub(crate) fn kick_from_outside(&mut self, start: f64, end: f64) {
        for influence in &self.model.influences {
            if influence.begins_in(start, end) {
                for &body in &influence.bodies {
                    let momentum = self.state.velocity[body] * self.model.bodies[body].mass;
                    let Some((impulse, ..)) = influence.blow(self.state.position[body], momentum, V3::zeros()) else {
                        continue;
                    };
                    let budget = self.kick(body, impulse);
                    self.external.add(budget);
                    self.supplied_j += budget.work_j;
                }
            }
        }
    }

    /// Exact flow from `from` to `to` \[s\] after the start of the step; no influence switches inside.
    pub(crate) fn flow(&mut self, step: &Step, from: f64, to: f64) {
        let (model, length) = (self.model, to - from);
        if length <= 0.0 {
            return;
        }
        let start = self.state.position.clone();
        let middle = step.start_s + 0.5 * (from + to);
        let mut force = vec![<Cubic>::default(); model.bodies.len()];
        let mut add = |body: usize, part: &Cubic, sign: f64| {
            for (sum, c) in force[body].iter_mut().zip(part) {
                *sum += c * sign;
            }
        };
        let outside: Vec<Pull> = (0..model.bodies.len())
            .map(|i| {
                let acting = model.influences.iter().filter(|f| f.acts_at(middle) && f.bodies.contains(&i));
                Pull::constant(acting.map(|f| f.force(model.bodies[i].mass)).sum())
            })
            .collect();
        let springs: Vec<Pull> = model
            .springs
            .iter()
            .map(|s| {
                let ends = start[s.a] - s.b.map_or_else(V3::zeros, |b| start[b]);
                Pull { stiffness: s.stiffness, ..Pull::constant((s.rest - ends) * s.stiffness) }
            })
            .collect();
        let crossing: Vec<Pull> = (0..model.couplings.len()).map(|i| self.crossing(i, step, from)).collect();
        outside.iter().enumerate().for_each(|(i, pull)| add(i, &pull.force, 1.0));
        for (spring, pull) in model.springs.iter().zip(&springs) {
            add(spring.a, &pull.force, 1.0);
            if let Some(b) = spring.b {
                add(b, &pull.force, -1.0);
            }
        }
        model.couplings.iter().zip(&crossing).for_each(|(c, pull)| add(c.own, &pull.force, 1.0));

        let motion = model.modes.motion(&self.state.velocity, &force, length);

        for (i, pull) in outside.iter().enumerate() {
            self.external.add(pull.over(length, start[i], &motion[i]));
        }
        for influence in model.influences.iter().filter(|f| f.acts_at(middle) && !f.has_potential()) {
            let works =
                influence.bodies.iter().map(|&i| influence.force(model.bodies[i].mass).dot(&motion[i].displacement));
            self.supplied_j += works.sum::<f64>();
        }
        for (spring, pull) in model.springs.iter().zip(&springs) {
            self.external.add(match spring.b {
                None => pull.over(length, start[spring.a], &motion[spring.a]),
                // Impulses on the two ends cancel; (x_a - x_b) × F_a stays where the rest vector is not zero.
                Some(b) => {
                    let pair = pull.over(length, start[spring.a] - start[b], &motion[spring.a].from(&motion[b]));
                    Budget { wrench: Wrench { linear: [0.0; 3], ..pair.wrench }, ..pair }
                }
            });
        }
        for (i, (coupling, pull)) in model.couplings.iter().zip(&crossing).enumerate() {
            self.received[i].add(pull.over(length, start[coupling.own], &motion[coupling.own]));
        }
        for (i, motion) in motion.iter().enumerate() {
            self.state.position[i] += motion.displacement;
            self.state.velocity[i] = motion.velocity;
        }
    }

    /// Force through coupling `i` from `from` \[s\] after the start of the step on.
    fn crossing(&self, i: usize, step: &Step, from: f64) -> Pull {
        let coupling = &self.model.couplings[i];
        if let Some(path) = &self.heard.paths[i] {
            let x0 = self.state.position[coupling.own];
            return Pull::towards(coupling.stiffness, coupling.preload, x0, &shifted(path, from));
        }
        match self.heard.impulses[i] {
            Some((impulse, true)) => Pull::constant(impulse / step.length_s),
            _ => Pull::default(),
        }
    }

    /// Checks that the state still is one.
    pub(crate) fn check(&self, window: u64) -> Result<(), PluginError> {
        let all = self.state.position.iter().zip(&self.state.velocity);
        for (body, (x, v)) in self.model.bodies.iter().zip(all) {
            if !x.iter().chain(v.iter()).all(|c| c.is_finite()) {
                return Err(PluginError::Physics(format!(
                    "body `{}` is no longer finite in window {window}",
                    body.name
                )));
            }
        }
        Ok(())
    }

    /// State and budgets at time `t` \[s\].
    pub(crate) fn report(&self, t: f64, flows: u64) -> Report {
        let bodies: Vec<BodyState> = (0..self.model.bodies.len()).map(|i| self.body(i)).collect();
        let kinetic = self.model.bodies.iter().zip(&self.state.velocity).map(|(b, v)| 0.5 * b.mass * v.norm_squared());
        let energy = Energy {
            kinetic_j: kinetic.sum(),
            potential_j: self.model.potential(&self.state.position, t),
            dissipated_j: 0.0,
        };
        let interfaces = self.model.couplings.iter().zip(&self.received).map(|(c, budget)| budget.report(c.id));
        Report {
            substeps: flows,
            substep_bound_by: "nothing: a step is exact at any length".into(),
            bodies,
            external: self.external.wrench,
            supplied_j: self.supplied_j,
            energy,
            interfaces: interfaces.collect(),
            ..Report::default()
        }
    }

    fn body(&self, i: usize) -> BodyState {
        let (body, x, v) = (&self.model.bodies[i], self.state.position[i], self.state.velocity[i]);
        BodyState::of_points(body.mass, &[x.into()], &[v.into()], &[body.position.into()])
    }

    /// Everything the step answers, at time `t` \[s\].
    pub(crate) fn outputs(&self, t: f64, flows: u64) -> Outputs {
        let coupled = self.model.bodies.iter().enumerate().filter(|(_, b)| b.coupled);
        let boundaries = coupled.map(|(i, b)| BoundaryOutput { body: b.name.clone(), state: self.state.boundary(i) });
        let given = self.model.couplings.iter().zip(&self.received).filter(|(c, _)| c.role.gives_impulses());
        let impulses = given.map(|(c, budget)| {
            let on_partner = budget.wrench.negated().linear;
            let impulses = if c.partner_is_rigid {
                Impulses::Rigid(Wrench { linear: on_partner, angular: [0.0; 3] })
            } else {
                Impulses::Samples(vec![on_partner])
            };
            (c.id, impulses)
        });
        Outputs { boundaries: boundaries.collect(), impulses: impulses.collect(), report: self.report(t, flows) }
    }

    /// The state after the step.
    pub(crate) fn into_state(self) -> State {
        self.state
    }
}

impl Motion {
    /// This motion as seen from another.
    fn from(&self, other: &Self) -> Self {
        let mut moments = self.moments;
        moments.iter_mut().zip(other.moments).for_each(|(m, o)| *m -= o);
        Self { displacement: self.displacement - other.displacement, velocity: self.velocity - other.velocity, moments }
    }
}

/// The same path with τ counted from `by` \[s\] on: Taylor's formula for a cubic.
fn shifted(path: &Cubic, by: f64) -> Cubic {
    let [a, b, c, d] = *path;
    [a + (b + (c + d * by) * by) * by, b + (c * 2.0 + d * (3.0 * by)) * by, c + d * (3.0 * by), d]
}
