//! Rigid bodies with contact, friction and joints, as responders of deformable solvers.
//!
//! rapier3d finds contacts and solves for their impulses in single precision; it is asked for nothing else. Position,
//! orientation, momentum and angular momentum of every body are kept here in double precision and advanced by the
//! impulses that rapier reports, so that every change of momentum is explained by a force, an impulse of a partner, a
//! contact or a joint, and flight between contacts is as exact as without them.
//!
//! A step is cut where an influence begins or ends, and then into equal substeps. In each of them (`step`):
//! rapier gets the state rounded to its precision and the forces (`world`), finds contacts, asks for the coefficients
//! of each pair (`pairs`) and solves; the impulses are read back (`contacts`); joints are solved directly for the
//! velocities that those leave (`joints`); and the bodies move.

mod actions;
mod advance;
mod contacts;
mod hull;
mod joints;
mod model;
mod pairs;
mod params;
mod plugin;
mod proxy;
mod read;
mod report;
mod rotation;
mod save;
mod shape;
mod single;
mod step;
mod walls;
mod world;

use nalgebra::{UnitQuaternion, Vector3};

pub use plugin::Rigid;

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
