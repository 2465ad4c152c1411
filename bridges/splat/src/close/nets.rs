//! The zero of a field as triangles: surface nets (Gibson 1998), one vertex in each cell that the surface passes.

use cosplat_core::asset::TriangleMesh;
use nalgebra::Vector3;

use super::poisson::Field;

const NONE: u32 = u32::MAX;

/// Triangles between the negative and the positive side, counter-clockwise seen from the positive one. A vertex is the mean
/// of the places where edges of its cell pass zero. The surface ends at the border of the grid.
pub(crate) fn surface(field: &Field) -> TriangleMesh {
    let [nx, ny, nz] = field.size;
    let mut mesh = TriangleMesh::default();
    let mut vertex = vec![NONE; field.values.len()];
    for z in 0..nz.saturating_sub(1) {
        for y in 0..ny.saturating_sub(1) {
            for x in 0..nx.saturating_sub(1) {
                if let Some(place) = crossing(field, [x, y, z]) {
                    vertex[field.index([x, y, z])] = mesh.vertices_m.len() as u32;
                    mesh.vertices_m.push(place.into());
                }
            }
        }
    }
    for z in 0..nz {
        for y in 0..ny {
            for x in 0..nx {
                for k in 0..3 {
                    quad(field, &vertex, [x, y, z], k, &mut mesh);
                }
            }
        }
    }
    mesh
}

/// Whether a value belongs to what is behind the surface.
fn behind(value: f32) -> bool {
    value < 0.0
}

/// Mean of the crossings of the twelve edges of a cell.
fn crossing(field: &Field, cell: [usize; 3]) -> Option<Vector3<f64>> {
    let value = |corner: usize| field.values[field.index([0, 1, 2].map(|k| cell[k] + (corner >> k & 1)))];
    let values: [f32; 8] = std::array::from_fn(value);
    let (mut sum, mut count) = (Vector3::zeros(), 0.0);
    for a in 0..8_usize {
        for k in 0..3 {
            let b = a | 1 << k;
            if a == b || behind(values[a]) == behind(values[b]) {
                continue;
            }
            let t = f64::from(values[a]) / (f64::from(values[a]) - f64::from(values[b]));
            let mut place = Vector3::new((a & 1) as f64, (a >> 1 & 1) as f64, (a >> 2 & 1) as f64);
            place[k] += t;
            (sum, count) = (sum + place, count + 1.0);
        }
    }
    let origin = Vector3::from(cell.map(|c| c as f64));
    (count > 0.0).then(|| field.lower + (origin + sum / count) * field.cell)
}

/// The face across the edge along `k` from a node, between the four cells around it.
fn quad(field: &Field, vertex: &[u32], node: [usize; 3], k: usize, mesh: &mut TriangleMesh) {
    let (u, v) = ((k + 1) % 3, (k + 2) % 3);
    if node[k] + 1 >= field.size[k] || node[u] == 0 || node[v] == 0 {
        return;
    }
    let mut end = node;
    end[k] += 1;
    let [from, to] = [node, end].map(|n| behind(field.values[field.index(n)]));
    if from == to {
        return;
    }
    let cell = |du: usize, dv: usize| {
        let mut c = node;
        (c[u], c[v]) = (c[u] - du, c[v] - dv);
        vertex[field.index(c)]
    };
    let mut corners = [cell(1, 1), cell(0, 1), cell(0, 0), cell(1, 0)];
    if corners.contains(&NONE) {
        return;
    }
    if to {
        // Behind is ahead: seen from the other side.
        corners.reverse();
    }
    let place = |i: u32| Vector3::from(mesh.vertices_m[i as usize]);
    let [a, b, c, d] = corners;
    // The shorter diagonal gives the better triangles.
    let split = (place(a) - place(c)).norm_squared() <= (place(b) - place(d)).norm_squared();
    mesh.triangles.extend(if split { [[a, b, c], [a, c, d]] } else { [[a, b, d], [b, c, d]] });
}
