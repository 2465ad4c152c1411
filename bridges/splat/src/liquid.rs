//! The surface of a liquid of particles as a mesh: where the share of space that they fill passes one half.
//!
//! Each particle is its volume d³ smoothed by the cubic spline of radius 2d (Monaghan 1992), d the spacing. At a flat face of
//! a full lattice that sum is one half by symmetry, so the face is where the matter ends; edges are rounded at the length of
//! the kernel. A particle with few neighbours would stay below one half and vanish: it is enlarged, so that a lone one is a
//! ball of its own volume. Groups that no kernel joins have grids of their own, so that spray far away costs nothing.

use std::collections::BTreeMap;

use cosplat_core::asset::TriangleMesh;
use cosplat_core::boundary::Vec3;
use nalgebra::Vector3;

use crate::close::{Field, nets};

/// Radius of the kernel, in spacings.
const RADIUS: f64 = 2.0;
/// Edge of a cell of the grid, in spacings.
const CELL: f64 = 0.5;
/// Nodes of the grid of a group at most: 8 bytes each. Cells grow until they fit.
const MOST: f64 = 33_554_432.0;
const COARSER: f64 = 1.05;
/// The surface is here.
const LEVEL: f32 = 0.5;
/// d³ W(0): what a lone particle fills of its own place.
const LONE: f64 = 1.0 / std::f64::consts::PI;
/// What a lone particle must fill there to be a ball of volume d³: one half over W(r)/W(0) at r = 0.742 d, where the spline
/// has fallen to 0.4806. Such a ball has the radius (3/4π)^⅓ d = 0.620 d; the nets cut a quarter of a cell off one so small,
/// as measured.
const BALL: f64 = 0.5 / 0.4806;

/// The surface \[m\] of a liquid whose particles are there \[m\], at this spacing \[m\]; closed, counter-clockwise seen from
/// outside. Particles that are nowhere (not finite) are left out. The same bytes for the same input.
pub fn liquid_surface(position_m: &[Vec3], spacing_m: f64) -> TriangleMesh {
    let mut mesh = TriangleMesh::default();
    if !(spacing_m.is_finite() && spacing_m > 0.0) {
        return mesh;
    }
    let places: Vec<Vector3<f64>> = position_m.iter().map(|p| Vector3::from(*p)).collect();
    for group in groups(&places, 2.0 * RADIUS * spacing_m) {
        let part = nets::surface(&field(&group, spacing_m));
        let first = mesh.vertices_m.len() as u32;
        mesh.vertices_m.extend(part.vertices_m);
        mesh.triangles.extend(part.triangles.into_iter().map(|t| t.map(|i| first + i)));
    }
    mesh
}

/// Particles that are joined by steps from cell to neighbouring cell of that edge \[m\].
fn groups(places: &[Vector3<f64>], edge: f64) -> Vec<Vec<Vector3<f64>>> {
    let mut cells: BTreeMap<[i64; 3], Vec<Vector3<f64>>> = BTreeMap::new();
    for place in places.iter().filter(|p| p.iter().all(|v| v.is_finite())) {
        cells.entry([0, 1, 2].map(|k| (place[k] / edge).floor() as i64)).or_default().push(*place);
    }
    let mut groups = Vec::new();
    while let Some((first, members)) = cells.pop_first() {
        let (mut group, mut open) = (members, vec![first]);
        while let Some(cell) = open.pop() {
            for n in 0..27_i64 {
                let shift = [n % 3 - 1, n / 3 % 3 - 1, n / 9 - 1];
                let near = [0, 1, 2].map(|k| cell[k].saturating_add(shift[k]));
                if let Some(members) = cells.remove(&near) {
                    group.extend(members);
                    open.push(near);
                }
            }
        }
        groups.push(group);
    }
    groups
}

/// One half minus the share of space that is filled: negative inside.
fn field(group: &[Vector3<f64>], spacing: f64) -> Field {
    let lower = group.iter().fold(group[0], |a, p| a.inf(p));
    let upper = group.iter().fold(group[0], |a, p| a.sup(p));
    let mut cell = CELL * spacing;
    let size = |cell: f64| {
        // Nothing around what the kernels reach, so that the surface is closed; no whole number of cells, so that the face
        // of a lattice does not lie in the nodes, where its sign would be that of the rounding.
        let reach = Vector3::repeat(RADIUS * spacing + 2.4 * cell);
        let cells = ((upper - lower + 2.0 * reach) / cell).map(|n| n.ceil() + 1.0);
        (lower - reach, cells)
    };
    while size(cell).1.product() > MOST {
        cell *= COARSER;
    }
    let (origin, cells) = size(cell);
    let size = <[f64; 3]>::from(cells).map(|n| n as usize);
    let mut field = Field { lower: origin, cell, size, values: vec![LEVEL; size.iter().product()] };
    for place in group {
        pour(&mut field, *place, spacing, 1.0);
    }
    let larger: Vec<f64> = group.iter().map(|place| enlarged(f64::from(LEVEL) - field.at(*place))).collect();
    for (place, factor) in group.iter().zip(larger) {
        if factor > 1.0 {
            pour(&mut field, *place, spacing, factor - 1.0);
        }
    }
    field
}

