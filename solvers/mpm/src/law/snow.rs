//! Snow: fixed-corotated elasticity whose stretches stay in a narrow band, hardening as it is packed.
//!
//! `τ = h (2 μ (b - √b) + λ (J - 1) J I)`, principal stretches kept in `[1 - θc, 1 + θs]`; what is cut off goes into the
//! plastic volume ratio `J_p`, the history of the particle, and `h = exp(min(ξ (1 - J_p), ln 20))`. Source: Stomakhin et
//! al., "A material point method for snow simulation" (2013). Its bound on the growth of the moduli, a factor of 20, keeps
//! the step from collapsing; `J_p` stays in 0.1 to 2, beyond which a hardening of 10 leaves less than 1/20 000 of them.

use cosplat_core::scene::Lame;

use super::Returned;
use super::solid::Moduli;
use crate::math::{Sym, all, det_minus_one, eigen, exp_m1, from_eigen, ln_1p, small_root, square};
use crate::real::{Lanes, Real};

/// Largest growth of the moduli, as a logarithm: ln 20.
const MOST: f64 = 2.995_732_273_553_991;
/// Range of the plastic volume ratio.
const PACKED: [f64; 2] = [0.1, 2.0];

/// Snow of Stomakhin.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Snow<R: Real> {
    solid: Moduli<R>,
    /// Range of the eigenvalues of B: `(1 - θc)² - 1` and `(1 + θs)² - 1`.
    range: [f64; 2],
    /// ξ.
    hardening: f64,
}

impl<R: Real> Snow<R> {
    pub(super) fn new(lame: Lame, [compression, stretch, hardening]: [f64; 3]) -> Self {
        let range = [-compression * (2.0 - compression), stretch * (2.0 + stretch)];
        Self { solid: Moduli::new(lame), range, hardening }
    }

    /// h. A particle in quarantine, whose history is negative, counts as unpacked.
    #[inline]
    fn harder(&self, packed: R::V) -> R::V {
        let (zero, one) = (R::V::default(), all::<R>(1.0));
        let packed = R::V::if_less(packed, zero, one, packed);
        one + exp_m1::<R>(((one - packed) * all::<R>(self.hardening)).min(all::<R>(MOST)))
    }

    /// Kirchhoff stress \[Pa\].
    pub(super) fn stress(&self, b: &Sym<R>, packed: R::V) -> Sym<R> {
        let h = self.harder(packed);
        let (mu, pressure) = (h * self.solid.mu * all::<R>(2.0), h * self.pressure(b));
        // b - √b = B - (√b - I).
        if let Some(root) = small_root::<R>(b) {
            let on = |i: usize| mu * (b[i] - root[i]);
            return [on(0) + pressure, on(1) + pressure, on(2) + pressure, on(3), on(4), on(5)];
        }
        let (beta, u) = eigen::<R>(b);
        from_eigen::<R>(&beta.map(|beta| mu * (beta - stretch::<R>(beta)) + pressure), &u)
    }

    /// `λ (J - 1) J`.
    #[inline]
    fn pressure(&self, b: &Sym<R>) -> R::V {
        let square = det_minus_one::<R>(b);
        let more = stretch::<R>(square);
        self.solid.lambda * more * (all::<R>(1.0) + more)
    }

    /// Keeps the stretches in their range. The energy lost is the work of the stress on what is cut off, less what the
    /// change of the moduli stores.
    pub(super) fn flow(&self, b: &Sym<R>, packed: R::V) -> Option<Returned<R>> {
        let within = R::of(self.range[0].abs().min(self.range[1]).powi(2));
        if square::<R>(b).array().iter().all(|&s| s < within) {
            return None;
        }
        let (zero, half) = (R::V::default(), all::<R>(0.5));
        let (beta, u) = eigen::<R>(b);
        let [least, most] = self.range.map(all::<R>);
        let kept = beta.map(|beta| beta.max(least).min(most));
        let cut = [0, 1, 2].map(|i| (ln_1p::<R>(beta[i]) - ln_1p::<R>(kept[i])) * half);
        let new = from_eigen::<R>(&kept, &u);
        let sum = cut[0] + cut[1] + cut[2];
        let after = (packed + packed * exp_m1::<R>(sum)).max(all::<R>(PACKED[0])).min(all::<R>(PACKED[1]));
        let (before, later) = (self.harder(packed), self.harder(after));
        let pressure = self.pressure(&new);
        let mu = self.solid.mu;
        let (mut work, mut stored) = (zero, zero);
        for i in 0..3 {
            let more = stretch::<R>(kept[i]);
            work += cut[i] * ((mu + mu) * (kept[i] - more) + pressure);
            stored += mu * more * more;
        }
        let volume = stretch::<R>(det_minus_one::<R>(&new));
        stored += self.solid.lambda * volume * volume * half;
        let touched = cut[0].abs() + cut[1].abs() + cut[2].abs();
        Some(Returned {
            // Untouched where nothing is cut off.
            b: [0, 1, 2, 3, 4, 5].map(|i| R::V::if_less(zero, touched, new[i], b[i])),
            past: R::V::if_less(zero, touched, after, packed),
            lost: R::V::if_less(zero, touched, work * before - stored * (later - before), zero),
            put: zero,
        })
    }

    /// `h (μ Σ(S - 1)² + λ/2 (J - 1)²)` \[J/m³\].
    pub(super) fn energy(&self, b: [f64; 6], packed: f64) -> f64 {
        let b = b.map(all::<f64>);
        let one = |v: wide::f64x4| v.to_array()[0];
        let volume = one(stretch::<f64>(det_minus_one::<f64>(&b)));
        let shape: f64 = eigen::<f64>(&b).0.iter().map(|&beta| one(stretch::<f64>(beta)).powi(2)).sum();
        let h = if packed < 0.0 { 1.0 } else { libm::exp((self.hardening * (1.0 - packed)).min(MOST)) };
        h * (self.solid.lame.mu_pa * shape + 0.5 * self.solid.lame.lambda_pa * volume * volume)
    }

