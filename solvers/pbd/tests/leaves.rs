//! Light leaves that fly into silk at 20 m/s: samples held together by what the cloth does not know of.

mod common;

use common::{Run, cloth, pair, pierced, squares};
use cosplat_conformance::parts;
use cosplat_core::boundary::{
    BoundaryState, Impulses, SampleStatics, Samples, Vec3, add, cross, dot, norm, scale, sub,
};
use cosplat_core::plan::BoundaryForm;
use cosplat_core::plugin::{Inputs, PartnerInput, PartnerSetup, Plugin, ViewRole};
use cosplat_core::scene::{MotionRule, Source};

/// Squares of the silk along a side, and its spacing \[m\].
const SQUARES: usize = 20;
const SPACING: f64 = 0.015;
/// Samples of the leaf, 10 cm by 6 cm, and their distance \[m\], which is also its thickness.
const ROWS: [usize; 2] = [21, 13];
const CLOSE: f64 = 0.005;
const COUNT: usize = ROWS[0] * ROWS[1];
/// Thickness of the silk, and the distance of its middle from that of a sample at which they touch \[m\].
const THICK: f64 = 0.0036;
const TOUCHING: f64 = 0.5 * (THICK + CLOSE);
/// Young's modulus of the leaf \[Pa\].
const STIFF: f64 = 1e5;
const SPEED: f64 = 20.0;

/// How a leaf meets silk.
#[derive(Clone, Copy, Debug)]
struct Flight {
    /// Mass of the leaf \[kg/m²\].
    areal: f64,
    /// Angle of its plane to that of the silk \[°\], and turns about an axis along the silk \[rad/s\].
    tilt: f64,
    spin: f64,
    /// Whether the rim of the silk is held.
    held: bool,
    window: f64,
}

/// What came of it.
#[derive(Clone, Copy, Debug)]
struct Outcome {
    /// Samples that went through cloth; pieces of leaf and cloth that are through each other at the end.
    gone: u64,
    through: usize,
    /// Largest overrun that was reported \[m\].
    overrun: f64,
    /// Mechanical energy of both at the end and at most, over that of the start.
    energy: [f64; 2],
}

/// Masses and springs, of which the cloth sees the masses.
struct Leaf {
    x: Vec<Vec3>,
    v: Vec<Vec3>,
    mass: f64,
    springs: Vec<([usize; 2], f64)>,
}

impl Leaf {
    /// 12 mm over silk at z = 0, coming down.
    fn new(flight: &Flight) -> Self {
        let (yaw, tilt) = (37.0_f64.to_radians(), flight.tilt.to_radians());
        let along = [yaw.cos(), yaw.sin(), 0.0];
        let up = add(scale([-yaw.sin(), yaw.cos(), 0.0], tilt.cos()), [0.0, 0.0, tilt.sin()]);
        let at = |k: usize, n: usize| CLOSE * (k as f64 - 0.5 * (n - 1) as f64);
        let place = |i: usize| add(scale(along, at(i % ROWS[0], ROWS[0])), scale(up, at(i / ROWS[0], ROWS[1])));
        let flat: Vec<Vec3> = (0..COUNT).map(place).collect();
        let low = flat.iter().map(|x| x[2]).fold(f64::MAX, f64::min);
        let turning = scale(along, flight.spin);
        let v = flat.iter().map(|&x| add([0.0, 0.0, -SPEED], cross(turning, x))).collect();
        let x: Vec<Vec3> = flat.iter().map(|&x| add(x, [0.003, 0.002, 0.012 - low])).collect();
        let length = |[i, j]: [usize; 2]| norm(sub(x[j], x[i]));
        let pairs = (0..COUNT).flat_map(|i| (i + 1..COUNT).map(move |j| [i, j]));
        // Neighbours in rows, across, and the next but one, which resist bending.
        let springs = pairs.map(|ends| (ends, length(ends))).filter(|(_, l)| *l < 2.3 * CLOSE).collect();
        Self { x, v, mass: flight.areal * CLOSE * CLOSE, springs }
    }

    /// A sheet of springs `k` along rows, diagonals and double rows is about 2.5 times as stiff as `k`.
    const SPRING: f64 = STIFF * CLOSE / 2.5;

    fn energy(&self) -> f64 {
        let stored =
            |&([i, j], l): &([usize; 2], f64)| 0.5 * Self::SPRING * (norm(sub(self.x[j], self.x[i])) - l).powi(2);
        self.v.iter().map(|v| 0.5 * self.mass * dot(*v, *v)).chain(self.springs.iter().map(stored)).sum()
    }

