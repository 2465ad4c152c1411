//! Cloth alone, against closed solutions.

mod common;

use std::f64::consts::FRAC_1_SQRT_2;
use std::sync::Arc;

use common::{Run, cloth};
use cosplat_conformance::parts;
use cosplat_core::asset::{Asset, TriangleMesh};
use cosplat_core::plugin::SolverScene;
use cosplat_core::scene::{Body, Probe, ProbeQuantity, Source};

/// No resistance to speak of.
const LIMP: f64 = 1e9;
const G: f64 = 9.81;

fn set(scene: &mut SolverScene, key: &str, value: impl Into<serde_json::Value>) {
    scene.params.insert(key.into(), value.into());
}

fn sheet(name: &str, material: cosplat_core::scene::Material, size: [f64; 2], spacing: f64) -> Body {
    let mut body = parts::body(name, material, Source::Plane { size_m: Some(size) }, [0.0; 3]);
    body.spacing_m = Some(spacing);
    body
}

/// A strip of 20 squares that hangs by its upper row from rest.
fn strip(substep: f64, iterations: u32) -> SolverScene {
    let mut strip = sheet("strip", cloth(0.5, LIMP), [0.01, 0.2], 0.01);
    // The sheet's y becomes the world's z.
    strip.pose.orientation = [FRAC_1_SQRT_2, 0.0, 0.0, FRAC_1_SQRT_2];
    let mut scene = parts::solver_scene("pbd", vec![strip], 100, 0.01);
    scene.actions = vec![parts::gravity()];
    set(&mut scene, "max_substep_s", substep);
    set(&mut scene, "iterations", iterations);
    set(&mut scene, "shear_compliance_m_n", LIMP);
    set(&mut scene, "damping_1_s", 20.0);
    set(&mut scene, "pins", serde_json::json!({ "strip": [[-0.005, 0.0, 0.1], [0.005, 0.0, 0.1]] }));
    scene
}

/// Its elongation \[m\].
fn hanging(substep: f64, iterations: u32) -> f64 {
    let mut run = Run::new(strip(substep, iterations));
    (0..100).for_each(|_| drop(run.step()));
    let v = run.vertices("strip");
    // The lower row comes first.
    -0.1 - 0.5 * (v[0][2] + v[1][2])
}

#[test]
fn a_hanging_strip_is_as_long_as_its_compliance_says() {
    // Two threads of compliance α, 20 links; below link k hang k + ½ squares of 0.2 kg/m² · 1 cm²: Σ = α g m 20²/4.
    let exact = 0.5 * G * 0.2e-4 * 100.0;
    for (substep, iterations) in [(1.5e-4, 1), (5e-5, 1), (2.5e-4, 4), (5e-4, 8), (1e-3, 30)] {
        let found = hanging(substep, iterations);
        println!("{substep} s, {iterations} iterations: {:+.2e}", found / exact - 1.0);
        // One sweep is softer by h²/(α m) = 1.5e-4² / (0.5 · 1e-5) = 0.5 %, more sweeps by less.
        assert!((found / exact - 1.0).abs() < 0.01, "{substep} {iterations}: {found} {exact}");
    }
}

#[test]
fn probes_tell_how_far_cloth_is_stretched_and_how_far_it_reaches() {
    let mut scene = strip(1.5e-4, 1);
    let asked = |name: &str, quantity, along| Probe {
        name: name.into(),
        quantity,
        body: Some("strip".into()),
        at_m: None,
        along,
    };
    scene.probes = vec![
        asked("stretch", ProbeQuantity::Strain, None),
        asked("down", ProbeQuantity::Reach, Some([0.0, 0.0, -1.0])),
    ];
    let mut run = Run::new(scene);
    let start = &run.setup.report.probes;
    assert!(start["stretch"] < 1e-12 && (start["down"] - 0.1).abs() < 1e-12, "{start:?}");
    let last = (0..100).map(|_| run.step()).last().expect("a window").report.probes;
    // As above; what hangs from the first link is 19 squares and a half, shared by two threads.
    let (longer, first) = (0.5 * G * 0.2e-4 * 100.0, 0.5 * G * 0.1e-4 * 19.5 / 0.01);
    assert!((last["down"] / (0.1 + longer) - 1.0).abs() < 0.01, "{last:?}");
    assert!((last["stretch"] / first - 1.0).abs() < 0.01, "{last:?}");
}

#[test]
fn a_pendulum_keeps_its_period_and_its_energy() {
    // One square, two corners fixed: the other two swing about them at 0.1 m.
    let plate = sheet("plate", cloth(0.0, LIMP), [0.1, 0.1], 0.1);
    let mut scene = parts::solver_scene("pbd", vec![plate], 10_000, 0.001);
    scene.actions = vec![parts::gravity()];
    set(&mut scene, "pins", serde_json::json!({ "plate": [[-0.05, 0.05, 0.0], [0.05, 0.05, 0.0]] }));
    let mut run = Run::new(scene);
    let (mut crossings, mut before) = (Vec::new(), -0.1);
    let mut highest = f64::NEG_INFINITY;
    for i in 1..=10_000 {
        run.step();
        let y = run.vertices("plate")[0][1] - 0.05;
        if before < 0.0 && y >= 0.0 {
            crossings.push((f64::from(i) - y / (y - before)) * 1e-3);
        }
        before = y;
        if i > 9000 {
            highest = highest.max(run.vertices("plate")[0][2]);
        }
    }
    let period = (crossings[crossings.len() - 1] - crossings[0]) / (crossings.len() - 1) as f64;
    // Released at 90°: T = 1.18034 T0.
    let exact = 1.180_34 * std::f64::consts::TAU * (0.1 / G).sqrt();
    println!("period {:+.1e}, height lost in 10 s {:.1e} of the amplitude", period / exact - 1.0, -highest / 0.1);
    // The printed 1.18034 has six digits; second order in ωh = 2.5e-3 adds less.
    assert!((period / exact - 1.0).abs() < 1e-5);
    // Seen once a millisecond near a turning point: 9.81/2 · 0.5e-3² = 1.2e-6 m.
    assert!(highest.abs() < 2e-6, "{highest}");
    assert!(run.defect[0] < 1e-12 * run.gross && run.defect[1] < 1e-12 * run.gross);
}

