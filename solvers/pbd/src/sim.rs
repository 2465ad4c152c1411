//! One substep, and the steps made of them.

use std::ops::Range;

use cosplat_core::boundary::{Vec3, add, norm, scale, sub};
use cosplat_core::plugin::{PartAction, PluginError, Pulse, Push, Signal};

use crate::air::wind;
use crate::bend::Hinge;
use crate::contact::Surface;
use crate::course::{Course, Desk, Kick};
use crate::own::Mesh;
use crate::pull::Pull;
use crate::samples::Swarm;
use crate::stretch::Edge;
use crate::sweep::Sweep;
use crate::tally::Tally;
use crate::vertex::{Phases, Solve, Vertex};
use cosplat_core::distance::{Placed, Shape};

/// Part of the shortest edge that a vertex may move in a substep.
pub(crate) const COURANT: f64 = 0.3;
/// Substeps of a step beyond which a cloth is not fast but blowing up.
const MOST_SUBSTEPS: f64 = 1e6;

/// A static collider and its surface for each body; `None` where the pair is left out.
#[derive(Clone, Debug)]
pub(crate) struct Wall {
    pub(crate) shape: Placed,
    /// Over which distance is linear, so that corners tell all of a triangle.
    pub(crate) is_half_space: bool,
    pub(crate) surface: Vec<Option<Surface>>,
}

/// What never changes about a rigid partner: its shape about its centre of mass, and its surface for each body.
#[derive(Clone, Debug)]
pub(crate) struct Partner {
    pub(crate) name: String,
    pub(crate) shape: Shape,
    pub(crate) surface: Vec<Option<Surface>>,
}

/// What never changes in a run.
#[derive(Clone, Debug)]
pub(crate) struct Setting {
    pub(crate) actions: Vec<PartAction>,
    pub(crate) walls: Vec<Wall>,
    pub(crate) partners: Vec<Partner>,
    /// Number of bodies.
    pub(crate) bodies: usize,
    /// Thickness of the cloth \[m\].
    pub(crate) thickness: f64,
    /// Iterations of stretch and of bending in a substep.
    pub(crate) iterations: [u32; 2],
    /// Whether published factors scale the corrections.
    pub(crate) relaxed: bool,
    /// Longest substep \[s\].
    pub(crate) longest: f64,
    /// Shortest edge \[m\].
    pub(crate) shortest: f64,
    /// Rate at which velocities decay \[1/s\].
    pub(crate) damping: f64,
    /// Turns in which contact with partners is solved.
    pub(crate) turns: u32,
    /// Whether blocks are shared out to threads.
    pub(crate) parallel: bool,
}

/// All vertices and what holds them together.
#[derive(Clone, Debug)]
pub(crate) struct Sim {
    pub(crate) vertices: Vec<Vertex>,
    /// Body of each vertex.
    pub(crate) owner: Vec<u32>,
    /// Area that each vertex stands for \[m²\].
    pub(crate) area: Vec<f64>,
    /// Vertices in a block.
    pub(crate) size: usize,
    pub(crate) edges: Phases<Edge>,
    pub(crate) hinges: Phases<Hinge>,
    pub(crate) mesh: Mesh,
    pub(crate) pulls: Vec<Pull>,
    pub(crate) setting: Setting,
}

impl Sim {
    /// Largest speed of a vertex \[m/s\].
    pub(crate) fn fastest(&self) -> f64 {
        self.vertices.iter().map(|v| norm(v.u)).fold(0.0, f64::max)
    }

    /// Triangles of a body among those of all.
    pub(crate) fn triangles(&self, body: usize) -> Range<usize> {
        let owner = |t: &[u32; 3]| self.owner[t[0] as usize] as usize;
        let all = &self.mesh.triangles;
        all.partition_point(|t| owner(t) < body)..all.partition_point(|t| owner(t) <= body)
    }

    /// Covers a step.
    pub(crate) fn run(
        &mut self,
        course: &mut Course,
        pool: Option<&rayon::ThreadPool>,
        pulse: &mut dyn Pulse,
    ) -> Result<(), PluginError> {
        let partners = course.proxies.iter().map(|p| norm(p.twist()[0]));
        let samples = course.swarms.iter().filter_map(|swarm| swarm.fastest);
        let fastest = partners.chain(samples).fold(self.fastest(), f64::max);
        // Relaxed stiffness is in proportion to 1/h²: a substep that changes its length would do work.
        let by_speed = if self.setting.relaxed {
            f64::INFINITY
        } else {
            self.setting.shortest * COURANT / fastest.max(f64::MIN_POSITIVE)
        };
        let longest = self.setting.longest.min(by_speed);
        // A whole number of longest substeps must not become one more by rounding.
        let count = (course.length / longest - 1e-9).ceil().max(1.0);
        if !(1.0..MOST_SUBSTEPS).contains(&count) {
            return Err(PluginError::Physics(format!(
                "vertices or partners move at {fastest:.3e} m/s: a substep would be shorter than {:.1e} s",
                course.length / MOST_SUBSTEPS
            )));
        }
        let (count, h) = (count as u64, course.length / count);
        course.books.substeps = count;
        course.books.bound_by_speed = by_speed < self.setting.longest;
        course.books.kicks = vec![Tally::default(); course.kicks.len()];
        course.books.swarms = vec![Tally::default(); course.swarms.len()];
        let mut desks = vec![Desk::default(); self.edges.first.len()];
        for i in 0..count {
            let t = i as f64 * h;
            match pool.filter(|_| self.setting.parallel) {
                Some(pool) => pool.install(|| self.substep(course, &mut desks, t, h)),
                None => self.substep(course, &mut desks, t, h),
            }
            if pulse.beat(i + 1, count) == Signal::Abort {
                return Err(PluginError::Aborted);
            }
        }
        match pool.filter(|_| self.setting.parallel) {
            Some(pool) => pool.install(|| self.inspect(course, h)),
            None => self.inspect(course, h),
        }
        if self.vertices.iter().all(|v| v.x.iter().chain(&v.u).all(|c| c.is_finite())) {
            return Ok(());
        }
        Err(PluginError::Physics("a vertex is nowhere: use a shorter `max_substep_s` or softer contact".into()))
    }

