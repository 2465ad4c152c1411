//! The smallest legal plugin: copy this file to start a solver of your own.
//!
//! A plugin is any program that speaks Cosplat's protocol. In Rust that is one trait and one call: implement
//! [`Plugin`], hand it to [`run_plugin`]. `cosplat` finds the program as `cosplat-solver-NAME` on the `PATH`, or by
//! `command` in a scene: `[solver.cloud]`, `command = ["./target/release/examples/dummy"]`.
//!
//! The physics is clouds of equal points in free flight that take impulses from whoever resolves contact with them. One
//! substep is exact for that; a solver that loops over substeps calls `pulse.beat(done, of)` in its loop and returns
//! [`PluginError::Aborted`] when told to. To compute contact yourself, see the larger solvers beside this one.
//!
//! What to keep: refuse by name what you cannot do; no clock, no file, no random numbers; report momentum and energy
//! from your own state, never from what you were sent; `save` all that `advance` depends on, in one order.

use std::process::ExitCode;

use cosplat_bus::run_plugin;
use cosplat_core::plugin::{
    Descriptor, Inputs, InterfaceRole, InterfaceView, Outputs, Plugin, PluginError, Points, Pulse, Refusals, Report,
    Setup, SolverScene, StateReader, StateSink, Step,
};

/// Clouds of points, and where each meets others.
#[derive(Default)]
pub(crate) struct Dummy {
    views: Vec<InterfaceView>,
    clouds: Vec<Points>,
}

impl Plugin for Dummy {
    fn describe(&self) -> Descriptor {
        Descriptor {
            body_kinds: vec!["points".into(), "cloud".into()],
            materials: vec!["point-mass".into()],
            roles: vec![InterfaceRole::Respond],
            ..Descriptor::new("dummy", env!("CARGO_PKG_VERSION"), "Points in free flight that take impulses")
        }
    }

    fn setup(&mut self, scene: &SolverScene) -> Result<Setup, PluginError> {
        let mut refusals = Refusals::undeclared(&self.describe(), scene);
        refusals.contacts(scene);
        self.clouds = scene.bodies.iter().filter_map(|body| refusals.points(body)).collect();
        refusals.finish()?;
        self.views.clone_from(&scene.interfaces);
        Ok(Setup::of_points("dummy", scene, &self.clouds))
    }

    fn advance(&mut self, step: &Step, inputs: &Inputs, _: &mut dyn Pulse) -> Result<Outputs, PluginError> {
        let (mut boundaries, mut rows) = (Vec::new(), Vec::new());
        for cloud in &mut self.clouds {
            let own = self.views.iter().filter(|view| view.own == cloud.body);
            let taken = own.map(|view| inputs.on_points(view, cloud.len())).collect::<Result<Vec<_>, _>>()?;
            rows.extend(cloud.fly(step.length_s, &taken)?);
            boundaries.extend((!taken.is_empty()).then(|| cloud.boundary()));
        }
        Ok(Outputs { boundaries, impulses: Vec::new(), report: Report::of_points(&self.clouds, 0.0, rows) })
    }

    fn save(&self, sink: &mut dyn StateSink) {
        self.clouds.iter().for_each(|cloud| cloud.save(sink));
    }

    fn restore(&mut self, state: &[u8]) -> Result<(), PluginError> {
        let mut reader = StateReader::new(state);
        let clouds = self.clouds.iter().map(|cloud| cloud.restored(&mut reader)).collect::<Result<_, _>>()?;
        reader.end()?;
        self.clouds = clouds;
        Ok(())
    }
}

fn main() -> ExitCode {
    run_plugin(&mut Dummy::default())
}
