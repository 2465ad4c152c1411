//! A thrown particle is put aside and counted; a body of which more than a hundredth is thrown ends the run.

#[cfg(test)]
mod common;

use common::{Run, columns, liquid, scene, tank, water};
use cosplat_core::boundary::{Vec3, norm};
use cosplat_core::plugin::{Inputs, Plugin, PluginError, Steady};
use cosplat_core::scene::Wall;

const SOUND: f64 = 20.0;

/// A tank of 1000 particles, at rest but for `count` of the upper layers, and its state with their velocity.
fn thrown(count: usize, velocity: Vec3) -> (Run, Vec<u8>) {
    let body = liquid(water(SOUND, 1.0), [0.2; 3], [0.1; 3], 0.02);
    let mut run = Run::new(scene(vec![body], tank(0.2, 0.2, Wall::Slip), 2e-3));
    run.step();
    let left = std::cell::Cell::new(count);
    let bytes = common::with_velocities(&run.bytes(), |x| {
        let chosen = left.get() > 0 && x[2] > 0.18;
        left.set(left.get() - usize::from(chosen));
        if chosen { velocity } else { [0.0; 3] }
    });
    (run, bytes)
}

#[test]
fn a_thrown_particle_is_put_aside_and_the_books_stay_closed() {
    let (mut run, bytes) = thrown(3, [2.0 * SOUND, 0.0, 10.0]);
    run.plugin.restore(&bytes).expect("its own state");
    let first = run.step();
    assert_eq!(first.report.counters["quarantined-particles"], 3);
    // The books begin here: what was thrown by hand is in none.
    run.defect = [0.0; 2];
    let mut again = Run::new(run.scene.clone());
    again.plugin.restore(&run.bytes()).expect("its own state");
    again.window = run.window;
    let mass = first.report.bodies[0].mass_kg;
    for _ in 0..40 {
        let report = run.step().report;
        assert_eq!(report.counters["quarantined-particles"], 0);
        // Sums in another order.
        assert!((report.bodies[0].mass_kg / mass - 1.0).abs() < 1e-13, "mass stays");
        again.step();
        assert_eq!(run.hash(), again.hash());
    }
    let (x, v, rho) = columns(&run.bytes());
    let aside: Vec<usize> = (0..x.len()).filter(|&i| rho[i] < 0.0).collect();
    println!("{:?}, defect {:?} of {}", aside.iter().map(|&i| (x[i], v[i])).collect::<Vec<_>>(), run.defect, run.gross);
    assert_eq!(aside.len(), 3);
    // They were stopped by the wall at 0.2 m.
    assert!(aside.iter().all(|&i| x[i][0] < 0.2 + 1e-9 && x[i][2] > -1e-9), "they stay in the tank");
    let rest = (0..x.len()).filter(|i| !aside.contains(i)).map(|i| norm(v[i])).fold(0.0, f64::max);
    // In the one substep before they were put aside they drew their neighbours along; all stay below a tenth of the speed
    // of sound, where the liquid counts as incompressible.
    assert!(rest < 0.1 * SOUND, "{rest}");
    assert!(run.defect[0] < 1e-12 * run.gross && run.defect[1] < 1e-12 * run.gross, "{:?}", run.defect);
}

#[test]
fn more_than_a_hundredth_thrown_ends_the_run_by_name() {
    let (mut run, bytes) = thrown(11, [2.0 * SOUND, 0.0, 10.0]);
    run.plugin.restore(&bytes).expect("its own state");
    let step = cosplat_conformance::parts::step(&run.scene.clock, run.window);
    let why = run.plugin.advance(&step, &Inputs::default(), &mut Steady).unwrap_err();
    let named = |w: &String| w.contains("11 of the 1000 particles of `water`") && w.contains("faster than sound");
    assert!(matches!(&why, PluginError::Physics(w) if named(w)), "{why}");
}
