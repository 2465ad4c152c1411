//! Vertices in one place become one vertex, so that it can be seen whether a surface is closed.

use std::collections::HashMap;

use cosplat_core::asset::TriangleMesh;
use nalgebra::Vector3;

use crate::cells::{Key, key};

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

/// Welds; colours, where there are any, stay with their vertices. The first of several vertices stays. Vertices without a triangle and triangles without three corners go.
pub(crate) fn weld(mesh: &mut TriangleMesh, colours: &mut Vec<[f32; 3]>) -> Welded {
    let points: Vec<Vector3<f64>> = mesh.vertices_m.iter().map(|v| Vector3::from(*v)).collect();
    let Some(first) = points.first() else { return Welded::default() };
    let (lower, upper) = points.iter().fold((*first, *first), |(l, u), p| (l.inf(p), u.sup(p)));
    let tolerance = TOLERANCE * (upper - lower).norm();
    let same = if tolerance > 0.0 { first_nearby(&points, tolerance) } else { (0..points.len() as u32).collect() };
    let (vertices, triangles) = (mesh.vertices_m.len(), mesh.triangles.len());
    for t in &mut mesh.triangles {
        *t = t.map(|i| same[i as usize]);
    }
    mesh.triangles.retain(|[a, b, c]| a != b && b != c && c != a);
    let mut place = vec![u32::MAX; vertices];
    let (mut kept, mut own) = (Vec::new(), Vec::new());
    for i in mesh.triangles.iter_mut().flatten() {
        let at = &mut place[*i as usize];
        if *at == u32::MAX {
            *at = kept.len() as u32;
            kept.push(mesh.vertices_m[*i as usize]);
            own.extend(colours.get(*i as usize));
        }
        *i = *at;
    }
    (mesh.vertices_m, *colours) = (kept, own);
    Welded { vertices: vertices - mesh.vertices_m.len(), triangles: triangles - mesh.triangles.len() }
}

/// For each point the first one within the tolerance that is its own first, or itself.
///
/// Only firsts are kept in the cells: they are farther than the tolerance from each other, so a cell holds a few, also
/// of a file with all its points in one place.
fn first_nearby(points: &[Vector3<f64>], tolerance: f64) -> Vec<u32> {
    let mut firsts: HashMap<Key, Vec<u32>> = HashMap::new();
    let mut same = Vec::with_capacity(points.len());
    for (i, point) in points.iter().enumerate() {
        let [x, y, z] = key(point, tolerance);
        let mut least = i as u32;
        for near in (0..27).map(|k| [x + k / 9 - 1, y + k / 3 % 3 - 1, z + k % 3 - 1]) {
            let is_same = |&&j: &&u32| (points[j as usize] - point).norm() <= tolerance;
            least = firsts.get(&near).and_then(|cell| cell.iter().find(is_same)).map_or(least, |j| least.min(*j));
        }
        if least == i as u32 {
            firsts.entry([x, y, z]).or_default().push(least);
        }
        same.push(least);
    }
    same
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Random;

    /// Compared with what it means, point by point: in crowds, across borders of cells, and on both sides of zero.
    #[test]
    fn the_first_of_several_points_in_one_place_is_found() {
        let mut random = Random::new(7);
        let points: Vec<Vector3<f64>> = (0..1500)
            .map(|_| Vector3::from_fn(|_, _| 0.5 * (random.unit() * 8.0).floor() - 2.0 + 0.1 * random.unit()))
            .collect();
        for tolerance in [0.01, 0.09, 0.3, 0.6] {
            let found = first_nearby(&points, tolerance);
            let mut expected: Vec<usize> = Vec::new();
            for (i, p) in points.iter().enumerate() {
                let is_first = |&j: &usize| expected[j] == j && (points[j] - p).norm() <= tolerance;
                let first = (0..i).find(is_first);
                expected.push(first.unwrap_or(i));
            }
            assert!(found.iter().map(|i| *i as usize).eq(expected), "{tolerance}");
        }
    }
}
