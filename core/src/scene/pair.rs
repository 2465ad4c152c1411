//! Contact parameters of two things that touch, where the scene says nothing about the pair.

use super::material::Material;
use super::model::{ContactLaw, PairSpec, Scene, Wall};

/// Friction coefficient where neither side's material has one.
pub const DEFAULT_FRICTION: f64 = 0.5;
/// Contact softness \[m\] where the scene gives none; the value of Table 5 of the first seed.
pub const DEFAULT_SOFTNESS_M: f64 = 0.002;

/// Contact parameters without the names of the two sides.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PairDefaults {
    /// Static friction coefficient.
    pub static_friction: f64,
    /// Kinetic friction coefficient.
    pub kinetic_friction: f64,
    /// Coefficient of restitution, 0..=1.
    pub restitution: f64,
    /// Contact softness \[m\].
    pub softness_m: f64,
}

impl Default for PairDefaults {
    fn default() -> Self {
        Self::with_friction(DEFAULT_FRICTION, DEFAULT_FRICTION)
    }
}

impl PairDefaults {
    /// Default restitution and softness with these frictions.
    fn with_friction(static_friction: f64, kinetic_friction: f64) -> Self {
        Self { static_friction, kinetic_friction, restitution: 0.0, softness_m: DEFAULT_SOFTNESS_M }
    }

    /// Two materials that touch: the larger friction of the two, where they have one.
    pub fn of_materials(a: &Material, b: &Material) -> Self {
        match (surface_friction(a), surface_friction(b)) {
            (Some(a), Some(b)) => Self::with_friction(a.0.max(b.0), a.1.max(b.1)),
            (Some(one), None) | (None, Some(one)) => Self::with_friction(one.0, one.1),
            (None, None) => Self::default(),
        }
    }

    /// Anything at a wall: the wall decides.
    pub fn of_wall(wall: Wall) -> Self {
        match wall {
            Wall::Slip => Self::with_friction(0.0, 0.0),
            Wall::NoSlip => Self::default(),
            Wall::Friction { static_friction, kinetic_friction } => {
                Self::with_friction(static_friction, kinetic_friction)
            }
        }
    }
}

/// Static and kinetic friction coefficient of a material's surface.
fn surface_friction(material: &Material) -> Option<(f64, f64)> {
    match *material {
        Material::Rigid { friction, .. } => Some((friction, friction)),
        Material::Cloth { static_friction, kinetic_friction, .. } => Some((static_friction, kinetic_friction)),
        _ => None,
    }
}

impl Scene {
    /// Contact parameters of a body and another body or static collider, in either order: what the scene says, else
    /// the defaults of the two. A name that does not exist takes the defaults.
    pub fn pair(&self, a: &str, b: &str) -> PairSpec {
        let listed = |pair: &&PairSpec| (pair.a == a && pair.b == b) || (pair.a == b && pair.b == a);
        self.pairs.iter().find(listed).cloned().unwrap_or_else(|| {
            let PairDefaults { static_friction, kinetic_friction, restitution, softness_m } = self.pair_defaults(a, b);
            PairSpec {
                a: a.to_owned(),
                b: b.to_owned(),
                static_friction,
                kinetic_friction,
                restitution,
                softness_m,
                contact: ContactLaw::Physical,
                resolver: None,
                enabled: true,
            }
        })
    }

    /// Contact parameters of a pair that `[[pair]]` does not list.
    pub fn pair_defaults(&self, a: &str, b: &str) -> PairDefaults {
        let wall = |name: &str| self.statics.iter().find(|s| s.name == name).map(|s| s.wall);
        let material = |name: &str| self.bodies.iter().find(|body| body.name == name).map(|body| body.material);
        match (wall(a).or_else(|| wall(b)), material(a), material(b)) {
            (Some(wall), _, _) => PairDefaults::of_wall(wall),
            (None, Some(a), Some(b)) => PairDefaults::of_materials(&a, &b),
            _ => PairDefaults::default(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::presets::preset;

    #[test]
    fn the_larger_friction_of_two_surfaces_counts() {
        let material = |name: &str| preset(name).map(|p| p.material).expect("a preset");
        let frictions = |a, b| {
            let defaults = PairDefaults::of_materials(&material(a), &material(b));
            (defaults.static_friction, defaults.kinetic_friction)
        };
        assert_eq!(frictions("brown-rock", "can"), (3.0, 3.0));
        assert_eq!(frictions("silk", "brown-rock"), (3.0, 3.0));
        assert_eq!(frictions("silk", "plushie"), (0.05, 0.03));
        assert_eq!(frictions("can", "mudslide"), (DEFAULT_FRICTION, DEFAULT_FRICTION));
    }
}
