//! Who is near: a uniform grid over points, and lists of pairs.

use cosplat_core::boundary::{Vec3, dot, scale, sub};
use rayon::prelude::*;

/// Cells beyond this number are made larger instead.
const MOST_CELLS: f64 = 1e6;
/// Points in a chunk of lists: what is in one cannot depend on who makes it.
pub(crate) const CHUNK: usize = 256;

/// Points by cell.
#[derive(Clone, Debug, Default)]
pub(crate) struct Cells {
    low: Vec3,
    inverse: f64,
    size: [usize; 3],
    /// First of each cell in `order`, and the end.
    first: Vec<u32>,
    order: Vec<u32>,
}

impl Cells {
    /// For points \[m\] and searches up to `reach` \[m\].
    pub(crate) fn new(points: &[Vec3], reach: f64) -> Self {
        if points.is_empty() {
            return Self::default();
        }
        let fold = |f: fn(f64, f64) -> f64, start: f64| [0, 1, 2].map(|k| points.iter().map(|x| x[k]).fold(start, f));
        let (low, high) = (fold(f64::min, f64::INFINITY), fold(f64::max, f64::NEG_INFINITY));
        let mut cell = reach;
        let cells = |cell: f64| [0, 1, 2].map(|k| ((high[k] - low[k]) / cell).floor() + 1.0);
        while cells(cell).iter().product::<f64>() > MOST_CELLS {
            cell *= 2.0;
        }
        let size = cells(cell).map(|n| n as usize);
        let mut made =
            Self { low, inverse: 1.0 / cell, size, first: vec![0; size[0] * size[1] * size[2] + 1], order: Vec::new() };
        let keys: Vec<usize> = points.iter().map(|&x| made.key(made.cell(x).map(|c| c.max(0) as usize))).collect();
        for key in &keys {
            made.first[key + 1] += 1;
        }
        for i in 1..made.first.len() {
            made.first[i] += made.first[i - 1];
        }
        let mut next = made.first.clone();
        made.order = vec![0; points.len()];
        for (i, &key) in keys.iter().enumerate() {
            made.order[next[key] as usize] = i as u32;
            next[key] += 1;
        }
        made
    }

    fn cell(&self, x: Vec3) -> [isize; 3] {
        [0, 1, 2].map(|k| ((x[k] - self.low[k]) * self.inverse).floor().clamp(-2.0, self.size[k] as f64 + 1.0) as isize)
    }

    fn key(&self, cell: [usize; 3]) -> usize {
        let [x, y, z] = [0, 1, 2].map(|k| cell[k].min(self.size[k] - 1));
        (z * self.size[1] + y) * self.size[0] + x
    }

    /// Calls `found` with all points in the cells around `x` \[m\].
    pub(crate) fn around(&self, x: Vec3, mut found: impl FnMut(usize)) {
        if self.first.is_empty() {
            return;
        }
        let cell = self.cell(x);
        let [low, high] = [-1, 1].map(|by| [0, 1, 2].map(|k| (cell[k] + by).clamp(0, self.size[k] as isize) as usize));
        for z in low[2]..=high[2].min(self.size[2] - 1) {
            for y in low[1]..=high[1].min(self.size[1] - 1) {
                if low[0] >= self.size[0] {
                    continue;
                }
                let row = [low[0], high[0]].map(|x| self.key([x, y, z]));
                let run = self.first[row[0]] as usize..self.first[row[1] + 1] as usize;
                self.order[run].iter().for_each(|&i| found(i as usize));
            }
        }
    }
}

/// A neighbour and the unit vector from it \[1\].
#[derive(Clone, Copy, Debug)]
pub(crate) struct Pair {
    pub(crate) other: u32,
    pub(crate) away: Vec3,
}

/// Pairs of a chunk of points: ends of their rows, and the pairs.
type Rows = (Vec<u32>, Vec<Pair>);

/// Neighbours of all points.
#[derive(Clone, Debug, Default)]
pub(crate) struct Pairs(Vec<Rows>);

impl Pairs {
    /// Those within `reach` \[m\]; two points in one place have no line between them and are none.
    pub(crate) fn new(points: &[Vec3], reach: f64, parallel: bool) -> Self {
        let cells = Cells::new(points, reach);
        let chunk = |(c, part): (usize, &[Vec3])| {
            let (mut ends, mut pairs) = (Vec::with_capacity(part.len()), Vec::with_capacity(32 * part.len()));
            for (i, &x) in part.iter().enumerate() {
                cells.around(x, |j| {
                    let apart = sub(x, points[j]);
                    let square = dot(apart, apart);
                    if square < reach * reach && square > 0.0 && j != c * CHUNK + i {
                        pairs.push(Pair { other: j as u32, away: scale(apart, 1.0 / square.sqrt()) });
                    }
                });
                ends.push(pairs.len() as u32);
            }
            (ends, pairs)
        };
        Self(if parallel {
            points.par_chunks(CHUNK).enumerate().map(chunk).collect()
        } else {
            points.chunks(CHUNK).enumerate().map(chunk).collect()
        })
    }

    /// Sets `out[i]` to `each(i, neighbours of i)`.
    pub(crate) fn each<T: Send>(&self, out: &mut [T], parallel: bool, each: &(impl Fn(usize, &[Pair]) -> T + Sync)) {
        let chunk = |(c, (out, (ends, pairs))): (usize, (&mut [T], &Rows))| {
            let mut from = 0;
            for (i, (out, &end)) in out.iter_mut().zip(ends).enumerate() {
                *out = each(c * CHUNK + i, &pairs[from..end as usize]);
                from = end as usize;
            }
        };
        if parallel {
            out.par_chunks_mut(CHUNK).zip(&self.0).enumerate().for_each(chunk);
        } else {
            out.chunks_mut(CHUNK).zip(&self.0).enumerate().for_each(chunk);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use cosplat_core::boundary::norm;

    #[test]
    fn pairs_are_those_that_a_search_of_all_finds() {
        // A spiral through several cells, with two points in one place and one far away.
        let mut points: Vec<Vec3> = (0..700_u32)
            .map(|i| {
                let t = f64::from(i) * 0.37;
                [0.4 * t.sin(), 0.4 * (1.7 * t).cos(), 0.3 * (2.3 * t).sin()]
            })
            .collect();
        points.push(points[3]);
        points.push([1e6, 0.0, -1e6]);
        for parallel in [false, true] {
            let mut found = vec![Vec::new(); points.len()];
            Pairs::new(&points, 0.1, parallel).each(&mut found, parallel, &|_, pairs| {
                let mut all: Vec<_> = pairs.iter().map(|p| p.other as usize).collect();
                all.sort_unstable();
                all
            });
            for (i, found) in found.iter().enumerate() {
                let near = |j: &usize| {
                    let d = norm(sub(points[i], points[*j]));
                    d > 0.0 && d < 0.1
                };
                assert_eq!(found, &(0..points.len()).filter(near).collect::<Vec<_>>(), "{i}");
            }
        }
    }
}
