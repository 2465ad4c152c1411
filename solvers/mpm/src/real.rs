//! Numbers: everything is written once for `f32` and `f64`, four particles or four components at a time.
//!
//! No operation here contracts `a * b + c` into one rounding, so results do not depend on the target's instructions.

use std::fmt::Debug;
use std::ops::{Add, AddAssign, Div, Mul, Neg, Sub, SubAssign};

use bytemuck::Pod;
use wide::{f32x4, f64x4};

/// A floating-point number and its four-lane type.
pub trait Real:
    Pod
    + Debug
    + Default
    + PartialOrd
    + Send
    + Sync
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
    + AddAssign
    + 'static
{
    /// Four of them.
    type V: Lanes<Self>;
    /// Relative size of half a unit in the last place.
    const HALF_ULP: f64;
    /// Terms of the series of `ln(1 + x)` for |x| ≤ 0.3, see [`crate::math::ln_1p`].
    const LOG_TERMS: usize;
    /// Terms of matrix series for norms up to 0.04: the first left out is below half a unit in the last place.
    const SERIES_TERMS: usize;
    /// Terms of the series of `exp(x) - 1` for |x| ≤ 0.3125.
    const EXP_TERMS: usize;
    /// Terms of the series of a matrix root for norms up to 0.1: the first left out is below half a unit.
    const ROOT_TERMS: usize;
    /// Jacobi sweeps to full accuracy of a 3×3 symmetric matrix (convergence is quadratic, then cubic).
    const JACOBI_SWEEPS: usize;
    /// Name of the precision.
    const NAME: &'static str;
    /// Nearest number of this type.
    #[must_use]
    fn of(value: f64) -> Self;
    /// Exact value.
    fn f64(self) -> f64;
    /// `ln(1 + x)` from a portable library.
    #[must_use]
    fn ln_1p(self) -> Self;
    /// `exp(x) - 1` from a portable library.
    #[must_use]
    fn exp_m1(self) -> Self;
    /// Square root, correctly rounded.
    #[must_use]
    fn sqrt(self) -> Self;
    /// Finite.
    fn finite(self) -> bool;
}

/// Four numbers at a time.
pub trait Lanes<R>:
    Pod
    + Debug
    + Default
    + Send
    + Sync
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
    + AddAssign
    + SubAssign
    + 'static
{
    /// The same number four times.
    fn splat(value: R) -> Self;
    /// From an array.
    fn from_array(values: [R; 4]) -> Self;
    /// To an array.
    fn array(self) -> [R; 4];
    /// Larger of each pair; the second where one is not a number.
    #[must_use]
    fn max(self, other: Self) -> Self;
    /// Smaller of each pair; the second where one is not a number.
    #[must_use]
    fn min(self, other: Self) -> Self;
    /// Magnitudes.
    #[must_use]
    fn abs(self) -> Self;
    /// Square roots.
    #[must_use]
    fn sqrt(self) -> Self;
    /// `if a < b { yes } else { no }`, each lane.
    #[must_use]
    fn if_less(a: Self, b: Self, yes: Self, no: Self) -> Self;
    /// Integer part of small positive numbers, as number and as index.
    fn whole(self) -> (Self, [u32; 4]);
    /// Rows to columns.
    fn transpose(rows: [Self; 4]) -> [Self; 4];
}

macro_rules! lanes {
    ($real:ty, $vector:ty) => {
        #[inline(always)]
        fn splat(value: $real) -> Self {
            <$vector>::splat(value)
        }
        #[inline(always)]
        fn from_array(values: [$real; 4]) -> Self {
            <$vector>::from(values)
        }
        #[inline(always)]
        fn array(self) -> [$real; 4] {
            self.to_array()
        }
        #[inline(always)]
        fn max(self, other: Self) -> Self {
            self.fast_max(other)
        }
        #[inline(always)]
        fn min(self, other: Self) -> Self {
            self.fast_min(other)
        }
        #[inline(always)]
        fn abs(self) -> Self {
            <$vector>::abs(self)
        }
        #[inline(always)]
        fn sqrt(self) -> Self {
            <$vector>::sqrt(self)
        }
        #[inline(always)]
        fn if_less(a: Self, b: Self, yes: Self, no: Self) -> Self {
            a.simd_lt(b).select(yes, no)
        }
        #[inline(always)]
        fn transpose(rows: [Self; 4]) -> [Self; 4] {
            <$vector>::transpose(rows)
        }
    };
}

#[expect(clippy::inline_always, reason = "the kernels must not call their arithmetic")]
impl Lanes<f32> for f32x4 {
    lanes!(f32, f32x4);
    #[inline(always)]
    fn whole(self) -> (Self, [u32; 4]) {
        let whole = self.fast_trunc_int();
        (Self::from_i32x4(whole), bytemuck::cast(whole))
    }
}

#[expect(clippy::inline_always, reason = "the kernels must not call their arithmetic")]
impl Lanes<f64> for f64x4 {
    lanes!(f64, f64x4);
    #[inline(always)]
    fn whole(self) -> (Self, [u32; 4]) {
        let whole = self.to_array().map(|x| x as u32);
        (Self::from(whole.map(f64::from)), whole)
    }
}

impl Real for f32 {
    type V = f32x4;
    const HALF_ULP: f64 = 5.960_464_477_539_063e-8;
    const LOG_TERMS: usize = 5;
    const SERIES_TERMS: usize = 5;
    const EXP_TERMS: usize = 7;
    const ROOT_TERMS: usize = 6;
    const JACOBI_SWEEPS: usize = 4;
    const NAME: &'static str = "f32";
    #[inline]
    fn of(value: f64) -> Self {
        value as Self
    }
    #[inline]
    fn f64(self) -> f64 {
        f64::from(self)
    }
    fn ln_1p(self) -> Self {
        libm::log1pf(self)
    }
    fn exp_m1(self) -> Self {
        libm::expm1f(self)
    }
    #[inline]
    fn sqrt(self) -> Self {
        Self::sqrt(self)
    }
    #[inline]
    fn finite(self) -> bool {
        self.is_finite()
    }
}

impl Real for f64 {
    type V = f64x4;
    const HALF_ULP: f64 = 1.110_223_024_625_156_5e-16;
    const LOG_TERMS: usize = 11;
    const SERIES_TERMS: usize = 12;
    const EXP_TERMS: usize = 12;
    const ROOT_TERMS: usize = 14;
    const JACOBI_SWEEPS: usize = 6;
    const NAME: &'static str = "f64";
    #[inline]
    fn of(value: f64) -> Self {
        value
    }
    #[inline]
    fn f64(self) -> f64 {
        self
    }
    fn ln_1p(self) -> Self {
        libm::log1p(self)
    }
    fn exp_m1(self) -> Self {
        libm::expm1(self)
    }
    #[inline]
    fn sqrt(self) -> Self {
        Self::sqrt(self)
    }
    #[inline]
    fn finite(self) -> bool {
        self.is_finite()
    }
}
