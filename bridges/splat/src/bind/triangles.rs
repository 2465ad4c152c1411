//! The triangle of a mesh below each Gaussian.

use nalgebra::{Matrix3, Vector3};
use rayon::prelude::*;

use super::{BindError, Local, Particles};
use crate::grid::Grid;
use crate::linalg::wide;

/// The nearest triangle is looked for among those at so many vertices that are nearest.
const VERTICES: usize = 12;
/// A triangle with a smaller sine between two edges has no frame.
const FLAT: f64 = 1e-9;

/// Where each Gaussian lies against a triangle whose corners are particles.
///
/// x = Σ bᵢ xᵢ + d n with barycentric coordinates b of the nearest point's plane, the unit normal n and a distance d that
/// stays; F takes the edges to the edges and the normal to the normal. Motions of the vertices that are affine in the
/// plane are followed exactly; along the normal nothing is stretched.
#[derive(Clone, Debug, PartialEq)]
pub struct Triangles {
    particles: usize,
    own: Vec<One>,
}

/// The part of one Gaussian.
#[derive(Clone, Copy, Debug, PartialEq)]
struct One {
    corners: [u32; 3],
    /// Of the second and the third corner.
    share: [f64; 2],
    /// Along the normal.
    off: f64,
}

/// Edges from the first corner, and the unit normal; nothing of a triangle without area.
fn frame(corners: [Vector3<f64>; 3]) -> Option<Matrix3<f64>> {
    let (u, v) = (corners[1] - corners[0], corners[2] - corners[0]);
    let n = u.cross(&v);
    let area = n.norm();
    (area > FLAT * u.norm() * v.norm() && area.is_finite()).then(|| Matrix3::from_columns(&[u, v, n / area]))
}

impl Triangles {
    pub(crate) fn new(
        positions: &[[f32; 3]],
        vertices: &[[f32; 3]],
        triangles: &[[u32; 3]],
    ) -> Result<Triangles, BindError> {
        super::finite(&[("particle", vertices), ("Gaussian", positions)])?;
        let mut at = vec![Vec::new(); vertices.len()];
        for (number, triangle) in triangles.iter().enumerate() {
            for &corner in triangle {
                let corner_at = at.get_mut(corner as usize);
                corner_at.ok_or(BindError::Index(number, corner, vertices.len()))?.push(number as u32);
            }
        }
        // Only vertices of triangles can be near one.
        let used: Vec<u32> = (0..vertices.len() as u32).filter(|v| !at[*v as usize].is_empty()).collect();
        if used.is_empty() {
            return Err(BindError::NoParticles(positions.len()));
        }
        let places: Vec<[f32; 3]> = used.iter().map(|v| vertices[*v as usize]).collect();
        let grid = Grid::new(&places);
        let one = |found: &mut Vec<(f64, u32)>, p: &[f32; 3]| {
            grid.nearest(wide(*p), VERTICES, found);
            let near = found.iter().flat_map(|n| &at[used[n.1 as usize] as usize]).map(|t| triangles[*t as usize]);
            let all = near.filter_map(|t| below(wide(*p), t, vertices));
            // The first of equals.
            let best = all.reduce(|best, next| if next.0 < best.0 { next } else { best });
            let alone = || One { corners: [used[found[0].1 as usize]; 3], share: [0.0; 2], off: 0.0 };
            best.map_or_else(alone, |b| b.1)
        };
        let own = positions.par_iter().map_init(Vec::new, one).collect();
        Ok(Triangles { particles: vertices.len(), own })
    }

    pub(super) fn check(&self, gaussians: usize, particles: usize) -> Result<(), BindError> {
        super::same_lengths(self.own.len(), gaussians, self.particles, particles)
    }

    /// Corners of the triangle that a Gaussian lies at, and its barycentric coordinates: a sum of one, outside the triangle
    /// with negative ones.
    pub(crate) fn place(&self, i: usize) -> ([u32; 3], [f64; 3]) {
        let One { corners, share: [s, t], .. } = self.own[i];
        (corners, [1.0 - s - t, s, t])
    }

    pub(super) fn local(&self, i: usize, particles: &Particles<'_>) -> Local {
        let one = &self.own[i];
        let at = |places: &[[f32; 3]]| one.corners.map(|c| wide(places[c as usize]));
        let (rest, now) = (at(particles.rest), at(particles.now));
        let first = now[0] - rest[0];
        let still = Local { displacement: first, gradient: Matrix3::identity() };
        let (Some(before), Some(after)) = (frame(rest), frame(now)) else { return still };
        if before == after {
            return still;
        }
        let Some(inverse) = before.try_inverse() else { return still };
        let moved = |k: usize| (now[k] - rest[k] - first) * one.share[k - 1];
        let lifted = (after.column(2) - before.column(2)) * one.off;
        Local { displacement: first + moved(1) + moved(2) + lifted, gradient: after * inverse }
    }
}

/// Distance of a place from a triangle, and how it lies against it.
fn below(p: Vector3<f64>, corners: [u32; 3], vertices: &[[f32; 3]]) -> Option<(f64, One)> {
    let places = corners.map(|c| wide(vertices[c as usize]));
    let axes = frame(places)?;
    let [s, t, off]: [f64; 3] = (axes.try_inverse()? * (p - places[0])).into();
    let distance = if s >= 0.0 && t >= 0.0 && s + t <= 1.0 {
        off.abs()
    } else {
        let side = |a: Vector3<f64>, b: Vector3<f64>| {
            let along = ((p - a).dot(&(b - a)) / (b - a).norm_squared()).clamp(0.0, 1.0);
            (a + (b - a) * along - p).norm()
        };
        let [a, b, c] = places;
        side(a, b).min(side(b, c)).min(side(c, a))
    };
    Some((distance, One { corners, share: [s, t], off }))
}
