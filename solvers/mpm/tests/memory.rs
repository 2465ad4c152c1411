//! Memory by particle and by node, against the sum of what is kept of each. A program of its own: other tests take memory
//! as well.

#[cfg(test)]
mod common;

use common::{Run, body, cuboid, elastic, scene};
use cosplat_core::scene::Material;
use cosplat_mpm::Real;

/// Particles a side, two a cell.
const SIDE: u32 = 64;

/// Says to a program of this test which of the [`CASES`] it is to measure.
const CASE: &str = "COSPLAT_MPM_MEMORY_CASE";

/// Resident memory of this process \[B\]; `None` where the system does not say.
fn resident() -> Option<f64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|l| l.strip_prefix("VmRSS:"))?;
    Some(1024.0 * line.trim().strip_suffix("kB")?.trim().parse::<f64>().ok()?)
}

/// A cube of particles after a step, and what it took of memory \[B\].
fn held<R: Real>(side: u32, material: Material) -> Option<(Run<R>, f64)> {
    let before = resident()?;
    let edge = f64::from(side) * 0.01;
    let cube = body("cube", material, cuboid([edge; 3]), [0.5 * edge; 3], 0.01);
    let mut run = Run::new(scene(vec![cube], 1e-3));
    run.step();
    let took = resident()? - before;
    Some((run, took))
}

/// What is kept of a cube of `side` particles an edge, of numbers of so many bytes \[B\]: by particles, by the blocks that
/// hold them and by the blocks of nodes. What flows has its nodes and tiles twice.
fn layout(side: u32, number: u32, flows: bool) -> [f64; 3] {
    // 27 numbers, identity and lane, and all of it again to go back to; where it was at the start.
    let particle = 2 * (27 * number + 4 + 4) + 24;
    let times = 1 + u32::from(flows);
    // 8³ nodes of four numbers; which of them are in use, and what a substep says; which nodes it reaches, its walls and its
    // end; itself, twice, and the next of its body.
    let block = 512 * 4 * number * times + 6 + 40 + 108 + 24 + 8 + 2 * 32 + 4;
    // 4³ nodes of four numbers; where they are, which blocks reach them, what happened there and its end.
    let nodes = 64 * 4 * number * times + 16 + 108 + 80 + 8 + 4;
    // Blocks of four cells begin half a cell before a multiple of four, and the nodes of all around them exist.
    let blocks = (side - 1).div_ceil(8) + 1;
    [(particle, side), (block, blocks), (nodes, blocks + 2)].map(|(each, n)| f64::from(each) * f64::from(n.pow(3)))
}

/// Fails where a cube takes a fifth more or less memory than its layout; skips where the system does not tell.
fn compare<R: Real>(name: &str, material: Material) {
    let Some((_run, took)) = held::<R>(SIDE, material) else {
        eprintln!("skipped: this system does not say how much memory a process has");
        return;
    };
    let parts = layout(SIDE, size_of::<R>() as u32, matches!(material, Material::MpmLiquid { .. }));
    let (kept, each) = (parts.iter().sum::<f64>(), f64::from(SIDE.pow(3)));
    println!("{name}: {:.0} B a particle, {:.0} by layout: {:.0?}", took / each, kept / each, parts.map(|p| p / each));
    // A fifth: vectors that grew, what the heap keeps of the setup, and 3 MB of the program itself; found are 2 to 4 %.
    assert!((took / kept - 1.0).abs() < 0.2, "{name}: {took} B of {kept}");
}

const CASES: [&str; 3] = ["rubber, single", "rubber, double", "liquid, single"];

#[test]
fn a_block_takes_what_is_kept_of_it() {
    let rubber = elastic(1000.0, 1e6, 0.3);
    let liquid = Material::MpmLiquid { density_kg_m3: 1000.0, bulk_modulus_pa: 1e5, viscosity_pa_s: 0.0 };
    match std::env::var(CASE).as_deref() {
        Ok("rubber, single") => compare::<f32>(CASES[0], rubber),
        Ok("rubber, double") => compare::<f64>(CASES[1], rubber),
        Ok("liquid, single") => compare::<f32>(CASES[2], liquid),
        _ => {
            // One program each: a run that ends leaves memory in the heap, which the next would take.
            let program = std::env::current_exe().expect("the path of this program");
            for case in CASES {
                let run = std::process::Command::new(&program).arg("--nocapture").env(CASE, case).output();
                let run = run.expect("this program starts");
                println!("{}", String::from_utf8_lossy(&run.stdout));
                assert!(run.status.success(), "{case}: {}", String::from_utf8_lossy(&run.stderr));
            }
        }
    }
}
