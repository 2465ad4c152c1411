//! What a force does over a stretch of time: impulse, angular impulse and work, each as an exact integral.

use cosplat_core::boundary::Wrench;
use cosplat_core::plugin::Budget;

use crate::V3;
use crate::modes::{Cubic, Motion};

/// A force `F(τ) = Σ_k c_k τ^k - K d(τ)` on a point that has moved by `d` since the start of the stretch.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Pull {
    /// K \[N/m\].
    pub(crate) stiffness: f64,
    /// `c_k` \[N/s^k\].
    pub(crate) force: Cubic,
}

impl Pull {
    /// A constant force.
    pub(crate) fn constant(force: V3) -> Self {
        Self { stiffness: 0.0, force: [force, V3::zeros(), V3::zeros(), V3::zeros()] }
    }

    /// Spring towards a partner on a path: `-K (x - path(τ)) + preload`, for a point that starts at `x0`.
    pub(crate) fn towards(stiffness: f64, preload: V3, x0: V3, path: &Cubic) -> Self {
        let mut force = path.map(|c| c * stiffness);
        force[0] = (path[0] - x0) * stiffness + preload;
        Self { stiffness, force }
    }

    /// Budget over a stretch of `length` \[s\] for a point that starts at `x0` \[m\] and moves as `motion` says.
    ///
    /// With the moments `m_k = ∫ τ^k d dτ`: `∫F = Σ c_k W^(k+1)/(k+1) - K m_0`;
    /// `∫ x × F = x0 × ∫F + Σ m_k × c_k`, as `d × d = 0`;
    /// `∫ F·d' = Σ c_k · (W^k d(W) - k m_(k-1)) - K |d(W)|²/2`, by parts.
    pub(crate) fn over(&self, length: f64, x0: V3, motion: &Motion) -> Budget {
        let d = motion.displacement;
        let mut linear = motion.moments[0] * -self.stiffness;
        let mut turning = V3::zeros();
        let mut work = -0.5 * self.stiffness * d.norm_squared();
        // W^k
        let mut power = 1.0;
        for (k, c) in self.force.iter().enumerate() {
            linear += c * (power * length / (k + 1) as f64);
            turning += motion.moments[k].cross(c);
            let before = if k == 0 { V3::zeros() } else { motion.moments[k - 1] * k as f64 };
            work += c.dot(&(d * power - before));
            power *= length;
        }
        let angular = x0.cross(&linear) + turning;
        Budget { wrench: Wrench { linear: linear.into(), angular: angular.into() }, work_j: work }
    }
}
