//! The plugin contract around the model.

use cosplat_core::boundary::{BoundaryState, SampleStatics, Samples, Vec3};
use cosplat_core::control::PROTOCOL;
use cosplat_core::plan::{BoundaryForm, LeftOut};
use cosplat_core::plugin::{
    Descriptor, Inputs, InterfaceRole, Outputs, PartnerSetup, Plugin, PluginError, Pulse, Saves, Setup, SetupBoundary,
    Signal, SolverScene, StateReader, StateSink, Step,
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
        BoundaryState::Samples(Samples {
            position: vec![self.position[i].into()],
            velocity: vec![self.velocity[i].into()],
            normal: Vec::new(),
        })
    }
}

impl Plugin for Oscillator {
    fn describe(&self) -> Descriptor {
        let features = ["links", "gravity", "acceleration-field", "point-force", "impulse"];
        Descriptor {
            name: "oscillator".into(),
            version: env!("CARGO_PKG_VERSION").into(),
            summary: "Point masses and linear springs, integrated exactly".into(),
            protocol: [PROTOCOL, PROTOCOL],
            body_kinds: vec!["points".into()],
            materials: vec!["point-mass".into()],
            roles: vec![InterfaceRole::Respond, InterfaceRole::Link],
            boundary: BoundaryForm::SamplesF64 { normals: false },
            features: features.map(String::from).into(),
            probes: Vec::new(),
            saves: Saves { bytes: true, deterministic: true },
            params_schema: serde_json::json!({ "type": "object", "properties": {}, "additionalProperties": false }),
        }
    }

    fn setup(&mut self, scene: &SolverScene) -> Result<Setup, PluginError> {
        let model = read(scene)?;
        let state = State {
            position: model.bodies.iter().map(|b| b.position).collect(),
            velocity: model.bodies.iter().map(|b| b.velocity).collect(),
        };
        let left_out = scene.statics.iter().map(|s| LeftOut {
            what: format!("static collider `{}`", s.name),
            why: "point masses have no contact".into(),
            indicator: None,
            limit: None,
            saved: "not measured".into(),
        });
        let boundaries = model.bodies.iter().enumerate().filter(|(_, b)| b.coupled).map(|(i, b)| SetupBoundary {
            body: b.name.clone(),
            statics: SampleStatics { id: vec![0], area_m2: vec![0.0], volume_m3: vec![0.0], mass_kg: vec![b.mass] },
            state: state.boundary(i),
        });
        let setup = Setup {
            boundaries: boundaries.collect(),
            report: Stage::new(&model, &state, Heard::nothing(&model)).report(0.0, 0),
            stable_dt: None,
            particles: vec![1; model.bodies.len()],
            left_out: left_out.collect(),
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
                return Err(PluginError::Unsupported(format!(
                    "the oscillator solver does not support: links to bodies of {samples} samples, only of one (body `{}`)",
                    coupling.partner
                )));
            }
        }
        Ok(())
    }

    fn advance(&mut self, step: &Step, inputs: &Inputs, pulse: &mut dyn Pulse) -> Result<Outputs, PluginError> {
        let Some(model) = &self.model else { return Err(not_set_up()) };
        let heard = Heard::new(model, inputs)?;
        let end = model.clock.seconds(step.span.to);
        let mut cuts = model.switches(step.start_s, end);
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
