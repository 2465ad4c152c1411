//! What a scene is to this solver, and what changes in a run.

use cosplat_core::plugin::{Influence, Moving, OwnView, hooks};
use cosplat_core::rotation::angular_momentum;
use cosplat_core::scene::Motion;
use cosplat_core::time::Clock;

use crate::joints::Joint;
use crate::pairs::Pairs;
use crate::params::Params;
use crate::shape::Part;
use crate::walls::StaticWall;
use crate::{Turn, V3};

/// A scene, read.
#[derive(Clone)]
pub(crate) struct Model {
    pub(crate) clock: Clock,
    pub(crate) params: Params,
    pub(crate) bodies: Vec<Body>,
    pub(crate) walls: Vec<StaticWall>,
    pub(crate) joints: Vec<Joint>,
    pub(crate) views: Vec<OwnView>,
    pub(crate) influences: Vec<Influence>,
    pub(crate) pairs: Pairs,
    /// Smallest extent of a body \[m\]: rapier's tolerances are shares of it.
    pub(crate) unit: f64,
    /// Where rapier has its origin \[m\], so that its single precision is spent on the scene and not on its place.
    pub(crate) origin: V3,
}

/// A rigid body.
#[derive(Clone)]
pub(crate) struct Body {
    pub(crate) name: String,
    /// \[kg\].
    pub(crate) mass: f64,
    /// Principal moments \[kg m²\].
    pub(crate) moments: V3,
    /// 1 / moments \[1/(kg m²)\].
    pub(crate) inverse: V3,
    /// From the principal frame to the body frame.
    pub(crate) axes: Turn,
    /// Centre of mass in the body frame \[m\].
    pub(crate) centre: V3,
    /// Farthest points, principal frame \[m\].
    pub(crate) marks: Vec<V3>,
    /// What it touches with, about its centre of mass along the body frame.
    pub(crate) parts: Vec<Part>,
    /// Smallest extent \[m\].
    pub(crate) extent: f64,
    /// At t = 0.
    pub(crate) start: Moving,
    /// Motion told in advance.
    pub(crate) motion: Option<Motion>,
    /// Whether a partner sees it.
    pub(crate) coupled: bool,
}

/// All that changes in a run, beside what rapier remembers of its contacts.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct State {
    pub(crate) bodies: Vec<Moving>,
    /// Lever arms of forces that act at a point of a body, principal frame \[m\]; set when the force begins.
    pub(crate) hooks: Vec<V3>,
    /// Energy that contacts and joints have taken since t = 0 \[J\].
    pub(crate) dissipated: f64,
}

/// Velocities of a body: of its centre of mass \[m/s\] and angular \[rad/s\].
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Twist {
    pub(crate) linear: V3,
    pub(crate) angular: V3,
}

impl Twist {
    /// Velocity \[m/s\] of the point that is `arm` \[m\] away from the centre of mass.
    pub(crate) fn at(&self, arm: V3) -> V3 {
        self.linear + self.angular.cross(&arm)
    }

    /// Half the sum.
    pub(crate) fn mean(self, other: Self) -> Self {
        Self { linear: (self.linear + other.linear) * 0.5, angular: (self.angular + other.angular) * 0.5 }
    }
}

/// A frame that starts at `position` \[m\] and `turn` and moves as told: place, orientation, velocity of its origin
/// \[m/s\] and angular velocity \[rad/s\] at time `t` \[s\].
///
/// Twist: the origin goes straight, the frame turns about it. Oscillation: `x0 + a sin(2π f t)`.
pub(crate) fn told(motion: &Motion, position: V3, turn: &Turn, t: f64) -> (V3, Turn, Twist) {
    match *motion {
        Motion::Twist { linear_m_s, angular_rad_s } => {
            let twist = Twist { linear: linear_m_s.into(), angular: angular_rad_s.into() };
            (position + twist.linear * t, Turn::from_scaled_axis(twist.angular * t) * turn, twist)
        }
        Motion::Oscillation { amplitude_m, frequency_hz } => {
            let rate = std::f64::consts::TAU * frequency_hz;
            let (sin, cos) = (rate * t).sin_cos();
            let a = V3::from(amplitude_m);
            (position + a * sin, *turn, Twist { linear: a * (rate * cos), angular: V3::zeros() })
        }
    }
}

impl Body {
    /// Where a motion told in advance has it at time `t` \[s\], with its acceleration \[m/s²\].
    pub(crate) fn driven(&self, motion: &Motion, t: f64) -> (Moving, V3) {
        let lever = self.start.turn * self.axes.inverse() * self.centre;
        let (origin, turn, twist) = told(motion, self.start.position - lever, &self.start.turn, t);
        let arm = turn * self.axes.inverse() * self.centre;
        let moving = Moving {
            position: origin + arm,
            turn,
            velocity: twist.at(arm),
            spin: angular_momentum(&turn, twist.angular, self.moments),
        };
        let acceleration = match *motion {
            Motion::Twist { .. } => twist.angular.cross(&twist.angular.cross(&arm)),
            Motion::Oscillation { frequency_hz, .. } => {
                (origin + lever - self.start.position) * -(std::f64::consts::TAU * frequency_hz).powi(2)
            }
        };
        (moving, acceleration)
    }

    /// Kinetic energy \[J\].
    pub(crate) fn kinetic(&self, moving: &Moving) -> f64 {
        let twist = self.twist(moving);
        0.5 * (self.mass * twist.linear.norm_squared() + moving.spin.dot(&twist.angular))
    }

    /// Its velocities.
    pub(crate) fn twist(&self, moving: &Moving) -> Twist {
        let angular = cosplat_core::rotation::angular_velocity(&moving.turn, moving.spin, self.inverse);
        Twist { linear: moving.velocity, angular }
    }

    /// Orientation of the body frame.
    pub(crate) fn frame(&self, moving: &Moving) -> Turn {
        moving.turn * self.axes.inverse()
    }
}

impl Model {
    /// State at t = 0.
    pub(crate) fn start(&self) -> State {
        let bodies = self.bodies.iter().map(|b| b.motion.as_ref().map_or(b.start, |m| b.driven(m, 0.0).0)).collect();
        let hooks = hooks(&self.influences);
        let mut state = State { bodies, hooks: vec![V3::zeros(); hooks], dissipated: 0.0 };
        self.hook(&mut state, f64::NEG_INFINITY, 0.0);
        state
    }
}
