//! Maps of Gaussians: similarity, binding, skinning.

#![allow(clippy::float_cmp, reason = "bits that must not change are compared")]

mod common;

use common::{Random, some_splats};
use cosplat_splat::bind::{Binding, Frame, Local, Particles};
use cosplat_splat::skin::{Limits, Report, skin};
use cosplat_splat::{Axes, Similarity, Splats};
use nalgebra::{Matrix3, Quaternion, Rotation3, UnitQuaternion, Vector3};
use proptest::prelude::*;

fn rotation_of(q: [f32; 4]) -> Matrix3<f64> {
    let [w, x, y, z] = q.map(f64::from);
    UnitQuaternion::from_quaternion(Quaternion::new(w, x, y, z)).to_rotation_matrix().into_inner()
}

fn covariance(s: &Splats, i: usize) -> Matrix3<f64> {
    let m = rotation_of(s.rotations[i]) * Matrix3::from_diagonal(&Vector3::from(s.scales(i)));
    m * m.transpose()
}

fn wide(p: [f32; 3]) -> Vector3<f64> {
    Vector3::from(p.map(f64::from))
}

fn some_rotation(r: &mut Random) -> Matrix3<f64> {
    Rotation3::from_euler_angles(r.between(-3.0, 3.0), r.between(-1.5, 1.5), r.between(-3.0, 3.0)).into_inner()
}

fn some_matrix(r: &mut Random, size: f64) -> Matrix3<f64> {
    Matrix3::from_fn(|_, _| r.between(-size, size))
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(256) })]

    /// Σ' = F Σ Fᵀ, symmetric and positive definite, the product of the scales times |det F|: also for reflections and
    /// nearly singular maps.
    #[test]
    fn covariance_is_pushed_forward(seed in any::<u64>(), kind in 0..5) {
        let mut r = Random::new(seed);
        let splats = some_splats(4, 2, seed);
        let f = match kind {
            0 => some_rotation(&mut r),
            1 => Matrix3::new(1.0, 3.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0),
            2 => some_matrix(&mut r, 2.0),
            3 => -(Matrix3::identity() + some_matrix(&mut r, 0.2)),
            _ => some_rotation(&mut r) * Matrix3::from_diagonal(&Vector3::new(1.0, 1e-4, 2.0)),
        };
        let local = Local { displacement: Vector3::new(0.1, 0.2, 0.3), gradient: f };
        let mut out = Splats::default();
        let report = skin(&splats, |_| local, Limits::default(), &mut out);
        prop_assert_eq!(report, Report { moved: 4, ..Report::default() });
        for i in 0..4 {
            let exact = f * covariance(&splats, i) * f.transpose();
            let error = (covariance(&out, i) - exact).amax() / exact.amax();
            prop_assert!(error < 1e-5, "{} {}", kind, error);
            let volume = |s: &Splats| s.scales(i).iter().product::<f64>();
            let growth = volume(&out) / volume(&splats) / f.determinant().abs();
            prop_assert!((growth - 1.0).abs() < 1e-4, "{} {}", kind, growth);
        }
    }

    /// Any affine motion of any particles is followed by the Gaussians between them.
    #[test]
    fn affine_motion_is_reproduced(seed in any::<u64>(), with_gradients in any::<bool>()) {
        let mut r = Random::new(seed);
        let splats = some_splats(50, 0, seed);
        let rest: Vec<[f32; 3]> = (0..200).map(|_| [0; 3].map(|_| r.single(-1.2, 1.2))).collect();
        let f = some_rotation(&mut r) * (Matrix3::identity() + some_matrix(&mut r, 0.3));
        let t = Vector3::new(r.between(-5.0, 5.0), 0.3, -2.0);
        let now: Vec<[f32; 3]> = rest.iter().map(|p| (f * wide(*p) + t).map(|v| v as f32).into()).collect();
        let flat: [f32; 9] = std::array::from_fn(|k| f[(k / 3, k % 3)] as f32);
        let gradients = vec![flat; rest.len()];
        let binding = Binding::affine(&splats, &rest, 12).unwrap();
        let particles = Particles { rest: &rest, now: &now, gradients: with_gradients.then_some(&gradients[..]) };
        let locals = binding.locals(&splats, &particles).unwrap();
        let mut out = Splats::default();
        skin(&splats, locals, Limits::default(), &mut out);
        for i in 0..splats.len() {
            let exact = f * wide(splats.positions[i]) + t;
            // Positions of particles are rounded to 2⁻²¹ of a unit at this distance.
            prop_assert!((wide(out.positions[i]) - exact).amax() < 4e-6, "{}", (wide(out.positions[i]) - exact).amax());
            let sigma = f * covariance(&splats, i) * f.transpose();
            prop_assert!((covariance(&out, i) - sigma).amax() < 1e-4 * sigma.amax());
        }
    }

    #[test]
    fn a_similarity_and_its_inverse_cancel(seed in any::<u64>(), degree in 0_u8..=3) {
        let mut r = Random::new(seed);
        let map = Similarity { scale: r.between(0.1, 10.0), rotation: some_rotation(&mut r), translation: Vector3::new(1.0, 2.0, 3.0) };
        let splats = some_splats(3, degree, seed);
        let mut there = splats.clone();
        map.apply(&mut there, Axes::Scene);
        for i in 0..3 {
            prop_assert!((wide(there.positions[i]) - map.point(wide(splats.positions[i]))).amax() < 2e-6);
            let exact = map.rotation * covariance(&splats, i) * map.rotation.transpose() * map.scale.powi(2);
            prop_assert!((covariance(&there, i) - exact).amax() < 1e-5 * exact.amax());
        }
        map.inverse().apply(&mut there, Axes::Rdf);
        for i in 0..3 {
            prop_assert!((wide(there.positions[i]) - wide(splats.positions[i])).amax() < 1e-5);
            prop_assert!((covariance(&there, i) - covariance(&splats, i)).amax() < 1e-5 * covariance(&splats, i).amax());
        }
        for (a, b) in there.sh_rest.iter().flatten().zip(splats.sh_rest.iter().flatten()) {
            prop_assert!((a - b).abs() < 1e-6);
        }
    }
}

