//! Which samples of the closed surface become transparent Gaussians.

use std::collections::{BTreeMap, BTreeSet};

use nalgebra::Vector3;
use rayon::prelude::*;

use super::{Chosen, Pruning, Settings, Thinning};
use crate::grid::Grid;
use crate::linalg::wide;

/// Guard, thinning and pruning, in the order of the seed's Algorithm 1.
pub(super) fn choose(samples: &[[f64; 3]], points: &[[f32; 3]], settings: &Settings) -> Chosen {
    let mut chosen = Chosen { samples: samples.len(), ..Chosen::default() };
    let distances = distances(samples, points, settings.reach);
    let occupied = occupancy(points, settings.pruning);
    for (i, (sample, distance)) in samples.iter().zip(distances).enumerate() {
        let place = sample.map(|v| v as f32);
        let Some(distance) = distance else {
            chosen.beyond += 1;
            continue;
        };
        if settings.thinning.is_some_and(|t| unit(settings.seed, i as u64) >= t.probability(distance)) {
            chosen.thinned += 1;
            continue;
        }
        let dense = match settings.pruning {
            Pruning::None => false,
            Pruning::Nearest(least) => distance < least,
            Pruning::Occupancy { edge, most } => occupied.get(&voxel(place, edge)).is_some_and(|n| *n >= most),
        };
        if dense {
            chosen.dense += 1;
            continue;
        }
        chosen.places.push(place);
    }
    chosen
}

impl Thinning {
    /// p = max(`least`, min(1, (d / `full`)^`power`)).
    pub fn probability(&self, distance: f64) -> f64 {
        (distance / self.full).powf(self.power).min(1.0).max(self.least)
    }
}

/// Distance to the nearest point, where it is within reach: of the single-precision place, which is what is kept.
fn distances(samples: &[[f64; 3]], points: &[[f32; 3]], reach: f64) -> Vec<Option<f64>> {
    let grid = Grid::new(points);
    // A search for what is far visits many cells: only samples with a point in the 27 cells of edge `reach` are asked.
    let near: BTreeSet<[i64; 3]> = points.iter().map(|p| voxel(*p, reach)).collect();
    let of = |found: &mut Vec<(f64, u32)>, sample: &[f64; 3]| {
        let place = sample.map(|v| v as f32);
        let [x, y, z] = voxel(place, reach);
        let mut around = (0..27).map(|n| [x + n / 9 - 1, y + n / 3 % 3 - 1, z + n % 3 - 1]);
        if reach > 0.0 && !around.any(|v| near.contains(&v)) {
            return None;
        }
        grid.nearest(wide(place), 1, found);
        found.first().map(|n| n.0.sqrt()).filter(|d| *d <= reach)
    };
    samples.par_iter().map_init(Vec::new, of).collect()
}

/// How many points each voxel holds, where that is asked for.
fn occupancy(points: &[[f32; 3]], pruning: Pruning) -> BTreeMap<[i64; 3], usize> {
    let mut counts = BTreeMap::new();
    if let Pruning::Occupancy { edge, .. } = pruning {
        for p in points {
            *counts.entry(voxel(*p, edge)).or_insert(0) += 1;
        }
    }
    counts
}

fn voxel(p: [f32; 3], edge: f64) -> [i64; 3] {
    // Half of the range leaves room for the neighbours.
    Vector3::from(p).map(|v| ((f64::from(v) / edge).floor() as i64).clamp(i64::MIN / 2, i64::MAX / 2)).into()
}

/// 0 to 1 from a seed and a number: `SplitMix64` (Steele, Lea, Flood 2014) at that place of its sequence.
fn unit(seed: u64, number: u64) -> f64 {
    let mut z = seed.wrapping_add(number.wrapping_add(1).wrapping_mul(0x9e37_79b9_7f4a_7c15));
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
}
