//! Cloth: what is seen between its vertices.

use cosplat_core::asset::TriangleMesh;
use cosplat_core::boundary::{Vec3, add, cross, norm, scale, sub};
use cosplat_splat::surfel::{Fabric, Sample, grained};

use crate::frames::{Cloth, Look};

/// Squares along the longer side of a sheet without a spacing, as `pbd` cuts it.
const SQUARES: f64 = 50.0;
/// Largest number of squares; a sheet of more is shown as its particles.
const MOST_SQUARES: f64 = 4e7;
/// By what part vertices differ in brightness: enough to see that the cloth moves in its own plane.
const GRAIN: f64 = 0.08;

/// A rectangle in z = 0, centred, as solvers cut it: squares of about the spacing, vertices row by row, x running fastest.
pub(super) fn rectangle(size_m: [f64; 2], spacing_m: Option<f64>) -> Option<TriangleMesh> {
    let spacing = spacing_m.unwrap_or(size_m[0].max(size_m[1]) / SQUARES);
    let cells = size_m.map(|s| (s / spacing).round().max(1.0));
    if cells[0] * cells[1] >= MOST_SQUARES {
        return None;
    }
    let [nx, ny] = cells.map(|c| c as u32);
    let place = |k: usize, i: u32| size_m[k] * (f64::from(i) / cells[k] - 0.5);
    let at = |i: u32, j: u32| j * (nx + 1) + i;
    let vertices_m = (0..=ny).flat_map(|j| (0..=nx).map(move |i| [place(0, i), place(1, j), 0.0])).collect();
    let square = |(i, j)| {
        let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
        if (i + j) % 2 == 0 { [[a, b, c], [a, c, d]] } else { [[a, b, d], [b, c, d]] }
    };
    let triangles = (0..ny).flat_map(|j| (0..nx).map(move |i| (i, j))).flat_map(square).collect();
    Some(TriangleMesh { vertices_m, triangles })
}

/// The vertices of a mesh as samples of one colour with grain, each with the same share of the surface.
pub(super) fn vertices(mesh: &TriangleMesh, colour: [f64; 3]) -> Vec<Sample> {
    let count = mesh.vertices_m.len();
    let (mut normals, mut areas) = (vec![[0.0; 3]; count], vec![0.0; count]);
    for triangle in &mesh.triangles {
        let [a, b, c] = triangle.map(|i| mesh.vertices_m[i as usize]);
        let normal: Vec3 = scale(cross(sub(b, a), sub(c, a)), 0.5);
        for &i in triangle {
            normals[i as usize] = add(normals[i as usize], normal);
            areas[i as usize] += norm(normal) / 3.0;
        }
    }
    let share = areas.iter().sum::<f64>() / count.max(1) as f64;
    grained(&mesh.vertices_m, &normals, &vec![share; count], colour, GRAIN)
}

/// Root of the share of the surface that each vertex has \[m\].
fn spacing(mesh: &TriangleMesh) -> f64 {
    let of = |t: &[u32; 3]| {
        let [a, b, c] = t.map(|i| mesh.vertices_m[i as usize]);
        norm(cross(sub(b, a), sub(c, a))) / 2.0
    };
    (mesh.triangles.iter().map(of).sum::<f64>() / mesh.vertices_m.len().max(1) as f64).sqrt()
}

/// A mesh whose vertices are what moves, each a sample; `colour` is that of particles where its solver shows other ones.
pub(super) fn look(mesh: &TriangleMesh, vertices: &[Sample], colour: [f64; 3]) -> Look {
    let fabric = Fabric { triangles: mesh.triangles.clone(), colours: vertices.iter().map(|s| s.colour).collect() };
    Look::Cloth(Cloth { rest: mesh.vertices_m.clone(), fabric, dots: (spacing(mesh), colour) })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sheet_is_cut_into_squares_of_about_its_spacing() {
        let mesh = rectangle([0.3, 0.21], Some(0.1)).unwrap();
        assert_eq!((mesh.vertices_m.len(), mesh.triangles.len()), (12, 12));
        let corner = |at: usize, wanted: Vec3| norm(sub(mesh.vertices_m[at], wanted)) < 1e-15;
        assert!(corner(0, [-0.15, -0.105, 0.0]) && corner(3, [0.15, -0.105, 0.0]) && corner(11, [0.15, 0.105, 0.0]));
        assert_eq!(rectangle([1.0, 0.5], None).unwrap().vertices_m.len(), 51 * 26);
        assert!(rectangle([1.0, 1.0], Some(1e-9)).is_none());
        let Look::Cloth(cloth) = look(&mesh, &vertices(&mesh, [0.5; 3]), [0.5; 3]) else { panic!("a cloth") };
        assert_eq!((cloth.fabric.colours.len(), cloth.rest.len()), (12, 12));
        assert!((cloth.dots.0 - (0.3_f64 * 0.21 / 12.0).sqrt()).abs() < 1e-12);
    }
}
