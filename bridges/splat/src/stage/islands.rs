//! One piece of material: cells of a lattice that hang together.

use std::collections::BTreeSet;

use crate::grid::Grid;

/// A cell of the lattice as z, y, x.
pub(super) type Cell = [i32; 3];

/// What became of the cells.
#[derive(Clone, Debug, Default)]
pub(super) struct Joined {
    /// Cells added between islands and the mainland.
    pub(super) bridges: Vec<Cell>,
    /// Cells of islands that are too small or too far to be part of the body.
    pub(super) stray: BTreeSet<Cell>,
}

/// Joins islands to the largest connected set of cells, the nearest first: a stalk that the capture saw in pieces is one
/// stalk. An island of fewer than `smallest` cells, or farther than `reach` cells from everything joined, is stray.
pub(super) fn join(cells: &BTreeSet<Cell>, smallest: usize, reach: f64) -> Joined {
    let mut islands = components(cells);
    let mut joined = Joined::default();
    let Some(largest) = (0..islands.len()).max_by_key(|&i| (islands[i].len(), usize::MAX - i)) else { return joined };
    let mainland = islands.remove(largest);
    let (large, small): (Vec<_>, Vec<_>) = islands.into_iter().partition(|island| island.len() >= smallest);
    joined.stray.extend(small.into_iter().flatten());
    let points: Vec<[f32; 3]> = mainland.iter().map(|c| c.map(|v| v as f32)).collect();
    let grid = Grid::new(&points);
    let mut found = Vec::new();
    // Of each island: the squared distance to what is joined, and the two cells between which it is.
    let mut waiting: Vec<(i64, Cell, Cell, Vec<Cell>)> = large
        .into_iter()
        .map(|island| {
            let (mut best, mut from, mut to) = (i64::MAX, island[0], island[0]);
            for &cell in &island {
                grid.nearest(nalgebra::Vector3::from(cell.map(f64::from)), 1, &mut found);
                let Some(&(_, nearest)) = found.first() else { continue };
                let other = mainland[nearest as usize];
                if squared(cell, other) < best {
                    (best, from, to) = (squared(cell, other), cell, other);
                }
            }
            (best, from, to, island)
        })
        .collect();
    while let Some(next) = (0..waiting.len()).min_by_key(|&i| (waiting[i].0, i)) {
        let (distance, from, to, island) = waiting.remove(next);
        if distance as f64 > reach * reach {
            joined.stray.extend(island);
            joined.stray.extend(waiting.into_iter().flat_map(|w| w.3));
            break;
        }
        joined.bridges.extend(line(from, to).into_iter().filter(|c| !cells.contains(c)));
        for (best, near, far, others) in &mut waiting {
            for &cell in others.iter() {
                for &other in &island {
                    if squared(cell, other) < *best {
                        (*best, *near, *far) = (squared(cell, other), cell, other);
                    }
                }
            }
        }
    }
    joined.bridges.sort_unstable();
    joined.bridges.dedup();
    joined
}

/// Sets of cells that touch by face, edge or corner; each sorted, in the order of their first cells.
fn components(cells: &BTreeSet<Cell>) -> Vec<Vec<Cell>> {
    let mut left = cells.clone();
    let mut all = Vec::new();
    while let Some(first) = left.pop_first() {
        let (mut open, mut one) = (vec![first], vec![first]);
        while let Some(c) = open.pop() {
            for n in 0..27 {
                let next = [c[0] + n / 9 - 1, c[1] + n / 3 % 3 - 1, c[2] + n % 3 - 1];
                if left.remove(&next) {
                    open.push(next);
                    one.push(next);
                }
            }
        }
        one.sort_unstable();
        all.push(one);
    }
    all
}

fn squared(a: Cell, b: Cell) -> i64 {
    (0..3).map(|k| i64::from(a[k] - b[k]).pow(2)).sum()
}

/// Cells on the straight line from one to the other, without the two.
fn line(from: Cell, to: Cell) -> Vec<Cell> {
    let steps = (0..3).map(|k| (to[k] - from[k]).abs()).max().unwrap_or(0);
    let at = |i: i32, k: usize| from[k] + (f64::from((to[k] - from[k]) * i) / f64::from(steps)).round() as i32;
    (1..steps).map(|i| [at(i, 0), at(i, 1), at(i, 2)]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn block(at: Cell, size: i32) -> Vec<Cell> {
        (0..size.pow(3)).map(|n| [at[0] + n / (size * size), at[1] + n / size % size, at[2] + n % size]).collect()
    }

    #[test]
    fn pieces_are_joined_in_a_chain_and_specks_are_stray() {
        let mut cells: BTreeSet<Cell> = block([0, 0, 0], 4).into_iter().collect();
        cells.extend(block([0, 0, 6], 2));
        cells.extend(block([0, 0, 10], 2));
        cells.extend(block([20, 0, 0], 3));
        cells.insert([0, 6, 0]);
        let joined = join(&cells, 4, 4.0);
        // Three cells to the first piece, three more to the second; from the block alone it would be seven.
        assert_eq!(joined.bridges, [[0, 0, 4], [0, 0, 5], [0, 0, 8], [0, 0, 9]]);
        assert_eq!(joined.stray.len(), 27 + 1);
        let whole: BTreeSet<Cell> =
            cells.iter().chain(&joined.bridges).filter(|c| !joined.stray.contains(*c)).copied().collect();
        assert_eq!(components(&whole).len(), 1);
        assert!(join(&BTreeSet::new(), 4, 4.0).stray.is_empty());
    }
}
