//! Stumpff functions: the forced oscillator `q'' + λ q = τ^k` from `λ = 0` to any `λ`, in one formula.
//!
//! `c_n(z) = Σ_j (-z)^j / (n + 2j)!`, so `c_0(ω²τ²) = cos ωτ` and `c_1(ω²τ²) = sin ωτ / ωτ`. With
//! `S_n(τ) = τ^n c_n(λ τ²)` one has `S_n' = S_{n-1}`, and the response to `τ^k / k!` from rest is `S_{k+2}`.
//! Source: Stiefel and Scheifele, "Linear and Regular Celestial Mechanics" (1971), §11.

/// Orders `n = 0..ORDERS` that are needed: 3 (degree of a path) + 2 (two integrations) + 1 (impulse) + 3 (moments) + 1.
pub(crate) const ORDERS: usize = 10;

/// Below this `z` the series is used for `n ≥ 2`. At the limit its largest term is below 1 (no cancellation), while the
/// recursion, which divides by `z` at every second order, no longer amplifies rounding above it.
const SERIES_LIMIT: f64 = 20.0;

/// Terms of the series: `20^16 / 34! < 1e-17`.
const TERMS: usize = 16;

/// `S_n(τ)` \[s^n\] for `n = 0..ORDERS`, for a mode of squared angular frequency `lambda` \[1/s²\].
pub(crate) fn stumpff(lambda: f64, tau: f64) -> [f64; ORDERS] {
    let z = lambda * tau * tau;
    let root = z.sqrt();
    let mut c = [0.0; ORDERS];
    c[0] = root.cos();
    c[1] = if root == 0.0 { 1.0 } else { root.sin() / root };
    // 1 / (n - 2)!
    let mut inverse_factorial = 1.0;
    for n in 2..ORDERS {
        c[n] = if z < SERIES_LIMIT {
            series(n, z) * inverse_factorial / (n * (n - 1)) as f64
        } else {
            (inverse_factorial - c[n - 2]) / z
        };
        inverse_factorial /= (n - 1) as f64;
    }
    let mut power = 1.0;
    c.map(|c| {
        let s = power * c;
        power *= tau;
        s
    })
}

/// `n! c_n(z)`, innermost bracket first.
fn series(n: usize, z: f64) -> f64 {
    (0..TERMS).rev().fold(1.0, |inner, j| {
        let m = n + 2 * j;
        1.0 - inner * z / ((m + 1) * (m + 2)) as f64
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn limits_are_powers_over_factorials() {
        let s = stumpff(0.0, 2.0);
        let mut expected = 1.0;
        for (n, value) in s.into_iter().enumerate() {
            assert!((value / expected - 1.0_f64).abs() < 1e-15, "n = {n}: {value} instead of {expected}");
            expected *= 2.0 / (n + 1) as f64;
        }
    }

    #[test]
    fn identity_holds_for_slow_and_fast_modes() {
        // S_n + λ S_{n+2} = τ^n / n!, the differential equation integrated n times.
        for lambda in [1e-12, 1e-3, 0.7, 19.0, 19.999_99, 20.000_01, 400.0, 1e6] {
            let tau = 1.0;
            let s = stumpff(lambda, tau);
            let mut expected = 1.0;
            for n in 0..ORDERS - 2 {
                let found = s[n] + lambda * s[n + 2];
                // Each side is a few roundings of numbers of this size.
                let scale = s[n].abs().max((lambda * s[n + 2]).abs()).max(expected);
                assert!((found - expected).abs() < 4e-16 * scale.max(1e-300) * 4.0, "λ = {lambda}, n = {n}");
                expected /= (n + 1) as f64;
            }
        }
    }

    #[test]
    fn series_and_recursion_meet() {
        let (below, above) = (stumpff(SERIES_LIMIT * (1.0 - 1e-15), 1.0), stumpff(SERIES_LIMIT, 1.0));
        for n in 0..ORDERS {
            assert!((below[n] / above[n] - 1.0).abs() < 1e-12, "n = {n}");
        }
    }
}