#[test]
fn up_axes_become_z() {
    let ups = [
        [0.0, -1.0, 0.0],
        [0.0, 1.0, 0.0],
        [1.0, 0.0, 0.0],
        [-1.0, 0.0, 0.0],
        [0.0, 0.0, 1.0],
        [0.0, 0.0, -1.0],
        [0.2, -3.0, 0.1],
    ];
    for up in ups {
        let map = Similarity::upright(up, 0.5).unwrap();
        let image = map.rotation * Vector3::from(up).normalize();
        assert!((image - Vector3::z()).amax() < 1e-15, "{up:?} {image}");
        assert!((map.rotation.determinant() - 1.0).abs() < 1e-14);
    }
    assert_eq!(
        Similarity::upright([0.0, -1.0, 0.0], 1.0).unwrap().point(Vector3::new(1.0, 2.0, 3.0)),
        Vector3::new(1.0, 3.0, -2.0)
    );
    assert!(Similarity::upright([0.0; 3], 1.0).is_err() && Similarity::upright([0.0, 1.0, 0.0], 0.0).is_err());
}

#[test]
fn what_does_not_move_keeps_its_bits() {
    let mut splats = some_splats(3000, 3, 9);
    splats.rotations[5] = [0.0; 4];
    splats.positions[6][0] = -0.0;
    let rest: Vec<[f32; 3]> = some_splats(500, 0, 4).positions;
    let mut now = rest.clone();
    let binding = Binding::affine(&splats, &rest, 12).unwrap();
    let still = Particles { rest: &rest, now: &now, gradients: None };
    let mut out = Splats::default();
    let report = skin(&splats, binding.locals(&splats, &still).unwrap(), Limits::default(), &mut out);
    assert_eq!((report.unmoved, report.moved), (3000, 0));
    assert_eq!(out, splats);
    // A translation changes positions only.
    for p in &mut now {
        p[2] += 1.0;
    }
    let rest_on_grid: Vec<[f32; 3]> = rest.iter().map(|p| p.map(|v| (v * 1024.0).round() / 1024.0)).collect();
    let now_on_grid: Vec<[f32; 3]> = rest_on_grid.iter().map(|p| [p[0], p[1], p[2] + 1.0]).collect();
    let binding = Binding::affine(&splats, &rest_on_grid, 12).unwrap();
    let shifted = Particles { rest: &rest_on_grid, now: &now_on_grid, gradients: None };
    skin(&splats, binding.locals(&splats, &shifted).unwrap(), Limits::default(), &mut out);
    assert_eq!(
        (&out.rotations, &out.log_scales, &out.sh_rest),
        (&splats.rotations, &splats.log_scales, &splats.sh_rest)
    );
    assert!(out.positions.iter().zip(&splats.positions).all(|(a, b)| a[0] == b[0] && a[2] == b[2] + 1.0));
    // Moving one particle moves the Gaussians around it and no other.
    let mut one = rest.clone();
    one[0][0] += 0.1;
    let binding = Binding::affine(&splats, &rest, 12).unwrap();
    let moved = Particles { rest: &rest, now: &one, gradients: None };
    let report = skin(&splats, binding.locals(&splats, &moved).unwrap(), Limits::default(), &mut out);
    assert!(report.moved > 20 && report.unmoved > 2500, "{report:?}");
}

