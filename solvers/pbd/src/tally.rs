//! Impulse, angular impulse and work of one cause, summed from the impulses themselves.
//!
//! Work is counted at the mean of the velocities at the start and the end of a substep, for all causes alike: the sum of
//! their works is then the change of the kinetic energy, whatever the order in which they act. Counted at the velocity
//! in between, what one cause gives in a substep and the next takes back would be work of both.

use cosplat_core::boundary::{Vec3, Wrench, add, cross, dot, norm, scale};
use cosplat_core::plan::InterfaceId;
use cosplat_core::plugin::InterfaceReport;

use crate::vertex::Vertex;

/// What one cause has done.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Tally {
    /// Impulse and angular impulse about the world origin.
    pub(crate) wrench: Wrench,
    /// Work \[J\].
    pub(crate) work: f64,
    /// Σ|j| \[N s\].
    pub(crate) gross: f64,
}

impl Tally {
    /// Gives a vertex an impulse \[N s\] where it is at the start of the substep: `x + h u` then has the moment
    /// `x × m u`, so that the sums close to rounding. A vertex that is fixed hands it on to the world.
    #[inline]
    pub(crate) fn give(&mut self, vertex: &mut Vertex, impulse: Vec3) {
        vertex.take(impulse);
        self.book(vertex.x, impulse);
    }

    /// Books an impulse at `x` \[m\].
    #[inline]
    pub(crate) fn book(&mut self, x: Vec3, impulse: Vec3) {
        self.wrench.linear = add(self.wrench.linear, impulse);
        self.wrench.angular = add(self.wrench.angular, cross(x, impulse));
        self.gross += norm(impulse);
    }

    /// Books what the world gives to hold a vertex that is fixed to it against an impulse, and its work where it moves.
    #[inline]
    pub(crate) fn hold(&mut self, vertex: &Vertex, impulse: Vec3) {
        self.book(vertex.x, scale(impulse, -1.0));
        self.work -= dot(impulse, vertex.u);
    }

    /// Books the work of an impulse on a vertex with these velocities at the start and the end \[m/s\].
    #[inline]
    pub(crate) fn earn(&mut self, impulse: Vec3, [start, end]: [Vec3; 2]) {
        self.work += 0.5 * dot(impulse, add(start, end));
    }

    /// Adds another.
    pub(crate) fn add(&mut self, other: &Self) {
        self.wrench = self.wrench.plus(other.wrench);
        self.work += other.work;
        self.gross += other.gross;
    }

    /// As the report of an interface.
    pub(crate) fn report(&self, interface: InterfaceId, residual: f64) -> InterfaceReport {
        InterfaceReport { interface, received: self.wrench, gross: self.gross, work_j: self.work, residual }
    }
}
