//! A small honest solver, and the ways in which it can be made to cheat.
//!
//! Beads fall, take impulses and pull on partners by springs (as resolver of a link), in eight symplectic substeps.

mod fault;
mod refuse;

use cosplat_core::boundary::{
    BoundaryState, Impulses, SampleStatics, Samples, Vec3, Wrench, add, cross, dot, norm, scale, sub,
};
use cosplat_core::control::PROTOCOL;
use cosplat_core::plan::BoundaryForm;
use cosplat_core::plugin::{
    BodyState, BoundaryOutput, Descriptor, Energy, Inputs, InterfaceReport, InterfaceRole, InterfaceView, Outputs,
    Plugin, PluginError, Pulse, Report, Saves, Setup, SetupBoundary, Signal, SolverScene, StateReader, StateSink, Step,
};
use cosplat_core::scene::{ActionKind, VelocityField};

pub(crate) use fault::Fault;

/// The solver.
#[derive(Clone, Debug)]
pub(crate) struct Beads {
    pub(crate) fault: Fault,
    scene: Option<SolverScene>,
    state: Vec<[Vec3; 2]>,
    start: Vec<[Vec3; 2]>,
    steps: u64,
    described: bool,
}

const SUBSTEPS: u64 = 8;

impl Beads {
    pub(crate) fn new(fault: Fault) -> Self {
        Self { fault, scene: None, state: Vec::new(), start: Vec::new(), steps: 0, described: false }
    }

    fn is(&self, fault: Fault) -> bool {
        self.fault == fault
    }

    fn mass(&self, i: usize) -> f64 {
        self.scene.as_ref().and_then(|s| s.bodies[i].mass_kg).unwrap_or(1.0)
    }

    fn shown(&self) -> Vec<(usize, String)> {
        let Some(scene) = &self.scene else { return Vec::new() };
        let names = scene.bodies.iter().enumerate().map(|(i, b)| (i, b.name.clone()));
        let mut shown: Vec<_> = names.filter(|(_, n)| scene.interfaces.iter().any(|v| v.own == *n)).collect();
        if self.is(Fault::HidesABody) && self.steps > 0 {
            shown.pop();
        }
        shown
    }

    fn boundary(&self, i: usize) -> BoundaryState {
        let [x, v] = self.state[i];
        BoundaryState::Samples(Samples { position: vec![x], velocity: vec![v], normal: Vec::new() })
    }

    fn report(&self, external: Wrench, interfaces: Vec<InterfaceReport>) -> Report {
        let body = |i: usize| {
            let ([x, v], m) = (self.state[i], self.mass(i));
            let linear = scale(v, m);
            BodyState {
                mass_kg: m,
                position_m: x,
                orientation: [0.0, 0.0, 0.0, 1.0],
                linear_velocity_m_s: v,
                angular_velocity_rad_s: [0.0; 3],
                momentum: Wrench { linear, angular: cross(x, linear) },
                gross_momentum: norm(linear),
                max_displacement_m: norm(sub(x, self.start[i][0])),
            }
        };
        let bodies: Vec<BodyState> = (0..self.state.len()).map(body).collect();
        let kinetic = bodies.iter().map(|b| 0.5 * dot(b.momentum.linear, b.linear_velocity_m_s)).sum();
        let lost = self.is(Fault::LosesItsEnergy) && self.steps > 0;
        Report {
            substeps: SUBSTEPS,
            substep_bound_by: if self.is(Fault::BoundByNothing) { String::new() } else { "eight a window".into() },
            bodies,
            external,
            energy: Energy { kinetic_j: if lost { f64::NAN } else { kinetic }, ..Energy::default() },
            interfaces,
            ..Report::default()
        }
    }

    fn gravity(&self) -> Vec3 {
        let actions = self.scene.iter().flat_map(|s| &s.actions);
        actions.fold([0.0; 3], |sum, a| match a.kind {
            ActionKind::Gravity { acceleration_m_s2 } => add(sum, acceleration_m_s2),
            _ => sum,
        })
    }

