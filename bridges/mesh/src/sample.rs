//! Oriented points on a surface.

use cosplat_core::asset::TriangleMesh;
use cosplat_core::boundary::Vec3;
use nalgebra::Vector3;

use crate::cells::Cells;
use crate::error::{Fault, MeshError};
use crate::prepare::area;
use crate::random::Random;
use crate::thin::thin;

/// Candidates for each sample.
const CANDIDATES: usize = 5;
/// Samples at most.
const MOST: f64 = 4e6;
const SEED: u64 = 0x636f_7370_6c61_7421;

/// Points on a surface, one index for one point in every list.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SurfaceSamples {
    /// Positions, on the surface \[m\].
    pub position_m: Vec<Vec3>,
    /// Unit normals of the triangles they lie on; outward where the mesh is counter-clockwise.
    pub normal: Vec<Vec3>,
    /// The share of the surface that is nearest to each \[m²\]; the sum is the area of the mesh.
    pub area_m2: Vec<f64>,
}

/// Covers a surface with about one sample a `spacing_m`²: evenly, by Poisson disks, and the same in every run.
///
/// Candidates are drawn in proportion to area, in equal shares of it; of five, one stays. Each candidate then stands for
/// its share of the area and gives it to the nearest sample on its side of the surface.
///
/// # Errors
/// The mesh has no area, or the spacing gives too many samples.
pub fn surface_samples(mesh: &TriangleMesh, spacing_m: f64) -> Result<SurfaceSamples, MeshError> {
    let areas: Vec<Vector3<f64>> = mesh.triangles.iter().map(|t| area(mesh, *t)).collect();
    let total: f64 = areas.iter().map(Vector3::norm).sum();
    let wanted = (total / (spacing_m * spacing_m)).ceil();
    if !(spacing_m > 0.0 && total > 0.0 && wanted <= MOST) {
        let what = format!("an area of {total} m² and a spacing of {spacing_m} m make {wanted} samples");
        return Err(MeshError::whole(Fault::Spacing, what, "use a larger spacing, or check `metres_per_unit`"));
    }
    let count = (wanted as usize).max(4);
    let (points, normals) = candidates(mesh, &areas, CANDIDATES * count, &mut Random::new(SEED));
    let kept = thin(&points, &normals, total, count);
    let area_m2 = shares(&points, &normals, &kept, total);
    Ok(SurfaceSamples {
        position_m: kept.iter().map(|&i| points[i as usize].into()).collect(),
        normal: kept.iter().map(|&i| normals[i as usize].into()).collect(),
        area_m2,
    })
}

/// Points in equal shares of the area, and the normals of their triangles.
pub(crate) fn candidates(
    mesh: &TriangleMesh,
    areas: &[Vector3<f64>],
    count: usize,
    random: &mut Random,
) -> (Vec<Vector3<f64>>, Vec<Vector3<f64>>) {
    let total: f64 = areas.iter().map(Vector3::norm).sum();
    let (mut points, mut normals) = (Vec::with_capacity(count), Vec::with_capacity(count));
    let (mut triangle, mut passed) = (0, 0.0);
    for k in 0..count {
        let target = (k as f64 + random.unit()) / count as f64 * total;
        while triangle + 1 < areas.len() && passed + areas[triangle].norm() < target {
            passed += areas[triangle].norm();
            triangle += 1;
        }
        // Uniform in a triangle: P = (1 − √r) A + √r (1 − s) B + √r s C (Osada et al. 2002).
        let [a, b, c] = mesh.corners(mesh.triangles[triangle]);
        let (root, s) = (random.unit().sqrt(), random.unit());
        points.push(a * (1.0 - root) + b * (root * (1.0 - s)) + c * (root * s));
        normals.push(areas[triangle].try_normalize(0.0).unwrap_or_else(Vector3::z));
    }
    (points, normals)
}

/// How much of the area is nearest to each sample.
fn shares(points: &[Vector3<f64>], normals: &[Vector3<f64>], kept: &[u32], total: f64) -> Vec<f64> {
    let samples: Vec<Vector3<f64>> = kept.iter().map(|&i| points[i as usize]).collect();
    // Elimination leaves no candidate farther than this from a sample: it would have been the least crowded.
    let cells = Cells::new(&samples, 3.0 * (total / kept.len() as f64).sqrt());
    let mut counts = vec![0_u32; kept.len()];
    for (p, n) in points.iter().zip(normals) {
        let (mut best, mut same_side) = ((f64::INFINITY, u32::MAX), (f64::INFINITY, u32::MAX));
        cells.around(p, |j| {
            let near = ((samples[j as usize] - p).norm_squared(), j);
            best = if near < best { near } else { best };
            if normals[kept[j as usize] as usize].dot(n) > 0.0 && near < same_side {
                same_side = near;
            }
        });
        let nearest = if same_side.1 == u32::MAX { best.1 } else { same_side.1 };
        if let Some(count) = counts.get_mut(nearest as usize) {
            *count += 1;
        }
    }
    let given: u32 = counts.iter().sum();
    counts.iter().map(|&n| f64::from(n) * total / f64::from(given.max(1))).collect()
}