    /// Notes how the step ends, after substeps of `h` \[s\].
    fn inspect(&self, course: &mut Course, h: f64) {
        let (setting, now) = (&self.setting, (&self.mesh, &self.vertices[..]));
        let last = Solve { h, per_h2: 1.0 / (h * h), first: false, relaxed: setting.relaxed };
        let of = |edge: &Edge, ends: [&Vertex; 2]| edge.left(ends, &last);
        course.books.left = self.edges.largest((now.1, self.size), setting.parallel, of);
        let cut = |swarm: &mut Swarm| swarm.cut(now, 0.5 * setting.thickness, course.length, setting.parallel);
        course.books.cut = course.swarms.iter_mut().map(cut).sum();
        course.books.beyond = course.swarms.iter().map(Swarm::beyond).sum();
    }

    fn substep(&mut self, course: &mut Course, desks: &mut [Desk], t: f64, h: f64) {
        let now = course.start + t;
        self.pull((now, now + h), &mut course.books.held);
        let setting = &self.setting;
        let push = Push::new(&setting.actions, setting.bodies, now, now + h);
        let damped = -libm::expm1(-setting.damping * h);
        let supplies = push.supplies();
        // An impulse at once is taken in the first substep.
        let share = |kick: &Kick| if kick.spread { h / course.length } else { f64::from(u8::from(t <= 0.0)) };
        let given = std::mem::take(&mut course.kicks);
        let kicks: Vec<(&[Vec3], f64)> = given.iter().map(|k| (&k.impulse[..], share(k))).collect();
        for desk in desks.iter_mut() {
            *desk = Desk { kicks: vec![Tally::default(); kicks.len()], ..std::mem::take(desk) };
            (desk.driven, desk.held, desk.count, desk.supplied) = (Tally::default(), Tally::default(), 0, 0.0);
        }
        let start: Vec<Vec3> = self.vertices.iter().map(|v| v.u).collect();
        for i in 0..setting.iterations[0].max(setting.iterations[1]) {
            let prepare = |b: usize, vertices: &mut [Vertex], desk: &mut Desk| {
                let from = b * self.size;
                desk.pushes.clear();
                desk.supplies.clear();
                for (k, vertex) in vertices.iter_mut().enumerate() {
                    let mut driven = pushed(vertex, self.owner[from + k] as usize, (&push, damped), desk);
                    if push.has_wind() {
                        let patch = (course.normals[from + k], self.area[from + k]);
                        let impulse = wind(&push, self.owner[from + k] as usize, (vertex.u, vertex.mass), patch);
                        kick(vertex, impulse, &mut desk.driven, &mut desk.held);
                        driven = add(driven, impulse);
                    }
                    desk.pushes.push(driven);
                    if supplies {
                        let weight = push.weight(self.owner[from + k] as usize);
                        desk.supplies.push(beyond_weight(vertex, driven, weight));
                    }
                    for (&(impulses, share), tally) in kicks.iter().zip(&mut desk.kicks) {
                        kick(vertex, scale(impulses[from + k], share), tally, &mut desk.held);
                    }
                }
            };
            let sweep = Sweep {
                vertices: &mut self.vertices,
                size: self.size,
                edges: &mut self.edges,
                hinges: &mut self.hinges,
                turn: setting.iterations.map(|n| i < n),
                solver: Solve { h, per_h2: 1.0 / (h * h), first: i == 0, relaxed: setting.relaxed },
                parallel: setting.parallel,
            };
            let before = |b: usize, vertices: &mut [Vertex], desk: &mut Desk| {
                if i == 0 {
                    prepare(b, vertices, desk);
                }
            };
            sweep.run(desks, before, &mut course.books.held);
        }
        self.touch_and_move(course, desks, start, &kicks, (t, h));
        course.kicks = given;
        for desk in desks.iter() {
            course.books.take(desk);
        }
    }
}

/// Influences on one vertex; the impulse of those that are not damping \[N s\].
#[inline]
fn pushed(vertex: &mut Vertex, body: usize, (push, damped): (&Push, f64), desk: &mut Desk) -> Vec3 {
    let mut impulse = [0.0; 3];
    if vertex.w > 0.0 {
        // Before the rest: what is at rest under its weight has nothing to lose.
        if damped > 0.0 {
            desk.held.give(vertex, scale(vertex.u, -damped * vertex.mass));
        }
        impulse = scale(push.at(body, vertex.x), vertex.mass);
        desk.driven.give(vertex, impulse);
    }
    impulse
}

/// What of an impulse \[N s\] on a vertex is not gravity's, which changes velocities by `weight` \[m/s\].
fn beyond_weight(vertex: &Vertex, impulse: Vec3, weight: Vec3) -> Vec3 {
    if vertex.w > 0.0 { sub(impulse, scale(weight, vertex.mass)) } else { impulse }
}

/// An impulse on a vertex; one that is fixed hands it on to the world.
fn kick(vertex: &mut Vertex, impulse: Vec3, tally: &mut Tally, held: &mut Tally) {
    tally.give(vertex, impulse);
    if vertex.w <= 0.0 {
        held.hold(vertex, impulse);
    }
}
