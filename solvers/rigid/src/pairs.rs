//! Coefficients of each pair that touches, exactly as the scene has them: nothing is averaged.

use std::collections::{BTreeMap, BTreeSet};

use cosplat_core::scene::{ContactLaw, Material, PairDefaults, PairSpec, Wall};
use rapier3d::geometry::SolverFlags;
use rapier3d::math::Vector;
use rapier3d::pipeline::{ContactModificationContext, ModifiableManifold, PairFilterContext, PhysicsHooks};

use crate::walls::StaticWall;

/// Relative speed below which a contact sticks and has its static coefficient \[m/s\]: a tenth of what gravity adds in
/// a hundredth of a second, and far above the noise of a body at rest.
const STICKING: f32 = 1e-2;
/// Coefficient of a wall that nothing slides on: the friction limit is then never reached.
const NO_SLIP: f64 = 1e6;

/// Friction and restitution of two things that touch.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Surface {
    pub(crate) static_friction: f64,
    pub(crate) kinetic_friction: f64,
    pub(crate) restitution: f64,
}

/// Surfaces by things: bodies in scene order, then static colliders. A collider's user data is its thing.
#[derive(Clone, Debug, Default)]
pub(crate) struct Pairs {
    bodies: Vec<Material>,
    walls: Vec<Wall>,
    listed: BTreeMap<[usize; 2], Surface>,
    apart: BTreeSet<[usize; 2]>,
}

impl Pairs {
    /// Reads the pairs of those things; names what cannot be done.
    pub(crate) fn new(
        specs: &[PairSpec],
        bodies: Vec<(String, Material)>,
        walls: &[(String, StaticWall)],
        refused: &mut Vec<String>,
    ) -> Self {
        let names: Vec<&String> = bodies.iter().map(|b| &b.0).chain(walls.iter().map(|w| &w.0)).collect();
        let mut pairs = Self::default();
        for spec in specs {
            let at = |name: &String| names.iter().position(|n| *n == name);
            let (Some(a), Some(b)) = (at(&spec.a), at(&spec.b)) else { continue };
            if !spec.enabled {
                pairs.apart.insert(key(a, b));
                continue;
            }
            if spec.contact == ContactLaw::Genesis {
                refused.push(format!("the genesis contact law (pair `{}` and `{}`)", spec.a, spec.b));
            }
            let surface = Surface {
                static_friction: spec.static_friction,
                kinetic_friction: spec.kinetic_friction,
                restitution: spec.restitution,
            };
            pairs.listed.insert(key(a, b), surface);
        }
        pairs.bodies = bodies.into_iter().map(|b| b.1).collect();
        pairs.walls = walls.iter().map(|w| w.1.wall).collect();
        pairs
    }

    /// Keeps two bodies that a joint holds together apart, unless the scene lists them as a pair.
    pub(crate) fn join(&mut self, a: usize, b: usize) {
        if !self.listed.contains_key(&key(a, b)) {
            self.apart.insert(key(a, b));
        }
    }

    /// Surface of two things, or nothing where they pass through each other.
    pub(crate) fn surface(&self, a: usize, b: usize) -> Option<Surface> {
        let key = key(a, b);
        if self.apart.contains(&key) {
            return None;
        }
        if let Some(surface) = self.listed.get(&key) {
            return Some(*surface);
        }
        let wall = |i: usize| i.checked_sub(self.bodies.len()).and_then(|w| self.walls.get(w));
        let plain = |d: PairDefaults| Surface {
            static_friction: d.static_friction,
            kinetic_friction: d.kinetic_friction,
            restitution: d.restitution,
        };
        match (wall(key[0]), wall(key[1]), self.bodies.get(key[0]), self.bodies.get(key[1])) {
            (_, Some(Wall::NoSlip), ..) => {
                Some(Surface { static_friction: NO_SLIP, kinetic_friction: NO_SLIP, restitution: 0.0 })
            }
            (_, Some(wall), ..) => Some(plain(PairDefaults::of_wall(*wall))),
            (.., Some(a), Some(b)) => Some(plain(PairDefaults::of_materials(a, b))),
            _ => None,
        }
    }
}

fn key(a: usize, b: usize) -> [usize; 2] {
    [a.min(b), a.max(b)]
}

/// A hook that rapier asks at every contact.
pub(crate) struct Asked<'a>(pub(crate) &'a Pairs);

impl Asked<'_> {
    fn surface(&self, context: [Option<u128>; 2]) -> Option<Surface> {
        let [Some(a), Some(b)] = context else { return None };
        self.0.surface(a as usize, b as usize)
    }
}

impl PhysicsHooks for Asked<'_> {
    fn filter_contact_pair(&self, context: &PairFilterContext) -> Option<SolverFlags> {
        let dynamic = [context.rigid_body1, context.rigid_body2]
            .into_iter()
            .flatten()
            .any(|handle| context.bodies.get(handle).is_some_and(rapier3d::dynamics::RigidBody::is_dynamic));
        let data = [context.collider1, context.collider2].map(|c| context.colliders.get(c).map(|c| c.user_data));
        self.surface(data).filter(|_| dynamic).map(|_| SolverFlags::COMPUTE_RIGID_IMPULSES)
    }

    fn modify_solver_contacts(&self, context: &mut ContactModificationContext) {
        let data = [context.collider1, context.collider2].map(|c| context.colliders.get(c).map(|c| c.user_data));
        let Some(surface) = self.surface(data) else { return };
        let bodies = [context.rigid_body1, context.rigid_body2].map(|h| h.and_then(|h| context.bodies.get(h)));
        let Some(manifold) = context.rigid_mut() else { return };
        let sliding = slides(manifold, bodies);
        let friction = if sliding { surface.kinetic_friction } else { surface.static_friction };
        *manifold.friction = friction as f32;
        *manifold.restitution = surface.restitution as f32;
    }
}

/// Whether a point of a manifold slides.
fn slides(manifold: &ModifiableManifold, bodies: [Option<&rapier3d::dynamics::RigidBody>; 2]) -> bool {
    let normal = *manifold.normal;
    manifold.solver_contacts.iter().any(|contact| {
        let at = |body: Option<&rapier3d::dynamics::RigidBody>, x: Vector| {
            body.map_or(Vector::ZERO, |b| b.velocity_at_point(x))
        };
        let middle = (contact.anchor1 + contact.anchor2) * 0.5;
        let relative = at(bodies[0], middle) - at(bodies[1], middle);
        (relative - normal * relative.dot(normal)).length() > STICKING
    })
}
