//! Substeps a second of a silk of 10 000 vertices that falls over the leaves of a plant, as in the scene
//! `cloth-over-plant`: samples one thick and a window for each substep, so that what is done once a window counts. In
//! mode `physical`, in which silk is as stiff as its material in a single iteration.

use std::time::Instant;

use cosplat_conformance::parts;
use cosplat_core::boundary::{BoundaryState, SampleStatics, Samples};
use cosplat_core::plan::BoundaryForm;
use cosplat_core::plugin::{Inputs, PartnerInput, PartnerSetup, Plugin, Steady, ViewRole};
use cosplat_core::scene::{ContactLaw, MotionRule, PairSpec, Source, presets};
use cosplat_pbd::Pbd;

/// Side and spacing of the silk, and its height above the topmost leaves \[m\].
const SIDE: f64 = 0.7;
const SPACING: f64 = 0.007;
const ABOVE: f64 = 0.03;
/// Tiers of leaves, leaves in one, samples along and across a leaf, and their distance \[m\].
const TIERS: usize = 5;
const LEAVES: usize = 9;
const ROW: [usize; 2] = [30, 9];
const WIDTH: f64 = 0.006;
const WINDOW: f64 = 4.5e-4;
/// Windows of a measurement, and how many there are.
const WINDOWS: [u64; 2] = [300, 6];

/// Leaves that bend down towards their tips, and do not touch each other.
fn leaves() -> Vec<[f64; 3]> {
    let place = |tier: usize, leaf: usize, k: usize| {
        let turn = std::f64::consts::TAU * (leaf as f64 + 0.5 * tier as f64) / LEAVES as f64;
        let (i, j) = ((k % ROW[0]) as f64, (k / ROW[0]) as f64);
        let (along, across) = (WIDTH * i, WIDTH * (j - 0.5 * (ROW[1] - 1) as f64));
        let (out, up) = (0.09 + along * 0.9, along * 0.6 - 3.5 * along * along - 0.05 * tier as f64);
        [out * turn.cos() - across * turn.sin(), out * turn.sin() + across * turn.cos(), up]
    };
    let all = (0..TIERS).flat_map(|tier| (0..LEAVES).map(move |leaf| (tier, leaf)));
    all.flat_map(|(tier, leaf)| (0..ROW[0] * ROW[1]).map(move |k| place(tier, leaf, k))).collect()
}

fn main() {
    let Some(silk) = presets::preset("silk").map(|p| p.material) else { return };
    let mut body = parts::body("silk", silk, Source::Plane { size_m: Some([SIDE; 2]) }, [0.02, 0.01, ABOVE]);
    body.spacing_m = Some(SPACING);
    let mut scene = parts::solver_scene("pbd", vec![body], WINDOWS[0] * WINDOWS[1], WINDOW);
    scene.threads = 2;
    scene.actions = vec![parts::gravity()];
    scene.params.insert("max_substep_s".into(), WINDOW.into());
    scene.params.insert("thickness_m".into(), 0.0037.into());
    let mut view = parts::view(1, ViewRole::ContactResolver, "silk", "plant", Vec::new());
    view.partner_form = BoundaryForm::SamplesF64 { normals: true };
    view.pair = Some(PairSpec {
        a: "silk".into(),
        b: "plant".into(),
        static_friction: 0.2,
        kinetic_friction: 0.2,
        restitution: 0.0,
        softness_m: 0.002,
        contact: ContactLaw::Physical,
        resolver: None,
        enabled: true,
    });
    scene.interfaces = vec![view];
    let mut plugin = Pbd::default();
    let position = leaves();
    let count = position.len();
    let statics = SampleStatics {
        area_m2: vec![WIDTH * WIDTH; count],
        volume_m3: vec![WIDTH.powi(3); count],
        // Too heavy to give way.
        ..SampleStatics::equal(count, 1e3)
    };
    let ready = plugin.setup(&scene).and_then(|_| plugin.connect(&[PartnerSetup { interface: 1, statics }]));
    if let Err(why) = ready {
        return println!("{why}");
    }
    let row = (SIDE / SPACING).round() as u32 + 1;
    println!("{} vertices, {count} samples, {} threads", row * row, scene.threads);
    let samples = Samples { position, velocity: vec![[0.0; 3]; count], normal: vec![[0.0, 0.0, 1.0]; count] };
    let now = BoundaryState::Samples(samples);
    let input = PartnerInput { interface: 1, rule: MotionRule::Linear, now, next: None, length_s: WINDOW };
    let inputs = Inputs { partners: vec![input], impulses: Vec::new() };
    for part in 0..WINDOWS[1] {
        let (begun, mut substeps, mut contacts, mut beyond) = (Instant::now(), 0, 0, 0);
        for window in part * WINDOWS[0]..(part + 1) * WINDOWS[0] {
            let out = match plugin.advance(&parts::step(&scene.clock, window), &inputs, &mut Steady) {
                Ok(out) => out.report,
                Err(why) => return println!("{why}"),
            };
            substeps += out.substeps;
            let count = |name: &str| out.counters.get(name).copied().unwrap_or(0);
            contacts += count("contacts");
            beyond = count("final-neighbours with cloth between");
        }
        println!(
            "from {:.3} s: {:.0} substeps/s, {} contacts in each, {beyond} neighbours with cloth between",
            WINDOW * (part * WINDOWS[0]) as f64,
            substeps as f64 / begun.elapsed().as_secs_f64(),
            contacts / substeps.max(1)
        );
    }
}
