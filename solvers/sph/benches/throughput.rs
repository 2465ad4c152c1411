//! Particle-substeps a second of a collapsing cube of 64 000 particles on one thread and on two.
//!
//! What bounds it (two cores at about 3 GHz without AVX, so two lanes in double precision; 30 GB/s together):
//! - arithmetic: a list holds about 82 neighbours (58 in the kernel, the rest in the skin), gone through twice. A group of
//!   four costs 16 loads of two lanes a half, 8 square roots or divisions of two lanes at 4 to 8 cycles each, and about 60
//!   other operations of two lanes: 40 cycles for densities and 50 for forces, as measured. So 21 x 90 = 1900 cycles, 1.6 M/s
//!   a core at 3 GHz; with AVX, which halves the operations, about twice that.
//! - memory: each particle's line of 64 B is written once and read by neighbours that lie near in the cache, its list of
//!   330 B is read twice; positions, velocities, densities about 200 B: 1 kB, 30 M/s.
//! - boundary particles: 14 000 here, each with half a list in three of the passes: a fifth of the whole.
//! - lists: one making costs four fifths of a substep, nearly half of it to find runs of cells, and is needed every eighth.
//! - dfsph: an iteration reads 8 B of each of 58 pairs in each of two passes, 0.9 kB a particle, 60 ns a core. From the cache
//!   a group of four costs 17 and 22 cycles, 190 ns a particle, so that arithmetic bounds it, and 10 iterations of a
//!   substep 0.5 M/s a core. All else costs as much as nine iterations: one pass over the pairs that measures and rubs, one for
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
