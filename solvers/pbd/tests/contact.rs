//! Cloth against walls, rigid partners and samples.

mod common;

use common::{Run, cloth, floor, pair, record, wall};
use cosplat_conformance::parts;
use cosplat_core::boundary::{BoundaryState, Impulses, SampleStatics, Samples, add, norm, scale, sub};
use cosplat_core::distance::{Placed, Shape, SignedDistance};
use cosplat_core::plan::BoundaryForm;
use cosplat_core::plugin::{Inputs, PartnerInput, PartnerSetup, Plugin, SolverScene, ViewRole};
use cosplat_core::scene::{MotionRule, Pose, Source, Wall};

const G: f64 = 9.81;

/// A sheet of 0.2 kg/m² at a height.
fn scene(size: f64, spacing: f64, height: f64, windows: u64, window: f64) -> SolverScene {
    let mut body =
        parts::body("sheet", cloth(1e-6, 1e2), Source::Plane { size_m: Some([size; 2]) }, [0.0, 0.0, height]);
    body.spacing_m = Some(spacing);
    parts::solver_scene("pbd", vec![body], windows, window)
}

/// Way down an incline of so many degrees in half a second \[m\], friction 0.3 and 0.2.
fn slide(degrees: f64) -> f64 {
    let mut scene = scene(0.1, 0.02, 0.0005, 50, 0.01);
    let (sin, cos) = degrees.to_radians().sin_cos();
    scene.statics = vec![floor(Wall::Friction { static_friction: 0.3, kinetic_friction: 0.2 })];
    let down = cosplat_core::scene::ActionKind::Gravity { acceleration_m_s2: [G * sin, 0.0, -G * cos] };
    scene.actions = vec![parts::action(down, 0.0, None)];
    let mut run = Run::new(scene);
    let mut last = run.setup.report.bodies[0].position_m[0];
    for _ in 0..50 {
        last = run.step().report.bodies[0].position_m[0];
    }
    last
}

#[test]
fn friction_holds_up_to_its_angle_and_brakes_beyond() {
    // atan 0.3 = 16.70°.
    let held = slide(16.5);
    // Rounding of positions of 0.1 m.
    assert!(held.abs() < 1e-12, "{held}");
    assert!(slide(16.9) > 0.1);
    let (sin, cos) = 20.0_f64.to_radians().sin_cos();
    let exact = 0.5 * G * (sin - 0.2 * cos) * 0.25;
    let found = slide(20.0);
    // Velocities first, positions after: h/T = 2.5e-4/0.5 more than a parabola, exactly.
    assert!((found / exact - 1.0 - 5e-4).abs() < 1e-6, "{found} {exact}");
}

#[test]
fn a_wall_that_sticks_holds_a_sheet_overhead() {
    let mut scene = scene(0.1, 0.02, 0.0005, 20, 0.01);
    scene.statics = vec![floor(Wall::NoSlip)];
    let up = cosplat_core::scene::ActionKind::Gravity { acceleration_m_s2: [1.0, 0.0, G] };
    scene.actions = vec![parts::action(up, 0.0, None)];
    let mut run = Run::new(scene);
    let moved = (0..20).map(|_| run.step().report.bodies[0].max_displacement_m).fold(0.0, f64::max);
    // Rounding of positions of 0.1 m.
    assert!(moved < 1e-15, "{moved}");
}

/// Silk as published that is thrown on a ball.
fn silk_survives(mode: &str) {
    let mut scene = scene(0.4, 0.01, 0.16, 15, 0.01);
    scene.bodies[0].material = cosplat_core::scene::presets::preset("silk").expect("a preset").material;
    scene.bodies[0].velocity = parts::twist([0.0, 0.0, -5.0], [0.0, 0.0, 3.0]);
    let pose = Pose { position_m: [0.02, 0.01, 0.0], orientation: common::UPRIGHT };
    let rough = Wall::Friction { static_friction: 0.05, kinetic_friction: 0.03 };
    scene.statics = vec![wall("ball", Source::Sphere { radius_m: 0.15 }, pose, rough)];
    scene.actions = vec![parts::gravity()];
    scene.params.insert("mode".into(), mode.into());
    let mut run = Run::new(scene);
    let energy = |e: &cosplat_core::plugin::Energy| e.kinetic_j + e.potential_j;
    let start = energy(&run.setup.report.energy);
    let last = (0..15)
        .map(|_| energy(&run.step().report.energy))
        .inspect(|e| assert!(*e < 1.05 * start))
        .last()
        .expect("windows");
    // What is stored is an estimate where a substep shortened by speed makes single sweeps stiffer.
    println!("{mode}: {start} J, {last} J");
    assert!(last < start, "{mode}: {start} J, {last} J");
    assert!(run.defect[0] < 1e-12 * run.gross && run.defect[1] < 1e-12 * run.gross, "{:?}", run.defect);
}

#[test]
fn published_silk_survives_in_physical_mode() {
    silk_survives("physical");
}

