//! Which ellipses each tile sees, nearest first.

use rayon::prelude::*;

use crate::project::Ellipse;

/// Width and height of a tile, in pixels.
pub(crate) const TILE: usize = 16;

/// Ellipses by depth and, for every tile, the range of its list.
pub(crate) struct Tiles<F> {
    /// Nearest first; equal depths in the order of the Gaussians.
    pub(crate) ellipses: Vec<Ellipse>,
    /// What is gathered beside their colours, in the same order.
    pub(crate) features: Vec<F>,
    /// Indices into `ellipses`, ascending within a tile.
    lists: Vec<u32>,
    /// Start of each tile's list, and the end of the last.
    starts: Vec<usize>,
    across: usize,
}

impl<F: Copy + Send + Sync> Tiles<F> {
    /// Sorts and bins.
    pub(crate) fn new(visible: &[Ellipse], beside: &[F], width: usize, height: usize) -> Tiles<F> {
        // Depths are positive, so their bits sort as they do; the index makes every key different.
        let mut keys: Vec<u64> =
            visible.par_iter().enumerate().map(|(i, e)| u64::from(e.depth.to_bits()) << 32 | i as u64).collect();
        keys.par_sort_unstable();
        let ellipses: Vec<Ellipse> = keys.par_iter().map(|&key| visible[key as u32 as usize]).collect();
        let features = keys.par_iter().map(|&key| beside[key as u32 as usize]).collect();
        let (across, down) = (width.div_ceil(TILE), height.div_ceil(TILE));
        let mut starts = vec![0_usize; across * down + 1];
        for e in &ellipses {
            for_tiles(e, across, |tile| starts[tile + 1] += 1);
        }
        for tile in 0..across * down {
            starts[tile + 1] += starts[tile];
        }
        let mut next = starts.clone();
        let mut lists = vec![0_u32; starts[across * down]];
        for (i, e) in ellipses.iter().enumerate() {
            for_tiles(e, across, |tile| {
                lists[next[tile]] = i as u32;
                next[tile] += 1;
            });
        }
        Tiles { ellipses, features, lists, starts, across }
    }

    /// Ellipses of a tile, nearest first.
    pub(crate) fn of(&self, column: usize, row: usize) -> &[u32] {
        let tile = row * self.across + column;
        &self.lists[self.starts[tile]..self.starts[tile + 1]]
    }
}

fn for_tiles(e: &Ellipse, across: usize, mut visit: impl FnMut(usize)) {
    let range = |pixels: [u16; 2]| usize::from(pixels[0]) / TILE..(usize::from(pixels[1]) - 1) / TILE + 1;
    for row in range(e.rows) {
        for column in range(e.columns) {
            visit(row * across + column);
        }
    }
}
