//! Stress, plastic flow, energy and stiffness of the materials, from the stored strain `B = b_e - I`.
//!
//! Kirchhoff stress τ, Lamé parameters λ and μ. Neo-Hookean: `τ = μ B + λ ln J I`. Hencky: `B = U diag(β) Uᵀ`,
//! `e = ln(1 + β) / 2`, `τ = U diag(2 μ e + λ Σe) Uᵀ`.

use cosplat_core::scene::Lame;

use crate::math::{Sym, all, det_minus_one, eigen, from_eigen, ln_1p, small_exp, small_log, square};
use crate::real::{Lanes, Real};

/// Which norm of the stress is compared with the yield stress.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum YieldNorm {
    /// `|dev τ| ≤ √(2/3) Y`: yields at the yield stress Y in uniaxial tension.
    #[default]
    Physical,
    /// `|dev τ| ≤ Y`, as the first seed's simulator: yields at 1.2247 Y in uniaxial tension.
    Genesis,
}

impl YieldNorm {
    /// Largest `|dev e|` of an elastic state.
    fn limit(self, yield_stress: f64, mu: f64) -> f64 {
        let factor = match self {
            Self::Physical => (2.0_f64 / 3.0).sqrt(),
            Self::Genesis => 1.0,
        };
        factor * yield_stress / (2.0 * mu)
    }
}

/// Material of one body.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Law<R: Real> {
    lame: Lame,
    lambda: R::V,
    mu: R::V,
    /// Largest `|dev e|`, for materials that flow; those are Hencky.
    limit: Option<f64>,
}

impl<R: Real> Law<R> {
    /// Neo-Hookean solid.
    pub(crate) fn elastic(lame: Lame) -> Self {
        Self { lame, lambda: all::<R>(lame.lambda_pa), mu: all::<R>(lame.mu_pa), limit: None }
    }

    /// Hencky solid with von Mises plasticity.
    pub(crate) fn elastoplastic(lame: Lame, yield_stress: f64, norm: YieldNorm) -> Self {
        Self { limit: Some(norm.limit(yield_stress, lame.mu_pa)), ..Self::elastic(lame) }
    }

    /// Kirchhoff stress \[Pa\].
    #[inline]
    pub(crate) fn stress(&self, b: &Sym<R>) -> Sym<R> {
        if self.limit.is_some() {
            return self.hencky_stress(b);
        }
        let half = all::<R>(0.5);
        let pressure = self.lambda * (ln_1p::<R>(det_minus_one::<R>(b)) * half);
        let mu = self.mu;
        [mu * b[0] + pressure, mu * b[1] + pressure, mu * b[2] + pressure, mu * b[3], mu * b[4], mu * b[5]]
    }

    fn hencky_stress(&self, b: &Sym<R>) -> Sym<R> {
        if let Some(twice) = small_log::<R>(b) {
            let pressure = self.lambda * (twice[0] + twice[1] + twice[2]) * all::<R>(0.5);
            let (mu, t) = (self.mu, twice);
            return [mu * t[0] + pressure, mu * t[1] + pressure, mu * t[2] + pressure, mu * t[3], mu * t[4], mu * t[5]];
        }
        let (beta, u) = eigen::<R>(b);
        let twice = beta.map(ln_1p::<R>);
        let pressure = self.lambda * (twice[0] + twice[1] + twice[2]) * all::<R>(0.5);
        from_eigen::<R>(&twice.map(|e| self.mu * e + pressure), &u)
    }

    /// Whether [`Self::flow`] could change a strain.
    #[inline]
    pub(crate) fn may_flow(&self, b: &Sym<R>) -> bool {
        let Some(limit) = self.limit else { return false };
        // |e| ≤ h / (1 - 2h) with h = |B|/2, so below the limit no return is possible.
        square::<R>(b).array().iter().any(|&s| {
            let h = 0.5 * s.f64().sqrt();
            h >= limit * (1.0 - 2.0 * h)
        })
    }

