//! The plugin contract around the model.

use cosplat_core::boundary::{BoundaryState, SampleStatics, Vec3};
use cosplat_core::plugin::{
    Descriptor, Inputs, InterfaceRole, Outputs, PartnerSetup, Plugin, PluginError, Pulse, Refusals, Setup,
    SetupBoundary, Signal, SolverScene, StateReader, StateSink, Step, switches,
};

use crate::V3;
use crate::advance::Stage;
use crate::heard::Heard;
use crate::model::Model;
use crate::read::read;

/// Point masses and springs, each integrated exactly.
#[derive(Clone, Debug, Default)]
pub struct Oscillator {
    model: Option<Model>,
    state: State,
}

/// All that changes in a run.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct State {
    /// \[m\].
    pub(crate) position: Vec<V3>,
    /// \[m/s\].
    pub(crate) velocity: Vec<V3>,
}

impl State {
    /// Boundary of body `i`: one sample, its point.
    pub(crate) fn boundary(&self, i: usize) -> BoundaryState {
        BoundaryState::points(&[self.position[i].into()], &[self.velocity[i].into()])
    }
}

impl Plugin for Oscillator {
    fn describe(&self) -> Descriptor {
        let summary = "Point masses and linear springs, integrated exactly";
        let features = ["links", "gravity", "acceleration-field", "point-force", "impulse", "reverse"];
        Descriptor {
            body_kinds: vec!["points".into()],
            materials: vec!["point-mass".into()],
            roles: vec![InterfaceRole::Respond, InterfaceRole::Link],
            features: features.map(String::from).into(),
            ..Descriptor::new("oscillator", env!("CARGO_PKG_VERSION"), summary)
        }
    }

    fn setup(&mut self, scene: &SolverScene) -> Result<Setup, PluginError> {
        let model = read(&self.describe(), scene)?;
        let state = State {
            position: model.bodies.iter().map(|b| b.position).collect(),
            velocity: model.bodies.iter().map(|b| b.velocity).collect(),
        };
        let boundaries = model.bodies.iter().enumerate().filter(|(_, b)| b.coupled).map(|(i, b)| SetupBoundary {
            body: b.name.clone(),
            statics: SampleStatics::equal(1, b.mass),
            state: state.boundary(i),
        });
        let setup = Setup {
            boundaries: boundaries.collect(),
            report: Stage::new(&model, &state, Heard::nothing(&model)).report(0.0, 0),
            stable_dt: None,
            particles: vec![1; model.bodies.len()],
            left_out: scene.left_out_statics("oscillator"),
        };
        self.model = Some(model);
        self.state = state;
        Ok(setup)
    }

    fn connect(&mut self, partners: &[PartnerSetup]) -> Result<(), PluginError> {
        let Some(model) = &self.model else { return Err(not_set_up()) };
        for coupling in model.couplings.iter().filter(|c| c.computes() && !c.partner_is_rigid) {
            let samples = partners.iter().find(|p| p.interface == coupling.id).map_or(1, |p| p.statics.len());
            // Links read no statics, so that none are sent; what comes with a record is checked when it is used.
            if samples > 1 {
                let what = format!("links to bodies of {samples} samples, only of one (body `{}`)", coupling.partner);
                return Err(Refusals::one("oscillator", what));
            }
        }
        Ok(())
    }

    fn advance(&mut self, step: &Step, inputs: &Inputs, pulse: &mut dyn Pulse) -> Result<Outputs, PluginError> {
        let Some(model) = &self.model else { return Err(not_set_up()) };
        let heard = Heard::new(model, inputs)?;
        let end = model.clock.seconds(step.span.to);
        let mut cuts = switches(&model.influences, step.start_s, end);
        cuts.push(end);
        let mut stage = Stage::new(model, &self.state, heard);
        stage.kick_from_partners();
        let mut from = 0.0;
        for (i, &cut) in cuts.iter().enumerate() {
            let last = i + 1 == cuts.len();
            let to = if last { step.length_s } else { cut - step.start_s };
            stage.kick_from_outside(if i == 0 { step.start_s } else { cuts[i - 1] }, cut);
            stage.flow(step, from, to);
            from = to;
            if pulse.beat(i as u64 + 1, cuts.len() as u64) == Signal::Abort {
                return Err(PluginError::Aborted);
            }
        }
        stage.check(step.window)?;
        let outputs = stage.outputs(end, cuts.len() as u64);
        self.state = stage.into_state();
        Ok(outputs)
    }

    fn save(&self, sink: &mut dyn StateSink) {
        let plain = |values: &[V3]| -> Vec<Vec3> { values.iter().map(|&v| v.into()).collect() };
        sink.vec3s(&plain(&self.state.position));
        sink.vec3s(&plain(&self.state.velocity));
    }

    fn restore(&mut self, state: &[u8]) -> Result<(), PluginError> {
        let bodies = self.state.position.len();
        let mut reader = StateReader::new(state);
        let position = reader.vec3s("positions", bodies)?;
        let velocity = reader.vec3s("velocities", bodies)?;
        reader.end()?;
        let vectors = |values: Vec<Vec3>| values.into_iter().map(V3::from).collect();
        self.state = State { position: vectors(position), velocity: vectors(velocity) };
        Ok(())
    }
}

fn not_set_up() -> PluginError {
    PluginError::Unsupported("the oscillator solver cannot advance before it has a scene".into())
}
