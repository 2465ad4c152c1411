//! The smallest legal plugin that plays both parts of a contact: copy this file to start a solver of your own.
//!
//! A plugin is any program that speaks Cosplat's protocol. In Rust that is one trait and one call: implement
//! [`Plugin`], hand it to [`run_plugin`]. `cosplat` finds the program as `cosplat-solver-NAME` on the `PATH`, or by
//! `command` in a scene: `[solver.cloud]`, `command = ["./target/release/examples/dummy"]`, `params = { drag = 2.0 }`.
//!
//! The physics is clouds of equal points in free flight. They take impulses as the *responder* of a contact; as the
//! *resolver* they drag at the partner, point by point: `J = c m (v_own - v_partner) W`, at most what makes both
//! velocities equal, and take `-J` themselves. One substep is exact for that; a solver that loops over substeps calls
//! `pulse.beat(done, of)` in its loop and returns [`PluginError::Aborted`] when told to.
//!
//! What to keep: refuse by name what you cannot do; no clock, no file, no random numbers; report momentum and energy
//! from your own state, never from what you were sent; `save` all that `advance` depends on, in one order.

use std::collections::BTreeMap;
use std::process::ExitCode;

use cosplat_bus::run_plugin;
use cosplat_core::boundary::{Impulses, Vec3, dot, scale, sub};
use cosplat_core::plan::{BoundaryForm, InterfaceId};
use cosplat_core::plugin::{
    Descriptor, ImpulseInput, Inputs, InterfaceRole, InterfaceView, Outputs, PartnerSetup, Plugin, PluginError, Points,
    Pulse, Refusals, Report, Setup, SolverScene, StateReader, StateSink, Step,
};

/// JSON Schema of `params`: what a scene may set, checked before any process starts.
const PARAMS: &str = r#"{ "type": "object", "additionalProperties": false,
    "properties": { "drag": { "type": "number", "minimum": 0, "default": 1, "description": "rate c, 1/s" } } }"#;

/// Clouds of points. They and `dissipated_j` change in a run, the rest comes from the scene.
#[derive(Default)]
struct Dummy {
    drag: f64,
    views: Vec<InterfaceView>,
    partner_mass: BTreeMap<InterfaceId, Vec<f64>>,
    clouds: Vec<Points>,
    dissipated_j: f64,
}

impl Plugin for Dummy {
    fn describe(&self) -> Descriptor {
        Descriptor {
            body_kinds: vec!["points".into(), "cloud".into()],
            materials: vec!["point-mass".into()],
            roles: vec![InterfaceRole::ResolveSamples, InterfaceRole::Respond],
            boundary: BoundaryForm::SamplesF32 { normals: false },
            params_schema: PARAMS.parse().unwrap_or_default(),
            ..Descriptor::new("dummy", env!("CARGO_PKG_VERSION"), "Points in free flight that drag at their partner")
        }
    }

    fn setup(&mut self, scene: &SolverScene) -> Result<Setup, PluginError> {
        let mut refusals = Refusals::undeclared(&self.describe(), scene);
        refusals.contacts(scene);
        self.clouds = scene.bodies.iter().filter_map(|body| refusals.points(body)).collect();
        refusals.finish()?;
        self.drag = scene.number("drag", 1.0)?;
        self.views.clone_from(&scene.interfaces);
        self.dissipated_j = 0.0;
        Ok(Setup::of_points("dummy", scene, &self.clouds))
    }

    fn connect(&mut self, partners: &[PartnerSetup]) -> Result<(), PluginError> {
        for view in self.views.iter().filter(|view| view.role.gives_impulses()) {
            let own = self.clouds.iter().filter(|c| c.body == view.own).map(Points::len).sum();
            self.partner_mass.insert(view.id, view.partner_masses(partners, own)?);
        }
        Ok(())
    }

    fn advance(&mut self, step: &Step, inputs: &Inputs, _: &mut dyn Pulse) -> Result<Outputs, PluginError> {
        let (mut boundaries, mut impulses, mut rows) = (Vec::new(), Vec::new(), Vec::new());
        for cloud in &mut self.clouds {
            let mut taken = Vec::new();
            for view in self.views.iter().filter(|view| view.own == cloud.body) {
                if !view.role.gives_impulses() {
                    taken.push(inputs.on_points(view, cloud.len())?);
                    continue;
                }
                let partner = inputs.samples(view, cloud.len())?;
                let pairs = cloud.v.iter().zip(&partner.velocity).zip(&self.partner_mass[&view.id]);
                let pull = |((&a, &b), &m)| drag(sub(a, b), cloud.mass, m, self.drag * step.length_s);
                let (each, lost_j): (Vec<Vec3>, Vec<f64>) = pairs.map(pull).unzip();
                self.dissipated_j += lost_j.iter().sum::<f64>();
                let given = Impulses::Samples(each);
                taken.push(ImpulseInput { interface: view.id, impulses: given.negated(), spread: true });
                impulses.push((view.id, given));
            }
            rows.extend(cloud.fly(step.length_s, &taken)?);
            boundaries.extend((!taken.is_empty()).then(|| cloud.boundary()));
        }
        Ok(Outputs { boundaries, impulses, report: Report::of_points(&self.clouds, self.dissipated_j, rows) })
    }

    fn save(&self, sink: &mut dyn StateSink) {
        self.clouds.iter().for_each(|cloud| cloud.save(sink));
        sink.f64(self.dissipated_j);
    }

    fn restore(&mut self, state: &[u8]) -> Result<(), PluginError> {
        let mut reader = StateReader::new(state);
        let clouds = self.clouds.iter().map(|cloud| cloud.restored(&mut reader)).collect::<Result<_, _>>()?;
        let dissipated_j = reader.f64()?;
        reader.end()?;
        (self.clouds, self.dissipated_j) = (clouds, dissipated_j);
        Ok(())
    }
}

/// Impulse on a partner's point of mass `other` that slips by `slip`, and the energy that the pair loses.
fn drag(slip: Vec3, mass: f64, other: f64, cw: f64) -> (Vec3, f64) {
    let reduced = 1.0 / (1.0 / mass + 1.0 / other);
    let j = scale(slip, (cw * mass).min(reduced));
    (j, dot(j, slip) - 0.5 * dot(j, j) / reduced)
}

fn main() -> ExitCode {
    run_plugin(&mut Dummy::default())
}
