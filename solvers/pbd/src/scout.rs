//! Which vertices and points of triangles can touch what in a substep.

use cosplat_core::boundary::{Vec3, add, dot, norm, scale, sub};

use crate::contact::{Cause, HOLDS, Surface, Touch, at_walls};
use crate::course::{Course, Desk};
use crate::near::Target;
use crate::place::Place;
use crate::sim::{Setting, Wall};
use crate::vertex::Vertex;
use cosplat_core::distance::{Placed, SignedDistance};

/// Steps of a point down the distance, for each way of the two sides relative to each other: what slides over a ridge
/// of 60° is followed.
const FOLLOW: f64 = 2.0;
/// The least step, in shortest edges.
const LEAST_STEP: f64 = 0.01;

/// Looks for contact.
pub(crate) struct Scout<'s, 'a> {
    pub(crate) setting: &'s Setting,
    pub(crate) course: &'s Course<'a>,
    pub(crate) placed: &'s [Placed],
    pub(crate) owner: &'s [u32],
    pub(crate) h: f64,
}

impl Scout<'_, '_> {
    /// Finds what points of triangles touch, and lets them follow the ridges that they are on: each goes down the
    /// distance by what the two sides move in a substep, or a little where they rest.
    pub(crate) fn spots(&self, spots: &mut [(Place, Target)], vertices: &[Vertex], touches: &mut Vec<Touch>) {
        let half = 0.5 * self.setting.thickness;
        for (spot, target) in spots {
            let place = *spot;
            let (x, body) = (place.position(vertices), self.owner[place.first()] as usize);
            let (shape, surface, cause, other) = match *target {
                Target::Wall(w) => {
                    let wall = &self.setting.walls[w];
                    (&wall.shape, wall.surface[body], Cause::Wall, [0.0; 3])
                }
                Target::Proxy(p) => {
                    let surface = self.setting.partners[p].surface[body];
                    (&self.placed[p], surface, Cause::Proxy(p), self.course.proxies[p].velocity(x))
                }
            };
            let Some(surface) = surface else { continue };
            let (distance, normal) = shape.distance(x);
            let relative = sub(place.velocity(vertices), other);
            touches.extend(self.note(relative, place, cause, (distance - half, normal), surface));
            let step = FOLLOW * self.h * norm(relative) + LEAST_STEP * self.setting.shortest;
            *spot = place.moved(vertices, scale(normal, -step));
        }
        for (s, (swarm, meeting)) in self.course.swarms.iter().zip(&self.course.meetings).enumerate() {
            let is_free = |place: &Place| !place.parts().any(|(i, _)| self.is_bound(i, Cause::Sample(s, 0)));
            for contact in swarm.contacts.iter().filter(|c| is_free(&c.place)) {
                let (place, ends, share) = (contact.place, contact.samples, contact.share);
                let is_seam = ends[0] != ends[1];
                let cause = if is_seam { Cause::Seam(s, ends, share) } else { Cause::Sample(s, ends[0]) };
                let relative = sub(place.velocity(vertices), swarm.between(ends, share).0);
                touches.extend(self.note(relative, place, cause, (contact.gap, contact.out), meeting.surface));
            }
        }
    }

    /// Finds what the vertices of a block touch. Those that touch walls only are solved at once, but for those that are
    /// busy elsewhere.
    pub(crate) fn block(&self, from: usize, vertices: &mut [Vertex], desk: &mut Desk, busy: &[bool]) {
        desk.touches.clear();
        let (mut low, mut high, mut speed) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3], 0.0_f64);
        for v in vertices.iter() {
            low = std::array::from_fn(|k| low[k].min(v.x[k]));
            high = std::array::from_fn(|k| high[k].max(v.x[k]));
            speed = speed.max(norm(v.u));
        }
        let (middle, radius) = (scale(add(low, high), 0.5), 0.5 * norm(sub(high, low)));
        let half = 0.5 * self.setting.thickness;
        let close = |shape: &Placed, other: f64| shape.at_least(middle, radius) < half + 2.0 * self.h * (speed + other);
        let walls: Vec<&Wall> = self.setting.walls.iter().filter(|w| close(&w.shape, 0.0)).collect();
        let near = |p: &usize| {
            let proxy = &self.course.proxies[*p];
            close(&self.placed[*p], norm(proxy.velocity(middle)) + norm(proxy.twist()[1]) * radius)
        };
        let partners: Vec<usize> = (0..self.placed.len()).filter(near).collect();
        if walls.is_empty() && partners.is_empty() {
            return;
        }
        for (k, vertex) in vertices.iter_mut().enumerate() {
            let body = self.owner[from + k] as usize;
            let place = Place::vertex((from + k) as u32);
            desk.alone.clear();
            for wall in &walls {
                let Some(surface) = wall.surface[body] else { continue };
                let (distance, normal) = wall.shape.distance(vertex.x);
                desk.alone.extend(self.note(vertex.u, place, Cause::Wall, (distance - half, normal), surface));
            }
            let alone = desk.alone.len();
            for &p in partners.iter().filter(|p| !self.is_bound(from + k, Cause::Proxy(**p))) {
                let Some(surface) = self.setting.partners[p].surface[body] else { continue };
                let (distance, normal) = self.placed[p].distance(vertex.x);
                let relative = sub(vertex.u, self.course.proxies[p].velocity(vertex.x));
                desk.alone.extend(self.note(relative, place, Cause::Proxy(p), (distance - half, normal), surface));
            }
            if desk.alone.len() > alone || busy[from + k] {
                desk.touches.append(&mut desk.alone);
            } else if alone > 0 && vertex.w > 0.0 {
                desk.count += alone as u64;
                at_walls(vertex, &mut desk.alone, self.h, &mut desk.held);
            }
        }
    }

    /// Whether a vertex is attached to what it would touch.
    fn is_bound(&self, vertex: usize, cause: Cause) -> bool {
        let bonds = &self.course.bonds;
        let first = bonds.partition_point(|b| (b.vertex as usize) < vertex);
        bonds[first..].iter().take_while(|b| b.vertex as usize == vertex).any(|b| match (b.cause, cause) {
            (Cause::Proxy(a), Cause::Proxy(b)) | (Cause::Sample(a, _), Cause::Sample(b, _)) => a == b,
            _ => false,
        })
    }

    /// Notes a place that may close its gap in this substep.
    ///
    /// At a partner that can also happen by what others do to it: there a little more is watched.
    fn note(
        &self,
        relative: Vec3,
        place: Place,
        cause: Cause,
        (gap, normal): (f64, Vec3),
        surface: Surface,
    ) -> Option<Touch> {
        let closing = gap + self.h * dot(relative, normal);
        // A point between corners is also moved by what is done to them.
        let watched = match cause {
            Cause::Wall if place.is_vertex() => 0.0,
            _ => self.h * norm(relative) + 0.05 * self.setting.thickness,
        };
        let touches = closing < watched || (surface == Surface::Stick && gap <= HOLDS);
        touches.then(|| Touch::new(place, cause, normal, gap, surface))
    }
}