    /// Returns the strain to the yield surface. Gives the new strain, the equivalent plastic strain added and the
    /// energy lost per volume at rest, `2 μ |dev e| Δγ` with the returned deviator.
    ///
    /// `Δγ = |dev e| - limit`, `e ← e - Δγ dev e / |dev e|`, `Δε_p = √(2/3) Δγ`. Source: Simo, "Algorithms for static
    /// and dynamic multiplicative plasticity" (1992); no hardening.
    pub(crate) fn flow(&self, b: &Sym<R>) -> (Sym<R>, R::V, R::V) {
        let zero = R::V::default();
        let Some(limit) = self.limit else { return (*b, zero, zero) };
        if let Some(twice) = small_log::<R>(b) {
            return self.small_flow(b, &twice, limit);
        }
        let (beta, u) = eigen::<R>(b);
        let e = beta.map(|beta| ln_1p::<R>(beta) * all::<R>(0.5));
        let mean = (e[0] + e[1] + e[2]) * all::<R>(1.0 / 3.0);
        let dev = e.map(|e| e - mean);
        let norm = (dev[0] * dev[0] + dev[1] * dev[1] + dev[2] * dev[2]).sqrt();
        let limit = all::<R>(limit);
        let excess = (norm - limit).max(zero);
        let keep = all::<R>(1.0) - excess / norm.max(limit);
        let returned = dev.map(|d| {
            let twice = (d * keep + mean) * all::<R>(2.0);
            R::V::from_array(twice.array().map(R::exp_m1))
        });
        let new = from_eigen::<R>(&returned, &u);
        // Untouched where nothing flows.
        let new = [0, 1, 2, 3, 4, 5].map(|i| R::V::if_less(zero, excess, new[i], b[i]));
        (new, excess * all::<R>((2.0_f64 / 3.0).sqrt()), excess * limit * self.mu * all::<R>(2.0))
    }

    /// The same for small strains, without eigenvectors; `twice` is `ln(I + B)`.
    fn small_flow(&self, b: &Sym<R>, twice: &Sym<R>, limit: f64) -> (Sym<R>, R::V, R::V) {
        let (zero, half) = (R::V::default(), all::<R>(0.5));
        let mean = (twice[0] + twice[1] + twice[2]) * all::<R>(1.0 / 3.0);
        let dev = [twice[0] - mean, twice[1] - mean, twice[2] - mean, twice[3], twice[4], twice[5]];
        let (norm, limit) = (square::<R>(&dev).sqrt() * half, all::<R>(limit));
        let excess = (norm - limit).max(zero);
        let keep = all::<R>(1.0) - excess / norm.max(limit);
        let back = |i: usize| if i < 3 { dev[i] * keep + mean } else { dev[i] * keep };
        let new = small_exp::<R>(&[back(0), back(1), back(2), back(3), back(4), back(5)]);
        let pick = |i: usize| R::V::if_less(zero, excess, new[i], b[i]);
        let new = [pick(0), pick(1), pick(2), pick(3), pick(4), pick(5)];
        (new, excess * all::<R>((2.0_f64 / 3.0).sqrt()), excess * limit * self.mu * all::<R>(2.0))
    }

    /// Keeps stretches inside 0.05..=20. Returns the strain and how many of four particles needed it.
    pub(crate) fn clamp(b: &Sym<R>, volume: R::V) -> (Sym<R>, u64) {
        let (beta, u) = eigen::<R>(b);
        let (least, most) = (all::<R>(STRETCH[0] * STRETCH[0] - 1.0), all::<R>(STRETCH[1] * STRETCH[1] - 1.0));
        let clamped = beta.map(|x| x.max(least).min(most));
        let mut hit = [false; 4];
        for (a, b) in beta.iter().zip(&clamped) {
            for (lane, (a, b)) in a.array().iter().zip(b.array()).enumerate() {
                hit[lane] |= *a != b;
            }
        }
        let volumes = volume.array();
        let count = (0..4).filter(|&lane| hit[lane] && volumes[lane] > R::default()).count() as u64;
        let flag = R::V::from_array(hit.map(|h| R::of(f64::from(u8::from(h)))));
        let new = from_eigen::<R>(&clamped, &u);
        ([0, 1, 2, 3, 4, 5].map(|i| R::V::if_less(R::V::default(), flag, new[i], b[i])), count)
    }

    /// Energy per volume at rest \[J/m³\] of one particle.
    ///
    /// Neo-Hookean `μ/2 (tr B - 2 ln J) + λ/2 ln² J`; Hencky `μ Σe² + λ/2 (Σe)²`.
    pub(crate) fn energy(&self, b: [f64; 6]) -> f64 {
        let Lame { lambda_pa, mu_pa } = self.lame;
        let b = b.map(all::<f64>);
        if self.limit.is_some() {
            let e = eigen::<f64>(&b).0.map(|beta| 0.5 * libm::log1p(beta.to_array()[0]));
            let sum: f64 = e.iter().sum();
            return mu_pa * e.iter().map(|e| e * e).sum::<f64>() + 0.5 * lambda_pa * sum * sum;
        }
        let twice_log = libm::log1p(det_minus_one::<f64>(&b).to_array()[0]);
        let trace = (b[0] + b[1] + b[2]).to_array()[0];
        0.5 * mu_pa * (trace - twice_log) + 0.125 * lambda_pa * twice_log * twice_log
    }

