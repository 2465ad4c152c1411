//! What moving air does to cloth.

use cosplat_core::boundary::{Vec3, add, dot, scale, sub};
use cosplat_core::plugin::Push;

/// Impulse \[N s\] of the air on a vertex: `ρ c_d/2 A |v_n| v_n` along its normal, for the patch that it stands for.
///
/// At most what brings the patch to the speed of the air: an explicit step must not turn the relative wind round.
pub(crate) fn wind(push: &Push, body: usize, (u, mass): (Vec3, f64), (normal, area): (Vec3, f64)) -> Vec3 {
    push.winds(body).fold([0.0; 3], |sum, (air, half)| {
        let across = dot(sub(air, u), normal);
        let impulse = (half * area * across.abs()).min(mass) * across;
        add(sum, scale(normal, impulse))
    })
}
