//! Samples, distances and particles of surfaces whose measures are known.

mod common;

use common::{Random, brick, torus};
use cosplat_core::asset::TriangleMesh;
use cosplat_mesh::{Fault, Prepared, SignedDistance, fill, surface_samples};
use nalgebra::Vector3;

fn welded(mesh: TriangleMesh) -> TriangleMesh {
    Prepared::from_mesh(mesh).expect("it is a mesh").mesh
}

/// How often a closed surface winds around a point, from the solid angles of its triangles (Van Oosterom & Strackee
/// 1983): exact, and independent of nearest points.
fn winding(mesh: &TriangleMesh, p: Vector3<f64>) -> f64 {
    let angle = |t: &[u32; 3]| {
        let [a, b, c] = mesh.corners(*t).map(|v| v - p);
        let (x, y, z) = (a.norm(), b.norm(), c.norm());
        let below = x * y * z + a.dot(&b) * z + b.dot(&c) * x + c.dot(&a) * y;
        2.0 * a.dot(&b.cross(&c)).atan2(below)
    };
    mesh.triangles.iter().map(angle).sum::<f64>() / (4.0 * std::f64::consts::PI)
}

#[test]
fn samples_cover_the_surface_evenly_and_share_its_area() {
    for (name, mesh, spacing) in
        [("torus", torus(1.0, 0.4, 96, 48), 0.05), ("brick", brick([0.0; 3], [1.0, 0.5, 0.02]), 0.025)]
    {
        let found = Prepared::from_mesh(mesh).unwrap();
        let (mesh, area) = (found.mesh, found.report.area_m2);
        let samples = surface_samples(&mesh, spacing).unwrap();
        assert_eq!(samples, surface_samples(&mesh, spacing).unwrap());
        let n = samples.position_m.len();
        assert_eq!(n, (area / (spacing * spacing)).ceil() as usize);
        // A sum of so many numbers of one size: n times the rounding of one.
        assert!((samples.area_m2.iter().sum::<f64>() / area - 1.0).abs() < 1e-12);
        let points: Vec<Vector3<f64>> = samples.position_m.iter().map(|p| Vector3::from(*p)).collect();
        let normals: Vec<Vector3<f64>> = samples.normal.iter().map(|p| Vector3::from(*p)).collect();
        // Only samples on one side count: the brick is thinner than the spacing.
        let nearest = |i: usize| {
            let others = (0..n).filter(|&j| j != i && normals[i].dot(&normals[j]) > 0.0);
            others.map(|j| (points[i] - points[j]).norm()).fold(f64::INFINITY, f64::min)
        };
        let closest = (0..n).map(nearest).fold(f64::INFINITY, f64::min) / spacing;
        let closed: Vector3<f64> = (0..n).map(|i| normals[i] * samples.area_m2[i]).sum();
        let largest = samples.area_m2.iter().copied().fold(0.0, f64::max) / (spacing * spacing);
        println!(
            "{name}: {n} samples, nearest two {closest:.2} spacings, largest share {largest:.2}, Σ a n {:.1e} of the area",
            closed.norm() / area
        );
        // A hexagonal lattice would have √(2/√3) = 1.07; elimination from five times as many reaches 0.6 to 0.7 of it.
        assert!(closest > 0.55, "{closest}");
        // A gap with a radius of 1.07 spacings would have been filled, so a share is at most π 1.07² = 3.6, give or take
        // the root of the 18 fifths in which it is counted.
        assert!(largest < 4.5, "{largest}");
        // Σ a n = 0 over a closed surface; shares are counted in fifths of a spacing², a random error of √n of them.
        assert!(closed.norm() / area < 1.0 / (n as f64).sqrt(), "{}", closed.norm() / area);
        if name == "torus" {
            let outward = |i: usize| {
                let ring = Vector3::new(points[i].x, points[i].y, 0.0).normalize();
                normals[i].dot(&(points[i] - ring)) > 0.0
            };
            assert!((0..n).all(outward));
        }
    }
}

