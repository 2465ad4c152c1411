//! Water strikes a box: pressures on its front face against those measured (Kleefsman, Fekken, Veldman, Iwanowski and
//! Buchner, "A volume-of-fluid based simulation method for wave impact problems", 2005; test 2 of SPHERIC).
//!
//! Run with `cargo bench -p cosplat-sph --bench obstacle [SPACING]`, by default 0.04 m: a minute or two on two cores. The
//! catalogue asks for 0.02 m, a quarter of an hour. Without friction and gate the toe arrives after 0.411 s
//! (`tests/reference/dam_break.py 150 0.4479`), later than the clock of the experiment says.
#[path = "../tests/common/mod.rs"]
mod common;

use std::time::Instant;

use common::{Run, liquid, scene, tank, water};
use cosplat_core::scene::{Pose, Probe, ProbeQuantity, Source, StaticCollider, Wall};

/// Heights of the gauges in the middle of the face at x = 2.42 m \[m\]; measured: when pressure passes 1 kPa, when it is largest
/// \[s\] and how large \[Pa\], and its integral from 0.4 s to 1.4 s \[Pa s\].
const MEASURED: [(f64, [f64; 4]); 2] =
    [(0.021, [0.381, 0.405, 10_910.0, 3_986.0]), (0.101, [0.386, 0.458, 6_566.0, 3_511.0])];

/// Time between samples of pressure \[s\].
const WINDOW: f64 = 2e-3;

fn gauge(height: f64) -> Probe {
    Probe {
        name: format!("{height}"),
        quantity: ProbeQuantity::Pressure,
        body: None,
        at_m: Some([2.42, 0.5, height]),
        along: None,
    }
}

fn main() {
    let d: f64 = std::env::args().find_map(|a| a.parse().ok()).unwrap_or(0.04);
    for pressure in ["wcsph", "dfsph"] {
        let clock = Instant::now();
        let column = liquid(water(33.0, 1e-3), [1.228, 1.0, 0.55], [0.614, 0.5, 0.275], d);
        let mut walls = tank(3.22, 1.0, Wall::Slip);
        walls.push(StaticCollider {
            name: "box".into(),
            source: Source::Box { size_m: [0.16, 0.4, 0.161] },
            pose: Pose { position_m: [2.5, 0.5, 0.0805], orientation: common::UPRIGHT },
            ..walls[0].clone()
        });
        let mut start = scene(vec![column], walls, WINDOW);
        start.params.insert("pressure".into(), pressure.into());
        start.probes = MEASURED.iter().map(|m| gauge(m.0)).collect();
        let mut run = Run::new(start);
        let particles: u64 = run.setup.particles.iter().sum();
        let mut found = [[f64::NAN, 0.0, 0.0, 0.0]; 2];
        while run.time() < 1.4 {
            let probes = run.step().report.probes;
            for ([there, when, most, impulse], (height, _)) in found.iter_mut().zip(MEASURED) {
                let p = probes.get(&format!("{height}")).copied().unwrap_or(0.0);
                if there.is_nan() && p > 1000.0 {
                    *there = run.time();
                }
                if p > *most {
                    (*when, *most) = (run.time(), p);
                }
                if run.time() > 0.4 {
                    *impulse += p * WINDOW;
                }
            }
        }
        let took = clock.elapsed().as_secs_f64();
        println!("{pressure}: {particles} particles {d} m apart, {} substeps in {took:.0} s", run.substeps);
        for (found, (height, measured)) in found.iter().zip(MEASURED) {
            for (who, [there, when, most, impulse]) in [("found", *found), ("measured", measured)] {
                println!(
                    "  {height} m, {who}: there at {there:.3} s, most {:.1} kPa at {when:.3} s, {impulse:.0} Pa s",
                    most / 1e3
                );
            }
        }
    }
}