/// By how much a particle is enlarged whose place is filled by that share: as a lone one where it is alone, not at all where
/// one half is reached without.
fn enlarged(share: f64) -> f64 {
    let alone = ((f64::from(LEVEL) - share) / (f64::from(LEVEL) - LONE)).clamp(0.0, 1.0);
    1.0 + (BALL / LONE - 1.0) * alone
}

/// Takes what a particle fills from the nodes around it.
fn pour(field: &mut Field, place: Vector3<f64>, spacing: f64, volumes: f64) {
    let radius = RADIUS * spacing;
    let at = (place - field.lower) / field.cell;
    let reach = radius / field.cell;
    let first = [0, 1, 2].map(|k| (at[k] - reach).ceil().max(0.0) as usize);
    let last = [0, 1, 2].map(|k| ((at[k] + reach).floor() as usize).min(field.size[k] - 1));
    for z in first[2]..=last[2] {
        for y in first[1]..=last[1] {
            for x in first[0]..=last[0] {
                let from = Vector3::new(x as f64, y as f64, z as f64) - at;
                let share = volumes * LONE * spline(from.norm() / reach);
                let index = field.index([x, y, z]);
                field.values[index] -= share as f32;
            }
        }
    }
}

/// The cubic spline over its value at the centre; `q` is the distance over the radius.
fn spline(q: f64) -> f64 {
    if q < 0.5 { 1.0 - 6.0 * q * q * (1.0 - q) } else { 2.0 * (1.0 - q).max(0.0).powi(3) }
}

#[cfg(test)]
mod tests {
    use super::*;

    const D: f64 = 0.02;

    fn block(n: [usize; 3], shift: Vec3) -> Vec<Vec3> {
        let all = (0..n[0] * n[1] * n[2]).map(|i| [i % n[0], i / n[0] % n[1], i / n[0] / n[1]]);
        all.map(|cell| [0, 1, 2].map(|k| shift[k] + (cell[k] as f64 + 0.5) * D)).collect()
    }

    fn volume(mesh: &TriangleMesh) -> f64 {
        let six = |t: &[u32; 3]| {
            let [a, b, c] = t.map(|i| Vector3::from(mesh.vertices_m[i as usize]));
            a.dot(&b.cross(&c))
        };
        mesh.triangles.iter().map(six).sum::<f64>() / 6.0
    }

    /// Every edge of a triangle is gone along once in each direction, as often as in the other.
    fn assert_closed(mesh: &TriangleMesh) {
        let mut edges: BTreeMap<(u32, u32), i32> = BTreeMap::new();
        for [a, b, c] in &mesh.triangles {
            for (from, to) in [(a, b), (b, c), (c, a)] {
                *edges.entry((*from.min(to), *from.max(to))).or_default() += if from < to { 1 } else { -1 };
            }
        }
        assert!(!edges.is_empty() && edges.values().all(|count| *count == 0));
    }

    #[test]
    fn a_block_at_rest_is_closed_and_has_the_volume_of_its_particles() {
        let n = [16, 12, 20];
        let particles = block(n, [0.3, -0.2, 0.1]);
        let mesh = liquid_surface(&particles, D);
        assert_closed(&mesh);
        // Euler's formula for one closed surface without a handle.
        assert_eq!(2 * mesh.vertices_m.len(), mesh.triangles.len() + 4);
        let wanted = particles.len() as f64 * D.powi(3);
        let found = volume(&mesh) / wanted - 1.0;
        println!("volume of a block of {n:?} particles: {:.2} %", 100.0 * found);
        // Faces are right to the mean of the lattice; edges lose what the kernel rounds: at most 0.5 d² of area along
        // each of 4 (16 + 12 + 20) d of edge, 2.5 % of the block.
        assert!((-0.025..0.005).contains(&found), "{found}");
        // The middle of a face is where the matter ends, to a twentieth of the spacing.
        let top = mesh.vertices_m.iter().map(|v| v[2]).fold(f64::MIN, f64::max);
        assert!((top - (0.1 + 20.0 * D)).abs() < 0.05 * D, "{top}");
    }

    #[test]
    fn spray_is_drops_of_about_its_own_volume_however_far_away() {
        let count = 40;
        let mut drops: Vec<Vec3> =
            (0..count).map(|i| [0.1377 * D, 5.0313 * D, 20.0 + 0.0717 * D].map(|v| v * f64::from(i))).collect();
        drops.push([f64::NAN, 0.0, 0.0]);
        let mesh = liquid_surface(&drops, D);
        assert_closed(&mesh);
        let found = volume(&mesh) / (f64::from(count) * D.powi(3)) - 1.0;
        println!("volume of lone drops: {:.1} %", 100.0 * found);
        // A ball of 2.5 cells in diameter, whose polyhedron differs with where it lies in the cells.
        assert!(found.abs() < 0.3, "{found}");
    }

    #[test]
    fn nothing_has_no_surface() {
        assert_eq!(liquid_surface(&[], D).triangles.len(), 0);
        assert_eq!(liquid_surface(&[[0.0; 3]], 0.0).triangles.len(), 0);
        assert_eq!(
            liquid_surface(&[[1e300, 0.0, 0.0]], D).vertices_m.iter().flatten().filter(|v| v.is_nan()).count(),
            0
        );
    }
}
