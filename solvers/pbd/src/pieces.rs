//! Which vertices and triangles, and which edges, of all cloths are near each other.
//!
//! Cloth is looked at by two tiles at a time (`tiles`, `watch`): each piece of one that is near the box of the other is
//! compared with each such piece of it.
//! What is closer than twice the thickness at rest is left alone: it could never be a thickness apart.

use cosplat_core::boundary::{Vec3, add, cross, dot, norm, scale, sub};
use rayon::prelude::*;

use crate::cells::Cells;
use crate::closest::{at, edges_apart, on_triangle};
use crate::own::{Candidate, Mesh};
use crate::tiles::Tile;
use crate::vertex::Vertex;

/// Tiles of a task.
const TASK: usize = 256;
/// Part of a distance that rounding may take.
pub(crate) const ROUNDED: f64 = 1e-9;

/// What a search is about.
#[derive(Clone, Copy)]
pub(crate) struct Search<'a> {
    pub(crate) mesh: &'a Mesh,
    pub(crate) vertices: &'a [Vertex],
    /// Distance within which pieces matter \[m\].
    pub(crate) reach: f64,
    pub(crate) thickness: f64,
    pub(crate) parallel: bool,
}

/// Centre and half extents of a box \[m\].
pub(crate) type Bounds = (Vec3, Vec3);

/// Pieces of a tile, by their numbers.
#[derive(Default)]
struct Part {
    vertices: Vec<(u32, Vec3)>,
    edges: Vec<(u32, Bounds)>,
    triangles: Vec<(u32, Bounds)>,
}

impl Part {
    /// All of a tile.
    fn fill(&mut self, search: &Search, tile: &Tile) {
        let Self { vertices, edges, triangles } = self;
        let (x, mesh) = (|i: u32| search.vertices[i as usize].x, search.mesh);
        vertices.clear();
        vertices.extend(tile.vertices.iter().map(|&v| (v, x(v))));
        edges.clear();
        edges.extend(tile.edges.iter().map(|&e| (e, around(mesh.edges[e as usize].map(x)))));
        triangles.clear();
        triangles.extend(tile.triangles.iter().map(|&t| (t, around(mesh.triangles[t as usize].map(x)))));
    }

    /// What of another is within `reach` of a box.
    fn take(&mut self, other: &Self, bounds: &Bounds, reach: f64) {
        self.vertices.clear();
        self.vertices.extend(other.vertices.iter().filter(|v| close(&(v.1, [0.0; 3]), bounds, reach)));
        self.edges.clear();
        self.edges.extend(other.edges.iter().filter(|e| close(&e.1, bounds, reach)));
        self.triangles.clear();
        self.triangles.extend(other.triangles.iter().filter(|t| close(&t.1, bounds, reach)));
    }
}

/// Room to look at couples in: what was last seen of a first tile, and of two tiles what of each is near the other.
#[derive(Default)]
pub(crate) struct Room {
    tile: Option<usize>,
    whole: [Part; 2],
    near: [Part; 2],
}

/// What two tiles are to each other.
#[derive(Clone, Copy)]
struct Terms {
    friction: [f64; 2],
    /// Whether pieces of them may be so near at rest that they are left alone.
    beside: bool,
}

