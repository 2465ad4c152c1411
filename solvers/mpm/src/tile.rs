//! A particle block's private copy of the nodes it writes or reads, and the part of it in use.

use crate::real::Real;
use crate::topology::{NONE, REACH};

/// Nodes along an edge of a tile.
pub(crate) const EDGE: usize = 8;
/// Nodes of a tile.
pub(crate) const TILE: usize = EDGE * EDGE * EDGE;
/// Nodes of a grid block.
pub(crate) const NODES: usize = 64;

/// Four numbers at each node: momentum and mass on the way to the grid, velocity and mass on the way back.
pub(crate) type Tile<R> = [<R as Real>::V; TILE];
/// The same for a grid block.
pub(crate) type Nodes<R> = [<R as Real>::V; NODES];

/// Node `n` of the grid block at `at` in the world \[m\].
pub(crate) fn node_position(at: [i32; 3], n: usize, dx: f64) -> [f64; 3] {
    let local = [n / 16, n / 4 % 4, n % 4];
    [0, 1, 2].map(|k| (4.0 * f64::from(at[k]) + local[k] as f64) * dx)
}

/// Nodes in use along each axis.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Extent {
    /// First.
    pub(crate) lo: [u8; 3],
    /// After the last.
    pub(crate) hi: [u8; 3],
}

impl Extent {
    /// Part of it inside the neighbour at that offset, as ranges of tile nodes.
    fn within(self, axis: usize, offset: usize) -> (usize, usize) {
        let reach = &REACH[offset].0;
        (reach.start.max(self.lo[axis] as usize), reach.end.min(self.hi[axis] as usize))
    }

    /// Calls `f(start in the tile, start in the neighbour, length)` for each run of nodes along z that it shares with
    /// neighbour `i` of 27.
    #[inline]
    pub(crate) fn runs(self, i: usize, mut f: impl FnMut(usize, usize, usize)) {
        let parts = [i / 9, i / 3 % 3, i % 3];
        let [(x0, x1), (y0, y1), (z0, z1)] = [0, 1, 2].map(|axis| self.within(axis, parts[axis]));
        if z0 >= z1 {
            return;
        }
        let inside = |axis: usize, t: usize| t - REACH[parts[axis]].0.start + REACH[parts[axis]].1;
        for x in x0..x1 {
            for y in y0..y1 {
                f((x * EDGE + y) * EDGE + z0, (inside(0, x) * 4 + inside(1, y)) * 4 + inside(2, z0), z1 - z0);
            }
        }
    }

    /// Whether it has nodes in neighbour `i` of 27.
    pub(crate) fn touches(self, i: usize) -> bool {
        let parts = [i / 9, i / 3 % 3, i % 3];
        (0..3).all(|axis| {
            let (a, b) = self.within(axis, parts[axis]);
            a < b
        })
    }

    /// Zeroes it.
    pub(crate) fn clear<R: Real>(self, tile: &mut Tile<R>) {
        for x in self.lo[0]..self.hi[0] {
            for y in self.lo[1]..self.hi[1] {
                let row = (x as usize * EDGE + y as usize) * EDGE;
                tile[row + self.lo[2] as usize..row + self.hi[2] as usize].fill(R::V::default());
            }
        }
    }

    /// Fills its nodes from the grid.
    pub(crate) fn load<R: Real>(self, tile: &mut Tile<R>, reached: &[u32; 27], grid: &[Nodes<R>]) {
        for (i, &entry) in reached.iter().enumerate() {
            if entry != NONE {
                let nodes = &grid[entry as usize];
                self.runs(i, |t, n, length| {
                    // Runs are short: a loop is faster than a call that copies.
                    for (to, from) in tile[t..t + length].iter_mut().zip(&nodes[n..n + length]) {
                        *to = *from;
                    }
                });
            }
        }
    }
}
