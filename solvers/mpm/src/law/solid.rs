//! Elastic moduli, and the stress and energy of elastic solids.

use cosplat_core::scene::Lame;

use super::log::Log;
use crate::math::{Sym, all, det_minus_one, ln_1p};
use crate::real::{Lanes, Real};

/// Lamé parameters, in all lanes.
#[derive(Clone, Copy, Debug)]
pub(super) struct Moduli<R: Real> {
    pub(super) lame: Lame,
    pub(super) lambda: R::V,
    pub(super) mu: R::V,
    /// Whether its volume ratio may be averaged over cells.
    pub(super) f_bar: bool,
}

impl<R: Real> Moduli<R> {
    pub(super) fn new(lame: Lame) -> Self {
        Self { lame, lambda: all::<R>(lame.lambda_pa), mu: all::<R>(lame.mu_pa), f_bar: true }
    }

    /// Bulk modulus `λ + 2μ/3` \[Pa\].
    pub(super) fn bulk(&self) -> f64 {
        self.lame.lambda_pa + 2.0 / 3.0 * self.lame.mu_pa
    }

    /// `τ = μ B + λ ln J I`.
    #[inline]
    pub(super) fn neo_hookean(&self, b: &Sym<R>) -> Sym<R> {
        let pressure = self.lambda * (ln_1p::<R>(det_minus_one::<R>(b)) * all::<R>(0.5));
        let mu = self.mu;
        [mu * b[0] + pressure, mu * b[1] + pressure, mu * b[2] + pressure, mu * b[3], mu * b[4], mu * b[5]]
    }

    /// `τ = 2 μ e + λ Σe I`.
    #[inline]
    pub(super) fn hencky(&self, b: &Sym<R>) -> Sym<R> {
        let log = Log::<R>::of(b);
        log.stress(self.mu, self.lambda * log.sum())
    }

    /// `μ/2 (tr B - 2 ln J) + λ/2 ln² J` \[J/m³\].
    pub(super) fn neo_hookean_energy(&self, b: [f64; 6]) -> f64 {
        let twice_log = libm::log1p(det_minus_one::<f64>(&b.map(all::<f64>)).to_array()[0]);
        let trace = b[0] + b[1] + b[2];
        0.5 * self.lame.mu_pa * (trace - twice_log) + 0.125 * self.lame.lambda_pa * twice_log * twice_log
    }

    /// `μ Σe² + λ/2 (Σe)²` \[J/m³\].
    pub(super) fn hencky_energy(&self, b: [f64; 6]) -> f64 {
        let log = Log::<f64>::of(&b.map(all::<f64>));
        let [sum, deviator] = [log.sum(), log.deviator()].map(|lanes| lanes.to_array()[0]);
        let squares = deviator * deviator + sum * sum / 3.0;
        self.lame.mu_pa * squares + 0.5 * self.lame.lambda_pa * sum * sum
    }

    /// Stiffness that carries the fastest wave through the strained material \[Pa\]: `λ max(1, 1 - ln J) + μ (1 + s²)`
    /// with the largest squared stretch `s²`, bounded by the rows of B. From the tangent `F² ∂P/∂F` of uniaxial strain.
    pub(super) fn wave(&self, b: &Sym<R>) -> R::V {
        let [xx, yy, zz, xy, xz, yz] = *b;
        let (xy, xz, yz, zero, one) = (xy.abs(), xz.abs(), yz.abs(), R::V::default(), all::<R>(1.0));
        let most = (xx + xy + xz).max(yy + xy + yz).max(zz + xz + yz).max(zero);
        let twice_log = ln_1p::<R>(det_minus_one::<R>(b).max(all::<R>(-1.0 + 1e-7)));
        self.lambda * (one - twice_log * all::<R>(0.5)).max(one) + self.mu * (one + one + most)
    }
}
