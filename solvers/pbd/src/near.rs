//! What may touch during the next substeps, looked for again before anything could have moved further than was allowed
//! for.
//!
//! Points of triangles belong to the state: where on a triangle they are depends on when they were looked for. Pieces of
//! cloth do not: whatever more than those that touch is in the list, and in whatever order, what comes of it is the same.

use cosplat_core::boundary::{Vec3, norm, sub};
use cosplat_core::distance::{Placed, Shape};
use cosplat_core::plugin::{StateError, StateReader, StateSink};

use crate::own::{Candidate, WATCHED};
use crate::patches::Patches;
use crate::pieces;
use crate::place::Place;
use crate::proxy::Proxy;
use crate::search;
use crate::sim::Sim;
use crate::vertex::Vertex;

/// Share of the shortest edge that pieces of cloth, and solids, may move before they are looked for again.
const ALLOWED: f64 = 0.3;
const ALLOWED_SOLID: f64 = 0.1;
/// Width of the patches within which cloth moves together, in shortest edges.
const PATCH: f64 = 4.0;
/// Share of the thickness by which a face must be deeper than its corners to be met between them.
const TOLERANCE: f64 = 0.1;

/// The other side of a point of a triangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Target {
    /// A static collider, by its number.
    Wall(usize),
    /// A rigid partner.
    Proxy(usize),
}

/// A list that ages.
#[derive(Clone, Debug)]
struct Aging<T> {
    list: Vec<T>,
    /// How far things may have moved since \[m\].
    moved: f64,
}

impl<T> Default for Aging<T> {
    fn default() -> Self {
        Self { list: Vec::new(), moved: f64::INFINITY }
    }
}

/// What is near.
#[derive(Clone, Debug, Default)]
pub(crate) struct Near {
    spots: Aging<(Place, Target)>,
    own: Aging<Candidate>,
    /// For the age of pieces of cloth, and what any two of them may have moved relative to each other, and may at most
    /// \[m\].
    patches: Patches,
    moved_far: f64,
    at_most: f64,
}

/// How fast things move \[m/s\].
#[derive(Clone, Copy, Debug)]
pub(crate) struct Speeds {
    /// Largest towards a solid.
    solid: f64,
    /// Largest of two vertices relative to each other.
    pub(crate) own: f64,
}

impl Speeds {
    /// Of vertices and partners with these radii \[m\].
    pub(crate) fn new(vertices: &[Vertex], partners: &[Proxy], radii: impl Iterator<Item = f64>) -> Self {
        let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
        for v in vertices {
            low = std::array::from_fn(|k| low[k].min(v.u[k]));
            high = std::array::from_fn(|k| high[k].max(v.u[k]));
        }
        if vertices.is_empty() {
            (low, high) = ([0.0; 3], [0.0; 3]);
        }
        let farthest: Vec3 = std::array::from_fn(|k| low[k].abs().max(high[k].abs()));
        let turning = |(p, radius): (&Proxy, f64)| norm(p.twist()[0]) + norm(p.twist()[1]) * radius;
        let others = partners.iter().zip(radii).map(turning).fold(0.0, f64::max);
        Self { solid: norm(farthest) + others, own: norm(sub(high, low)) }
    }
}

/// Radius of a shape about its origin \[m\]; of an infinite one none.
pub(crate) fn radius(shape: &Shape) -> f64 {
    match shape {
        Shape::Plane(half) => half.map_or(0.0, |[a, b]| a.hypot(b)),
        // The plan refuses it: cloth lacks the feature.
        Shape::HeightField(_) => 0.0,
        Shape::Box(half) => norm(*half),
        Shape::Sphere(radius) => *radius,
        Shape::Cylinder(radius, half) => radius.hypot(*half),
        Shape::Mesh(mesh) => mesh.radius(),
    }
}

impl Near {
    /// Looks again where something may have moved too far by the end of a substep of `h` \[s\].
    pub(crate) fn renew(&mut self, sim: &Sim, placed: &[Placed], speeds: Speeds, h: f64) {
        let setting = &sim.setting;
        let allowed = ALLOWED_SOLID * setting.shortest;
        let flat = setting.walls.iter().all(|wall| wall.is_half_space) && placed.is_empty();
        if self.spots.moved + h * speeds.solid > allowed && !flat {
            let search = search::Search {
                vertices: &sim.vertices,
                triangles: &sim.mesh.triangles,
                reach: 0.5 * setting.thickness + allowed.max(h * speeds.solid) + h * speeds.solid,
                tolerance: TOLERANCE * setting.thickness,
                parallel: setting.parallel,
            };
            let mut list = Vec::new();
            let body = |i: usize| sim.owner[i] as usize;
            for (w, wall) in setting.walls.iter().enumerate().filter(|(_, wall)| !wall.is_half_space) {
                let found = search.run(&wall.shape, |i| wall.surface[body(i)].is_some());
                list.extend(found.into_iter().map(|place| (place, Target::Wall(w))));
            }
            for (p, shape) in placed.iter().enumerate() {
                let found = search.run(shape, |i| setting.partners[p].surface[body(i)].is_some());
                list.extend(found.into_iter().map(|place| (place, Target::Proxy(p))));
            }
            self.spots = Aging { list, moved: 0.0 };
        }
        if !sim.mesh.friction.is_empty() {
            self.renew_own(sim, speeds, h);
        }
    }

