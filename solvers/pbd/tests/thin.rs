//! Cloth against samples of thin things, whose normals are those of neither side.

mod common;

use common::{Run, cloth, pair, pierced, squares};
use cosplat_conformance::parts;
use cosplat_core::boundary::{BoundaryState, SampleStatics, Samples, add, scale};
use cosplat_core::plan::BoundaryForm;
use cosplat_core::plugin::{Inputs, PartnerInput, PartnerSetup, Plugin, ViewRole};
use cosplat_core::scene::{MotionRule, Source};

/// Squares of the cloth along a side, and its spacing \[m\].
const SQUARES: usize = 20;
const SPACING: f64 = 0.015;
/// Samples of the leaf along a side, and their distance \[m\].
const ROW: usize = 13;
const WIDTH: f64 = 0.01;
const WINDOW: f64 = 0.002;

/// A leaf that is one sample thick.
struct Leaf {
    /// Its two axes.
    axes: [[f64; 3]; 2],
    centre: [f64; 3],
    velocity: [f64; 3],
}

impl Leaf {
    fn positions(&self, t: f64) -> Vec<[f64; 3]> {
        let at = |k: usize| WIDTH * (k as f64 - 0.5 * (ROW - 1) as f64);
        let centre = add(self.centre, scale(self.velocity, t));
        let place = |i: usize| add(centre, add(scale(self.axes[0], at(i % ROW)), scale(self.axes[1], at(i / ROW))));
        (0..ROW * ROW).map(place).collect()
    }

    /// Neighbouring samples.
    fn edges() -> Vec<[usize; 2]> {
        let right = (0..ROW * ROW).filter(|i| i % ROW + 1 < ROW).map(|i| [i, i + 1]);
        let up = (0..ROW * (ROW - 1)).map(|i| [i, i + ROW]);
        right.chain(up).collect()
    }
}

/// Pushes a leaf into a cloth that is held at its corners, 5 cm from where it meets it, and looks every window.
fn push(axes: [[f64; 3]; 2], from: f64, speed: f64) -> Run {
    let source = Source::Plane { size_m: Some([SPACING * SQUARES as f64; 2]) };
    let mut body = parts::body("sheet", cloth(1e-3, 1e3), source, [0.0; 3]);
    body.spacing_m = Some(SPACING);
    let windows = ((from.abs() + 0.05) / speed.abs() / WINDOW).round() as u64;
    let mut scene = parts::solver_scene("pbd", vec![body], windows, WINDOW);
    scene.actions = vec![parts::gravity()];
    scene.params.insert("thickness_m".into(), 0.004.into());
    let rim = 0.5 * SPACING * SQUARES as f64;
    let pins: Vec<[f64; 3]> =
        [[-1.0, -1.0], [-1.0, 1.0], [1.0, -1.0], [1.0, 1.0]].iter().map(|[x, y]| [x * rim, y * rim, 0.0]).collect();
    scene.params.insert("pins".into(), serde_json::json!({ "sheet": pins }));
    let mut view = parts::view(1, ViewRole::ContactResolver, "sheet", "leaf", Vec::new());
    view.partner_form = BoundaryForm::SamplesF64 { normals: true };
    view.pair = Some(pair("sheet", "leaf", 0.3));
    scene.interfaces = vec![view];
    let mut run = Run::new(scene);
    let count = ROW * ROW;
    let statics = SampleStatics {
        area_m2: vec![WIDTH * WIDTH; count],
        volume_m3: vec![WIDTH * WIDTH * 0.002; count],
        // Too heavy to give way: where it is, is prescribed.
        ..SampleStatics::equal(count, 1e6)
    };
    run.plugin.connect(&[PartnerSetup { interface: 1, statics }]).expect("a partner");
    let leaf = Leaf { axes, centre: [0.003, 0.002, from], velocity: [0.0, 0.0, speed] };
    let (edges, triangles) = (Leaf::edges(), squares(SQUARES));
    let mut gone = 0;
    for window in 0..windows {
        let t = WINDOW * window as f64;
        let samples = Samples {
            position: leaf.positions(t),
            velocity: vec![leaf.velocity; count],
            normal: vec![[0.0, 0.0, 1.0]; count],
        };
        let now = BoundaryState::Samples(samples);
        let input = PartnerInput { interface: 1, rule: MotionRule::Linear, now, next: None, length_s: WINDOW };
        let out = run.step_with(&Inputs { partners: vec![input], impulses: Vec::new() }).expect("a step");
        gone += out.report.counters["samples gone through cloth"];
        let v = run.vertices("sheet");
        let through = pierced(&leaf.positions(t + WINDOW), &edges, &v, &triangles);
        assert_eq!(through, 0, "window {window} of {windows}, at {speed} m/s");
    }
    assert_eq!(gone, 0, "at {speed} m/s");
    // The cloth has been taken along: it is not behind the leaf as a whole either.
    let middle = run.vertices("sheet")[(SQUARES + 1) * (SQUARES / 2) + SQUARES / 2][2];
    let tip = leaf.positions(WINDOW * windows as f64).iter().map(|x| x[2] * speed.signum()).fold(f64::MIN, f64::max);
    assert!(middle * speed.signum() > tip, "{middle} m, the leaf is at {tip} m");
    assert!(run.defect[0] < 1e-12 * run.gross && run.defect[1] < 1e-12 * run.gross, "{:?}", run.defect);
    run
}