#[test]
fn a_sheet_of_particles_carries_gaussians_rigidly() {
    let rest: Vec<[f32; 3]> = (0..100).map(|i| [(i % 10) as f32 * 0.1, (i / 10) as f32 * 0.1, 0.0]).collect();
    let splats = Splats { positions: vec![[0.42, 0.37, 0.01], [0.1, 0.9, -0.02]], ..some_splats(2, 1, 3) };
    let splats = Splats { extras: Vec::new(), ..splats };
    let turn = Rotation3::from_euler_angles(1.0, -0.7, 2.0).into_inner();
    let now: Vec<[f32; 3]> = rest.iter().map(|p| (turn * wide(*p)).map(|v| v as f32).into()).collect();
    let binding = Binding::affine(&splats, &rest, 12).unwrap();
    let Binding::Affine(affine) = &binding else { unreachable!() };
    assert_eq!(affine.flat(), 2);
    let particles = Particles { rest: &rest, now: &now, gradients: None };
    let mut out = Splats::default();
    skin(&splats, binding.locals(&splats, &particles).unwrap(), Limits::default(), &mut out);
    for i in 0..2 {
        assert!((wide(out.positions[i]) - turn * wide(splats.positions[i])).amax() < 1e-6);
        let exact = turn * covariance(&splats, i) * turn.transpose();
        assert!((covariance(&out, i) - exact).amax() < 1e-5 * exact.amax());
    }
}

#[test]
fn frames_and_particles_agree_on_a_rigid_motion() {
    let splats = some_splats(40, 3, 8);
    let frame = Frame {
        rotation: Rotation3::from_euler_angles(0.4, 1.0, -2.0).into_inner(),
        translation: Vector3::new(1.0, 2.0, 3.0),
    };
    let mut rigid = Splats::default();
    skin(&splats, |i| frame.local(splats.positions[i]), Limits::default(), &mut rigid);
    let flat: [f32; 9] = std::array::from_fn(|k| frame.rotation[(k / 3, k % 3)] as f32);
    let now: Vec<[f32; 3]> = splats
        .positions
        .iter()
        .map(|p| (frame.rotation * wide(*p) + frame.translation).map(|v| v as f32).into())
        .collect();
    let gradients = vec![flat; 40];
    let particles = Particles { rest: &splats.positions, now: &now, gradients: Some(&gradients) };
    let binding = Binding::OneToOne((0..40).collect());
    let mut bound = Splats::default();
    skin(&splats, binding.locals(&splats, &particles).unwrap(), Limits::default(), &mut bound);
    for i in 0..40 {
        assert!((wide(rigid.positions[i]) - wide(bound.positions[i])).amax() < 1e-6);
        assert!((covariance(&rigid, i) - covariance(&bound, i)).amax() < 1e-5 * covariance(&rigid, i).amax());
    }
    let scales = |s: &Splats| s.log_scales.iter().flatten().map(|v| f64::from(*v)).collect::<Vec<_>>();
    assert!(scales(&rigid).iter().zip(scales(&splats)).all(|(a, b)| (a - b).abs() < 1e-6), "axes are not mixed");
}

