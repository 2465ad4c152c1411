//! One step in progress, and its books.

use std::ops::Range;

use cosplat_core::boundary::{Vec3, add, dot, scale};

use crate::bond::Bond;
use crate::contact::{Surface, Touch};
use crate::near::Near;
use crate::proxy::Proxy;
use crate::samples::Swarm;
use crate::tally::Tally;
use crate::vertex::Vertex;

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
pub(crate) struct Meeting {
    pub(crate) surface: Surface,
    /// Its triangles.
    pub(crate) triangles: Range<usize>,
}

/// One step in progress.
pub(crate) struct Course<'a> {
    /// Start and length \[s\].
    pub(crate) start: f64,
    pub(crate) length: f64,
    pub(crate) proxies: Vec<Proxy>,
    pub(crate) swarms: Vec<Swarm<'a>>,
    /// In the order of the swarms.
    pub(crate) meetings: Vec<Meeting>,
    pub(crate) kicks: Vec<Kick>,
    pub(crate) bonds: Vec<Bond>,
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
    /// Work of the actions without a potential energy \[J\].
    pub(crate) supplied: f64,
    /// Walls, pins and damping; work of pins that move.
    pub(crate) held: Tally,
    /// Effect of each swarm on its own body.
    pub(crate) swarms: Vec<Tally>,
    /// Effect of each kick.
    pub(crate) kicks: Vec<Tally>,
    /// Contacts solved, summed over the substeps.
    pub(crate) touches: u64,
    /// Substeps in which pieces of cloth moved more than a thickness relative to each other between two looks.
    pub(crate) too_fast: u64,
    /// Samples that are beyond cloth at the end, and neighbours among them with cloth between.
    pub(crate) beyond: u64,
    pub(crate) cut: u64,
    /// Largest part of its length by which a thread is off after the last substep, beyond what its compliance gives way.
    pub(crate) left: f64,
}

impl Books {
    /// Adds what happened in one block.
    pub(crate) fn take(&mut self, desk: &Desk) {
        self.driven.add(&desk.driven);
        self.supplied += desk.supplied;
        self.held.add(&desk.held);
        self.touches += desk.count;
        for (sum, one) in self.kicks.iter_mut().zip(&desk.kicks) {
            sum.add(one);
        }
    }
}

/// Books of one block in one substep.
#[derive(Clone, Debug, Default)]
pub(crate) struct Desk {
    pub(crate) driven: Tally,
    /// Impulse of gravity and other actions on each vertex \[N s\].
    pub(crate) pushes: Vec<Vec3>,
    /// Of it what has no potential energy, where there is any.
    pub(crate) supplies: Vec<Vec3>,
    /// Work of that \[J\].
    pub(crate) supplied: f64,
    pub(crate) held: Tally,
    pub(crate) kicks: Vec<Tally>,
    /// Of one vertex.
    pub(crate) alone: Vec<Touch>,
    /// That partners have a part in.
    pub(crate) touches: Vec<Touch>,
    /// Contacts with walls alone.
    pub(crate) count: u64,
}

impl Desk {
    /// Books the work of actions and of kicks, on each vertex and the share of it, on vertices that had the velocities
    /// `start` \[m/s\].
    pub(crate) fn earn<'a>(
        &mut self,
        vertices: &[Vertex],
        start: &[Vec3],
        kicks: impl Iterator<Item = (&'a [Vec3], f64)>,
    ) {
        for ((vertex, &start), &impulse) in vertices.iter().zip(start).zip(&self.pushes) {
            self.driven.earn(impulse, [start, vertex.u]);
        }
        for ((vertex, &start), &impulse) in vertices.iter().zip(start).zip(&self.supplies) {
            self.supplied += 0.5 * dot(impulse, add(start, vertex.u));
        }
        for ((impulses, share), tally) in kicks.zip(&mut self.kicks) {
            for ((vertex, &start), &impulse) in vertices.iter().zip(start).zip(impulses) {
                tally.earn(scale(impulse, share), [start, vertex.u]);
            }
        }
    }
}
