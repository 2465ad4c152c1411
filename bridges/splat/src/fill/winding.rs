//! The winding number of oriented points, far ones taken together.

use std::collections::BTreeMap;
use std::f64::consts::PI;

use nalgebra::Vector3;

use super::surface::Surface;
use crate::linalg::wide;

/// A cluster farther than this many times its radius counts as one dipole: the error is about 1 % of its share.
const FAR: f64 = 3.0;

/// A dipole: place and area times normal.
#[derive(Clone, Copy)]
struct Dipole {
    place: Vector3<f64>,
    strength: Vector3<f64>,
    /// Closer than this the field is that at this distance: half the width of the point's own share of the surface.
    core: f64,
}

struct Cluster {
    whole: Dipole,
    /// Radius around the whole's place.
    radius: f64,
    points: Vec<Dipole>,
}

/// Dipoles in clusters.
pub(super) struct Winding {
    clusters: Vec<Cluster>,
}

impl Winding {
    /// Clusters in cells of a lattice.
    pub(super) fn new(surface: &Surface, cell: f64) -> Winding {
        let mut cells: BTreeMap<[i64; 3], Vec<Dipole>> = BTreeMap::new();
        for (i, p) in surface.points.iter().enumerate() {
            let place = wide(*p);
            let area = surface.areas[i];
            let strength = surface.normals[i] * (area * (2.0 * surface.confidence[i]).min(1.0));
            let key = [2, 1, 0].map(|k| (place[k] / cell).floor() as i64);
            cells.entry(key).or_default().push(Dipole { place, strength, core: area.sqrt() / 2.0 });
        }
        Winding { clusters: cells.into_values().map(cluster).collect() }
    }

    /// Σ a n·(p − x) / (4π |p − x|³): 1 inside a closed surface, 0 outside.
    pub(super) fn at(&self, x: Vector3<f64>) -> f64 {
        let of = |c: &Cluster| {
            let reach = FAR * c.radius;
            if (c.whole.place - x).norm_squared() > reach * reach {
                return field(&c.whole, x);
            }
            c.points.iter().map(|d| field(d, x)).sum()
        };
        self.clusters.iter().map(of).sum::<f64>() / (4.0 * PI)
    }
}

fn field(d: &Dipole, x: Vector3<f64>) -> f64 {
    let arm = d.place - x;
    let distance = arm.norm().max(d.core);
    if distance > 0.0 { d.strength.dot(&arm) / distance.powi(3) } else { 0.0 }
}

fn cluster(points: Vec<Dipole>) -> Cluster {
    let total: f64 = points.iter().map(|d| d.strength.norm()).sum();
    let weight = |d: &Dipole| if total > 0.0 { d.strength.norm() / total } else { 1.0 / points.len() as f64 };
    let place = points.iter().map(|d| d.place * weight(d)).sum::<Vector3<f64>>();
    let strength = points.iter().map(|d| d.strength).sum();
    let radius = points.iter().map(|d| (d.place - place).norm()).fold(0.0, f64::max);
    Cluster { whole: Dipole { place, strength, core: 0.0 }, radius, points }
}
