//! What a cause does to a body: impulse, moment and work, summed as the contract wants them reported.

use crate::boundary::{Vec3, Wrench, add, cross, dot, norm};
use crate::plan::InterfaceId;

use super::exchange::InterfaceReport;

/// What crossed through one cause (a partner, or the outside) in a step.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Budget {
    /// Impulse, angular part about the world origin.
    pub wrench: Wrench,
    /// Work done on the body \[J\].
    pub work_j: f64,
}

impl Budget {
    /// An impulse at `x` \[m\] whose point has those velocities before and after.
    ///
    /// Work is the impulse times their mean, which is exact for a sudden impulse on a point mass.
    pub fn of_impulse(impulse: Vec3, x: Vec3, before: Vec3, after: Vec3) -> Self {
        Self {
            wrench: Wrench { linear: impulse, angular: cross(x, impulse) },
            work_j: 0.5 * dot(impulse, add(before, after)),
        }
    }

    /// Gives a point of that mass \[kg\] at `x` \[m\] a sudden impulse \[N s\]: changes its velocity `v`.
    ///
    /// A constant force over a stretch of free flight is half its impulse before the flight and half after, in the
    /// opposite order where several act: path, moment and each one's work are then exact.
    pub fn kick(impulse: Vec3, mass: f64, x: Vec3, v: &mut Vec3) -> Self {
        let before = *v;
        *v = add(before, impulse.map(|j| j / mass));
        Self::of_impulse(impulse, x, before, *v)
    }

    /// Adds another.
    pub fn add(&mut self, other: Self) {
        self.wrench = self.wrench.plus(other.wrench);
        self.work_j += other.work_j;
    }

    /// As the report of an interface; `gross` is the size of the sum, for a body that takes one impulse.
    pub fn report(&self, interface: InterfaceId) -> InterfaceReport {
        InterfaceReport {
            interface,
            received: self.wrench,
            gross: norm(self.wrench.linear),
            work_j: self.work_j,
            residual: 0.0,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::boundary::{scale, sub};

    #[test]
    fn the_work_of_a_kick_is_what_the_kinetic_energy_gains() {
        let (mass, x, start) = (2.5, [1.0, 2.0, -3.0], [0.3, -1.0, 4.0]);
        let mut v = start;
        let impulse = [1.0, 0.5, -2.0];
        let mut sum = Budget::default();
        for _ in 0..2 {
            sum.add(Budget::kick(impulse, mass, x, &mut v));
        }
        let kinetic = |v: Vec3| 0.5 * mass * dot(v, v);
        // Roundings of numbers of order ten.
        assert!((sum.work_j - (kinetic(v) - kinetic(start))).abs() < 1e-13);
        assert!(norm(sub(scale(sub(v, start), mass), sum.wrench.linear)) < 1e-13);
        assert!(norm(sub(sum.wrench.angular, scale(cross(x, impulse), 2.0))) < 1e-13);
        assert_eq!((sum.report(7).interface, sum.report(7).gross.to_bits()), (7, norm(scale(impulse, 2.0)).to_bits()));
    }

    #[test]
    fn half_before_and_half_after_is_a_constant_force() {
        let (mass, length) = (0.5, 0.25);
        let (x0, v0): (Vec3, Vec3) = ([1.0, -2.0, 0.5], [3.0, 0.0, -1.0]);
        let impulses = [[0.25, 0.5, 0.0], [-1.0, 0.25, 2.0]];
        let total = add(impulses[0], impulses[1]);
        let (mut x, mut v, mut sums) = (x0, v0, [Budget::default(); 2]);
        for i in [0, 1] {
            sums[i].add(Budget::kick(scale(impulses[i], 0.5), mass, x, &mut v));
        }
        x = add(x, scale(v, length));
        for i in [1, 0] {
            sums[i].add(Budget::kick(scale(impulses[i], 0.5), mass, x, &mut v));
        }
        let mean = add(v0, scale(total, 0.5 / mass));
        // Roundings of numbers of order one.
        assert!(norm(sub(x, add(x0, scale(mean, length)))) < 1e-14);
        assert!(norm(sub(v, add(v0, scale(total, 1.0 / mass)))) < 1e-14);
        for (sum, impulse) in sums.iter().zip(impulses) {
            assert!((sum.work_j - dot(impulse, mean)).abs() < 1e-14, "{sum:?}");
        }
        let turned = sub(cross(x, scale(v, mass)), cross(x0, scale(v0, mass)));
        assert!(norm(sub(turned, add(sums[0].wrench.angular, sums[1].wrench.angular))) < 1e-14);
    }
}
