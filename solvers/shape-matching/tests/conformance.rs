//! The solver passes what every plugin must pass.

mod common;

use common::{on_floor, still};
use cosplat_conformance::{Case, assert_conforms, parts};
use cosplat_core::boundary::{Impulses, Wrench};
use cosplat_core::plugin::{Inputs, Plugin, SolverScene, ViewRole};
use cosplat_core::scene::{ActionKind, Source};
use cosplat_shape_matching::ShapeMatching;

/// Two boxes that fall on each other and on the floor, a ball that rolls, a can that spins, a knock.
fn touching() -> SolverScene {
    let cube = Source::Box { size_m: [0.1; 3] };
    let can = Source::Cylinder { radius_m: 0.05, height_m: 0.2 };
    let mut scene = on_floor(
        vec![
            parts::rigid("box", cube.clone(), 1.0, [0.0, 0.0, 0.06], still()),
            parts::rigid("lid", cube, 2.0, [0.03, 0.02, 0.163], parts::twist([0.5, 0.0, -1.0], [0.0, 1.0, 2.0])),
            parts::rigid(
                "ball",
                Source::Sphere { radius_m: 0.05 },
                0.5,
                [0.3, 0.0, 0.051],
                parts::twist([-1.0, 0.2, -0.3], [0.0, 5.0, 0.0]),
            ),
            parts::rigid("can", can, 1.0, [2.0, 0.0, 0.5], parts::twist([0.0; 3], [9.0, 0.0, 2.0])),
        ],
        12,
        0.01,
    );
    let knock = ActionKind::Impulse { impulse_n_s: [0.1, 0.0, 0.2], at_m: Some([0.0, 0.1, 0.0]) };
    scene.actions.push(parts::action(knock, 0.0177, None));
    scene
}

#[test]
fn the_contract_is_kept() {
    let mut pushed = touching();
    pushed.interfaces = (0..3)
        .map(|i| parts::view(i, ViewRole::ContactResponder, if i < 2 { "box" } else { "can" }, "mud", Vec::new()))
        .collect();
    let windows = (0..12_u16).map(|w| {
        let push = |i: u16| {
            let (i, w) = (f64::from(i), f64::from(w % 4));
            Impulses::Rigid(Wrench { linear: [0.1 * i, -0.03, 0.07 * w], angular: [0.01, 0.003 * w, -0.002 * i] })
        };
        let mut impulses: Vec<_> = (0..3).map(|i| parts::spread(i, push(i))).collect();
        impulses[1].spread = false;
        Inputs { partners: Vec::new(), impulses }
    });
    let pushed = Case::new("pushed", pushed).hearing(Vec::new(), windows.collect());
    let alone = Case { windows: vec![Inputs::default(); 12], ..Case::new("contacts", touching()) };
    assert_conforms(&|| Box::new(ShapeMatching::default()) as Box<dyn Plugin>, &[alone, pushed]);
}
