//! The record from which a resolver makes its stand-in of a body.

use cosplat_core::boundary::{BoundaryState, ProxyRecord};
use cosplat_core::plugin::Moving;
use cosplat_core::rotation::angular_velocity;
use nalgebra::Matrix3;

use crate::V3;
use crate::joints::Pushed;
use crate::model::{Body, Model, State};
use crate::plain;
use crate::rotation::tensor;

/// What the last step says about a body's near future.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Past {
    /// Impulses of contacts and joints.
    pub(crate) pushed: Pushed,
    /// Impulses of partners, angular about the centre of mass.
    pub(crate) received: Pushed,
    /// Length of the step \[s\]; 0 before the first.
    pub(crate) length: f64,
}

/// Record of a body at time `t` \[s\].
///
/// The background is what outside influences do now, and with it the rate `R` at which floor, joints and other rigid
/// bodies pushed in the last step, where it opposes what drove the body, `d = M⁻¹ΣJ / W + g`, and never more than that:
/// support is foreseen, a bounce is not repeated. The gyroscopic term is not in it; it belongs to the stand-in's own
/// equation of motion. `inertia` holds components of the tensor, so `xy = -Σ m x y`.
pub(crate) fn record(model: &Model, index: usize, state: &State, t: f64, past: &Past) -> BoundaryState {
    let (body, moving) = (&model.bodies[index], &state.bodies[index]);
    let twist = body.twist(moving);
    let mut record = ProxyRecord {
        position: moving.position.into(),
        orientation: plain(&body.frame(moving)),
        linear_velocity: twist.linear.into(),
        angular_velocity: twist.angular.into(),
        mass: body.mass,
        inertia: [0.0; 6],
        share: 1.0,
        background_linear: [0.0; 3],
        background_angular: [0.0; 3],
    };
    if let Some(motion) = &body.motion {
        record.mass = f64::INFINITY;
        record.inertia = [f64::INFINITY, f64::INFINITY, f64::INFINITY, 0.0, 0.0, 0.0];
        record.background_linear = body.driven(motion, t).1.into();
        return BoundaryState::Proxy(record);
    }
    let i: Matrix3<f64> = tensor(&moving.turn, body.moments);
    record.inertia = [i.m11, i.m22, i.m33, i.m12, i.m13, i.m23];
    let [linear, angular] = background(model, index, state, t, body, moving, past);
    record.background_linear = linear.into();
    record.background_angular = angular.into();
    BoundaryState::Proxy(record)
}

fn background(
    model: &Model,
    index: usize,
    state: &State,
    t: f64,
    body: &Body,
    moving: &Moving,
    past: &Past,
) -> [V3; 2] {
    let (mut force, mut torque) = (V3::zeros(), V3::zeros());
    for (f, arm, _) in model.forces(&state.hooks, index, t) {
        force += f;
        torque += arm.map_or_else(V3::zeros, |arm| (moving.turn * arm).cross(&f));
    }
    let turning = |torque: V3| angular_velocity(&moving.turn, torque, body.inverse);
    let own = [force / body.mass, turning(torque)];
    if past.length == 0.0 {
        return own;
    }
    let rates = |p: &Pushed| [p.linear / (body.mass * past.length), turning(p.angular) / past.length];
    let (support, partners) = (rates(&past.pushed), rates(&past.received));
    std::array::from_fn(|k| own[k] + opposing(support[k], own[k] + partners[k]))
}

/// `rate` where it opposes `driving`, no larger than that.
fn opposing(rate: V3, driving: V3) -> V3 {
    if rate.dot(&driving) < 0.0 { rate * (driving.norm() / rate.norm()).min(1.0) } else { V3::zeros() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn support_is_foreseen_and_a_bounce_is_not_repeated() {
        let g = V3::new(0.0, 0.0, -9.81);
        assert_eq!(opposing(-g, g), -g);
        assert_eq!(opposing(g * 0.1, g), V3::zeros());
        // A bounce takes a hundred times the weight for one window; the floor will hold the weight, no more. Roundings.
        assert!((opposing(g * -100.0, g) + g).norm() < 1e-14);
        // On a slope without friction the support is not vertical, and stays whole.
        let slope = V3::new(3.0, 0.0, 4.0);
        assert_eq!(opposing(slope, g), slope);
    }
}
