//! Saved states, threads, and what is refused.

mod common;

use common::{STILL, advance, body, cube, on_floor, scene, start};
use cosplat_core::plugin::{Inputs, Plugin, PluginError, SolverScene};
use cosplat_core::scene::Source;
use cosplat_rigid::Rigid;

/// A heap: boxes, cans and balls that fall on each other for half a second.
fn heap() -> SolverScene {
    let shapes = [
        Source::Box { size_m: [0.1, 0.12, 0.08] },
        Source::Sphere { radius_m: 0.05 },
        Source::Cylinder { radius_m: 0.04, height_m: 0.1 },
    ];
    let bodies = (0..15_u8).map(|i| {
        let (x, z) = (0.03 * f64::from(i % 3), 0.08 + 0.11 * f64::from(i));
        body(
            &format!("b{i}"),
            shapes[usize::from(i % 3)].clone(),
            1.0,
            [x, 0.02 * x, z],
            STILL,
            [0.3, 1.0, f64::from(i)],
        )
    });
    on_floor(bodies.collect(), 0.4, 60, 0.01)
}

fn saved(solver: &Rigid) -> Vec<u8> {
    let mut bytes = Vec::new();
    solver.save(&mut bytes);
    bytes
}

#[test]
fn a_heap_goes_on_bitwise_after_a_restore_and_on_any_number_of_threads() {
    let scene = heap();
    let (mut whole, _) = start(&scene);
    let mut checkpoint = Vec::new();
    for window in 0..60 {
        if window == 30 {
            checkpoint = saved(&whole);
        }
        let report = advance(&mut whole, &scene, window, &Inputs::default()).report;
        // The impulses read back from rapier are the ones with which it moved the bodies.
        assert!(!report.counters.keys().any(|k| k.contains("disagree")), "{:?}", report.counters);
    }
    let end = saved(&whole);
    let (mut restored, _) = start(&scene);
    restored.restore(&checkpoint).expect("it is its own state");
    for window in 30..60 {
        advance(&mut restored, &scene, window, &Inputs::default());
    }
    assert!(saved(&restored) == end, "the second half differs after a restore");
    // The same instance, taken back from the end.
    whole.restore(&checkpoint).expect("it is its own state");
    for window in 30..60 {
        advance(&mut whole, &scene, window, &Inputs::default());
    }
    assert!(saved(&whole) == end, "the second half differs when repeated");
    let mut threads = scene.clone();
    threads.threads = 2;
    let (mut parallel, _) = start(&threads);
    (0..60).for_each(|w| drop(advance(&mut parallel, &threads, w, &Inputs::default())));
    assert!(saved(&parallel) == end, "two threads give other bits");
    println!("{} bytes of state for 15 bodies", end.len());
}

#[test]
fn what_is_absurdly_fast_is_named() {
    let mut scene = scene(vec![cube("shot", 0.1, 1.0, STILL)], 1, 0.01);
    scene.bodies[0].velocity = cosplat_conformance::parts::twist([2e5, 0.0, 0.0], STILL);
    let Err(PluginError::Physics(why)) = Rigid::default().setup(&scene) else { panic!("accepted") };
    assert!(why.contains("shot") && why.contains("2.000e5 m/s"), "{why}");
}

#[test]
fn parameters_are_checked_and_bound_the_substep() {
    let with = |params: &[(&str, f64)]| {
        let mut scene = scene(vec![cube("box", 0.1, 1.0, STILL)], 1, 0.01);
        scene.params = params.iter().map(|&(key, value)| (key.to_owned(), value.into())).collect();
        scene
    };
    for (params, substeps, bound) in
        [(&[][..], 5, "default"), (&[("substeps", 3.0)], 3, "`substeps`"), (&[("substep_s", 1e-3)], 10, "`substep_s`")]
    {
        let scene = with(params);
        let report = advance(&mut start(&scene).0, &scene, 0, &Inputs::default()).report;
        assert_eq!(report.substeps, substeps);
        assert!(report.substep_bound_by.contains(bound), "{}", report.substep_bound_by);
    }
    for params in [
        &[("substeps", 0.0)][..],
        &[("substep_s", -1.0)],
        &[("solver_iterations", 2.5)],
        &[("substeps", 2.0), ("substep_s", 0.1)],
        &[("gravity", 1.0)],
    ] {
        let Err(PluginError::Unsupported(why)) = Rigid::default().setup(&with(params)) else { panic!("accepted") };
        assert!(why.contains(params[0].0), "{why}");
    }
}
