//! A uniform grid of cells over the particles: physical sorting and the search for what is near.

use cosplat_core::boundary::{Vec3, dot, sub};
use fearless_simd::{Level, Simd, dispatch, f64x8, mask32x8, prelude::*, u32x8};

use crate::single::WIDE;

/// Cells beyond this number and eight a particle are made larger instead.
const MOST_CELLS: f64 = 1e6;

/// Cells over the reach of a search: what is looked at around a place is 2.5 times as large as the sphere that is searched, and
/// 4.9 times with cells as wide as the reach (means over places; without leaving out what is too far in a row, 6.4).
const FINENESS: f64 = 0.5;

/// Places by which a list grows beyond what it may need at once.
const ROOM: usize = 64 + WIDE;

/// Particles by cell, x running fastest, so that neighbouring cells in a row are one run.
#[derive(Clone, Debug, Default)]
pub(crate) struct Grid {
    low: Vec3,
    inverse: f64,
    size: [usize; 3],
    /// First particle of each cell, and the end.
    first: Vec<u32>,
}

impl Grid {
    /// For particles at `x` \[m\] and a search up to `reach` \[m\]; with the order in which they are to be sorted.
    pub(crate) fn new(x: &[Vec3], reach: f64) -> (Self, Vec<u32>) {
        let fold = |f: fn(f64, f64) -> f64, start: f64| [0, 1, 2].map(|k| x.iter().map(|x| x[k]).fold(start, f));
        let (low, high) = (fold(f64::min, f64::INFINITY), fold(f64::max, f64::NEG_INFINITY));
        if x.is_empty() {
            return (Self::default(), Vec::new());
        }
        let mut cell = FINENESS * reach;
        let cells = |cell: f64| [0, 1, 2].map(|k| ((high[k] - low[k]) / cell).floor() + 1.0);
        while cells(cell).iter().product::<f64>() > MOST_CELLS.max(8.0 * x.len() as f64) {
            cell *= 2.0;
        }
        let size = cells(cell).map(|n| n as usize);
        let mut grid = Self { low, inverse: 1.0 / cell, size, first: vec![0; size[0] * size[1] * size[2] + 1] };
        let keys: Vec<u32> = x.iter().map(|&x| grid.key(x)).collect();
        for &key in &keys {
            grid.first[key as usize + 1] += 1;
        }
        for i in 1..grid.first.len() {
            grid.first[i] += grid.first[i - 1];
        }
        let mut next = grid.first.clone();
        let mut order = vec![0; x.len()];
        for (i, &key) in keys.iter().enumerate() {
            order[next[key as usize] as usize] = i as u32;
            next[key as usize] += 1;
        }
        (grid, order)
    }

    fn key(&self, x: Vec3) -> u32 {
        let c = [0, 1, 2].map(|k| (((x[k] - self.low[k]) * self.inverse) as usize).min(self.size[k] - 1));
        ((c[2] * self.size[1] + c[1]) * self.size[0] + c[0]) as u32
    }

    /// Whether the cells within `reach` of `x` hold a particle at all.
    pub(crate) fn occupied(&self, x: Vec3, reach: f64) -> bool {
        let mut any = false;
        self.rows(x, reach, |from, to| any |= from < to);
        any
    }

    /// Calls `found` with every particle closer than `reach` to `x`, in rising order. `sorted` are the positions that the
    /// grid was made for, sorted.
    #[inline]
    pub(crate) fn near(&self, sorted: &[Vec3], x: Vec3, reach: f64, mut found: impl FnMut(usize)) {
        let square = reach * reach;
        self.rows(x, reach, |from, to| {
            for (i, &other) in sorted[from..to].iter().enumerate() {
                let apart = sub(x, other);
                if dot(apart, apart) < square {
                    found(from + i);
                }
            }
        });
    }

    /// Adds to a list every particle closer than `reach` to `x` but `one`, in rising order.
    pub(crate) fn list(&self, sorted: &Sorted, x: Vec3, reach: f64, one: u32, list: &mut Vec<u32>) {
        dispatch!(Level::new(), simd => self.list_with(simd, sorted, x, reach, one, list));
    }

    #[inline(always)]
    #[expect(clippy::inline_always, reason = "as said in `lanes`")]
    fn list_with<S: Simd>(&self, simd: S, sorted: &Sorted, x: Vec3, reach: f64, one: u32, list: &mut Vec<u32>) {
        let mut end = list.len();
        let offsets = u32x8::load_array(simd, [0, 1, 2, 3, 4, 5, 6, 7]);
        self.rows(x, reach, |from, to| {
            if list.len() < end + to - from + WIDE {
                list.resize(end + to - from + ROOM, 0);
            }
            for i in (from..to).step_by(WIDE) {
                let (near, all) = (sorted.near(simd, i, x, reach * reach), offsets + i as u32);
                let counts = near & all.simd_lt(to as u32) & all.simd_ne(one);
                // All are written, and those beyond the ones that count written over: a branch, which goes either way,
                // would be foretold badly.
                all.compress(counts).store_slice(&mut list[end..end + WIDE]);
                end += counts.to_bitmask().count_ones() as usize;
            }
        });
        list.truncate(end);
    }