impl Search<'_> {
    fn x(&self, i: u32) -> Vec3 {
        self.vertices[i as usize].x
    }

    /// Boxes of the places of all tiles \[m\].
    pub(crate) fn places(&self) -> Vec<Bounds> {
        self.of_tiles(|v| v.x)
    }

    /// Boxes of the velocities of all tiles \[m/s\].
    pub(crate) fn speeds(&self) -> Vec<Bounds> {
        self.of_tiles(|v| v.u)
    }

    fn of_tiles(&self, what: impl Fn(&Vertex) -> Vec3 + Sync) -> Vec<Bounds> {
        let one = |tile: &Tile| around(tile.corners.iter().map(|&i| what(&self.vertices[i as usize])));
        let tiles = &self.mesh.tiles.all;
        if self.parallel {
            tiles.par_iter().with_min_len(TASK).map(one).collect()
        } else {
            tiles.iter().map(one).collect()
        }
    }

    /// How far apart two tiles are at least, seen along each of them \[m\]: layers that lie on each other aslant have boxes
    /// that overlap.
    pub(crate) fn across(&self, a: usize, b: usize) -> f64 {
        let tiles = [a, b].map(|n| &self.mesh.tiles.all[n]);
        let extent = |tile: &Tile, n: Vec3| {
            let along = tile.corners.iter().map(|&i| dot(self.x(i), n));
            along.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], d| {
                [if d < low { d } else { low }, if d > high { d } else { high }]
            })
        };
        let one = |tile: &Tile| {
            let area = tile.triangles.iter().fold([0.0; 3], |sum, &t| {
                let [a, b, c] = self.mesh.triangles[t as usize].map(|i| self.x(i));
                add(sum, cross(sub(b, a), sub(c, a)))
            });
            let size = norm(area);
            if size <= 0.0 {
                return 0.0;
            }
            let [first, second] = tiles.map(|tile| extent(tile, scale(area, 1.0 / size)));
            (second[0] - first[1]).max(first[0] - second[1])
        };
        one(tiles[0]).max(one(tiles[1]))
    }

    /// Candidates of two tiles, or of one with itself, from their boxes.
    pub(crate) fn between(&self, tiles: [usize; 2], boxes: [&Bounds; 2], room: &mut Room, found: &mut Vec<Candidate>) {
        let Some(friction) = self.friction(tiles[0], tiles[1]) else { return };
        let [one, other] = tiles.map(|n| &self.mesh.tiles.all[n]);
        // Pieces that share a corner are 0 apart, but for rounding.
        let least = 2.0 * self.thickness + ROUNDED * norm(one.rest.1);
        let terms = Terms { friction, beside: one.body == other.body && gap(&one.rest, &other.rest) <= least };
        let Room { tile, whole: [whole, second_whole], near: [first, second] } = room;
        if *tile != Some(tiles[0]) {
            whole.fill(self, one);
            *tile = Some(tiles[0]);
        }
        first.take(whole, boxes[1], self.reach);
        if tiles[0] == tiles[1] {
            self.of_vertices([first, first], terms, found);
            for (i, e) in first.edges.iter().enumerate() {
                first.edges[i + 1..].iter().for_each(|f| self.of_edges([e, f], terms, found));
            }
            return;
        }
        second_whole.fill(self, other);
        second.take(second_whole, boxes[0], self.reach);
        self.of_vertices([first, second], terms, found);
        self.of_vertices([second, first], terms, found);
        for e in &first.edges {
            second.edges.iter().for_each(|f| self.of_edges([e, f], terms, found));
        }
    }

    /// Of two tiles; nothing where they pass through each other.
    pub(crate) fn friction(&self, a: usize, b: usize) -> Option<[f64; 2]> {
        let [a, b] = [a, b].map(|n| &self.mesh.tiles.all[n]);
        self.mesh.friction[a.body * self.mesh.bodies + b.body]
    }

    /// Whether corners of two pieces of one body are closer at rest than what is left alone: most of what is near, for
    /// less than the distance of the pieces costs.
    fn is_beside(&self, a: &[u32], b: &[u32]) -> bool {
        let closest = 4.0 * self.thickness * self.thickness;
        let rest = |i: u32| self.mesh.rest[i as usize];
        a.iter().any(|&i| {
            b.iter().any(|&j| {
                let d = sub(rest(i), rest(j));
                dot(d, d) < closest
            })
        })
    }

    fn of_vertices(&self, [first, second]: [&Part; 2], terms: Terms, found: &mut Vec<Candidate>) {
        let rest = |i: u32| self.mesh.rest[i as usize];
        let far = |p: Vec3, points: [Vec3; 3]| {
            let d = sub(p, at(points, on_triangle(points, p)));
            dot(d, d)
        };
        let closest = 4.0 * self.thickness * self.thickness;
        for &(v, x) in &first.vertices {
            for (t, bounds) in &second.triangles {
                if !close(bounds, &(x, [0.0; 3]), self.reach) {
                    continue;
                }
                let ends @ [a, b, c] = self.mesh.triangles[*t as usize];
                if terms.beside && (ends.contains(&v) || self.is_beside(&[v], &ends)) {
                    continue;
                }
                let square = far(x, ends.map(|i| self.x(i)));
                if square > self.reach * self.reach || (terms.beside && far(rest(v), ends.map(rest)) < closest) {
                    continue;
                }
                found.push(Candidate {
                    ends: [v, a, b, c],
                    is_vertex: true,
                    friction: terms.friction,
                    apart: square.sqrt(),
                });
            }
        }
    }

    fn of_edges(&self, [a, b]: [&(u32, Bounds); 2], terms: Terms, found: &mut Vec<Candidate>) {
        if !close(&a.1, &b.1, self.reach) {
            return;
        }
        let [first, second] = [a.0, b.0].map(|e| self.mesh.edges[e as usize]);
        if terms.beside && (first.iter().any(|i| second.contains(i)) || self.is_beside(&first, &second)) {
            return;
        }
        let points = |e: [u32; 2]| e.map(|i| self.x(i));
        let square = edges_apart(points(first), points(second));
        if square > self.reach * self.reach {
            return;
        }
        let rest = |e: [u32; 2]| e.map(|i| self.mesh.rest[i as usize]);
        if terms.beside && edges_apart(rest(first), rest(second)) < 4.0 * self.thickness * self.thickness {
            return;
        }
        // In one order, whichever of the two comes first in the cells.
        let [first, second] = if first < second { [first, second] } else { [second, first] };
        found.push(Candidate {
            ends: [first[0], first[1], second[0], second[1]],
            is_vertex: false,
            friction: terms.friction,
            apart: square.sqrt(),
        });
    }
}

