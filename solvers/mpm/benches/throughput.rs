//! Particle-substeps a second of an elastic block of 100 000 particles, eight a cell, and of a plastic one.
//!
//! What bounds it (two cores of an AVX2 machine at about 3 GHz, 30 GB/s together):
//! - memory: a substep reads and writes 108 B of each particle twice, once to the tile (read) and once from it (read
//!   and write), about 300 B: 30 GB/s / 300 B = 100 M/s. The tiles (8 KiB) stay in the first-level cache.
//! - arithmetic: about 110 four-lane operations each way for the transfers, 150 for stress, strain and weights of four
//!   particles, which is 260 a particle; at two a cycle 130 cycles, so 23 M/s a core, 46 M/s on two.
//!
//! Run with `cargo bench -p cosplat-mpm`.

#![expect(clippy::unwrap_used, reason = "a benchmark may stop")]

use std::time::Instant;

use cosplat_core::plugin::{Inputs, Plugin, SolverScene, Steady, Step};
use cosplat_core::scene::{Action, ActionKind, Body, Material, Pose, Source, Space, VelocityField};
use cosplat_core::time::{Clock, Span};
use cosplat_mpm::{Mpm, Real};

/// A flying and turning cube of 46³ particles, or of 100³.
fn scene(material: Material, threads: usize, edge: f64) -> SolverScene {
    let spin = VelocityField::Twist { linear_m_s: [0.3, 0.1, 0.0], angular_rad_s: [0.0, 1.0, 2.0] };
    let body = Body {
        name: "block".into(),
        solver: "mpm".into(),
        material,
        source: Source::Box { size_m: [edge; 3] },
        pose: Pose { position_m: [0.1, 0.2, 0.3], orientation: [0.0, 0.0, 0.0, 1.0] },
        mass_kg: None,
        spacing_m: Some(1.0 / 128.0),
        velocity: spin,
        prescribed: None,
        color: None,
    };
    let kind = ActionKind::Gravity { acceleration_m_s2: [0.0, 0.0, -9.81] };
    SolverScene {
        participant: "mpm".into(),
        threads,
        clock: Clock { tick_s: 5e-4, windows: 1000 },
        space: Space::Full,
        bodies: vec![body],
        statics: Vec::new(),
        links: Vec::new(),
        joints: Vec::new(),
        actions: vec![Action { kind, bodies: Vec::new(), from_s: 0.0, until_s: None }],
        pairs: Vec::new(),
        probes: Vec::new(),
        interfaces: Vec::new(),
        params: serde_json::Map::new(),
        assets: std::collections::BTreeMap::new(),
    }
}

fn measure<R: Real>(name: &str, material: Material, threads: usize, edge: f64) {
    let scene = scene(material, threads, edge);
    let mut plugin = Mpm::<R>::default();
    let setup = plugin.setup(&scene).unwrap();
    let particles = setup.particles[0];
    let mut rates = Vec::new();
    for window in 0..8 {
        let span = Span { from: scene.clock.start_of(window), to: scene.clock.start_of(window + 1) };
        let start = Instant::now();
        let out = plugin.advance(&Step::new(&scene.clock, window, span), &Inputs::default(), &mut Steady).unwrap();
        let seconds = start.elapsed().as_secs_f64();
        rates.push((particles * out.report.substeps) as f64 / seconds * 1e-6);
    }
    rates.sort_by(f64::total_cmp);
    let mut bytes = Vec::new();
    plugin.save(&mut bytes);
    println!(
        "{name:24} {threads} threads {particles:7} particles {:3} B each: {:6.2} M/s ({:.2} to {:.2})",
        bytes.len() as u64 / particles,
        rates[rates.len() / 2],
        rates[0],
        rates[rates.len() - 1],
    );
}

fn main() {
    let elastic = Material::Elastic { density_kg_m3: 30.0, youngs_modulus_pa: 2e6, poissons_ratio: 0.22 };
    let plastic = |yield_stress_pa| Material::Elastoplastic {
        density_kg_m3: 30.0,
        youngs_modulus_pa: 2e6,
        poissons_ratio: 0.22,
        yield_stress_pa,
    };
    let edge = 46.0 / 128.0;
    for threads in [1, 2] {
        measure::<f32>("elastic f32", elastic, threads, edge);
        measure::<f32>("elastoplastic f32", plastic(3e4), threads, edge);
        measure::<f32>("elastoplastic, flows", plastic(1.0), threads, edge);
        measure::<f64>("elastic f64", elastic, threads, edge);
    }
    measure::<f32>("elastic f32", elastic, 2, 100.0 / 128.0);
}
