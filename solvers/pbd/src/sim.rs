//! One substep, and the steps made of them.

use cosplat_core::boundary::{Vec3, add, norm, scale};
use cosplat_core::plugin::{PluginError, Pulse, Signal};
use rayon::prelude::*;

use crate::bend::Hinge;
use crate::contact::{Others, Surface, Touch, earn, settle};
use crate::near::{Near, Speeds, radius};
use crate::own::Mesh;
use crate::pair::Pair;
use crate::place::Place;
use crate::proxy::Proxy;
use crate::push::{Action, Push};
use crate::samples::Swarm;
use crate::scout::Scout;
use crate::stretch::Edge;
use crate::tally::Tally;
use crate::vertex::{Constraint, Phases, Solve, Vertex, solve};
use cosplat_core::distance::{Placed, Shape};

/// Part of the shortest edge that a vertex may move in a substep.
pub(crate) const COURANT: f64 = 0.3;
/// Most parts of a substep in which contact is looked at.
const MOST_PARTS: f64 = 16.0;
/// Substeps of a step beyond which a cloth is not fast but blowing up.
const MOST_SUBSTEPS: f64 = 1e6;

/// A static collider and its surface for each body; `None` where the pair is left out.
#[derive(Clone, Debug)]
pub(crate) struct Wall {
    pub(crate) shape: Placed,
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
    pub(crate) actions: Vec<Action>,
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

/// Impulses of a partner on the vertices of a body.
#[derive(Clone, Debug)]
pub(crate) struct Kick {
    /// Interface, by its index.
    pub(crate) face: usize,
    /// On each vertex of all bodies \[N s\].
    pub(crate) impulse: Vec<Vec3>,
    /// Over the whole step, or at once at its start.
    pub(crate) spread: bool,
}

/// Own side of a contact with a partner that shows samples.
#[derive(Clone, Debug)]
pub(crate) struct Meeting<'a> {
    /// Own body.
    pub(crate) body: usize,
    pub(crate) surface: Surface,
    /// Points of its triangles that are as close together as the samples.
    pub(crate) lattice: &'a [Place],
}

/// One step in progress.
pub(crate) struct Course<'a> {
    /// Start and length \[s\].
    pub(crate) start: f64,
    pub(crate) length: f64,
    pub(crate) proxies: Vec<Proxy>,
    pub(crate) swarms: Vec<Swarm<'a>>,
    /// In the order of the swarms.
    pub(crate) meetings: Vec<Meeting<'a>>,
    pub(crate) kicks: Vec<Kick>,
    /// Normals at the start of the step, where air moves.
    pub(crate) normals: Vec<Vec3>,
    pub(crate) near: Near,
    pub(crate) books: Books,
}

/// What has acted in a step.
#[derive(Clone, Debug, Default)]
pub(crate) struct Books {
    pub(crate) substeps: u64,
    pub(crate) bound_by_speed: bool,
    /// Gravity and other actions.
    pub(crate) driven: Tally,
    /// Walls, pins and damping, which take energy.
    pub(crate) held: Tally,
    /// Effect of each swarm on its own body.
    pub(crate) swarms: Vec<Tally>,
    /// Effect of each kick.
    pub(crate) kicks: Vec<Tally>,
    /// Contacts solved, summed over the substeps.
    pub(crate) touches: u64,
    /// Substeps in which pieces of cloth moved more than a thickness relative to each other between two looks.
    pub(crate) too_fast: u64,
}

/// Books of one block in one substep.
#[derive(Clone, Debug, Default)]
pub(crate) struct Desk {
    driven: Tally,
    /// Impulse of gravity and other actions on each vertex \[N s\].
    pushes: Vec<Vec3>,
    pub(crate) held: Tally,
    kicks: Vec<Tally>,
    /// Of one vertex.
    pub(crate) alone: Vec<Touch>,
    /// That partners have a part in.
    pub(crate) touches: Vec<Touch>,
    /// Contacts with walls alone.
    pub(crate) count: u64,
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
    pub(crate) setting: Setting,
}

/// Does something with each item, on one thread or several.
fn each<T: Send>(parallel: bool, items: Vec<T>, f: impl Fn(usize, T) + Sync + Send) {
    if parallel {
        items.into_par_iter().enumerate().for_each(|(i, item)| f(i, item));
    } else {
        items.into_iter().enumerate().for_each(|(i, item)| f(i, item));
    }
}

