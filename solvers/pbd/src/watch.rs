//! Which pieces of all cloths may touch in a substep.
//!
//! Cloth is watched by two tiles at a time (`tiles`). Of each two it is known how much further apart than what touches
//! their pieces were when they were last looked at. How fast the two have moved relative to each other since is taken from
//! that, and only those of whom it is used up are looked at again: by their boxes, then by how flat the cloth about them is,
//! and last piece by piece. A part of a cloth that whips about costs the rest nothing.
//!
//! Whatever more than what touches is listed, what comes of it is the same, and in the same order: nothing here belongs to
//! the state.

use cosplat_core::boundary::norm;
use rayon::prelude::*;

use crate::own::{Candidate, WATCHED};
use crate::pair::Pair;
use crate::pieces::{Bounds, Boxes, Search, gap};

/// Reach within which tiles are watched, in shortest edges, and in ways of a substep of the fastest.
const WIDE: [f64; 2] = [2.5, 6.0];
/// What is listed beyond what may close in a substep: so many times that, and the least and most of it in shortest edges.
const LISTED: (f64, [f64; 2]) = (2.0, [0.05, 0.3]);
/// Part of a distance that rounding may take.
const ROUNDED: f64 = 1e-9;
/// Couples of a task.
const TASK: usize = 512;

/// Two tiles, or one and itself.
#[derive(Clone, Debug)]
struct Couple {
    tiles: [u32; 2],
    /// How much further than what touches those of their pieces are apart that are not listed: when they were looked at, and
    /// now at least \[m\].
    room: f64,
    left: f64,
    /// What may close in this substep \[m\].
    closing: f64,
    is_due: bool,
    list: Vec<Candidate>,
}

impl Couple {
    fn new(tiles: [u32; 2], left: f64) -> Self {
        Self { tiles, room: left, left, closing: 0.0, is_due: false, list: Vec::new() }
    }

    /// Nothing of them is nearer than `left` beyond what touches \[m\].
    fn rest(&mut self, left: f64) {
        (self.room, self.left) = (left, left);
        self.list.clear();
    }
}

/// What is watched.
#[derive(Clone, Debug)]
pub(crate) struct Watch {
    /// By the numbers of their tiles.
    couples: Vec<Couple>,
    /// How far any two tiles that are not among them may have moved towards each other, and may \[m\].
    moved: f64,
    at_most: f64,
}

impl Default for Watch {
    fn default() -> Self {
        Self { couples: Vec::new(), moved: f64::INFINITY, at_most: 0.0 }
    }
}

/// Does something with each couple, on one thread or several.
fn each(parallel: bool, couples: &mut [Couple], f: impl Fn(&mut Couple) + Sync + Send) {
    if parallel {
        couples.par_iter_mut().with_min_len(TASK).for_each(f);
    } else {
        couples.iter_mut().for_each(f);
    }
}

/// How fast any point of one tile and any of another move relative to each other at most, from the boxes of their
/// velocities \[m/s\].
fn relative(a: &Bounds, b: &Bounds) -> f64 {
    norm(std::array::from_fn(|k| (a.0[k] - b.0[k]).abs() + a.1[k] + b.1[k]))
}

/// Distance below which pieces touch that do not move relative to each other \[m\].
fn touching(search: &Search) -> f64 {
    (1.0 + WATCHED) * search.thickness
}

impl Watch {
    /// Looks again at whatever may touch in a substep of `h` \[s\] and was not looked at near enough, where no two vertices
    /// move faster than `own` \[m/s\] relative to each other and the shortest edge is `shortest` \[m\].
    pub(crate) fn renew(&mut self, search: &Search, own: f64, shortest: f64, h: f64) {
        let touching = touching(search);
        // What closes in a substep, and as much again: what is touched is told by velocities before contact.
        let fastest = 2.0 * h * own;
        if self.moved + fastest > self.at_most {
            (self.moved, self.at_most) = (0.0, (WIDE[0] * shortest).max(WIDE[1] * h * own));
            self.gather(search, touching);
        }
        let speeds = search.speeds();
        each(search.parallel, &mut self.couples, |couple| {
            let [a, b] = couple.tiles.map(|n| n as usize);
            couple.closing = 2.0 * h * relative(&speeds[a], &speeds[b]) + ROUNDED * touching;
            couple.is_due = couple.left < couple.closing;
            if couple.is_due {
                let left = gap(&search.around(a), &search.around(b)) - touching;
                if left >= couple.closing {
                    couple.rest(left);
                    couple.is_due = false;
                }
            }
        });
        let flat = self.flat(search);
        let tiles = &search.mesh.tiles;
        let look = |couple: &mut Couple| {
            let [a, b] = couple.tiles.map(|n| n as usize);
            let left = tiles.blocks(a, b).map(|n| flat[n]).fold(0.0, f64::max) - touching;
            if left >= couple.closing {
                return couple.rest(left);
            }
            let (share, [least, most]) = LISTED;
            let room = couple.closing + (share * couple.closing).clamp(least * shortest, most * shortest);
            couple.rest(room);
            Search { reach: touching + room, ..*search }.between([a, b], &mut couple.list);
        };
        if search.parallel {
            self.couples.par_iter_mut().filter(|couple| couple.is_due).for_each(look);
        } else {
            self.couples.iter_mut().filter(|couple| couple.is_due).for_each(look);
        }
    }

