//! Free flight: falls, tops, impulses of partners, motions told in advance.

mod common;

use common::{G, STILL, advance, body, closure, contact, energy, scene, size, start, turn, worked};
use cosplat_conformance::parts::{action, gravity};
use cosplat_core::boundary::{BoundaryState, Impulses, Wrench, cross, norm, sub};
use cosplat_core::plugin::{ImpulseInput, Inputs, Plugin};
use cosplat_core::scene::{ActionKind, Motion, Source};
use cosplat_core::visual::VisualState;
use nalgebra::Vector3;

const TOP: Source = Source::Box { size_m: [0.06, 0.12, 0.20] };

fn hearing(impulses: Vec<ImpulseInput>) -> Inputs {
    Inputs { partners: Vec::new(), impulses }
}

#[test]
fn free_fall_is_a_parabola() {
    let mut scene = scene(vec![body("box", TOP, 2.0, STILL, [3.0, 0.0, 4.0], [0.3, 4.0, 0.2])], 80, 0.01);
    scene.actions = vec![gravity()];
    let (mut solver, first) = start(&scene);
    let mut last = first.clone();
    for window in 0..80 {
        last = advance(&mut solver, &scene, window, &Inputs::default()).report;
    }
    let off = norm(sub(last.bodies[0].position_m, [2.4, 0.0, 4.0 * 0.8 - 0.5 * G * 0.64]));
    println!("fall of 0.8 s: off by {off:e} m, energy by {:e}", energy(&last) / energy(&first) - 1.0);
    // 400 substeps of a rounding each of numbers of order one.
    assert!(off < 1e-12);
    assert!(norm(sub(last.bodies[0].linear_velocity_m_s, [3.0, 0.0, 4.0 - G * 0.8])) < 1e-12);
    // Rotation keeps its energy to the fourth order of its parts, translation exactly.
    assert!((energy(&last) / energy(&first) - 1.0).abs() < 1e-9);
}

/// The box that turns over, in windows of 1/240 s.
#[test]
fn the_asymmetric_top_turns_over_when_jacobi_says() {
    let windows = 2400;
    let scene = scene(vec![body("top", TOP, 2.0, STILL, STILL, [0.3, 4.0, 0.2])], windows, 1.0 / 240.0);
    let (mut solver, first) = start(&scene);
    let (spin, kinetic) = (first.bodies[0].momentum.angular, first.energy.kinetic_j);
    let mut before = [0.3, 4.0, 0.2];
    let (mut flips, mut worst, mut lost) = (Vec::new(), 0.0_f64, 0.0_f64);
    for window in 0..windows {
        let report = advance(&mut solver, &scene, window, &Inputs::default()).report;
        let top = report.bodies[0];
        let omega = Vector3::from(top.angular_velocity_rad_s);
        let now: [f64; 3] = turn(top.orientation).inverse_transform_vector(&omega).into();
        let t = scene.clock.seconds(scene.clock.start_of(window));
        if before[1] * now[1] < 0.0 {
            flips.push(t + scene.clock.window_s() * before[1] / (before[1] - now[1]));
        }
        worst = worst.max((report.energy.kinetic_j / kinetic - 1.0).abs());
        lost = lost.max(norm(sub(top.momentum.angular, spin)));
        before = now;
    }
    println!("flips {flips:?} s, |ΔE|/E {worst:e}, |ΔL| {lost:e} kg m²/s");
    assert_eq!(flips.len(), 3);
    for (found, tabulated) in flips.iter().zip([1.5136, 5.1782, 8.8428]) {
        // Table of the verification catalogue (Jacobi elliptic functions), four decimals, the last up to 0.65 off.
        assert!((found - tabulated).abs() < 1e-4, "flip at {found} s instead of {tabulated} s");
    }
    // The catalogue's gates are 1e-3 and 1e-4; the scheme keeps energy to fourth order and angular momentum by being
    // made of rotations, so that only roundings are left.
    assert!(worst < 1e-8 && lost < 1e-12, "{worst:e}, {lost:e}");
}

