//! Cell-substeps and particle-substeps a second of a cloud in a wind that meets a sheet, on one thread and on two.
//!
//! What bounds it (two cores at about 2.6 GHz, 7 to 8 GB/s each under load, two lanes of double precision):
//! - memory, one sweep of the cycle over a cell, in single precision: the unknown read and the next one written, three
//!   weights, the right side and the inverse: 28 B. An iteration of conjugate gradients has four sweeps and a residual
//!   on the finest level, a seventh of that on the others, and 60 B for restriction, correction and what goes in and
//!   out: 210 B; in double precision, a product (40 B) and four vectors twice: 110 B. 6.5 iterations in two solutions:
//!   2.1 kB.
//! - memory, the rest of a substep: six entries of the stress twice with three components each, three components and a
//!   concentration read and written about four times: about 1.2 kB.
//! - arithmetic: about 400 operations of two lanes for the stress and the concentration, 6.5 x 110 of four lanes and
//!   6.5 x 30 of two for the solutions: 480 cycles, 180 ns.
//!
//! So 3.3 kB, 0.45 μs a cell and core where memory binds: 2 M cell-substeps a second on one core, 4 M on two.
//! Particles: 48 loads of faces that lie near, 150 operations: 10 M/s a core.
//!
//! Run with `cargo bench -p cosplat-smoke`.

#[path = "../tests/common/mod.rs"]
mod common;

use std::time::Instant;

use common::{Run, ball, gravity, meets, scene, sheet, shown, wind};
use cosplat_core::boundary::{BoundaryState, SampleStatics};
use cosplat_core::plan::BoundaryForm;
use cosplat_core::plugin::{Inputs, PartnerSetup};
use cosplat_core::scene::Source;
use serde_json::json;

/// Particle-iterations a second of density constraints, in a box filled with a heavy gas.
///
/// Arithmetic: 26 pairs, a root, a division and 30 operations each, twice: 26 x 2 x 15 ns = 0.8 μs at one lane of
/// double precision. Beside the 8 iterations a substep makes its lists and two densities: 1 M/s on one core.
fn constraints(threads: usize) {
    let params = json!({
        "method": "positions", "low": [0, 0, 0], "high": [0.5, 0.5, 1], "open": ["+z"], "air_density": 1e-9
    });
    let mut body = ball(1.0, 0.1, [0.25, 0.25, 0.15], 0.0125);
    body.source = Source::Box { size_m: [0.5, 0.5, 0.3] };
    let mut start = scene(body, vec![gravity([0.0, 0.0, -9.81])], 0.005, &params);
    start.threads = threads;
    let mut run = Run::new(start);
    let particles: u64 = run.setup.particles.iter().sum();
    let mut best = 0.0_f64;
    for _ in 0..4 {
        let (clock, before) = (Instant::now(), run.substeps);
        run.step();
        best = best.max((run.substeps - before) as f64 / clock.elapsed().as_secs_f64());
    }
    let rate = best * particles as f64 * 8.0 / 1e6;
    println!("{threads} threads: {particles} particles by density constraints, {rate:.2} M particle-iterations/s");
}

fn main() {
    for threads in [1, 2] {
        constraints(threads);
    }
    for threads in [1, 2] {
        let params = json!({ "low": [-0.8, -0.4, -0.4], "high": [0.8, 0.4, 0.4], "cell": 0.0125 });
        let actions = vec![wind([1.0, 0.0, 0.0]), gravity([0.0, 0.0, -9.81])];
        let mut start = scene(ball(1.0, 0.2, [-0.4, 0.0, 0.0], 0.01), actions, 0.005, &params);
        start.threads = threads;
        start.interfaces.push(meets(0, "sheet", BoundaryForm::SamplesF64 { normals: false }, None));
        let points = sheet(40, 0.0075, 0.1);
        let statics = SampleStatics { area_m2: vec![5.6e-5; 1600], ..SampleStatics::equal(1600, 1e-5) };
        let mut run = Run::with(start, &[PartnerSetup { interface: 0, statics }]);
        let particles: u64 = run.setup.particles.iter().sum();
        let now = BoundaryState::points(&points, &vec![[0.0; 3]; points.len()]);
        let inputs = Inputs { partners: vec![shown(0, now, 0.005)], impulses: Vec::new() };
        let cells = 128 * 64 * 64;
        let mut best = 0.0_f64;
        for _ in 0..8 {
            let (clock, before) = (Instant::now(), run.substeps);
            run.step_with(&inputs);
            best = best.max((run.substeps - before) as f64 / clock.elapsed().as_secs_f64());
        }
        println!(
            "{threads} threads: {cells} cells, {particles} particles, {:.2} M cell-substeps/s, {:.3} M particle-\
             substeps/s beside them, {:.1} iterations a substep",
            best * f64::from(cells) / 1e6,
            best * particles as f64 / 1e6,
            run.iterations as f64 / run.substeps as f64
        );
    }
}