    /// Lists all tiles near each other; what is known of those that were listed before is kept.
    fn gather(&mut self, search: &Search, touching: f64) {
        let reach = touching + self.at_most;
        let tiles = &search.mesh.tiles;
        let boxes = Boxes::new((0..tiles.all.len()).map(|n| search.around(n)), reach);
        let one = |place: usize| {
            let (a, mut found) = (boxes.number(place), Vec::new());
            // Each two tiles are met once, from the one that comes first in the order of the cells.
            boxes.near(place, |b| {
                if search.friction(a, b).is_some() {
                    found.push([a.min(b) as u32, a.max(b) as u32]);
                }
            });
            found
        };
        let lists: Vec<Vec<[u32; 2]>> = if search.parallel {
            (0..tiles.all.len()).into_par_iter().with_min_len(TASK).map(one).collect()
        } else {
            (0..tiles.all.len()).map(one).collect()
        };
        let mut found = lists.concat();
        found.sort_unstable();
        let mut before = std::mem::take(&mut self.couples).into_iter().peekable();
        let couple = |tiles: [u32; 2]| {
            while before.next_if(|c| c.tiles < tiles).is_some() {}
            let [a, b] = tiles.map(|n| &boxes.all[n as usize]);
            let left = gap(a, b) - touching;
            before.next_if(|c| c.tiles == tiles && c.left >= left).unwrap_or_else(|| Couple::new(tiles, left))
        };
        self.couples = found.into_iter().map(couple).collect();
    }

    /// Of each tile that begins a block with two that are due, how far pieces of the block are apart at least \[m\].
    fn flat(&self, search: &Search) -> Vec<f64> {
        let tiles = &search.mesh.tiles;
        let mut wanted = vec![false; tiles.all.len()];
        for couple in self.couples.iter().filter(|c| c.is_due) {
            let [a, b] = couple.tiles.map(|n| n as usize);
            tiles.blocks(a, b).for_each(|n| wanted[n] = true);
        }
        let one = |n: usize| if wanted[n] { tiles.apart(search.mesh, search.vertices, n) } else { 0.0 };
        if search.parallel {
            (0..wanted.len()).into_par_iter().map(one).collect()
        } else {
            (0..wanted.len()).map(one).collect()
        }
    }

    /// Notes that vertices move for `h` \[s\].
    pub(crate) fn age(&mut self, search: &Search, own: f64, h: f64) {
        if self.moved.is_infinite() {
            return;
        }
        self.moved += h * own;
        let speeds = search.speeds();
        each(search.parallel, &mut self.couples, |couple| {
            let [a, b] = couple.tiles.map(|n| n as usize);
            couple.left -= h * relative(&speeds[a], &speeds[b]);
        });
    }

