//! Outside influences on bodies of many parts, as particles, nodes and vertices: what they add to a velocity in a step.

use super::SolverScene;
use crate::boundary::{Vec3, add, cross, dot, norm, scale, sub};
use crate::scene::{ActionKind, Field};

/// What an influence does.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PartInfluence {
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
pub struct PartAction {
    /// What it does.
    pub influence: PartInfluence,
    /// Whether it acts on each body.
    pub bodies: Vec<bool>,
    /// First moment \[s\].
    pub from: f64,
    /// Last moment \[s\].
    pub until: f64,
    /// Whether its potential energy is in the books: it is gravity that always acts, and does not begin or end.
    pub has_potential: bool,
}

/// All influences over one step.
#[derive(Clone, Debug, Default)]
pub struct Push {
    /// Change of velocity of each body \[m/s\].
    uniform: Vec<Vec3>,
    /// The part of it that is gravity's \[m/s\].
    weight: Vec<Vec3>,
    /// Fields with the time they act \[s\].
    fields: Vec<(Vec<bool>, Field, f64)>,
    /// Air: velocity \[m/s\], and `ρ c_d / 2` times the time it acts \[kg s/m³\].
    winds: Vec<(Vec<bool>, Vec3, f64)>,
}

/// The actions of a scene, for bodies of these masses \[kg\]. What cannot be played is told to `refuse`.
///
/// A force at the centre of mass accelerates every part alike.
pub fn part_actions(scene: &SolverScene, masses: &[f64], refuse: &mut dyn FnMut(&str)) -> Vec<PartAction> {
    let mut list = Vec::new();
    for action in &scene.actions {
        let all = action.bodies.is_empty();
        let bodies: Vec<bool> = scene.bodies.iter().map(|b| all || action.bodies.contains(&b.name)).collect();
        let until = action.until_s.unwrap_or(f64::INFINITY);
        let mut add = |influence: PartInfluence, bodies: Vec<bool>, has_potential: bool| {
            list.push(PartAction { influence, bodies, from: action.from_s, until, has_potential });
        };
        let mut each = |per_mass: &dyn Fn(f64) -> PartInfluence| {
            for (i, mass) in masses.iter().enumerate().filter(|(i, _)| bodies[*i]) {
                add(per_mass(1.0 / mass), (0..bodies.len()).map(|k| k == i).collect(), false);
            }
        };
        match action.kind {
            ActionKind::PointForce { force_n, at_m: None } => each(&|per| PartInfluence::Uniform(scale(force_n, per))),
            ActionKind::Impulse { impulse_n_s, at_m: None } => {
                each(&|per| PartInfluence::Kick(scale(impulse_n_s, per)));
            }
            ActionKind::Gravity { acceleration_m_s2 } => {
                add(PartInfluence::Uniform(acceleration_m_s2), bodies, action.always());
            }
            ActionKind::AccelerationField { field } => add(PartInfluence::Field(field), bodies, false),
            ActionKind::Wind { velocity_m_s, air_density_kg_m3, drag_coefficient } => {
                add(PartInfluence::Wind(velocity_m_s, 0.5 * air_density_kg_m3 * drag_coefficient), bodies, false);
            }
            ActionKind::PointForce { .. } => refuse("point forces beside the centre of mass (`at_m`)"),
            ActionKind::Impulse { .. } => refuse("impulses beside the centre of mass (`at_m`)"),
            ActionKind::Reverse => refuse("reversed velocities"),
            ActionKind::Inflow { .. } | ActionKind::Drain { .. } => refuse("inflows and drains"),
        }
    }
    list
}

impl Push {
    /// Influences on so many bodies over `start..end` \[s\].
    pub fn new(actions: &[PartAction], bodies: usize, start: f64, end: f64) -> Self {
        let mut push = Self { uniform: vec![[0.0; 3]; bodies], weight: vec![[0.0; 3]; bodies], ..Self::default() };
        for action in actions {
            let seconds = (end.min(action.until) - start.max(action.from)).max(0.0);
            let change = match action.influence {
                PartInfluence::Uniform(acceleration) if seconds > 0.0 => scale(acceleration, seconds),
                PartInfluence::Kick(change) if action.from >= start && action.from < end => change,
                PartInfluence::Field(field) if seconds > 0.0 => {
                    push.fields.push((action.bodies.clone(), field, seconds));
                    continue;
                }
                PartInfluence::Wind(velocity, half) if seconds > 0.0 => {
                    push.winds.push((action.bodies.clone(), velocity, half * seconds));
                    continue;
                }
                _ => continue,
            };
            let Self { uniform, weight, .. } = &mut push;
            for i in (0..bodies).filter(|&i| action.bodies[i]) {
                uniform[i] = add(uniform[i], change);
                if action.has_potential {
                    weight[i] = add(weight[i], change);
                }
            }
        }
        push
    }

