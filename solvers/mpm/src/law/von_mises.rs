//! Hencky solids that flow by von Mises: at once, or as fast as Herschel and Bulkley say.
//!
//! With the equivalent plastic strain `ε_p`, its rate and `|dev τ|` at yield, `√(2/3) (Y + H ε_p) + √2 K (√2 |D_p|)^n` in
//! which `√2 |D_p|` is the rate of a simple shear: so the shear stress of a simple shear is `Y/√3 + K γ̇^n`. Within a
//! substep the flow is taken with its rate at the end, which is stable at any length of it. Source: Yue et al.,
//! "Continuum foam" (2015), with the shear modulus of Hencky's law in place of the one that its neo-Hookean solid needs.

use cosplat_core::scene::Lame;

use super::log::Log;
use super::solid::Moduli;
use super::{Returned, YieldNorm};
use crate::math::{Sym, all, square};
use crate::real::{Lanes, Real};

/// Hencky solid with von Mises plasticity.
#[derive(Clone, Copy, Debug)]
pub(crate) struct VonMises<R: Real> {
    pub(super) solid: Moduli<R>,
    /// Largest `|dev e|` before any flow.
    limit: f64,
    /// Rise of the limit with the equivalent plastic strain.
    rise: f64,
    /// Consistency \[Pa sⁿ\] and flow index.
    fluid: (f64, f64),
}

/// Rounds of Newton's method for the rate of flow: it doubles the digits in each once it is near.
const ROUNDS: usize = 40;

impl<R: Real> VonMises<R> {
    pub(super) fn new(lame: Lame, yield_stress: f64, norm: YieldNorm) -> Self {
        Self { solid: Moduli::new(lame), limit: norm.limit(yield_stress, lame.mu_pa), rise: 0.0, fluid: (0.0, 1.0) }
    }

    /// With a hardening \[Pa\], a consistency \[Pa sⁿ\] and a flow index.
    pub(super) fn viscoplastic(
        lame: Lame,
        [yield_stress, hardening]: [f64; 2],
        fluid: (f64, f64),
        norm: YieldNorm,
    ) -> Self {
        Self { rise: norm.limit(hardening, lame.mu_pa), fluid, ..Self::new(lame, yield_stress, norm) }
    }

    /// Largest `|dev e|` after so much plastic strain.
    #[inline]
    fn limit(&self, plastic: R::V) -> R::V {
        (all::<R>(self.limit) + plastic * all::<R>(self.rise)).max(R::V::default())
    }

    /// Whether [`Self::flow`] could change a strain.
    #[inline]
    fn may_flow(&self, b: &Sym<R>, plastic: R::V) -> bool {
        // |e| ≤ h / (1 - 2h) with h = |B|/2, so below the limit no return is possible.
        let limits = self.limit(plastic).array();
        square::<R>(b).array().iter().zip(limits).any(|(&s, limit)| {
            let h = 0.5 * s.f64().sqrt();
            h >= limit.f64() * (1.0 - 2.0 * h)
        })
    }

    /// Returns the strain towards the yield surface; the history is the equivalent plastic strain. The energy lost is
    /// `2 μ |dev e| Δγ` with the returned deviator.
    ///
    /// `Δγ = |dev e| - limit - over`, `e ← e - Δγ dev e / |dev e|`, `Δε_p = √(2/3) Δγ`, in which `over` is what hardening
    /// and the rate of flow bear. Source: Simo, "Algorithms for static and dynamic multiplicative plasticity" (1992).
    pub(super) fn flow(&self, b: &Sym<R>, plastic: R::V, dt: f64) -> Option<Returned<R>> {
        if !self.may_flow(b, plastic) {
            return None;
        }
        let (log, zero, limit) = (Log::<R>::of(b), R::V::default(), self.limit(plastic));
        let norm = log.deviator();
        let trial = (norm - limit).max(zero);
        let over = self.over(trial, dt);
        let (kept, excess) = ((limit + over).max(zero), (trial - over).min(norm));
        let new = log.returned(all::<R>(1.0) - excess / norm.max(limit), log.sum());
        Some(Returned {
            // Untouched where nothing flows.
            b: [0, 1, 2, 3, 4, 5].map(|i| R::V::if_less(zero, trial, new[i], b[i])),
            past: plastic + excess * all::<R>((2.0_f64 / 3.0).sqrt()),
            lost: excess * kept * self.solid.mu * all::<R>(2.0),
            put: zero,
        })
    }

    /// Part of what passes the limit that hardening and the rate of flow bear.
    fn over(&self, trial: R::V, dt: f64) -> R::V {
        let (consistency, index) = self.fluid;
        let harder = self.rise * (2.0_f64 / 3.0).sqrt();
        if consistency <= 0.0 || index >= 1.0 {
            // Linear: over = a Δγ.
            let a = harder + consistency / (self.solid.lame.mu_pa * dt);
            return trial * all::<R>(a / (1.0 + a));
        }
        let one = |trial: R| R::of(thinning(trial.f64(), harder, self.solid.lame.mu_pa, (consistency, index), dt));
        R::V::from_array(trial.array().map(one))
    }
}

/// `over` of a fluid of index below 1: with the shear stress t of its flow, the trial passes the limit by
/// `√2 t / 2μ + (1 + harder) Δγ`, `Δγ = (dt/√2) (t/K)^(1/n)`. Convex in t: Newton's method comes down from the right.
fn thinning(trial: f64, harder: f64, mu: f64, (consistency, index): (f64, f64), dt: f64) -> f64 {
    let half = std::f64::consts::FRAC_1_SQRT_2;
    let mut t = (trial * mu / half).min(consistency * libm::pow(trial / (dt * half * (1.0 + harder)), index));
    for _ in 0..ROUNDS {
        let flow = dt * half * libm::pow(t / consistency, 1.0 / index);
        let left = half * t / mu + (1.0 + harder) * flow - trial;
        if left <= 1e-12 * trial {
            break;
        }
        t -= left / (half / mu + (1.0 + harder) * flow / (index * t));
    }
    trial - dt * half * libm::pow(t / consistency, 1.0 / index)
}
