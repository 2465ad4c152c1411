//! Triangle meshes of boxes, spheres, cylinders and planes, to be drawn.

use std::f64::consts::{PI, TAU};

use cosplat_core::asset::TriangleMesh;
use cosplat_core::scene::Source;

/// Corners around a sphere or cylinder: the polygon's edge lies 0.5 % of the radius inside the circle.
const AROUND: u32 = 32;
/// Rings of a sphere from pole to pole.
const RINGS: u32 = 16;
/// Edge of the part of an infinite plane that is drawn \[m\].
const PLANE_M: f64 = 3.0;

/// The surface of a primitive; nothing for sources without one.
pub(super) fn mesh(source: &Source) -> Option<TriangleMesh> {
    match source {
        Source::Box { size_m } => Some(cuboid(*size_m)),
        Source::Sphere { radius_m } => Some(lathe(&meridian(*radius_m))),
        Source::Cylinder { radius_m: r, height_m: h } => {
            Some(lathe(&[(0.0, -h / 2.0), (*r, -h / 2.0), (*r, h / 2.0), (0.0, h / 2.0)]))
        }
        Source::Plane { size_m } => Some(sheet(size_m.unwrap_or([PLANE_M; 2]))),
        Source::Splat { .. }
        | Source::Mesh { .. }
        | Source::HeightField { .. }
        | Source::Points { .. }
        | Source::Cloud { .. } => None,
    }
}

fn cuboid(size: [f64; 3]) -> TriangleMesh {
    let corner = |i: usize| [0, 1, 2].map(|k| size[k] * if i >> k & 1 == 1 { 0.5 } else { -0.5 });
    let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    TriangleMesh {
        vertices_m: (0..8).map(corner).collect(),
        triangles: quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect(),
    }
}

fn sheet([x, y]: [f64; 2]) -> TriangleMesh {
    let corners = [[-0.5, -0.5], [0.5, -0.5], [0.5, 0.5], [-0.5, 0.5]];
    TriangleMesh {
        vertices_m: corners.iter().map(|[u, v]| [u * x, v * y, 0.0]).collect(),
        triangles: vec![[0, 1, 2], [0, 2, 3]],
    }
}

/// Radius and height from the lower to the upper pole of a sphere.
fn meridian(radius: f64) -> Vec<(f64, f64)> {
    let ring = |i: u32| {
        let angle = PI * f64::from(i) / f64::from(RINGS);
        let r = if i == 0 || i == RINGS { 0.0 } else { radius * angle.sin() };
        (r, -radius * angle.cos())
    };
    (0..=RINGS).map(ring).collect()
}

/// A profile (radius, height) turned about z, from bottom to top; radius 0 is one point.
fn lathe(profile: &[(f64, f64)]) -> TriangleMesh {
    let mut mesh = TriangleMesh::default();
    let mut rings: Vec<Vec<u32>> = Vec::new();
    for &(radius, height) in profile {
        let first = mesh.vertices_m.len() as u32;
        let count = if radius == 0.0 { 1 } else { AROUND };
        for i in 0..count {
            let (sin, cos) = (TAU * f64::from(i) / f64::from(AROUND)).sin_cos();
            mesh.vertices_m.push([radius * cos, radius * sin, height]);
        }
        rings.push((0..AROUND).map(|i| first + i % count).collect());
    }
    for pair in rings.windows(2) {
        for i in 0..AROUND as usize {
            let j = (i + 1) % AROUND as usize;
            let (a, b, c, d) = (pair[0][i], pair[0][j], pair[1][j], pair[1][i]);
            mesh.triangles.extend([[a, b, c], [a, c, d]].into_iter().filter(|[a, b, c]| a != b && b != c && c != a));
        }
    }
    mesh
}

#[cfg(test)]
mod tests {
    use super::*;

    fn volume(source: &Source) -> f64 {
        mesh(source).unwrap().solid().unwrap().volume_m3
    }

    #[test]
    fn solids_are_closed_and_have_nearly_their_volume() {
        assert!((volume(&Source::Box { size_m: [0.2, 0.3, 0.4] }) / 0.024 - 1.0).abs() < 1e-12);
        // An inscribed polygon of n corners has sin(2π/n) / (2π/n) of the circle's area: 0.6 % less for 32.
        let polygon = (TAU / 32.0).sin() / (TAU / 32.0);
        let cylinder = volume(&Source::Cylinder { radius_m: 0.1, height_m: 0.5 }) / (PI * 0.01 * 0.5);
        assert!((cylinder / polygon - 1.0).abs() < 1e-12);
        // Chords from pole to pole cost as much again: second order in the angle of a ring, π/16.
        let sphere = volume(&Source::Sphere { radius_m: 0.1 }) / (4.0 / 3.0 * PI * 1e-3);
        assert!((0.97..polygon).contains(&sphere), "{sphere}");
    }

    #[test]
    fn a_plane_faces_up_and_points_have_no_surface() {
        let plane = mesh(&Source::Plane { size_m: Some([1.0, 2.0]) }).unwrap();
        let [a, b, c] = plane.corners(plane.triangles[0]);
        assert!((b - a).cross(&(c - a)).z > 0.0);
        assert_eq!(mesh(&Source::Points { positions_m: vec![[0.0; 3]] }), None);
    }
}