#[test]
fn distances_from_a_brick_are_exact() {
    let size = [0.4, 0.3, 0.2];
    let at = [5.0, -3.0, 2.0];
    let distance = SignedDistance::new(&welded(brick(at, size))).unwrap();
    let mut random = Random(7);
    for _ in 0..4000 {
        let p = [0, 1, 2].map(|k| at[k] + size[k] * random.between(-1.0, 2.0));
        let beyond = Vector3::from_fn(|k, _| (p[k] - at[k] - size[k] / 2.0).abs() - size[k] / 2.0);
        let exact = beyond.sup(&Vector3::zeros()).norm() + beyond.max().min(0.0);
        // Single precision in a frame in which the largest edge is 1: some 6e-8 of 0.4 m in each of a few operations.
        assert!((distance.at(p) - exact).abs() < 4e-7 * 0.4 * 3.0, "{p:?} {exact} {}", distance.at(p));
    }
}

#[test]
fn the_sign_is_that_of_the_winding_number() {
    // Thin triangles with sharp edges: the nearest point lies on an edge or a vertex most of the time.
    let mesh = welded(torus(1.0, 0.4, 12, 5));
    let distance = SignedDistance::new(&mesh).unwrap();
    let mut random = Random(3);
    let mut inside = 0;
    for _ in 0..20_000 {
        let p = [random.between(-1.6, 1.6), random.between(-1.6, 1.6), random.between(-0.6, 0.6)];
        let (d, w) = (distance.at(p), winding(&mesh, Vector3::from(p)));
        // Nearer than the precision of the distance the sign is open.
        if d.abs() > 1e-6 {
            assert_eq!(d < 0.0, w > 0.5, "{p:?} {d} {w}");
            inside += usize::from(d < 0.0);
        }
    }
    assert!(inside > 3000);
}

#[test]
fn particles_share_the_volume_of_the_solid() {
    for (name, mesh, spacing) in
        [("torus", torus(1.0, 0.4, 96, 48), 0.05), ("brick", brick([0.01, 0.02, 0.03], [0.4, 0.3, 0.2]), 0.02)]
    {
        let mesh = welded(mesh);
        let solid = mesh.solid().unwrap();
        let cloud = fill(&mesh, spacing).unwrap();
        let volume: f64 = cloud.volume_m3.iter().sum();
        let each = cloud.volume_m3[0] / spacing.powi(3);
        println!("{name}: {} particles of {each:.4} h³", cloud.position_m.len());
        // A sum of so many equal numbers.
        assert!((volume / solid.volume_m3 - 1.0).abs() < 1e-11);
        // The lattice misses by up to half a spacing at each side: 3 faces of the brick, some part of that for curves.
        assert!((each - 1.0).abs() < 0.1, "{each}");
        let distance = SignedDistance::new(&mesh).unwrap();
        assert!(cloud.position_m.iter().all(|p| distance.at(*p) < 0.0));
        let pool = rayon::ThreadPoolBuilder::new().num_threads(3).build().unwrap();
        assert_eq!(pool.install(|| fill(&mesh, spacing)).unwrap(), cloud);
    }
}

#[test]
fn what_is_no_solid_is_refused() {
    let mut open = welded(brick([0.0; 3], [1.0; 3]));
    open.triangles.pop();
    let error = fill(&open, 0.1).unwrap_err();
    assert!(error.fault == Fault::Open && error.advice.contains("close the mesh"), "{error}");
    assert!(SignedDistance::new(&open).is_err());
    // A surface that is open can be sampled all the same.
    assert!(surface_samples(&open, 0.1).is_ok());
    let brick = welded(brick([0.0; 3], [1.0; 3]));
    for spacing in [0.0, -1.0, f64::NAN, 1e-4, 1e3] {
        assert_eq!(fill(&brick, spacing).unwrap_err().fault, Fault::Spacing, "{spacing}");
    }
    for spacing in [0.0, f64::NAN, 1e-6] {
        assert_eq!(surface_samples(&brick, spacing).unwrap_err().fault, Fault::Spacing, "{spacing}");
    }
}
