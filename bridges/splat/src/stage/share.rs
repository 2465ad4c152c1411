//! Volume of the particles of a body.

use std::collections::{BTreeMap, BTreeSet};

use super::islands::Cell;

/// Volumes of the cells of a body in units of a cell, in their order, and how many cells are skin.
///
/// What is inside was measured by counting cells whose middle is inside, which is right on average wherever the surface
/// cuts them. A cell beside them that only holds surface is their skin: it adds no volume but gets some from the cells
/// behind it, as much as each of them keeps on a flat wall. So all particles together have the volume that is inside, and
/// where the surface is there is mass. A cell with no inside beside it is thin matter, and counts in full.
pub(super) fn volumes(body: &BTreeSet<Cell>, inside: &BTreeSet<Cell>) -> (Vec<f64>, usize) {
    let beside = |c: &Cell| -> Vec<Cell> {
        let around = (0..27).map(|n| [c[0] + n / 9 - 1, c[1] + n / 3 % 3 - 1, c[2] + n % 3 - 1]);
        around.filter(|n| inside.contains(n) && body.contains(n)).collect()
    };
    let outer: BTreeMap<Cell, Vec<Cell>> =
        body.iter().filter(|c| !inside.contains(*c)).map(|c| (*c, beside(c))).collect();
    // Of each cell inside: how many times what it keeps it gives away.
    let mut asked: BTreeMap<Cell, f64> = BTreeMap::new();
    for behind in outer.values() {
        for cell in behind {
            *asked.entry(*cell).or_insert(0.0) += 1.0 / behind.len() as f64;
        }
    }
    let keeps = |c: &Cell| 1.0 / (1.0 + asked.get(c).copied().unwrap_or(0.0));
    let volume = |c: &Cell| match outer.get(c) {
        None => keeps(c),
        Some(behind) if behind.is_empty() => 1.0,
        Some(behind) => behind.iter().map(keeps).sum::<f64>() / behind.len() as f64,
    };
    (body.iter().map(volume).collect(), outer.values().filter(|behind| !behind.is_empty()).count())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_skin_shares_what_is_behind_it_and_thin_matter_is_its_own() {
        let layer = |z: i32| (0..25).map(move |n| [z, n / 5, n % 5]);
        let inside: BTreeSet<Cell> = layer(0).chain(layer(1)).collect();
        // A skin above, and a sheet that touches nothing.
        let body: BTreeSet<Cell> = inside.iter().copied().chain(layer(2)).chain(layer(9)).collect();
        let (volumes, skin) = volumes(&body, &inside);
        assert_eq!(skin, 25);
        let sum = |z: i32| body.iter().zip(&volumes).filter(|(c, _)| c[0] == z).map(|(_, v)| v).sum::<f64>();
        // Roundings of sums of 25 numbers of order one.
        assert!((sum(0) - 25.0).abs() < 1e-12 && (sum(9) - 25.0).abs() < 1e-12);
        assert!((sum(1) + sum(2) - 25.0).abs() < 1e-12);
        let middle = body.iter().zip(&volumes).find(|(c, _)| **c == [2, 2, 2]).map(|(_, v)| *v);
        // Its share is that of nine cells which each give as much as they keep, but for those at the rim.
        assert!(middle.is_some_and(|v| (v - 0.5).abs() < 0.06), "{middle:?}");
        assert!(volumes.iter().all(|v| *v > 0.1));
    }
}
