//! What hangs together: sets of Gaussians whose cells touch.

use std::collections::{BTreeMap, BTreeSet};

use crate::grid::Grid;
use crate::linalg::wide;
use crate::splats::Splats;

/// Gaussians more transparent than this join nothing; they go with what they lie on.
pub const SOLID: f64 = 0.1;
/// The gap that is bridged by default, in typical distances.
const GAP: f64 = 2.0;
/// Neighbours whose distance is typical: within a surface, and not within a pair of copies.
const NEIGHBOURS: usize = 8;
/// A faint Gaussian belongs to what is within this many of its standard deviations.
const SIGMAS: f64 = 2.0;
/// But not farther than this many cells: haze has blobs of any size.
const FARTHEST: f64 = 8.0;

/// Sets of Gaussians, each ascending; the largest first, then by first index.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Components {
    /// Edge of the cells, in units of the splats.
    pub cell: f64,
    /// Indices of each set: solid ones and the faint ones that lie on them.
    pub sets: Vec<Vec<u32>>,
    /// Indices of faint Gaussians that lie on nothing, and of those that are not finite.
    pub alone: Vec<u32>,
}

type Cell = [i64; 3];

/// Sorts all Gaussians by what they hang together with. Without a `cell`, twice the median distance of the eighth
/// neighbour of those that are solid.
pub fn components(splats: &Splats, cell: Option<f64>) -> Components {
    let finite = |i: usize| splats.positions[i].iter().all(|v| v.is_finite());
    let solid: Vec<u32> =
        (0..splats.len()).filter(|&i| finite(i) && splats.opacity(i) >= SOLID).map(|i| i as u32).collect();
    let edge = cell.unwrap_or_else(|| typical(splats, &solid));
    let edge = if edge.is_finite() && edge > 0.0 { edge } else { 1.0 };
    let cell_of = |i: u32| splats.positions[i as usize].map(|v| (f64::from(v) / edge).floor() as i64);
    let mut left: BTreeSet<Cell> = solid.iter().map(|&i| cell_of(i)).collect();
    let mut of_cell: BTreeMap<Cell, usize> = BTreeMap::new();
    let mut count = 0;
    while let Some(first) = left.pop_first() {
        let mut open = vec![first];
        while let Some(c) = open.pop() {
            of_cell.insert(c, count);
            for n in 0..27 {
                let next = [c[0] + n / 9 - 1, c[1] + n / 3 % 3 - 1, c[2] + n % 3 - 1];
                if left.remove(&next) {
                    open.push(next);
                }
            }
        }
        count += 1;
    }
    let points: Vec<[f32; 3]> = solid.iter().map(|&i| splats.positions[i as usize]).collect();
    let grid = Grid::new(&points);
    let (mut sets, mut alone, mut found) = (vec![Vec::new(); count], Vec::new(), Vec::new());
    for i in 0..splats.len() {
        if !finite(i) {
            alone.push(i as u32);
            continue;
        }
        if splats.opacity(i) >= SOLID {
            sets[of_cell[&cell_of(i as u32)]].push(i as u32);
            continue;
        }
        grid.nearest(wide(splats.positions[i]), 1, &mut found);
        let sigma = splats.scales(i).into_iter().fold(0.0, f64::max);
        let reach = (SIGMAS * sigma).min(FARTHEST * edge).max(edge);
        match found.first().filter(|n| n.0 <= reach * reach) {
            Some(&(_, n)) => sets[of_cell[&cell_of(solid[n as usize])]].push(i as u32),
            None => alone.push(i as u32),
        }
    }
    sets.sort_by_key(|set: &Vec<u32>| (std::cmp::Reverse(set.len()), set.first().copied()));
    Components { cell: edge, sets, alone }
}

/// Twice the median distance of the eighth neighbour.
fn typical(splats: &Splats, solid: &[u32]) -> f64 {
    let points: Vec<[f32; 3]> = solid.iter().map(|&i| splats.positions[i as usize]).collect();
    let grid = Grid::new(&points);
    let mut found = Vec::new();
    // The median of some thousand is known well enough.
    let step = (points.len() / 4000).max(1);
    let distance = |p: &[f32; 3]| {
        grid.nearest(wide(*p), NEIGHBOURS + 1, &mut found);
        found.last().map_or(0.0, |n| n.0.sqrt())
    };
    let mut all: Vec<f64> = points.iter().step_by(step).map(distance).collect();
    all.sort_by(f64::total_cmp);
    all.get(all.len() / 2).map_or(0.0, |d| GAP * d)
}

/// How many times longer a Gaussian is than the wider of its two other sides; that of a disk is one.
pub fn needle(splats: &Splats, index: usize) -> f64 {
    let mut scales = splats.scales(index);
    scales.sort_by(f64::total_cmp);
    scales[2] / scales[1].max(f64::MIN_POSITIVE)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn block(at: f32, count: usize) -> impl Iterator<Item = [f32; 3]> {
        (0..count).map(move |i| [at + (i % 5) as f32 * 0.1, (i / 5 % 5) as f32 * 0.1, (i / 25) as f32 * 0.1])
    }

    #[test]
    fn pieces_are_told_apart_and_fringes_go_along() {
        // A faint wide one on the second piece, a faint one in the air, and one that is nowhere.
        let others = [[5.2, 0.2, 0.5], [2.5, 0.0, 0.0], [f32::NAN, 0.0, 0.0]];
        let positions: Vec<[f32; 3]> = block(0.0, 125).chain(block(5.0, 50)).chain(others).collect();
        let n = positions.len();
        let (log_scales, opacity_logits) = (vec![[-3.0; 3]; n], vec![3.0; n]);
        let mut splats = Splats { positions, log_scales, opacity_logits, ..Splats::default() };
        splats.log_scales[175] = [-1.0, -1.0, -6.0];
        splats.opacity_logits[175..].fill(-4.0);
        let found = components(&splats, None);
        assert_eq!(found.sets.iter().map(Vec::len).collect::<Vec<_>>(), [125, 51]);
        assert_eq!((found.sets[1].last(), &found.alone[..]), (Some(&175), &[176, 177][..]));
        // A gap as wide as the distance joins them.
        assert_eq!(components(&splats, Some(5.0)).sets.len(), 1);
        assert_eq!(components(&Splats::default(), None).sets.len(), 0);
        assert!((needle(&splats, 0) - 1.0).abs() < 1e-6 && (needle(&splats, 175) - 1.0).abs() < 1e-6);
    }
}
