//! Gaussians of bodies that were never captured: their light, their grain, their shape.

mod common;

use common::covariance;
use cosplat_splat::bind::Frame;
use cosplat_splat::surfel::{
    Fabric, Light, MeshSurfels, Sample, colour_by_vertices, dots, fabric, grained, linear_of_display, lit, topological,
};
use cosplat_splat::{Axes, OutputFrame, SH_C0, Similarity, Splats};
use nalgebra::{Matrix3, Vector3};

#[test]
fn light_falls_from_where_it_comes_and_stays_there() {
    let light = Light { towards: [0.0, 0.0, 2.0], ambient: 0.25 };
    let up = grained(&[[0.0; 3]], &[[0.0, 0.0, 1.0]], &[1e-4], [0.5; 3], 0.0);
    let colour = |s: &Splats| {
        let display = 0.5 + SH_C0 * f64::from(s.sh_dc[0][0]);
        linear_of_display(display)
    };
    let world = OutputFrame::world();
    // Single precision of a colour.
    assert!((colour(&lit(&up, &Frame::identity(), &light, &world)) - 0.5).abs() < 1e-6);
    let over = Frame::of_pose([0.0; 3], [1.0, 0.0, 0.0, 0.0]).unwrap();
    assert!((colour(&lit(&up, &over, &light, &world)) - 0.5 * 0.25).abs() < 1e-6);
    // Grain stays within its share and has no preferred side.
    let many: Vec<[f64; 3]> = (0..4000)
        .map(|i| [0.01 * f64::from(i % 20), 0.01 * f64::from(i / 20 % 20), 0.01 * f64::from(i / 400)])
        .collect();
    let n = many.len();
    let stone = grained(&many, &vec![[0.0, 0.0, 1.0]; n], &vec![1e-4; n], [0.3; 3], 0.3);
    let linear: Vec<f64> = stone.iter().map(|s| linear_of_display(f64::from(s.colour[0]))).collect();
    let mean = linear.iter().sum::<f64>() / n as f64;
    assert!(linear.iter().all(|c| (c / 0.3 - 1.0).abs() <= 0.3 + 1e-6) && (mean / 0.3 - 1.0).abs() < 0.1, "{mean}");
    assert!(linear.iter().any(|c| (c / 0.3 - 1.0).abs() > 0.1));
}

#[test]
fn dots_follow_their_gradients() {
    let stretch = [2.0, 0.0, 0.0, 0.0, 0.5, 0.0, 0.0, 0.0, 1.0_f32];
    let world = OutputFrame::world();
    let found = dots(&[[1.0, 2.0, 3.0]; 2], &[stretch, [f32::NAN; 9]], 0.1, [0.5; 3], &world).unwrap();
    let sigma = covariance(&found, 0);
    let expected = Matrix3::from_diagonal(&Vector3::new(0.1 * 0.1, 0.025 * 0.025, 0.05 * 0.05));
    assert!((sigma - expected).amax() < 1e-6 * 0.01);
    assert!((covariance(&found, 1) - Matrix3::identity() * 0.0025).amax() < 1e-8);
    assert!(dots(&[[0.0; 3]], &[stretch; 2], 0.1, [0.5; 3], &world).is_err());
}

/// A flat sheet of squares of edge `h`, stretched along x, with diagonals of alternating direction.
fn sheet(n: u32, h: f64, stretch: f64) -> (Vec<[f64; 3]>, Fabric) {
    let at = |i: u32, j: u32| j * n + i;
    let place = |i: u32, j: u32| [stretch * h * f64::from(i), h * f64::from(j), 0.0];
    let positions: Vec<[f64; 3]> = (0..n).flat_map(|j| (0..n).map(move |i| place(i, j))).collect();
    let mut triangles = Vec::new();
    for (i, j) in (0..n - 1).flat_map(|j| (0..n - 1).map(move |i| (i, j))) {
        let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
        triangles.extend(if (i + j) % 2 == 0 { [[a, b, c], [a, c, d]] } else { [[a, b, d], [b, c, d]] });
    }
    let colours = vec![[0.5; 3]; positions.len()];
    (positions, Fabric { triangles, colours })
}

