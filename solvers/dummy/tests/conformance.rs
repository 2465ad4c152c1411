//! The plugin to copy passes what every plugin must pass.

#[path = "../examples/dummy.rs"]
#[allow(dead_code, reason = "its `main` is for the program")]
mod dummy;

use cosplat_conformance::{Case, assert_conforms, parts};
use cosplat_core::boundary::Impulses;
use cosplat_core::plugin::{Inputs, ViewRole};
use cosplat_core::scene::{Material, Source};

/// Four points in the corners of a body of 2 kg, hit by two partners.
#[test]
fn the_smallest_plugin_keeps_the_contract() {
    let source = Source::Points { positions_m: vec![[0.0; 3], [0.1, 0.0, 0.0], [0.0, 0.2, 0.0], [0.0, 0.0, 0.3]] };
    let mut body = parts::body("cloud", Material::PointMass, source, [0.5, -0.25, 1.0]);
    body.mass_kg = Some(2.0);
    body.velocity = parts::twist([1.0, 0.0, -0.5], [0.0; 3]);
    let mut scene = parts::solver_scene("dummy", vec![body], 4, 0.02);
    let view = |id| parts::view(id, ViewRole::ContactResponder, "cloud", "mud", Vec::new());
    scene.interfaces = vec![view(0), view(1)];
    let each = |w: u32, k: f64| (0..4).map(|i| [k * f64::from(w), 0.01 * f64::from(i), -k]).collect();
    let hit = |w: u32| {
        vec![parts::spread(0, Impulses::Samples(each(w, 0.03))), parts::spread(1, Impulses::Samples(each(w, -0.02)))]
    };
    let windows = (0..4).map(|w| Inputs { partners: Vec::new(), impulses: hit(w) });
    let case = Case::new("two partners", scene).hearing(Vec::new(), windows.collect());
    assert_conforms(&|| Box::new(dummy::Dummy::default()), &[case]);
}
