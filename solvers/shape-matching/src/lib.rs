//! Rigid bodies as particles held together by shape matching (Müller, Heidelberger, Teschner, Gross, "Meshless
//! deformations based on shape matching", 2005, with stiffness one), a second opinion beside the solver `rigid`.
//!
//! A body is a cloud of particles that fill its shape (`particles`). In a substep they fly on by their velocities, and the
//! body turns to where its shape at rest fits them best: the rotation of `A = Σ m p qᵀ` (`matching`). Velocities are not
//! taken from the goal positions, which keeps angular momentum to second order only, but are the rigid motion with the
//! momenta of the particles: both momenta are kept to rounding, energy to first order in the substep.
//!
//! Contact (`contact`) is that of points of the surface with walls and with the shapes of other bodies. Collisions of
//! single particles, repeated until matching changes nothing, give each point the inverse mass of the whole body; that
//! limit is solved directly, by projected Gauss–Seidel with Coulomb friction.
//!
//! Mass and inertia are those of the particles: a box is exact in volume and within 1/n² in its moments, for n particles
//! along a side (ten along the longest, unless the body has a `spacing`).
//!
//! Not here: joints, motion told in advance, forces at a point, restitution, moving walls.

mod body;
mod contact;
mod matching;
mod model;
mod particles;
mod plugin;
mod read;
mod report;
mod step;

use nalgebra::{Matrix3, Quaternion, UnitQuaternion, Vector3};

pub use plugin::ShapeMatching;

/// Three components along the world axes, or those of a body.
type V3 = Vector3<f64>;
/// A matrix over them.
type M3 = Matrix3<f64>;
/// Rotation from a body's frame to the world.
type Turn = UnitQuaternion<f64>;

/// From `[x, y, z, w]`, as the contract writes a quaternion.
fn turn([x, y, z, w]: [f64; 4]) -> Turn {
    UnitQuaternion::from_quaternion(Quaternion::new(w, x, y, z))
}

/// As the contract writes it.
fn plain(turn: &Turn) -> [f64; 4] {
    [turn.i, turn.j, turn.k, turn.w]
}
