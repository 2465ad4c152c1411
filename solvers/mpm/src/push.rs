//! Outside influences: what they add to a node's velocity in one substep.

use cosplat_core::boundary::{add, cross, dot, norm, scale, sub};
use cosplat_core::scene::Field;

/// What an influence does.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Influence {
    /// The same acceleration everywhere \[m/s²\].
    Uniform([f64; 3]),
    /// An acceleration that depends on the place.
    Field(Field),
    /// A total impulse per mass of the body at `from` \[m/s\].
    Kick([f64; 3]),
}

/// An influence in a range of time.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Action {
    /// What it does.
    pub(crate) influence: Influence,
    /// Whether it acts on each body.
    pub(crate) bodies: Vec<bool>,
    /// First moment \[s\].
    pub(crate) from: f64,
    /// Last moment \[s\].
    pub(crate) until: f64,
    /// Whether it is gravity, which has a potential.
    pub(crate) gravity: bool,
}

/// All influences over one substep.
#[derive(Clone, Debug, Default)]
pub(crate) struct Push {
    /// Change of velocity of each body \[m/s\].
    pub(crate) uniform: Vec<[f64; 3]>,
    /// The part of it that is gravity's \[m/s\].
    pub(crate) weight: Vec<[f64; 3]>,
    /// Fields with the time they act \[s\].
    pub(crate) fields: Vec<(Vec<bool>, Field, f64)>,
}

impl Push {
    /// Influences over `start..end` \[s\].
    pub(crate) fn new(actions: &[Action], bodies: usize, start: f64, end: f64) -> Self {
        let mut push = Self { uniform: vec![[0.0; 3]; bodies], weight: vec![[0.0; 3]; bodies], fields: Vec::new() };
        for action in actions {
            let seconds = (end.min(action.until) - start.max(action.from)).max(0.0);
            let change = match action.influence {
                Influence::Uniform(acceleration) if seconds > 0.0 => scale(acceleration, seconds),
                Influence::Kick(change) if action.from >= start && action.from < end => change,
                Influence::Field(field) if seconds > 0.0 => {
                    push.fields.push((action.bodies.clone(), field, seconds));
                    continue;
                }
                _ => continue,
            };
            let Self { uniform, weight, .. } = &mut push;
            for i in (0..bodies).filter(|&i| action.bodies[i]) {
                uniform[i] = add(uniform[i], change);
                if action.gravity {
                    weight[i] = add(weight[i], change);
                }
            }
        }
        push
    }

    /// Change of velocity of a body's node at `x` \[m/s\].
    #[inline]
    pub(crate) fn at(&self, body: usize, x: [f64; 3]) -> [f64; 3] {
        self.fields
            .iter()
            .filter(|(bodies, ..)| bodies[body])
            .fold(self.uniform[body], |sum, (_, field, seconds)| add(sum, scale(acceleration(field, x), *seconds)))
    }
}

/// Acceleration of a field at `x` \[m/s²\].
fn acceleration(field: &Field, x: [f64; 3]) -> [f64; 3] {
    match *field {
        Field::Constant { acceleration_m_s2 } => acceleration_m_s2,
        Field::Cylinder { strength_m_s2, direction, center_m, radius_m } => {
            let inside = norm(cross(sub(x, center_m), direction)) <= radius_m;
            if inside { scale(direction, strength_m_s2) } else { [0.0; 3] }
        }
        Field::Point { strength_m_s2, center_m, falloff } => {
            let towards = sub(center_m, x);
            let r = dot(towards, towards).sqrt();
            if r == 0.0 { [0.0; 3] } else { scale(towards, strength_m_s2 / (r * libm::pow(1.0 + r, falloff))) }
        }
    }
}
