//! What the solver shows: body states, energies and proxy records.

use cosplat_core::boundary::{BoundaryState, ProxyRecord};
use cosplat_core::plugin::{BodyState, Budget, Energy, Moving, Report};
use cosplat_core::rotation::angular_velocity;
use cosplat_core::visual::VisualState;
use nalgebra::Matrix3;

use crate::model::{Body, Model, State};
use crate::{V3, plain};

/// State and budgets at time `t` \[s\].
pub(crate) fn report(model: &Model, state: &State, t: f64, external: &Budget, received: &[Budget]) -> Report {
    let pairs = || model.bodies.iter().zip(&state.bodies);
    let kinetic = pairs().map(|(b, f)| b.kinetic(f));
    let weights = model.influences.iter().filter(|i| i.acts_at(t) && i.has_potential());
    let potential =
        weights.flat_map(|i| i.bodies.iter().map(|&b| -i.force(model.bodies[b].mass).dot(&state.bodies[b].position)));
    Report {
        substeps: 0,
        substep_bound_by: String::new(),
        bodies: pairs().map(|(b, f)| body_state(b, f)).collect(),
        external: external.wrench,
        energy: Energy { kinetic_j: kinetic.sum(), potential_j: potential.sum(), dissipated_j: 0.0 },
        interfaces: model.views.iter().zip(received).map(|(view, budget)| budget.report(view.id)).collect(),
        ..Report::default()
    }
}

fn body_state(body: &Body, moving: &Moving) -> BodyState {
    let momentum = moving.momentum(body.mass);
    let moved =
        |mark: &V3| (moving.position + moving.turn * mark - body.start.position - body.start.turn * mark).norm();
    BodyState {
        mass_kg: body.mass,
        position_m: moving.position.into(),
        orientation: plain(&(moving.turn * body.axes.inverse())),
        linear_velocity_m_s: moving.velocity.into(),
        angular_velocity_rad_s: angular_velocity(&moving.turn, moving.spin, body.inverse).into(),
        momentum,
        gross_momentum: body.mass * moving.velocity.norm(),
        max_displacement_m: body.marks.iter().map(moved).fold(0.0, f64::max),
    }
}

/// Pose of the frame in which the scene gives a body's shape.
pub(crate) fn pose(body: &Body, moving: &Moving) -> VisualState {
    let frame = moving.turn * body.axes.inverse();
    VisualState::Pose { position: (moving.position - frame * body.centre).into(), orientation: plain(&frame) }
}

/// Record from which a resolver makes its stand-in at time `t` \[s\].
///
/// The background is what outside influences do now: nothing touches a body here but its partners. The gyroscopic term
/// is not in it; it belongs to the stand-in's own equation of motion. `inertia` holds components of the tensor, so
/// `xy = -Σ m x y`.
pub(crate) fn proxy(model: &Model, index: usize, moving: &Moving, hooks: &[V3], t: f64) -> BoundaryState {
    let body = &model.bodies[index];
    let omega = angular_velocity(&moving.turn, moving.spin, body.inverse);
    let mut record = ProxyRecord {
        position: moving.position.into(),
        orientation: plain(&(moving.turn * body.axes.inverse())),
        linear_velocity: moving.velocity.into(),
        angular_velocity: omega.into(),
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
    let frame = moving.turn.to_rotation_matrix().into_inner();
    let tensor = frame * Matrix3::from_diagonal(&body.moments) * frame.transpose();
    record.inertia = [tensor.m11, tensor.m22, tensor.m33, tensor.m12, tensor.m13, tensor.m23];
    let (mut force, mut torque) = (V3::zeros(), V3::zeros());
    for influence in model.influences.iter().filter(|i| i.acts_at(t)) {
        if let Some(k) = influence.bodies.iter().position(|&b| b == index) {
            let f = influence.force(body.mass);
            force += f;
            if let Some(first) = influence.hooks {
                torque += (moving.turn * hooks[first + k]).cross(&f);
            }
        }
    }
    record.background_linear = (force / body.mass).into();
    record.background_angular = angular_velocity(&moving.turn, torque, body.inverse).into();
    BoundaryState::Proxy(record)
}
