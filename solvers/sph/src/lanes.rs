//! Four neighbours at a time, in registers as wide as the processor has.
//!
//! Whatever that width is, each lane takes the same steps and lanes are added in the same order, so that the bytes do not
//! depend on the processor. What takes a token `S` must become part of the function that was dispatched for it: it is
//! inlined always, and its closures, which are not always, compute with lanes only where they are called from one place.
#![expect(clippy::inline_always, reason = "a call would be compiled for the narrowest registers")]

use cosplat_core::boundary::Vec3;
use fearless_simd::{Simd, f64x2, f64x4, prelude::*};

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

/// Three components of four.
pub(crate) type Vec3x4<S> = [f64x4<S>; 3];

/// Four of them, seen from one particle.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Four<S: Simd> {
    /// Way from each to the particle \[m\], and its square.
    pub(crate) apart: Vec3x4<S>,
    pub(crate) square: f64x4<S>,
    /// Distance \[m\].
    pub(crate) r: f64x4<S>,
    /// Velocity of the particle relative to each \[m/s\].
    pub(crate) relative: Vec3x4<S>,
    pub(crate) volume: f64x4<S>,
    pub(crate) pressure: f64x4<S>,
}

/// Whole groups of a list.
#[inline(always)]
pub(crate) fn groups(list: &[u32]) -> &[[u32; LANES]] {
    list.as_chunks().0
}

/// First and second column of four rows of two.
#[inline(always)]
fn columns<S: Simd>(simd: S, [a, b, c, d]: [[f64; 2]; LANES]) -> (f64x4<S>, f64x4<S>) {
    let (a, b) = (f64x2::load_array(simd, a), f64x2::load_array(simd, b));
    let (c, d) = (f64x2::load_array(simd, c), f64x2::load_array(simd, d));
    (a.zip_low(b).combine(c.zip_low(d)), a.zip_high(b).combine(c.zip_high(d)))
}

impl<S: Simd> Four<S> {
    /// Those with the numbers `j`, seen from `own`.
    #[inline(always)]
    pub(crate) fn new(simd: S, own: &Pack, pack: &[Pack], j: &[u32; LANES]) -> Self {
        let (a, b) = (&pack[j[0] as usize], &pack[j[1] as usize]);
        let (c, d) = (&pack[j[2] as usize], &pack[j[3] as usize]);
        let (x, y) = columns(simd, [[a.x[0], a.x[1]], [b.x[0], b.x[1]], [c.x[0], c.x[1]], [d.x[0], d.x[1]]]);
        let (z, volume) =
            columns(simd, [[a.x[2], a.volume], [b.x[2], b.volume], [c.x[2], c.volume], [d.x[2], d.volume]]);
        let (u, v) = columns(simd, [[a.v[0], a.v[1]], [b.v[0], b.v[1]], [c.v[0], c.v[1]], [d.v[0], d.v[1]]]);
        let (w, pressure) =
            columns(simd, [[a.v[2], a.pressure], [b.v[2], b.pressure], [c.v[2], c.pressure], [d.v[2], d.pressure]]);
        let apart = [own.x[0] - x, own.x[1] - y, own.x[2] - z];
        let relative = [own.v[0] - u, own.v[1] - v, own.v[2] - w];
        let square = along(&apart, &apart);
        Self { apart, square, r: square.sqrt(), relative, volume, pressure }
    }

    /// Velocity along the way between them, times its length \[m²/s\].
    #[inline(always)]
    pub(crate) fn approach(&self) -> f64x4<S> {
        along(&self.relative, &self.apart)
    }
}

impl Kernel {
    /// `W'(r)/r` of four \[1/m⁵\].
    #[inline(always)]
    pub(crate) fn slopes<S: Simd>(&self, r: f64x4<S>) -> f64x4<S> {
        self.slopes_at(self.inside(r))
    }

    /// The same by `t = 1 - r/2h`.
    #[inline(always)]
    pub(crate) fn slopes_at<S: Simd>(&self, t: f64x4<S>) -> f64x4<S> {
        self.slope * (t * t * t)
    }

