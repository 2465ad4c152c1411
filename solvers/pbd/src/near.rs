//! What may touch during the next substeps, looked for again before anything could have moved further than was allowed
//! for.
//!
//! Points of triangles belong to the state: where on a triangle they are depends on when they were looked for. Pieces of
//! cloth do not: whatever more than those that touch is in the list, and in whatever order, what comes of it is the same.

use cosplat_core::boundary::{Vec3, norm, sub};
use cosplat_core::distance::{Placed, Shape};
use cosplat_core::plugin::{StateError, StateReader, StateSink};

use crate::place::Place;
use crate::proxy::Proxy;
use crate::search;
use crate::sim::Sim;
use crate::vertex::Vertex;
use crate::watch::Watch;

/// Share of the shortest edge that solids may move before they are looked for again.
const ALLOWED: f64 = 0.1;
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
    pub(crate) own: Watch,
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
        let allowed = ALLOWED * setting.shortest;
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
            self.own.renew(&sim.pieces(), speeds.own, setting.shortest, h);
        }
    }

    /// Notes that things move for `h` \[s\].
    pub(crate) fn age(&mut self, sim: &Sim, speeds: Speeds, h: f64) {
        self.spots.moved += h * speeds.solid;
        self.own.age(&sim.pieces(), speeds.own, h);
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
}
