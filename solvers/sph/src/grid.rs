//! A uniform grid of cells over the particles: physical sorting and the search for what is near.

use cosplat_core::boundary::{Vec3, dot, sub};

/// Cells beyond this number and eight a particle are made larger instead.
const MOST_CELLS: f64 = 1e6;

/// Particles by cell, x running fastest, so that three neighbouring cells are one run.
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
        let mut cell = reach;
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

    /// Whether the cells around `x` hold a particle at all.
    pub(crate) fn occupied(&self, x: Vec3) -> bool {
        let mut any = false;
        self.rows(x, |from, to| any |= from < to);
        any
    }

    /// Calls `found` with every particle closer than `reach` to `x`, in rising order. `sorted` are the positions that the
    /// grid was made for, sorted; `reach` is at most what it was made for.
    #[inline]
    pub(crate) fn near(&self, sorted: &[Vec3], x: Vec3, reach: f64, mut found: impl FnMut(usize)) {
        let square = reach * reach;
        self.rows(x, |from, to| {
            for (i, &other) in sorted[from..to].iter().enumerate() {
                let apart = sub(x, other);
                if dot(apart, apart) < square {
                    found(from + i);
                }
            }
        });
    }

    /// Calls `found` with the runs of particles in the cells around `x`.
    #[inline]
    fn rows(&self, x: Vec3, mut found: impl FnMut(usize, usize)) {
        if self.first.is_empty() {
            return;
        }
        let at = [0, 1, 2].map(|k| ((x[k] - self.low[k]) * self.inverse).floor());
        if (0..3).any(|k| !(at[k] >= -1.0 && at[k] <= self.size[k] as f64)) {
            return;
        }
        let range = |k: usize| {
            let last = self.size[k] as f64 - 1.0;
            (at[k] - 1.0).clamp(0.0, last) as usize..=(at[k] + 1.0).clamp(0.0, last) as usize
        };
        let xs = range(0);
        for k in range(2) {
            for j in range(1) {
                let row = (k * self.size[1] + j) * self.size[0];
                found(self.first[row + xs.start()] as usize, self.first[row + xs.end() + 1] as usize);
            }
        }
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
        }
        Grid::new(&[], 0.1).0.near(&[], [0.0; 3], 0.1, |_| panic!("nothing is there"));
    }
}
