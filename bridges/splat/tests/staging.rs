//! From a capture to a body, its motion and its export.

#![allow(clippy::float_cmp, reason = "bits that must not change are compared")]

mod common;

use common::{Random, covariance, some_splats};
use cosplat_core::scene::BindingKind;
use cosplat_splat::bind::{BindError, Frame};
use cosplat_splat::format::{self, Decoded};
use cosplat_splat::skin::Limits;
use cosplat_splat::stage::{Recipe, StageError, Staged};
use cosplat_splat::surfel::{Light, Sample, dots, grained, lit, surfels};
use cosplat_splat::{Axes, MergeError, OutputFrame, Similarity, Splats, merge};
use nalgebra::{Rotation3, Vector3};

const PI: f64 = std::f64::consts::PI;

/// A pot with a stalk and a leaf, up along +y, in units of 2 m, with all bands: what a capture looks like.
fn capture(degree: u8) -> Splats {
    let mut r = Random::new(5);
    let mut samples = Vec::new();
    let mut put = |position: [f64; 3], normal: [f64; 3]| {
        let position = position.map(|v| v as f32);
        samples.push(Sample { position, normal: normal.map(|v| v as f32), area: 4e-5, colour: [0.3, 0.5, 0.2] });
    };
    for _ in 0..12_000 {
        let (a, y) = (r.between(0.0, 2.0 * PI), r.between(-0.1, 0.1));
        put([0.1 * a.cos(), y, 0.1 * a.sin()], [a.cos(), 0.0, a.sin()]);
        let s = 0.1 * r.unit().sqrt();
        put([s * a.cos(), 0.1, s * a.sin()], [0.0, 1.0, 0.0]);
    }
    for _ in 0..1500 {
        let (a, y) = (r.between(0.0, 2.0 * PI), r.between(0.1, 0.3));
        put([0.008 * a.cos(), y, 0.008 * a.sin()], [a.cos(), 0.0, a.sin()]);
        put([r.between(0.0, 0.15), 0.3 + r.between(-0.001, 0.001), r.between(-0.05, 0.05)], [0.0, 1.0, 0.0]);
    }
    let mut splats = surfels(&samples);
    let other = some_splats(splats.len(), degree, 3);
    splats.axes = Axes::Rub;
    splats.sh_degree = degree;
    splats.sh_rest = other.sh_rest;
    splats.extras = other.extras;
    // Faint ones, one without a position, and a speck in the air.
    splats.opacity_logits[7] = -9.0;
    splats.positions[8][0] = f32::NAN;
    splats.positions[9] = [0.9, 0.9, 0.9];
    splats
}

fn recipe() -> Recipe {
    Recipe::new(0.5, [0.0, 1.0, 0.0], 0.005)
}

fn staged(degree: u8) -> Staged {
    Staged::new(Decoded { splats: capture(degree), notes: Vec::new() }, &recipe()).expect("it is a body")
}

/// A pose that is nothing special.
fn pose() -> Frame {
    Frame::of_pose([0.3, -0.2, 0.05], [0.1, 0.2, 0.3, 0.9]).expect("it is a pose")
}

fn world_of(body: &Staged, pose: &Frame) -> Vec<[f64; 3]> {
    body.cloud.position_m.iter().map(|p| pose.point(Vector3::from(*p)).into()).collect()
}

