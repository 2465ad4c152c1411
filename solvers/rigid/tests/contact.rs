//! Contact and friction against textbook answers.

mod common;

use common::{
    G, STILL, above, advance, body, closure, collider, cube, energy, momentum, on_floor, plane, play, rough, scene,
    start, tilt,
};
use cosplat_conformance::parts::gravity;
use cosplat_core::boundary::{BoundaryState, dot, norm, sub};
use cosplat_core::plugin::{Inputs, Plugin, SolverScene};
use cosplat_core::scene::{ContactLaw, Motion, PairSpec, Source, Wall};

fn pair(a: &str, b: &str, friction: [f64; 2], restitution: f64) -> PairSpec {
    PairSpec {
        a: a.into(),
        b: b.into(),
        static_friction: friction[0],
        kinetic_friction: friction[1],
        restitution,
        softness_m: 0.002,
        contact: ContactLaw::Physical,
        resolver: None,
        enabled: true,
    }
}

/// One body of 1 kg on a plane that falls along +x by that angle, with its frame along the plane.
fn on_slope(source: Source, height: f64, angle: f64, wall: Wall, seconds: f64) -> SolverScene {
    let mut only = body("block", source, 1.0, above(angle, 0.0, height), STILL, STILL);
    only.pose.orientation = tilt(angle);
    let mut scene = scene(vec![only], (seconds / 0.01) as u64, 0.01);
    scene.actions = vec![gravity()];
    scene.statics = vec![plane("slope", tilt(angle), wall)];
    scene
}

/// How far down the slope the body has come \[m\].
fn slid(scene: &SolverScene, angle: f64) -> f64 {
    let first = start(scene).1.bodies[0].position_m;
    let last = play(scene, |_, _| {}).bodies[0].position_m;
    dot(sub(last, first), above(angle, 1.0, 0.0))
}

#[test]
fn a_block_slides_when_the_tangent_of_the_slope_exceeds_its_friction() {
    let plate = || Source::Box { size_m: [0.2, 0.2, 0.05] };
    let mu = 0.5_f64;
    for share in [0.98, 0.99, 1.01, 1.02] {
        let angle = (mu * share).atan();
        let scene = on_slope(plate(), 0.025, angle, rough(mu), 1.0);
        let way = slid(&scene, angle);
        let expected = if share > 1.0 { 0.5 * G * (angle.sin() - mu * angle.cos()) } else { 0.0 };
        println!("tan φ = {share} μ: {way:.6} m in 1 s, Coulomb {expected:.6} m");
        // One percent of the friction decides: 4 cm/s² of acceleration or none. What creeps must be below a hundredth
        // of what slides at the next step.
        if share < 1.0 {
            assert!(way.abs() < 2e-4, "{way}");
        } else {
            // First order in the substep: it starts within one of 1/480 s.
            assert!((way / expected - 1.0).abs() < 0.01, "{way} m instead of {expected} m");
        }
    }
}

#[test]
fn a_block_that_slides_stops_after_v_squared_over_two_mu_g_in_every_direction() {
    for heading in [0.0_f64, 22.5, 45.0, 70.0, 90.0] {
        let (sin, cos) = heading.to_radians().sin_cos();
        let mut block = body("block", Source::Box { size_m: [0.3, 0.3, 0.02] }, 1.0, [0.0, 0.0, 0.01], STILL, STILL);
        block.velocity = cosplat_conformance::parts::twist([2.0 * cos, 2.0 * sin, 0.0], STILL);
        let scene = on_floor(vec![block], 0.4, 100, 0.01);
        let end = play(&scene, |_, _| {});
        let last = end.bodies[0].position_m;
        // 2 J of kinetic energy go into friction; the height changes by what the block sinks into the floor, some µm.
        let taken = end.energy.dissipated_j;
        assert!((taken - 2.0).abs() < 1e-4, "{taken} J of 2 J");
        let (way, expected) = ((last[0] * last[0] + last[1] * last[1]).sqrt(), 4.0 / (2.0 * 0.4 * G));
        println!("heading {heading}°: {:.3} % off", 100.0 * (way / expected - 1.0));
        // Symplectic Euler at constant deceleration stops half a substep's way short: v h / 2, 0.4 % of the way.
        assert!((way / expected - 1.0).abs() < 0.01, "{way} m instead of {expected} m");
    }
}

#[test]
fn a_ball_rolls_down_with_five_sevenths_and_slips_where_friction_is_short() {
    let angle = 20_f64.to_radians();
    let ball = || Source::Sphere { radius_m: 0.05 };
    // Rolling needs μ ≥ 2/7 tan φ = 0.104.
    for (mu, acceleration) in [(0.5, 5.0 / 7.0 * G * angle.sin()), (0.05, G * (angle.sin() - 0.05 * angle.cos()))] {
        let scene = on_slope(ball(), 0.05, angle, rough(mu), 1.0);
        let way = slid(&scene, angle);
        let last = play(&scene, |_, _| {});
        let off = way / (0.5 * acceleration) - 1.0;
        let roll = last.bodies[0].angular_velocity_rad_s[1] * 0.05 / norm(last.bodies[0].linear_velocity_m_s);
        println!("μ = {mu}: {way:.5} m in 1 s, {:.3} % off; ω r / v = {roll:.5}", 100.0 * off);
        // Symplectic Euler leads by v h / 2 after 1 s: h / 1 s = 0.2 %.
        assert!(off.abs() < 0.005, "{off}");
        if mu > 0.1 {
            assert!((roll - 1.0).abs() < 1e-3, "{roll}");
        }
    }
}

