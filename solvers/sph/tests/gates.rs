//! Inflows and drains: what enters and leaves, and that the books stay closed.

#[cfg(test)]
mod common;

use common::{Run, columns, liquid, scene, tank, water};
use cosplat_core::plugin::{Plugin, SolverScene};
use cosplat_core::scene::{Action, ActionKind, Opening, Wall};

const BOTH: [&str; 2] = ["wcsph", "dfsph"];
const D: f64 = 0.02;
const SPEED: f64 = 1.0;

fn action(kind: ActionKind, until_s: f64) -> Action {
    Action { kind, bodies: vec!["water".into()], from_s: 0.05, until_s: Some(until_s) }
}

/// A pool below a jet, in a tank with a drain on a part of its floor.
fn pool(opening: Opening, pressure: &str) -> SolverScene {
    let body = liquid(water(20.0, 1.0), [0.2, 0.2, 0.06], [0.1, 0.1, 0.03], D);
    let mut start = scene(vec![body], tank(0.2, 0.2, Wall::Slip), 2e-3);
    let jet = ActionKind::Inflow { center_m: [0.1, 0.1, 0.3], velocity_m_s: [0.0, 0.0, -SPEED], opening };
    start.actions.push(action(jet, 0.25));
    start.params.insert("pressure".into(), pressure.into());
    start
}

fn masses(run: &mut Run, windows: u64) -> Vec<f64> {
    (0..windows).map(|_| run.step().report.bodies[0].mass_kg).collect()
}

#[test]
fn what_enters_has_the_mass_and_the_momentum_of_the_jet() {
    BOTH.into_iter().for_each(enters);
}

fn enters(pressure: &str) {
    // 4 x 3 cells across; from 0.05 s to 0.25 s ten layers of them.
    let mut run = Run::new(pool(Opening::Rectangle { size_m: [0.08, 0.06] }, pressure));
    let before = run.setup.report.bodies[0].mass_kg;
    let mass = masses(&mut run, 150);
    let layer = 12.0 * 1000.0 * D.powi(3);
    let after = |time: f64| mass[(time / 2e-3).round() as usize - 1] - before;
    println!("{before} kg, then {:?}, defect {:?} of {}", mass.last(), run.defect, run.gross);
    // Rounding of sums of a thousand masses.
    assert!(after(0.048).abs() < 1e-12, "nothing before it begins");
    assert!((after(0.152) - 6.0 * layer).abs() < 1e-12, "a layer each 20 ms: {}", after(0.152) / layer);
    assert!((after(0.3) - 10.0 * layer).abs() < 1e-12, "and none after its end: {}", after(0.3) / layer);
    assert!(run.defect[0] < 1e-12 * run.gross && run.defect[1] < 1e-12 * run.gross, "{:?}", run.defect);
    // The jet falls 0.24 m from 1 m/s; no particle of it was thrown, and all that waited has entered.
    let (_, v, rho) = columns(&run.bytes());
    assert!(rho.iter().all(|rho| *rho > 0.0), "all have entered");
    let fastest = v.iter().map(|v| -v[2]).fold(0.0, f64::max);
    assert!(fastest < 1.1 * (SPEED * SPEED + 2.0 * 9.81 * 0.24_f64).sqrt(), "{fastest}");
}

#[test]
fn the_energy_of_a_jet_is_supplied() {
    BOTH.into_iter().for_each(supplies);
}

fn supplies(pressure: &str) {
    // In free fall nothing else happens to it: from 0.05 s to 0.15 s it falls by less than 0.18 m, above the pool.
    let mut run = Run::new(pool(Opening::Rectangle { size_m: [0.08, 0.06] }, pressure));
    let of = |e: cosplat_core::plugin::Energy| e.kinetic_j + e.potential_j + e.dissipated_j;
    let (mut supplied, mut all) = (0.0, Vec::new());
    for _ in 0..75 {
        let report = run.step().report;
        supplied += report.supplied_j;
        all.push((of(report.energy), supplied));
    }
    // Five layers by then, each held against gravity over the reach of the kernel, 2.4 spacings, or as far as it has come.
    let held: f64 = [0.1, 0.08, 0.06, 0.04, 0.02_f64].iter().map(|way| way.min(2.4 * D)).sum();
    let layer = 12.0 * 1000.0 * D.powi(3);
    let ([(e0, w0), (e1, w1)], gained) = ([all[24], all[74]], layer * (5.0 * (0.5 + 9.81 * 0.3) - 9.81 * held));
    println!("{} J supplied, {gained} J counted by hand, energy rose by {} J", w1 - w0, e1 - e0);
    // A layer may enter a substep later: the energy of falling in a millisecond is 1e-3 of it.
    assert!((w1 - w0 - gained).abs() < 1e-2 * gained, "{}", w1 - w0);
    assert!((e1 - e0 - (w1 - w0)).abs() < 1e-2 * gained, "{}", e1 - e0);
}

#[test]
fn a_drain_takes_what_is_in_it() {
    BOTH.into_iter().for_each(drains);
}

fn drains(pressure: &str) {
    let mut start = pool(Opening::Disc { radius_m: 0.05 }, pressure);
    let drain = ActionKind::Drain { center_m: [0.1, 0.1, 0.0], size_m: [0.1, 0.1, 0.04] };
    start.actions.push(action(drain, 10.0));
    let mut run = Run::new(start.clone());
    let layer = run.setup.particles[0] - 300;
    assert_eq!(layer % 10, 0, "ten layers wait");
    let (mut entered, mut left) = (0, 0);
    let before = run.setup.report.bodies[0].mass_kg;
    let mut last = before;
    let mut again = None;
    for window in 0..150 {
        if window == 80 {
            let mut restored = Run::new(start.clone());
            restored.plugin.restore(&run.bytes()).expect("its own state");
            restored.window = run.window;
            again = Some(restored);
        }
        let report = run.step().report;
        entered += report.counters["admitted-particles"];
        left += report.counters["drained-particles"];
        last = report.bodies[0].mass_kg;
        if let Some(again) = &mut again {
            again.step();
            assert_eq!(run.hash(), again.hash(), "a restored run goes on with the same bytes");
        }
    }
    println!("{entered} entered, {left} left, {last} kg of {before}, defect {:?} of {}", run.defect, run.gross);
    let each = 1000.0 * D.powi(3);
    assert!(entered == layer && left > 100, "{entered} {left}");
    assert!((last - before - each * (entered as f64 - left as f64)).abs() < 1e-11, "{last}");
    assert!(run.defect[0] < 1e-12 * run.gross && run.defect[1] < 1e-12 * run.gross, "{:?}", run.defect);
    let (x, _, rho) = columns(&run.bytes());
    let inside = |x: &[f64; 3]| (x[0] - 0.1).abs() < 0.05 && (x[1] - 0.1).abs() < 0.05 && x[2] < 0.02;
    assert!(x.iter().zip(&rho).all(|(x, rho)| *rho <= 0.0 || !inside(x)), "nobody is left in the drain");
}
