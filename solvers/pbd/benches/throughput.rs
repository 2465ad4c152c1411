//! Projections a second of a cloth without contact, on one and two threads, beside what memory and arithmetic allow.
//!
//! Roofline: a distance projection reads and writes two vertices of a cache line each and one edge of 32 bytes, about
//! 60 flops with one root and one division; a hinge four vertices and 40 bytes, about 350 flops.

use std::time::Instant;

use cosplat_conformance::parts;
use cosplat_core::plugin::{Inputs, Plugin, Steady};
use cosplat_core::scene::{Material, Source};
use cosplat_pbd::Pbd;

fn main() {
    for side in [100_u32, 300] {
        for threads in [1, 2] {
            for bends in [false, true] {
                measure(side, threads, bends);
            }
        }
    }
}

fn measure(side: u32, threads: usize, bends: bool) {
    let cloth = Material::Cloth {
        areal_density_kg_m2: 0.2,
        static_friction: 0.3,
        kinetic_friction: 0.3,
        stretch_compliance_m_n: 1e-6,
        bending_compliance_rad_n: 1e2,
        stretch_relaxation: 1.0,
        bending_relaxation: 1.0,
    };
    let source = Source::Plane { size_m: Some([f64::from(side) * 0.01; 2]) };
    let mut body = parts::body("sheet", cloth, source, [0.0; 3]);
    body.spacing_m = Some(0.01);
    body.velocity = parts::twist([0.0; 3], [0.5, 0.2, 0.0]);
    let mut scene = parts::solver_scene("pbd", vec![body], 100, 0.01);
    scene.threads = threads;
    let iterations = 11;
    scene.params.insert(if bends { "bending_iterations" } else { "iterations" }.into(), iterations.into());
    let mut plugin = Pbd::default();
    if plugin.setup(&scene).is_err() {
        return;
    }
    let mut best = f64::INFINITY;
    let (mut substeps, n) = (0, f64::from(side));
    for window in 0..3 {
        let start = Instant::now();
        let step = parts::step(&scene.clock, window);
        let Ok(out) = plugin.advance(&step, &Inputs::default(), &mut Steady) else { return };
        substeps = out.report.substeps;
        best = best.min(start.elapsed().as_secs_f64());
    }
    let [edges, hinges] = [2.0 * n * (n + 1.0) + n * n, 2.0 * n * (n - 1.0) + n * n];
    let per_substep = best / substeps as f64;
    println!(
        "{side} x {side}, {threads} threads, {iterations} iterations of {}: {:.3} ms a substep, {:.1} M projections/s in all",
        if bends { "bending" } else { "stretch" },
        per_substep * 1e3,
        if bends { edges + hinges * f64::from(iterations) } else { edges * f64::from(iterations) + hinges }
            / per_substep
            / 1e6
    );
}
