//! Which vertices and triangles, and which edges, of all cloths are near each other.
//!
//! Cloth is looked at by two tiles at a time (`tiles`, `watch`): each piece of one that is near the box of the other is
//! compared with each such piece of it.
//! What is closer than twice the thickness at rest is left alone: it could never be a thickness apart.

use cosplat_core::boundary::{Vec3, add, dot, norm, scale, sub};
use rayon::prelude::*;

use crate::cells::Cells;
use crate::closest::{at, edges_apart, on_triangle};
use crate::own::{Candidate, Mesh};
use crate::tiles::Tile;
use crate::vertex::Vertex;

/// Tiles of a task.
const TASK: usize = 256;

/// What a search is about.
#[derive(Clone, Copy)]
pub(crate) struct Search<'a> {
    pub(crate) mesh: &'a Mesh,
    pub(crate) vertices: &'a [Vertex],
    pub(crate) owner: &'a [u32],
    /// Distance within which pieces matter \[m\].
    pub(crate) reach: f64,
    pub(crate) thickness: f64,
    pub(crate) parallel: bool,
}

/// Centre and half extents of a box \[m\].
pub(crate) type Bounds = (Vec3, Vec3);

/// Pieces of one tile that are near another tile, by their numbers.
#[derive(Default)]
struct Part {
    vertices: Vec<u32>,
    edges: Vec<(u32, Bounds)>,
    triangles: Vec<(u32, Bounds)>,
}

impl Search<'_> {
    fn x(&self, i: u32) -> Vec3 {
        self.vertices[i as usize].x
    }

    fn of_edge(&self, edge: u32) -> Bounds {
        of(self.mesh.edges[edge as usize].map(|i| self.x(i)))
    }

    fn of_triangle(&self, triangle: u32) -> Bounds {
        of(self.mesh.triangles[triangle as usize].map(|i| self.x(i)))
    }

    /// Box of all pieces of a tile.
    pub(crate) fn around(&self, tile: usize) -> Bounds {
        of(self.mesh.tiles.all[tile].corners.iter().map(|&i| self.x(i)))
    }

    /// Boxes of the velocities of all tiles \[m/s\].
    pub(crate) fn speeds(&self) -> Vec<Bounds> {
        let one = |tile: &Tile| of(tile.corners.iter().map(|&i| self.vertices[i as usize].u));
        let tiles = &self.mesh.tiles.all;
        if self.parallel {
            tiles.par_iter().with_min_len(TASK).map(one).collect()
        } else {
            tiles.iter().map(one).collect()
        }
    }

    /// Candidates of two tiles, or of one with itself.
    pub(crate) fn between(&self, [a, b]: [usize; 2], found: &mut Vec<Candidate>) {
        let Some(friction) = self.friction(a, b) else { return };
        let [one, other] = [a, b].map(|n| &self.mesh.tiles.all[n]);
        let first = self.part(one, &self.around(b));
        if a == b {
            self.of_vertices(&first, &first, friction, found);
            for (i, e) in first.edges.iter().enumerate() {
                first.edges[i + 1..].iter().for_each(|f| self.of_edges([e, f], friction, found));
            }
            return;
        }
        let second = self.part(other, &self.around(a));
        self.of_vertices(&first, &second, friction, found);
        self.of_vertices(&second, &first, friction, found);
        for e in &first.edges {
            second.edges.iter().for_each(|f| self.of_edges([e, f], friction, found));
        }
    }

    /// What of a tile is near a box.
    fn part(&self, tile: &Tile, bounds: &Bounds) -> Part {
        let near = |b: &Bounds| close(b, bounds, self.reach);
        let edges = tile.edges.iter().map(|&e| (e, self.of_edge(e))).filter(|(_, b)| near(b));
        let triangles = tile.triangles.iter().map(|&t| (t, self.of_triangle(t))).filter(|(_, b)| near(b));
        Part {
            vertices: tile.vertices.iter().copied().filter(|&v| near(&(self.x(v), [0.0; 3]))).collect(),
            edges: edges.collect(),
            triangles: triangles.collect(),
        }
    }

    /// Of two tiles; nothing where they pass through each other.
    pub(crate) fn friction(&self, a: usize, b: usize) -> Option<[f64; 2]> {
        let [a, b] = [a, b].map(|n| &self.mesh.tiles.all[n]);
        self.mesh.friction[a.body * self.mesh.bodies + b.body]
    }

    /// Whether two vertices belong to one body, and so have a distance at rest.
    fn same(&self, a: u32, b: u32) -> bool {
        self.owner[a as usize] == self.owner[b as usize]
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

    fn of_vertices(&self, first: &Part, second: &Part, friction: [f64; 2], found: &mut Vec<Candidate>) {
        let rest = |i: u32| self.mesh.rest[i as usize];
        let far = |p: Vec3, points: [Vec3; 3]| norm(sub(p, at(points, on_triangle(points, p))));
        let far_now = |x: Vec3, ends: [u32; 3]| far(x, ends.map(|i| self.x(i)));
        for &v in &first.vertices {
            let x = self.x(v);
            for (t, bounds) in &second.triangles {
                let ends @ [a, b, c] = self.mesh.triangles[*t as usize];
                if !close(bounds, &(x, [0.0; 3]), self.reach)
                    || [a, b, c].contains(&v)
                    || (self.same(v, a) && self.is_beside(&[v], &ends))
                {
                    continue;
                }
                let apart = far_now(x, ends);
                if apart > self.reach || (self.same(v, a) && far(rest(v), ends.map(rest)) < 2.0 * self.thickness) {
                    continue;
                }
                found.push(Candidate { ends: [v, a, b, c], is_vertex: true, friction, apart });
            }
        }
    }

    fn of_edges(&self, [a, b]: [&(u32, Bounds); 2], friction: [f64; 2], found: &mut Vec<Candidate>) {
        if !close(&a.1, &b.1, self.reach) {
            return;
        }
        let [first, second] = [a.0, b.0].map(|e| self.mesh.edges[e as usize]);
        let points = |e: [u32; 2]| e.map(|i| self.x(i));
        let rest = |e: [u32; 2]| e.map(|i| self.mesh.rest[i as usize]);
        let closest = 2.0 * self.thickness;
        let same = self.same(first[0], second[0]);
        if first.iter().any(|i| second.contains(i)) || (same && self.is_beside(&first, &second)) {
            return;
        }
        let square = edges_apart(points(first), points(second));
        if square > self.reach * self.reach || (same && edges_apart(rest(first), rest(second)) < closest * closest) {
            return;
        }
        // In one order, whichever of the two comes first in the cells.
        let [first, second] = if first < second { [first, second] } else { [second, first] };
        found.push(Candidate {
            ends: [first[0], first[1], second[0], second[1]],
            is_vertex: false,
            friction,
            apart: square.sqrt(),
        });
    }
}

