//! Flight of one body under constant forces: exact parabola, and rotation in substeps with kicks of torque between.

use cosplat_core::boundary::Wrench;
use cosplat_core::plugin::{Budget, Moving, Signal};
use cosplat_core::rotation::{ANGLE, angular_velocity, free};

use crate::V3;
use crate::model::Body;

/// A constant force and how it turns the body.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Push {
    /// \[N\].
    pub(crate) force: V3,
    pub(crate) lever: Lever,
}

/// Where a force acts.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Lever {
    /// At the centre of mass.
    Centre,
    /// At a point of the body, principal frame \[m\].
    Hook(V3),
    /// At a fixed point of the world, with a torque about it: what a contact gave back about the centre of mass at the
    /// start of the window. While the body moves, `(point - x) × F` turns it, so that the angular momentum about any
    /// fixed point changes by exactly what was given.
    Fixed {
        /// \[m\].
        point: V3,
        /// \[N m\].
        torque: V3,
    },
}

/// Impulse \[N s\], angular impulse about the world origin \[N m s\] and work \[J\].
pub(crate) fn budget(linear: V3, angular: V3, work_j: f64) -> Budget {
    Budget { wrench: Wrench { linear: linear.into(), angular: angular.into() }, work_j }
}

/// Sudden impulse through a point of the world with an angular impulse about it.
///
/// Work is impulse times the mean of the velocities before and after, exact for a quadratic energy.
pub(crate) fn kick(body: &Body, moving: &mut Moving, impulse: V3, point: V3, angular: V3) -> Budget {
    let turning = angular + (point - moving.position).cross(&impulse);
    let before = (moving.velocity, angular_velocity(&moving.turn, moving.spin, body.inverse));
    moving.velocity += impulse / body.mass;
    moving.spin += turning;
    let after = (moving.velocity, angular_velocity(&moving.turn, moving.spin, body.inverse));
    let work = 0.5 * (impulse.dot(&(before.0 + after.0)) + turning.dot(&(before.1 + after.1)));
    budget(impulse, point.cross(&impulse) + angular, work)
}

/// Bound on the rate of rotation over `length` \[s\]: what it is, and what the torques could add \[rad/s\].
pub(crate) fn fastest(body: &Body, moving: &Moving, pushes: &[Push], length: f64) -> f64 {
    let total: V3 = pushes.iter().map(|p| p.force).sum();
    let way = moving.velocity.norm() * length + 0.5 * total.norm() / body.mass * length * length;
    let torque = pushes.iter().map(|p| match p.lever {
        Lever::Centre => 0.0,
        Lever::Hook(arm) => arm.norm() * p.force.norm(),
        Lever::Fixed { point, torque } => torque.norm() + ((point - moving.position).norm() + way) * p.force.norm(),
    });
    let omega = angular_velocity(&moving.turn, moving.spin, body.inverse).norm();
    omega + torque.sum::<f64>() * length * body.inverse.max()
}

/// Substeps over `length` \[s\] at that rate \[rad/s\].
pub(crate) fn substeps(rate: f64, length: f64) -> f64 {
    (rate * length / ANGLE).ceil().max(1.0)
}

/// Flies for `length` \[s\]; answers one budget per push, or nothing if it was told to stop.
///
/// Translation is exact: `x = x0 + v0 t + a t²/2`, `∫x dt × F` for the angular impulse. Rotation is a Strang splitting:
/// half the torque impulse of a substep, free rotation, the other half.
pub(crate) fn fly(
    body: &Body,
    moving: &mut Moving,
    pushes: &[Push],
    length: f64,
    substeps: u64,
    beat: &mut dyn FnMut() -> Signal,
) -> Option<Vec<Budget>> {
    let (x0, v0) = (moving.position, moving.velocity);
    let a = pushes.iter().map(|p| p.force).sum::<V3>() / body.mass;
    let at = |t: f64| x0 + v0 * t + a * (0.5 * t * t);
    // ∫ x dt over a stretch of length s that starts at t.
    let path = |t: f64, s: f64| at(t) * s + (v0 + a * t) * (0.5 * s * s) + a * (s * s * s / 6.0);
    let mut budgets: Vec<Budget> = pushes
        .iter()
        .map(|p| budget(p.force * length, path(0.0, length).cross(&p.force), p.force.dot(&(at(length) - x0))))
        .collect();
    let h = length / substeps as f64;
    for i in 0..substeps {
        let travelled = path(i as f64 * h, h);
        twist(body, moving, pushes, &mut budgets, h, travelled);
        moving.turn = free(&moving.turn, moving.spin, body.inverse, h);
        twist(body, moving, pushes, &mut budgets, h, travelled);
        if beat() == Signal::Abort {
            return None;
        }
    }
    moving.position = at(length);
    moving.velocity = v0 + a * length;
    Some(budgets)
}

/// Half the torque impulse of a substep of `h` \[s\] during which `∫ x dt = travelled`.
fn twist(body: &Body, moving: &mut Moving, pushes: &[Push], budgets: &mut [Budget], h: f64, travelled: V3) {
    let turning: Vec<V3> = pushes
        .iter()
        .map(|p| match p.lever {
            Lever::Centre => V3::zeros(),
            Lever::Hook(arm) => (moving.turn * arm).cross(&p.force) * (0.5 * h),
            Lever::Fixed { point, torque } => (torque * h + (point * h - travelled).cross(&p.force)) * 0.5,
        })
        .collect();
    let sum: V3 = turning.iter().sum();
    if sum == V3::zeros() {
        return;
    }
    let before = angular_velocity(&moving.turn, moving.spin, body.inverse);
    moving.spin += sum;
    let mean = (before + angular_velocity(&moving.turn, moving.spin, body.inverse)) * 0.5;
    for (sum, turning) in budgets.iter_mut().zip(turning) {
        sum.add(budget(V3::zeros(), turning, turning.dot(&mean)));
    }
}
