//! Contact impulses of a substep, read back from rapier.

use rapier3d::geometry::{ContactData, ContactManifold};
use rapier3d::math::Vector;
use rapier3d::pipeline::PhysicsWorld;

use crate::V3;
use crate::joints::Push;
use crate::single::double;

/// Contacts of a manifold that rapier solves.
const SOLVED: usize = 4;

/// All impulses of the last step. `place` tells where the centre of mass of a thing is, where it is a body that
/// contacts can move.
///
/// A step of rapier is one of its solver's steps here, so that the impulses kept for the next warm start are the whole
/// of what was applied. A manifold has normal impulses at its points, restitution included, and at their mean one
/// friction, kept as a vector of the world with each of them, and one couple about the normal. Lever arms are those
/// with which it solved.
pub(crate) fn pushes(world: &PhysicsWorld, place: impl Fn(usize) -> Option<V3>) -> Vec<Push> {
    let mut found = Vec::new();
    for pair in world.narrow_phase.contact_pairs() {
        let data = [pair.collider1, pair.collider2].map(|c| world.colliders.get(c).map(|c| c.user_data as usize));
        let [Some(one), Some(two)] = data else { continue };
        // Seen from the side that can move: the other one, its place, its arms, its sign.
        let (a, b, x, side, sign) = match (place(one), place(two)) {
            (Some(x), _) => (one, two, x, 0, 1.0),
            (None, Some(x)) => (two, one, x, 1, -1.0),
            (None, None) => continue,
        };
        for manifold in pair.solver_manifolds() {
            for (impulse, arms, couple) in solved(manifold) {
                let point = x + double(arms[side]);
                let (impulse, couple) = (double(impulse) * sign, double(couple) * sign);
                found.push(Push { a, b: Some(b), impulse, point, couple });
            }
        }
    }
    found
}

/// Impulses on the first body \[N s\] with their arms about both centres of mass \[m\], and couples \[N m s\].
fn solved(manifold: &ContactManifold) -> Vec<(Vector, [Vector; 2], Vector)> {
    let points = manifold.data.solver_contacts.iter().take(SOLVED).filter_map(|contact| {
        let [index] = contact.contact_indices();
        manifold.points.get(index as usize).map(|p| &p.data)
    });
    let points: Vec<&ContactData> = points.collect();
    let Some(first) = points.first() else { return Vec::new() };
    let toward = -manifold.data.normal;
    let mut all: Vec<_> =
        points.iter().map(|data| (toward * data.impulse, [data.solver_dp1, data.solver_dp2], Vector::ZERO)).collect();
    let mean = |arm: fn(&ContactData) -> Vector| {
        points.iter().fold(Vector::ZERO, |sum, data| sum + arm(data)) / points.len() as f32
    };
    let couple = if points.len() > 1 { toward * first.warmstart_twist_impulse } else { Vector::ZERO };
    all.push((first.warmstart_tangent_world, [mean(|d| d.solver_dp1), mean(|d| d.solver_dp2)], couple));
    all.retain(|(impulse, _, couple)| *impulse != Vector::ZERO || *couple != Vector::ZERO);
    all
}
