//! The rigid solver passes what every plugin must pass.

mod common;

use common::{STILL, body, cube, on_floor, scene};
use cosplat_conformance::{Case, assert_conforms, parts};
use cosplat_core::boundary::{Impulses, Wrench};
use cosplat_core::plugin::{Inputs, Plugin, SolverScene, ViewRole};
use cosplat_core::scene::{ActionKind, Joint, JointKind, Motion, Source};
use cosplat_rigid::Rigid;

/// A box, a ball and a can that spin and fall, with a push at a point that begins inside a window.
fn flying() -> SolverScene {
    let can = Source::Cylinder { radius_m: 0.05, height_m: 0.2 };
    let bodies = vec![
        body(
            "box",
            Source::Box { size_m: [0.06, 0.12, 0.20] },
            2.0,
            [1.0, -2.0, 3.0],
            [0.5, 0.0, 1.0],
            [0.3, 40.0, 0.2],
        ),
        body("ball", Source::Sphere { radius_m: 0.1 }, 0.5, [0.0, 1.0, 0.0], STILL, STILL),
        body("can", can, 1.0, [2.0, 0.0, 0.0], STILL, [9.0, 0.0, 2.0]),
    ];
    let mut scene = scene(bodies, 4, 0.01);
    let push = ActionKind::PointForce { force_n: [1.0, 2.0, -3.0], at_m: Some([1.0, -1.9, 3.1]) };
    let knock = ActionKind::Impulse { impulse_n_s: [0.1, 0.0, 0.2], at_m: Some([0.0, 0.1, 0.0]) };
    scene.actions =
        vec![parts::gravity(), parts::action(push, 0.0033, Some(0.0317)), parts::action(knock, 0.0177, None)];
    scene
}

/// Boxes that fall on each other and on the floor, a ball that rolls, and a pendulum beside them.
fn touching() -> SolverScene {
    let mut bodies = vec![
        cube("box", 0.1, 1.0, [0.0, 0.0, 0.06]),
        cube("can", 0.1, 2.0, [0.03, 0.02, 0.163]),
        body("ball", Source::Sphere { radius_m: 0.05 }, 0.5, [0.3, 0.0, 0.051], [-1.0, 0.2, -0.3], [0.0, 5.0, 0.0]),
        cube("bob", 0.05, 0.3, [1.0, 0.0, 0.5]),
    ];
    bodies[1].velocity = parts::twist([0.5, 0.0, -1.0], [0.0, 1.0, 2.0]);
    let mut scene = on_floor(bodies, 0.4, 12, 0.01);
    scene.joints = vec![Joint {
        name: "string".into(),
        kind: JointKind::Ball,
        a: "bob".into(),
        b: None,
        anchor_m: [0.7, 0.0, 0.5],
        axis: [0.0, 0.0, 1.0],
        stiffness: 0.01,
        damping: 0.001,
    }];
    scene
}

/// Three partners push the box, one of them at once; a fourth pushes the can.
fn touched(name: &str, mut scene: SolverScene) -> Case {
    scene.interfaces = (0..4)
        .map(|i| parts::view(i, ViewRole::ContactResponder, if i < 3 { "box" } else { "can" }, "mud", Vec::new()))
        .collect();
    let windows = (0..scene.clock.windows as u16).map(|w| {
        let push = |i: u16| {
            let (i, w) = (f64::from(i), f64::from(w % 4));
            Impulses::Rigid(Wrench { linear: [0.1 * i, -0.03, 0.07 * w], angular: [0.01, 0.003 * w, -0.002 * i] })
        };
        let mut impulses: Vec<_> = (0..4).map(|i| parts::spread(i, push(i))).collect();
        impulses[1].spread = false;
        Inputs { partners: Vec::new(), impulses }
    });
    let windows = windows.collect();
    // Momentum is kept in double precision, whatever rapier computes in: the gate stays that of double precision.
    Case::new(name, scene).hearing(Vec::new(), windows)
}

#[test]
fn the_contract_is_kept() {
    let mut rails = flying();
    rails.bodies[0].prescribed = Some(Motion::Oscillation { amplitude_m: [0.1, 0.0, 0.2], frequency_hz: 3.0 });
    rails.bodies[2].prescribed = Some(Motion::Twist { linear_m_s: [1.0, 0.0, 0.0], angular_rad_s: [0.0, 2.0, 1.0] });
    let mut pushed = touching();
    pushed.bodies[0].prescribed = Some(Motion::Oscillation { amplitude_m: [0.05, 0.0, 0.0], frequency_hz: 5.0 });
    let cases = [
        Case::new("alone", flying()),
        touched("touched", flying()),
        touched("on rails", rails),
        Case { windows: vec![Inputs::default(); 12], ..Case::new("contacts", touching()) },
        touched("contacts and partners", touching()),
        touched("contacts with a driven body", pushed),
    ];
    assert_conforms(&|| Box::new(Rigid::default()) as Box<dyn Plugin>, &cases);
}
