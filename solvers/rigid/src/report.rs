//! State, energies and budgets of a step.

use cosplat_core::plugin::{BodyState, Budget, Energy, Moving, Report};
use cosplat_core::visual::VisualState;

use crate::V3;
use crate::model::{Body, Model, State};
use crate::plain;

/// State and budgets at time `t` \[s\]; `springs` is the energy in the joints \[J\].
pub(crate) fn report(
    model: &Model,
    state: &State,
    t: f64,
    springs: f64,
    external: &Budget,
    received: &[Budget],
) -> Report {
    let pairs = || model.bodies.iter().zip(&state.bodies);
    let kinetic = pairs().map(|(b, m)| b.kinetic(m));
    let weights = model.influences.iter().filter(|i| i.acts_at(t) && i.has_potential());
    let potential =
        weights.flat_map(|i| i.bodies.iter().map(|&b| -i.force(model.bodies[b].mass).dot(&state.bodies[b].position)));
    Report {
        substeps: 0,
        substep_bound_by: String::new(),
        bodies: pairs().map(|(b, m)| body_state(b, m)).collect(),
        external: external.wrench,
        energy: Energy {
            kinetic_j: kinetic.sum(),
            potential_j: potential.sum::<f64>() + springs,
            dissipated_j: state.dissipated,
        },
        interfaces: model.views.iter().zip(received).map(|(view, budget)| budget.report(view.id)).collect(),
        ..Report::default()
    }
}

fn body_state(body: &Body, moving: &Moving) -> BodyState {
    let twist = body.twist(moving);
    let start = &body.start;
    let moved = |mark: &V3| (moving.position + moving.turn * mark - start.position - start.turn * mark).norm();
    BodyState {
        mass_kg: body.mass,
        position_m: moving.position.into(),
        orientation: plain(&body.frame(moving)),
        linear_velocity_m_s: twist.linear.into(),
        angular_velocity_rad_s: twist.angular.into(),
        momentum: moving.momentum(body.mass),
        gross_momentum: body.mass * twist.linear.norm(),
        max_displacement_m: body.marks.iter().map(moved).fold(0.0, f64::max),
    }
}

/// Pose of the body frame.
pub(crate) fn pose(body: &Body, moving: &Moving) -> VisualState {
    let frame = body.frame(moving);
    VisualState::Pose { position: (moving.position - frame * body.centre).into(), orientation: plain(&frame) }
}