    /// Impulse of one interface in one substep of `h` \[s\], with the sample's place.
    fn pull(&self, view: &InterfaceView, own: usize, inputs: &Inputs, h: f64, tau: f64) -> Vec3 {
        if view.role.takes_impulses() {
            let Some(heard) = inputs.impulse(view.id) else { return [0.0; 3] };
            let factor = if self.is(Fault::DropsImpulses) { 0.0 } else { 1.0 / SUBSTEPS as f64 };
            let all = scale(heard.impulses.total(), factor);
            let clean = self.is(Fault::ThrowsNanAway) && all.iter().any(|v| !v.is_finite());
            return if clean { [0.0; 3] } else { all };
        }
        let Some(partner) = inputs.partner(view.id) else { return [0.0; 3] };
        let [c0, c1, _, _] = partner.path(0);
        let there = add(c0, scale(c1, tau));
        let k: f64 = view.links.iter().map(|l| l.stiffness_n_m).sum();
        let force = scale(sub(self.state[own][0], there), -k);
        let clean = self.is(Fault::ThrowsNanAway) && force.iter().any(|v| !v.is_finite());
        if clean { [0.0; 3] } else { scale(force, h) }
    }
}

impl Plugin for Beads {
    fn describe(&self) -> Descriptor {
        Descriptor {
            name: if self.is(Fault::ShoutsItsName) { "BEADS!".into() } else { "beads".into() },
            version: "1.0.0".into(),
            summary: if self.is(Fault::ChangesItsMind) && self.described { "Grains".into() } else { "Beads".into() },
            protocol: [PROTOCOL; 2],
            body_kinds: vec!["points".into()],
            materials: vec!["point-mass".into()],
            roles: vec![InterfaceRole::Respond, InterfaceRole::Link],
            boundary: BoundaryForm::SamplesF64 { normals: false },
            visual: None,
            features: vec!["gravity".into()],
            probes: Vec::new(),
            saves: Saves { bytes: true, deterministic: true },
            params_schema: serde_json::json!({}),
        }
    }

    fn setup(&mut self, scene: &SolverScene) -> Result<Setup, PluginError> {
        refuse::refuse(self.fault, scene)?;
        if self.is(Fault::HatesEmptyScenes) && scene.bodies.is_empty() {
            return Err(PluginError::Physics("nothing to do".into()));
        }
        let velocity = |b: &cosplat_core::scene::Body| match b.velocity {
            VelocityField::Twist { linear_m_s, .. } => linear_m_s,
            _ => [0.0; 3],
        };
        let fresh: Vec<[Vec3; 2]> = scene.bodies.iter().map(|b| [b.pose.position_m, velocity(b)]).collect();
        if !(self.is(Fault::RemembersTheLastRun) && self.state.len() == fresh.len()) {
            self.state.clone_from(&fresh);
        }
        (self.start, self.steps, self.scene, self.described) = (fresh, 0, Some(scene.clone()), true);
        let none = |v: &InterfaceView| InterfaceReport { interface: v.id, ..InterfaceReport::default() };
        let boundaries = self.shown().into_iter().map(|(i, body)| SetupBoundary {
            body,
            statics: SampleStatics {
                id: vec![0],
                area_m2: vec![0.0],
                volume_m3: vec![0.0],
                mass_kg: vec![self.mass(i)],
            },
            state: self.boundary(i),
        });
        Ok(Setup {
            boundaries: boundaries.collect(),
            report: self.report(Wrench::default(), scene.interfaces.iter().map(none).collect()),
            stable_dt: None,
            particles: vec![1; scene.bodies.len()],
            left_out: Vec::new(),
        })
    }