    /// Calls `found` with the runs of particles in the cells that are within `reach` of `x`.
    #[inline(always)]
    #[expect(clippy::inline_always, reason = "as said in `lanes`")]
    fn rows(&self, x: Vec3, reach: f64, mut found: impl FnMut(usize, usize)) {
        if self.first.is_empty() || x.iter().any(|x| x.is_nan()) {
            return;
        }
        // In cells, and a little more than asked for: what is rounded must not leave out a cell.
        let (at, reach) = ([0, 1, 2].map(|k| (x[k] - self.low[k]) * self.inverse), reach * self.inverse * (1.0 + 1e-9));
        let range = |k: usize, reach: f64| {
            let last = self.size[k] as i64 - 1;
            // Cut towards zero, not down, which is a cell too many at most.
            let (from, to) = ((at[k] - reach) as i64, (at[k] + reach) as i64);
            (from <= last && to >= 0).then(|| (from.max(0) as usize, to.min(last) as usize))
        };
        let beside = |k: usize, cell: usize| {
            let from = cell as f64;
            (from - at[k]).max(at[k] - from - 1.0).max(0.0)
        };
        let (Some(zs), Some(ys)) = (range(2, reach), range(1, reach)) else { return };
        for k in zs.0..=zs.1 {
            for j in ys.0..=ys.1 {
                let left = reach * reach - beside(2, k).powi(2) - beside(1, j).powi(2);
                if left < 0.0 {
                    continue;
                }
                let Some(xs) = range(0, left.sqrt()) else { continue };
                let row = (k * self.size[1] + j) * self.size[0];
                found(self.first[row + xs.0] as usize, self.first[row + xs.1 + 1] as usize);
            }
        }
    }
}

/// Places by coordinates, for as many at once as fit the lanes.
#[derive(Clone, Debug, Default)]
pub(crate) struct Sorted([Vec<f64>; 3]);

impl Sorted {
    /// Of those positions \[m\].
    pub(crate) fn new(x: &[Vec3]) -> Self {
        // As many more as a group may reach beyond the last one.
        Self([0, 1, 2].map(|k| x.iter().map(|x| x[k]).chain([f64::NAN; WIDE]).collect()))
    }

    /// Which of those from `i` on are nearer to `x` than the root of `square`.
    #[inline(always)]
    #[expect(clippy::inline_always, reason = "as said in `lanes`")]
    fn near<S: Simd>(&self, simd: S, i: usize, x: Vec3, square: f64) -> mask32x8<S> {
        let [u, v, w] = &self.0;
        let u = x[0] - f64x8::from_slice(simd, &u[i..i + WIDE]);
        let v = x[1] - f64x8::from_slice(simd, &v[i..i + WIDE]);
        let w = x[2] - f64x8::from_slice(simd, &w[i..i + WIDE]);
        mask32x8::from_bitmask(simd, (u * u + v * v + w * w).simd_lt(square).to_bitmask())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn everything_near_is_found_once_and_in_order() {
        let mut x: Vec<Vec3> = (0..500).map(|i| [0.37, 0.61, 0.83].map(|a| (f64::from(i) * a).fract())).collect();
        x.push([40.0, -30.0, 1e5]);
        let (grid, order) = Grid::new(&x, 0.2);
        let sorted: Vec<Vec3> = order.iter().map(|&i| x[i as usize]).collect();
        for probe in [[0.5; 3], [0.0, 1.0, 0.3], [-0.1, 0.5, 0.5], [9.0; 3], [40.0, -30.0, 1e5]] {
            let mut found = Vec::new();
            grid.near(&sorted, probe, 0.2, |i| found.push(i));
            let close = |x: &Vec3| dot(sub(*x, probe), sub(*x, probe)) < 0.04;
            let expected: Vec<usize> = (0..sorted.len()).filter(|&i| close(&sorted[i])).collect();
            assert_eq!(found, expected, "{probe:?}");
            let mut listed = vec![7];
            let one = expected.get(1).map_or(u32::MAX, |&i| i as u32);
            grid.list(&Sorted::new(&sorted), probe, 0.2, one, &mut listed);
            let mut narrow = vec![7];
            let places = Sorted::new(&sorted);
            dispatch!(Level::baseline(), simd => grid.list_with(simd, &places, probe, 0.2, one, &mut narrow));
            assert_eq!(listed, narrow, "whatever the registers");
            let wanted = expected.iter().map(|&i| i as u32).filter(|&i| i != one);
            assert_eq!(listed, std::iter::once(7).chain(wanted).collect::<Vec<_>>(), "{probe:?}");
        }
        Grid::new(&[], 0.1).0.near(&[], [0.0; 3], 0.1, |_| panic!("nothing is there"));
    }
}
