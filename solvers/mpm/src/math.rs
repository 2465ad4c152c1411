//! Small symmetric matrices, four at a time: strain update, invariants, eigen-solve, logarithms.
//!
//! A symmetric matrix is `[xx, yy, zz, xy, xz, yz]`; a full one is rows `[[a; 3]; 3]`.

use crate::real::{Lanes, Real};

/// Symmetric 3×3, one in each lane.
pub(crate) type Sym<R> = [<R as Real>::V; 6];
/// Full 3×3, one in each lane, by rows.
pub(crate) type Full<R> = [[<R as Real>::V; 3]; 3];

/// `(I+L)(I+B)(I+L)ᵀ - I = L + Lᵀ + (L+G)Lᵀ + G` with `G = B + L B`: no small difference of large numbers.
#[inline]
pub(crate) fn congruence<R: Real>(l: &Full<R>, b: &Sym<R>) -> Sym<R> {
    let full = [[b[0], b[3], b[4]], [b[3], b[1], b[5]], [b[4], b[5], b[2]]];
    let mut g = full;
    for (row, l) in g.iter_mut().zip(l) {
        for (j, g) in row.iter_mut().enumerate() {
            *g += l[0] * full[0][j] + l[1] * full[1][j] + l[2] * full[2][j];
        }
    }
    // (L+G) Lᵀ
    let part = |i: usize, j: usize| {
        let product = (l[i][0] + g[i][0]) * l[j][0] + (l[i][1] + g[i][1]) * l[j][1] + (l[i][2] + g[i][2]) * l[j][2];
        (l[i][j] + l[j][i]) + product + g[i][j]
    };
    [part(0, 0), part(1, 1), part(2, 2), part(0, 1), part(0, 2), part(1, 2)]
}

/// `det(I + B) - 1 = tr B + I₂(B) + det B`.
#[inline]
pub(crate) fn det_minus_one<R: Real>(b: &Sym<R>) -> R::V {
    let [xx, yy, zz, xy, xz, yz] = *b;
    let second = xx * yy + xx * zz + yy * zz - xy * xy - xz * xz - yz * yz;
    let third = xx * (yy * zz - yz * yz) - xy * (xy * zz - yz * xz) + xz * (xy * yz - yy * xz);
    (xx + yy + zz) + second + third
}

/// `ln(1 + x)`: for |x| ≤ 0.3 the series `2 (s + s³/3 + s⁵/5 + …)` in `s = x / (2 + x)`, |s| < 0.18, beyond it the
/// library's, number by number. Truncation is below half a unit in the last place at both precisions.
#[inline]
pub(crate) fn ln_1p<R: Real>(x: R::V) -> R::V {
    let limit = R::of(0.3);
    let size = x.abs().array();
    if size.iter().any(|&a| a > limit || !a.finite()) {
        return R::V::from_array(x.array().map(R::ln_1p));
    }
    let s = x / (R::V::splat(R::of(2.0)) + x);
    let q = s * s;
    let mut sum = R::V::default();
    for k in (1..=R::LOG_TERMS).rev() {
        sum = (sum + R::V::splat(R::of(1.0 / (2 * k + 1) as f64))) * q;
    }
    (s + s * sum) * R::V::splat(R::of(2.0))
}

/// `exp(x) - 1`: for |x| ≤ 0.3125 its series, up to 10 that of `x / 32` doubled five times by
/// `e(2x) = e(x) (2 + e(x))`, beyond it the library's, number by number.
#[inline]
pub(crate) fn exp_m1<R: Real>(x: R::V) -> R::V {
    let size = x.abs().array();
    if size.iter().all(|&a| a <= R::of(0.3125)) {
        return exp_series::<R>(x);
    }
    if size.iter().any(|&a| a > R::of(10.0) || !a.finite()) {
        return R::V::from_array(x.array().map(R::exp_m1));
    }
    let two = all::<R>(2.0);
    (0..5).fold(exp_series::<R>(x * all::<R>(1.0 / 32.0)), |e, _| e * (two + e))
}

#[inline]
fn exp_series<R: Real>(x: R::V) -> R::V {
    let one = all::<R>(1.0);
    (2..=R::EXP_TERMS).rev().fold(one, |sum, k| one + sum * x * all::<R>(1.0 / k as f64)) * x
}

/// `det(I + L) - 1` of a full matrix.
#[inline]
pub(crate) fn full_det_minus_one<R: Real>(l: &Full<R>) -> R::V {
    let [[a, b, c], [d, e, f], [g, h, i]] = *l;
    let second = (a * e - b * d) + (a * i - c * g) + (e * i - f * h);
    let third = a * (e * i - f * h) - b * (d * i - f * g) + c * (d * h - e * g);
    (a + e + i) + second + third
}

