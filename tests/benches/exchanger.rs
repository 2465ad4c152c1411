//! The emptiest solver there is: it shows constant samples and gives constant impulses. For benchmarks of the exchange.

use std::process::ExitCode;

use cosplat_core::boundary::{BoundaryState, Impulses, SampleStatics, Samples};
use cosplat_core::control::PROTOCOL;
use cosplat_core::plan::{BoundaryForm, InterfaceId};
use cosplat_core::plugin::{
    BodyState, BoundaryOutput, Descriptor, Inputs, InterfaceRole, Outputs, Plugin, PluginError, Pulse, Report, Saves,
    Setup, SetupBoundary, SolverScene, StateReader, StateSink, Step,
};
use cosplat_core::scene::Source;

#[derive(Default)]
struct Exchanger {
    body: String,
    shown: Samples,
    gives: Vec<InterfaceId>,
    impulses: Vec<[f64; 3]>,
    steps: u64,
}

impl Exchanger {
    fn report() -> Report {
        Report { bodies: vec![BodyState::default()], substeps: 1, ..Report::default() }
    }
}

impl Plugin for Exchanger {
    fn describe(&self) -> Descriptor {
        Descriptor {
            name: "exchanger".into(),
            version: env!("CARGO_PKG_VERSION").into(),
            summary: "Constant samples and impulses, for benchmarks of the exchange".into(),
            protocol: [PROTOCOL; 2],
            body_kinds: vec!["cloud".into()],
            materials: vec!["point-mass".into()],
            roles: vec![InterfaceRole::ResolveSamples, InterfaceRole::Respond],
            boundary: BoundaryForm::SamplesF32 { normals: false },
            visual: None,
            features: Vec::new(),
            probes: Vec::new(),
            saves: Saves { bytes: true, deterministic: true },
            params_schema: serde_json::json!({ "type": "object", "additionalProperties": false }),
        }
    }

    fn setup(&mut self, scene: &SolverScene) -> Result<Setup, PluginError> {
        let [body] = &scene.bodies[..] else { return Err(PluginError::Unsupported("not one body".into())) };
        let Source::Cloud { count, .. } = body.source else {
            return Err(PluginError::Unsupported(format!("body `{}` is no cloud", body.name)));
        };
        self.body.clone_from(&body.name);
        self.gives = scene.interfaces.iter().filter(|i| i.role.gives_impulses()).map(|i| i.id).collect();
        let line = (0..count).map(|i| [i as f64 / count as f64, 0.0, 0.0]).collect();
        self.shown = Samples { position: line, velocity: vec![[0.25, 0.5, 1.0]; count], normal: Vec::new() };
        self.impulses = vec![[0.0; 3]; count];
        let ones = vec![1.0; count];
        let id = (0..count as u64).collect();
        let statics = SampleStatics { id, area_m2: ones.clone(), volume_m3: ones.clone(), mass_kg: ones };
        let state = BoundaryState::Samples(self.shown.clone());
        Ok(Setup {
            boundaries: vec![SetupBoundary { body: self.body.clone(), statics, state }],
            report: Self::report(),
            stable_dt: None,
            particles: vec![count as u64],
            left_out: Vec::new(),
        })
    }

    fn advance(&mut self, _: &Step, _: &Inputs, _: &mut dyn Pulse) -> Result<Outputs, PluginError> {
        self.steps += 1;
        let state = BoundaryState::Samples(self.shown.clone());
        let give = |&id: &InterfaceId| (id, Impulses::Samples(self.impulses.clone()));
        Ok(Outputs {
            boundaries: vec![BoundaryOutput { body: self.body.clone(), state }],
            impulses: self.gives.iter().map(give).collect(),
            report: Self::report(),
        })
    }

    fn save(&self, sink: &mut dyn StateSink) {
        sink.u64(self.steps);
    }

    fn restore(&mut self, state: &[u8]) -> Result<(), PluginError> {
        let mut reader = StateReader::new(state);
        let steps = reader.u64()?;
        reader.end()?;
        self.steps = steps;
        Ok(())
    }
}

fn main() -> ExitCode {
    cosplat_bus::run_plugin(&mut Exchanger::default())
}
