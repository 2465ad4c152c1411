//! Boundary particles below the surface of a closed triangle mesh.

use cosplat_core::asset::{AssetError, TriangleMesh};
use cosplat_core::boundary::{Vec3, add, cross, dot, norm, scale, sub};

use crate::shell::{Piece, piece};

/// Pairs of a cell and a triangle near it above which a spacing is refused as too fine for a mesh.
const MOST_PAIRS: f64 = 3e7;

/// Boundary particles of the solid that a mesh encloses, with `origin` \[m\] moved to zero; `Err` in words.
pub(crate) fn mesh_shell(mesh: &TriangleMesh, origin: Vec3, spacing: f64, depth: f64) -> Result<Vec<Piece>, String> {
    let triangles: Vec<[Vec3; 3]> =
        mesh.triangles.iter().map(|&t| mesh.corners(t).map(|c| sub(c.into(), origin))).collect();
    let pairs = near(&triangles, spacing, depth)?;
    let mut pieces = Vec::new();
    for group in pairs.chunk_by(|a, b| a.0 == b.0) {
        let x = group[0].0.map(|i| (i as f64 + 0.5) * spacing);
        let (distance, outward) = signed(x, group.iter().map(|(_, t)| &triangles[*t as usize]), 1e-9 * spacing);
        if distance > -depth {
            pieces.extend(piece(x, distance, || outward, spacing));
        }
    }
    Ok(pieces)
}

/// What a mesh must be to be a solid, in words.
pub(crate) fn not_solid(why: &AssetError) -> String {
    let hint = if matches!(why, AssetError::Open(_)) {
        "; close its holes and merge vertices at the same place, or use a box, sphere, cylinder or plane"
    } else {
        ""
    };
    format!("{why}{hint}")
}

/// Every cell with a triangle that may be closer than `depth`, sorted by cell.
fn near(triangles: &[[Vec3; 3]], spacing: f64, depth: f64) -> Result<Vec<([i64; 3], u32)>, String> {
    // From a cell's middle the nearest surface of interest is `depth` below or half a cell above.
    let reach = depth.max(0.5 * spacing);
    let (mut pairs, mut looked) = (Vec::new(), 0.0);
    for (t, corners) in triangles.iter().enumerate() {
        let range = [0, 1, 2].map(|k| {
            let ends = corners.iter().fold([f64::INFINITY, f64::NEG_INFINITY], |[l, h], c| [l.min(c[k]), h.max(c[k])]);
            let cell = |x: f64| (x / spacing - 0.5).floor() as i64;
            [cell(ends[0] - reach), cell(ends[1] + reach) + 1]
        });
        looked += range.iter().map(|r| (r[1] - r[0] + 1) as f64).product::<f64>();
        if looked > MOST_PAIRS {
            return Err(format!(
                "a mesh so large at a spacing of {spacing} m; a coarser spacing or smaller triangles help"
            ));
        }
        let normal = cross(sub(corners[1], corners[0]), sub(corners[2], corners[0]));
        let length = norm(normal);
        for i in range[0][0]..=range[0][1] {
            for j in range[1][0]..=range[1][1] {
                for k in range[2][0]..=range[2][1] {
                    let x = [i, j, k].map(|i| (i as f64 + 0.5) * spacing);
                    if dot(sub(x, corners[0]), normal).abs() <= reach * length
                        && norm(sub(x, closest(corners, x).0)) <= reach
                    {
                        pairs.push(([i, j, k], t as u32));
                    }
                }
            }
        }
    }
    pairs.sort_unstable();
    Ok(pairs)
}

