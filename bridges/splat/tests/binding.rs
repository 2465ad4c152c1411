//! Bindings against each other: which motions each follows exactly, and by how much it misses the others.

mod common;

use common::{Random, some_splats};
use cosplat_splat::Splats;
use cosplat_splat::bind::{BindError, Binding, Particles};
use cosplat_splat::skin::{Limits, skin};
use nalgebra::{Matrix3, Rotation3, Vector3};

/// A lattice of 9³ particles in the cube of the Gaussians of [`some_splats`].
fn lattice() -> Vec<[f32; 3]> {
    (0..729).map(|i| [i % 9, i / 9 % 9, i / 81].map(|k| k as f32 / 4.0 - 1.0)).collect()
}

/// Places moved by x → A x + b.
fn moved(places: &[[f32; 3]], a: &Matrix3<f64>, b: &Vector3<f64>) -> Vec<[f32; 3]> {
    let image = |p: &[f32; 3]| (a * Vector3::from(p.map(f64::from)) + b).map(|v| v as f32).into();
    places.iter().map(image).collect()
}

/// Root mean square and largest distance of the centres from where the motion takes them.
fn error(splats: &Splats, binding: &Binding, rest: &[[f32; 3]], a: &Matrix3<f64>, b: &Vector3<f64>) -> [f64; 2] {
    let now = moved(rest, a, b);
    let particles = Particles { rest, now: &now, gradients: None };
    let mut out = Splats::default();
    let local = binding.locals(splats, &particles).expect("the lengths fit");
    skin(splats, local, Limits::default(), &mut out);
    let wanted = moved(&splats.positions, a, b);
    let gap = |(p, q): (&[f32; 3], &[f32; 3])| (0..3).map(|k| f64::from(p[k] - q[k]).powi(2)).sum::<f64>();
    let squares: Vec<f64> = out.positions.iter().zip(&wanted).map(gap).collect();
    let mean = squares.iter().sum::<f64>() / squares.len() as f64;
    [mean.sqrt(), squares.into_iter().fold(0.0, f64::max).sqrt()]
}

/// The mean of ten follows translations exactly; under a rotation by ω it misses by ω times the distance from a Gaussian to
/// the mean of its neighbours, which the affine binding does not.
#[test]
fn the_mean_of_ten_is_off_under_rotation_and_the_affine_binding_is_not() {
    let splats = some_splats(500, 0, 5);
    let rest = lattice();
    let [mean, affine] = [Binding::mean(&splats, &rest, 10).unwrap(), Binding::affine(&splats, &rest, 12).unwrap()];
    let (still, shift) = (Matrix3::identity(), Vector3::new(0.5, -2.0, 1.0));
    assert!(error(&splats, &mean, &rest, &still, &shift)[1] < 1e-6);
    let mut before = 0.0;
    for angle in [0.05, 0.1, 0.2] {
        let turn = Rotation3::from_euler_angles(0.0, 0.0, angle).into_inner();
        let [off, _] = error(&splats, &mean, &rest, &turn, &shift);
        // In single precision around 2.
        assert!(error(&splats, &affine, &rest, &turn, &shift)[1] < 2e-6);
        // A spacing of 1/4: means of ten neighbours lie some 0.06 beside a Gaussian, at the border more.
        assert!((0.02..0.3).contains(&(off / angle)), "{angle} {off}");
        // Of first order in the angle, to the second order of 1 − cos.
        assert!(before == 0.0 || (off / before - 2.0).abs() < 0.02, "{off} {before}");
        before = off;
    }
}

/// A mesh of 20 × 20 squares, each two triangles, in the plane z = 0 from −1 to 1.
fn mesh() -> (Vec<[f32; 3]>, Vec<[u32; 3]>) {
    let vertices = (0..441).map(|i| [(i % 21) as f32 / 10.0 - 1.0, (i / 21) as f32 / 10.0 - 1.0, 0.0]).collect();
    let square = |i: u32| {
        let a = i % 20 + i / 20 * 21;
        [[a, a + 1, a + 22], [a, a + 22, a + 21]]
    };
    (vertices, (0..400).flat_map(square).collect())
}