#[test]
fn a_capture_becomes_a_body() {
    let body = staged(1);
    let report = &body.report;
    assert_eq!((report.clean.faint, report.clean.non_finite, report.clean.kept), (1, 1, capture(1).len() - 2));
    // The speck alone, with the cells that it touches.
    assert!((1..=8).contains(&report.cloud.stray), "{}", report.cloud.stray);
    assert_eq!((report.visible_unbound, &body.unbound[..]), (1, &[7_u32][..]));
    assert_eq!(report.bound + body.unbound.len(), body.splats.len());
    // The pot is 0.1 m high and has a radius of 0.05 m. A wall of random points bulges by up to a cell.
    let pot = PI * 0.05 * 0.05 * 0.1;
    let shell = PI * 0.055 * 0.055 * 0.11;
    println!("{report:?}");
    assert!(
        (0.93 * pot..1.05 * shell).contains(&report.cloud.inside_volume_m3),
        "{}",
        report.cloud.inside_volume_m3 / pot
    );
    assert!((report.cloud.volume_m3 - body.cloud.volume_m3.iter().sum::<f64>()).abs() < 1e-12);
    assert_eq!(body.cloud.position_m.len(), report.cloud.inside + report.cloud.sheet + report.cloud.bridges);
    // The underside is that of the pot, within a cell; nothing lies below.
    assert!((report.cloud.base_m + 0.05).abs() <= 0.005, "{}", report.cloud.base_m);
    assert!(body.cloud.position_m.iter().all(|p| p[2] >= report.cloud.base_m));
    // The leaf carries particles, to its tip.
    assert!(body.cloud.position_m.iter().any(|p| p[2] > 0.145 && p[0] > 0.07));
    // Body frame: the file's origin, upright.
    let expected = body.similarity.point(Vector3::from(body.source.positions[100].map(f64::from)));
    assert!((Vector3::from(body.splats.positions[100].map(f64::from)) - expected).norm() < 1e-8);
    let again = staged(1);
    assert_eq!((again.cloud, again.binding, again.report), (body.cloud, body.binding, body.report));
}

#[test]
fn a_box_of_the_file_and_an_opacity_choose() {
    let decoded = |splats: Splats| Decoded { splats, notes: Vec::new() };
    let keep_box = Some([[-0.2, -0.2, -0.2], [0.2, 0.05, 0.2]]);
    let pot = Staged::new(decoded(capture(0)), &Recipe { keep_box, ..recipe() }).unwrap();
    assert!(pot.source.positions.iter().all(|p| p[1] <= 0.05) && pot.report.clean.outside > 1000);
    let none = Staged::new(decoded(capture(0)), &Recipe { min_opacity: 1.1, ..recipe() });
    assert!(matches!(none, Err(StageError::Empty(report)) if report.kept == 0));
    for bad in [Recipe { metres_per_unit: -1.0, ..recipe() }, Recipe { up: [0.0; 3], ..recipe() }] {
        assert!(matches!(Staged::new(decoded(capture(0)), &bad), Err(StageError::Similarity(_))));
    }
    assert!(matches!(
        Staged::new(decoded(capture(0)), &Recipe::new(0.5, [0.0, 1.0, 0.0], 0.0)),
        Err(StageError::Fill(_))
    ));
    let mut far = capture(0);
    far.positions.iter_mut().for_each(|p| p[0] += 1e30);
    assert!(matches!(Staged::new(decoded(far), &recipe()), Err(StageError::Fill(_))));
    assert!(matches!(Staged::from_file("no.spz".as_ref(), &recipe()), Err(StageError::File(_))));
}

/// Half of the body moves: the other half is in the export what was decoded, to the last bit, also where the solver
/// rounds the pose its own way.
#[test]
fn what_no_particle_moves_leaves_as_it_was_decoded() {
    let body = staged(3);
    let frame = OutputFrame::of_file(&body, &pose());
    let initial: Vec<[f64; 3]> = world_of(&body, &pose()).iter().map(|p| p.map(|v| f64::from(v as f32))).collect();
    let shown = body.shown(&pose(), &frame, Some(&initial)).unwrap();
    assert_eq!(*shown.rest(), body.source);
    let up = pose().rotation * Vector3::z();
    let mut now = initial.clone();
    for (p, rest) in now.iter_mut().zip(&body.cloud.position_m) {
        if rest[2] > 0.07 {
            *p = (Vector3::from(*p) + up * 0.01).into();
        }
    }
    let mut out = Splats::default();
    let report = shown.deformed(&now, None, Limits::default(), &mut out).unwrap();
    assert!(report.moved > 2000 && report.unmoved > 20_000 && report.lost == 0, "{report:?}");
    let mut same = 0;
    for i in 0..out.len() {
        let bits = |s: &Splats| (s.positions[i], s.rotations[i], s.log_scales[i], s.rest(i).to_vec());
        same += usize::from(bits(&out) == bits(&body.source));
    }
    assert_eq!(same, report.unmoved);
    // Written and read again it is the same file; only the signs of the axes differ in between.
    let path = std::env::temp_dir().join(format!("cosplat-staging-{}.ply", std::process::id()));
    format::write_file(&path, &out).unwrap();
    let back = format::read_file(&path).unwrap().splats.to_axes(Axes::Rub);
    std::fs::remove_file(&path).unwrap();
    assert_eq!(back, out);
}

