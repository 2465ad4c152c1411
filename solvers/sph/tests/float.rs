//! A rigid box floats as Archimedes says.

#[cfg(test)]
mod common;

use common::{Float, Run, liquid, meets, scene, tank, water};
use cosplat_core::boundary::{Impulses, add, cross, norm};
use cosplat_core::plan::BoundaryForm;
use cosplat_core::scene::{Source, Wall};

/// Width of the tank and height of the water before the box is in it, and size of the box \[m\].
const SIDE: f64 = 0.4;
const HEIGHT: f64 = 0.2;
const SIZE: [f64; 3] = [0.2, 0.2, 0.1];

/// A box of that density, over the water's, laid on the water.
struct Bath {
    run: Run,
    float: Float,
    /// Mean height of its middle over the last third \[m\].
    height: f64,
    /// Largest speed \[m/s\].
    fastest: f64,
    /// Largest difference between what the water received and what the box was given.
    mismatch: f64,
}

fn bathe(share: f64, until: f64, pressure: &str) -> Bath {
    let (d, window) = (0.025, 4e-3);
    let mass = share * 1000.0 * SIZE[0] * SIZE[1] * SIZE[2];
    let body = liquid(water(20.0, 4.0), [SIDE, SIDE, HEIGHT], [0.5 * SIDE, 0.5 * SIDE, 0.5 * HEIGHT], d);
    let mut start = scene(vec![body], tank(SIDE, SIDE, Wall::Slip), window);
    start.interfaces.push(meets("box", BoundaryForm::Proxy, Some(Source::Box { size_m: SIZE }), 0.0));
    start.params.insert("pressure".into(), pressure.into());
    let mut run = Run::new(start);
    let mut float = Float::new(mass, SIZE, [0.5 * SIDE, 0.5 * SIDE, HEIGHT + 0.5 * SIZE[2]]);
    let (mut sum, mut of, mut fastest, mut mismatch) = (0.0, 0.0, 0.0_f64, 0.0_f64);
    while run.time() < until {
        let out = run.step_with(&float.inputs(window));
        let Impulses::Rigid(j) = &out.impulses[0].1 else { panic!("a rigid impulse") };
        let got = out.report.interfaces[0].received;
        let about = add(j.angular, cross(float.record.position, j.linear));
        mismatch = mismatch.max(norm(add(got.linear, j.linear))).max(norm(add(got.angular, about)));
        float.take(&out, window);
        fastest = fastest.max(norm(float.record.linear_velocity));
        if run.time() > until / 1.5 {
            (sum, of) = (sum + float.record.position[2], of + 1.0);
        }
    }
    println!(
        "{pressure}, {share}: {} substeps, mismatch {mismatch:e}, defect {:?} of {}",
        run.substeps, run.defect, run.gross
    );
    // Roundings of sums of some thousand impulses in double precision.
    assert!(mismatch < 1e-13, "{mismatch}");
    assert!(
        run.defect[0] < 1e-12 * run.gross && run.defect[1] < 1e-12 * run.gross,
        "{:?} of {}",
        run.defect,
        run.gross
    );
    Bath { run, float, height: sum / of, fastest, mismatch }
}

#[test]
fn a_box_floats_with_its_draft() {
    floats("wcsph", 0.5);
}

#[test]
fn a_box_floats_with_its_draft_in_an_incompressible_liquid() {
    for share in [0.3, 0.5, 0.7] {
        floats("dfsph", share);
    }
}

fn floats(pressure: &str, share: f64) {
    let bath = bathe(share, if pressure == "wcsph" { 1.5 } else { 1.2 }, pressure);
    // The water that the box displaces stands in the rest of the tank.
    let (area, own) = (SIDE * SIDE, SIZE[0] * SIZE[1]);
    let draft = (HEIGHT + 0.5 * SIZE[2] - bath.height) * area / (area - own);
    println!("draft {draft} of {}, mismatch {:e} after {} windows", share * SIZE[2], bath.mismatch, bath.run.window);
    // Archimedes. The published gate for floating boxes is 2 % of the edge, 4 mm, but not less than half a spacing, 12.5 mm:
    // the drafts are known to a spacing's sixth.
    let gate = 0.004;
    assert!((draft - share * SIZE[2]).abs() < gate, "{draft}");
    // In the middle of its tank it stays upright and in place, by symmetry up to roundings that grow.
    let record = bath.float.record;
    assert!((record.orientation[3] - 1.0).abs() < 1e-6 && (record.position[0] - 0.5 * SIDE).abs() < 1e-3);
}

#[test]
fn light_and_heavy_boxes_stay_bounded() {
    bounded("wcsph");
}

#[test]
fn light_and_heavy_boxes_stay_bounded_in_an_incompressible_liquid() {
    bounded("dfsph");
}

fn bounded(pressure: &str) {
    // The water that a box of 5 % of its density moves with it weighs several times as much: a coupling without a stand-in
    // would throw it away. One of twice the density sinks, here through the floor, which is for the rigid solver to know.
    let light = bathe(0.05, 0.5, pressure);
    println!("light: at {:?}, at most {} m/s", light.float.record.position, light.fastest);
    // A draft of 5 mm, a fifth of a spacing, is below what the particles can tell: it rests within a spacing.
    assert!(light.fastest < 0.5 && (light.height - HEIGHT - 0.5 * SIZE[2]).abs() < 0.02, "{}", light.height);
    let heavy = bathe(2.0, 0.3, pressure);
    println!("heavy: at {:?}, at most {} m/s", heavy.float.record.position, heavy.fastest);
    // Free fall through all of the water would end with 2 m/s; the water in its way takes a third of the acceleration and more.
    assert!(heavy.fastest < 2.0 && heavy.float.record.position[2] < HEIGHT, "{:?}", heavy.float.record);
}