#[test]
fn gaussians_on_triangles_follow_the_plane_exactly_and_keep_their_distance() {
    let (vertices, triangles) = mesh();
    let mut splats = some_splats(300, 1, 8);
    let mut r = Random::new(4);
    splats.positions.iter_mut().for_each(|p| p[2] = r.single(-0.02, 0.02));
    let binding = Binding::triangles(&splats, &vertices, &triangles).unwrap();
    let shift = Vector3::new(1.0, 2.0, 3.0);
    let turn = Rotation3::from_euler_angles(0.4, -0.3, 1.2).into_inner();
    // Rigid, then stretched in the plane by 1.5 and 0.8: the normal stays one.
    for a in [turn, turn * Matrix3::from_diagonal(&Vector3::new(1.5, 0.8, 1.0))] {
        assert!(error(&splats, &binding, &vertices, &a, &shift)[1] < 2e-6);
        let now = moved(&vertices, &a, &shift);
        let particles = Particles { rest: &vertices, now: &now, gradients: None };
        let local = binding.locals(&splats, &particles).unwrap();
        assert!((0..300).all(|i| (local(i).gradient - a).amax() < 1e-5));
    }
    // A fold: the Gaussians of the half that is lifted go with it.
    let lifted: Vec<[f32; 3]> = vertices.iter().map(|p| if p[0] > 0.05 { [0.0, p[1], p[0]] } else { *p }).collect();
    let particles = Particles { rest: &vertices, now: &lifted, gradients: None };
    let local = binding.locals(&splats, &particles).unwrap();
    for (i, p) in splats.positions.iter().enumerate().filter(|(_, p)| p[0] > 0.15) {
        let now = Vector3::from(p.map(f64::from)) + local(i).displacement;
        assert!((now.x + f64::from(p[2])).abs() < 1e-6 && (now.z - f64::from(p[0])).abs() < 1e-6, "{p:?} {now}");
    }
    // What nothing moved keeps its bits, and what collapsed keeps its place.
    let same = Particles { rest: &vertices, now: &vertices, gradients: None };
    let mut out = Splats::default();
    let report = skin(&splats, binding.locals(&splats, &same).unwrap(), Limits::default(), &mut out);
    assert_eq!((report.unmoved, &out), (300, &splats));
    let point = vec![[1.0; 3]; 441];
    let local = Particles { rest: &vertices, now: &point, gradients: None };
    let local = binding.locals(&splats, &local).unwrap();
    assert!(
        (0..300)
            .all(|i| local(i).displacement.iter().all(|v| v.is_finite()) && local(i).gradient == Matrix3::identity())
    );
}

#[test]
fn what_cannot_be_bound_is_refused() {
    let splats = some_splats(3, 0, 1);
    let (vertices, triangles) = mesh();
    let refusal = |binding: Result<Binding, BindError>| binding.unwrap_err();
    assert_eq!(refusal(Binding::mean(&splats, &[], 10)), BindError::NoParticles(3));
    assert_eq!(refusal(Binding::mean(&splats, &[[f32::NAN; 3]], 10)), BindError::NonFinite("particle", 0));
    assert_eq!(refusal(Binding::triangles(&splats, &vertices, &[])), BindError::NoParticles(3));
    assert_eq!(refusal(Binding::triangles(&splats, &vertices, &[[0, 1, 441]])), BindError::Index(0, 441, 441));
    let binding = Binding::triangles(&splats, &vertices, &triangles).unwrap();
    let few = Particles { rest: &vertices[..9], now: &vertices[..9], gradients: None };
    assert!(matches!(binding.locals(&splats, &few).map(|_| ()), Err(BindError::Length("particles", 441, 9))));
    // Only triangles without area: they follow the nearest vertex.
    let binding = Binding::triangles(&splats, &vertices, &[[7, 7, 7]]).unwrap();
    let all = Particles { rest: &vertices, now: &vertices, gradients: None };
    assert!((0..3).all(|i| binding.locals(&splats, &all).unwrap()(i).displacement == Vector3::zeros()));
}

/// With the gradients of an affine motion, following the nearest particle alone is as exact as following twelve.
#[test]
fn the_nearest_particle_with_its_gradient_follows_affine_motion() {
    let splats = some_splats(300, 0, 6);
    let rest = lattice();
    let binding = Binding::nearest(&splats, &rest).unwrap();
    let a = Matrix3::new(1.1, 0.2, 0.0, -0.1, 0.9, 0.3, 0.0, 0.1, 1.2);
    let b = Vector3::new(0.5, -1.0, 0.25);
    let now = moved(&rest, &a, &b);
    let rows = std::array::from_fn(|k| a[(k / 3, k % 3)] as f32);
    let gradients = vec![rows; rest.len()];
    let particles = Particles { rest: &rest, now: &now, gradients: Some(&gradients) };
    let mut out = Splats::default();
    skin(&splats, binding.locals(&splats, &particles).unwrap(), Limits::default(), &mut out);
    let wanted = moved(&splats.positions, &a, &b);
    // Single precision of numbers around 2.
    let off = out.positions.iter().flatten().zip(wanted.iter().flatten()).map(|(p, q)| (p - q).abs());
    assert!(off.fold(0.0, f32::max) < 2e-6);
    assert!(Binding::nearest(&splats, &[]).is_err());
}
