//! Pins that move: vertices with a prescribed velocity.

use cosplat_core::boundary::{Vec3, dot, scale, sub};

use crate::sim::Sim;
use crate::tally::Tally;

/// A vertex that is moved.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Pull {
    pub(crate) vertex: u32,
    /// While it moves \[m/s\].
    pub(crate) velocity: Vec3,
    /// Time at which it stops \[s\].
    pub(crate) until: f64,
}

impl Sim {
    /// Gives pins their velocities over a substep from `start` to `end` \[s\]; `held` is the world, which moves them. A
    /// pin that stops in between goes as far as it would.
    pub(crate) fn pull(&mut self, (start, end): (f64, f64), held: &mut Tally) {
        for pull in &self.pulls {
            let vertex = &mut self.vertices[pull.vertex as usize];
            let share = ((pull.until - start) / (end - start)).clamp(0.0, 1.0);
            let velocity = scale(pull.velocity, share);
            let impulse = scale(sub(velocity, vertex.u), vertex.mass);
            held.book(vertex.x, impulse);
            held.work += 0.5 * vertex.mass * (dot(velocity, velocity) - dot(vertex.u, vertex.u));
            vertex.u = velocity;
        }
    }
}
