//! Newton's viscosity: `τ = 2 η J dev(sym C)`, of liquids and of solids that damp themselves (Kelvin and Voigt).
//!
//! η is in Pa s, so that no result depends on it through the length of a step.

use crate::math::{Full, Sym, all};
use crate::real::Real;

/// Dynamic viscosity.
#[derive(Clone, Copy, Debug)]
pub(super) struct Viscosity<R: Real> {
    /// η \[Pa s\].
    pub(super) eta: f64,
    /// 2 η.
    twice: R::V,
}

impl<R: Real> Viscosity<R> {
    pub(super) fn new(eta: f64) -> Self {
        Self { eta, twice: all::<R>(2.0 * eta) }
    }

    /// Whether there is any.
    #[inline]
    pub(super) fn acts(&self) -> bool {
        self.eta > 0.0
    }

    /// Kirchhoff stress \[Pa\] at a volume ratio and a velocity gradient \[1/s\].
    #[inline]
    pub(super) fn stress(&self, volume: R::V, c: &Full<R>) -> Sym<R> {
        let eta = volume * self.twice;
        let half = eta * all::<R>(0.5);
        let mean = eta * (c[0][0] + c[1][1] + c[2][2]) * all::<R>(1.0 / 3.0);
        [
            eta * c[0][0] - mean,
            eta * c[1][1] - mean,
            eta * c[2][2] - mean,
            half * (c[0][1] + c[1][0]),
            half * (c[0][2] + c[2][0]),
            half * (c[1][2] + c[2][1]),
        ]
    }

    /// Power that it takes per volume at rest \[W/m³\]: `2 η J |dev(sym C)|²`.
    pub(super) fn heat(&self, volume: R::V, c: &Full<R>) -> R::V {
        let mean = (c[0][0] + c[1][1] + c[2][2]) * all::<R>(1.0 / 3.0);
        let on = [c[0][0] - mean, c[1][1] - mean, c[2][2] - mean];
        let off = [c[0][1] + c[1][0], c[0][2] + c[2][0], c[1][2] + c[2][1]];
        let sum = on[0] * on[0] + on[1] * on[1] + on[2] * on[2];
        let shear = off[0] * off[0] + off[1] * off[1] + off[2] * off[2];
        (sum + shear * all::<R>(0.5)) * self.twice * volume
    }
}