impl Sim {
    /// Largest speed of a vertex \[m/s\].
    pub(crate) fn fastest(&self) -> f64 {
        self.vertices.iter().map(|v| norm(v.u)).fold(0.0, f64::max)
    }

    /// Covers a step.
    pub(crate) fn run(
        &mut self,
        course: &mut Course,
        pool: Option<&rayon::ThreadPool>,
        pulse: &mut dyn Pulse,
    ) -> Result<(), PluginError> {
        let partners = course.proxies.iter().map(|p| norm(p.twist()[0]));
        let fastest = partners.fold(self.fastest(), f64::max);
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
        if self.vertices.iter().all(|v| v.x.iter().chain(&v.u).all(|c| c.is_finite())) {
            return Ok(());
        }
        Err(PluginError::Physics("a vertex is nowhere: use a shorter `max_substep_s` or softer contact".into()))
    }

    fn substep(&mut self, course: &mut Course, desks: &mut [Desk], t: f64, h: f64) {
        let setting = &self.setting;
        let now = course.start + t;
        let push = Push::new(&setting.actions, setting.bodies, (now, now + h), setting.damping);
        // An impulse at once is taken in the first substep.
        let share = |kick: &Kick| if kick.spread { h / course.length } else { f64::from(u8::from(t <= 0.0)) };
        let given = std::mem::take(&mut course.kicks);
        let kicks: Vec<(&[Vec3], f64)> = given.iter().map(|k| (&k.impulse[..], share(k))).collect();
        for desk in desks.iter_mut() {
            *desk = Desk { kicks: vec![Tally::default(); kicks.len()], ..std::mem::take(desk) };
            (desk.driven, desk.held, desk.count) = (Tally::default(), Tally::default(), 0);
        }
        let start: Vec<Vec3> = self.vertices.iter().map(|v| v.u).collect();
        for i in 0..setting.iterations[0].max(setting.iterations[1]) {
            let solver = Solve { h, per_h2: 1.0 / (h * h), first: i == 0, relaxed: setting.relaxed };
            let prepare = |b: usize, vertices: &mut [Vertex], desk: &mut Desk| {
                let from = b * self.size;
                desk.pushes.clear();
                for (k, vertex) in vertices.iter_mut().enumerate() {
                    let mut driven = pushed(vertex, self.owner[from + k] as usize, &push, desk);
                    if push.has_wind() {
                        let patch = (course.normals[from + k], self.area[from + k]);
                        let impulse = push.wind(self.owner[from + k] as usize, (vertex.u, vertex.mass), patch);
                        kick(vertex, impulse, &mut desk.driven, &mut desk.held);
                        driven = add(driven, impulse);
                    }
                    desk.pushes.push(driven);
                    for (&(impulses, share), tally) in kicks.iter().zip(&mut desk.kicks) {
                        kick(vertex, scale(impulses[from + k], share), tally, &mut desk.held);
                    }
                }
            };
            let turn = [0, 1].map(|k| i < setting.iterations[k]);
            let blocks = self.vertices.chunks_mut(self.size);
            let work: Vec<_> = blocks
                .zip(&mut self.edges.first)
                .zip(&mut self.hinges.first)
                .zip(desks.iter_mut())
                .map(|(((v, e), h), d)| (v, e, h, d))
                .collect();
            each(setting.parallel, work, |b, (vertices, edges, hinges, desk)| {
                if i == 0 {
                    prepare(b, vertices, desk);
                }
                project(vertices, edges, hinges, turn, &solver);
            });
            let shifted = self.vertices.get_mut(self.size / 2..).unwrap_or_default().chunks_mut(self.size);
            let work: Vec<_> = shifted
                .zip(&mut self.edges.shifted)
                .zip(&mut self.hinges.shifted)
                .filter(|((_, e), h)| !(e.is_empty() && h.is_empty()))
                .collect();
            each(setting.parallel, work, |_, ((vertices, edges), hinges)| {
                project(vertices, edges, hinges, turn, &solver);
            });
            project(&mut self.vertices, &mut self.edges.rest, &mut self.hinges.rest, turn, &solver);
            let held = &mut course.books.held;
            if turn[0] {
                self.edges.anchored.iter_mut().for_each(|c| anchor(c, &mut self.vertices, &solver, held));
            }
            if turn[1] {
                self.hinges.anchored.iter_mut().for_each(|c| anchor(c, &mut self.vertices, &solver, held));
            }
        }
        self.touch_and_move(course, desks, start, &kicks, (t, h));
        course.kicks = given;
        let books = &mut course.books;
        for desk in desks.iter() {
            books.driven.add(&desk.driven);
            books.held.add(&desk.held);
            books.touches += desk.count;
            for (sum, one) in books.kicks.iter_mut().zip(&desk.kicks) {
                sum.add(one);
            }
        }
    }

