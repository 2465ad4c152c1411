//! Closed solutions, and what shape matching keeps.

mod common;

use common::{on_floor, still};
use cosplat_conformance::parts;
use cosplat_core::boundary::{norm, sub};
use cosplat_core::plugin::{Inputs, Outputs, Plugin, Setup, SolverScene, Steady};
use cosplat_core::scene::{ActionKind, Source};
use cosplat_shape_matching::ShapeMatching;

const G: f64 = 9.81;

fn run(scene: &SolverScene) -> (Setup, Vec<Outputs>) {
    let mut plugin = ShapeMatching::default();
    let setup = plugin.setup(scene).expect("a scene it takes");
    let step = |w| plugin.advance(&parts::step(&scene.clock, w), &Inputs::default(), &mut Steady).expect("a step");
    (setup, (0..scene.clock.windows).map(step).collect())
}

#[test]
fn a_tumbling_box_keeps_both_momenta() {
    let source = Source::Box { size_m: [0.06, 0.12, 0.20] };
    let turning = parts::twist([0.5, 0.0, 1.0], [0.3, 20.0, 0.2]);
    let scene = parts::solver_scene(
        "shape-matching",
        vec![parts::rigid("box", source, 2.0, [1.0, -2.0, 3.0], turning)],
        100,
        0.01,
    );
    let (setup, all) = run(&scene);
    let start = setup.report.bodies[0].momentum;
    let mut drift = 0.0_f64;
    for out in &all {
        let now = out.report.bodies[0].momentum;
        // Roundings of momenta of some kg m²/s about the world's origin.
        assert!(norm(sub(now.linear, start.linear)) < 1e-14 && norm(sub(now.angular, start.angular)) < 1e-13);
        drift = drift.max((out.report.energy.kinetic_j / setup.report.energy.kinetic_j - 1.0).abs());
    }
    println!("energy drifts by {drift}");
    // First order in ω h = 20 rad/s · 0.5 ms = 1 %, of the part that is not about the middle axis, some 0.04² at first.
    assert!(drift < 1e-4, "{drift}");
}

/// Way of a box down an incline of so many degrees in half a second \[m\], friction 0.4.
fn slide(degrees: f64) -> f64 {
    let cube = Source::Box { size_m: [0.2, 0.2, 0.05] };
    let mut scene = on_floor(vec![parts::rigid("box", cube, 1.0, [0.0, 0.0, 0.025], still())], 50, 0.01);
    let (sin, cos) = degrees.to_radians().sin_cos();
    let down = ActionKind::Gravity { acceleration_m_s2: [G * sin, 0.0, -G * cos] };
    scene.actions = vec![parts::action(down, 0.0, None)];
    run(&scene).1.last().expect("windows").report.bodies[0].position_m[0]
}

#[test]
fn friction_holds_up_to_its_angle_and_brakes_beyond() {
    // atan 0.4 = 21.80°.
    let held = slide(21.0);
    assert!(held.abs() < 1e-6, "{held}");
    let (sin, cos) = 30.0_f64.to_radians().sin_cos();
    let (found, exact) = (slide(30.0), 0.5 * G * (sin - 0.4 * cos) * 0.25);
    println!("held {held:e}, slid {:+.2e}", found / exact - 1.0);
    // Velocities first, positions after: h/T = 0.1 %; twenty turns over some 200 points leave another 0.1 %.
    assert!((found / exact - 1.0).abs() < 3e-3, "{found} {exact}");
}

#[test]
fn a_stack_rests() {
    let cube = Source::Box { size_m: [0.1; 3] };
    let bodies = (0..2).map(|i| {
        let name = ["below", "above"][i];
        parts::rigid(name, cube.clone(), 1.0, [0.01 * i as f64, 0.0, 0.05 + 0.1 * i as f64], still())
    });
    let scene = on_floor(bodies.collect(), 100, 0.01);
    let (setup, all) = run(&scene);
    let last = &all[99].report;
    for (now, start) in last.bodies.iter().zip(&setup.report.bodies) {
        let moved = norm(sub(now.position_m, start.position_m));
        println!("{moved:e} m, {:e} m/s", norm(now.linear_velocity_m_s));
        // Twenty turns leave a part of g h = 5 mm/s, which a tenth of the overlap a substep takes back.
        assert!(moved < 1e-3, "{moved}");
    }
    let held: f64 = all[90..].iter().map(|o| o.report.external.linear[2]).sum();
    // Gravity and floor cancel.
    assert!(held.abs() < 0.01 * 2.0 * G * 0.1, "{held}");
}

#[test]
fn a_ball_on_an_incline_rolls() {
    let ball = Source::Sphere { radius_m: 0.05 };
    let mut scene = on_floor(vec![parts::rigid("ball", ball, 1.0, [0.0, 0.0, 0.05], still())], 50, 0.01);
    let (sin, cos) = 20.0_f64.to_radians().sin_cos();
    scene.actions = vec![parts::action(ActionKind::Gravity { acceleration_m_s2: [G * sin, 0.0, -G * cos] }, 0.0, None)];
    let found = run(&scene).1[49].report.bodies[0].position_m[0];
    let exact = 0.5 * G * sin / 1.4 * 0.25;
    println!("rolled {:+.2e}", found / exact - 1.0);
    // The particles' moment of inertia is 4.4 % above the ball's, which is 2/7 of what is accelerated: 1.25 %, and 0.1 %
    // of the substep.
    assert!((found / exact - 1.0).abs() < 0.015, "{found} {exact}");
}