/// A rotation of all particles about the world is the same as a rotation of the world, in both frames, with gradients
/// of the solver and without.
#[test]
fn a_turned_body_is_turned() {
    let body = staged(2);
    let turn = Rotation3::from_euler_angles(0.4, -0.3, 1.1).into_inner();
    let shift = Vector3::new(0.5, 0.1, 0.2);
    let initial = world_of(&body, &pose());
    let now: Vec<[f64; 3]> = initial.iter().map(|p| (turn * Vector3::from(*p) + shift).into()).collect();
    let gradients = vec![std::array::from_fn(|k| turn[(k / 3, k % 3)] as f32); now.len()];
    let moved = Frame { rotation: turn * pose().rotation, translation: turn * pose().translation + shift };
    for frame in [OutputFrame::world(), OutputFrame::of_file(&body, &pose())] {
        let shown = body.shown(&pose(), &frame, None).unwrap();
        let (mut rigid, mut soft) = (Splats::default(), Splats::default());
        shown.posed(&moved, &mut rigid);
        let size = frame.from_world.scale;
        for g in [None, Some(&gradients[..])] {
            shown.deformed(&now, g, Limits::default(), &mut soft).unwrap();
            for i in (0..soft.len()).filter(|i| body.unbound.binary_search(&(*i as u32)).is_err()) {
                let [a, b] = [&soft, &rigid].map(|s| Vector3::from(s.positions[i].map(f64::from)));
                // Single precision at a distance of some 0.7 m: 6e-8 of it in each of a few operations; the fit of a
                // gradient to displacements rounded so, over neighbours 5 mm apart, is good to some 1e-4.
                assert!((a - b).norm() < 2e-6 * size, "{i} {}", (a - b).norm());
                let [a, b] = [&soft, &rigid].map(|s| covariance(s, i));
                assert!((a - b).amax() < 1e-3 * b.amax(), "{i}");
                let change =
                    soft.rest(i).iter().flatten().zip(rigid.rest(i).iter().flatten()).map(|(x, y)| (x - y).abs());
                assert!(change.fold(0.0, f32::max) < 1e-3, "{i}");
            }
        }
        shown.posed(&pose(), &mut rigid);
        assert_eq!(rigid, *shown.rest());
    }
}

#[test]
fn lists_of_another_length_and_poses_that_are_none_are_refused() {
    let body = staged(0);
    let world = OutputFrame::world();
    assert!(matches!(body.shown(&pose(), &world, Some(&[[0.0; 3]])), Err(BindError::Length("particles", _, 1))));
    let shown = body.shown(&pose(), &world, None).unwrap();
    // What was in `out` does not matter, not even other Gaussians of the same number.
    let (now, mut out) = (world_of(&body, &pose()), some_splats(body.splats.len(), 0, 1));
    shown.deformed(&now, None, Limits::default(), &mut out).unwrap();
    assert_eq!(out, *shown.rest());
    assert!(shown.deformed(&now[1..], None, Limits::default(), &mut out).is_err());
    assert!(shown.deformed(&now, Some(&[[0.0; 9]]), Limits::default(), &mut out).is_err());
    // A particle that is nowhere takes nobody with it.
    let mut lost = now.clone();
    lost[40] = [f64::NAN; 3];
    let report = shown.deformed(&lost, None, Limits::default(), &mut out).unwrap();
    assert!(report.lost > 0 && out.positions.iter().flatten().all(|v| v.is_finite()));
    assert_eq!(Frame::of_pose([0.0; 3], [0.0; 4]), Err(BindError::Pose));
    assert_eq!(Frame::of_pose([f64::NAN; 3], [0.0, 0.0, 0.0, 1.0]), Err(BindError::Pose));
    assert_eq!(Frame::of_pose([0.0; 3], [0.0, 0.0, 0.0, 1.0]), Ok(Frame::identity()));
}

