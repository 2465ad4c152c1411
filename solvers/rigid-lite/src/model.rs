//! What a scene is to this solver, and what changes in a run.

use cosplat_core::plugin::{Influence, InfluenceKind, Moving, OwnView, hooks};
use cosplat_core::rotation::{angular_momentum, angular_velocity};
use cosplat_core::scene::Motion;
use cosplat_core::time::Clock;

use crate::{Turn, V3};

/// A scene, read.
#[derive(Clone, Debug)]
pub(crate) struct Model {
    pub(crate) clock: Clock,
    pub(crate) bodies: Vec<Body>,
    pub(crate) views: Vec<OwnView>,
    pub(crate) influences: Vec<Influence>,
}

/// A rigid body.
#[derive(Clone, Debug)]
pub(crate) struct Body {
    pub(crate) name: String,
    /// \[kg\].
    pub(crate) mass: f64,
    /// Principal moments \[kg m²\].
    pub(crate) moments: V3,
    /// 1 / moments, 0 about an axis without moment: the body does not turn about it \[1/(kg m²)\].
    pub(crate) inverse: V3,
    /// From the principal frame to the frame of the source.
    pub(crate) axes: Turn,
    /// Centre of mass in the frame of the source \[m\].
    pub(crate) centre: V3,
    /// Farthest points, principal frame \[m\].
    pub(crate) marks: Vec<V3>,
    /// Points it is made of.
    pub(crate) particles: u64,
    /// At t = 0.
    pub(crate) start: Moving,
    /// Motion told in advance.
    pub(crate) motion: Option<Motion>,
    /// Whether a partner sees it.
    pub(crate) coupled: bool,
}

/// All that changes in a run.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct State {
    pub(crate) bodies: Vec<Moving>,
    /// Lever arms of forces that act at a point of a body, principal frame \[m\]; set when the force begins.
    pub(crate) hooks: Vec<V3>,
}

impl Body {
    /// Kinetic energy \[J\].
    pub(crate) fn kinetic(&self, moving: &Moving) -> f64 {
        let omega = angular_velocity(&moving.turn, moving.spin, self.inverse);
        0.5 * (self.mass * moving.velocity.norm_squared() + moving.spin.dot(&omega))
    }

    /// Where a motion told in advance has it at time `t` \[s\], with its acceleration \[m/s²\].
    ///
    /// Twist: the origin of the source's frame goes straight, the body turns about it. Oscillation: `x0 + a sin(2π f t)`.
    pub(crate) fn driven(&self, motion: &Motion, t: f64) -> (Moving, V3) {
        let start = &self.start;
        match *motion {
            Motion::Twist { linear_m_s, angular_rad_s } => {
                let (v, omega) = (V3::from(linear_m_s), V3::from(angular_rad_s));
                let turned = Turn::from_scaled_axis(omega * t);
                let lever = start.turn * self.axes.inverse() * self.centre;
                let arm = turned * lever;
                let turn = turned * start.turn;
                let moving = Moving {
                    position: start.position - lever + v * t + arm,
                    turn,
                    velocity: v + omega.cross(&arm),
                    spin: angular_momentum(&turn, omega, self.moments),
                };
                (moving, omega.cross(&omega.cross(&arm)))
            }
            Motion::Oscillation { amplitude_m, frequency_hz } => {
                let rate = std::f64::consts::TAU * frequency_hz;
                let (sin, cos) = (rate * t).sin_cos();
                let a = V3::from(amplitude_m);
                let moving = Moving {
                    position: start.position + a * sin,
                    velocity: a * (rate * cos),
                    spin: V3::zeros(),
                    ..*start
                };
                (moving, a * (-rate * rate * sin))
            }
        }
    }
}

impl Model {
    /// State at t = 0.
    pub(crate) fn start(&self) -> State {
        let bodies = self.bodies.iter().map(|b| b.motion.as_ref().map_or(b.start, |m| b.driven(m, 0.0).0)).collect();
        let hooks = hooks(&self.influences);
        let mut state = State { bodies, hooks: vec![V3::zeros(); hooks] };
        self.hook(&mut state, f64::NEG_INFINITY, 0.0);
        state
    }

    /// Fixes the points of forces that begin in `start..end` \[s\] to their bodies.
    pub(crate) fn hook(&self, state: &mut State, start: f64, end: f64) {
        for influence in self.influences.iter().filter(|i| i.begins_in(start, end)) {
            if let (Some(first), InfluenceKind::Force(_, Some(at))) = (influence.hooks, influence.kind) {
                for (k, &body) in influence.bodies.iter().enumerate() {
                    let moving = &state.bodies[body];
                    state.hooks[first + k] = moving.turn.inverse_transform_vector(&(at - moving.position));
                }
            }
        }
    }
}
