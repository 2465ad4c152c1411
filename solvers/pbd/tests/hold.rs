//! Cloth that is attached to partners, and pins that move.

mod common;

use common::{Run, cloth, pair, record};
use cosplat_conformance::parts;
use cosplat_core::boundary::{BoundaryState, Impulses, SampleStatics, Samples, add, norm, scale, sub};
use cosplat_core::plan::BoundaryForm;
use cosplat_core::plugin::{Inputs, PartnerInput, PartnerSetup, Plugin, SolverScene, ViewRole};
use cosplat_core::scene::{MotionRule, Source};

const WINDOW: f64 = 0.002;

/// A sheet of 0.2 kg/m², ten squares of 1 cm a side, in z = 0.
fn scene(windows: u64) -> SolverScene {
    let mut body = parts::body("sheet", cloth(1e-4, 1e3), Source::Plane { size_m: Some([0.1; 2]) }, [0.0; 3]);
    body.spacing_m = Some(0.01);
    let mut scene = parts::solver_scene("pbd", vec![body], windows, WINDOW);
    scene.actions = vec![parts::gravity()];
    scene
}

fn bound_to(partner: &str, form: BoundaryForm, source: Option<Source>, windows: u64) -> SolverScene {
    let mut scene = scene(windows);
    let corners = [[-0.05, -0.05, 0.0], [0.05, -0.05, 0.0]];
    scene.params.insert("bonds".into(), serde_json::json!({ "sheet": [{ "to": partner, "at": corners }] }));
    let mut view = parts::view(1, ViewRole::ContactResolver, "sheet", partner, Vec::new());
    (view.partner_form, view.partner_source, view.pair) = (form, source, Some(pair("sheet", partner, 0.3)));
    scene.interfaces = vec![view];
    scene
}

fn hears(now: BoundaryState) -> Inputs {
    let partner = PartnerInput { interface: 1, rule: MotionRule::Linear, now, next: None, length_s: WINDOW };
    Inputs { partners: vec![partner], impulses: Vec::new() }
}

#[test]
fn a_sheet_hangs_on_to_a_bar_that_is_thrown() {
    // The bar flies and spins freely, without weight of its own; the sheet has two corners in it.
    let (mass, inertia) = (0.02, 2e-5);
    let bar = Source::Box { size_m: [0.12, 0.01, 0.01] };
    let mut run = Run::new(bound_to("bar", BoundaryForm::Proxy, Some(bar), 100));
    run.plugin.connect(&[PartnerSetup { interface: 1, statics: SampleStatics::default() }]).expect("a partner");
    let mut bar = record([0.0, -0.055, 0.0], [0.5, -1.0, 2.0], mass, inertia);
    bar.angular_velocity = [0.0, 0.0, 3.0];
    let mut weight = 0.0;
    let mut widest: u64 = 0;
    for _ in 0..100 {
        let turn = nalgebra::UnitQuaternion::from_scaled_axis(nalgebra::Vector3::from(bar.angular_velocity) * WINDOW);
        let out = run.step_with(&hears(BoundaryState::Proxy(bar))).expect("a step");
        let Impulses::Rigid(wrench) = &out.impulses[0].1 else { panic!("a wrench") };
        let [x, y, z, w] = bar.orientation;
        let q = turn * nalgebra::UnitQuaternion::from_quaternion(nalgebra::Quaternion::new(w, x, y, z));
        bar.orientation = [q.i, q.j, q.k, q.w];
        bar.position = add(bar.position, scale(bar.linear_velocity, WINDOW));
        bar.linear_velocity = add(bar.linear_velocity, scale(wrench.linear, 1.0 / mass));
        bar.angular_velocity = add(bar.angular_velocity, scale(wrench.angular, 1.0 / inertia));
        let off = add(wrench.linear, out.report.interfaces[0].received.linear);
        assert!(norm(off) < 1e-15, "{off:?}");
        weight += out.report.external.linear[2];
        widest = widest.max(out.report.counters["largest-gap-of-a-bond-1e-6-m"]);
    }
    let all = add(run.momentum.linear, scale(bar.linear_velocity, mass));
    let expected = add(scale([0.5, -1.0, 2.0], mass), [0.0, 0.0, weight]);
    println!("widest gap {widest} µm");
    // Roundings of 0.05 N s summed over a hundred windows.
    assert!(norm(sub(all, expected)) < 1e-14, "{all:?} {expected:?}");
    // A substep closes the gap that it finds; what is left is the turn of the stand-in in it, (ω h)² of 5 cm.
    assert!(widest < 2, "{widest} µm");
    assert!(run.defect[0] < 1e-12 * run.gross && run.defect[1] < 1e-12 * run.gross, "{:?}", run.defect);
}