#[test]
fn the_picture_does_not_depend_on_threads() {
    let run = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let body = staged(1);
            let now: Vec<[f64; 3]> =
                world_of(&body, &pose()).iter().map(|p| [p[0] + 0.2 * p[2] * p[1], p[1].sin(), p[2]]).collect();
            let mut out = Splats::default();
            let shown = body.shown(&pose(), &OutputFrame::world(), None).unwrap();
            shown.deformed(&now, None, Limits::default(), &mut out).unwrap();
            out
        })
    };
    let one = run(1);
    for threads in [2, 5] {
        assert_eq!(run(threads), one, "{threads} threads");
    }
}

#[test]
fn several_bodies_make_one_file() {
    let body = staged(2);
    let frame = OutputFrame::of_file(&body, &pose());
    let shown = body.shown(&pose(), &frame, None).unwrap();
    let stone = grained(&[[0.0, 0.0, 0.1], [0.02, 0.0, 0.1]], &[[0.0, 0.0, 1.0]; 2], &[1e-4; 2], [0.3; 3], 0.2);
    let stone = lit(&stone, &Frame::identity(), &Light::default(), &frame);
    let mud = dots(&[[0.1, 0.2, 0.3]], &[], 0.01, [0.2, 0.1, 0.05], &frame).unwrap();
    let all = merge(&[shown.rest(), &stone, &mud]).unwrap();
    assert!(all.is_consistent());
    let n = body.source.len();
    assert_eq!((all.len(), all.sh_degree, all.axes), (n + 3, 2, Axes::Rub));
    let first: Vec<u32> = (0..n as u32).collect();
    assert_eq!(all.select(&first), body.source);
    assert!(all.rest(n).iter().flatten().all(|v| *v == 0.0) && all.extras[0].values[n] == 0.0);
    // A point of the world is where the inverse of file → body → world puts it.
    let to_world = Similarity::from(pose()).after(&body.similarity);
    let back = to_world.point(Vector3::from(mud.positions[0].map(f64::from)));
    assert!((back - Vector3::new(0.1, 0.2, 0.3)).norm() < 1e-6);
    let elsewhere = dots(&[[0.0; 3]], &[], 0.01, [0.5; 3], &OutputFrame::world()).unwrap();
    assert_eq!(merge(&[shown.rest(), &elsewhere]), Err(MergeError::Axes(1, Axes::Scene, Axes::Rub)));
    assert_eq!(merge(&[]), Ok(Splats::default()));
}