    /// Takes impulses over a window.
    fn advance(&mut self, impulses: &[Vec3], window: f64) {
        let steps = (window / 2e-5).ceil();
        let h = window / steps;
        for _ in 0..steps as u64 {
            let mut force: Vec<Vec3> = impulses.iter().map(|j| scale(*j, 1.0 / window)).collect();
            for &([i, j], rest) in &self.springs {
                let way = sub(self.x[j], self.x[i]);
                let length = norm(way);
                let n = scale(way, 1.0 / length);
                let damper = 0.02 * (Self::SPRING * self.mass).sqrt() * dot(sub(self.v[j], self.v[i]), n);
                let pull = scale(n, Self::SPRING * (length - rest) + damper);
                (force[i], force[j]) = (add(force[i], pull), sub(force[j], pull));
            }
            for ((x, v), f) in self.x.iter_mut().zip(&mut self.v).zip(force) {
                *v = add(*v, scale(f, h / self.mass));
                *x = add(*x, scale(*v, h));
            }
        }
    }
}

/// Sides of triangles.
fn edges(triangles: &[[usize; 3]]) -> Vec<[usize; 2]> {
    let sides = |t: &[usize; 3]| [[t[0], t[1]], [t[1], t[2]], [t[0], t[2]]].map(|[a, b]| [a.min(b), a.max(b)]);
    let mut edges: Vec<[usize; 2]> = triangles.iter().flat_map(sides).collect();
    edges.sort_unstable();
    edges.dedup();
    edges
}

fn silk(flight: &Flight, windows: u64) -> Run {
    let source = Source::Plane { size_m: Some([SPACING * SQUARES as f64; 2]) };
    let mut body = parts::body("silk", cloth(1e-6, 2e4), source, [0.0; 3]);
    body.spacing_m = Some(SPACING);
    let mut scene = parts::solver_scene("pbd", vec![body], windows, flight.window);
    scene.params.insert("thickness_m".into(), THICK.into());
    let rim = 0.5 * SPACING * SQUARES as f64;
    let along = (0..=SQUARES).map(|i| SPACING * i as f64 - rim);
    let pins: Vec<Vec3> = along.flat_map(|s| [[s, rim, 0.0], [s, -rim, 0.0], [rim, s, 0.0], [-rim, s, 0.0]]).collect();
    if flight.held {
        scene.params.insert("pins".into(), serde_json::json!({ "silk": pins }));
    }
    let mut view = parts::view(1, ViewRole::ContactResolver, "silk", "leaf", Vec::new());
    view.partner_form = BoundaryForm::SamplesF64 { normals: true };
    view.pair = Some(pair("silk", "leaf", 0.05));
    scene.interfaces = vec![view];
    Run::new(scene)
}

/// Lets a leaf fly into silk for so many windows.
fn fly(flight: Flight, windows: u64) -> Outcome {
    let mut run = silk(&flight, windows);
    let mut leaf = Leaf::new(&flight);
    let statics = SampleStatics {
        area_m2: vec![CLOSE * CLOSE; COUNT],
        volume_m3: vec![CLOSE.powi(3); COUNT],
        ..SampleStatics::equal(COUNT, leaf.mass)
    };
    run.plugin.connect(&[PartnerSetup { interface: 1, statics }]).expect("a partner");
    let triangles = squares(SQUARES);
    let row = |i: usize| i % ROWS[0] + 1 < ROWS[0] && i / ROWS[0] + 1 < ROWS[1];
    let halves = |i: usize| [[i, i + 1, i + ROWS[0] + 1], [i, i + ROWS[0] + 1, i + ROWS[0]]];
    let faces: Vec<[usize; 3]> = (0..COUNT).filter(|&i| row(i)).flat_map(halves).collect();
    let start = leaf.energy();
    let mut outcome = Outcome { gone: 0, through: 0, overrun: 0.0, energy: [0.0; 2] };
    for _ in 0..windows {
        let samples =
            Samples { position: leaf.x.clone(), velocity: leaf.v.clone(), normal: vec![[0.0, 0.0, 1.0]; COUNT] };
        let now = BoundaryState::Samples(samples);
        let input = PartnerInput { interface: 1, rule: MotionRule::Linear, now, next: None, length_s: flight.window };
        let out = run.step_with(&Inputs { partners: vec![input], impulses: Vec::new() }).expect("a step");
        let Impulses::Samples(impulses) = &out.impulses[0].1 else { panic!("impulses on samples") };
        leaf.advance(impulses, flight.window);
        outcome.gone += out.report.counters["samples gone through cloth"];
        outcome.overrun = outcome.overrun.max(1e-6 * out.report.counters["largest-overrun-1e-6-m"] as f64);
        let energy = (leaf.energy() + out.report.energy.kinetic_j + out.report.energy.potential_j) / start;
        outcome.energy = [energy, outcome.energy[1].max(energy)];
    }
    let v = run.vertices("silk");
    outcome.through =
        pierced(&leaf.x, &edges(&faces), &v, &triangles) + pierced(&v, &edges(&triangles), &leaf.x, &faces);
    assert!(run.defect[0] < 1e-12 * run.gross && run.defect[1] < 1e-12 * run.gross, "{:?}", run.defect);
    outcome
}

/// The plan's windows of silk against such a leaf: 1.4 of the coarser spacing for its elastic wave, `c = √(E d/σ)`, and 0.3 of
/// it for its speed where the scene tells of it.
fn planned(areal: f64) -> [f64; 2] {
    let wave = 1.4 * SPACING / (STIFF * CLOSE / areal).sqrt();
    [wave, wave.min(0.3 * SPACING / SPEED)]
}