#[test]
fn stretch_is_held_and_lost_maps_are_counted() {
    let splats = some_splats(2, 0, 2);
    let stretch = Local { displacement: Vector3::zeros(), gradient: Matrix3::identity() * 100.0 };
    let broken = Local { displacement: Vector3::zeros(), gradient: Matrix3::repeat(f64::NAN) };
    let mut out = Splats::default();
    let report = skin(
        &splats,
        |i| if i == 0 { stretch } else { broken },
        Limits { stretch: Some(4.0), ..Limits::default() },
        &mut out,
    );
    assert_eq!(report, Report { moved: 1, held: 1, lost: 1, unmoved: 0 });
    let largest = |s: &Splats| s.scales(0).into_iter().fold(0.0, f64::max);
    assert!(largest(&out) <= 4.0001 * largest(&splats));
    assert_eq!(out.positions[1], splats.positions[1]);
}

#[test]
fn bindings_that_cannot_work_are_refused() {
    let splats = some_splats(3, 0, 1);
    assert!(Binding::affine(&splats, &[], 12).is_err());
    assert!(Binding::affine(&splats, &[[f32::NAN; 3]], 12).is_err());
    let one = [[0.0; 3]];
    let binding = Binding::affine(&splats, &one, 12).unwrap();
    let two = [[0.0; 3]; 2];
    assert!(binding.locals(&splats, &Particles { rest: &two, now: &two, gradients: None }).is_err());
    let moved = [[1.0, 0.0, 0.0]];
    let particles = Particles { rest: &one, now: &moved, gradients: None };
    let mut out = Splats::default();
    skin(&splats, binding.locals(&splats, &particles).unwrap(), Limits::default(), &mut out);
    assert_eq!(out.rotations, splats.rotations);
    assert!(Binding::OneToOne(vec![0, 1, 0]).locals(&splats, &particles).is_err());
}

#[test]
fn every_number_of_threads_gives_the_same_bytes() {
    let splats = some_splats(5000, 2, 21);
    let rest: Vec<[f32; 3]> = some_splats(800, 0, 22).positions;
    let now: Vec<[f32; 3]> = rest.iter().map(|p| [p[0] + 0.1 * p[1] * p[2], p[1].sin(), p[2] * 1.1]).collect();
    let run = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let binding = Binding::affine(&splats, &rest, 12).unwrap();
            let particles = Particles { rest: &rest, now: &now, gradients: None };
            let mut out = Splats::default();
            skin(&splats, binding.locals(&splats, &particles).unwrap(), Limits::default(), &mut out);
            let filling = cosplat_splat::fill::fill(&splats, &cosplat_splat::fill::Settings::new(0.1)).unwrap();
            (out, binding, filling)
        })
    };
    let one = run(1);
    for threads in [2, 5] {
        assert_eq!(run(threads), one, "{threads} threads");
    }
}

/// Half of a block flies off: no Gaussian is left between the halves, and none is drawn out to a needle.
#[test]
fn torn_material_parts() {
    let splats = some_splats(4000, 0, 12);
    let rest: Vec<[f32; 3]> =
        (0..8000).map(|n| [n % 20, n / 20 % 20, n / 400].map(|k| (k as f32 + 0.5) / 10.0 - 1.0)).collect();
    let now: Vec<[f32; 3]> = rest.iter().map(|p| [p[0], p[1], if p[2] > 0.0 { p[2] + 3.0 } else { p[2] }]).collect();
    let binding = Binding::affine(&splats, &rest, 12).unwrap();
    let particles = Particles { rest: &rest, now: &now, gradients: None };
    let mut out = Splats::default();
    let report = skin(&splats, binding.locals(&splats, &particles).unwrap(), Limits::default(), &mut out);
    assert!(report.moved > 1500 && report.lost == 0);
    let between = out.positions.iter().filter(|p| p[2] > 1.2 && p[2] < 1.8).count();
    let longest =
        |i: usize| out.scales(i).into_iter().fold(0.0, f64::max) / splats.scales(i).into_iter().fold(0.0, f64::max);
    let stretched = (0..splats.len()).filter(|&i| longest(i) > 2.0).count();
    println!("torn: {between} of {} between, {stretched} stretched", splats.len());
    assert_eq!((between, stretched), (0, 0));
}
