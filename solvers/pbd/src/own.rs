//! Which vertices and triangles, and which edges, of all cloths are near each other, and which of them touch.
//!
//! What is closer than twice the thickness at rest is left alone: it could never be a thickness apart.

use cosplat_core::boundary::{Vec3, add, cross, dot, norm, scale, sub};
use rayon::prelude::*;

use crate::cells::Cells;
use crate::closest::{at, edges_apart, of_edges, on_triangle};
use crate::pair::Pair;
use crate::vertex::Vertex;

/// The surface of all cloths, by vertices in memory.
#[derive(Clone, Debug, Default)]
pub(crate) struct Mesh {
    pub(crate) triangles: Vec<[u32; 3]>,
    pub(crate) edges: Vec<[u32; 2]>,
    /// Which sides and corners of each triangle lie on a rim, as [`crate::rim`] numbers them.
    pub(crate) rim: Vec<u8>,
    /// Places of the vertices at rest, each in the frame of its body \[m\].
    pub(crate) rest: Vec<Vec3>,
    /// Static and kinetic friction of each two bodies, row by row; nothing where they pass through each other.
    pub(crate) friction: Vec<Option<[f64; 2]>>,
    /// Number of bodies.
    pub(crate) bodies: usize,
}

/// Two pieces that may touch before the next search.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Candidate {
    /// A vertex and a triangle, or two edges.
    ends: [u32; 4],
    is_vertex: bool,
    friction: [f64; 2],
}

/// What a search is about.
pub(crate) struct Search<'a> {
    pub(crate) mesh: &'a Mesh,
    pub(crate) vertices: &'a [Vertex],
    pub(crate) owner: &'a [u32],
    /// Distance within which pieces matter \[m\].
    pub(crate) reach: f64,
    pub(crate) thickness: f64,
    pub(crate) parallel: bool,
}

impl Search<'_> {
    /// All candidates, in a fixed order.
    pub(crate) fn run(&self) -> Vec<Candidate> {
        let mut found = self.of_vertices();
        found.append(&mut self.of_edges());
        found
    }

    fn x(&self, i: u32) -> Vec3 {
        self.vertices[i as usize].x
    }

    /// Collects what `f` finds for each of `count` pieces, in their order.
    fn each(&self, count: usize, f: impl Fn(usize, &mut Vec<Candidate>) + Sync) -> Vec<Candidate> {
        if !self.parallel {
            let mut all = Vec::new();
            (0..count).for_each(|i| f(i, &mut all));
            return all;
        }
        let chunks = count.div_ceil(CHUNK);
        let one = |c: usize| {
            let mut some = Vec::new();
            (c * CHUNK..((c + 1) * CHUNK).min(count)).for_each(|i| f(i, &mut some));
            some
        };
        let lists: Vec<Vec<Candidate>> = (0..chunks).into_par_iter().map(one).collect();
        lists.concat()
    }

    fn friction(&self, a: u32, b: u32) -> Option<[f64; 2]> {
        let [a, b] = [a, b].map(|i| self.owner[i as usize] as usize);
        self.mesh.friction[a * self.mesh.bodies + b]
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

    fn of_vertices(&self) -> Vec<Candidate> {
        let triangles = &self.mesh.triangles;
        let corners = |t: [u32; 3]| t.map(|i| self.x(i));
        let list = Boxes::new(triangles.iter().map(|&t| of(&corners(t))), self.reach);
        let rest = |i: u32| self.mesh.rest[i as usize];
        self.each(self.vertices.len(), |v, found| {
            let x = self.x(v as u32);
            list.near(0, (x, [0.0; 3]), |t| {
                let (v, ends @ [a, b, c]) = (v as u32, triangles[t]);
                if v == a || v == b || v == c {
                    return;
                }
                let Some(friction) = self.friction(v, a) else { return };
                if self.same(v, a) && self.is_beside(&[v], &ends) {
                    return;
                }
                let far = |p: Vec3, points: [Vec3; 3]| norm(sub(p, at(points, on_triangle(points, p))));
                if far(x, corners(ends)) > self.reach {
                    return;
                }
                if self.same(v, a) && far(rest(v), ends.map(rest)) < 2.0 * self.thickness {
                    return;
                }
                found.push(Candidate { ends: [v, a, b, c], is_vertex: true, friction });
            });
        })
    }

    fn of_edges(&self) -> Vec<Candidate> {
        let edges = &self.mesh.edges;
        let points = |e: [u32; 2]| e.map(|i| self.x(i));
        let list = Boxes::new(edges.iter().map(|&e| of(&points(e))), self.reach);
        let rest = |e: [u32; 2]| e.map(|i| self.mesh.rest[i as usize]);
        self.each(edges.len(), |place, found| {
            let first = edges[list.number(place)];
            // Each two edges are met once, from the one that comes first in the order of the cells.
            list.near(place + 1, list.sorted[place], |f| {
                let second = edges[f];
                if first.iter().any(|i| second.contains(i)) {
                    return;
                }
                let Some(friction) = self.friction(first[0], second[0]) else { return };
                if self.same(first[0], second[0]) && self.is_beside(&first, &second) {
                    return;
                }
                if edges_apart(points(first), points(second)) > self.reach * self.reach {
                    return;
                }
                let closest = 2.0 * self.thickness;
                if self.same(first[0], second[0]) && edges_apart(rest(first), rest(second)) < closest * closest {
                    return;
                }
                // In one order, whichever of the two comes first in the cells.
                let [first, second] = if first < second { [first, second] } else { [second, first] };
                let ends = [first[0], first[1], second[0], second[1]];
                found.push(Candidate { ends, is_vertex: false, friction });
            });
        })
    }
}

