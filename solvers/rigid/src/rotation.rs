//! The free rigid body in parts that its rate asks for, and tensors in world axes.

use cosplat_core::rotation;
use nalgebra::Matrix3;

use crate::{Turn, V3};

/// Most steps of a substep; a body that needs more does not spin but blows up, which is found elsewhere.
const MOST_PARTS: f64 = 1e5;

/// Turns a body for `h` \[s\] without torque, in as many parts as its rate asks for.
///
/// `turn` leads from the principal frame to the world, `spin` is the angular momentum about the centre of mass in world
/// axes \[kg m²/s\], `inverse` the inverse principal moments \[1/(kg m²)\].
pub(crate) fn free(turn: &Turn, spin: V3, inverse: V3, h: f64) -> Turn {
    let rate = spin.norm() * inverse.max();
    if rate == 0.0 {
        return *turn;
    }
    let parts = (rate * h / rotation::ANGLE).ceil().clamp(1.0, MOST_PARTS);
    (0..parts as u64).fold(*turn, |turn, _| rotation::free(&turn, spin, inverse, h / parts))
}

/// A tensor of those principal values in world axes: inertia, or its inverse.
pub(crate) fn tensor(turn: &Turn, principal: V3) -> Matrix3<f64> {
    let frame = turn.to_rotation_matrix().into_inner();
    frame * Matrix3::from_diagonal(&principal) * frame.transpose()
}