#[test]
fn five_boxes_stay_where_they_are() {
    let boxes = (0..5).map(|i| cube(&format!("box{i}"), 0.1, 1.0, [0.0, 0.0, 0.05 + 0.1 * f64::from(i)])).collect();
    let scene = on_floor(boxes, 0.5, 200, 0.01);
    let (mut solver, first) = start(&scene);
    let (mut last, mut weight, mut worst) = (first.clone(), 0.0, [0.0_f64; 2]);
    for window in 0..200 {
        let report = advance(&mut solver, &scene, window, &Inputs::default()).report;
        // What is outside is gravity and the floor.
        weight = report.external.linear[2] / scene.clock.window_s() + 5.0 * G;
        let change = momentum(&report).minus(momentum(&last)).minus(report.external);
        worst = [worst[0].max(norm(change.linear)), worst[1].max(norm(change.angular))];
        last = report;
    }
    let drift = |k: usize| norm(sub(last.bodies[k].position_m, first.bodies[k].position_m));
    let most = (0..5).map(drift).fold(0.0, f64::max);
    let speed = last.bodies.iter().map(|b| norm(b.linear_velocity_m_s)).fold(0.0, f64::max);
    println!("drift {most:e} m, speed {speed:e} m/s, floor carries {weight} N of {} N", 5.0 * G);
    println!("open momentum {worst:?} N s; {:?}", last.counters);
    assert!(!last.counters.keys().any(|k| k.contains("disagree")), "{:?}", last.counters);
    // The catalogue's gate is 1 mm in 10 s for ten cubes; contact force within 1 %.
    assert!(most < 2e-4 && speed < 1e-3, "{most} m, {speed} m/s");
    assert!((weight / (5.0 * G) - 1.0).abs() < 0.01, "{weight}");
    // Against the weight of a window, 0.5 N s: roundings in double precision.
    assert!(worst[0] < 1e-15 && worst[1] < 1e-15, "{worst:?}");
}

#[test]
fn a_pair_has_its_own_friction_and_restitution() {
    let at = |i: u8| [0.0, f64::from(i), 0.025];
    let block =
        |name: &str, i| body(name, Source::Box { size_m: [0.2, 0.2, 0.05] }, 1.0, at(i), [1.0, 0.0, 0.0], STILL);
    let ball = |name: &str, y| body(name, Source::Sphere { radius_m: 0.05 }, 0.5, [0.0, y, 0.55], STILL, STILL);
    let bodies = vec![block("ice", 0), block("rubber", 1), ball("lively", 2.0), ball("dead", 3.0), ball("ghost", 4.0)];
    let mut scene = on_floor(bodies, 0.5, 60, 0.01);
    scene.pairs = vec![
        pair("ice", "floor", [0.02, 0.02], 0.0),
        pair("floor", "rubber", [0.9, 0.9], 0.0),
        pair("lively", "floor", [0.5, 0.5], 0.8),
        PairSpec { enabled: false, ..pair("ghost", "floor", [0.5, 0.5], 0.0) },
    ];
    let mut top = 0.0_f64;
    let last = play(&scene, |window, report| {
        if window > 35 {
            top = top.max(report.bodies[2].position_m[2] - 0.05);
        }
    });
    let speed = |k: usize| last.bodies[k].linear_velocity_m_s[0];
    println!("ice {} m/s, rubber {} m/s, bounce to {top} m, {:?}", speed(0), speed(1), last.counters);
    // Exact for a constant force, but for the substep in which contact begins: 0.02 g 0.6 s.
    assert!((speed(0) - (1.0 - 0.02 * G * 0.6)).abs() < 1e-3, "{}", speed(0));
    assert!(speed(1).abs() < 1e-6, "{}", speed(1));
    // e² of 0.5 m is 0.32 m; a substep's speed g h = 0.02 m/s of 3.1 m/s is 1.3 % of the height.
    assert!((top / 0.32 - 1.0).abs() < 0.015, "{top}");
    assert!((last.bodies[3].position_m[2] - 0.05).abs() < 1e-3, "no bounce where none is asked for");
    assert!((last.bodies[4].position_m[2] - (0.55 - 0.5 * G * 0.36)).abs() < 1e-9, "it falls through the floor");
}