/// Centre and half extents of a box \[m\].
type Bounds = (Vec3, Vec3);

/// Box of some points.
fn of<const N: usize>(points: &[Vec3; N]) -> Bounds {
    let fold = |f: fn(f64, f64) -> f64| [0, 1, 2].map(|k| points.iter().skip(1).fold(points[0][k], |m, p| f(m, p[k])));
    let (low, high) = (fold(f64::min), fold(f64::max));
    (scale(add(low, high), 0.5), scale(sub(high, low), 0.5))
}

/// Boxes in the order of cells.
struct Boxes {
    cells: Cells,
    sorted: Vec<Bounds>,
    /// Largest half extents \[m\].
    largest: Vec3,
    reach: f64,
}

impl Boxes {
    fn new(all: impl Iterator<Item = Bounds>, reach: f64) -> Self {
        let all: Vec<Bounds> = all.collect();
        let centres: Vec<Vec3> = all.iter().map(|b| b.0).collect();
        let largest = [0, 1, 2].map(|k| all.iter().map(|b| b.1[k]).fold(0.0, f64::max));
        // Half of what is asked for about a box: finer cells hold less that is too far, but there are more of them.
        let cells = Cells::new(&centres, norm(largest) + 0.5 * reach);
        let sorted = cells.items().iter().map(|&i| all[i as usize]).collect();
        Self { cells, sorted, largest, reach }
    }

    /// Number in the given order of the one that comes at `place` in the order of the cells.
    fn number(&self, place: usize) -> usize {
        self.cells.items()[place] as usize
    }

    /// Calls `f` with the numbers of boxes within reach of a box, from the place `first` on.
    fn near(&self, first: usize, (centre, half): Bounds, mut f: impl FnMut(usize)) {
        let around = add(add(half, self.largest), [self.reach; 3]);
        let close = |b: &Bounds| {
            let apart = |k: usize| (b.0[k] - centre[k]).abs() - b.1[k] - half[k];
            apart(0).max(apart(1)).max(apart(2)) <= self.reach
        };
        self.cells.near(centre, around, |range| {
            for place in range.start.max(first)..range.end {
                if close(&self.sorted[place]) {
                    f(self.number(place));
                }
            }
        });
    }
}

/// Vertices or edges of a task.
const CHUNK: usize = 256;

impl Candidate {
    /// By what candidates are sorted.
    pub(crate) fn key(&self) -> (bool, [u32; 4]) {
        (self.is_vertex, self.ends)
    }

    /// The contact of the two, where they may close their gap in a substep of `h` \[s\].
    pub(crate) fn touch(&self, vertices: &[Vertex], thickness: f64, h: f64) -> Option<Pair> {
        let x = self.ends.map(|i| vertices[i as usize].x);
        let share = if self.is_vertex {
            let [a, b, c] = on_triangle([x[1], x[2], x[3]], x[0]);
            [1.0, -a, -b, -c]
        } else {
            let [s, t] = of_edges([x[0], x[1]], [x[2], x[3]])?;
            [1.0 - s, s, t - 1.0, -t]
        };
        let between = x.iter().zip(share).fold([0.0; 3], |sum, (&x, c)| add(sum, scale(x, c)));
        let apart = norm(between);
        let normal = if apart > 0.0 { scale(between, 1.0 / apart) } else { self.across(x)? };
        let pair = Pair {
            ends: self.ends,
            share,
            normal,
            apart,
            gap: apart - thickness,
            friction: self.friction,
            pressed: 0.0,
            rubbed: [0.0; 3],
        };
        let velocity = pair.velocity(vertices);
        // Others may push it while contacts are solved: a little more than what closes by itself is watched.
        let watched = h * norm(velocity) + 0.05 * thickness;
        (pair.gap + h * dot(velocity, normal) < watched).then_some(pair)
    }

    /// A direction across two pieces that meet in a point.
    fn across(&self, x: [Vec3; 4]) -> Option<Vec3> {
        let n = if self.is_vertex {
            cross(sub(x[2], x[1]), sub(x[3], x[1]))
        } else {
            cross(sub(x[1], x[0]), sub(x[3], x[2]))
        };
        let length = norm(n);
        (length > 0.0).then(|| scale(n, 1.0 / length))
    }
}