    fn advance(&mut self, step: &Step, inputs: &Inputs, pulse: &mut dyn Pulse) -> Result<Outputs, PluginError> {
        let Some(scene) = self.scene.clone() else { return Err(PluginError::Unsupported("no scene".into())) };
        if !matches!(self.fault, Fault::LetsNanThrough | Fault::ThrowsNanAway) {
            refuse::finite(inputs)?;
        }
        let h = step.length_s / SUBSTEPS as f64;
        let mut views: Vec<&InterfaceView> = scene.interfaces.iter().collect();
        if self.is(Fault::AddsAsItHears) {
            let heard = |v: &&InterfaceView| inputs.impulses.iter().position(|i| i.interface == v.id);
            views.sort_by_key(heard);
        }
        let mut external = Wrench::default();
        let mut rows: Vec<InterfaceReport> = Vec::new();
        for view in &scene.interfaces {
            rows.push(InterfaceReport { interface: view.id, ..InterfaceReport::default() });
        }
        for sub in 0..SUBSTEPS {
            for i in 0..self.state.len() {
                let weight = scale(self.gravity(), self.mass(i) * h);
                self.state[i][1] = add(self.state[i][1], scale(weight, 1.0 / self.mass(i)));
                if !self.is(Fault::ForgetsGravity) {
                    external = external.plus(Wrench { linear: weight, angular: cross(self.state[i][0], weight) });
                }
            }
            for view in &views {
                let Some(own) = scene.bodies.iter().position(|b| b.name == view.own) else { continue };
                let j = self.pull(view, own, inputs, h, sub as f64 * h);
                let lever = if self.is(Fault::ForgetsLeverArms) { [0.0; 3] } else { cross(self.state[own][0], j) };
                self.state[own][1] = add(self.state[own][1], scale(j, 1.0 / self.mass(own)));
                for row in rows.iter_mut().filter(|r| r.interface == view.id) {
                    row.received = row.received.plus(Wrench { linear: j, angular: lever });
                    row.gross += norm(j);
                }
            }
            for [x, v] in &mut self.state {
                *x = add(*x, scale(*v, h));
            }
            let (done, of) = (sub + 1, if self.is(Fault::BeatsBackwards) { SUBSTEPS / 2 } else { SUBSTEPS });
            if pulse.beat(done, of) == Signal::Abort && !self.is(Fault::NeverStops) {
                return Err(PluginError::Aborted);
            }
        }
        self.steps += 1;
        self.cheat(&scene);
        let boundaries = self.shown().into_iter().map(|(i, body)| BoundaryOutput { body, state: self.boundary(i) });
        let factor = if self.is(Fault::GivesTooMuch) { -1.25 } else { -1.0 };
        let given = scene.interfaces.iter().zip(&rows).filter(|(v, _)| v.role.gives_impulses());
        let given = given.map(|(v, row)| (v.id, Impulses::Samples(vec![scale(row.received.linear, factor)])));
        if self.is(Fault::ReportsOtherImpulses) {
            let first = given.clone().collect();
            for row in &mut rows {
                row.received.linear = scale(row.received.linear, 1.01);
            }
            return Ok(Outputs {
                boundaries: boundaries.collect(),
                impulses: first,
                report: self.report(external, rows),
            });
        }
        Ok(Outputs {
            boundaries: boundaries.collect(),
            impulses: given.collect(),
            report: self.report(external, rows.clone()),
        })
    }

    fn save(&self, sink: &mut dyn StateSink) {
        let state = if self.is(Fault::SavesTheBeginning) { &self.start } else { &self.state };
        sink.u64(state.len() as u64);
        for [x, v] in state {
            sink.vec3(*x);
            sink.vec3(*v);
        }
    }

    fn restore(&mut self, bytes: &[u8]) -> Result<(), PluginError> {
        let mut reader = StateReader::new(bytes);
        let (found, expected) = (reader.u64()?, self.state.len() as u64);
        if found != expected {
            return Err(cosplat_core::plugin::StateError::Count { what: "beads", found, expected }.into());
        }
        let mut state = self.state.clone();
        for bead in &mut state {
            match (reader.vec3(), reader.vec3()) {
                (Ok(x), Ok(v)) => *bead = [x, v],
                _ if self.is(Fault::TakesHalfAState) => break,
                (Err(why), _) | (_, Err(why)) => return Err(why.into()),
            }
            if self.is(Fault::RestoresRoughly) {
                *bead = bead.map(|v| v.map(|c| f64::from(c as f32)));
            }
            if self.is(Fault::RestoresBeforeItChecks) {
                self.state[0] = bead.map(|v| scale(v, 0.5));
            }
        }
        if !self.is(Fault::TakesHalfAState) {
            reader.end()?;
        }
        self.state = state;
        Ok(())
    }
}

impl Beads {
    /// What is done behind the back of the books.
    fn cheat(&mut self, scene: &SolverScene) {
        let nudge = match self.fault {
            // Far below any gate: only bits can tell.
            Fault::CountsThreads => scene.threads as f64 * 1e-15,
            Fault::KeepsSecrets => self.steps as f64 * 1e-15,
            _ => return,
        };
        for [x, _] in &mut self.state {
            x[0] += nudge;
        }
    }
}