#[test]
fn published_silk_survives_in_the_published_mode() {
    silk_survives("genesis");
}

#[test]
fn a_cloth_drapes_over_a_ball_without_entering_it() {
    let mut scene = scene(0.5, 0.02, 0.152, 200, 0.01);
    let pose = Pose { position_m: [0.0; 3], orientation: common::UPRIGHT };
    let rough = Wall::Friction { static_friction: 1.0, kinetic_friction: 1.0 };
    scene.statics = vec![wall("ball", Source::Sphere { radius_m: 0.15 }, pose, rough)];
    scene.actions = vec![parts::gravity()];
    scene.params.insert("damping_1_s".into(), 5.0.into());
    let mut run = Run::new(scene);
    let (mut deepest, mut held) = (f64::NEG_INFINITY, 0.0);
    for i in 0..200 {
        let out = run.step();
        deepest = run.vertices("sheet").iter().map(|&x| 0.15 - norm(x)).fold(deepest, f64::max);
        if i >= 190 {
            held += 0.1 * (out.report.external.linear[2] / 0.01 + 0.05 * G);
        }
    }
    println!("deepest {deepest:e} m, held {:+.1e}", held / (0.05 * G) - 1.0);
    // Contact is at half the thickness of 1 mm. Outside a convex shape a place that keeps its distance to the tangent
    // plane keeps it to the shape: nothing but rounding is left.
    assert!(deepest < -0.0005 + 1e-9, "{deepest}");
    // What swings by then: the published gate of the case.
    assert!((held / (0.05 * G) - 1.0).abs() < 0.01, "{held}");
    assert!(run.defect[0] < 1e-12 * run.gross && run.defect[1] < 1e-12 * run.gross);
}

fn resolver(scene: &mut SolverScene, partner: &str, form: BoundaryForm, source: Option<Source>) {
    let mut view = parts::view(1, ViewRole::ContactResolver, "sheet", partner, Vec::new());
    (view.partner_form, view.partner_source, view.pair) = (form, source, Some(pair("sheet", partner, 0.3)));
    scene.interfaces = vec![view];
}

fn hears(now: BoundaryState, length_s: f64) -> Inputs {
    let partner = PartnerInput { interface: 1, rule: MotionRule::Linear, now, next: None, length_s };
    Inputs { partners: vec![partner], impulses: Vec::new() }
}

#[test]
fn a_sheet_and_a_light_plate_go_on_together() {
    for mass in [2e-4, 5e-4, 2e-3, 0.2] {
        let mut scene = scene(0.1, 0.01, 0.011, 60, 0.002);
        scene.bodies[0].velocity = parts::twist([0.0, 0.0, -1.0], [0.0; 3]);
        resolver(&mut scene, "plate", BoundaryForm::Proxy, Some(Source::Box { size_m: [0.2, 0.2, 0.02] }));
        let mut run = Run::new(scene);
        run.plugin.connect(&[PartnerSetup { interface: 1, statics: SampleStatics::default() }]).expect("a partner");
        let mut plate = record([0.0; 3], [0.0; 3], mass, mass * 0.2 * 0.2 / 12.0);
        for _ in 0..60 {
            let out = run.step_with(&hears(BoundaryState::Proxy(plate), 0.002)).expect("a step");
            let Impulses::Rigid(wrench) = &out.impulses[0].1 else { panic!("a wrench") };
            plate.linear_velocity = add(plate.linear_velocity, scale(wrench.linear, 1.0 / mass));
            plate.angular_velocity = add(plate.angular_velocity, scale(wrench.angular, 1.0 / plate.inertia[0]));
            plate.position = add(plate.position, scale(plate.linear_velocity, 0.002));
            let off = add(wrench.linear, out.report.interfaces[0].received.linear);
            assert!(norm(off) < 1e-15, "{off:?}");
        }
        let all = add(run.momentum.linear, scale(plate.linear_velocity, mass));
        // 2 g at 1 m/s.
        let together = -0.002 / (0.002 + mass);
        let sheet = scale(run.momentum.linear, 500.0)[2];
        println!("{mass} kg: {:+.1e} {:+.1e}", plate.linear_velocity[2] / together - 1.0, sheet / together - 1.0);
        assert!(norm(sub(all, [0.0, 0.0, -0.002])) < 1e-15, "{all:?}");
        // Eight turns over 121 places, and what the sheet keeps of its waves.
        assert!((plate.linear_velocity[2] / together - 1.0).abs() < 0.02 && (sheet / together - 1.0).abs() < 0.02);
    }
}