#[test]
fn static_friction_holds_what_kinetic_friction_would_not() {
    let angle = 0.4_f64.atan();
    let wall = |s, k| Wall::Friction { static_friction: s, kinetic_friction: k };
    let plate = || Source::Box { size_m: [0.2, 0.2, 0.05] };
    let way = |wall, speed: f64| {
        let mut scene = on_slope(plate(), 0.025, angle, wall, 0.5);
        scene.bodies[0].velocity = cosplat_conformance::parts::twist(above(angle, speed, 0.0), STILL);
        slid(&scene, angle)
    };
    let (rests, slides) = (way(wall(0.5, 0.2), 0.0), way(wall(0.5, 0.2), 0.5));
    let expected = 0.5 * 0.5 + 0.5 * G * (angle.sin() - 0.2 * angle.cos()) * 0.25;
    println!("at rest {rests:e} m, pushed {slides} m of {expected} m; no slip {:e} m", way(Wall::NoSlip, 0.0));
    assert!(rests.abs() < 1e-4 && way(Wall::NoSlip, 0.0).abs() < 1e-4);
    // First order in the substep.
    assert!((slides / expected - 1.0).abs() < 0.01);
    let frictionless = way(Wall::Slip, 0.0) / (0.5 * G * angle.sin() * 0.25);
    assert!((frictionless - 1.0).abs() < 0.01, "{frictionless}");
}

#[test]
fn a_belt_carries_and_a_piston_lifts() {
    let mut scene = on_floor(vec![cube("load", 0.1, 1.0, [0.0, 0.0, 0.15])], 0.5, 100, 0.01);
    let mut belt =
        collider("belt", Source::Box { size_m: [10.0, 1.0, 0.1] }, [0.0, 0.0, 0.05], [0.0, 0.0, 0.0, 1.0], rough(0.8));
    belt.motion = Some(Motion::Twist { linear_m_s: [0.5, 0.0, 0.2], angular_rad_s: STILL });
    scene.statics.push(belt);
    let (_, first) = start(&scene);
    let (mut before, mut supplied) = (first.clone(), 0.0);
    let last = play(&scene, |_, report| {
        let open = closure(&before, report);
        assert!(open[0] < 1e-12 && open[1] < 1e-12, "{open:?}");
        supplied += report.supplied_j;
        before = report.clone();
    });
    let left = energy(&last) + last.energy.dissipated_j - energy(&first) - supplied;
    println!("supplied {supplied} J, dissipated {} J, {left} J unexplained", last.energy.dissipated_j);
    // Where it is caught and lifted, work is known to the weight times the way in a substep.
    assert!(supplied > 2.0 && left.abs() < G * 0.2 / 480.0, "{supplied} {left}");
    let v = last.bodies[0].linear_velocity_m_s;
    assert!(norm(sub(v, [0.5, 0.0, 0.2])) < 1e-3, "{v:?}");
}

#[test]
fn the_proxy_foresees_its_support() {
    let mut scene = on_floor(vec![cube("box", 0.1, 1.0, [0.0, 0.0, 0.05])], 0.5, 20, 0.01);
    scene.interfaces = vec![common::contact(0, "box")];
    let mut solver = cosplat_rigid::Rigid::default();
    let setup = solver.setup(&scene).unwrap();
    let BoundaryState::Proxy(first) = &setup.boundaries[0].state else { panic!("not a proxy") };
    assert_eq!(first.background_linear.map(f64::to_bits), [0.0_f64, 0.0, -G].map(f64::to_bits));
    let mut rest = [1.0; 3];
    for window in 0..20 {
        let out = advance(&mut solver, &scene, window, &Inputs::default());
        let BoundaryState::Proxy(proxy) = &out.boundaries[0].state else { panic!("not a proxy") };
        rest = proxy.background_linear;
    }
    // A body at rest is carried: single precision of the contact's impulse.
    assert!(norm(rest) < 1e-4 * G, "{rest:?}");
}

#[test]
fn a_bullet_does_not_cross_a_thin_wall() {
    for speed in [30.0, 100.0, 300.0] {
        let shot = body("shot", Source::Sphere { radius_m: 0.02 }, 0.1, [-1.0, 0.0, 0.0], [speed, 0.0, 0.0], STILL);
        let mut scene = scene(vec![shot], 10, 0.01);
        let wall = Source::Box { size_m: [0.001, 2.0, 2.0] };
        scene.statics = vec![collider("wall", wall, STILL, [0.0, 0.0, 0.0, 1.0], rough(0.5))];
        let mut before = start(&scene).1;
        let last = play(&scene, |_, report| {
            let open = closure(&before, report);
            assert!(open[0] * norm(report.bodies[0].linear_velocity_m_s) < 1e-10, "{open:?}");
            before = report.clone();
        });
        let (x, v) = (last.bodies[0].position_m[0], last.bodies[0].linear_velocity_m_s[0]);
        println!("{speed} m/s: ends at {x} m with {v} m/s, {:?}", last.counters);
        assert!(!last.counters.keys().any(|k| k.contains("disagree")), "{:?}", last.counters);
        // Without restitution it stays in front of the wall.
        assert!(x < 0.0 && v.abs() < 1e-3 * speed, "{speed} m/s: {x} m, {v} m/s");
    }
}