/// The plant that the project ships, as the default scene uses it.
#[test]
fn the_shipped_plant_is_one_body() {
    let path = std::path::PathBuf::from(std::env::var("CARGO_MANIFEST_DIR").expect("cargo runs the tests"))
        .join("../../launch/scenes/assets/plant.v4.spz");
    let body = Staged::from_file(&path, &Recipe::new(0.4665, [0.0, 1.0, 0.0], 0.004)).unwrap();
    let report = &body.report;
    println!("{report:?}");
    assert_eq!((report.clean.total, report.clean.kept, report.visible), (113_648, 111_110, 86_952));
    // At least 95 % of what is visible has to move with the plant.
    assert!(report.visible_unbound * 20 <= report.visible, "{}", report.visible_unbound);
    assert!((20_000..60_000).contains(&body.cloud.position_m.len()), "{}", body.cloud.position_m.len());
    // 0.45 m to a spacing.
    assert!((report.height_m - 0.45).abs() < 0.005, "{}", report.height_m);
    let pose = Frame::of_pose([0.0, 0.0, -report.cloud.base_m], [0.0, 0.0, 0.0, 1.0]).unwrap();
    let initial = world_of(&body, &pose);
    assert!(initial.iter().all(|p| p[2] >= 0.0));
    // A bend of the stalk above the pot, without gradients.
    let bend = |p: &[f64; 3]| {
        let angle = 3.0 * (p[2] - 0.13_f64).max(0.0);
        let z = p[2].min(0.13) + angle.sin() / 3.0 - p[0] * angle.sin();
        [p[0] * angle.cos() + (1.0 - angle.cos()) / 3.0, p[1], z]
    };
    let now: Vec<[f64; 3]> = initial.iter().map(bend).collect();
    let shown = body.shown(&pose, &OutputFrame::of_file(&body, &pose), None).unwrap();
    let mut out = Splats::default();
    let start = std::time::Instant::now();
    let moved = shown.deformed(&now, None, Limits::default(), &mut out).unwrap();
    println!("{moved:?} in {:.1} ms", start.elapsed().as_secs_f64() * 1e3);
    assert!(moved.unmoved > 30_000 && moved.moved > 70_000 && moved.lost == 0);
    assert!(out.positions.iter().zip(&body.source.positions).filter(|(a, b)| a == b).count() >= moved.unmoved);
}

/// An affine motion of a turned body with its gradients, through each binding of captures: the nearest particle and the
/// nearest twelve follow it exactly, the mean of ten only where it is a translation.
#[test]
fn a_body_follows_by_the_binding_that_its_recipe_names() {
    let (pose, frame) = (pose(), OutputFrame::world());
    let turn = Rotation3::from_euler_angles(0.3, -0.2, 0.5);
    let shift = Vector3::new(0.1, 0.0, -0.05);
    for (kind, turned, shifted) in [
        // Displacements in single precision over some millimetres.
        (BindingKind::Affine, 1e-5, 1e-6),
        (BindingKind::Particle, 1e-5, 1e-6),
        // Off by the angle times the distance to the mean of ten, some millimetres.
        (BindingKind::Mean, 1e-2, 1e-6),
    ] {
        let recipe = Recipe { binding: kind.into(), ..recipe() };
        let body = Staged::new(Decoded { splats: capture(0), notes: Vec::new() }, &recipe).expect("it is a body");
        let initial = world_of(&body, &pose);
        let shown = body.shown(&pose, &frame, Some(&initial)).expect("the lengths fit");
        let off = |map: &dyn Fn(Vector3<f64>) -> Vector3<f64>, gradient: [f32; 9]| {
            let now: Vec<[f64; 3]> = initial.iter().map(|p| map(Vector3::from(*p)).into()).collect();
            let gradients = vec![gradient; now.len()];
            let mut out = Splats::default();
            shown.deformed(&now, Some(&gradients), Limits::default(), &mut out).expect("the lengths fit");
            let gap = |i: usize| {
                let wanted = map(Vector3::from(shown.rest().positions[i].map(f64::from)));
                (Vector3::from(out.positions[i].map(f64::from)) - wanted).norm()
            };
            let bound = (0..out.len()).filter(|i| body.unbound.binary_search(&(*i as u32)).is_err());
            bound.map(gap).fold(0.0, f64::max)
        };
        let rows = std::array::from_fn(|k| turn.matrix()[(k / 3, k % 3)] as f32);
        let identity = [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0];
        let (around, along) = (off(&|p| turn * p + shift, rows), off(&|p| p + shift, identity));
        println!("{kind:?}: {around:.1e} m turned, {along:.1e} m shifted");
        assert!(around < turned && along < shifted, "{kind:?}: {around} {along}");
        assert!(kind != BindingKind::Mean || around > 1e-3, "the mean does not turn");
    }
}
