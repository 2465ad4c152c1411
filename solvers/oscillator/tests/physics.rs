//! The solver in three dimensions: budgets under every scheme, actions that begin inside a step, several bodies in one
//! solver, and what it refuses.

#[cfg(test)]
mod common;

use common::{Run, point, scene};
use cosplat_conformance::parts::{action, gravity, solver_scene, spring, step};
use cosplat_core::boundary::{norm, sub};
use cosplat_core::plugin::{Inputs, Plugin, PluginError, SolverScene, Steady};
use cosplat_core::scene::{ActionKind, Field, MotionRule, Scene, Scheme, Space};
use cosplat_oscillator::Oscillator;

/// Four masses of two solvers: chains inside, springs with a rest vector across, gravity, a push for a while, a kick.
fn tangle(duration_s: f64, scheme: Scheme, rule: MotionRule) -> Scene {
    let mut scene = scene(duration_s, 0.01, scheme, rule);
    scene.bodies = vec![
        point("one", "a", 1.0, [1.0, 0.2, 5.0], [0.3, -1.0, 0.0]),
        point("two", "b", 0.3, [2.0, -0.4, 5.5], [0.0, 0.5, 1.0]),
        point("one", "c", 2.5, [0.1, 1.3, 4.0], [-0.2, 0.0, 0.7]),
        point("two", "d", 7.0, [3.0, 0.9, 6.0], [0.0; 3]),
    ];
    scene.links = vec![
        spring("a", None, 40.0, [0.0, 0.0, 5.0], [0.0; 3]),
        spring("a", Some("c"), 90.0, [0.0; 3], [0.3, -0.9, 1.1]),
        spring("b", Some("d"), 55.0, [0.0; 3], [0.0; 3]),
        spring("a", Some("b"), 120.0, [0.0; 3], [-1.0, 0.5, 0.2]),
    ];
    scene.actions = vec![
        gravity(),
        action(ActionKind::PointForce { force_n: [1.0, 2.0, -3.0], at_m: None }, 0.0333, Some(0.127)),
        action(
            ActionKind::AccelerationField { field: Field::Constant { acceleration_m_s2: [0.5, 0.0, 0.0] } },
            0.2,
            Some(0.31),
        ),
        action(ActionKind::Impulse { impulse_n_s: [0.0, 1.0, 0.5], at_m: None }, 0.0777, None),
    ];
    scene
}

#[test]
fn every_scheme_explains_every_momentum() {
    for scheme in [Scheme::Serial, Scheme::Parallel, Scheme::Alternating, Scheme::Centred] {
        for rule in [MotionRule::Hold, MotionRule::Linear, MotionRule::Hermite] {
            let mut scene = tangle(0.5, scheme, rule);
            let mut run = Run::start(&mut scene);
            for window in 0..run.plan.clock.windows {
                run.window(window);
            }
            println!("{scheme:?} {rule:?}: closure {:?}", run.closure);
            // Some twenty sums of f64 numbers a window; measured 1e-15.
            assert!(run.closure[0] < 1e-14 && run.closure[1] < 1e-14, "{scheme:?} {rule:?}: {:?}", run.closure);
        }
    }
}

#[test]
fn work_through_interfaces_explains_every_energy() {
    for scheme in [Scheme::Serial, Scheme::Parallel, Scheme::Alternating, Scheme::Centred] {
        let mut scene = tangle(0.5, scheme, MotionRule::Hermite);
        let mut run = Run::start(&mut scene);
        (0..run.plan.clock.windows).for_each(|w| run.window(w));
        println!("{scheme:?}: work defect {:e} J", run.work_defect);
        // Energies of some 500 J known to a few roundings.
        assert!(run.work_defect < 2e-12, "{scheme:?}: {} J", run.work_defect);
    }
}

#[test]
fn schemes_converge_to_the_undivided_system() {
    // All masses in one solver: exact. The same cut at a spring must approach it with the square of the window.
    let whole = {
        let mut scene = tangle(0.5, Scheme::Alternating, MotionRule::Hold);
        scene.bodies.iter_mut().for_each(|b| b.solver = "one".into());
        let mut run = Run::start(&mut scene);
        (0..run.plan.clock.windows).for_each(|w| run.window(w));
        run
    };
    assert!(whole.plan.interfaces.is_empty());
    for (scheme, rule) in [
        (Scheme::Alternating, MotionRule::Hold),
        (Scheme::Centred, MotionRule::Hold),
        (Scheme::Serial, MotionRule::Hermite),
    ] {
        let error = |window_s: f64| {
            let mut scene = tangle(0.5, scheme, rule);
            scene.clock.window_s = Some(window_s);
            let mut run = Run::start(&mut scene);
            (0..run.plan.clock.windows).for_each(|w| run.window(w));
            ["a", "b", "c", "d"].iter().map(|n| norm(sub(run.position(n), whole.position(n)))).fold(0.0, f64::max)
        };
        let (coarse, fine) = (error(0.0025), error(0.00125));
        let order = (coarse / fine).log2();
        println!("{scheme:?} {rule:?}: {coarse:e} m, {fine:e} m, order {order:.3}");
        // Kinks of the actions lie inside windows, so the order is met to a few per cent only.
        assert!(order > 1.85, "{scheme:?} {rule:?}: order {order}");
    }
}

