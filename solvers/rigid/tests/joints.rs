//! Joints against textbook answers.

mod common;

use common::{G, STILL, body, closure, cube, energy, play, scene, start};
use cosplat_conformance::parts::gravity;
use cosplat_core::boundary::{Vec3, norm, sub};
use cosplat_core::plugin::{Plugin, PluginError};
use cosplat_core::scene::{Joint, JointKind, Source};

fn joint(kind: JointKind, a: &str, b: Option<&str>, anchor_m: Vec3, spring: [f64; 2]) -> Joint {
    Joint {
        name: format!("{a}-joint"),
        kind,
        a: a.into(),
        b: b.map(str::to_owned),
        anchor_m,
        axis: [0.0, 0.0, 1.0],
        stiffness: spring[0],
        damping: spring[1],
    }
}

#[test]
fn a_mass_on_a_rail_swings_with_its_spring() {
    // 1 kg on 100 N/m under gravity: about -g m / k, with period 2π / 10 s.
    let mut scene = scene(vec![cube("mass", 0.1, 1.0, STILL)], 126, 0.005);
    scene.actions = vec![gravity()];
    scene.joints = vec![joint(JointKind::Prismatic, "mass", None, STILL, [100.0, 0.0])];
    scene.params.insert("substep_s".into(), 1e-3.into());
    let mut before = start(&scene).1;
    let (mut lowest, mut aside, mut worst) = (0.0_f64, 0.0_f64, 0.0_f64);
    let last = play(&scene, |_, report| {
        let x = report.bodies[0].position_m;
        lowest = lowest.min(x[2]);
        aside = aside.max(x[0].abs()).max(x[1].abs());
        let open = closure(&before, report);
        worst = worst.max(open[0]);
        before = report.clone();
    });
    println!("lowest {lowest} m, aside {aside:e} m, closure {worst:e}, {:?}, {:?}", last.energy, last.counters);
    // Implicit Euler damps an oscillation by exp(-ω² h t / 2): 1.6 % over half a period of 0.31 s, and as much of the
    // returning way.
    assert!((lowest / (-2.0 * G / 100.0) - 1.0).abs() < 0.02, "{lowest}");
    assert!(aside < 1e-9, "{aside}");
    assert!(worst < 1e-12, "{worst}");
}

#[test]
fn a_pendulum_keeps_its_length_and_its_period() {
    // A rod of 1 m hung at its end: small swings have period 2π √(2 l / 3 g) = 1.6378 s.
    let rod = Source::Box { size_m: [0.02, 0.02, 1.0] };
    let tilt = 0.05_f64;
    let mut only = body("rod", rod, 1.0, [-0.5 * tilt.sin(), 0.0, -0.5 * tilt.cos()], STILL, STILL);
    only.pose.orientation = common::tilt(tilt);
    let mut scene = scene(vec![only], 500, 0.01);
    scene.actions = vec![gravity()];
    scene.joints = vec![joint(JointKind::Ball, "rod", None, STILL, [0.0; 2])];
    let first = start(&scene).1;
    let (mut crossings, mut before, mut length, mut worst) = (Vec::new(), first.clone(), 0.0_f64, [0.0_f64; 2]);
    let last = play(&scene, |window, report| {
        let [x0, x1] = [&before, report].map(|r| r.bodies[0].position_m[0]);
        if x0 < 0.0 && x1 >= 0.0 {
            crossings.push(0.01 * (window as f64 + x0 / (x0 - x1)));
        }
        length = length.max((norm(report.bodies[0].position_m) - 0.5).abs());
        let open = closure(&before, report);
        worst = [worst[0].max(open[0]), worst[1].max(open[1])];
        before = report.clone();
    });
    let period = (crossings[crossings.len() - 1] - crossings[0]) / (crossings.len() - 1) as f64;
    let expected = std::f64::consts::TAU * (2.0 / (3.0 * G)).sqrt() * (1.0 + tilt * tilt / 16.0);
    let lift = energy(&first) + 0.5 * G;
    let lost = 1.0 - (energy(&last) + 0.5 * G) / lift;
    println!(
        "period {period} s of {expected} s, length off by {length:e} m, {:.2} % of the energy lost in 5 s",
        100.0 * lost
    );
    println!("closure {worst:?}, {:?}", last.counters);
    // First order in the substep; interpolation between windows.
    assert!((period / expected - 1.0).abs() < 0.005, "{period} s instead of {expected} s");
    assert!(length < 1e-4, "{length}");
    // Against momenta that pass through zero: roundings of g h m.
    assert!(worst[0] < 1e-11 && worst[1] < 1e-11, "{worst:?}");
}

#[test]
fn what_is_fixed_flies_as_one_and_what_turns_keeps_its_angular_momentum() {
    let bodies = vec![
        body("one", Source::Box { size_m: [0.1; 3] }, 1.0, [-0.05, 0.0, 0.0], [0.3, 0.1, 0.0], STILL),
        body("two", Source::Box { size_m: [0.1; 3] }, 3.0, [0.05, 0.0, 0.0], [0.3, 0.5, 0.0], STILL),
        body("three", Source::Sphere { radius_m: 0.03 }, 0.5, [0.25, 0.0, 0.0], [0.3, 0.0, 1.0], STILL),
    ];
    let mut scene = scene(bodies, 100, 0.01);
    scene.joints = vec![
        joint(JointKind::Fixed, "one", Some("two"), STILL, [0.0; 2]),
        joint(JointKind::Ball, "two", Some("three"), [0.15, 0.0, 0.0], [0.0, 0.0]),
    ];
    let first = start(&scene).1;
    let (mut before, mut worst, mut apart) = (first.clone(), [0.0_f64; 2], 0.0_f64);
    let last = play(&scene, |_, report| {
        let open = closure(&before, report);
        worst = [worst[0].max(open[0]), worst[1].max(open[1])];
        let [a, b] = [0, 1].map(|i| report.bodies[i].position_m);
        apart = apart.max((norm(sub(b, a)) - 0.1).abs());
        before = report.clone();
    });
    println!("closure {worst:?}, distance off by {apart:e} m, {:?}", last.counters);
    assert!(worst[0] < 1e-12 && worst[1] < 1e-12, "{worst:?}");
    // Nothing is outside here, but the moment of position corrections: a millionth of what turns.
    let change = common::momentum(&last).minus(common::momentum(&first));
    println!("linear {:e}, angular {:e}", norm(change.linear), norm(change.angular));
    assert!(norm(change.linear) < 1e-14);
    assert!(apart < 1e-4, "{apart}");
}

#[test]
fn joints_that_cannot_work_are_refused_by_name() {
    let refused = |joint: Joint| {
        let mut scene = scene(vec![cube("mass", 0.1, 1.0, STILL)], 1, 0.01);
        scene.joints = vec![joint];
        let Err(PluginError::Unsupported(why)) = cosplat_rigid::Rigid::default().setup(&scene) else {
            panic!("accepted")
        };
        assert!(why.contains("mass-joint"), "{why}");
    };
    refused(joint(JointKind::Fixed, "mass", None, STILL, [1.0, 0.0]));
    refused(joint(JointKind::Ball, "mass", Some("nobody"), STILL, [0.0; 2]));
    refused(joint(JointKind::Ball, "mass", None, STILL, [-1.0, 0.0]));
    refused(Joint { axis: [0.0; 3], ..joint(JointKind::Prismatic, "mass", None, STILL, [0.0; 2]) });
}