/// Box of some points; an empty one of none.
fn of(points: impl IntoIterator<Item = Vec3>) -> Bounds {
    let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
    for p in points {
        low = std::array::from_fn(|k| low[k].min(p[k]));
        high = std::array::from_fn(|k| high[k].max(p[k]));
    }
    (scale(add(low, high), 0.5), scale(sub(high, low), 0.5))
}

/// Whether boxes are within reach along each axis.
fn close(a: &Bounds, b: &Bounds, reach: f64) -> bool {
    let apart = |k: usize| (a.0[k] - b.0[k]).abs() - a.1[k] - b.1[k];
    apart(0).max(apart(1)).max(apart(2)) <= reach
}

/// Distance of two boxes \[m\].
pub(crate) fn gap(a: &Bounds, b: &Bounds) -> f64 {
    norm(std::array::from_fn(|k| ((a.0[k] - b.0[k]).abs() - a.1[k] - b.1[k]).max(0.0)))
}

/// Boxes in the given order and in that of cells.
pub(crate) struct Boxes {
    pub(crate) all: Vec<Bounds>,
    cells: Cells,
    sorted: Vec<Bounds>,
    /// Largest half extents \[m\].
    largest: Vec3,
    reach: f64,
}

impl Boxes {
    /// Boxes that are looked for within `reach` of each other \[m\].
    pub(crate) fn new(all: impl Iterator<Item = Bounds>, reach: f64) -> Self {
        let all: Vec<Bounds> = all.collect();
        let centres: Vec<Vec3> = all.iter().map(|b| b.0).collect();
        let largest = [0, 1, 2].map(|k| all.iter().map(|b| b.1[k]).fold(0.0, f64::max));
        // Half of what is asked for about a box: finer cells hold less that is too far, but there are more of them.
        let cells = Cells::new(&centres, norm(largest) + 0.5 * reach);
        let sorted = cells.items().iter().map(|&i| all[i as usize]).collect();
        Self { all, cells, sorted, largest, reach }
    }

    /// Number in the given order of the one that comes at `place` in the order of the cells.
    pub(crate) fn number(&self, place: usize) -> usize {
        self.cells.items()[place] as usize
    }

    /// Calls `f` with the numbers of boxes within reach of the one at `place` in the order of the cells, from that on.
    pub(crate) fn near(&self, place: usize, mut f: impl FnMut(usize)) {
        let bounds = self.sorted[place];
        let around = add(add(bounds.1, self.largest), [self.reach; 3]);
        self.cells.near(bounds.0, around, |range| {
            for other in range.start.max(place)..range.end {
                if close(&self.sorted[other], &bounds, self.reach) {
                    f(self.number(other));
                }
            }
        });
    }
}
