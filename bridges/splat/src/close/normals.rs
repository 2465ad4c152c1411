//! Points with normals that agree about which side is free.

use std::cmp::Reverse;
use std::collections::{BTreeMap, BinaryHeap};

use nalgebra::Vector3;
use rayon::prelude::*;

use crate::fill::plane;
use crate::grid::Grid;
use crate::linalg::{perpendicular, wide};
use crate::splats::Splats;

/// Neighbours from which normal and area come, the point itself among them.
const NEIGHBOURS: usize = 17;
/// Of a lattice of points the eighth neighbour is √2 apart; thinned points are nearer than the cells are wide.
const EIGHTH: usize = 9;
/// Cells are too fine for points whose eighth neighbour is farther than this many of them.
const SPARSE: f64 = 2.0;
/// Cosine of the angle up to which neighbours are one surface.
const AGREE: f64 = 0.8;
/// Part of the spread of neighbours along the normal from which a point is haze and no surface.
const HAZE: f64 = 0.08;
/// A piece is hidden from above where its votes sum to less than this part of its points.
const HIDDEN: f64 = 0.05;
/// Width of the columns that are looked at from above, in cells.
const COLUMN: f64 = 2.0;
/// Cells grow by this.
const COARSER: f64 = 1.2;
/// And not more often than this.
const TRIES: usize = 24;

/// A point of a surface, the direction of its free side and the area that it stands for.
#[derive(Clone, Copy, Debug)]
pub(super) struct Oriented {
    pub(super) place: Vector3<f64>,
    pub(super) normal: Vector3<f64>,
    pub(super) area: f64,
}

/// Indices of the Gaussians that are the surface: finite and opaque.
pub(super) fn opaque(splats: &Splats, opacity: f64) -> Vec<[f32; 3]> {
    let solid = |&i: &usize| splats.opacity(i) >= opacity && splats.positions[i].iter().all(|v| v.is_finite());
    (0..splats.len()).filter(solid).map(|i| splats.positions[i]).collect()
}

/// One point a cell, the mean of those in it, in the order of the cells; the cells are as fine as asked, or as the points
/// are dense. Returns the edge of the cells too.
pub(super) fn representatives(points: &[[f32; 3]], finest: f64) -> (Vec<[f32; 3]>, f64) {
    let mut cell = finest;
    for _ in 0..TRIES {
        let means = means(points, cell);
        if eighth(&means) <= SPARSE * cell {
            return (means, cell);
        }
        cell *= COARSER;
    }
    (means(points, cell), cell)
}

fn means(points: &[[f32; 3]], cell: f64) -> Vec<[f32; 3]> {
    let mut cells: BTreeMap<[i64; 3], (Vector3<f64>, f64)> = BTreeMap::new();
    for p in points {
        let key = [2, 1, 0].map(|k| (f64::from(p[k]) / cell).floor() as i64);
        let sum = cells.entry(key).or_insert((Vector3::zeros(), 0.0));
        *sum = (sum.0 + wide(*p), sum.1 + 1.0);
    }
    cells.values().map(|(sum, n)| (sum / *n).map(|v| v as f32).into()).collect()
}

/// Median distance of the eighth neighbour.
fn eighth(points: &[[f32; 3]]) -> f64 {
    let grid = Grid::new(points);
    // The median of some thousand is known well enough.
    let some: Vec<&[f32; 3]> = points.iter().step_by((points.len() / 4000).max(1)).collect();
    let distance = |found: &mut Vec<_>, p: &&[f32; 3]| {
        grid.nearest(wide(**p), EIGHTH, found);
        found.last().map_or(0.0, |n: &(f64, u32)| n.0.sqrt())
    };
    let mut all: Vec<f64> = some.par_iter().map_init(Vec::new, distance).collect();
    all.sort_by(f64::total_cmp);
    all.get(all.len() / 2).copied().unwrap_or(0.0)
}

