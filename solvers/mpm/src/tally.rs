//! Impulse, angular impulse and work of one cause, summed in f64 from the changes of the grid's momentum.

use cosplat_core::boundary::{Wrench, add, cross, dot, norm, scale, sub};

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
    /// A mass at `x` whose velocity went from `before` to `after`.
    pub(crate) fn change(&mut self, mass: f64, x: [f64; 3], before: [f64; 3], after: [f64; 3]) {
        let j = scale(sub(after, before), mass);
        self.wrench.linear = add(self.wrench.linear, j);
        self.wrench.angular = add(self.wrench.angular, cross(x, j));
        self.work += 0.5 * dot(j, add(before, after));
        self.gross += norm(j);
    }

    /// Adds another.
    pub(crate) fn add(&mut self, other: &Self) {
        self.wrench = self.wrench.plus(other.wrench);
        self.work += other.work;
        self.gross += other.gross;
    }
}