/// Box of some points; an empty one of none.
pub(crate) fn around(points: impl IntoIterator<Item = Vec3>) -> Bounds {
    let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
    for p in points {
        low = std::array::from_fn(|k| if p[k] < low[k] { p[k] } else { low[k] });
        high = std::array::from_fn(|k| if p[k] > high[k] { p[k] } else { high[k] });
    }
    (scale(add(low, high), 0.5), scale(sub(high, low), 0.5))
}

/// Whether boxes are within reach along each axis.
#[inline]
fn close(a: &Bounds, b: &Bounds, reach: f64) -> bool {
    (0..3).all(|k| (a.0[k] - b.0[k]).abs() - a.1[k] - b.1[k] <= reach)
}

/// Distance of two boxes \[m\].
#[inline]
pub(crate) fn gap(a: &Bounds, b: &Bounds) -> f64 {
    norm(std::array::from_fn(|k| ((a.0[k] - b.0[k]).abs() - a.1[k] - b.1[k]).max(0.0)))
}

/// Boxes in the given order and in that of cells.
pub(crate) struct Boxes<'a> {
    pub(crate) all: &'a [Bounds],
    cells: Cells,
    sorted: Vec<Bounds>,
    /// Largest half extents \[m\].
    largest: Vec3,
    reach: f64,
}

impl<'a> Boxes<'a> {
    /// Boxes that are looked for within `reach` of each other \[m\].
    pub(crate) fn new(all: &'a [Bounds], reach: f64) -> Self {
        let centres: Vec<Vec3> = all.iter().map(|b| b.0).collect();
        let largest = [0, 1, 2].map(|k| all.iter().map(|b| b.1[k]).fold(0.0, f64::max));
        // Half of what is asked for about a box: finer cells hold less that is too far, but there are more of them.
        let cells = Cells::new(&centres, norm(largest) + 0.5 * reach);
        let sorted = cells.items().iter().map(|&i| all[i as usize]).collect();
        Self { all, cells, sorted, largest, reach }
    }

    /// Numbers of the boxes within reach of one of them, from that on, in order.
    pub(crate) fn near(&self, number: usize, found: &mut Vec<u32>) {
        found.clear();
        let bounds = self.all[number];
        let reach = add(add(bounds.1, self.largest), [self.reach; 3]);
        self.cells.near(bounds.0, reach, |range| {
            let items = self.cells.items()[range.clone()].iter().zip(&self.sorted[range]);
            let near = items.filter(|(n, b)| **n as usize >= number && close(b, &bounds, self.reach));
            found.extend(near.map(|(&n, _)| n));
        });
        found.sort_unstable();
    }
}
