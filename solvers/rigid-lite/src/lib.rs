//! Rigid bodies without contact: exact flight under constant forces, and a rotation that keeps angular momentum bitwise
//! and energy to fourth order.
//!
//! Partners see each body as a proxy record and answer with impulses, so this is the smallest honest responder; the
//! solver of rigid contact is another plugin.

mod flight;
mod model;
mod plugin;
mod read;
mod report;
mod shape;
mod step;

use nalgebra::{UnitQuaternion, Vector3};

pub use plugin::RigidLite;

/// Three components along the world axes.
type V3 = Vector3<f64>;
/// Rotation from a body's frame to the world.
type Turn = UnitQuaternion<f64>;

/// `[x, y, z, w]`, as the contract writes a quaternion.
fn plain(turn: &Turn) -> [f64; 4] {
    [turn.i, turn.j, turn.k, turn.w]
}

/// From `[x, y, z, w]`.
fn turn(xyzw: [f64; 4]) -> Turn {
    let [x, y, z, w] = xyzw;
    UnitQuaternion::from_quaternion(nalgebra::Quaternion::new(w, x, y, z))
}
