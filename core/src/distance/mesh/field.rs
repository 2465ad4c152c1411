//! Distance and direction of a mesh at the nodes of a regular grid, with linear interpolation between them.

use crate::boundary::{norm, scale};

use super::tree::Tree;
use crate::distance::Distance;

/// Nodes of the cache in a grid cell of the material, where there is room.
const PER_CELL: f64 = 4.0;
/// Most nodes: 16 bytes each.
const MOST_NODES: f64 = 1e6;
/// Width of the shell around the mesh's box, in grid cells of the material.
const SHELL: f64 = 2.0;

/// Cached distances.
#[derive(Clone, Debug)]
pub(super) struct Field {
    low: [f64; 3],
    cell: f64,
    size: [usize; 3],
    /// Distance and direction by node, z fastest.
    nodes: Vec<[f32; 4]>,
}

impl Field {
    /// Of a mesh in a box, for cells of size `dx`; nothing when even two nodes a cell would be too many.
    pub(super) fn new(tree: &Tree, low: [f64; 3], high: [f64; 3], dx: f64) -> Option<Self> {
        let shell = SHELL * dx;
        let extent = [0, 1, 2].map(|k| high[k] - low[k] + 2.0 * shell);
        let room = (extent[0] * extent[1] * extent[2] / MOST_NODES).cbrt();
        let cell = (dx / PER_CELL).max(room);
        if cell > 0.5 * dx {
            return None;
        }
        let size = extent.map(|e| (e / cell).ceil() as usize + 1);
        let low = low.map(|x| x - shell);
        let mut nodes = Vec::with_capacity(size[0] * size[1] * size[2]);
        for i in 0..size[0] {
            for j in 0..size[1] {
                for k in 0..size[2] {
                    let x = [i, j, k].map(|n| n as f64 * cell);
                    let (d, [nx, ny, nz]) = tree.distance([low[0] + x[0], low[1] + x[1], low[2] + x[2]]);
                    nodes.push([d, nx, ny, nz].map(|v| v as f32));
                }
            }
        }
        Some(Self { low, cell, size, nodes })
    }

    /// Interpolated distance and direction; nothing outside the cached box.
    pub(super) fn at(&self, x: [f64; 3]) -> Option<Distance> {
        let u = [0, 1, 2].map(|k| (x[k] - self.low[k]) / self.cell);
        if !(0..3).all(|k| u[k] >= 0.0 && u[k] < (self.size[k] - 1) as f64) {
            return None;
        }
        let base = u.map(|u| u as usize);
        let f = [0, 1, 2].map(|k| u[k] - base[k] as f64);
        let mut sum = [0.0; 4];
        for corner in 0..8 {
            let up = [corner >> 2 & 1, corner >> 1 & 1, corner & 1];
            let weight: f64 = (0..3).map(|k| if up[k] == 1 { f[k] } else { 1.0 - f[k] }).product();
            let node = ((base[0] + up[0]) * self.size[1] + base[1] + up[1]) * self.size[2] + base[2] + up[2];
            for (s, v) in sum.iter_mut().zip(self.nodes[node]) {
                *s += weight * f64::from(v);
            }
        }
        let [d, n @ ..] = sum;
        let length = norm(n);
        // Directions of opposite sides cancel in the middle of a thin sheet.
        let direction = if length > 1e-6 { scale(n, 1.0 / length) } else { [0.0, 0.0, 1.0] };
        Some((d, direction))
    }
}
