//! Does a coupled run through real processes and the real bus reach the published coupling errors?
//!
//! Partitioned oscillator of Schüller, Rodenberg, Uekermann, Bungartz (2022): exact `u₁,₂ = ½ (cos 2πt ± cos 6πt)`. Each
//! side is integrated exactly with its partner held, so that what is left is the error of the coupling alone. The
//! expected errors were computed independently of this program; ±2 % catches a window too many, a wrong order and a
//! wrong extrapolation, each of which changes them by tens of percent.

mod support;

use std::f64::consts::PI;
use support::{Oscillator, Program, Run};

/// Largest distance of either mass from the exact solution within one second.
fn largest_error(run: &Run) -> f64 {
    let (header, rows) = run.csv("probes.csv");
    let column =
        |name: &str| header.iter().position(|h| h == name).unwrap_or_else(|| panic!("no `{name}` in {header:?}"));
    let (t, left, right) = (column("time_s"), column("left.x"), column("right.x"));
    let exact = |time: f64, sign: f64| 0.5 * ((2.0 * PI * time).cos() + sign * (6.0 * PI * time).cos());
    assert!(!rows.is_empty(), "probes are written each window");
    rows.iter()
        .filter(|row| row[t] <= 1.0 + 1e-9)
        .map(|row| (row[left] - exact(row[t], 1.0)).abs().max((row[right] - exact(row[t], -1.0)).abs()))
        .fold(0.0, f64::max)
}

/// Largest relative deviation of the total energy from the start, `½ k u² + ½ k₁₂ u²` with u = 1.
fn largest_energy_deviation(run: &Run) -> f64 {
    let start = 0.5 * support::GROUND + 0.5 * 4.0 * support::GROUND;
    let energies: Vec<f64> = run.ledger("total_energy_j").iter().map(|e| e.parse().expect("a number")).collect();
    assert!(energies.len() >= 100, "one row a window");
    energies.iter().map(|e| (e / start - 1.0).abs()).fold(0.0, f64::max)
}

fn run(window: f64, duration: f64, scheme: &str) -> Run {
    let scene = Oscillator { window, duration, scheme, ..Oscillator::default() }.scene();
    Program::run(&scene, &["--quiet"]).finish().expect_code(0)
}

#[track_caller]
fn assert_error(scheme: &str, window: f64, expected: f64) {
    let error = largest_error(&run(window, 1.0, scheme));
    assert!((error / expected - 1.0).abs() <= 0.02, "{scheme} at {window} s: {error:e} instead of {expected:e}");
}

#[test]
fn parallel_hold_has_the_published_error() {
    assert_error("parallel", 0.01, 0.404_031_84);
    assert_error("parallel", 0.0025, 0.098_849_937);
}

#[test]
fn serial_hold_has_the_published_error() {
    assert_error("serial", 0.01, 0.104_168_91);
    assert_error("serial", 0.0025, 0.026_147_104);
}

#[test]
fn alternating_hold_has_the_published_error_and_is_of_second_order() {
    assert_error("alternating", 0.04, 0.208_509_71);
    assert_error("alternating", 0.01, 0.013_222_506);
    assert_error("alternating", 0.0025, 0.000_829_228_61);
}

/// Freezing the partner and solving one side exactly is an exact partial flow of the total Hamiltonian: only rounding
/// is left, a thousand windows of about 1e-16 each with room for its random walk.
#[test]
fn alternating_and_serial_keep_the_energy_exactly_over_ten_seconds() {
    for scheme in ["alternating", "serial"] {
        let deviation = largest_energy_deviation(&run(0.01, 10.0, scheme));
        assert!(deviation < 1e-10, "{scheme}: {deviation:e}");
    }
}

/// The same springs as an interface across which impulses travel.
#[test]
fn centred_impulses_have_the_known_error_and_move_momentum_exactly() {
    for (window, expected) in [(0.01, 2.605e-3), (0.005, 6.503e-4)] {
        let run = run(window, 1.0, "centred");
        let error = largest_error(&run);
        assert!((error / expected - 1.0).abs() <= 0.02, "{window} s: {error:e} instead of {expected:e}");
        let interface = &run.summary["interfaces"][0];
        assert_eq!(interface["transfer_defect"].as_f64(), Some(0.0), "what was sent is what arrived, to the bit");
        let closure = interface["closure"].as_f64().expect("closure is measured");
        assert!(closure > 0.0 && closure < 1e-12, "a double-precision solver closes to rounding, not {closure:e}");
    }
}

/// Strang splitting is symplectic: the energy oscillates with W² and does not drift. 0.43 % is its computed amplitude.
#[test]
fn centred_impulses_keep_the_energy_bounded_over_ten_seconds() {
    let deviation = largest_energy_deviation(&run(0.01, 10.0, "centred"));
    assert!(deviation < 0.0043 * 1.02, "{deviation:e}");
    assert!(deviation > 0.0043 * 0.9, "{deviation:e}: smaller than the scheme can be, so something else was run");
}