#[test]
fn the_centred_scheme_conserves_momentum() {
    let mut scene = scene(2.0, 0.01, Scheme::Centred, MotionRule::Hold);
    scene.bodies = vec![
        point("one", "a", 1.0, [1.0, 0.2, 5.0], [0.3, -1.0, 0.0]),
        point("two", "b", 0.3, [2.0, -0.4, 5.5], [0.0, 0.5, 1.0]),
    ];
    scene.links = vec![spring("a", Some("b"), 120.0, [0.0; 3], [0.0; 3])];
    let mut run = Run::start(&mut scene);
    let start = run.momentum();
    let mut worst = [0.0_f64; 2];
    for window in 0..run.plan.clock.windows {
        run.window(window);
        let change = run.momentum().minus(start);
        worst = [worst[0].max(norm(change.linear)), worst[1].max(norm(change.angular))];
    }
    println!("momentum {worst:?} of {start:?}");
    // 200 windows of a few roundings each; momenta are of order 1 kg m/s and 10 kg m²/s.
    assert!(worst[0] < 1e-13 && worst[1] < 1e-12, "{worst:?}");
}

#[test]
fn time_runs_backwards() {
    // Exact flows of held partners are reversible; alternating over an even number of windows is not symmetric itself,
    // the centred scheme is.
    let mut scene = tangle(1.0, Scheme::Centred, MotionRule::Hold);
    scene.actions.truncate(1);
    let start: Vec<[f64; 3]> = scene.bodies.iter().map(|b| b.pose.position_m).collect();
    let mut run = Run::start(&mut scene);
    (0..50).for_each(|w| run.window(w));
    run.reverse();
    (50..100).for_each(|w| run.window(w));
    for (name, start) in ["a", "b", "c", "d"].iter().zip(start) {
        let error = norm(sub(run.position(name), start));
        assert!(error < 1e-11, "{name}: {error} m after 100 windows of roundings");
    }
}

fn blank() -> SolverScene {
    solver_scene("one", vec![point("one", "a", 1.0, [0.0, 0.0, 1.0], [1.0, 0.0, 0.0])], 1, 1.0)
}

#[test]
fn free_fall_is_a_parabola_and_a_switch_inside_a_step_is_met() {
    let mut scene = blank();
    scene.actions = vec![action(ActionKind::Gravity { acceleration_m_s2: [0.0, 0.0, -10.0] }, 0.25, Some(0.75))];
    let mut solver = Oscillator::default();
    solver.setup(&scene).unwrap();
    let report = solver.advance(&step(&scene.clock, 0), &Inputs::default(), &mut Steady).unwrap().report;
    // 0.5 s of fall: v = -5 m/s; then 0.25 s straight on: z = 1 - 1.25 - 1.25 m.
    assert!(norm(sub(report.bodies[0].position_m, [1.0, 0.0, -1.5])) < 1e-15, "{:?}", report.bodies[0]);
    assert!(norm(sub(report.external.linear, [0.0, 0.0, -5.0])) < 1e-15);
    assert_eq!(report.substeps, 3);
}

#[test]
fn everything_missing_is_refused_at_once_by_name() {
    let mut scene = blank();
    scene.space = Space::Slab { normal: 1, thickness_m: 1.0 };
    scene.links = vec![spring("a", None, 1.0, [0.0; 3], [0.0; 3])];
    scene.links[0].damping_n_s_m = 0.1;
    scene.actions = vec![action(
        ActionKind::Wind { velocity_m_s: [1.0, 0.0, 0.0], air_density_kg_m3: 1.2, drag_coefficient: 1.0 },
        0.0,
        None,
    )];
    scene.params.insert("order".into(), 4.into());
    scene.bodies[0].source = cosplat_core::scene::Source::Points { positions_m: vec![[0.0; 3]; 2] };
    let Err(PluginError::Unsupported(message)) = Oscillator::default().setup(&scene) else { panic!("accepted") };
    for name in ["slab", "damped links (`a-world`)", "wind", "`order`", "2 points"] {
        assert!(message.contains(name), "`{name}` is not named in: {message}");
    }
}
