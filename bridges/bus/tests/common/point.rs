//! A plugin for tests: one sample that moves straight on, pulled at by a partner that wants its velocity.

use std::thread;
use std::time::Duration;

use cosplat_core::boundary::{BoundaryState, Impulses, SampleStatics, Samples, Vec3, Wrench};
use cosplat_core::control::PROTOCOL;
use cosplat_core::plan::BoundaryForm;
use cosplat_core::plugin::{
    BodyState, BoundaryOutput, Descriptor, Inputs, InterfaceReport, InterfaceRole, Outputs, Plugin, PluginError, Pulse,
    Report, Saves, Setup, SetupBoundary, Signal, SolverScene, StateError, StateSink, Step,
};

/// What goes wrong, and in which window.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Trouble {
    Nothing,
    Panics(u64),
    BlowsUp(u64),
    /// Computes for so long without a beat.
    Sleeps(u64, Duration),
    /// Computes until told to stop.
    Lingers(u64),
}

pub(crate) struct Point {
    pub(crate) trouble: Trouble,
    body: String,
    x: f64,
    v: f64,
    partners: Vec<(u16, bool)>,
}

impl Point {
    pub(crate) fn new(v: f64, trouble: Trouble) -> Self {
        Self { trouble, body: String::new(), x: 0.0, v, partners: Vec::new() }
    }

    fn boundary(&self) -> BoundaryState {
        let along = |c: f64| vec![[c, 0.0, 0.0]];
        BoundaryState::Samples(Samples { position: along(self.x), velocity: along(self.v), normal: Vec::new() })
    }

    fn report(&self, interfaces: Vec<InterfaceReport>) -> Report {
        let momentum = Wrench { linear: [self.v, 0.0, 0.0], angular: [0.0; 3] };
        let body = BodyState { mass_kg: 1.0, momentum, gross_momentum: self.v.abs(), ..Default::default() };
        Report { substeps: 1, bodies: vec![body], interfaces, ..Default::default() }
    }

    fn get_into_trouble(&self, window: u64, pulse: &mut dyn Pulse) -> Result<(), PluginError> {
        match self.trouble {
            Trouble::Panics(at) if at == window => panic!("lost in window {window}"),
            Trouble::BlowsUp(at) if at == window => Err(PluginError::Physics("speed is not a number".to_owned())),
            Trouble::Sleeps(at, time) if at == window => {
                thread::sleep(time);
                Ok(())
            }
            Trouble::Lingers(at) if at == window => loop {
                thread::sleep(Duration::from_millis(1));
                if pulse.beat(1, 1_000_000) == Signal::Abort {
                    return Err(PluginError::Aborted);
                }
            },
            _ => Ok(()),
        }
    }
}

impl Plugin for Point {
    fn describe(&self) -> Descriptor {
        Descriptor {
            name: "point".to_owned(),
            version: "0".to_owned(),
            summary: String::new(),
            protocol: [PROTOCOL; 2],
            body_kinds: vec!["points".to_owned()],
            materials: vec!["point-mass".to_owned()],
            roles: vec![InterfaceRole::ResolveSamples, InterfaceRole::Respond],
            boundary: BoundaryForm::SamplesF32 { normals: false },
            visual: None,
            features: Vec::new(),
            probes: Vec::new(),
            saves: Saves { bytes: true, deterministic: true },
            params_schema: serde_json::Value::Null,
        }
    }

    fn setup(&mut self, scene: &SolverScene) -> Result<Setup, PluginError> {
        self.body = format!("{}-body", scene.participant);
        self.partners = scene.interfaces.iter().map(|i| (i.id, i.role.gives_impulses())).collect();
        let one = |c: f64| vec![c];
        let statics = SampleStatics { id: vec![0], area_m2: one(0.0), volume_m3: one(0.0), mass_kg: one(1.0) };
        Ok(Setup {
            boundaries: vec![SetupBoundary { body: self.body.clone(), statics, state: self.boundary() }],
            report: self.report(Vec::new()),
            stable_dt: None,
            particles: vec![1],
            left_out: Vec::new(),
        })
    }

    fn advance(&mut self, step: &Step, inputs: &Inputs, pulse: &mut dyn Pulse) -> Result<Outputs, PluginError> {
        self.get_into_trouble(step.window, pulse)?;
        let (mut given, mut interfaces, mut sum) = (Vec::new(), Vec::new(), 0.0);
        for &(interface, gives) in &self.partners {
            let j: Vec3 = if gives {
                let Some(BoundaryState::Samples(partner)) = inputs.partner(interface).map(|p| &p.now) else { continue };
                let pull = 0.25 * (self.v - partner.velocity[0][0]);
                given.push((interface, Impulses::Samples(vec![[pull, 0.0, 0.0]])));
                [-pull, 0.0, 0.0]
            } else {
                let Some(Impulses::Samples(each)) = inputs.impulse(interface).map(|i| &i.impulses) else { continue };
                each[0]
            };
            let received = Wrench { linear: j, angular: [0.0; 3] };
            interfaces.push(InterfaceReport { interface, received, gross: j[0].abs(), ..Default::default() });
            sum += j[0];
        }
        self.v += sum;
        self.x += self.v * step.length_s;
        let boundaries = vec![BoundaryOutput { body: self.body.clone(), state: self.boundary() }];
        Ok(Outputs { boundaries, impulses: given, report: self.report(interfaces) })
    }

    fn save(&self, sink: &mut dyn StateSink) {
        sink.f64(self.x);
        sink.f64(self.v);
    }

    fn restore(&mut self, state: &[u8]) -> Result<(), PluginError> {
        Err(PluginError::State(StateError::Long { left: state.len() }))
    }
}
