//! Oriented points on the surface of a capture.

use std::collections::BTreeMap;

use nalgebra::{Matrix3, Vector3};
use rayon::prelude::*;

use super::ground::underside;
use super::voxels::Voxels;
use crate::grid::{Grid, Near};
use crate::linalg::{svd, wide};
use crate::splats::Splats;

/// Neighbours from which normal and area come, the point itself among them.
const NEIGHBOURS: usize = 13;

/// Points with the normal and area that each stands for.
pub(super) struct Surface {
    pub(super) points: Vec<[f32; 3]>,
    /// Largest standard deviation of the Gaussians behind each point, the mean of them.
    pub(super) sigmas: Vec<f64>,
    /// Unit normals; outward after [`Surface::oriented`].
    pub(super) normals: Vec<Vector3<f64>>,
    pub(super) areas: Vec<f64>,
    /// 0 where outside is on both sides or on none, 1 where it is on one; from ½ on a point counts in full.
    pub(super) confidence: Vec<f64>,
    /// Points of the underside that was put, the last ones, before any was left out.
    pub(super) closed: usize,
}

/// Sums of one cell: position, standard deviation, number.
type Sum = (Vector3<f64>, f64, f64);

impl Surface {
    /// The means of the opaque Gaussians in each cell of a lattice, in the order of the cells; behind them, where the
    /// body stands on the ground, an underside.
    pub(super) fn thinned(splats: &Splats, opacity: f64, cell: f64, on_ground: bool) -> Surface {
        let mut cells: BTreeMap<[i64; 3], Sum> = BTreeMap::new();
        for i in 0..splats.len() {
            let p = wide(splats.positions[i]);
            let sigma = splats.scales(i).into_iter().fold(0.0, f64::max);
            if splats.opacity(i) >= opacity && p.iter().all(|v| v.is_finite()) && sigma.is_finite() {
                let key = [2, 1, 0].map(|k| (p[k] / cell).floor() as i64);
                let sum = cells.entry(key).or_insert((Vector3::zeros(), 0.0, 0.0));
                *sum = (sum.0 + p, sum.1 + sigma, sum.2 + 1.0);
            }
        }
        let mut points: Vec<[f32; 3]> = cells.values().map(|(p, _, n)| (p / *n).map(|v| v as f32).into()).collect();
        let mut sigmas: Vec<f64> = cells.values().map(|(_, s, n)| s / n).collect();
        let seen = points.len();
        if on_ground {
            points.extend(underside(&points, cell));
            sigmas.resize(points.len(), 0.0);
        }
        let grid = Grid::new(&points);
        let of = |found: &mut Vec<(f64, u32)>, p: &[f32; 3]| {
            grid.nearest(wide(*p), NEIGHBOURS, found);
            let plane = plane(&points, found);
            (plane.normal, plane.area)
        };
        let (normals, areas): (Vec<_>, Vec<_>) = points.par_iter().map_init(Vec::new, of).unzip();
        let confidence = vec![0.0; points.len()];
        let closed = points.len() - seen;
        Surface { points, sigmas, normals, areas, confidence, closed }
    }

    /// Lower and upper corner.
    pub(super) fn bounds(&self) -> (Vector3<f64>, Vector3<f64>) {
        let ends = (Vector3::repeat(f64::INFINITY), Vector3::repeat(f64::NEG_INFINITY));
        self.points.iter().fold(ends, |(lower, upper), p| (lower.inf(&wide(*p)), upper.sup(&wide(*p))))
    }

    /// Without the points that lie deep inside: captures leave haze there.
    pub(super) fn without_buried(self, voxels: &Voxels) -> Surface {
        let stays: Vec<bool> = self.points.par_iter().map(|p| voxels.is_near_outside(wide(*p))).collect();
        Surface {
            points: kept(self.points, &stays),
            sigmas: kept(self.sigmas, &stays),
            normals: kept(self.normals, &stays),
            areas: kept(self.areas, &stays),
            closed: self.closed,
            confidence: kept(self.confidence, &stays),
        }
    }

    /// Normals turned to the side on which the flood came nearest.
    pub(super) fn oriented(mut self, voxels: &Voxels) -> Surface {
        let sides: Vec<f64> =
            self.points.par_iter().zip(&self.normals).map(|(p, n)| voxels.outside_along(wide(*p), n)).collect();
        for ((n, c), side) in self.normals.iter_mut().zip(&mut self.confidence).zip(sides) {
            *c = side.abs();
            if side < 0.0 {
                *n = -*n;
            }
        }
        self
    }

    /// How far a point is behind the surface at the surface points nearest to it: behind all their tangent planes, and
    /// not farther than the nearest itself. Points that do not know which way is out have no say; where none knows, as
    /// in a slit, the depth is zero.
    pub(super) fn depth(&self, nearest: &[Near], p: Vector3<f64>) -> f64 {
        let distance = nearest.first().map_or(0.0, |n| n.0.sqrt());
        let mut knowing = nearest.iter().map(|n| n.1 as usize).filter(|&i| self.confidence[i] >= 0.5).peekable();
        if knowing.peek().is_none() {
            return 0.0;
        }
        knowing.map(|i| self.normals[i].dot(&(wide(self.points[i]) - p))).fold(distance, f64::min)
    }
}

/// The values that stay, in order.
fn kept<T>(values: Vec<T>, stays: &[bool]) -> Vec<T> {
    values.into_iter().zip(stays).filter_map(|(v, s)| s.then_some(v)).collect()
}

/// What the neighbours of a point say about the surface there.
pub(crate) struct Plane {
    /// The direction in which they spread least.
    pub(crate) normal: Vector3<f64>,
    /// π r² / (k − ½) with r the distance of the k-th.
    pub(crate) area: f64,
    /// Part of their spread that is along the normal: 0 in a plane, ⅓ in a cloud (Pauly et al. 2002).
    pub(crate) variation: f64,
}

/// The plane through a point and its neighbours.
pub(crate) fn plane(points: &[[f32; 3]], found: &[(f64, u32)]) -> Plane {
    let near: Vec<Vector3<f64>> = found.iter().map(|n| wide(points[n.1 as usize])).collect();
    let mean = near.iter().sum::<Vector3<f64>>() / near.len() as f64;
    let spread: Matrix3<f64> = near.iter().map(|p| (p - mean) * (p - mean).transpose()).sum();
    let parts = svd(&spread);
    let least = Vector3::from(parts.s).imin();
    let area = found.last().map_or(0.0, |n| std::f64::consts::PI * n.0) / (found.len() as f64 - 0.5);
    let total: f64 = parts.s.iter().sum();
    let variation = if total > 0.0 { parts.s[least] / total } else { 0.0 };
    Plane { normal: parts.u.column(least).into_owned(), area, variation }
}
