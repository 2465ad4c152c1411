//! Regular cells around points, to look up those near a place.

use std::ops::Range;

use cosplat_core::boundary::{Vec3, add, sub};

/// Most cells for each point: what is spread out wide gets wider cells.
const MOST_PER_POINT: f64 = 8.0;

/// Points sorted by cell; of one cell, in the given order.
#[derive(Clone, Debug, Default)]
pub(crate) struct Cells {
    low: Vec3,
    side: f64,
    size: [usize; 3],
    begin: Vec<u32>,
    items: Vec<u32>,
}

impl Cells {
    /// Sorts finite points into cells of at least `side` \[m\].
    pub(crate) fn new(points: &[Vec3], side: f64) -> Self {
        let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
        for p in points {
            low = std::array::from_fn(|k| low[k].min(p[k]));
            high = std::array::from_fn(|k| high[k].max(p[k]));
        }
        if points.is_empty() {
            return Self::default();
        }
        let room = MOST_PER_POINT * points.len() as f64;
        let cells = |side: f64| [0, 1, 2].map(|k| ((high[k] - low[k]) / side).floor() + 1.0);
        let mut side = side;
        while cells(side).iter().product::<f64>() > room {
            side *= 1.5;
        }
        let size = cells(side).map(|n| n as usize);
        let mut found = Self { low, side, size, begin: vec![0; size[0] * size[1] * size[2] + 1], items: Vec::new() };
        let place: Vec<usize> = points.iter().map(|&p| found.index(found.cell(p))).collect();
        for &cell in &place {
            found.begin[cell + 1] += 1;
        }
        for i in 1..found.begin.len() {
            found.begin[i] += found.begin[i - 1];
        }
        let mut next = found.begin.clone();
        found.items = vec![0; points.len()];
        for (i, &cell) in place.iter().enumerate() {
            found.items[next[cell] as usize] = i as u32;
            next[cell] += 1;
        }
        found
    }

    fn cell(&self, p: Vec3) -> [usize; 3] {
        // A conversion stops at zero and at the last cell.
        [0, 1, 2].map(|k| (((p[k] - self.low[k]) / self.side) as usize).min(self.size[k] - 1))
    }

    fn index(&self, [i, j, k]: [usize; 3]) -> usize {
        (i * self.size[1] + j) * self.size[2] + k
    }

    /// Points in the order of the cells.
    pub(crate) fn items(&self) -> &[u32] {
        &self.items
    }

    /// Calls `f` with ranges of [`Cells::items`]: all points of the cells that a box about `p` touches, in a fixed order.
    pub(crate) fn near(&self, p: Vec3, reach: Vec3, mut f: impl FnMut(Range<usize>)) {
        if self.items.is_empty() {
            return;
        }
        let (from, to) = (self.cell(sub(p, reach)), self.cell(add(p, reach)));
        for i in from[0]..=to[0] {
            for j in from[1]..=to[1] {
                let (first, last) = (self.index([i, j, from[2]]), self.index([i, j, to[2]]));
                f(self.begin[first] as usize..self.begin[last + 1] as usize);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use cosplat_core::boundary::norm;

    #[test]
    fn nobody_within_reach_is_missed() {
        let points: Vec<Vec3> =
            (0..500).map(|i| f64::from(i) * 0.37).map(|t| [t.sin(), (1.7 * t).cos(), 0.3 * (0.9 * t).sin()]).collect();
        let cells = Cells::new(&points, 0.1);
        for (i, &p) in points.iter().enumerate() {
            let mut found = Vec::new();
            cells.near(p, [0.15; 3], |range| found.extend(cells.items()[range].iter().map(|&k| k as usize)));
            let wanted = (0..points.len()).filter(|&k| norm(sub(points[k], p)) < 0.15);
            assert!(wanted.into_iter().all(|k| found.contains(&k)), "{i}");
        }
        Cells::new(&[], 0.1).near([0.0; 3], [1.0; 3], |_| panic!("nobody is there"));
    }
}