/// Eigenvalues and eigenvectors (columns) of `B` by cyclic Jacobi rotations, without a branch.
///
/// Works on B itself, so small entries keep their relative accuracy. Source: Golub and Van Loan, "Matrix Computations",
/// §8.5; `t = 2 a / (d ± √(d² + 4 a²))` with the sign of `d = a_qq - a_pp`.
pub(crate) fn eigen<R: Real>(b: &Sym<R>) -> ([R::V; 3], Full<R>) {
    let (zero, one) = (R::V::default(), R::V::splat(R::of(1.0)));
    // Far below any strain that matters, far above where squares underflow.
    let tiny = R::V::splat(R::of(1e-18));
    let mut a = [[b[0], b[3], b[4]], [b[3], b[1], b[5]], [b[4], b[5], b[2]]];
    let mut u = [[one, zero, zero], [zero, one, zero], [zero, zero, one]];
    for _ in 0..R::JACOBI_SWEEPS {
        for (p, q, r) in [(0, 1, 2), (0, 2, 1), (1, 2, 0)] {
            let off = a[p][q];
            let d = a[q][q] - a[p][p];
            let twice = off + off;
            let root = (d * d + twice * twice).sqrt();
            let below = (d.abs() + root).max(tiny);
            let t = R::V::if_less(d, zero, -twice, twice) / below;
            let c = one / (one + t * t).sqrt();
            let s = t * c;
            a[p][p] -= t * off;
            a[q][q] += t * off;
            a[p][q] = zero;
            let (rp, rq) = (a[r.min(p)][r.max(p)], a[r.min(q)][r.max(q)]);
            a[r.min(p)][r.max(p)] = c * rp - s * rq;
            a[r.min(q)][r.max(q)] = s * rp + c * rq;
            for row in &mut u {
                let (up, uq) = (row[p], row[q]);
                row[p] = c * up - s * uq;
                row[q] = s * up + c * uq;
            }
        }
    }
    ([a[0][0], a[1][1], a[2][2]], u)
}

/// `U diag(d) Uᵀ`.
#[inline]
pub(crate) fn from_eigen<R: Real>(d: &[R::V; 3], u: &Full<R>) -> Sym<R> {
    let part = |i: usize, j: usize| u[i][0] * d[0] * u[j][0] + u[i][1] * d[1] * u[j][1] + u[i][2] * d[2] * u[j][2];
    [part(0, 0), part(1, 1), part(2, 2), part(0, 1), part(0, 2), part(1, 2)]
}

/// Norm of B up to which [`small_log`] and [`small_exp`] are as exact as the number type.
const SMALL: f64 = 0.04;

/// Product of two symmetric matrices that commute.
#[inline]
fn product<R: Real>(a: &Sym<R>, b: &Sym<R>) -> Sym<R> {
    let ([axx, ayy, azz, axy, axz, ayz], [bxx, byy, bzz, bxy, bxz, byz]) = (*a, *b);
    [
        axx * bxx + axy * bxy + axz * bxz,
        axy * bxy + ayy * byy + ayz * byz,
        axz * bxz + ayz * byz + azz * bzz,
        axx * bxy + axy * byy + axz * byz,
        axx * bxz + axy * byz + axz * bzz,
        axy * bxz + ayy * byz + ayz * bzz,
    ]
}

/// `B (c₁ + B (c₂ + …))` with the factors of a power series.
#[inline]
fn series<R: Real>(b: &Sym<R>, terms: usize, factor: impl Fn(usize) -> f64) -> Sym<R> {
    let last = all::<R>(factor(terms));
    let mut sum = [b[0] * last, b[1] * last, b[2] * last, b[3] * last, b[4] * last, b[5] * last];
    for k in (1..terms).rev() {
        let c = all::<R>(factor(k));
        sum = [sum[0] + c, sum[1] + c, sum[2] + c, sum[3], sum[4], sum[5]];
        sum = product::<R>(b, &sum);
    }
    sum
}

/// `ln(I + B) = B - B²/2 + B³/3 - …` where all four are small, else nothing.
#[inline]
pub(crate) fn small_log<R: Real>(b: &Sym<R>) -> Option<Sym<R>> {
    let limit = R::of(SMALL * SMALL);
    let size = square::<R>(b).array();
    size.iter()
        .all(|&s| s < limit)
        .then(|| series::<R>(b, R::SERIES_TERMS, |k| if k % 2 == 1 { 1.0 / k as f64 } else { -1.0 / k as f64 }))
}