#[test]
fn leaves_at_20_m_s_do_not_cut_silk_however_they_are_turned() {
    let turns = [(0.0, 0.0), (30.0, 60.0), (70.0, -60.0), (90.0, 0.0), (90.0, 60.0)];
    let all = [0.2, 0.5, 1.0].into_iter().flat_map(|areal| turns.map(|(tilt, spin)| (areal, tilt, spin)));
    for (areal, tilt, spin) in all {
        for (held, window) in [false, true].into_iter().flat_map(|held| planned(areal).map(|window| (held, window))) {
            let flight = Flight { areal, tilt, spin, held, window };
            // Until the leaf has been stopped, or takes the silk along.
            let outcome = fly(flight, (0.2 / SPEED / window).ceil() as u64);
            assert_eq!(outcome.gone, 0, "{flight:?}: {outcome:?}");
            // What is still overrun by more than the distance at which they touch is through the silk, and said to be.
            let said = window > 0.3 * SPACING / SPEED && outcome.overrun > TOUCHING;
            assert!(outcome.through == 0 || said, "{flight:?}: {outcome:?}");
            // A millionth for the steps of a leaf that turns.
            assert!(outcome.energy[1] < 1.0 + 1e-6 && outcome.energy[0] < 0.9, "{flight:?}: {outcome:?}");
        }
    }
}

#[test]
fn how_far_a_leaf_overruns_held_silk_is_bounded_and_said() {
    for window in [1e-4, 5e-4, 2e-3] {
        let flight = Flight { areal: 0.5, tilt: 90.0, spin: 0.0, held: true, window };
        let outcome = fly(flight, (0.2 / SPEED / window) as u64);
        // Behind a sample of its edge are those of its column, and only its edge is held up: v W √(B/m). That it is not far
        // below says that the window is what it comes from.
        let most = SPEED * window * (ROWS[1] as f64).sqrt();
        assert!(outcome.overrun < most && outcome.overrun > 0.1 * most, "{flight:?}: {outcome:?} of {most} m");
    }
}

#[test]
fn where_contact_left_a_leaf_belongs_to_the_state() {
    let flight = Flight { areal: 0.5, tilt: 90.0, spin: 0.0, held: true, window: 5e-4 };
    let leaf = Leaf::new(&flight);
    let step = |run: &mut Run| {
        // It is said to come on as if nothing had been in its way.
        let t = flight.window * run.window as f64;
        let position = leaf.x.iter().zip(&leaf.v).map(|(&x, &v)| add(x, scale(v, t))).collect();
        let samples = Samples { position, velocity: leaf.v.clone(), normal: vec![[0.0, 0.0, 1.0]; COUNT] };
        let now = BoundaryState::Samples(samples);
        let input = PartnerInput { interface: 1, rule: MotionRule::Linear, now, next: None, length_s: flight.window };
        run.step_with(&Inputs { partners: vec![input], impulses: Vec::new() }).expect("a step").impulses
    };
    let statics = || SampleStatics { volume_m3: vec![CLOSE.powi(3); COUNT], ..SampleStatics::equal(COUNT, leaf.mass) };
    let mut run = silk(&flight, 10);
    run.plugin.connect(&[PartnerSetup { interface: 1, statics: statics() }]).expect("a partner");
    (0..4).for_each(|_| drop(step(&mut run)));
    let mut other = silk(&flight, 10);
    other.plugin.connect(&[PartnerSetup { interface: 1, statics: statics() }]).expect("a partner");
    other.plugin.restore(&run.bytes()).expect("a state");
    other.window = run.window;
    assert_eq!(other.bytes(), run.bytes());
    for _ in 0..4 {
        assert_eq!(step(&mut other), step(&mut run));
        assert_eq!(other.bytes(), run.bytes());
    }
}

#[test]
fn substeps_follow_samples_that_are_faster_than_the_silk() {
    let flight = Flight { areal: 0.5, tilt: 60.0, spin: 0.0, held: false, window: 2e-3 };
    let (mut run, leaf) = (silk(&flight, 1), Leaf::new(&flight));
    run.plugin
        .connect(&[PartnerSetup { interface: 1, statics: SampleStatics::equal(COUNT, leaf.mass) }])
        .expect("a partner");
    let samples = Samples { position: leaf.x, velocity: leaf.v, normal: vec![[0.0, 0.0, 1.0]; COUNT] };
    let now = BoundaryState::Samples(samples);
    let input = PartnerInput { interface: 1, rule: MotionRule::Linear, now, next: None, length_s: flight.window };
    let out = run.step_with(&Inputs { partners: vec![input], impulses: Vec::new() }).expect("a step");
    // 0.3 of a spacing in each; substeps of the silk at rest would be 8.
    assert_eq!(out.report.substeps, (flight.window * SPEED / (0.3 * SPACING)).ceil() as u64);
}