    /// Stiffness that carries the fastest wave \[Pa\].
    pub(super) fn wave(&self, b: &Sym<R>, packed: R::V) -> R::V {
        self.harder(packed) * self.solid.wave(b)
    }
}

/// `√(1 + x) - 1 = x / (1 + √(1 + x))`.
#[inline]
fn stretch<R: Real>(x: R::V) -> R::V {
    let one = all::<R>(1.0);
    x / (one + (one + x).sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::law::Law;
    use crate::math::congruence;
    use cosplat_core::scene::SNOW;

    const LAME: Lame = Lame::from_young_poisson(1.4e5, 0.2);

    fn one(v: wide::f64x4) -> f64 {
        v.to_array()[0]
    }

    /// Squeezed along z alone to the stretch `to`: stress along z, `J_p`, and energy lost.
    fn squeezed(to: f64, steps: usize) -> (f64, f64, f64) {
        let law = Law::<f64>::snow(LAME, SNOW);
        let factor = to.powf(1.0 / steps as f64) - 1.0;
        let l = [[0.0; 3], [0.0; 3], [0.0, 0.0, factor]].map(|r| r.map(all::<f64>));
        let (mut b, mut packed, mut lost) = ([all::<f64>(0.0); 6], all::<f64>(law.start()), 0.0);
        for _ in 0..steps {
            b = congruence::<f64>(&l, &b);
            if let Some(new) = law.flow(&b, packed, &crate::law::Room::endless()) {
                (b, packed, lost) = (new.b, new.past, lost + one(new.lost));
            }
        }
        (one(law.stress(&b, packed, &[[all::<f64>(0.0); 3]; 3])[2]), one(packed), lost)
    }

    #[test]
    fn packed_snow_hardens_by_the_closed_form() {
        // Squeezed to s along one axis: the elastic stretch stays at 1 - θc and J_p = s / (1 - θc).
        for to in [0.99, 0.9, 0.8, 0.6] {
            let (stress, packed, lost) = squeezed(to, 1000);
            let elastic = to.max(1.0 - SNOW[0]);
            let ratio = to / elastic;
            let h = (SNOW[2] * (1.0 - ratio)).exp().min(20.0);
            let wanted = h * elastic * (2.0 * LAME.mu_pa + LAME.lambda_pa) * (elastic - 1.0);
            println!("{to}: {stress} Pa of {wanted}, J_p {packed}, lost {lost} J/m³");
            // A thousand roundings of f64.
            assert!((stress / wanted - 1.0).abs() < 1e-10, "{stress} instead of {wanted}");
            assert!((packed / ratio - 1.0).abs() < 1e-12, "{packed}");
            assert!(lost >= 0.0, "{lost}");
        }
    }

    #[test]
    fn equal_stretches_give_the_pressures_of_the_catalogue() {
        // Kirchhoff pressure and J_p of one equal stretch of all axes, by another program (verification case M9).
        let cases = [(0.99, 2275.7, 1.0), (0.95, 11597.5, 0.92503), (0.90, 46332.7, 0.78653), (1.02, -1223.3, 1.03769)];
        for (to, pressure, ratio) in cases {
            let law = Law::<f64>::snow(LAME, SNOW);
            let mut l = [[all::<f64>(0.0); 3]; 3];
            (0..3).for_each(|k| l[k][k] = all::<f64>(to - 1.0));
            let (b, packed) = (congruence::<f64>(&l, &[all::<f64>(0.0); 6]), all::<f64>(law.start()));
            let (b, packed) = law.flow(&b, packed, &crate::law::Room::endless()).map_or((b, packed), |n| (n.b, n.past));
            let found = -one(law.stress(&b, packed, &[[all::<f64>(0.0); 3]; 3])[0]);
            println!("{to}: {found} Pa, J_p {}", one(packed));
            // Digits of the table.
            assert!((found / pressure - 1.0).abs() < 3e-5 && (one(packed) - ratio).abs() < 6e-6, "{found} at {to}");
        }
    }

    #[test]
    fn stress_of_the_series_is_that_of_the_eigenvalues() {
        let b = [0.03, -0.045, 0.01, 0.004, -0.012, 0.007].map(all::<f64>);
        let snow = Snow::<f64>::new(LAME, SNOW);
        let (beta, u) = eigen::<f64>(&b);
        let pressure = snow.pressure(&b);
        let mu = all::<f64>(2.0 * LAME.mu_pa);
        let exact = from_eigen::<f64>(&beta.map(|beta| mu * (beta - stretch::<f64>(beta)) + pressure), &u);
        for (a, e) in snow.stress(&b, all::<f64>(1.0)).iter().zip(exact) {
            // Roundings of a stress of 1e4 Pa.
            assert!((one(*a) - one(e)).abs() < 1e-9, "{a:?} instead of {e:?}");
        }
    }

    #[test]
    fn stretched_snow_breaks_and_softens() {
        let (stress, packed, lost) = squeezed(1.3, 1000);
        let elastic = 1.0 + SNOW[1];
        let h = (SNOW[2] * (1.0 - 1.3 / elastic)).exp();
        let wanted = h * elastic * (2.0 * LAME.mu_pa + LAME.lambda_pa) * SNOW[1];
        assert!((stress / wanted - 1.0).abs() < 1e-10 && packed > 1.29 && lost > 0.0, "{stress} of {wanted}");
    }
}