    /// Stiffness that carries the fastest wave through the strained material \[Pa\]: `λ max(1, 1 - ln J) + μ (1 + s²)`
    /// with the largest squared stretch `s²`, bounded by the rows of B. From the tangent `F² ∂P/∂F` of uniaxial strain.
    pub(crate) fn wave_modulus(&self, b: &Sym<R>) -> R::V {
        let [xx, yy, zz, xy, xz, yz] = *b;
        let (xy, xz, yz, zero, one) = (xy.abs(), xz.abs(), yz.abs(), R::V::default(), all::<R>(1.0));
        let most = (xx + xy + xz).max(yy + xy + yz).max(zz + xz + yz).max(zero);
        let twice_log = ln_1p::<R>(det_minus_one::<R>(b).max(all::<R>(-1.0 + 1e-7)));
        self.lambda * (one - twice_log * all::<R>(0.5)).max(one) + self.mu * (one + one + most)
    }
}

/// Smallest and largest stretch a particle may have.
pub(crate) const STRETCH: [f64; 2] = [0.05, 20.0];

#[cfg(test)]
mod tests {
    use super::*;

    /// Uniaxial stress by solving for the lateral stretch: returns the Kirchhoff stress along the axis.
    fn uniaxial(law: &Law<f64>, log_strain: f64, steps: usize) -> f64 {
        let mut b = [all::<f64>(0.0); 6];
        for _ in 0..steps {
            let axial = (log_strain / steps as f64).exp() - 1.0;
            let (mut low, mut high) = (-0.9, 0.9);
            let mut next = b;
            for _ in 0..60 {
                let lateral = 0.5 * (low + high);
                let l = [[axial, 0.0, 0.0], [0.0, lateral, 0.0], [0.0, 0.0, lateral]].map(|r| r.map(all::<f64>));
                next = crate::math::congruence::<f64>(&l, &b);
                next = law.flow(&next).0;
                if law.stress(&next)[1].to_array()[0] > 0.0 { high = lateral } else { low = lateral }
            }
            b = next;
        }
        law.stress(&b)[0].to_array()[0]
    }

    #[test]
    fn yields_at_the_yield_stress_or_at_that_of_the_seed() {
        let lame = Lame::from_young_poisson(2e6, 0.22);
        let physical = uniaxial(&Law::elastoplastic(lame, 3e4, YieldNorm::Physical), 0.2, 20);
        let genesis = uniaxial(&Law::elastoplastic(lame, 3e4, YieldNorm::Genesis), 0.2, 20);
        // Algebra in f64: the plateau of perfect plasticity in Kirchhoff stress.
        assert!((physical / 3e4 - 1.0).abs() < 1e-9, "{physical}");
        assert!((genesis / 3e4 - 1.5_f64.sqrt()).abs() < 1e-9, "{genesis}");
    }

    #[test]
    fn small_strains_obey_hooke() {
        let lame = Lame::from_young_poisson(2e6, 0.22);
        for law in [Law::<f64>::elastic(lame), Law::elastoplastic(lame, 3e6, YieldNorm::Physical)] {
            let stress = uniaxial(&law, 1e-5, 1);
            // Second order in a strain of 1e-5.
            assert!((stress / (2e6 * 1e-5) - 1.0).abs() < 3e-5, "{stress}");
        }
    }

    #[test]
    fn energy_is_the_work_of_the_stress() {
        // dψ = τ : d, for a rate d that commutes with nothing in particular.
        let lame = Lame::from_young_poisson(1e5, 0.3);
        let b = [0.2, -0.1, 0.05, 0.07, -0.03, 0.02];
        let d = [[0.3, 0.1, -0.2], [0.1, -0.4, 0.15], [-0.2, 0.15, 0.25]];
        for law in [Law::<f64>::elastic(lame), Law::elastoplastic(lame, 1e9, YieldNorm::Physical)] {
            let at = |h: f64| {
                let moved =
                    crate::math::congruence::<f64>(&d.map(|r| r.map(|v| all::<f64>(v * h))), &b.map(all::<f64>));
                law.energy(moved.map(|v| v.to_array()[0]))
            };
            let tau = law.stress(&b.map(all::<f64>)).map(|v| v.to_array()[0]);
            let power = tau[0] * d[0][0]
                + tau[1] * d[1][1]
                + tau[2] * d[2][2]
                + 2.0 * (tau[3] * d[0][1] + tau[4] * d[0][2] + tau[5] * d[1][2]);
            let found = (at(1e-5) - at(-1e-5)) / 2e-5;
            assert!((found / power - 1.0).abs() < 1e-7, "{found} instead of {power}");
        }
    }
}