/// Normals by the neighbours of each point, turned so that neighbours agree, and so that what is seen from above has its
/// free side there.
///
/// Signs are carried along a minimal spanning tree of the graph of neighbours, in which an edge costs 1 − |n·n′| (Hoppe et
/// al. 1992), but not over edges where normals turn by more than [`AGREE`], and not by haze: what floats between two things
/// would carry the wrong one over, and counts little for the surface. Each piece that hangs together is then turned as most
/// of its points ask for that are seen from above; a piece that is hardly seen from there as those ask that are seen from
/// the sides, and one that is hidden as its highest point asks.
pub(super) fn oriented(points: &[[f32; 3]], up: Vector3<f64>, cell: f64) -> Vec<Oriented> {
    let grid = Grid::new(points);
    let of = |found: &mut Vec<(f64, u32)>, p: &[f32; 3]| {
        grid.nearest(wide(*p), NEIGHBOURS, found);
        let plane = plane(points, found);
        let flat = (1.0 - 3.0 * plane.variation).max(0.0);
        let own = Oriented { place: wide(*p), normal: plane.normal, area: plane.area * flat * flat };
        // Haze takes signs over and gives none: its normals are those of nothing.
        let carries = plane.variation <= HAZE;
        (own, if carries { found.iter().map(|n| n.1).collect::<Vec<u32>>() } else { Vec::new() })
    };
    let (mut all, mut near): (Vec<Oriented>, Vec<Vec<u32>>) = points.par_iter().map_init(Vec::new, of).unzip();
    // Neighbourhood both ways, so that the tree does not depend on where it begins more than it must.
    let carries: Vec<bool> = near.iter().map(|n| !n.is_empty()).collect();
    for i in 0..near.len() {
        for j in near[i].clone() {
            if carries[j as usize] && !near[j as usize].contains(&(i as u32)) {
                near[j as usize].push(i as u32);
            }
        }
    }
    let across = perpendicular(&up);
    let along = up.cross(&across);
    let sides = [across, -across, along, -along];
    let from_above = votes(&all, &up, COLUMN * cell);
    let from_sides = sides.map(|side| votes(&all, &side, COLUMN * cell));
    let mut order: Vec<u32> = (0..all.len() as u32).collect();
    let height = |i: &u32| all[*i as usize].place.dot(&up);
    order.sort_by(|a, b| height(b).total_cmp(&height(a)).then(a.cmp(b)));
    let mut done = vec![false; all.len()];
    for first in order {
        if !done[first as usize] {
            let piece = agree(first, &mut all, &near, &mut done);
            let count = |seen: &[Option<Vector3<f64>>]| {
                let vote = |i: &u32| seen[*i as usize].map_or(0.0, |d| all[*i as usize].normal.dot(&d));
                piece.iter().map(vote).sum::<f64>()
            };
            let mut sum = count(&from_above);
            if sum.abs() < HIDDEN * piece.len() as f64 {
                sum += from_sides.iter().map(|seen| count(seen)).sum::<f64>();
            }
            let wrong = if sum == 0.0 { all[first as usize].normal.dot(&up) < 0.0 } else { sum < 0.0 };
            for i in piece.into_iter().filter(|_| wrong) {
                all[i as usize].normal *= -1.0;
            }
        }
    }
    all
}

/// The piece that hangs together with a point, its normals turned to agree.
fn agree(first: u32, all: &mut [Oriented], near: &[Vec<u32>], done: &mut [bool]) -> Vec<u32> {
    let mut piece = Vec::new();
    let mut open: BinaryHeap<Reverse<(u64, u32, u32)>> = BinaryHeap::from([Reverse((0, first, first))]);
    while let Some(Reverse((_, i, from))) = open.pop() {
        if std::mem::replace(&mut done[i as usize], true) {
            continue;
        }
        if all[i as usize].normal.dot(&all[from as usize].normal) < 0.0 {
            all[i as usize].normal *= -1.0;
        }
        piece.push(i);
        let own = all[i as usize].normal;
        for &j in near[i as usize].iter().filter(|j| !done[**j as usize]) {
            let along = own.dot(&all[j as usize].normal).abs().min(1.0);
            if along >= AGREE {
                // Bits of numbers that are not negative are ordered as the numbers are.
                open.push(Reverse(((1.0 - along).to_bits(), j, i)));
            }
        }
    }
    piece
}

/// The direction, for points that are seen from there: those with nothing before them, in columns of that width.
fn votes(all: &[Oriented], up: &Vector3<f64>, width: f64) -> Vec<Option<Vector3<f64>>> {
    let across = perpendicular(up);
    let along = up.cross(&across);
    let column = |p: &Oriented| [across, along].map(|axis| (p.place.dot(&axis) / width).floor() as i64);
    let mut highest: BTreeMap<[i64; 2], f64> = BTreeMap::new();
    for p in all {
        let top = highest.entry(column(p)).or_insert(f64::NEG_INFINITY);
        *top = top.max(p.place.dot(up));
    }
    let seen = |p: &Oriented| highest.get(&column(p)).is_some_and(|top| p.place.dot(up) >= top - width);
    all.iter().map(|p| seen(p).then_some(*up)).collect()
}