#[test]
fn a_sheet_hangs_on_to_samples_that_carry_it() {
    let mut scene = bound_to("branch", BoundaryForm::SamplesF64 { normals: true }, None, 150);
    scene.params.insert("damping_1_s".into(), 3.0.into());
    let mut run = Run::new(scene);
    // Two heavy samples behind the corners rise slowly; a third is farther away.
    let statics = SampleStatics { volume_m3: vec![1e-9; 3], ..SampleStatics::equal(3, 1.0) };
    run.plugin.connect(&[PartnerSetup { interface: 1, statics }]).expect("a partner");
    let (mut carried, mut widest) = (0.0, 0);
    for window in 0..150 {
        let t = WINDOW * f64::from(window);
        let position = [[-0.05, -0.053, 0.1 * t], [0.05, -0.053, 0.1 * t], [0.0, -0.1, 0.0]].to_vec();
        let velocity = vec![[0.0, 0.0, 0.1], [0.0, 0.0, 0.1], [0.0; 3]];
        let samples = Samples { position, velocity, normal: vec![[0.0, 1.0, 0.0]; 3] };
        let out = run.step_with(&hears(BoundaryState::Samples(samples))).expect("a step");
        let Impulses::Samples(each) = &out.impulses[0].1 else { panic!("impulses") };
        assert!(norm(each[2]) <= 0.0, "nothing hangs on the third");
        let off = add(out.impulses[0].1.total(), out.report.interfaces[0].received.linear);
        assert!(norm(off) < 1e-15, "{off:?}");
        widest = widest.max(out.report.counters["largest-gap-of-a-bond-1e-6-m"]);
        carried += if window >= 75 { -(each[0][2] + each[1][2]) } else { 0.0 };
    }
    // 2 g at rest; it swings like a door, and a swing from 90° ends at 3 mg.
    let weight = 0.002 * 9.81;
    let mean = -carried / (75.0 * WINDOW);
    println!("carried {:.2} of its weight, widest gap {widest} µm", mean.abs() / weight);
    assert!((0.3..3.0).contains(&(mean.abs() / weight)), "{mean}");
    // Samples of a kilogram give way by nothing.
    assert!(widest < 5, "{widest} µm");
    // Anchors are a part of the state.
    let bytes = run.bytes();
    run.plugin.restore(&bytes).expect("its own state");
    assert_eq!(run.bytes(), bytes);
}

#[test]
fn a_pin_that_is_pulled_at_a_hundred_metres_a_second_takes_the_cloth_along() {
    let mut scene = scene(10);
    let pull = serde_json::json!([{ "at": [-0.05, -0.05, 0.0], "velocity": [-100.0, 0.0, 0.0], "until": 0.011 }]);
    scene.params.insert("pulls".into(), serde_json::json!({ "sheet": pull }));
    let mut run = Run::new(scene);
    let (mut dissipated, mut stored) = (0.0, 0.0);
    for _ in 0..10 {
        let energy = run.step().report.energy;
        // What is stored is told as substeps of full length feel it, softer by 2h²/m than these far shorter ones:
        // by 1 + 2 (2.5e-4 s)² / (2e-5 kg · 1e-4 m/N).
        let off = 63.5 * f64::max(stored, energy.potential_j);
        assert!(energy.kinetic_j.is_finite() && energy.dissipated_j >= dissipated - off, "{energy:?}");
        (dissipated, stored) = (energy.dissipated_j, energy.potential_j);
    }
    let corner = run.vertices("sheet")[0];
    // 1.1 m in 11 ms, to the bit of a sum of some thousand substeps.
    assert!((corner[0] + 1.15).abs() < 1e-12, "{corner:?}");
    assert!(run.defect[0] < 1e-12 * run.gross && run.defect[1] < 1e-12 * run.gross, "{:?}", run.defect);
    // All of it has come along.
    let farthest = run.vertices("sheet").iter().map(|&x| norm(sub(x, corner))).fold(0.0, f64::max);
    println!("farthest vertex {farthest} m behind, {dissipated} J dissipated");
    assert!(farthest < 0.5, "{farthest}");
}

#[test]
fn what_cannot_be_held_is_refused_by_name() {
    let mut wrong = scene(1);
    let pull = |v: f64| serde_json::json!({ "at": [0.05, 0.05, 0.0], "velocity": [v, 0.0, 0.0] });
    wrong.params.insert("pulls".into(), serde_json::json!({ "sheet": [pull(1.0), pull(2.0)], "curtain": [] }));
    wrong.params.insert(
        "bonds".into(),
        serde_json::json!({ "sheet": [{ "to": "moon", "at": [[0.05, 0.05, 0.0], [1.0, 0.0, 0.0]] }] }),
    );
    let why = cosplat_pbd::Pbd::default().setup(&wrong).expect_err("a wrong scene").to_string();
    for name in ["pulled twice", "`curtain`", "pinned and attached to `moon`", "a bond of `sheet` at [1.0, 0.0, 0.0]"] {
        assert!(why.contains(name), "{name} is not in: {why}");
    }
    assert!(why.contains("bonds of `sheet` to `moon`"), "{why}");
}