/// A strip one square wide over points of the x-z plane.
fn ribbon(points: &[[f64; 2]], width: f64) -> TriangleMesh {
    let row = |&[x, z]: &[f64; 2]| [[x, -0.5 * width, z], [x, 0.5 * width, z]];
    let square = |i: u32| [[2 * i, 2 * i + 2, 2 * i + 1], [2 * i + 1, 2 * i + 2, 2 * i + 3]];
    TriangleMesh {
        vertices_m: points.iter().flat_map(row).collect(),
        triangles: (0..points.len() as u32 - 1).flat_map(square).collect(),
    }
}

#[test]
fn a_chain_hangs_as_a_catenary() {
    // Fifty links of 24 mm on an arc over 1 m: 2R sin(δ/2) = 0.024, 2R sin(25 δ) = 1.
    let (mut low, mut high) = (1e-3, 0.1_f64);
    for _ in 0..100 {
        let d = 0.5 * (low + high);
        if 0.024 * (25.0 * d).sin() / (0.5 * d).sin() > 1.0 { low = d } else { high = d }
    }
    let radius = 0.012 / (0.5 * low).sin();
    let points: Vec<[f64; 2]> = (0..=50)
        .map(|i| (f64::from(i) - 25.0) * low)
        .map(|a| [radius * a.sin(), -radius * (a.cos() - (25.0 * low).cos())])
        .collect();
    let mesh = ribbon(&points, 0.024);
    let ends: Vec<[f64; 3]> = [0, 1, 100, 101].iter().map(|&i: &usize| mesh.vertices_m[i]).collect();
    let source = Source::Mesh { file: "ribbon.obj".into(), metres_per_unit: 1.0, up: "+z".into() };
    let body = parts::body("chain", cloth(0.0, LIMP), source, [0.0; 3]);
    let mut scene = parts::solver_scene("pbd", vec![body], 150, 0.01);
    scene.assets.insert("chain".into(), Arc::new(Asset::Mesh(mesh)));
    scene.actions = vec![parts::gravity()];
    set(&mut scene, "damping_1_s", 5.0);
    set(&mut scene, "max_substep_s", 1e-4);
    set(&mut scene, "pins", serde_json::json!({ "chain": ends }));
    let mut run = Run::new(scene);
    (0..150).for_each(|_| drop(run.step()));
    let v = run.vertices("chain");
    let sag = -0.5 * (v[50][2] + v[51][2]);
    println!("sag {:+.1e}", sag / 0.29234 - 1.0);
    // Fifty straight links: 1/50² of the curvature's share.
    assert!((sag / 0.29234 - 1.0).abs() < 1e-3);
}

#[test]
fn a_cantilever_bends_as_the_heavy_elastica() {
    // Peirce: where q L³ = 8.004 B, the chord to the tip lies 41.5° below the clamp.
    for spacing in [0.04_f64, 0.025, 0.02] {
        let rows = (0.2 / spacing).round();
        // The hinge of the last fixed row bends half a square before it and half a square behind.
        let length = (rows + 0.5) * spacing;
        let stiffness = 0.2 * G * length.powi(3) / 8.004;
        let size = [(rows + 1.0) * spacing, 4.0 * spacing];
        let strip = sheet("strip", cloth(1e-6, 1.0 / stiffness), size, spacing);
        let left = -0.5 * size[0];
        let pins: Vec<[f64; 3]> =
            (0..10).map(|i| [left + spacing * f64::from(i / 5), spacing * (f64::from(i % 5) - 2.0), 0.0]).collect();
        let mut scene = parts::solver_scene("pbd", vec![strip], 150, 0.01);
        scene.actions = vec![parts::gravity()];
        set(&mut scene, "damping_1_s", 10.0);
        // One sweep is softer by h²/(α m l²) times the square of the rows: 2 % at 2 cm.
        set(&mut scene, "max_substep_s", 4e-5);
        set(&mut scene, "pins", serde_json::json!({ "strip": pins }));
        let mut run = Run::new(scene);
        (0..150).for_each(|_| drop(run.step()));
        let v = run.vertices("strip");
        let tip = v[v.len() - 1];
        // The clamp lies half a square before the hinge.
        let angle = (-tip[2]).atan2(tip[0] - left - 0.5 * spacing).to_degrees();
        println!("squares of {spacing} m: {angle:.2}°");
        // Squares of a fifth to a tenth of the length, and the softness above.
        assert!((angle / 41.5 - 1.0).abs() < 0.05, "{spacing}: {angle}");
    }
}
