//! How fast neighbouring pieces of cloth move relative to each other, which is less than what all of them do.
//!
//! Vertices are sorted into wide cells once. Two in the same or in neighbouring cells move relative to each other at
//! most by what the velocities of 27 cells differ; two in others were at least a cell apart.

use cosplat_core::boundary::{Vec3, norm, sub};

use crate::vertex::Vertex;

/// Lowest and highest velocities \[m/s\].
type Range = (Vec3, Vec3);

/// Most cells for each vertex.
const MOST_PER_VERTEX: f64 = 2.0;

/// Of no vertex.
const NONE: Range = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);

/// Vertices by cells.
#[derive(Clone, Debug, Default)]
pub(crate) struct Patches {
    /// Side of a cell \[m\].
    pub(crate) side: f64,
    size: [usize; 3],
    cell: Vec<u32>,
    /// How far vertices in and about each cell may have moved relative to each other since \[m\].
    moved: Vec<f64>,
    /// The same and twice what the next substep may add.
    closing: Vec<f64>,
}

fn merge(a: Range, b: Range) -> Range {
    (std::array::from_fn(|k| a.0[k].min(b.0[k])), std::array::from_fn(|k| a.1[k].max(b.1[k])))
}

impl Patches {
    /// Cells of at least `side` \[m\], no more than a few for each vertex.
    pub(crate) fn new(vertices: &[Vertex], side: f64) -> Self {
        if vertices.is_empty() {
            return Self::default();
        }
        let (low, high) = vertices.iter().fold(NONE, |all, v| merge(all, (v.x, v.x)));
        let cells = |side: f64| [0, 1, 2].map(|k| ((high[k] - low[k]) / side).floor() + 1.0);
        let mut side = side;
        while cells(side).iter().product::<f64>() > MOST_PER_VERTEX * vertices.len() as f64 {
            side *= 1.5;
        }
        let size = cells(side).map(|n| n as usize);
        let cell = |v: &Vertex| {
            let [i, j, k] = [0, 1, 2].map(|k| (((v.x[k] - low[k]) / side) as usize).min(size[k] - 1));
            ((i * size[1] + j) * size[2] + k) as u32
        };
        let moved = vec![0.0; size[0] * size[1] * size[2]];
        Self { side, size, cell: vertices.iter().map(cell).collect(), closing: moved.clone(), moved }
    }

    /// Notes that vertices move for `h` \[s\].
    pub(crate) fn age(&mut self, vertices: &[Vertex], h: f64) {
        let speeds = self.speeds(vertices);
        self.moved.iter_mut().zip(speeds).for_each(|(moved, speed)| *moved += h * speed);
    }

    /// How far any two vertices in neighbouring cells may have moved relative to each other, in another `h` \[s\] \[m\].
    pub(crate) fn ahead(&mut self, vertices: &[Vertex], h: f64) -> f64 {
        let speeds = self.speeds(vertices);
        let mut most = 0.0_f64;
        for ((closing, moved), speed) in self.closing.iter_mut().zip(&self.moved).zip(speeds) {
            *closing = moved + 2.0 * h * speed;
            most = most.max(moved + h * speed);
        }
        most
    }

    /// How far what is about a vertex may have moved relative to it, and twice what the substep that was looked ahead to
    /// may add \[m\].
    pub(crate) fn closing(&self, vertex: u32) -> f64 {
        self.closing[self.cell[vertex as usize] as usize]
    }

    /// Largest speed relative to each other of two vertices in the cells about each \[m/s\].
    fn speeds(&self, vertices: &[Vertex]) -> Vec<f64> {
        let [nx, ny, nz] = self.size;
        let mut ranges = vec![NONE; nx * ny * nz];
        for (v, &cell) in vertices.iter().zip(&self.cell) {
            let range = &mut ranges[cell as usize];
            *range = merge(*range, (v.u, v.u));
        }
        // Three in a row along each axis in turn are 27.
        for (count, stride) in [(nz, 1), (ny, nz), (nx, ny * nz)] {
            let before = ranges.clone();
            for (i, range) in ranges.iter_mut().enumerate() {
                let place = i / stride % count;
                if place > 0 {
                    *range = merge(*range, before[i - stride]);
                }
                if place + 1 < count {
                    *range = merge(*range, before[i + stride]);
                }
            }
        }
        ranges.iter().map(|r| if r.0[0] <= r.1[0] { norm(sub(r.1, r.0)) } else { 0.0 }).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn neighbours_bound_each_other_and_strangers_do_not_count() {
        let vertices: Vec<Vertex> = (0..400)
            .map(|i| [0.05 * f64::from(i % 20), 0.05 * f64::from(i / 20), 0.0])
            .map(|x| Vertex { x, u: [0.0, 0.0, 2.0 * x[0]], w: 1.0, mass: 1.0 })
            .collect();
        let mut patches = Patches::new(&vertices, 0.1);
        let found = patches.ahead(&vertices, 1.0);
        // A slope of 2 m/s a metre over three cells, not over the metre.
        assert!(found <= 2.0 * 3.0 * patches.side + 1e-12, "{found}");
        for a in &vertices {
            for b in vertices.iter().filter(|b| norm(sub(b.x, a.x)) < patches.side) {
                assert!(norm(sub(a.u, b.u)) <= found);
            }
        }
    }
}
