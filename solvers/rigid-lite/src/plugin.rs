//! The plugin contract around the model.

use cosplat_core::boundary::{SampleStatics, Vec3, Wrench};
use cosplat_core::plan::BoundaryForm;
use cosplat_core::plugin::{
    BoundaryOutput, Budget, Descriptor, Inputs, InterfaceRole, Moving, Outputs, Plugin, PluginError, Pulse, Setup,
    SetupBoundary, Signal, SolverScene, StateReader, StateSink, Step, switches,
};
use cosplat_core::rotation::{ANGLE, angular_velocity};
use cosplat_core::visual::{VisualForm, VisualState};

use crate::V3;
use crate::flight::substeps;
use crate::model::{Model, State};
use crate::read::read;
use crate::report::{pose, proxy, report};
use crate::step::{Given, Stage};

/// Rigid bodies without contact.
#[derive(Clone, Debug, Default)]
pub struct RigidLite {
    model: Option<Model>,
    state: State,
}

impl Plugin for RigidLite {
    fn describe(&self) -> Descriptor {
        let summary = "Rigid bodies without contact: exact flight, symplectic rotation";
        let features = ["prescribed", "gravity", "acceleration-field", "point-force", "impulse", "reverse"];
        Descriptor {
            body_kinds: ["box", "sphere", "cylinder", "points"].map(String::from).into(),
            materials: vec!["rigid".into()],
            roles: vec![InterfaceRole::Respond],
            boundary: BoundaryForm::Proxy,
            visual: Some(VisualForm::Pose),
            features: features.map(String::from).into(),
            ..Descriptor::new("rigid-lite", env!("CARGO_PKG_VERSION"), summary)
        }
    }

    fn setup(&mut self, scene: &SolverScene) -> Result<Setup, PluginError> {
        let model = read(&self.describe(), scene)?;
        let state = model.start();
        let coupled = model.bodies.iter().enumerate().filter(|(_, b)| b.coupled);
        let boundaries = coupled.map(|(i, b)| SetupBoundary {
            body: b.name.clone(),
            statics: SampleStatics::default(),
            state: proxy(&model, i, &state.bodies[i], &state.hooks, 0.0),
        });
        let free = model.bodies.iter().zip(&state.bodies).filter(|(b, _)| b.motion.is_none());
        let spin = free.map(|(b, f)| (angular_velocity(&f.turn, f.spin, b.inverse).norm(), &b.name));
        let fastest = spin.filter(|(rate, _)| *rate > 0.0).max_by(|a, b| a.0.total_cmp(&b.0));
        let none = vec![Budget::default(); model.views.len()];
        let setup = Setup {
            boundaries: boundaries.collect(),
            report: report(&model, &state, 0.0, &Budget::default(), &none),
            stable_dt: fastest.map(|(rate, name)| (ANGLE / rate, bound_by(name, rate))),
            particles: model.bodies.iter().map(|b| b.particles).collect(),
            left_out: scene.left_out_statics("rigid-lite"),
        };
        self.model = Some(model);
        self.state = state;
        Ok(setup)
    }

    fn advance(&mut self, step: &Step, inputs: &Inputs, pulse: &mut dyn Pulse) -> Result<Outputs, PluginError> {
        let Some(model) = &self.model else {
            return Err(PluginError::Unsupported("the rigid-lite solver cannot advance before it has a scene".into()));
        };
        let given = given(model, inputs)?;
        let end = model.clock.seconds(step.span.to);
        let mut cuts = switches(&model.influences, step.start_s, end);
        cuts.push(end);
        let mut stage = Stage::new(model, &self.state, given, step);
        let mut done = 0;
        for (i, &cut) in cuts.iter().enumerate() {
            let start = if i == 0 { step.start_s } else { cuts[i - 1] };
            let offset = start - step.start_s;
            let length = if i + 1 == cuts.len() { step.length_s - offset } else { cut - start };
            let planned = stage.prepare(start, cut, length)?;
            let of = done + planned.iter().sum::<u64>();
            let mut beat = || -> Signal {
                done += 1;
                if done % BEAT_EVERY == 0 || done == of { pulse.beat(done, of) } else { Signal::Continue }
            };
            stage.fly(start, length, &planned, &mut beat).ok_or(PluginError::Aborted)?;
        }
        stage.drive(end);
        stage.check(step.window)?;
        let (taken, bound) = stage.finest();
        let mut report = report(model, &stage.state, end, &stage.external, &stage.received);
        report.supplied_j = stage.supplied_j;
        report.substeps = taken;
        report.substep_bound_by = bound;
        let coupled = model.bodies.iter().enumerate().filter(|(_, b)| b.coupled);
        let boundaries = coupled.map(|(i, b)| BoundaryOutput {
            body: b.name.clone(),
            state: proxy(model, i, &stage.state.bodies[i], &stage.state.hooks, end),
        });
        let outputs = Outputs { boundaries: boundaries.collect(), impulses: Vec::new(), report };
        self.state = stage.state;
        Ok(outputs)
    }

    fn visual(&self, body: &str) -> Option<VisualState> {
        let model = self.model.as_ref()?;
        let (body, moving) = model.bodies.iter().zip(&self.state.bodies).find(|(b, _)| b.name == body)?;
        Some(pose(body, moving))
    }

    fn save(&self, sink: &mut dyn StateSink) {
        Moving::save(&self.state.bodies, sink);
        let hooks: Vec<Vec3> = self.state.hooks.iter().map(|&h| h.into()).collect();
        sink.vec3s(&hooks);
    }

    fn restore(&mut self, state: &[u8]) -> Result<(), PluginError> {
        let mut reader = StateReader::new(state);
        let bodies = Moving::restore(self.state.bodies.len(), &mut reader)?;
        let hooks = reader.vec3s("lever arms", self.state.hooks.len())?.into_iter().map(V3::from).collect();
        reader.end()?;
        self.state = State { bodies, hooks };
        Ok(())
    }
}

/// Substeps between two beats: some hundred microseconds.
const BEAT_EVERY: u64 = 256;

/// Impulses by view, checked.
fn given(model: &Model, inputs: &Inputs) -> Result<Vec<Option<Given>>, PluginError> {
    let own = |body: usize| model.bodies[body].name.as_str();
    let views: Vec<_> = model.views.iter().map(|v| (v.id, own(v.own), v.partner.as_str())).collect();
    let one = |(wrench, spread): (Wrench, bool)| Given {
        linear: wrench.linear.into(),
        angular: wrench.angular.into(),
        spread,
    };
    Ok(inputs.wrenches("rigid-lite", &views)?.into_iter().map(|given| given.map(one)).collect())
}

/// The term that binds a substep.
pub(crate) fn bound_by(body: &str, rate: f64) -> String {
    format!("rotation of `{body}`: {ANGLE} rad at {rate:.4} rad/s")
}

/// Whole substeps, or nothing where the number means that the state blew up.
pub(crate) fn counted(rate: f64, length: f64) -> Option<u64> {
    let n = substeps(rate, length);
    (n <= MOST_SUBSTEPS).then_some(n as u64)
}

/// Substeps of a step beyond which a body is not spinning but blowing up: 200 000 rad in one window.
const MOST_SUBSTEPS: f64 = 1e7;
