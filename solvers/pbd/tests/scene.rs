//! A scene file as an author writes it, read, planned and run.

use std::collections::BTreeMap;

use cosplat_core::plan::{self, BoundaryForm};
use cosplat_core::plugin::{Descriptor, InterfaceRole, Plugin, ViewRole};
use cosplat_core::scene::read;
use cosplat_pbd::Pbd;

const SILK_OVER_A_BALL: &str = r#"
format = 1
name = "silk"

[clock]
duration = 0.5
fps = 24

[solver.pbd]
params = { mode = "genesis", pins = { silk = [[-0.3, 0.3, 0.4]] } }

[[body]]
name = "silk"
plane = [0.6, 0.6]
spacing = 0.01
material = "silk"
position = [0.0, 0.0, 0.4]

[[body]]
name = "ball"
material = { kind = "rigid", density = 300.0, friction = 0.05 }
sphere = 0.15
position = [0.0, 0.0, 0.15]

[[static]]
name = "floor"
plane = "infinite"
wall = { static_friction = 0.4, kinetic_friction = 0.3 }

[[action]]
kind = "gravity"
acceleration = [0.0, 0.0, -9.81]
"#;

#[test]
fn silk_over_a_ball_is_planned_and_set_up() {
    let (scene, warnings) = read::parse(SILK_OVER_A_BALL).unwrap_or_else(|wrong| panic!("{wrong:?}"));
    assert!(warnings.is_empty(), "{warnings:?}");
    let rigid = Descriptor {
        body_kinds: vec!["sphere".into()],
        materials: vec!["rigid".into()],
        roles: vec![InterfaceRole::Respond],
        boundary: BoundaryForm::Proxy,
        features: ["gravity", "statics"].map(String::from).into(),
        ..Descriptor::new("rigid", "0", "stands in for the real one")
    };
    let known = BTreeMap::from([("pbd".to_owned(), Pbd::default().describe()), ("rigid".to_owned(), rigid)]);
    let (_, parts) = plan::build(&scene, &known, 2).unwrap_or_else(|why| panic!("{why:?}"));
    let cloth = parts.iter().find(|p| p.participant == "pbd").expect("the cloth's part");
    assert_eq!(cloth.interfaces.iter().map(|i| i.role).collect::<Vec<_>>(), [ViewRole::ContactResolver]);
    let setup = Pbd::default().setup(cloth).expect("a scene it takes");
    assert_eq!(setup.particles, [61 * 61]);
    // 1.5 kg/m², as published.
    assert!((setup.report.bodies[0].mass_kg - 1.5 * 0.36).abs() < 1e-12);
    // α g ρ/2 a metre: 1e-6 m/N by compliance; h² Σw (1 - φ)/φ = 1e-6 s² · 2/0.15 g · 4.39 = 0.0585 m/N by factors.
    let [told] = &setup.left_out[..] else { panic!("{:?}", setup.left_out) };
    assert!(told.what.contains("compliances of `silk`"), "{told:?}");
    assert!(told.why.contains("7.4e-6 m longer by compliance, 4.3e-1 m by factors"), "{told:?}");
}
