//! The stiffest material of the first seed, its environment: made rigid unless asked otherwise (`run.rigidify = false`).

use crate::common::rock::view;
use crate::common::{Run, TO_MINUS_X, TO_MINUS_Y, TO_X, TO_Y, UPRIGHT, body, cuboid, elastic, plane, scene};
use cosplat_core::boundary::{BoundaryState, Impulses};
use cosplat_core::plugin::{ImpulseInput, Inputs, ViewRole};
use cosplat_core::scene::Wall;
use cosplat_mpm::Real;

/// A cube of 0.5 m of the environment of Table 4, between slip walls, under 1e5 Pa on its top: strain in the mean over a
/// swing, and substeps a second.
fn pressed<R: Real>() -> (f64, f64) {
    let (edge, pressure, window) = (0.5, 1e5, 2e-5);
    let dx = edge / 8.0;
    let middle = 0.5 * edge;
    let block = body("block", elastic(2.6e4, 5e10, 0.49), cuboid([edge; 3]), [middle; 3], 0.5 * dx);
    let mut start = scene(vec![block], window);
    start.statics = vec![
        plane("floor", [0.0; 3], UPRIGHT, Wall::Slip),
        plane("left", [0.0; 3], TO_X, Wall::Slip),
        plane("right", [edge, 0.0, 0.0], TO_MINUS_X, Wall::Slip),
        plane("front", [0.0; 3], TO_Y, Wall::Slip),
        plane("back", [0.0, edge, 0.0], TO_MINUS_Y, Wall::Slip),
    ];
    start.interfaces.push(view(ViewRole::ContactResponder, "block", 0.0));
    let mut run = Run::<R>::new(start);
    let BoundaryState::Samples(samples) = run.setup.boundaries[0].state.clone() else { panic!("samples") };
    // On the two top layers so that the force acts at the top, half a layer above them.
    let layer = |x: &[f64; 3]| ((edge - x[2]) / (0.5 * dx)) as usize;
    let layers: Vec<usize> = samples.position.iter().map(layer).collect();
    let of = |k: usize| layers.iter().filter(|l| **l == k).count() as f64;
    let parts = [1.5 / of(0), -0.5 / of(1)];
    let rest = run.setup.report.bodies[0].position_m[2];
    // Four crossings of sound: the period of the slowest swing. Three of them to load, two to measure.
    let wave = 5736.8;
    let period = (4.0 * edge / wave / window).round();
    let (mut sunk, measured) = (0.0, 2.0 * period);
    for i in 0..(5.0 * period) as usize {
        let share = 0.5 * (1.0 - (std::f64::consts::PI * (i as f64 / (3.0 * period)).min(1.0)).cos());
        let force = -pressure * edge * edge * share * window;
        let wanted = layers.iter().map(|&l| [0.0, 0.0, force * parts.get(l).unwrap_or(&0.0)]).collect();
        let impulses = vec![ImpulseInput { interface: 0, impulses: Impulses::Samples(wanted), spread: true }];
        let z = run.step_with(&Inputs { partners: Vec::new(), impulses }).report.bodies[0].position_m[2];
        sunk += if i as f64 >= 3.0 * period { (rest - z) / measured } else { 0.0 };
    }
    (sunk / middle, run.substeps as f64 / (run.window as f64 * window))
}

#[test]
fn a_block_of_the_stiffest_row_is_simulated_when_asked() {
    // Confined: the pressure over λ + 2μ = 8.557e11 Pa.
    let exact = 1e5 / 8.557e11;
    let ((double, rate), (single, _)) = (pressed::<f64>(), pressed::<f32>());
    println!("strain {double:e} in f64, {single:e} in f32, exact {exact:e}; {rate} substeps a second");
    // Published aim 5 %: with eight cells along an edge it is off by 4.9 %, with six by 5.9 %.
    assert!((double / exact - 1.0).abs() < 0.05, "{double:e}");
    // Strain is stored, not the deformation gradient: single precision keeps what 1 + 1.2e-7 could not hold.
    assert!((single / exact - 1.0).abs() < 0.05, "{single:e}");
}
