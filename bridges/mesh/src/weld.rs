//! Vertices in one place become one vertex, so that it can be seen whether a surface is closed.

use cosplat_core::asset::TriangleMesh;
use nalgebra::Vector3;

use crate::cells::Cells;

/// Vertices nearer than this fraction of the diagonal of the box are one: files print six or seven digits.
const TOLERANCE: f64 = 1e-6;

/// What welding did.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Welded {
    /// Vertices that fell together with another, or that no triangle uses.
    pub(crate) vertices: usize,
    /// Triangles that lost a corner.
    pub(crate) triangles: usize,
}

/// Welds; the first of several vertices stays. Vertices without a triangle and triangles without three corners go.
pub(crate) fn weld(mesh: &mut TriangleMesh) -> Welded {
    let points: Vec<Vector3<f64>> = mesh.vertices_m.iter().map(|v| Vector3::from(*v)).collect();
    let Some(first) = points.first() else { return Welded::default() };
    let (lower, upper) = points.iter().fold((*first, *first), |(l, u), p| (l.inf(p), u.sup(p)));
    let tolerance = TOLERANCE * (upper - lower).norm();
    let mut same: Vec<u32> = (0..points.len() as u32).collect();
    if tolerance > 0.0 {
        let cells = Cells::new(&points, tolerance);
        for i in 0..points.len() {
            let mut least = i as u32;
            cells.around(&points[i], |j| {
                if j < least && same[j as usize] == j && (points[j as usize] - points[i]).norm() <= tolerance {
                    least = j;
                }
            });
            same[i] = least;
        }
    }
    let (vertices, triangles) = (mesh.vertices_m.len(), mesh.triangles.len());
    for t in &mut mesh.triangles {
        *t = t.map(|i| same[i as usize]);
    }
    mesh.triangles.retain(|[a, b, c]| a != b && b != c && c != a);
    let mut place = vec![u32::MAX; vertices];
    let mut kept = Vec::new();
    for i in mesh.triangles.iter_mut().flatten() {
        let at = &mut place[*i as usize];
        if *at == u32::MAX {
            *at = kept.len() as u32;
            kept.push(mesh.vertices_m[*i as usize]);
        }
        *i = *at;
    }
    mesh.vertices_m = kept;
    Welded { vertices: vertices - mesh.vertices_m.len(), triangles: triangles - mesh.triangles.len() }
}