    /// Pieces that touch in the substep of `h` \[s\] that was looked ahead to, in an order that does not depend on when they
    /// were looked for.
    pub(crate) fn pairs(&self, search: &Search, h: f64) -> Vec<Pair> {
        let touching = touching(search) * (1.0 + ROUNDED);
        let of = |couple: &Couple| {
            let spent = couple.room - couple.left + couple.closing;
            let near = couple.list.iter().filter(move |c| c.apart - spent < touching);
            near.filter_map(|c| c.touch(search.vertices, search.thickness, h)).collect::<Vec<_>>()
        };
        let known = |couple: &&Couple| !couple.list.is_empty();
        let lists: Vec<Vec<Pair>> = if search.parallel {
            self.couples.par_iter().filter(known).map(of).collect()
        } else {
            self.couples.iter().filter(known).map(of).collect()
        };
        lists.concat()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::closest::{at, edges_apart, on_triangle};
    use crate::own::Mesh;
    use crate::sheet::Sheet;
    use crate::tiles::{Cut, Tiles};
    use crate::vertex::Vertex;
    use cosplat_core::boundary::{Vec3, add, scale, sub};

    const SPACING: f64 = 0.01;
    const H: f64 = 5e-4;

    fn sheet(thickness: f64) -> Mesh {
        let sheet = Sheet::rectangle([0.16, 0.12], SPACING).expect("small");
        let edges: Vec<[u32; 2]> = sheet.edges.iter().map(|e| e.0).collect();
        let mut mesh = Mesh { triangles: sheet.triangles, edges, rest: sheet.points, ..Mesh::default() };
        (mesh.friction, mesh.bodies) = (vec![Some([0.3, 0.2])], 1);
        let cuts = vec![Cut::new(&mesh.rest, SPACING, Some([SPACING; 2]), 2.0 * thickness)];
        mesh.tiles = Tiles::new(&mesh, &vec![0; mesh.rest.len()], cuts);
        mesh
    }

    /// Ends of all pieces that touch, from each two pieces.
    fn all(mesh: &Mesh, vertices: &[Vertex], thickness: f64) -> Vec<[u32; 4]> {
        let (rest, mut found) = (|i: u32| mesh.rest[i as usize], Vec::new());
        let mut note = |ends: [u32; 4], is_vertex: bool| {
            let candidate = Candidate { ends, is_vertex, friction: [0.0; 2], apart: 0.0 };
            found.extend(candidate.touch(vertices, thickness, H).map(|pair| pair.ends));
        };
        for (i, &e) in mesh.edges.iter().enumerate() {
            for &f in mesh.edges[..i].iter().filter(|f| !f.iter().any(|k| e.contains(k))) {
                if edges_apart(e.map(rest), f.map(rest)).sqrt() >= 2.0 * thickness {
                    let [e, f] = if e < f { [e, f] } else { [f, e] };
                    note([e[0], e[1], f[0], f[1]], false);
                }
            }
        }
        for v in 0..vertices.len() as u32 {
            for t in mesh.triangles.iter().filter(|t| !t.contains(&v)) {
                let corners = t.map(rest);
                if norm(sub(at(corners, on_triangle(corners, rest(v))), rest(v))) >= 2.0 * thickness {
                    note([v, t[0], t[1], t[2]], true);
                }
            }
        }
        found.sort_unstable();
        found
    }

    #[test]
    fn nothing_that_touches_is_missed_however_cloth_moves() {
        let thickness = 0.004;
        let mesh = sheet(thickness);
        let owner = vec![0; mesh.rest.len()];
        // Folds that run across a sheet which is folded up, a corner of which whips.
        let place = |p: &Vec3, t: f64| {
            let whip = if p[0] > 0.05 { 0.02 * (300.0 * t).sin() } else { 0.0 };
            let wave = 0.012 * (90.0 * p[0] + 200.0 * t).sin();
            [0.6 * p[0], p[1] + whip, wave * (1.0 - 20.0 * t) + 0.3 * p[1] * (60.0 * p[0]).sin()]
        };
        let (mut watch, mut seen, mut order): (Watch, usize, Option<bool>) = (Watch::default(), 0, None);
        for step in 0..40 {
            let t = H * f64::from(step);
            let moving = |p: &Vec3| {
                let [x, later] = [place(p, t), place(p, t + H)];
                Vertex { x, u: scale(sub(later, x), 1.0 / H), w: 1.0, mass: 1.0 }
            };
            let vertices: Vec<Vertex> = mesh.rest.iter().map(moving).collect();
            let parallel = step % 2 == 0;
            let search = Search { mesh: &mesh, vertices: &vertices, owner: &owner, reach: 0.0, thickness, parallel };
            let own = vertices.iter().map(|v| norm(v.u)).fold(0.0, f64::max) * 2.0;
            watch.renew(&search, own, SPACING, H);
            let ends = |watch: &Watch| watch.pairs(&search, H).iter().map(|p| p.ends).collect::<Vec<_>>();
            let found = ends(&watch);
            // As a run that was resumed finds them.
            let mut fresh = Watch::default();
            fresh.renew(&search, own, SPACING, H);
            order = Some(order.unwrap_or(true) && ends(&fresh) == found);
            seen += found.len();
            let mut found = found;
            found.sort_unstable();
            assert_eq!(found, all(&mesh, &vertices, thickness), "step {step}");
            watch.age(&search, own, H);
        }
        assert!(order == Some(true) && seen > 500, "{order:?} {seen}");
    }

    #[test]
    fn points_of_tiles_are_no_faster_than_their_boxes_say() {
        let a: Bounds = ([1.0, 0.0, 0.0], [0.5, 0.2, 0.0]);
        let b: Bounds = ([-1.0, 0.3, 0.0], [0.1, 0.0, 0.4]);
        let corner =
            |b: &Bounds, n: u32| add(b.0, std::array::from_fn(|k| b.1[k] * if n >> k & 1 == 1 { 1.0 } else { -1.0 }));
        let most = relative(&a, &b);
        for (i, j) in (0..8).flat_map(|i| (0..8).map(move |j| (i, j))) {
            assert!(norm(sub(corner(&a, i), corner(&b, j))) <= most * (1.0 + ROUNDED));
        }
    }
}
