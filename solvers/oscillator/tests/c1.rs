//! Two oscillators cut at their spring (C1): each solver is exact, so what is left is the error of the scheme alone.
//!
//! Schüller, Rodenberg, Uekermann, Bungartz (2022): m = 1 kg, k = 4π² N/m to the world, 16π² N/m between; from
//! u = (1, 0) at rest u = ½ (cos 2πt ± cos 6πt). Expected errors: table D01 of the verification catalogue, computed
//! there by an independent script; centred scheme: computed by an independent script for this project's definition.

#[cfg(test)]
mod common;

use std::f64::consts::PI;

use common::{Run, point, scene};
use cosplat_conformance::parts::spring;
use cosplat_core::boundary::{norm, sub};
use cosplat_core::scene::{MotionRule, Scene, Scheme};

/// Distance between the two rest positions \[m\]; not zero, so that anchors and rest vectors are exercised.
const APART: f64 = 3.0;

/// Allowed deviation from a tabulated error. The catalogue allows 2 %; its tables have eight digits and solver and
/// schemes are the same, so all of them must be met.
const GATE: f64 = 1e-6;

/// The same for the centred scheme, known to four digits.
const CENTRED_GATE: f64 = 2e-4;

fn c1(duration_s: f64, window_s: f64, scheme: Scheme, rule: MotionRule) -> Scene {
    let mut scene = scene(duration_s, window_s, scheme, rule);
    let (outer, inner) = (4.0 * PI * PI, 16.0 * PI * PI);
    scene.bodies = vec![
        point("left", "left-mass", 1.0, [1.0, 0.0, 0.0], [0.0; 3]),
        point("right", "right-mass", 1.0, [APART, 0.0, 0.0], [0.0; 3]),
    ];
    scene.links = vec![
        spring("left-mass", None, outer, [0.0; 3], [0.0; 3]),
        spring("right-mass", None, outer, [0.0; 3], [APART, 0.0, 0.0]),
        spring("left-mass", Some("right-mass"), inner, [0.0; 3], [-APART, 0.0, 0.0]),
    ];
    scene
}

/// Largest error of both displacements within 1 s \[m\].
fn error(window_s: f64, scheme: Scheme, rule: MotionRule) -> f64 {
    let mut scene = c1(1.0, window_s, scheme, rule);
    let mut run = Run::start(&mut scene);
    let mut worst = 0.0_f64;
    for window in 0..run.plan.clock.windows {
        run.window(window);
        let t = run.plan.clock.seconds(run.plan.clock.start_of(window + 1));
        let (slow, fast) = ((2.0 * PI * t).cos(), (6.0 * PI * t).cos());
        let left = sub(run.position("left-mass"), [0.5 * (slow + fast), 0.0, 0.0]);
        let right = sub(run.position("right-mass"), [APART + 0.5 * (slow - fast), 0.0, 0.0]);
        worst = worst.max(norm(left)).max(norm(right));
    }
    // Sums of forces against sums of states, both in f64 over one window: a few roundings.
    assert!(run.closure[0] < 1e-13 && run.closure[1] < 1e-13, "closure {:?}", run.closure);
    worst
}

fn expect(expected: f64, window_s: f64, scheme: Scheme, rule: MotionRule) {
    let found = error(window_s, scheme, rule);
    println!("{scheme:?} {rule:?} {window_s} s: {found:.7e} m, table {expected:.7e} m");
    let gate = if scheme == Scheme::Centred { CENTRED_GATE } else { GATE };
    assert!(
        (found / expected - 1.0).abs() < gate,
        "{scheme:?} {rule:?} at {window_s} s: {found} instead of {expected}"
    );
}

#[test]
fn parallel_hold_is_of_first_order() {
    expect(0.404_031_84, 0.01, Scheme::Parallel, MotionRule::Hold);
    expect(0.198_599_08, 0.005, Scheme::Parallel, MotionRule::Hold);
}

#[test]
fn serial_hold_is_of_first_order() {
    expect(0.411_22, 0.04, Scheme::Serial, MotionRule::Hold);
    expect(0.104_168_91, 0.01, Scheme::Serial, MotionRule::Hold);
    expect(0.052_226_405, 0.005, Scheme::Serial, MotionRule::Hold);
}

#[test]
fn alternating_hold_is_of_second_order() {
    expect(0.208_509_71, 0.04, Scheme::Alternating, MotionRule::Hold);
    expect(0.013_222_506, 0.01, Scheme::Alternating, MotionRule::Hold);
    expect(0.003_316_301_2, 0.005, Scheme::Alternating, MotionRule::Hold);
}

#[test]
fn parallel_linear_is_of_second_order() {
    expect(0.013_358_996, 0.01, Scheme::Parallel, MotionRule::Linear);
    expect(0.003_323_783_9, 0.005, Scheme::Parallel, MotionRule::Linear);
}

#[test]
fn serial_linear_is_of_second_order() {
    expect(0.004_439_564_7, 0.01, Scheme::Serial, MotionRule::Linear);
    expect(0.001_127_462_9, 0.005, Scheme::Serial, MotionRule::Linear);
}

#[test]
fn centred_is_of_second_order() {
    expect(2.605e-3, 0.01, Scheme::Centred, MotionRule::Hold);
    expect(6.503e-4, 0.005, Scheme::Centred, MotionRule::Hold);
}

/// Largest relative deviation of the total energy, and of what would be momentum without springs to the world.
fn drift(duration_s: f64, scheme: Scheme, rule: MotionRule) -> f64 {
    let mut scene = c1(duration_s, 0.01, scheme, rule);
    let mut run = Run::start(&mut scene);
    let start = run.energy(&scene);
    let mut worst = 0.0_f64;
    for window in 0..run.plan.clock.windows {
        run.window(window);
        worst = worst.max((run.energy(&scene) / start - 1.0).abs());
    }
    println!("{scheme:?} {rule:?}: energy deviation {worst:e} over {duration_s} s, closure {:?}", run.closure);
    assert!(run.closure.iter().all(|&c| c < 1e-12), "gate of a double-precision build: {:?}", run.closure);
    worst
}

#[test]
fn held_partners_keep_the_energy() {
    // 1000 windows of a few roundings each; the catalogue's own script has 1e-13.
    assert!(drift(10.0, Scheme::Serial, MotionRule::Hold) < 2e-12);
    assert!(drift(10.0, Scheme::Alternating, MotionRule::Hold) < 2e-12);
}

#[test]
fn the_centred_scheme_keeps_the_energy_bounded() {
    // Symplectic, not energy-exact: oscillates with the window squared and must not grow.
    let (short, long) =
        (drift(10.0, Scheme::Centred, MotionRule::Hold), drift(40.0, Scheme::Centred, MotionRule::Hold));
    assert!(short < 0.05 && long < 1.05 * short, "{short} then {long}");
}

#[test]
fn parallel_hold_gains_energy() {
    // Negative control: 2338.893 at 10 s in the table.
    let found = drift(10.0, Scheme::Parallel, MotionRule::Hold);
    assert!((found / 2338.893 - 1.0).abs() < GATE, "{found}");
}
