//! Four neighbours at a time.

use cosplat_core::boundary::Vec3;
use wide::f64x4;

use crate::kernel::Kernel;

/// Neighbours in a group: lists are filled up to it with a place that has no volume.
pub(crate) const LANES: usize = 4;

/// What others read of a particle or boundary particle: one line of the cache.
#[derive(Clone, Copy, Debug, Default)]
#[repr(align(64))]
pub(crate) struct Pack {
    /// Position \[m\], volume \[m³\], velocity \[m/s\] and pressure \[Pa\].
    pub(crate) x: Vec3,
    pub(crate) volume: f64,
    pub(crate) v: Vec3,
    pub(crate) pressure: f64,
}

/// Four of them, seen from one particle.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Four {
    /// Way from each to the particle \[m\], and its square.
    pub(crate) apart: [f64x4; 3],
    pub(crate) square: f64x4,
    /// Distance \[m\].
    pub(crate) r: f64x4,
    /// Velocity of the particle relative to each \[m/s\].
    pub(crate) relative: [f64x4; 3],
    pub(crate) volume: f64x4,
    pub(crate) pressure: f64x4,
}

impl Four {
    /// Those with the numbers `j`, of which there are four, seen from `own`.
    #[inline(always)]
    #[expect(clippy::inline_always, reason = "a call for every group of pairs costs a tenth of a pass")]
    pub(crate) fn new(own: &Pack, pack: &[Pack], j: &[u32]) -> Self {
        // Written out: a map over an array is not always inlined.
        let at = |k: usize| &pack[j[k] as usize];
        let (a, b, c, d) = (at(0), at(1), at(2), at(3));
        let lanes = |f: &dyn Fn(&Pack) -> f64| f64x4::new([f(a), f(b), f(c), f(d)]);
        let apart = [0, 1, 2].map(|k| f64x4::splat(own.x[k]) - f64x4::new([a.x[k], b.x[k], c.x[k], d.x[k]]));
        let relative = [0, 1, 2].map(|k| f64x4::splat(own.v[k]) - f64x4::new([a.v[k], b.v[k], c.v[k], d.v[k]]));
        let square = apart[0] * apart[0] + apart[1] * apart[1] + apart[2] * apart[2];
        let (volume, pressure) = (lanes(&|p| p.volume), lanes(&|p| p.pressure));
        Self { apart, square, r: square.sqrt(), relative, volume, pressure }
    }

    /// Velocity along the way between them, times its length \[m²/s\].
    #[inline]
    pub(crate) fn approach(&self) -> f64x4 {
        self.relative[0] * self.apart[0] + self.relative[1] * self.apart[1] + self.relative[2] * self.apart[2]
    }
}

impl Kernel {
    /// `W'(r)/r` of four \[1/m⁵\].
    #[inline]
    pub(crate) fn slopes(&self, r: f64x4) -> f64x4 {
        let t = self.inside(r);
        f64x4::splat(self.slope) * (t * t * t)
    }

    /// `W(r)` of four \[1/m³\].
    #[inline]
    pub(crate) fn weights(&self, r: f64x4) -> f64x4 {
        let t = self.inside(r);
        let square = t * t;
        f64x4::splat(self.alpha) * square * square * (f64x4::splat(5.0) - f64x4::splat(4.0) * t)
    }

    #[inline]
    pub(crate) fn inside(&self, r: f64x4) -> f64x4 {
        (f64x4::ONE - r * f64x4::splat(self.half_inverse)).fast_max(f64x4::ZERO)
    }
}

/// Adds four vectors.
#[inline]
pub(crate) fn gather(sum: [f64x4; 3]) -> Vec3 {
    // Written out: a map over an array is not always inlined.
    [sum[0].reduce_add(), sum[1].reduce_add(), sum[2].reduce_add()]
}