#[test]
fn an_impulse_gives_a_velocity_and_an_angular_impulse_a_spin() {
    let wrench = Wrench { linear: [1.0, -2.0, 0.5], angular: [0.01, 0.02, -0.03] };
    let mut scene = scene(vec![body("box", TOP, 2.0, [1.0, 2.0, 3.0], STILL, STILL)], 1, 1e-3);
    scene.interfaces = vec![contact(0, "box")];
    let (x, y, z) = (0.06_f64, 0.12_f64, 0.20_f64);
    let moments = [y * y + z * z, x * x + z * z, x * x + y * y].map(|m| m * 2.0 / 12.0);
    for spread in [true, false] {
        let (mut solver, first) = start(&scene);
        let impulses = vec![ImpulseInput { interface: 0, impulses: Impulses::Rigid(wrench), spread }];
        let report = advance(&mut solver, &scene, 0, &hearing(impulses)).report;
        let top = report.bodies[0];
        let v = sub(top.linear_velocity_m_s, wrench.linear.map(|j| j / 2.0));
        assert!(norm(v) < 1e-15, "spread {spread}: {v:?}");
        let omega: [f64; 3] = std::array::from_fn(|k| wrench.angular[k] / moments[k]);
        let off = norm(sub(top.angular_velocity_rad_s, omega)) / norm(omega);
        // The body turns by up to 0.02 rad within the window and its inertia with it: second order in that for what
        // acts at once, half as much for what is spread.
        println!("spread {spread}: angular velocity off by {off:e}");
        assert!(off < 2e-2, "spread {spread}: {off:e}");
        let turned = turn(top.orientation);
        let spin = turned
            * Vector3::from(moments)
                .component_mul(&turned.inverse_transform_vector(&Vector3::from(top.angular_velocity_rad_s)));
        assert!((spin - Vector3::from(wrench.angular)).norm() < 1e-16, "spread {spread}: {spin}");
        let about = Wrench { angular: cross([1.0, 2.0, 3.0], wrench.linear), ..Wrench::default() };
        let received = report.interfaces[0].received.minus(wrench).minus(about);
        // Roundings of a moment of order ten.
        assert!(size(received)[0] < 1e-15 && size(received)[1] < 1e-14, "{received:?}");
        let [linear, angular] = closure(&first, &report);
        assert!(linear < 1e-14 && angular < 1e-14, "spread {spread}: {linear:e} {angular:e}");
        let gained = report.energy.kinetic_j - first.energy.kinetic_j;
        // Torque and rate of rotation are averaged over each substep: second order in the 0.02 rad it turns.
        assert!((gained - report.interfaces[0].work_j).abs() < 1e-4 * gained);
    }
}

