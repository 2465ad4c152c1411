//! The plugin contract around the model.

use cosplat_core::boundary::{SampleStatics, Wrench};
use cosplat_core::plan::BoundaryForm;
use cosplat_core::plugin::{
    BoundaryOutput, Budget, Descriptor, Inputs, InterfaceRole, Outputs, Plugin, PluginError, Pulse, Setup,
    SetupBoundary, SolverScene, StateSink, Step,
};
use cosplat_core::visual::{VisualForm, VisualState};

use crate::V3;
use crate::advance::{Given, Stage};
use crate::joints::Pushed;
use crate::model::{Model, State};
use crate::params::schema;
use crate::proxy::{Past, record};
use crate::read::read;
use crate::report::{pose, report};
use crate::save;
use crate::world::World;

/// Rigid bodies with contact, friction and joints.
#[derive(Default)]
pub struct Rigid {
    run: Option<Run>,
}

struct Run {
    model: Model,
    world: World,
    state: State,
}

impl Plugin for Rigid {
    fn describe(&self) -> Descriptor {
        let summary = "Rigid bodies with contact, friction and joints; contacts by rapier3d";
        let features = [
            "statics",
            "height-fields",
            "joints",
            "prescribed",
            "gravity",
            "acceleration-field",
            "point-force",
            "impulse",
            "reverse",
        ];
        Descriptor {
            body_kinds: ["box", "sphere", "cylinder", "mesh"].map(String::from).into(),
            materials: vec!["rigid".into()],
            roles: vec![InterfaceRole::Respond],
            boundary: BoundaryForm::Proxy,
            visual: Some(VisualForm::Pose),
            features: features.map(String::from).into(),
            params_schema: schema(),
            ..Descriptor::new("rigid", env!("CARGO_PKG_VERSION"), summary)
        }
    }

    fn setup(&mut self, scene: &SolverScene) -> Result<Setup, PluginError> {
        let (model, left_out) = read(&self.describe(), scene)?;
        let mut state = model.start();
        let mut world = World::new(&model, &state);
        let step = Step { window: 0, span: cosplat_core::time::Span { from: 0, to: 0 }, start_s: 0.0, length_s: 0.0 };
        let stage = Stage::new(&model, &mut world, &mut state, vec![None; model.views.len()], &step);
        stage.check()?;
        let springs = stage.spring_energy();
        let coupled = model.bodies.iter().enumerate().filter(|(_, b)| b.coupled);
        let boundaries = coupled.map(|(i, b)| SetupBoundary {
            body: b.name.clone(),
            statics: SampleStatics::default(),
            state: record(&model, i, &state, 0.0, &Past::default()),
        });
        let none = vec![Budget::default(); model.views.len()];
        let setup = Setup {
            boundaries: boundaries.collect(),
            report: report(&model, &state, 0.0, springs, &Budget::default(), &none),
            stable_dt: None,
            particles: vec![1; model.bodies.len()],
            left_out,
        };
        self.run = Some(Run { model, world, state });
        Ok(setup)
    }

    fn advance(&mut self, step: &Step, inputs: &Inputs, pulse: &mut dyn Pulse) -> Result<Outputs, PluginError> {
        let Some(Run { model, world, state }) = &mut self.run else {
            return Err(PluginError::Unsupported("the rigid solver cannot advance before it has a scene".into()));
        };
        let given = given(model, inputs)?;
        let end = model.clock.seconds(step.span.to);
        let mut stage = Stage::new(model, world, state, given.clone(), step);
        let substeps = stage.run(pulse)?;
        let springs = stage.spring_energy();
        let (external, supplied_j) = (stage.external, stage.supplied_j);
        let received = std::mem::take(&mut stage.received);
        let (pushed, counters) = (std::mem::take(&mut stage.pushed), std::mem::take(&mut stage.counters));
        let mut report = report(model, state, end, springs, &external, &received);
        report.supplied_j = supplied_j;
        report.substeps = substeps;
        model.params.bound_by.clone_into(&mut report.substep_bound_by);
        report.counters = counters;
        let coupled = model.bodies.iter().enumerate().filter(|(_, b)| b.coupled);
        let boundaries = coupled.map(|(i, b)| {
            let past = Past { pushed: pushed[i], received: heard(model, &given, i), length: step.length_s };
            BoundaryOutput { body: b.name.clone(), state: record(model, i, state, end, &past) }
        });
        Ok(Outputs { boundaries: boundaries.collect(), impulses: Vec::new(), report })
    }

    fn visual(&self, body: &str) -> Option<VisualState> {
        let Run { model, state, .. } = self.run.as_ref()?;
        let index = model.bodies.iter().position(|b| b.name == body)?;
        Some(pose(&model.bodies[index], &state.bodies[index]))
    }

    fn save(&self, sink: &mut dyn StateSink) {
        match &self.run {
            Some(run) => save::save(&run.state, Some(&run.world.inner), sink),
            None => save::save(&State::default(), None, sink),
        }
    }

    fn restore(&mut self, bytes: &[u8]) -> Result<(), PluginError> {
        match &mut self.run {
            Some(run) => save::restore(&mut run.state, Some(&mut run.world.inner), bytes),
            None => save::restore(&mut State::default(), None, bytes),
        }
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
    Ok(inputs.wrenches("rigid", &views)?.into_iter().map(|given| given.map(one)).collect())
}

/// Sum of the impulses of partners on a body.
fn heard(model: &Model, given: &[Option<Given>], body: usize) -> Pushed {
    let own = model.views.iter().zip(given).filter(|(view, _)| view.own == body).filter_map(|(_, given)| *given);
    own.fold(Pushed::default(), |sum, g| Pushed {
        linear: sum.linear + g.linear,
        angular: sum.angular + V3::from(g.angular),
    })
}
