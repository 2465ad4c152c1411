//! The rigid solver passes what every plugin must pass.

use cosplat_conformance::{Case, assert_conforms, parts};
use cosplat_core::boundary::{Impulses, Wrench};
use cosplat_core::plugin::{Inputs, Plugin, SolverScene, ViewRole};
use cosplat_core::scene::{ActionKind, Motion, Source};
use cosplat_rigid_lite::RigidLite;

/// A box, a ball, a can and a cloud of points that spin and fall, with a push at a point that begins inside a window.
fn bodies() -> SolverScene {
    let points = Source::Points { positions_m: vec![[0.0; 3], [0.3, 0.0, 0.0], [0.0, 0.2, 0.1], [0.1, 0.1, -0.2]] };
    let bodies = vec![
        parts::rigid(
            "box",
            Source::Box { size_m: [0.06, 0.12, 0.20] },
            2.0,
            [1.0, -2.0, 3.0],
            parts::twist([0.5, 0.0, 1.0], [0.3, 40.0, 0.2]),
        ),
        parts::rigid("ball", Source::Sphere { radius_m: 0.1 }, 0.5, [0.0, 1.0, 0.0], parts::twist([0.0; 3], [0.0; 3])),
        parts::rigid(
            "can",
            Source::Cylinder { radius_m: 0.05, height_m: 0.2 },
            1.0,
            [2.0, 0.0, 0.0],
            parts::twist([0.0; 3], [9.0, 0.0, 2.0]),
        ),
        parts::rigid("four", points, 0.7, [-1.0, 0.0, 0.0], parts::twist([0.0, 1.0, 0.0], [1.0, 2.0, 3.0])),
    ];
    let mut scene = parts::solver_scene("rigid-lite", bodies, 4, 0.01);
    let push = ActionKind::PointForce { force_n: [1.0, 2.0, -3.0], at_m: Some([1.0, -1.9, 3.1]) };
    let knock = ActionKind::Impulse { impulse_n_s: [0.1, 0.0, 0.2], at_m: Some([0.0, 0.1, 0.0]) };
    scene.actions =
        vec![parts::gravity(), parts::action(push, 0.0033, Some(0.0317)), parts::action(knock, 0.0177, None)];
    scene
}

/// Three partners push the box, one of them at once; a fourth pushes the can.
fn touched(mut scene: SolverScene) -> Case {
    scene.interfaces = (0..4)
        .map(|i| parts::view(i, ViewRole::ContactResponder, if i < 3 { "box" } else { "can" }, "mud", Vec::new()))
        .collect();
    let windows = (0..4).map(|w| {
        let push = |i: u16| {
            let (i, w) = (f64::from(i), f64::from(w));
            Impulses::Rigid(Wrench { linear: [0.1 * i, -0.03, 0.07 * w], angular: [0.01, 0.003 * w, -0.002 * i] })
        };
        let mut impulses: Vec<_> = (0..4).map(|i| parts::spread(i, push(i))).collect();
        impulses[1].spread = false;
        Inputs { partners: Vec::new(), impulses }
    });
    Case::new("touched", scene).hearing(Vec::new(), windows.collect())
}

#[test]
fn the_contract_is_kept() {
    let mut on_rails = bodies();
    on_rails.bodies[0].prescribed = Some(Motion::Oscillation { amplitude_m: [0.1, 0.0, 0.2], frequency_hz: 3.0 });
    on_rails.bodies[2].prescribed = Some(Motion::Twist { linear_m_s: [1.0, 0.0, 0.0], angular_rad_s: [0.0, 2.0, 1.0] });
    let rails = Case { name: "on rails".into(), ..touched(on_rails) };
    let cases = [Case::new("alone", bodies()), touched(bodies()), rails];
    assert_conforms(&|| Box::new(RigidLite::default()) as Box<dyn Plugin>, &cases);
}