#[test]
fn a_sheet_and_free_samples_go_on_together() {
    for mass in [1e-6, 2e-5, 1e-3] {
        // So thick that nothing can come through between the vertices, and they alone are met.
        let mut scene = scene(0.1, 0.01, 0.0085, 60, 0.002);
        scene.params.insert("thickness_m".into(), 0.005.into());
        scene.bodies[0].velocity = parts::twist([0.0, 0.0, -1.0], [0.0; 3]);
        resolver(&mut scene, "soil", BoundaryForm::SamplesF64 { normals: true }, None);
        let mut run = Run::new(scene);
        let at = |i: usize| 0.01 * i as f64 - 0.1;
        let mut position: Vec<[f64; 3]> = (0..441).map(|i| [at(i % 21), at(i / 21), 0.0]).collect();
        let mut velocity = vec![[0.0; 3]; 441];
        let statics =
            SampleStatics { area_m2: vec![1e-4; 441], volume_m3: vec![1e-6; 441], ..SampleStatics::equal(441, mass) };
        run.plugin.connect(&[PartnerSetup { interface: 1, statics }]).expect("a partner");
        for _ in 0..60 {
            let samples =
                Samples { position: position.clone(), velocity: velocity.clone(), normal: vec![[0.0, 0.0, 1.0]; 441] };
            let out = run.step_with(&hears(BoundaryState::Samples(samples), 0.002)).expect("a step");
            let Impulses::Samples(each) = &out.impulses[0].1 else { panic!("impulses") };
            for ((x, v), &j) in position.iter_mut().zip(&mut velocity).zip(each) {
                *v = add(*v, scale(j, 1.0 / mass));
                *x = add(*x, scale(*v, 0.002));
            }
            let off = add(out.impulses[0].1.total(), out.report.interfaces[0].received.linear);
            // Roundings of some hundred impulses of 1e-5 N s.
            assert!(norm(off) < 1e-16, "{off:?}");
        }
        let all = velocity.iter().fold(run.momentum.linear, |sum, &v| add(sum, scale(v, mass)));
        // The vertex over the middle has 8/6 of a square: once they have met, both go on together; then the sheet's
        // lighter vertices hold it back, and the sample flies on.
        let vertex = 0.2e-4 * 8.0 / 6.0;
        assert!((velocity[220][2] * (vertex + mass) / vertex + 1.0).abs() < 1e-12, "{:?}", velocity[220]);
        assert!(norm(sub(all, [0.0, 0.0, -0.002])) < 1e-15, "{all:?}");
    }
}

/// How far below its surface a solid has come through triangles \[m\]: over points a tenth of a side apart.
fn deepest(run: &Run, triangles: &[[usize; 3]], solid: &impl SignedDistance) -> f64 {
    let v = run.vertices("sheet");
    let shares = (0..=10).flat_map(|a| (0..=10 - a).map(move |b| [f64::from(a) / 10.0, f64::from(b) / 10.0]));
    let points = triangles.iter().flat_map(|t| shares.clone().map(move |s| (t, s)));
    let at = |(t, [a, b]): (&[usize; 3], [f64; 2])| {
        add(add(scale(v[t[0]], 1.0 - a - b), scale(v[t[1]], a)), scale(v[t[2]], b))
    };
    points.map(|p| -solid.distance(at(p)).0).fold(f64::NEG_INFINITY, f64::max)
}

/// Triangles of a sheet of `n` by `n` squares, diagonals alternating.
fn squares(n: usize) -> Vec<[usize; 3]> {
    let corners = |i: usize, j: usize| [(i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)].map(|(i, j)| j * (n + 1) + i);
    let halves = |(i, j): (usize, usize)| match corners(i, j) {
        [a, b, c, d] if (i + j) % 2 == 0 => [[a, b, c], [a, c, d]],
        [a, b, c, d] => [[a, b, d], [b, c, d]],
    };
    (0..n).flat_map(|j| (0..n).map(move |i| (i, j))).flat_map(halves).collect()
}

#[test]
fn an_edge_and_a_corner_do_not_come_through_between_vertices() {
    // A block on its corner, far sharper than the squares of the sheet are small.
    let turned =
        nalgebra::UnitQuaternion::rotation_between(&nalgebra::Vector3::new(1.0, 1.0, 1.0), &nalgebra::Vector3::z())
            .expect("not opposite");
    let pose = Pose { position_m: [0.013, 0.007, 0.0], orientation: turned.coords.into() };
    let source = Source::Box { size_m: [0.2; 3] };
    let mut scene = scene(0.5, 0.05, 0.19, 120, 0.005);
    let rough = Wall::Friction { static_friction: 0.8, kinetic_friction: 0.8 };
    scene.statics = vec![wall("block", source.clone(), pose, rough)];
    scene.actions = vec![parts::gravity()];
    scene.params.insert("damping_1_s".into(), 3.0.into());
    let block = Placed::at(Shape::of(&source).expect("a formula"), &pose);
    let triangles = squares(10);
    let mut run = Run::new(scene);
    let worst = (0..120)
        .map(|_| {
            run.step();
            deepest(&run, &triangles, &block)
        })
        .fold(f64::NEG_INFINITY, f64::max);
    println!("deepest {worst:e} m");
    // Contact is at half of 1 mm; what is left of that is what places are off by between two searches.
    assert!(worst < 0.0, "{worst}");
    assert!(run.defect[0] < 1e-12 * run.gross && run.defect[1] < 1e-12 * run.gross, "{:?}", run.defect);
}