    /// `W(r)` of four \[1/m³\].
    #[inline(always)]
    pub(crate) fn weights<S: Simd>(&self, r: f64x4<S>) -> f64x4<S> {
        self.weights_at(self.inside(r))
    }

    /// The same by `t = 1 - r/2h`.
    #[inline(always)]
    pub(crate) fn weights_at<S: Simd>(&self, t: f64x4<S>) -> f64x4<S> {
        let square = t * t;
        self.alpha * square * square * (5.0 - 4.0 * t)
    }

    /// `1 - r/2h` of four, not below 0; of a distance that is not a number nothing or not a number, as processors differ.
    #[inline(always)]
    pub(crate) fn inside<S: Simd>(&self, r: f64x4<S>) -> f64x4<S> {
        (1.0 - r * self.half_inverse).max(zero(r.token()))
    }
}

/// Nothing.
#[inline(always)]
pub(crate) fn zero<S: Simd>(simd: S) -> f64x4<S> {
    f64x4::splat(simd, 0.0)
}

/// No vector.
#[inline(always)]
pub(crate) fn zeros<S: Simd>(simd: S) -> Vec3x4<S> {
    [zero(simd); 3]
}

/// Scalar products of four.
#[inline(always)]
pub(crate) fn along<S: Simd>(a: &Vec3x4<S>, b: &Vec3x4<S>) -> f64x4<S> {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// The same with one vector.
#[inline(always)]
pub(crate) fn along_one<S: Simd>(a: &Vec3x4<S>, b: Vec3) -> f64x4<S> {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// Adds four vectors times factors.
#[inline(always)]
pub(crate) fn accumulate<S: Simd>(sum: &mut Vec3x4<S>, vectors: &Vec3x4<S>, factors: f64x4<S>) {
    sum[0] += vectors[0] * factors;
    sum[1] += vectors[1] * factors;
    sum[2] += vectors[2] * factors;
}

/// Sum of four.
#[inline(always)]
pub(crate) fn total<S: Simd>(four: f64x4<S>) -> f64 {
    let (first, second) = four.split();
    let [a, b] = (first + second).to_array();
    a + b
}

/// Sum of four vectors.
#[inline(always)]
pub(crate) fn gather<S: Simd>(sum: Vec3x4<S>) -> Vec3 {
    [total(sum[0]), total(sum[1]), total(sum[2])]
}

#[cfg(test)]
mod tests {
    use super::*;
    use fearless_simd::{Level, dispatch};

    /// What a pass makes of a few particles, as bits.
    fn sums<S: Simd>(simd: S, pack: &[Pack]) -> Vec<u64> {
        let kernel = Kernel::new(0.01);
        let list: Vec<u32> = (0..pack.len() as u32).collect();
        let (mut force, mut weight, mut rate) = (zeros(simd), zero(simd), zero(simd));
        for j in groups(&list) {
            let others = Four::new(simd, &pack[1], pack, j);
            weight += kernel.weights(others.r) * others.volume;
            rate += along_one(&others.relative, [0.1, -0.3, 0.7]) / (others.square + 1e-4);
            accumulate(&mut force, &others.apart, kernel.slopes(others.r) * (others.pressure + others.approach()));
        }
        gather(force).into_iter().chain([total(weight), total(rate)]).map(f64::to_bits).collect()
    }

    #[test]
    fn the_widest_registers_make_the_same_bytes_as_the_narrowest() {
        let some = |i: u32, a: f64| 0.03 * ((f64::from(i) * a).fract() - 0.5);
        let pack: Vec<Pack> = (0..64)
            .map(|i| Pack {
                x: [some(i, 0.37), some(i, 0.61), some(i, 0.83)],
                volume: 1e-6 + some(i, 0.11),
                v: [some(i, 0.23), some(i, 0.47), some(i, 0.71)],
                pressure: some(i, 0.91),
            })
            .collect();
        let [narrow, wide] = [Level::baseline(), Level::new()].map(|level| dispatch!(level, simd => sums(simd, &pack)));
        println!("{:?} {narrow:?}", Level::new());
        assert_eq!(narrow, wide);
    }
}