#[test]
fn cloth_is_closed_and_stretches_with_its_triangles() {
    let (light, world) = (Light::default(), OutputFrame::world());
    let (h, n) = (0.01, 9);
    for stretch in [1.0, 1.5] {
        let (positions, cloth) = sheet(n, h, stretch);
        let found = fabric(&positions, &cloth, &light, &world).unwrap();
        for (i, valence, mean_square) in [(4 * n + 4, 8, h * h / 3.0), (4 * n + 5, 4, h * h / 6.0)] {
            let touching = cloth.triangles.iter().filter(|t| t.contains(&i)).count();
            assert_eq!(touching, valence);
            let sigma = covariance(&found, i as usize);
            let wanted = [1.44 * mean_square * stretch * stretch, 1.44 * mean_square];
            // Single precision of logarithms of standard deviations, and of quaternions.
            assert!((sigma[(0, 0)] / wanted[0] - 1.0).abs() < 1e-5 && (sigma[(1, 1)] / wanted[1] - 1.0).abs() < 1e-5);
            assert!(sigma[(0, 1)].abs() < 1e-5 * wanted[0] && sigma[(2, 2)] < 0.02 * wanted[1], "{sigma}");
        }
        // What passes between the vertices, seen along the normal.
        let clear = |x: f64, y: f64| {
            let through = |i: usize| {
                let d = [x - f64::from(found.positions[i][0]), y - f64::from(found.positions[i][1])];
                let flat = covariance(&found, i).fixed_view::<2, 2>(0, 0).into_owned();
                let d = nalgebra::Vector2::from(d);
                let power = flat.try_inverse().map_or(f64::INFINITY, |inverse| d.dot(&(inverse * d)));
                1.0 - 0.99 * (-0.5 * power).exp()
            };
            (0..positions.len()).map(through).product::<f64>()
        };
        let between = |k: u32| 4.0 * h + h * f64::from(k) / 4.0;
        let worst = (0..16).map(|k| clear(stretch * between(k % 4), between(k / 4))).fold(0.0, f64::max);
        // A square lattice of the surfels of other surfaces, 0.6 of its spacing wide, lets through in the middle of four
        // Π (1 − 0.99 exp(−d² / 0.72)) with d² = 0.5, 2.5, 4.5, 6.5 for 4, 8, 4, 8 of them: 5.05 %. The sum of the
        // exponents is nearly the same for two sizes that share the same area.
        let lattice = [(0.5, 4), (2.5, 8), (4.5, 4), (6.5, 8)]
            .map(|(d2, n): (f64, i32)| (1.0 - 0.99 * (-d2 / 0.72).exp()).powi(n));
        assert!(worst < 1.1 * lattice.iter().product::<f64>(), "{worst}");
    }
}

#[test]
fn cloth_is_lit_from_both_sides_and_bears_what_has_no_area() {
    let light = Light { towards: [0.0, 0.0, 1.0], ambient: 0.25 };
    let world = OutputFrame::world();
    let (positions, cloth) = sheet(3, 0.1, 1.0);
    let turned = Fabric { triangles: cloth.triangles.iter().map(|&[a, b, c]| [a, c, b]).collect(), ..cloth.clone() };
    let colour = |f: &Fabric| fabric(&positions, f, &light, &world).unwrap().sh_dc;
    assert_eq!(colour(&cloth), colour(&turned));
    let flat = vec![[1.0; 3]; positions.len()];
    let none = fabric(&flat, &cloth, &light, &world).unwrap();
    assert!(none.log_scales.iter().flatten().chain(none.rotations.iter().flatten()).all(|v| v.is_finite()));
    assert!(fabric(&positions[1..], &cloth, &light, &world).is_err());
    let wild = Fabric { triangles: vec![[0, 1, 99]], ..cloth };
    assert!(fabric(&positions, &wild, &light, &world).is_err());
}

#[test]
fn a_mesh_becomes_surfels_with_its_edges() {
    let (positions, mut mesh) = sheet(5, 0.1, 1.0);
    mesh.colours[7] = [1.0, 0.25, 0.0];
    let surfels = topological(&positions, &mesh, &OutputFrame::world()).unwrap();
    assert_eq!(surfels.len(), 25);
    // The colour that the mesh has, by the curve of displays and back, in single precision.
    let colour = surfels.sh_dc[7].map(|c| 0.5 + SH_C0 * f64::from(c));
    assert!(colour.iter().zip([1.0, 0.25, 0.0]).all(|(c, wanted)| (c - wanted).abs() < 1e-6), "{colour:?}");
    // Euler: V − E + F = 1 for a sheet of 25 vertices and 32 triangles.
    let edges = mesh.edges();
    assert_eq!((edges.len(), edges[0]), (56, [0, 1]));
    assert!(edges.is_sorted() && edges.iter().all(|[a, b]| a < b));
    // All normals along z: the shortest axis of each.
    for i in 0..25 {
        assert!(covariance(&surfels, i)[(2, 2)] < 0.02 * covariance(&surfels, i)[(0, 0)]);
    }
}

