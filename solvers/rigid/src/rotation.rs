//! The free rigid body by exact rotations about its principal axes.
//!
//! The kinetic energy is a sum of three terms `m_i² / 2 I_i` (m the angular momentum in the body's frame); the flow of
//! each is a rotation about one axis at constant rate `m_i / I_i`. Their symmetric composition is symplectic, keeps |m|
//! and leaves the angular momentum in space untouched. Source: Reich, "Momentum conserving symplectic integrators",
//! Physica D 76 (1994).

use nalgebra::{Matrix3, Quaternion, UnitQuaternion};

use crate::{Turn, V3};

/// Five symmetric stages of second order make one of fourth: `p, p, 1 - 4p, p, p` with `p = 1 / (4 - 4^(1/3))`.
/// Source: Suzuki (1990), "Fractal decomposition of exponential operators".
const OUTER: f64 = 0.414_490_771_794_375_7;
const STAGES: [f64; 5] = [OUTER, OUTER, 1.0 - 4.0 * OUTER, OUTER, OUTER];

/// Largest rotation of a part \[rad\]: energy of the fourth-order scheme is then off by less than 1e-8.
const ANGLE: f64 = 0.02;
/// Most parts of a substep; a body that needs more does not spin but blows up, which is found elsewhere.
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
    let parts = (rate * h / ANGLE).ceil().clamp(1.0, MOST_PARTS);
    (0..parts as u64).fold(*turn, |turn, _| part(&turn, spin, inverse, h / parts))
}

fn part(turn: &Turn, spin: V3, inverse: V3, h: f64) -> Turn {
    let mut q = *turn.quaternion();
    let mut m = turn.inverse_transform_vector(&spin);
    for stage in STAGES {
        let h = stage * h;
        for (axis, share) in [(0, 0.5), (1, 0.5), (2, 1.0), (1, 0.5), (0, 0.5)] {
            let angle = share * h * m[axis] * inverse[axis];
            let (sin, cos) = (0.5 * angle).sin_cos();
            let mut imaginary = V3::zeros();
            imaginary[axis] = sin;
            q *= Quaternion::from_parts(cos, imaginary);
            // The frame turns by `angle`, so m turns back by it: sine and cosine of the full angle from those of half.
            let (sin, cos) = (2.0 * sin * cos, cos * cos - sin * sin);
            let (j, k) = ((axis + 1) % 3, (axis + 2) % 3);
            (m[j], m[k]) = (cos * m[j] + sin * m[k], cos * m[k] - sin * m[j]);
        }
    }
    UnitQuaternion::new_normalize(q)
}

/// Angular velocity \[rad/s\], world axes: `ω = R I⁻¹ Rᵀ L`.
pub(crate) fn angular_velocity(turn: &Turn, spin: V3, inverse: V3) -> V3 {
    turn * turn.inverse_transform_vector(&spin).component_mul(&inverse)
}

/// Angular momentum \[kg m²/s\], world axes: `L = R I Rᵀ ω`.
pub(crate) fn angular_momentum(turn: &Turn, omega: V3, moments: V3) -> V3 {
    turn * turn.inverse_transform_vector(&omega).component_mul(&moments)
}

/// A tensor of those principal values in world axes: inertia, or its inverse.
pub(crate) fn tensor(turn: &Turn, principal: V3) -> Matrix3<f64> {
    let frame = turn.to_rotation_matrix().into_inner();
    frame * Matrix3::from_diagonal(&principal) * frame.transpose()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_scheme_is_of_fourth_order_and_reversible() {
        let inverse = V3::new(1.0, 2.0, 3.0).map(|i: f64| i.recip());
        let spin = V3::new(0.5, 2.0, -1.0);
        let after = |steps: u32| {
            (0..steps).fold(Turn::identity(), |turn, _| part(&turn, spin, inverse, 1.0 / f64::from(steps)))
        };
        let exact = after(4096);
        let (coarse, fine) = (after(8).angle_to(&exact), after(16).angle_to(&exact));
        assert!((coarse / fine).log2() > 3.9, "order {}", (coarse / fine).log2());
        let back = (0..8).fold(after(8), |turn, _| part(&turn, spin, inverse, -0.125));
        // The composition is symmetric: only roundings of 16 parts remain.
        assert!(back.angle() < 1e-14, "{}", back.angle());
    }
}
