//! Particle-substeps a second of a collapsing cube of 64 000 particles on one thread and on two.
//!
//! What bounds it (two cores at 3.5 GHz with AVX, so eight lanes in single and four in double precision; 30 GB/s together):
//! - densities, single precision: a list holds about 82 neighbours (58 in the kernel, the rest in the skin), 11 groups of
//!   eight. A group costs 16 loads, 40 shuffles that turn them into columns on two ports, a root of 8 cycles, about 60 other
//!   operations on three ports: 45 cycles; 50 as measured, 160 ns a particle.
//! - forces, double precision: the 58 in the kernel, 15 groups of four, each 16 loads, 24 shuffles, a division of 8 cycles
//!   and about 50 other operations: 35 cycles; 42 as measured, 180 ns. Distances come with the list, which saves the roots.
//! - lists: one making costs four fifths of a substep, half of it to find runs of cells, and is needed every eighth: 50 ns.
//! - boundary particles: 14 000 here, each with half a list in three of the passes: 60 ns.
//! - so 2.2 M/s a core, and 4.4 M/s of two; what is not shared out, a twentieth, leaves 4.1. Registers of two doubles (SSE2)
//!   make two thirds of it.
//! - memory: each particle's 64 and 32 B are written once and read by neighbours that lie near in the cache, its list of
//!   330 B is read, pairs of 460 B written and read; positions, velocities, densities about 200 B: 1.6 kB, 20 M/s.
//! - dfsph: an iteration reads 8 B of each of 58 pairs in each of two passes, 0.9 kB a particle, 60 ns a core. From the cache
//!   a group of four costs 17 and 22 cycles, 160 ns a particle, so that arithmetic bounds it, and 10 iterations of a
//!   substep 0.6 M/s a core. All else costs as much as nine iterations: one pass over the pairs that measures and rubs, one for
//!   the impulses, and lists.
//!
//! Run with `cargo bench -p cosplat-sph`.
#![expect(clippy::unwrap_used, reason = "a benchmark may stop")]

#[path = "../tests/common/mod.rs"]
mod common;

use std::time::Instant;

use common::{Run, liquid, scene, tank, water};
use cosplat_core::scene::Wall;

fn main() {
    for (pressure, threads) in [("wcsph", 1), ("wcsph", 2), ("dfsph", 2)] {
        let (n, d) = (40.0, 0.01);
        let side = n * d;
        let body = liquid(water(30.0, 1.0), [side; 3], [0.5 * side; 3], d);
        let mut start = scene(vec![body], tank(2.0 * side, side, Wall::Slip), 4e-3);
        start.threads = threads;
        start.params.insert("pressure".into(), pressure.into());
        let mut run = Run::new(start);
        let particles: u64 = run.setup.particles.iter().sum();
        let mut best = 0.0_f64;
        let mut last = None;
        for _ in 0..6 {
            let (clock, before) = (Instant::now(), run.substeps);
            last = Some(run.step());
            let rate = particles as f64 * (run.substeps - before) as f64 / clock.elapsed().as_secs_f64();
            best = best.max(rate);
        }
        println!("{pressure}, {threads} threads: {particles} particles, {:.2} M particle-substeps/s", best / 1e6);
        println!("{:?}", last.unwrap().report.counters);
    }
}