    /// Change of velocity of a part of a body at `x` \[m\], without that by air \[m/s\].
    #[inline]
    pub fn at(&self, body: usize, x: Vec3) -> Vec3 {
        let fields = self.fields.iter().filter(|(bodies, ..)| bodies[body]);
        fields.fold(self.uniform[body], |sum, (_, field, seconds)| add(sum, scale(field.acceleration(x), *seconds)))
    }

    /// Change of velocity of a body by gravity \[m/s\].
    pub fn weight(&self, body: usize) -> Vec3 {
        self.weight[body]
    }

    /// Whether nothing changes the velocity of a body but air.
    pub fn is_still(&self, body: usize) -> bool {
        self.fields.is_empty() && self.uniform[body].iter().all(|a| a.abs() < f64::MIN_POSITIVE)
    }

    /// Whether anything acts that has no potential energy.
    pub fn supplies(&self) -> bool {
        self.has_wind() || !self.fields.is_empty() || self.uniform != self.weight
    }

    /// Whether air moves past a body.
    pub fn has_wind(&self) -> bool {
        !self.winds.is_empty()
    }

    /// Air past a body: velocity \[m/s\], and `ρ c_d / 2` times the time it acts \[kg s/m³\].
    pub fn winds(&self, body: usize) -> impl Iterator<Item = (Vec3, f64)> {
        self.winds.iter().filter(move |(bodies, ..)| bodies[body]).map(|&(_, air, half)| (air, half))
    }
}

impl Field {
    /// Acceleration at `x` \[m\], in m/s².
    pub fn acceleration(&self, x: Vec3) -> Vec3 {
        match *self {
            Self::Constant { acceleration_m_s2 } => acceleration_m_s2,
            Self::Cylinder { strength_m_s2, direction, center_m, radius_m } => {
                let inside = norm(cross(sub(x, center_m), direction)) <= radius_m;
                if inside { scale(direction, strength_m_s2) } else { [0.0; 3] }
            }
            Self::Point { strength_m_s2, center_m, falloff } => {
                let towards = sub(center_m, x);
                let r = dot(towards, towards).sqrt();
                if r > 0.0 { scale(towards, strength_m_s2 / (r * libm::pow(1.0 + r, falloff))) } else { [0.0; 3] }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn action(influence: PartInfluence, from: f64, until: f64, has_potential: bool) -> PartAction {
        PartAction { influence, bodies: vec![true, false], from, until, has_potential }
    }

    #[test]
    fn influences_act_for_the_part_of_a_step_that_is_theirs() {
        let field = Field::Point { strength_m_s2: 8.0, center_m: [1.0, 0.0, 0.0], falloff: 1.0 };
        let list = [
            action(PartInfluence::Uniform([0.0, 0.0, -2.0]), 0.0, f64::INFINITY, true),
            action(PartInfluence::Field(field), 0.5, 0.75, false),
            action(PartInfluence::Kick([0.0, 3.0, 0.0]), 0.5, f64::INFINITY, false),
        ];
        let push = Push::new(&list, 2, 0.0, 0.5);
        assert!(!push.supplies() && push.is_still(1) && !push.is_still(0));
        assert_eq!([push.at(0, [0.0; 3]), push.at(1, [0.0; 3])], [[0.0, 0.0, -1.0], [0.0; 3]]);
        let push = Push::new(&list, 2, 0.5, 1.0);
        // A quarter of a second of 8 / (1 + 1) m/s² towards the point, and the kick.
        assert_eq!([push.at(0, [0.0; 3]), push.weight(0)], [[1.0, 3.0, -1.0], [0.0, 0.0, -1.0]]);
        assert!(push.supplies() && !push.has_wind());
        // At the point itself no direction is its own.
        assert_eq!([push.at(0, [1.0, 0.0, 0.0])], [[0.0, 3.0, -1.0]]);
    }
}
