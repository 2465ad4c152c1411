//! The rotation that fits a shape at rest to where its particles are.

use crate::{M3, Turn, V3};

/// Most iterations; warm-started, two or three are needed.
const MOST: u32 = 30;
/// Angle that counts as none \[rad\].
const SMALLEST: f64 = 1e-15;

/// Rotation `R` for which `A Rᵀ` is symmetric, from one near it. Source: Müller, Bender, Chentanez, Macklin, "A robust
/// method to extract the rotational part of deformations" (2016).
pub(crate) fn rotation(a: &M3, from: &Turn) -> Turn {
    let mut turn = *from;
    for _ in 0..MOST {
        let r = turn.to_rotation_matrix();
        let r = r.matrix();
        let (mut torque, mut along) = (V3::zeros(), 0.0);
        for k in 0..3 {
            torque += r.column(k).cross(&a.column(k));
            along += r.column(k).dot(&a.column(k));
        }
        let angle = torque / (along.abs() + f64::MIN_POSITIVE);
        if angle.norm() < SMALLEST {
            break;
        }
        turn = Turn::from_scaled_axis(angle) * turn;
    }
    // Products of unit quaternions leave the unit sphere by roundings.
    Turn::new_normalize(turn.into_inner())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_turned_and_stretched_is_turned() {
        let shape = M3::new(0.3, 0.02, 0.01, 0.02, 0.2, -0.03, 0.01, -0.03, 0.5);
        for i in 0..20 {
            let t = f64::from(i);
            let turn = Turn::from_scaled_axis(V3::new(t.sin(), (1.3 * t).cos(), 0.4 * t.cos()) * 0.3);
            let found = rotation(&(turn.to_rotation_matrix().matrix() * shape), &Turn::identity());
            // A symmetric positive factor on the right does not turn. The iteration converges linearly.
            assert!(found.angle_to(&turn) < 1e-7, "{i}: {}", found.angle_to(&turn));
        }
    }
}
