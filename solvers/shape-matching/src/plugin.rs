//! The plugin contract around the model.

use cosplat_core::boundary::{SampleStatics, Wrench};
use cosplat_core::plan::BoundaryForm;
use cosplat_core::plugin::{
    BoundaryOutput, Descriptor, Inputs, InterfaceRole, Moving, Outputs, Plugin, PluginError, Pulse, Setup,
    SetupBoundary, SolverScene, StateReader, StateSink, Step,
};
use cosplat_core::visual::{VisualForm, VisualState};
use serde_json::json;

use crate::V3;
use crate::model::{Model, State};
use crate::read::read;
use crate::report::pose;
use crate::step::{Given, run};

/// Rigid bodies by shape matching.
#[derive(Debug, Default)]
pub struct ShapeMatching {
    model: Option<Model>,
    state: State,
}

impl Plugin for ShapeMatching {
    fn describe(&self) -> Descriptor {
        let summary = "Rigid bodies as particles held together by shape matching, with contact and friction";
        let number = |what: &str| json!({ "type": "number", "exclusiveMinimum": 0, "description": what });
        Descriptor {
            body_kinds: ["box", "sphere", "cylinder", "mesh"].map(String::from).into(),
            materials: vec!["rigid".into()],
            roles: vec![InterfaceRole::Respond],
            boundary: BoundaryForm::Proxy,
            visual: Some(VisualForm::Pose),
            features: ["statics", "gravity", "acceleration-field", "point-force", "impulse"].map(String::from).into(),
            params_schema: json!({
                "type": "object",
                "additionalProperties": false,
                "properties": {
                    "max_substep_s": number("Longest substep [s]; default 5e-4"),
                    "contact_turns": number("Turns in which contact is solved in a substep; default 20")
                }
            }),
            ..Descriptor::new("shape-matching", env!("CARGO_PKG_VERSION"), summary)
        }
    }

    fn setup(&mut self, scene: &SolverScene) -> Result<Setup, PluginError> {
        let model = read(&self.describe(), scene)?;
        self.state = State { bodies: model.bodies.iter().map(|b| b.start).collect(), dissipated: 0.0 };
        let coupled = model.bodies.iter().enumerate().filter(|(_, b)| b.coupled);
        let boundaries = coupled.map(|(i, b)| SetupBoundary {
            body: b.name.clone(),
            statics: SampleStatics::default(),
            state: model.record(i, &self.state, 0.0, [V3::zeros(); 2], 0.0),
        });
        let setup = Setup {
            boundaries: boundaries.collect(),
            report: model.report(&self.state, 0.0, None),
            stable_dt: None,
            particles: model.bodies.iter().map(|b| b.particles).collect(),
            left_out: Vec::new(),
        };
        self.model = Some(model);
        Ok(setup)
    }

    fn advance(&mut self, step: &Step, inputs: &Inputs, pulse: &mut dyn Pulse) -> Result<Outputs, PluginError> {
        let Some(model) = &self.model else {
            return Err(PluginError::Contract("shape matching is asked to advance before it has a scene".into()));
        };
        let given = given(model, inputs)?;
        let mut state = self.state.clone();
        let books = run(model, &mut state, &given, step, pulse)?;
        let end = model.clock.seconds(step.span.to);
        let coupled = model.bodies.iter().enumerate().filter(|(_, b)| b.coupled);
        let boundaries = coupled.map(|(i, b)| BoundaryOutput {
            body: b.name.clone(),
            state: model.record(i, &state, end, books.pushed[i], step.length_s),
        });
        let (boundaries, report) = (boundaries.collect(), model.report(&state, end, Some(&books)));
        self.state = state;
        Ok(Outputs { boundaries, impulses: Vec::new(), report })
    }

    fn visual(&self, body: &str) -> Option<VisualState> {
        let model = self.model.as_ref()?;
        let (body, moving) = model.bodies.iter().zip(&self.state.bodies).find(|(b, _)| b.name == body)?;
        Some(pose(body, moving))
    }

    fn save(&self, sink: &mut dyn StateSink) {
        Moving::save(&self.state.bodies, sink);
        sink.f64(self.state.dissipated);
    }

    fn restore(&mut self, state: &[u8]) -> Result<(), PluginError> {
        let mut reader = StateReader::new(state);
        let bodies = Moving::restore(self.state.bodies.len(), &mut reader)?;
        let dissipated = reader.f64()?;
        reader.end()?;
        self.state = State { bodies, dissipated };
        Ok(())
    }
}

/// Impulses by view, checked.
fn given(model: &Model, inputs: &Inputs) -> Result<Vec<Option<Given>>, PluginError> {
    let own = |body: usize| model.bodies[body].name.as_str();
    let views: Vec<_> = model.views.iter().map(|v| (v.id, own(v.own), v.partner.as_str())).collect();
    let one = |(wrench, spread): (Wrench, bool)| Given {
        linear: wrench.linear.into(),
        angular: wrench.angular.into(),
        spread,
    };
    Ok(inputs.wrenches("shape-matching", &views)?.into_iter().map(|given| given.map(one)).collect())
}
