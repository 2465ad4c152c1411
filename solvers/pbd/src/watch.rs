//! Which pieces of all cloths may touch in a substep.
//!
//! Cloth is watched by two tiles at a time (`tiles`, `couple`). Those that are due are looked at by their boxes, then by how
//! flat the cloth about them is, or along the one and the other, and last piece by piece. A part of a cloth that whips about
//! costs the rest nothing.
//!
//! Whatever more than what touches is listed, what comes of it is the same, and in the same order: nothing here belongs to
//! the state.

use rayon::prelude::*;

use crate::couple::{Now, Row, touching};
use crate::pair::Pair;
use crate::pieces::{Boxes, Room, Search};

/// Reach within which tiles are watched, in shortest edges, and in ways of a substep of the fastest.
const WIDE: [f64; 2] = [2.5, 6.0];
/// Rows of a task.
const TASK: usize = 32;

/// What is watched.
#[derive(Clone, Debug)]
pub(crate) struct Watch {
    /// Of each tile.
    rows: Vec<Row>,
    /// How far any two vertices may have moved towards each other since tiles near each other were gathered, and how far
    /// apart at least those are that were not \[m\].
    moved: f64,
    at_most: f64,
}

impl Default for Watch {
    fn default() -> Self {
        Self { rows: Vec::new(), moved: f64::INFINITY, at_most: 0.0 }
    }
}

/// Does something with each item, on one thread or several; each task has room of its own to work in.
fn each<T: Send, R: Default>(parallel: bool, items: &mut [T], f: impl Fn(&mut R, (usize, &mut T)) + Sync + Send) {
    if parallel {
        items.par_iter_mut().enumerate().with_min_len(TASK).for_each_init(R::default, f);
    } else {
        let mut room = R::default();
        items.iter_mut().enumerate().for_each(|item| f(&mut room, item));
    }
}

impl Watch {
    /// Looks again at whatever may touch in a substep of `h` \[s\] and was not looked at near enough, where no two vertices
    /// move faster than `own` \[m/s\] relative to each other and the shortest edge is `shortest` \[m\].
    pub(crate) fn renew(&mut self, search: &Search, own: f64, shortest: f64, h: f64) {
        // What closes in a substep, and as much again: what is touched is told by velocities before contact.
        let fastest = 2.0 * h * own;
        let (places, speeds) = (search.places(), search.speeds());
        let mut now =
            Now { search, places, speeds, touching: touching(search), h, fastest, moved: self.moved, shortest };
        if self.moved + fastest > self.at_most {
            (self.moved, self.at_most) = (0.0, (WIDE[0] * shortest).max(WIDE[1] * h * own));
            now.moved = 0.0;
            self.gather(&now);
        }
        each(search.parallel, &mut self.rows, |(), (a, row)| row.wake(a, &now));
        let flat = self.flat(search);
        each(search.parallel, &mut self.rows, |room: &mut Room, (a, row)| row.look(a, &flat, &now, room));
    }

    /// Takes all tiles near each other.
    fn gather(&mut self, now: &Now) {
        let boxes = Boxes::new(&now.places, now.touching + self.at_most);
        self.rows.resize(now.places.len(), Row::default());
        each(now.search.parallel, &mut self.rows, |found: &mut Vec<u32>, (a, row)| {
            boxes.near(a, found);
            found.retain(|&b| now.search.friction(a, b as usize).is_some());
            row.gather(a, found, now);
        });
    }

    /// Of each tile that begins a block with two that are due, how far pieces of the block are apart at least \[m\].
    fn flat(&self, search: &Search) -> Vec<f64> {
        let (tiles, mut flat) = (&search.mesh.tiles, vec![0.0; self.rows.len()]);
        (0..).zip(&self.rows).for_each(|(a, row)| row.wanted(a, search, |n| flat[n] = f64::NAN));
        each(search.parallel, &mut flat, |room, (n, flat)| {
            if flat.is_nan() {
                *flat = tiles.apart(search.mesh, search.vertices, n, room);
            }
        });
        flat
    }

    /// Notes that vertices move for `h` \[s\].
    pub(crate) fn age(&mut self, search: &Search, own: f64, h: f64) {
        if self.moved.is_infinite() {
            return;
        }
        self.moved += h * own;
        let speeds = search.speeds();
        each(search.parallel, &mut self.rows, |(), (a, row)| row.age(a, &speeds, h));
    }

    /// Pieces that touch in the substep of `h` \[s\] that was looked ahead to, in an order that does not depend on when they
    /// were looked for.
    pub(crate) fn pairs(&mut self, search: &Search, h: f64) -> Vec<Pair> {
        let of = |row: &mut Row| row.pairs(search, h);
        let lists: Vec<Vec<Pair>> = if search.parallel {
            self.rows.par_iter_mut().with_min_len(TASK).map(of).collect()
        } else {
            self.rows.iter_mut().map(of).collect()
        };
        lists.concat()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::closest::{at, edges_apart, on_triangle};
    use crate::own::{Candidate, Mesh};
    use crate::sheet::Sheet;
    use crate::tiles::{Cut, Tiles};
    use crate::vertex::Vertex;
    use cosplat_core::boundary::{Vec3, norm, scale, sub};

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
            let mut candidate = Candidate { ends, is_vertex, friction: [0.0; 2], apart: 0.0 };
            found.extend(candidate.touch(vertices, (thickness, H), [f64::INFINITY, 0.0, 0.0]).map(|pair| pair.ends));
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
            let search = Search { mesh: &mesh, vertices: &vertices, reach: 0.0, thickness, parallel };
            let own = vertices.iter().map(|v| norm(v.u)).fold(0.0, f64::max) * 2.0;
            watch.renew(&search, own, SPACING, H);
            let ends = |watch: &mut Watch| watch.pairs(&search, H).iter().map(|p| p.ends).collect::<Vec<_>>();
            let found = ends(&mut watch);
            // As a run that was resumed finds them.
            let mut fresh = Watch::default();
            fresh.renew(&search, own, SPACING, H);
            order = Some(order.unwrap_or(true) && ends(&mut fresh) == found);
            seen += found.len();
            let mut found = found;
            found.sort_unstable();
            assert_eq!(found, all(&mesh, &vertices, thickness), "step {step}");
            watch.age(&search, own, H);
        }
        assert!(order == Some(true) && seen > 500, "{order:?} {seen}");
    }
}