    /// Contact and motion of a substep, and the work of what partners and actions gave in it, where the velocities at its
    /// start were `start` \[m/s\].
    fn touch_and_move(
        &mut self,
        course: &mut Course,
        desks: &mut [Desk],
        mut start: Vec<Vec3>,
        kicks: &[(&[Vec3], f64)],
        (t, h): (f64, f64),
    ) {
        let parts = self.parts(course, h);
        for i in 0..parts {
            let part = h / f64::from(parts);
            self.meet(course, desks, &start, (t + f64::from(i) * part, part));
            if i == 0 {
                let blocks = self.vertices.chunks(self.size).zip(start.chunks(self.size));
                let work: Vec<_> = blocks.zip(desks.iter_mut()).collect();
                each(self.setting.parallel, work, |b, ((vertices, start), desk)| {
                    let own = kicks.iter().map(|&(impulses, share)| (&impulses[b * self.size..], share));
                    desk.earn(vertices, start, own);
                });
            }
            self.drift(course, part);
            start.iter_mut().zip(&self.vertices).for_each(|(start, v)| *start = v.u);
        }
    }

    /// Parts of a substep in which contact is looked at: cloth moves less than its thickness relative to other cloth in
    /// each, and less than half of both thicknesses relative to samples, so that nothing passes unseen. Shorter substeps
    /// instead would make what a sweep leaves stiffer, and give it energy.
    fn parts(&self, course: &mut Course, h: f64) -> u32 {
        let thickness = self.setting.thickness;
        let mut wanted: f64 = 1.0;
        if !self.mesh.friction.is_empty() {
            wanted = h * self.speeds(course).own / thickness;
        }
        for swarm in course.swarms.iter().filter(|s| !s.points().is_empty()) {
            wanted = wanted.max(h * (self.fastest() + swarm.fastest) / swarm.thinnest(0.5 * thickness));
        }
        let wanted = wanted.ceil();
        course.books.too_fast += u64::from(wanted > MOST_PARTS);
        wanted.clamp(1.0, MOST_PARTS) as u32
    }

    /// Moves everything for `h` \[s\].
    fn drift(&mut self, course: &mut Course, h: f64) {
        let speeds = self.speeds(course);
        course.near.age(&self.vertices, speeds, h);
        for vertex in &mut self.vertices {
            vertex.x = add(vertex.x, scale(vertex.u, h));
        }
        course.proxies.iter_mut().for_each(|p| p.drift(h));
        course.swarms.iter_mut().for_each(|s| s.drift(h));
    }

    /// Contact of one substep, or of a part of it, at whose start the velocities were `start` \[m/s\].
    fn meet(&mut self, course: &mut Course, desks: &mut [Desk], start: &[Vec3], (t, h): (f64, f64)) {
        let setting = &self.setting;
        course.proxies.iter_mut().for_each(|p| p.push(h));
        for (swarm, meeting) in course.swarms.iter_mut().zip(&course.meetings) {
            swarm.at(t);
            let vertices = &self.vertices;
            let position = |place: usize| match place.checked_sub(vertices.len()) {
                Some(k) => meeting.lattice[k].position(vertices),
                None => vertices[place].x,
            };
            swarm.look(position, 0.5 * setting.thickness, setting.parallel);
        }
        let alone = setting.walls.is_empty() && course.proxies.is_empty() && course.swarms.is_empty();
        if alone && self.mesh.friction.is_empty() {
            return;
        }
        let placed: Vec<Placed> =
            course.proxies.iter().zip(&setting.partners).map(|(p, partner)| p.placed(&partner.shape)).collect();
        let speeds = self.speeds(course);
        let mut near = std::mem::take(&mut course.near);
        near.renew(self, &placed, speeds, h);
        let mut pairs = self.pairs(&near, h);
        let scout = Scout { setting, course: &*course, placed: &placed, owner: &self.owner, h };
        let mut between = Vec::new();
        scout.spots(near.spots(), &self.vertices, &mut between);
        let mut busy = vec![false; self.vertices.len()];
        between.iter().flat_map(|t| t.place.parts()).for_each(|(i, _)| busy[i] = true);
        pairs.iter().flat_map(|p| p.ends).for_each(|i| busy[i as usize] = true);
        let work: Vec<_> = self.vertices.chunks_mut(self.size).zip(desks.iter_mut()).collect();
        each(setting.parallel, work, |b, (vertices, desk)| scout.block(b * self.size, vertices, desk, &busy));
        // Vertices last: what they touch then holds exactly, whatever is left of the turns before.
        let mut touches = between;
        touches.extend(desks.iter().flat_map(|d| d.touches.iter().copied()));
        course.near = near;
        course.books.touches += (touches.len() + pairs.len()) as u64;
        let mut others = Others {
            proxies: &mut course.proxies,
            swarms: &mut course.swarms,
            on_own: &mut course.books.swarms,
            external: &mut course.books.held,
        };
        for _ in 0..setting.turns {
            for pair in &mut pairs {
                pair.solve(&mut self.vertices, h, others.external);
            }
            settle(&mut self.vertices, &self.owner, &mut touches, &mut others, h);
        }
        earn(&self.vertices, start, &self.owner, &touches, &mut others);
    }

