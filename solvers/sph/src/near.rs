//! Lists of what is near: kept until something has moved by the skin.

use rayon::prelude::*;

use crate::lanes::LANES;

/// Particles in a chunk: work is shared out and sums are taken chunk by chunk, whatever the number of threads.
pub(crate) const CHUNK: usize = 128;

/// Lists of equal chunks of rows.
#[derive(Clone, Debug, Default)]
pub(crate) struct Lists(Vec<Rows>);

/// Lists of the rows of one chunk.
#[derive(Clone, Debug, Default)]
pub(crate) struct Rows {
    ends: Vec<u32>,
    all: Vec<u32>,
}

impl Rows {
    /// List of a row of the chunk.
    #[inline]
    pub(crate) fn row(&self, i: usize) -> &[u32] {
        let from = if i == 0 { 0 } else { self.ends[i - 1] };
        &self.all[from as usize..self.ends[i] as usize]
    }

    /// Length of all lists.
    pub(crate) fn len(&self) -> usize {
        self.all.len()
    }

    fn fill(&mut self, rows: usize, (group, nobody): (usize, u32), mut list: impl FnMut(usize, &mut Vec<u32>)) {
        self.ends.clear();
        self.all.clear();
        for i in 0..rows {
            list(i, &mut self.all);
            self.all.resize(self.all.len().next_multiple_of(group), nobody);
            self.ends.push(self.all.len() as u32);
        }
    }
}

impl Lists {
    /// Chunks.
    pub(crate) fn chunks(&self) -> &[Rows] {
        &self.0
    }

    /// For `rows` rows, what `list(row, target)` adds to each, filled up with `nobody` to whole groups of so many.
    pub(crate) fn make(
        &mut self,
        rows: usize,
        (group, nobody): (usize, usize),
        parallel: bool,
        list: &(impl Fn(usize, &mut Vec<u32>) + Sync),
    ) {
        self.0.resize(rows.div_ceil(CHUNK), Rows::default());
        let one = |(c, chunk): (usize, &mut Rows)| {
            let fill = (group, nobody as u32);
            chunk.fill((rows - c * CHUNK).min(CHUNK), fill, |i, all| list(c * CHUNK + i, all));
        };
        if parallel {
            self.0.par_iter_mut().enumerate().for_each(one);
        } else {
            self.0.iter_mut().enumerate().for_each(one);
        }
    }

    /// The other way round: for each of `rows` rows the `from` rows of `self` that list it, in rising order, and `from`
    /// itself up to whole groups of lanes.
    pub(crate) fn transposed(&self, from: usize, rows: usize) -> (Vec<u32>, Vec<u32>) {
        let mut first = vec![0_u32; rows + 1];
        for &i in self.0.iter().flat_map(|c| &c.all).filter(|i| (**i as usize) < rows) {
            first[i as usize + 1] += 1;
        }
        for i in 0..rows {
            first[i + 1] = first[i] + first[i + 1].next_multiple_of(LANES as u32);
        }
        let mut next = first.clone();
        let mut all = vec![from as u32; first[rows] as usize];
        for (c, chunk) in self.0.iter().enumerate() {
            for row in 0..chunk.ends.len() {
                for i in chunk.row(row).iter().map(|&i| i as usize).filter(|&i| i < rows) {
                    all[next[i] as usize] = (c * CHUNK + row) as u32;
                    next[i] += 1;
                }
            }
        }
        (first, all)
    }
}

/// Calls `f(chunk, its items, its output)` for equal chunks of `items`, on one thread or several.
pub(crate) fn for_chunks<T: Send, U: Send>(
    parallel: bool,
    items: &mut [T],
    outputs: &mut [U],
    f: &(impl Fn(usize, &mut [T], &mut U) + Sync),
) {
    if parallel {
        items.par_chunks_mut(CHUNK).zip(outputs).enumerate().for_each(|(c, (items, out))| f(c, items, out));
    } else {
        items.chunks_mut(CHUNK).zip(outputs).enumerate().for_each(|(c, (items, out))| f(c, items, out));
    }
}
