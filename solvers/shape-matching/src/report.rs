//! What the solver shows: body states, energies and proxy records.

use cosplat_core::boundary::{BoundaryState, ProxyRecord};
use cosplat_core::plugin::{BodyState, Energy, Moving, Report};
use cosplat_core::visual::VisualState;

use crate::body::Body;
use crate::model::{Model, State};
use crate::step::Books;
use crate::{V3, plain};

impl Model {
    /// Kinetic energy of all bodies \[J\].
    pub(crate) fn kinetic(&self, state: &State) -> f64 {
        self.bodies.iter().zip(&state.bodies).map(|(b, m)| b.kinetic(m)).sum()
    }

    /// State and budgets at time `t` \[s\].
    pub(crate) fn report(&self, state: &State, t: f64, books: Option<&Books>) -> Report {
        let weights = self.influences.iter().filter(|i| i.acts_at(t) && i.has_potential());
        let energy = |(i, mass): (usize, f64), g: V3| -g.dot(&state.bodies[i].position) * mass;
        let potential_j =
            weights.flat_map(|w| w.bodies.iter().map(|&i| energy((i, 1.0), w.force(self.bodies[i].mass))));
        let none = cosplat_core::plugin::Budget::default();
        let received = |k: usize| books.map_or(none, |b| b.received[k]);
        Report {
            substeps: books.map_or(0, |b| b.substeps),
            substep_bound_by: format!("max_substep_s: {:.3e} s, or a tenth of a radius", self.longest),
            bodies: self.bodies.iter().zip(&state.bodies).map(|(b, m)| body_state(b, m)).collect(),
            external: books.map_or(none, |b| b.external).wrench,
            supplied_j: books.map_or(0.0, |b| b.supplied_j),
            energy: Energy {
                kinetic_j: self.kinetic(state),
                potential_j: potential_j.sum(),
                dissipated_j: state.dissipated,
            },
            interfaces: self.views.iter().enumerate().map(|(k, view)| received(k).report(view.id)).collect(),
            counters: [
                ("contacts".to_owned(), books.map_or(0, |b| b.contacts)),
                ("largest-overlap-1e-6-m".to_owned(), books.map_or(0, |b| (1e6 * b.deepest) as u64)),
            ]
            .into(),
            ..Report::default()
        }
    }

    /// Record from which a resolver makes its stand-in at time `t` \[s\].
    ///
    /// The background is what outside influences do now, and the support by walls and other bodies in the last step of
    /// `length` \[s\] where it opposes them, no more than that: a bounce is not repeated.
    pub(crate) fn record(&self, index: usize, state: &State, t: f64, pushed: [V3; 2], length: f64) -> BoundaryState {
        let (body, moving) = (&self.bodies[index], &state.bodies[index]);
        let inverse = body.inverse_now(moving);
        let acting = self.influences.iter().filter(|i| i.acts_at(t) && i.bodies.contains(&index));
        let own = acting.map(|i| i.force(body.mass)).sum::<V3>() / body.mass;
        let mut linear = own;
        if length > 0.0 {
            let support = pushed[0] / (body.mass * length);
            if support.dot(&own) < 0.0 {
                linear += support * (own.norm() / support.norm()).min(1.0);
            }
        }
        let r = moving.turn.to_rotation_matrix();
        let spread = r.matrix() * body.spread * r.matrix().transpose();
        let i = crate::M3::identity() * spread.trace() - spread;
        BoundaryState::Proxy(ProxyRecord {
            position: moving.position.into(),
            orientation: plain(&moving.turn),
            linear_velocity: moving.velocity.into(),
            angular_velocity: (inverse * moving.spin).into(),
            mass: body.mass,
            inertia: [i.m11, i.m22, i.m33, i.m12, i.m13, i.m23],
            share: 1.0,
            background_linear: linear.into(),
            background_angular: [0.0; 3],
        })
    }
}

fn body_state(body: &Body, moving: &Moving) -> BodyState {
    let start = &body.start;
    let moved = |p: &V3| (moving.position + moving.turn * p - start.position - start.turn * p).norm();
    BodyState {
        mass_kg: body.mass,
        position_m: moving.position.into(),
        orientation: plain(&moving.turn),
        linear_velocity_m_s: moving.velocity.into(),
        angular_velocity_rad_s: body.omega(moving).into(),
        momentum: moving.momentum(body.mass),
        gross_momentum: body.mass * moving.velocity.norm(),
        max_displacement_m: body.points.iter().map(|(p, _)| moved(p)).fold(0.0, f64::max),
    }
}

/// Pose of the frame in which the scene gives a body's shape.
pub(crate) fn pose(body: &Body, moving: &Moving) -> VisualState {
    let position = (moving.position - moving.turn * body.centre).into();
    VisualState::Pose { position, orientation: plain(&moving.turn) }
}