    /// Pieces of cloth that touch.
    fn pairs(&self, near: &Near, h: f64) -> Vec<Pair> {
        let (vertices, thickness) = (&self.vertices, self.setting.thickness);
        if self.setting.parallel {
            near.candidates().par_iter().filter_map(|c| c.touch(vertices, thickness, h)).collect()
        } else {
            near.candidates().iter().filter_map(|c| c.touch(vertices, thickness, h)).collect()
        }
    }

    /// How fast things move.
    fn speeds(&self, course: &Course) -> Speeds {
        Speeds::new(&self.vertices, &course.proxies, self.setting.partners.iter().map(|p| radius(&p.shape)))
    }
}

impl Desk {
    /// Books the work of actions and of kicks, on each vertex and the share of it, on vertices that had the velocities
    /// `start` \[m/s\].
    fn earn<'a>(&mut self, vertices: &[Vertex], start: &[Vec3], kicks: impl Iterator<Item = (&'a [Vec3], f64)>) {
        for ((vertex, &start), &impulse) in vertices.iter().zip(start).zip(&self.pushes) {
            self.driven.earn(impulse, [start, vertex.u]);
        }
        for ((impulses, share), tally) in kicks.zip(&mut self.kicks) {
            for ((vertex, &start), &impulse) in vertices.iter().zip(start).zip(impulses) {
                tally.earn(scale(impulse, share), [start, vertex.u]);
            }
        }
    }
}

/// Influences on one vertex; the impulse of those that are not damping \[N s\].
#[inline]
fn pushed(vertex: &mut Vertex, body: usize, push: &Push, desk: &mut Desk) -> Vec3 {
    let mut impulse = [0.0; 3];
    if vertex.w > 0.0 {
        // Before the rest: what is at rest under its weight has nothing to lose.
        if push.damped > 0.0 {
            desk.held.give(vertex, scale(vertex.u, -push.damped * vertex.mass));
        }
        impulse = scale(push.at(body, vertex.x), vertex.mass);
        desk.driven.give(vertex, impulse);
    }
    impulse
}

/// An impulse on a vertex; one that is fixed hands it on to the world.
fn kick(vertex: &mut Vertex, impulse: Vec3, tally: &mut Tally, held: &mut Tally) {
    tally.give(vertex, impulse);
    if vertex.w <= 0.0 {
        held.book(vertex.x, scale(impulse, -1.0));
    }
}

/// Solves the constraints of a block.
pub(crate) fn project(
    vertices: &mut [Vertex],
    edges: &mut [Edge],
    hinges: &mut [Hinge],
    turn: [bool; 2],
    solver: &Solve,
) {
    if turn[0] {
        for edge in edges {
            solve(edge, vertices, solver);
        }
    }
    if turn[1] {
        for hinge in hinges {
            solve(hinge, vertices, solver);
        }
    }
}

/// Solves a constraint with an end that is fixed to the world, which takes that end's impulse.
pub(crate) fn anchor<const N: usize, C: Constraint<N>>(
    constraint: &mut C,
    vertices: &mut [Vertex],
    solver: &Solve,
    held: &mut Tally,
) {
    let ends = constraint.ends().map(|i| i as usize);
    if let Some(impulses) = constraint.impulses(ends.map(|i| &vertices[i]), solver) {
        for (i, impulse) in ends.into_iter().zip(impulses) {
            if vertices[i].w > 0.0 {
                vertices[i].take(impulse);
            } else {
                held.book(vertices[i].x, scale(impulse, -1.0));
            }
        }
    }
}
