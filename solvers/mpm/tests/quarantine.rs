//! Particles that run away: put aside one by one and counted, or the end of the run with a reason.

use crate::common::rock::view;
use crate::common::{Run, body, cuboid, elastic, gravity, plane, scene};
use cosplat_core::boundary::Impulses;
use cosplat_core::plugin::{ImpulseInput, Inputs, Plugin, PluginError, ViewRole};
use cosplat_core::scene::Wall;

const WINDOW: f64 = 5e-3;
/// Mass \[kg\] of a block of 8³ particles.
const MASS: f64 = 500.0 * 0.16 * 0.16 * 0.16;

/// A block of 512 particles that rests on a floor.
fn resting() -> Run<f64> {
    let block = body("block", elastic(500.0, 1e5, 0.3), cuboid([0.16; 3]), [0.0, 0.0, 0.08], 0.02);
    let mut start = scene(vec![block], WINDOW);
    start.statics = vec![plane("floor", [0.0; 3], crate::common::UPRIGHT, Wall::NoSlip)];
    start.actions.push(gravity(-9.81));
    let mut run = Run::new(start);
    for _ in 0..10 {
        run.step();
    }
    run
}

/// Gives every `each`-th of some particles that strain, in a saved state: blocks, identities and 27 numbers of four
/// particles at a time, the strain from the 18th on.
fn strain(bytes: &mut [u8], count: usize, value: f64) {
    let number = |at: usize| u32::from_le_bytes(bytes[at..at + 4].try_into().expect("four bytes")) as usize;
    let blocks = number(0);
    let quads: usize = (0..blocks).map(|b| number(8 + 20 * b + 16).div_ceil(4)).sum();
    let identities = 8 + 20 * blocks;
    let live: Vec<usize> = (0..4 * quads).filter(|s| number(identities + 4 * s) < 512).collect();
    for &slot in live.iter().skip(200).take(count) {
        for field in 18..21 {
            let at = identities + 16 * quads + 8 * (slot / 4 * 27 * 4 + field * 4 + slot % 4);
            bytes[at..at + 8].copy_from_slice(&value.to_le_bytes());
        }
    }
}

fn spoiled(count: usize, value: f64) -> Run<f64> {
    let mut run = resting();
    let mut bytes = run.bytes();
    strain(&mut bytes, count, value);
    run.plugin.restore(&bytes).expect("a state of this run");
    run
}

#[test]
fn one_particle_that_runs_away_is_put_aside() {
    let mut sane = resting();
    let substeps: Vec<u64> = (0..20).map(|_| sane.step().report.substeps).collect();
    // A volume of 1e9 times that at rest, one of 1e-6 times, and one that is no number.
    for value in [1e6, 1e-4 - 1.0, f64::NAN] {
        let mut run = spoiled(1, value);
        let mut counters = std::collections::BTreeMap::new();
        for &sane in &substeps {
            let report = run.step().report;
            // The rest of the block swings otherwise than before: one more where the window nearly held a whole number.
            assert!(report.substeps <= sane + 1, "{} substeps instead of {sane}", report.substeps);
            for (name, n) in &report.counters {
                cosplat_core::plugin::count(&mut counters, name, *n);
            }
        }
        println!("{value}: {counters:?}, defect {:?} of {}", run.defect, run.gross);
        assert_eq!([counters["quarantined-particles"], counters["rollbacks"], counters["stretch-clamps"]], [1, 0, 0]);
        // Rounding of f64 in sums of 512 particles over some five substeps; weight and floor give m g t each.
        let given = MASS * 9.81 * WINDOW;
        assert!(run.defect[0] < 1e-13 * given && run.defect[1] < 1e-13 * given, "{:?} of {given}", run.defect);
        let (body, sane) = (run.step().report.bodies[0], sane.setup.report.bodies[0]);
        // Mass stays in the books to the bit, and the block stands where it stood, to a tenth of a particle's edge.
        assert_eq!(body.mass_kg.to_bits(), sane.mass_kg.to_bits());
        assert!(crate::common::shifted(body.position_m, sane.position_m) < 0.1 * 0.02, "{:?}", body.position_m);
    }
}

#[test]
fn quarantine_is_saved_and_restored() {
    let mut run = spoiled(1, 1e6);
    run.step();
    let bytes = run.bytes();
    let mut again = resting();
    again.plugin.restore(&bytes).expect("a state of this run");
    (again.window, again.momentum) = (run.window, run.momentum);
    for _ in 0..3 {
        run.step();
        assert_eq!(again.step().report.counters["quarantined-particles"], 0, "it is in it already");
    }
    assert_eq!(run.hash(), again.hash());
}

fn reason(result: Result<cosplat_core::plugin::Outputs, PluginError>) -> String {
    match result {
        Err(PluginError::Physics(reason)) => reason,
        other => panic!("a physical error instead of {other:?}"),
    }
}

#[test]
fn more_than_one_particle_in_a_hundred_ends_the_run() {
    spoiled(5, 1e6).step();
    for count in [6, 26] {
        let reason = reason(spoiled(count, 1e6).try_step(&Inputs::default()));
        println!("{reason}");
        assert!(reason.starts_with(&format!("{count} of the 512 particles of `block`")), "{reason}");
        assert!(reason.contains("max_substep_s") && reason.contains("volume"), "{reason}");
    }
}

#[test]
fn an_impulse_that_no_substep_can_follow_is_named() {
    let mut start = resting().scene;
    start.interfaces = vec![view(ViewRole::ContactResponder, "block", 0.3)];
    let mut run = Run::<f64>::new(start);
    let mut each = vec![[0.0; 3]; run.setup.boundaries[0].statics.len()];
    // 10 000 km/s for one particle of 4 g.
    each[0] = [4e4, 0.0, 0.0];
    let impulses = vec![ImpulseInput { interface: 0, impulses: Impulses::Samples(each), spread: false }];
    let reason = reason(run.try_step(&Inputs { partners: Vec::new(), impulses }));
    println!("{reason}");
    assert!(reason.contains("`block`") && reason.contains("lost the motion"), "{reason}");
}
