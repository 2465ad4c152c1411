//! The liquid as boundary particles see it: sums over what is near one.
#![expect(clippy::inline_always, reason = "as said in `lanes`")]

use cosplat_core::boundary::{Vec3, scale};
use fearless_simd::{Simd, f64x4, prelude::*};

use crate::force::drag;
use crate::lanes::{Four, Pack, accumulate, along_one, gather, groups, total, zero, zeros};
use crate::model::Model;
use crate::wall::Piece;

/// What boundary particles see of the liquid.
pub(crate) struct Liquids<'a> {
    pub(crate) model: &'a Model,
    pub(crate) pack: &'a [Pack],
    /// Gravity of each body \[m/s²\].
    pub(crate) gravity: &'a [Vec3],
    pub(crate) parallel: bool,
}

/// What the liquid around a place is like: sums over it, weighed by the kernel.
pub(crate) struct Means {
    pub(crate) sum: f64,
    /// Pressure, with the weight of what lies between \[Pa\], velocity \[m/s\] and way \[m\] to the place.
    pub(crate) pressure: f64,
    pub(crate) velocity: Vec3,
    pub(crate) way: Vec3,
}

impl Liquids<'_> {
    /// What the liquid `near` a place is like, where it weighs `g` \[N/m³\]; velocities are relative to its own.
    #[inline(always)]
    pub(crate) fn means<S: Simd>(&self, simd: S, own: &Pack, g: Vec3, near: &[u32]) -> Means {
        let (mut sum, mut pressure) = (zero(simd), zero(simd));
        let (mut velocity, mut way) = (zeros(simd), zeros(simd));
        for i in groups(near) {
            let others = Four::new(simd, own, self.pack, i);
            let weight = others.volume * self.model.kernel.weights(others.r);
            sum += weight;
            pressure += weight * (others.pressure + along_one(&others.apart, g));
            accumulate(&mut velocity, &others.relative, -weight);
            accumulate(&mut way, &others.apart, weight);
        }
        Means { sum: total(sum), pressure: total(pressure), velocity: gather(velocity), way: gather(way) }
    }

    /// Impulse of a boundary particle, seen as `own`, on the liquid `near` it, which gains such velocities over `dt` \[s\].
    #[inline(always)]
    pub(crate) fn push<S: Simd>(
        &self,
        simd: S,
        piece: &mut Piece,
        own: &Pack,
        viscosity: f64,
        near: &[u32],
        (acceleration, dt): (&[Vec3], f64),
    ) {
        let kernel = self.model.kernel;
        let (mut sum, mut rubbed, mut work) = (zeros(simd), zeros(simd), zero(simd));
        for i in groups(near) {
            let others = Four::new(simd, own, self.pack, i);
            let slope = kernel.slopes(others.r) * (others.volume * own.volume);
            let shear = drag(&kernel, f64x4::splat(simd, viscosity), others.approach(), others.square);
            let along = slope * (own.pressure + others.pressure - shear);
            accumulate(&mut sum, &others.apart, along);
            accumulate(&mut rubbed, &others.apart, -(slope * shear));
            let gained = |k: usize, l: usize| 0.5 * dt * acceleration.get(i[l] as usize).map_or(0.0, |a| a[k]);
            for k in 0..3 {
                let gained = f64x4::load_array(simd, [gained(k, 0), gained(k, 1), gained(k, 2), gained(k, 3)]);
                work += others.apart[k] * along * (own.v[k] - others.relative[k] + gained);
            }
        }
        piece.impulse = scale(gather(sum), dt);
        piece.rubbed = scale(gather(rubbed), dt);
        piece.work = total(work) * dt;
    }
}