    fn renew_own(&mut self, sim: &Sim, speeds: Speeds, h: f64) {
        let (setting, vertices) = (&sim.setting, &sim.vertices);
        let allowed = ALLOWED * setting.shortest;
        if self.own.moved.is_finite()
            && self.patches.ahead(vertices, h) <= allowed
            && self.moved_far + h * speeds.own <= self.at_most
        {
            return;
        }
        // What is touched in this substep must be within reach, however fast: so must the patches be wide.
        let fastest = (1.0 + WATCHED) * setting.thickness + allowed + 2.0 * h * speeds.own;
        self.patches = Patches::new(vertices, (PATCH * setting.shortest).max(2.0 * fastest));
        let closing = self.patches.ahead(vertices, h);
        // Touching is also what may be closed by a push, `Candidate::touch`.
        let reach = (1.0 + WATCHED) * setting.thickness + allowed.max(closing) + closing;
        let search = pieces::Search {
            mesh: &sim.mesh,
            vertices,
            owner: &sim.owner,
            reach,
            thickness: setting.thickness,
            parallel: setting.parallel,
        };
        // Sorted: the list may be older or younger in a run that was resumed.
        let mut list = search.run();
        list.sort_unstable_by_key(Candidate::key);
        self.own = Aging { list, moved: 0.0 };
        (self.moved_far, self.at_most) = (0.0, self.patches.side - reach);
    }

    /// Notes that things move for `h` \[s\].
    pub(crate) fn age(&mut self, vertices: &[Vertex], speeds: Speeds, h: f64) {
        self.spots.moved += h * speeds.solid;
        if self.own.moved.is_finite() {
            self.patches.age(vertices, h);
            self.moved_far += h * speeds.own;
        }
    }

    /// Points of triangles near solids.
    pub(crate) fn spots(&mut self) -> &mut [(Place, Target)] {
        &mut self.spots.list
    }

    /// Writes what belongs to the state.
    pub(crate) fn save(&self, sink: &mut dyn StateSink) {
        sink.f64(self.spots.moved);
        sink.u64(self.spots.list.len() as u64);
        for (place, target) in &self.spots.list {
            let (ends, share) = place.raw();
            let (kind, number) = match *target {
                Target::Wall(w) => (0, w),
                Target::Proxy(p) => (1, p),
            };
            for n in [ends[0].into(), ends[1].into(), ends[2].into(), kind, number as u64] {
                sink.u64(n);
            }
            sink.vec3(share);
        }
    }

    /// Reads it back, for so many vertices, walls and partners.
    pub(crate) fn restore(
        reader: &mut StateReader,
        [vertices, walls, partners]: [usize; 3],
    ) -> Result<Self, StateError> {
        let moved = reader.f64()?;
        let (found, mut list) = (reader.u64()?, Vec::new());
        for _ in 0..found {
            let numbers = [reader.u64()?, reader.u64()?, reader.u64()?, reader.u64()?, reader.u64()?];
            let [a, b, c, kind, number] = numbers.map(|n| n as usize);
            let share = reader.vec3()?;
            let count = if kind == 0 { walls } else { partners };
            if [a, b, c].iter().any(|&i| i >= vertices) || number >= count {
                return Err(StateError::Count {
                    what: "points of contact",
                    found: number as u64,
                    expected: count as u64,
                });
            }
            let target = if kind == 0 { Target::Wall(number) } else { Target::Proxy(number) };
            list.push((Place::on([a, b, c].map(|i| i as u32), share), target));
        }
        Ok(Self { spots: Aging { list, moved }, ..Self::default() })
    }

    /// Pieces of cloth near each other, sorted.
    pub(crate) fn candidates(&self) -> &[Candidate] {
        &self.own.list
    }

    /// Whether two pieces may touch in the substep that was looked ahead to, by how far they were apart and what is about
    /// them has moved since: who does not is not looked at, and would not have touched.
    pub(crate) fn may_touch(&self, candidate: &Candidate, thickness: f64) -> bool {
        let [a, b, ..] = candidate.ends.map(|i| self.patches.closing(i));
        let closing = if candidate.is_vertex { a } else { a.max(b) };
        // Rounded once more than what it is compared with.
        candidate.apart - closing < (1.0 + WATCHED + 1e-9) * thickness
    }
}