/// Vertices of a sheet follow particles that are not its vertices, here those of a lattice around it, through a turn and a
/// stretch: affine motion is followed exactly, so each surfel is where that of the turned and stretched sheet itself is.
#[test]
fn surfels_of_vertices_and_triangles_follow_particles_that_are_neither() {
    let (light, world) = (Light::default(), OutputFrame::world());
    let (positions, cloth) = sheet(9, 0.01, 1.0);
    let pose = Frame::of_pose([0.1, -0.2, 0.3], [0.0, 0.0, 0.382_683_43, 0.923_879_53]).unwrap();
    let around: Vec<[f64; 3]> = (0..6 * 6 * 4)
        .map(|i| {
            [0.018 * f64::from(i % 6) - 0.005, 0.018 * f64::from(i / 6 % 6) - 0.005, 0.01 * f64::from(i / 36) - 0.015]
        })
        .map(|p| pose.point(Vector3::from(p)).into())
        .collect();
    let stretch = Matrix3::new(1.3, 0.2, 0.0, 0.0, 0.9, 0.1, 0.1, 0.0, 1.0);
    let map = |p: &[f64; 3]| <[f64; 3]>::from(stretch * Vector3::from(*p) + Vector3::new(0.0, 0.5, 0.0));
    let now: Vec<[f64; 3]> = around.iter().map(map).collect();
    let on_vertices = MeshSurfels::on_vertices(positions.clone(), cloth.clone(), false).unwrap();
    let samples: Vec<Sample> = grained(&positions[..40], &[[0.0, 0.0, 1.0]; 40], &[1e-4; 40], [0.5; 3], 0.0);
    let on_triangles = on_vertices.clone().on_triangles(samples).unwrap();
    assert_eq!((on_vertices.gaussians(), on_triangles.gaussians()), (81, 40));
    for mesh in [&on_vertices, &on_triangles] {
        let worn = mesh.worn(&pose, &around, 12).unwrap();
        let moved = worn.vertices(&now).unwrap();
        let wanted: Vec<[f64; 3]> = mesh.posed(&pose).iter().map(map).collect();
        let gap = |(p, q): (&[f64; 3], &[f64; 3])| (Vector3::from(*p) - Vector3::from(*q)).norm();
        // Particles in single precision around 1 m, over neighbours 2 cm apart.
        assert!(moved.iter().zip(&wanted).map(gap).fold(0.0, f64::max) < 2e-6);
        let [found, expected] = [&moved, &wanted].map(|v| mesh.drawn(v, &light, &world).unwrap());
        for i in 0..mesh.gaussians() {
            let sigma = covariance(&expected, i);
            assert!((covariance(&found, i) - sigma).amax() < 2e-3 * sigma.amax());
            assert!((found.sh_dc[i][0] - expected.sh_dc[i][0]).abs() < 1e-2);
        }
        assert!(worn.vertices(&now[1..]).is_err() && mesh.drawn(&wanted[1..], &light, &world).is_err());
    }
    // Particles that are the vertices are followed to the last bit.
    let own = on_vertices.posed(&pose);
    let worn = on_vertices.worn(&pose, &own, 12).unwrap();
    let moved: Vec<[f64; 3]> = own.iter().map(map).collect();
    assert_eq!(worn.vertices(&moved).unwrap(), moved);
}

