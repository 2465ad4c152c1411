//! The solver passes what every plugin must pass, in each part it can play.

#[cfg(test)]
mod common;

use common::{meets, rigid, sheet, shown, windy};
use cosplat_conformance::{Case, assert_conforms};
use cosplat_core::boundary::{BoundaryState, SampleStatics};
use cosplat_core::plan::BoundaryForm;
use cosplat_core::plugin::{Inputs, PartnerSetup, SolverScene};
use cosplat_core::scene::Source;
use cosplat_smoke::Smoke;

/// Smoke in the wind over a floor.
fn floor() -> SolverScene {
    let mut scene = windy(0.01);
    scene.threads = 1;
    scene.statics.push(common::wall("floor", Source::Plane { size_m: None }, [0.0, 0.0, -0.3]));
    scene
}

fn boxed() -> Case {
    let mut scene = floor();
    let size = [0.1, 0.15, 0.1];
    scene.interfaces.push(meets(0, "crate", BoundaryForm::Proxy, Some(Source::Box { size_m: size })));
    let at = |w: i32| BoundaryState::Proxy(rigid(0.4, size, [0.1, 0.01 * f64::from(w), 0.0], [0.0, 1.0, 0.0]));
    let windows = (0..4).map(|w| Inputs { partners: vec![shown(0, at(w), 0.01)], impulses: Vec::new() });
    let partner = PartnerSetup { interface: 0, statics: SampleStatics::default() };
    Case { name: "rigid partner".into(), ..Case::new("", scene).hearing(vec![partner], windows.collect()) }
}

fn sampled() -> Case {
    let mut scene = floor();
    scene.interfaces.push(meets(0, "sheet", BoundaryForm::SamplesF64 { normals: false }, None));
    let at = |w: i32| BoundaryState::points(&sheet(10, 0.02, 0.1 + 0.002 * f64::from(w)), &[[0.2, 0.0, -0.1]; 100]);
    let windows = (0..4).map(|w| Inputs { partners: vec![shown(0, at(w), 0.01)], impulses: Vec::new() });
    let statics = SampleStatics { area_m2: vec![4e-4; 100], ..SampleStatics::equal(100, 4e-5) };
    Case::new("sampled partner", scene).hearing(vec![PartnerSetup { interface: 0, statics }], windows.collect())
}

#[test]
fn the_solver_conforms() {
    assert_conforms(&|| Box::new(Smoke::default()), &[Case::new("smoke", floor()), boxed(), sampled()]);
}
