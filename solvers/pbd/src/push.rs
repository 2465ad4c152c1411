//! Outside influences: gravity, fields, forces at the centre of mass, moving air.

use cosplat_core::boundary::{Vec3, add, cross, dot, norm, scale, sub};
use cosplat_core::scene::Field;

/// What an influence does.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Influence {
    /// The same acceleration everywhere \[m/s²\].
    Uniform(Vec3),
    /// An acceleration that depends on the place.
    Field(Field),
    /// A total impulse per mass of the body at `from` \[m/s\].
    Kick(Vec3),
    /// Air of a velocity \[m/s\] and `ρ c_d / 2` \[kg/m³\].
    Wind(Vec3, f64),
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
    uniform: Vec<Vec3>,
    /// The part of it that is gravity's \[m/s\].
    weight: Vec<Vec3>,
    /// Fields with the time they act \[s\].
    fields: Vec<(Vec<bool>, Field, f64)>,
    /// Air with the time it acts \[s\].
    winds: Vec<(Vec<bool>, Vec3, f64)>,
    /// Share of the velocity that damping takes.
    pub(crate) damped: f64,
}

impl Push {
    /// Influences over `start..end` \[s\], and damping at a rate \[1/s\].
    pub(crate) fn new(actions: &[Action], bodies: usize, (start, end): (f64, f64), damping: f64) -> Self {
        let damped = -libm::expm1(-damping * (end - start));
        let mut push =
            Self { uniform: vec![[0.0; 3]; bodies], weight: vec![[0.0; 3]; bodies], damped, ..Self::default() };
        for action in actions {
            let seconds = (end.min(action.until) - start.max(action.from)).max(0.0);
            let change = match action.influence {
                Influence::Uniform(acceleration) if seconds > 0.0 => scale(acceleration, seconds),
                Influence::Kick(change) if action.from >= start && action.from < end => change,
                Influence::Field(field) if seconds > 0.0 => {
                    push.fields.push((action.bodies.clone(), field, seconds));
                    continue;
                }
                Influence::Wind(velocity, half) if seconds > 0.0 => {
                    push.winds.push((action.bodies.clone(), velocity, half * seconds));
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

    /// Change of velocity of a body's vertex at `x` \[m\].
    #[inline]
    pub(crate) fn at(&self, body: usize, x: Vec3) -> Vec3 {
        let fields = self.fields.iter().filter(|(bodies, ..)| bodies[body]);
        fields.fold(self.uniform[body], |sum, (_, field, seconds)| add(sum, scale(acceleration(field, x), *seconds)))
    }

    /// Whether anything acts that has no potential energy.
    pub(crate) fn supplies(&self) -> bool {
        self.has_wind() || !self.fields.is_empty() || self.uniform != self.weight
    }

    /// Change of velocity of a body by gravity \[m/s\].
    pub(crate) fn weight(&self, body: usize) -> Vec3 {
        self.weight[body]
    }

    /// Whether air moves past a body.
    pub(crate) fn has_wind(&self) -> bool {
        !self.winds.is_empty()
    }

    /// Impulse \[N s\] of the air on a vertex: `ρ c_d/2 A |v_n| v_n` along its normal, for the patch that it stands for.
    ///
    /// At most what brings the patch to the speed of the air: an explicit step must not turn the relative wind round.
    pub(crate) fn wind(&self, body: usize, (u, mass): (Vec3, f64), (normal, area): (Vec3, f64)) -> Vec3 {
        self.winds.iter().filter(|(bodies, ..)| bodies[body]).fold([0.0; 3], |sum, (_, air, half)| {
            let across = dot(sub(*air, u), normal);
            let impulse = (half * area * across.abs()).min(mass) * across;
            add(sum, scale(normal, impulse))
        })
    }
}

/// Acceleration of a field at `x` \[m/s²\].
fn acceleration(field: &Field, x: Vec3) -> Vec3 {
    match *field {
        Field::Constant { acceleration_m_s2 } => acceleration_m_s2,
        Field::Cylinder { strength_m_s2, direction, center_m, radius_m } => {
            let inside = norm(cross(sub(x, center_m), direction)) <= radius_m;
            if inside { scale(direction, strength_m_s2) } else { [0.0; 3] }
        }
        Field::Point { strength_m_s2, center_m, falloff } => {
            let towards = sub(center_m, x);
            let r = norm(towards);
            if r > 0.0 { scale(towards, strength_m_s2 / (r * libm::pow(1.0 + r, falloff))) } else { [0.0; 3] }
        }
    }
}