/// Everything that can push a body in flight, with forces that begin and end inside windows.
#[test]
fn every_momentum_is_explained() {
    let can = Source::Cylinder { radius_m: 0.05, height_m: 0.2 };
    let bodies = vec![
        body("box", TOP, 2.0, [1.0, -2.0, 3.0], [0.5, 0.0, 1.0], [0.3, 4.0, 0.2]),
        body("ball", Source::Sphere { radius_m: 0.1 }, 0.5, [0.0, 1.0, 0.0], STILL, STILL),
        body("can", can, 1.0, [2.0, 0.0, 0.0], STILL, [9.0, 0.0, 2.0]),
    ];
    let mut scene = scene(bodies, 100, 0.01);
    scene.actions = vec![
        gravity(),
        action(ActionKind::Gravity { acceleration_m_s2: [0.0, 3.0, 0.0] }, 0.3, Some(0.617)),
        action(ActionKind::PointForce { force_n: [1.0, 2.0, -3.0], at_m: Some([1.0, -1.9, 3.1]) }, 0.0333, Some(0.417)),
        action(ActionKind::PointForce { force_n: [0.0, 0.5, 0.1], at_m: None }, 0.2, None),
        action(ActionKind::Impulse { impulse_n_s: [0.1, 0.0, 0.2], at_m: Some([0.0, 0.1, 0.0]) }, 0.0777, None),
    ];
    scene.interfaces = vec![contact(0, "box"), contact(1, "can")];
    let (mut solver, mut last) = start(&scene);
    let (mut worst, mut unexplained) = ([0.0_f64; 2], 0.0_f64);
    for window in 0..100 {
        let swing = (window as f64).sin();
        let push = |interface, spread, s: f64| ImpulseInput {
            interface,
            impulses: Impulses::Rigid(Wrench { linear: [0.1 * s, -0.2, 0.15], angular: [0.01, 0.02 * s, -0.01] }),
            spread,
        };
        let inputs = hearing(vec![push(0, true, swing), push(1, false, -swing)]);
        let report = advance(&mut solver, &scene, window, &inputs).report;
        let open = closure(&last, &report);
        worst = [worst[0].max(open[0]), worst[1].max(open[1])];
        unexplained += energy(&report) - energy(&last) - report.supplied_j - worked(&report);
        last = report;
    }
    println!("closure {worst:?}, {unexplained} J of {} J unexplained", energy(&last));
    // The error of the midpoint rule, (ω h)²/12 at 9 rad/s and 480 substeps a second.
    assert!(unexplained.abs() < energy(&last) * (9.0_f64 / 480.0).powi(2) / 12.0, "{unexplained} J");
    // Sums over some substeps in f64; the project's gate is 1e-12.
    assert!(worst[0] < 1e-13 && worst[1] < 1e-13, "{worst:?}");
}

#[test]
fn a_body_on_rails_has_infinite_mass_and_its_drive_takes_the_impulses() {
    let mut crank = body("crank", TOP, 2.0, STILL, STILL, STILL);
    crank.prescribed = Some(Motion::Oscillation { amplitude_m: [0.1, 0.0, 0.0], frequency_hz: 2.0 });
    let can = Source::Cylinder { radius_m: 0.1, height_m: 0.2 };
    let mut drum = body("drum", can, 1.0, [1.0, 0.0, 0.0], STILL, STILL);
    drum.prescribed = Some(Motion::Twist { linear_m_s: [0.0, 0.5, 0.0], angular_rad_s: [0.0, 0.0, 3.0] });
    let mut scene = scene(vec![crank, drum], 10, 0.0125);
    scene.interfaces = vec![contact(0, "crank"), contact(1, "drum")];
    scene.actions = vec![gravity()];
    let (mut solver, mut last) = start(&scene);
    for window in 0..10 {
        let wrench = Wrench { linear: [5.0, 1.0, 0.0], angular: [0.0, 0.1, 0.0] };
        let push = |interface| ImpulseInput { interface, impulses: Impulses::Rigid(wrench), spread: true };
        let out = advance(&mut solver, &scene, window, &hearing(vec![push(0), push(1)]));
        let open = closure(&last, &out.report);
        assert!(open[0] < 1e-13 && open[1] < 1e-13, "roundings: {open:?}");
        let unexplained = energy(&out.report) - energy(&last) - out.report.supplied_j - worked(&out.report);
        assert!(unexplained.abs() < 1e-13 && out.report.supplied_j.abs() > 1e-3, "of some joules: {unexplained}");
        for boundary in &out.boundaries {
            let BoundaryState::Proxy(proxy) = &boundary.state else { panic!("not a proxy") };
            assert!(proxy.mass.is_infinite() && proxy.mass > 0.0);
        }
        last = out.report;
    }
    // A quarter of a period: at the turning point.
    assert!(norm(sub(last.bodies[0].position_m, [0.1, 0.0, 0.0])) < 1e-15);
    assert!(norm(sub(last.bodies[1].position_m, [1.0, 0.0625, 0.0])) < 1e-15);
    assert!((2.0 * last.bodies[1].orientation[2].asin() - 0.375).abs() < 1e-15);
    let Some(VisualState::Pose { position, .. }) = solver.visual("drum") else { panic!("no picture") };
    assert!(norm(sub(position, [1.0, 0.0625, 0.0])) < 1e-15 && solver.visual("nobody").is_none());
}
