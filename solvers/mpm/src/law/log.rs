//! Logarithmic strain `e = ln(1 + B) / 2` of four particles: by a series where all four are small, else by eigenvalues.

use crate::math::{Full, Sym, all, eigen, exp_m1, from_eigen, ln_1p, small_exp, small_log, square};
use crate::real::{Lanes, Real};

/// Twice the logarithmic strain.
pub(super) enum Log<R: Real> {
    /// The matrix.
    Small(Sym<R>),
    /// Principal values and axes.
    Principal([R::V; 3], Full<R>),
}

impl<R: Real> Log<R> {
    #[inline]
    pub(super) fn of(b: &Sym<R>) -> Self {
        if let Some(twice) = small_log::<R>(b) {
            return Self::Small(twice);
        }
        let (beta, u) = eigen::<R>(b);
        Self::Principal(beta.map(ln_1p::<R>), u)
    }

    /// `Σ e = ln J`.
    #[inline]
    pub(super) fn sum(&self) -> R::V {
        let (Self::Small([x, y, z, ..]) | Self::Principal([x, y, z], _)) = *self;
        (x + y + z) * all::<R>(0.5)
    }

    /// `|dev e|`.
    #[inline]
    pub(super) fn deviator(&self) -> R::V {
        let mean = self.sum() * all::<R>(2.0 / 3.0);
        let twice = match *self {
            Self::Small(t) => square::<R>(&[t[0] - mean, t[1] - mean, t[2] - mean, t[3], t[4], t[5]]),
            Self::Principal(t, _) => {
                let d = t.map(|t| t - mean);
                d[0] * d[0] + d[1] * d[1] + d[2] * d[2]
            }
        };
        twice.sqrt() * all::<R>(0.5)
    }

    /// `2 μ e + pressure I`.
    #[inline]
    pub(super) fn stress(&self, mu: R::V, pressure: R::V) -> Sym<R> {
        match self {
            Self::Small(t) => {
                [mu * t[0] + pressure, mu * t[1] + pressure, mu * t[2] + pressure, mu * t[3], mu * t[4], mu * t[5]]
            }
            Self::Principal(t, u) => from_eigen::<R>(&t.map(|t| mu * t + pressure), u),
        }
    }

    /// B of the strain with `keep` of the deviator and that sum.
    pub(super) fn returned(&self, keep: R::V, sum: R::V) -> Sym<R> {
        let (old, new) = (self.sum() * all::<R>(2.0 / 3.0), sum * all::<R>(2.0 / 3.0));
        match self {
            Self::Small(t) => {
                let on = |i: usize| (t[i] - old) * keep + new;
                small_exp::<R>(&[on(0), on(1), on(2), t[3] * keep, t[4] * keep, t[5] * keep])
            }
            Self::Principal(t, u) => from_eigen::<R>(&t.map(|t| exp_m1::<R>((t - old) * keep + new)), u),
        }
    }
}