/// Nearest point of a triangle, and which corners it lies between: all of them for the inside.
fn closest(corners: &[Vec3; 3], x: Vec3) -> (Vec3, [bool; 3]) {
    let [a, b, c] = *corners;
    let normal = cross(sub(b, a), sub(c, a));
    let square = dot(normal, normal);
    // Barycentric coordinates of the foot on the plane.
    let part = |p: Vec3, q: Vec3| dot(cross(sub(q, p), sub(x, p)), normal) / square;
    let weights = [part(b, c), part(c, a), part(a, b)];
    if weights.iter().all(|w| *w > 0.0) {
        let foot = (0..3).fold([0.0; 3], |sum, k| add(sum, scale(corners[k], weights[k])));
        return (foot, [true; 3]);
    }
    let on_edge = |k: usize| {
        let (p, q) = (corners[k], corners[(k + 1) % 3]);
        let along = sub(q, p);
        let t = (dot(sub(x, p), along) / dot(along, along)).clamp(0.0, 1.0);
        let mut between = [false; 3];
        between[k] = t < 1.0;
        between[(k + 1) % 3] = t > 0.0;
        (add(p, scale(along, t)), between)
    };
    let nearer = |k: usize, other: (Vec3, [bool; 3])| {
        let found = on_edge(k);
        if norm(sub(x, found.0)) < norm(sub(x, other.0)) { found } else { other }
    };
    nearer(2, nearer(1, on_edge(0)))
}

/// Signed distance from the nearest of some triangles and the direction away from the solid.
///
/// The sign is that of the sum of the normals of all triangles at the nearest point, weighted by their angle there.
/// Source: Bærentzen and Aanæs, "Signed distance computation using the angle weighted pseudonormal" (2005).
fn signed<'t>(x: Vec3, triangles: impl Iterator<Item = &'t [Vec3; 3]>, equal: f64) -> (f64, Vec3) {
    let (mut best, mut foot, mut normal) = (f64::INFINITY, x, [0.0; 3]);
    for corners in triangles {
        let (point, between) = closest(corners, x);
        let distance = norm(sub(x, point));
        if distance > best + equal {
            continue;
        }
        let face = cross(sub(corners[1], corners[0]), sub(corners[2], corners[0]));
        let seen = angle(corners, between) / norm(face).max(f64::MIN_POSITIVE);
        if distance < best - equal {
            normal = [0.0; 3];
        }
        if distance < best {
            (best, foot) = (distance, point);
        }
        normal = add(normal, scale(face, seen));
    }
    let away = sub(x, foot);
    let sign = if dot(away, normal) < 0.0 { -1.0 } else { 1.0 };
    let outward = if best > equal { scale(away, sign / best) } else { scale(normal, 1.0 / norm(normal)) };
    (sign * best, outward)
}

/// Angle of a triangle at a point inside, on an edge or at a corner \[rad\].
fn angle(corners: &[Vec3; 3], between: [bool; 3]) -> f64 {
    let ends = between.iter().filter(|b| **b).count();
    if ends > 1 {
        return std::f64::consts::PI * if ends == 2 { 1.0 } else { 2.0 };
    }
    let k = between.iter().position(|b| *b).unwrap_or(0);
    let (a, b) = (sub(corners[(k + 1) % 3], corners[k]), sub(corners[(k + 2) % 3], corners[k]));
    libm::atan2(norm(cross(a, b)), dot(a, b))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shape::Shape;

    #[test]
    fn a_brick_of_triangles_has_the_particles_of_a_box() {
        let (half, d) = ([0.1, 0.055, 0.033], 0.02);
        let corner = |i: usize| [0, 1, 2].map(|k| if i >> k & 1 == 1 { half[k] } else { -half[k] });
        let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
        let mesh = TriangleMesh {
            vertices_m: (0..8).map(corner).map(|v| add(v, [0.3, 0.0, 0.0])).collect(),
            triangles: quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect(),
        };
        let pieces = mesh_shell(&mesh, [0.3, 0.0, 0.0], d, 0.05).unwrap();
        let volume: f64 = pieces.iter().map(|p| p.1).sum();
        let exact = 8.0 * half.iter().product::<f64>();
        println!("{} pieces, {}", pieces.len(), volume / exact - 1.0);
        // Cells cut by two or three sides at once are taken as cut by one.
        assert!((volume / exact - 1.0).abs() < 0.06);
        assert!(pieces.iter().all(|p| Shape::Box(half).distance(p.0) < -0.02 * d));
        assert!(mesh_shell(&mesh, [0.0; 3], 1e-5, 1e-4).unwrap_err().contains("coarser"));
    }
}