const FLAT: [[f64; 3]; 2] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
const ON_EDGE: [[f64; 3]; 2] = [[0.8, 0.6, 0.0], [0.0, 0.0, 1.0]];

#[test]
fn a_flat_leaf_does_not_come_through_from_either_side() {
    for speed in [0.5, 4.0, 20.0] {
        push(FLAT, -0.01, speed);
        push(FLAT, 0.01, -speed);
    }
}

#[test]
fn a_leaf_on_its_edge_does_not_come_through_from_either_side() {
    let below = -0.01 - 0.5 * WIDTH * (ROW - 1) as f64;
    for speed in [0.5, 4.0, 20.0] {
        push(ON_EDGE, below, speed);
        push(ON_EDGE, -below, -speed);
    }
}

/// Samples of a leaf that stands across the plane of the cloth: along z, and away from the cloth.
const STANDING: [usize; 2] = [12, 4];
/// Their distance \[m\]: the plane of the cloth lies halfway between two rows.
const CLOSE: f64 = 0.006;

#[test]
fn a_rim_does_not_slide_in_between_neighbouring_samples() {
    let source = Source::Plane { size_m: Some([SPACING * SQUARES as f64; 2]) };
    let mut body = parts::body("sheet", cloth(1e-4, 1e3), source, [0.0; 3]);
    body.spacing_m = Some(SPACING);
    let (windows, speed) = (20, -0.5);
    let mut scene = parts::solver_scene("pbd", vec![body], windows, WINDOW);
    scene.params.insert("thickness_m".into(), 0.003.into());
    let rim = 0.5 * SPACING * SQUARES as f64;
    let pins: Vec<[f64; 3]> = (0..=SQUARES).map(|j| [-rim, SPACING * j as f64 - rim, 0.0]).collect();
    scene.params.insert("pins".into(), serde_json::json!({ "sheet": pins }));
    let mut view = parts::view(1, ViewRole::ContactResolver, "sheet", "leaf", Vec::new());
    view.partner_form = BoundaryForm::SamplesF64 { normals: true };
    view.pair = Some(pair("sheet", "leaf", 0.3));
    scene.interfaces = vec![view];
    let mut run = Run::new(scene);
    let [n, m] = STANDING;
    let count = n * m;
    let statics = SampleStatics {
        area_m2: vec![CLOSE * CLOSE; count],
        volume_m3: vec![CLOSE.powi(3); count],
        // Too heavy to give way: where it is, is prescribed.
        ..SampleStatics::equal(count, 1e6)
    };
    run.plugin.connect(&[PartnerSetup { interface: 1, statics }]).expect("a partner");
    // Beside the middle of an edge, and from beyond where beads of 4.5 mm touch.
    let place = |t: f64, k: usize| {
        let z = CLOSE * ((k % n) as f64 - 0.5 * (n - 1) as f64);
        [rim + 0.006 + CLOSE * (k / n) as f64 + speed * t, 0.004, z]
    };
    let at = |t: f64| (0..count).map(|k| place(t, k)).collect::<Vec<_>>();
    let up = (0..count).filter(|k| k % n + 1 < n).map(|k| [k, k + 1]);
    let edges: Vec<[usize; 2]> = up.chain((0..n * (m - 1)).map(|k| [k, k + n])).collect();
    let triangles = squares(SQUARES);
    for window in 0..windows {
        let t = WINDOW * window as f64;
        let samples =
            Samples { position: at(t), velocity: vec![[speed, 0.0, 0.0]; count], normal: vec![[0.0, 0.0, 1.0]; count] };
        let now = BoundaryState::Samples(samples);
        let input = PartnerInput { interface: 1, rule: MotionRule::Linear, now, next: None, length_s: WINDOW };
        let out = run.step_with(&Inputs { partners: vec![input], impulses: Vec::new() }).expect("a step");
        let through = pierced(&at(t + WINDOW), &edges, &run.vertices("sheet"), &triangles);
        assert_eq!((through, out.report.counters["final-neighbours with cloth between"]), (0, 0), "window {window}");
    }
    // It has been pushed back by most of the way of 2 cm.
    let middle = run.vertices("sheet")[(SQUARES + 1) * (SQUARES / 2) + SQUARES];
    assert!(middle[0] < rim - 0.005, "{middle:?}");
    assert!(run.defect[0] < 1e-12 * run.gross && run.defect[1] < 1e-12 * run.gross, "{:?}", run.defect);
}

#[test]
fn on_which_side_a_cloth_is_belongs_to_its_state() {
    let mut run = push(FLAT, -0.01, 0.5);
    let bytes = run.bytes();
    let scene = run.scene.clone();
    run.plugin.restore(&bytes).expect("its own state");
    assert_eq!(run.bytes(), bytes);
    // Cut short by a side, or from a run that knew more samples: refused, not taken.
    assert!(run.plugin.restore(&bytes[..bytes.len() - 8]).is_err());
    let mut other = Run::new(scene);
    assert!(other.plugin.restore(&bytes).is_err(), "it knows no samples yet");
}
