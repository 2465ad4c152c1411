//! What a scene is to this solver, and what changes in a run.

use cosplat_core::boundary::Wrench;
use cosplat_core::plan::InterfaceId;
use cosplat_core::rotation::angular_momentum;
use cosplat_core::scene::Motion;
use cosplat_core::time::Clock;

use crate::{Turn, V3};

/// A scene, read.
#[derive(Clone, Debug)]
pub(crate) struct Model {
    pub(crate) clock: Clock,
    pub(crate) bodies: Vec<Body>,
    pub(crate) views: Vec<View>,
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
    pub(crate) start: Flying,
    /// Motion told in advance.
    pub(crate) motion: Option<Motion>,
    /// Whether a partner sees it.
    pub(crate) coupled: bool,
}

/// Motion of a body: 13 numbers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Flying {
    /// Centre of mass \[m\].
    pub(crate) position: V3,
    /// From the principal frame to the world.
    pub(crate) turn: Turn,
    /// Of the centre of mass \[m/s\].
    pub(crate) velocity: V3,
    /// Angular momentum about the centre of mass, world axes \[kg m²/s\].
    pub(crate) spin: V3,
}

/// All that changes in a run.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct State {
    pub(crate) bodies: Vec<Flying>,
    /// Lever arms of forces that act at a point of a body, principal frame \[m\]; set when the force begins.
    pub(crate) hooks: Vec<V3>,
}

/// An interface with a solver that computes the contact.
#[derive(Clone, Debug)]
pub(crate) struct View {
    pub(crate) id: InterfaceId,
    pub(crate) own: usize,
    pub(crate) partner: String,
}

/// An outside influence on some bodies in a range of time.
#[derive(Clone, Debug)]
pub(crate) struct Influence {
    pub(crate) kind: InfluenceKind,
    /// Those without a motion told in advance.
    pub(crate) bodies: Vec<usize>,
    /// \[s\].
    pub(crate) from: f64,
    /// \[s\].
    pub(crate) until: f64,
    /// First of its lever arms in [`State::hooks`], one per body, for a force at a point.
    pub(crate) hooks: Option<usize>,
}

/// What an influence does.
#[derive(Clone, Copy, Debug)]
pub(crate) enum InfluenceKind {
    /// \[m/s²\], with the potential energy `-m g·x`.
    Gravity(V3),
    /// \[m/s²\].
    Acceleration(V3),
    /// \[N\], at the point of the body that is at that place of the world when the force begins.
    Force(V3, Option<V3>),
    /// \[N s\] at `from`, at a point of the world.
    Kick(V3, Option<V3>),
}

impl Influence {
    pub(crate) fn acts_at(&self, t: f64) -> bool {
        t >= self.from && t < self.until
    }

    /// Whether it begins in `start..end` \[s\].
    pub(crate) fn begins_in(&self, start: f64, end: f64) -> bool {
        self.from >= start && self.from < end
    }

    /// Constant force on a body of that mass \[N\].
    pub(crate) fn force(&self, mass: f64) -> V3 {
        match self.kind {
            InfluenceKind::Gravity(g) | InfluenceKind::Acceleration(g) => g * mass,
            InfluenceKind::Force(f, _) => f,
            InfluenceKind::Kick(..) => V3::zeros(),
        }
    }
}

impl Flying {
    /// Momentum, angular part about the world origin.
    pub(crate) fn momentum(&self, mass: f64) -> Wrench {
        let linear = self.velocity * mass;
        Wrench { linear: linear.into(), angular: (self.position.cross(&linear) + self.spin).into() }
    }

    /// Whether every number is one.
    pub(crate) fn is_finite(&self) -> bool {
        let turn = self.turn.coords;
        [self.position, self.velocity, self.spin].iter().flat_map(V3::iter).chain(turn.iter()).all(|v| v.is_finite())
    }
}

impl Body {
    /// Where a motion told in advance has it at time `t` \[s\], with its acceleration \[m/s²\].
    ///
    /// Twist: the origin of the source's frame goes straight, the body turns about it. Oscillation: `x0 + a sin(2π f t)`.
    pub(crate) fn driven(&self, motion: &Motion, t: f64) -> (Flying, V3) {
        let start = &self.start;
        match *motion {
            Motion::Twist { linear_m_s, angular_rad_s } => {
                let (v, omega) = (V3::from(linear_m_s), V3::from(angular_rad_s));
                let turned = Turn::from_scaled_axis(omega * t);
                let lever = start.turn * self.axes.inverse() * self.centre;
                let arm = turned * lever;
                let turn = turned * start.turn;
                let flying = Flying {
                    position: start.position - lever + v * t + arm,
                    turn,
                    velocity: v + omega.cross(&arm),
                    spin: angular_momentum(&turn, omega, self.moments),
                };
                (flying, omega.cross(&omega.cross(&arm)))
            }
            Motion::Oscillation { amplitude_m, frequency_hz } => {
                let rate = std::f64::consts::TAU * frequency_hz;
                let (sin, cos) = (rate * t).sin_cos();
                let a = V3::from(amplitude_m);
                let flying = Flying {
                    position: start.position + a * sin,
                    velocity: a * (rate * cos),
                    spin: V3::zeros(),
                    ..*start
                };
                (flying, a * (-rate * rate * sin))
            }
        }
    }
}

impl Model {
    /// State at t = 0.
    pub(crate) fn start(&self) -> State {
        let bodies = self.bodies.iter().map(|b| b.motion.as_ref().map_or(b.start, |m| b.driven(m, 0.0).0)).collect();
        let hooks = self.influences.iter().filter(|i| i.hooks.is_some()).map(|i| i.bodies.len()).sum();
        let mut state = State { bodies, hooks: vec![V3::zeros(); hooks] };
        self.hook(&mut state, f64::NEG_INFINITY, 0.0);
        state
    }

    /// Fixes the points of forces that begin in `start..end` \[s\] to their bodies.
    pub(crate) fn hook(&self, state: &mut State, start: f64, end: f64) {
        for influence in self.influences.iter().filter(|i| i.begins_in(start, end)) {
            if let (Some(first), InfluenceKind::Force(_, Some(at))) = (influence.hooks, influence.kind) {
                for (k, &body) in influence.bodies.iter().enumerate() {
                    let flying = &state.bodies[body];
                    state.hooks[first + k] = flying.turn.inverse_transform_vector(&(at - flying.position));
                }
            }
        }
    }

    /// Moments strictly inside `(start, end)` \[s\] at which an influence begins or ends, in order, each once.
    pub(crate) fn switches(&self, start: f64, end: f64) -> Vec<f64> {
        let mut cuts: Vec<f64> =
            self.influences.iter().flat_map(|i| [i.from, i.until]).filter(|&t| t > start && t < end).collect();
        cuts.sort_by(f64::total_cmp);
        cuts.dedup();
        cuts
    }
}