/// `exp(A) - I = A + A²/2 + A³/6 + …` for small A.
#[inline]
pub(crate) fn small_exp<R: Real>(a: &Sym<R>) -> Sym<R> {
    series::<R>(a, R::SERIES_TERMS, |k| 1.0 / (1..=k).map(|i| i as f64).product::<f64>())
}

/// `√(I + B) - I = B/2 - B²/8 + B³/16 - …` where all four have a norm below 0.1, else nothing.
#[inline]
pub(crate) fn small_root<R: Real>(b: &Sym<R>) -> Option<Sym<R>> {
    let limit = R::of(0.01);
    // Binomial coefficients of 1/2: each is the one before times (3/2 - k)/k.
    let factor = |k: usize| (2..=k).fold(0.5, |c, k| c * (1.5 - k as f64) / k as f64);
    square::<R>(b).array().iter().all(|&s| s < limit).then(|| series::<R>(b, R::ROOT_TERMS, factor))
}

/// Frobenius norm, squared.
#[inline]
pub(crate) fn square<R: Real>(b: &Sym<R>) -> R::V {
    let off = b[3] * b[3] + b[4] * b[4] + b[5] * b[5];
    b[0] * b[0] + b[1] * b[1] + b[2] * b[2] + (off + off)
}

/// The same number in all four lanes.
#[inline]
pub(crate) fn all<R: Real>(value: f64) -> R::V {
    R::V::splat(R::of(value))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn eigen_solve_returns_the_matrix() {
        let entries = [0.3, -0.2, 1e-3, 0.05, -0.4, 0.02];
        let b: Sym<f64> = entries.map(all::<f64>);
        let (d, u) = eigen::<f64>(&b);
        for (found, wanted) in from_eigen::<f64>(&d, &u).iter().zip(entries) {
            assert!((found.to_array()[0] - wanted).abs() < 1e-15, "{found:?} instead of {wanted}");
        }
    }

    #[test]
    fn logarithm_is_that_of_the_library() {
        for i in -299..300 {
            let x = f64::from(i) * 1e-3;
            let found = ln_1p::<f64>(all::<f64>(x)).to_array()[0];
            assert!((found - x.ln_1p()).abs() <= 3e-16 * x.abs().max(1e-3), "{x}");
            let single = ln_1p::<f32>(all::<f32>(x)).to_array()[0];
            let exact = f64::from(x as f32).ln_1p();
            assert!((f64::from(single) - exact).abs() <= 2.5e-7 * exact.abs(), "{x}");
        }
    }

    #[test]
    fn exponential_is_that_of_the_library() {
        for i in -400..400 {
            let x = f64::from(i) * 0.029;
            let found = exp_m1::<f64>(all::<f64>(x)).to_array()[0];
            let exact = libm::expm1(x);
            // Five doublings, each with two roundings that the factors before carry on, relative to 1 below zero.
            assert!((found - exact).abs() <= 1e-14 * exact.abs(), "{x}: {found} instead of {exact}");
            let single = exp_m1::<f32>(all::<f32>(x)).to_array()[0];
            let exact = libm::expm1(f64::from(x as f32));
            assert!((f64::from(single) - exact).abs() <= 5e-6 * exact.abs(), "{x}: {single} instead of {exact}");
        }
    }

    #[test]
    fn small_series_agree_with_the_eigen_solve() {
        let entries = [0.02, -0.013, 1e-3, 0.005, -0.014, 0.002];
        let b: Sym<f64> = entries.map(all::<f64>);
        let (beta, u) = eigen::<f64>(&b);
        let exact = from_eigen::<f64>(&beta.map(ln_1p::<f64>), &u);
        let found = small_log::<f64>(&b).expect("small");
        for ((a, e), b) in found.iter().zip(exact).zip(small_exp::<f64>(&found).iter().zip(b)) {
            assert!((a.to_array()[0] - e.to_array()[0]).abs() < 1e-17, "{a:?} {e:?}");
            assert!((b.0.to_array()[0] - b.1.to_array()[0]).abs() < 1e-17, "{b:?}");
        }
    }

    #[test]
    fn a_rotation_leaves_no_strain() {
        // L of a finite rotation: R - I, exactly orthogonal up to rounding, so B stays at rounding size.
        let (s, c) = 0.3_f64.sin_cos();
        let l = [[c - 1.0, -s, 0.0], [s, c - 1.0, 0.0], [0.0; 3]].map(|row| row.map(all::<f64>));
        let b = congruence::<f64>(&l, &[all::<f64>(0.0); 6]);
        assert!(b.iter().all(|v| v.to_array()[0].abs() < 1e-16), "{b:?}");
    }
}
