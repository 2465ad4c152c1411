//! A uniform grid over points, for nearest neighbours.

use nalgebra::Vector3;

/// Cells along one axis at most.
const LONGEST: usize = 512;

/// Points in cells.
pub(crate) struct Grid<'a> {
    points: &'a [[f32; 3]],
    lower: Vector3<f64>,
    cell: f64,
    size: [usize; 3],
    /// Start of each cell in `order`, and the end of the last.
    starts: Vec<u32>,
    /// Indices of the points, by cell, ascending within one.
    order: Vec<u32>,
}

/// A neighbour: squared distance, then index, so that ties have one order.
pub(crate) type Near = (f64, u32);

impl<'a> Grid<'a> {
    /// Cells of about two points; every coordinate must be finite.
    pub(crate) fn new(points: &'a [[f32; 3]]) -> Grid<'a> {
        let (mut lower, mut upper) = (Vector3::repeat(f64::INFINITY), Vector3::repeat(f64::NEG_INFINITY));
        for p in points {
            let p = Vector3::from(p.map(f64::from));
            (lower, upper) = (lower.inf(&p), upper.sup(&p));
        }
        if points.is_empty() {
            (lower, upper) = (Vector3::zeros(), Vector3::zeros());
        }
        let extent = upper - lower;
        let longest = extent.max();
        let filled = extent.map(|e| e.max(longest * 1e-2));
        let cell = (2.0 * filled.product() / points.len().max(1) as f64).cbrt().max(longest / LONGEST as f64);
        let cell = if cell > 0.0 { cell } else { 1.0 };
        let size = [0, 1, 2].map(|k| ((extent[k] / cell) as usize + 1).min(LONGEST + 1));
        let mut grid = Grid { points, lower, cell, size, starts: Vec::new(), order: vec![0; points.len()] };
        let cells: Vec<usize> =
            points.iter().map(|p| grid.index(grid.cell_of(Vector3::from(p.map(f64::from))))).collect();
        let mut starts = vec![0_u32; size.iter().product::<usize>() + 1];
        for &c in &cells {
            starts[c + 1] += 1;
        }
        for c in 1..starts.len() {
            starts[c] += starts[c - 1];
        }
        let mut next = starts.clone();
        for (i, &c) in cells.iter().enumerate() {
            grid.order[next[c] as usize] = i as u32;
            next[c] += 1;
        }
        grid.starts = starts;
        grid
    }

    fn cell_of(&self, p: Vector3<f64>) -> [usize; 3] {
        // Conversion to integers saturates: points outside belong to the cells at the edge.
        [0, 1, 2].map(|k| (((p[k] - self.lower[k]) / self.cell) as usize).min(self.size[k] - 1))
    }

    fn index(&self, c: [usize; 3]) -> usize {
        (c[2] * self.size[1] + c[1]) * self.size[0] + c[0]
    }

    /// The `k` nearest points, nearest first, ties by index; fewer where there are fewer points.
    ///
    /// Shells of cells are searched until the next one is farther than the last neighbour. A point outside the grid is
    /// farther from everything than its projection onto the grid, so the bound holds there too.
    pub(crate) fn nearest(&self, p: Vector3<f64>, k: usize, found: &mut Vec<Near>) {
        found.clear();
        if k == 0 {
            return;
        }
        let centre = self.cell_of(p);
        let last_shell = self.size.iter().copied().max().unwrap_or(1);
        for shell in 0..=last_shell {
            if shell > 0 && found.len() == k {
                let bound = (shell - 1) as f64 * self.cell;
                if found[k - 1].0 < bound * bound {
                    return;
                }
            }
            self.visit_shell(centre, shell, |i| {
                let near = ((Vector3::from(self.points[i as usize].map(f64::from)) - p).norm_squared(), i);
                if found.len() == k && !less(near, found[k - 1]) {
                    return;
                }
                let at = found.partition_point(|&other| less(other, near));
                if found.len() == k {
                    found.pop();
                }
                found.insert(at, near);
            });
        }
    }

    /// Points of the cells whose largest index distance from `centre` is `shell`.
    fn visit_shell(&self, centre: [usize; 3], shell: usize, mut visit: impl FnMut(u32)) {
        let range = |k: usize| centre[k].saturating_sub(shell)..=(centre[k] + shell).min(self.size[k] - 1);
        for z in range(2) {
            for y in range(1) {
                let whole = z.abs_diff(centre[2]) == shell || y.abs_diff(centre[1]) == shell;
                let row = |x: usize| self.index([x, y, z]);
                let mut cell = |x: usize| {
                    let c = row(x);
                    self.order[self.starts[c] as usize..self.starts[c + 1] as usize].iter().for_each(|&i| visit(i));
                };
                if whole {
                    range(0).for_each(cell);
                } else {
                    if let Some(x) = centre[0].checked_sub(shell) {
                        cell(x);
                    }
                    if centre[0] + shell < self.size[0] {
                        cell(centre[0] + shell);
                    }
                }
            }
        }
    }
}

fn less(a: Near, b: Near) -> bool {
    a.0 < b.0 || (a.0 <= b.0 && a.1 < b.1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn neighbours_are_those_of_a_full_search() {
        let mut state = 1_u64;
        let mut random = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 40) as f32 / (1 << 24) as f32
        };
        let scales = [[1.0, 1.0, 1.0], [1.0, 1.0, 0.0], [1.0, 0.0, 0.0], [100.0, 1.0, 0.01]];
        for s in scales {
            // Coordinates on a coarse lattice, so that there are ties.
            let points: Vec<[f32; 3]> = (0..500).map(|_| s.map(|f| (random() * 16.0).floor() * f)).collect();
            let grid = Grid::new(&points);
            for _ in 0..200 {
                let p = Vector3::from(s.map(|f| f64::from((random() * 3.0 - 1.0) * 16.0 * f)));
                let mut all: Vec<Near> = points
                    .iter()
                    .enumerate()
                    .map(|(i, q)| ((Vector3::from(q.map(f64::from)) - p).norm_squared(), i as u32))
                    .collect();
                all.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
                let mut found = Vec::new();
                grid.nearest(p, 12, &mut found);
                assert_eq!(found, all[..12]);
            }
        }
        let mut found = Vec::new();
        Grid::new(&[]).nearest(Vector3::zeros(), 3, &mut found);
        assert!(found.is_empty());
        Grid::new(&[[1.0; 3], [1.0; 3]]).nearest(Vector3::zeros(), 3, &mut found);
        assert_eq!(found, [(3.0, 0), (3.0, 1)]);
    }
}