/// A closed mesh is dark inside: only the side towards the lamp is bright.
#[test]
fn a_mesh_wears_a_capture_as_a_pose_would_carry_it() {
    let (positions, cloth) = sheet(9, 0.01, 1.0);
    let mut capture = Splats { axes: Axes::Scene, ..common::some_splats(200, 3, 5) };
    for (i, place) in capture.positions.iter_mut().enumerate() {
        // Over the sheet and beyond its rim, up to three millimetres off it.
        let part = |k: usize| ((i * k) % 97) as f32 / 97.0;
        *place = [0.1 * part(31) - 0.01, 0.1 * part(53) - 0.01, 0.006 * part(71) - 0.003];
    }
    let mesh = MeshSurfels::on_vertices(positions, cloth, false).unwrap().wearing(capture.clone()).unwrap();
    assert_eq!(mesh.gaussians(), 200);
    let pose = Frame::of_pose([0.3, -0.2, 1.0], [0.1, 0.4, -0.2, 0.9]).unwrap();
    let found = mesh.drawn(&mesh.posed(&pose), &Light::default(), &OutputFrame::world()).unwrap();
    let rest = capture.positions.clone();
    let mut wanted = capture;
    Similarity::from(pose).apply(&mut wanted, Axes::Scene);
    assert_eq!(found.sh_dc, wanted.sh_dc, "its light is its own");
    for i in 0..200 {
        let gap = (0..3).map(|k| (found.positions[i][k] - wanted.positions[i][k]).abs()).fold(0.0, f32::max);
        let sigma = covariance(&wanted, i);
        // Vertices in single precision around 1 m, over triangles of 1 cm: a turn is known to 1e-5.
        assert!(gap < 1e-6 && (covariance(&found, i) - sigma).amax() < 1e-4 * sigma.amax(), "{i}: {gap}");
        let bands = found.rest(i).iter().flatten().zip(wanted.rest(i).iter().flatten());
        assert!(bands.map(|(a, b)| (a - b).abs()).fold(0.0, f32::max) < 1e-4, "{i}");
    }
    // A sheet that is rolled up takes them along: what lies on it stays on it.
    let rolled = |p: &[f64; 3]| [0.02 * (p[0] / 0.02).sin(), p[1], 0.02 - 0.02 * (p[0] / 0.02).cos()];
    let on_it: Vec<[f64; 3]> = mesh.vertices_m().iter().map(rolled).collect();
    let found = mesh.drawn(&on_it, &Light::default(), &OutputFrame::world()).unwrap();
    let axis = |p: &[f32; 3]| f64::from(p[0]).hypot(f64::from(p[2]) - 0.02);
    let over = |p: &[f32; 3]| p[0] > 0.0 && p[0] < 0.08;
    for (now, rest) in found.positions.iter().zip(&rest).filter(|(_, rest)| over(rest)) {
        // A chord of a centimetre lies up to h²/8R = 0.6 mm below its arc.
        assert!((axis(now) - 0.02 + f64::from(rest[2])).abs() < 1e-3, "{now:?} {rest:?}");
    }
}

#[test]
fn a_closed_mesh_is_lit_from_one_side() {
    let light = Light { towards: [0.0, 0.0, 1.0], ambient: 0.25 };
    let (positions, mut cloth) = sheet(3, 0.01, 1.0);
    cloth.triangles.iter_mut().for_each(|t| t.swap(0, 1));
    let colour = |is_closed: bool| {
        let mesh = MeshSurfels::on_vertices(positions.clone(), cloth.clone(), is_closed).unwrap();
        let splats = mesh.drawn(&positions, &light, &OutputFrame::world()).unwrap();
        linear_of_display(0.5 + SH_C0 * f64::from(splats.sh_dc[4][0]))
    };
    // Single precision of a colour.
    assert!((colour(true) / colour(false) - 0.25).abs() < 1e-5);
}

#[test]
fn samples_take_the_colours_of_the_vertices_around_them() {
    let (positions, cloth) = sheet(2, 1.0, 1.0);
    let linear: Vec<[f32; 3]> = positions.iter().map(|p| [p[0] as f32, p[1] as f32, 0.25]).collect();
    let mut samples = grained(&[[0.25, 0.5, 0.0], [1.0, 1.0, 0.1]], &[[0.0, 0.0, 1.0]; 2], &[1e-2; 2], [0.5; 3], 0.0);
    colour_by_vertices(&mut samples, &positions, &cloth.triangles, &linear).unwrap();
    for (sample, wanted) in samples.iter().zip([[0.25, 0.5, 0.25], [1.0, 1.0, 0.25]]) {
        for (found, wanted) in sample.colour.into_iter().zip(wanted) {
            // A linear colour is reproduced by linear interpolation, to single precision.
            assert!((linear_of_display(f64::from(found)) - wanted).abs() < 1e-6);
        }
    }
    assert!(colour_by_vertices(&mut samples, &positions, &cloth.triangles, &linear[1..]).is_err());
}
