//! Pairs stored in single precision: of each pair that the kernel reaches its neighbour and `t = 1 - r/2h`, 8 bytes. Gradient
//! `∇W = s t³ (x_i - x_j)` and weight `W = α t⁴ (5 - 4t)` follow from it and the places, which stay in the cache.
//!
//! In the many passes of an incompressible solution that takes fewer cycles than to read gradients from memory; what is exact,
//! the impulses of the pressures found, is computed anew in double precision. Forces of a weakly compressible liquid save the
//! roots: as both of a pair have the same `t`, rounding it takes nothing from what balances.
#![expect(clippy::inline_always, reason = "as said in `lanes`")]

use cosplat_core::boundary::Vec3;
use fearless_simd::{Simd, f32x4, f32x8, f64x4, i32x4, prelude::*, u32x4, u32x8};

use crate::lanes::LANES;
use crate::single::{Place, Scale, WIDE};

/// Pairs of a chunk, row by row.
#[derive(Clone, Debug, Default)]
pub(crate) struct Pairs {
    ends: Vec<u32>,
    near: Vec<u32>,
    inside: Vec<f32>,
    /// How many of them are pairs.
    count: usize,
}

/// Pairs of one particle.
#[derive(Clone, Copy)]
pub(crate) struct Row<'a> {
    near: &'a [[u32; LANES]],
    inside: &'a [[f32; LANES]],
}

impl Pairs {
    /// Forgets all, with room for `count` in whole groups.
    pub(crate) fn clear(&mut self, count: usize) {
        // Whole groups are written, of which not all may be kept.
        let count = count + WIDE;
        self.ends.clear();
        self.near.reserve_exact(count.saturating_sub(self.near.len()));
        self.near.resize(count, 0);
        self.inside.reserve_exact(count.saturating_sub(self.inside.len()));
        self.inside.resize(count, 0.0);
        self.count = 0;
    }

    /// Adds those of four to which the kernel reaches.
    #[inline(always)]
    pub(crate) fn push<S: Simd>(&mut self, near: &[u32; LANES], inside: f64x4<S>) {
        let simd = inside.token();
        let [a, b, c, d] = inside.to_array();
        let inside = f32x4::load_array(simd, [a as f32, b as f32, c as f32, d as f32]);
        let counts = inside.simd_gt(0.0);
        let (here, near) = (self.count..self.count + LANES, u32x4::load_array_ref(simd, near));
        // All are written, and those beyond the ones that count written over: a branch would be foretold badly.
        near.compress(counts).store_slice(&mut self.near[here.clone()]);
        inside.compress(counts).store_slice(&mut self.inside[here]);
        self.count += counts.to_bitmask().count_ones() as usize;
    }

    /// The same with eight.
    #[inline(always)]
    pub(crate) fn push_eight<S: Simd>(&mut self, near: &[u32; WIDE], inside: f32x8<S>) {
        let counts = inside.simd_gt(0.0);
        let (here, near) = (self.count..self.count + WIDE, u32x8::load_array_ref(inside.token(), near));
        near.compress(counts).store_slice(&mut self.near[here.clone()]);
        inside.compress(counts).store_slice(&mut self.inside[here]);
        self.count += counts.to_bitmask().count_ones() as usize;
    }

    /// Ends the row, filled up with `nobody` to whole groups.
    #[inline]
    pub(crate) fn end(&mut self, nobody: usize) {
        let full = self.count.next_multiple_of(LANES);
        self.near[self.count..full].fill(nobody as u32);
        self.inside[self.count..full].fill(0.0);
        self.count = full;
        self.ends.push(full as u32);
    }

    /// A row.
    #[inline]
    pub(crate) fn row(&self, k: usize) -> Row<'_> {
        let range = if k == 0 { 0 } else { self.ends[k - 1] as usize }..self.ends[k] as usize;
        Row { near: self.near[range.clone()].as_chunks().0, inside: self.inside[range].as_chunks().0 }
    }
}

impl<'a> Row<'a> {
    /// Neighbours in groups, and `t` of each.
    #[inline(always)]
    pub(crate) fn groups(&self) -> impl Iterator<Item = (&'a [u32; LANES], &'a [f32; LANES])> + use<'a> {
        self.near.iter().zip(self.inside)
    }

    /// `Σ u_j ∇W_ij`, seen from a place.
    #[inline(always)]
    pub(crate) fn along<S: Simd>(&self, simd: S, scale: &Scale, own: Place, places: &[Place], u: &[f32]) -> Vec3 {
        let own = i32x4::load_array(simd, own);
        let mut sums = [f32x4::splat(simd, 0.0); 2];
        for (j, &t) in self.near.iter().zip(self.inside) {
            let t = f32x4::load_array(simd, t);
            let factor = (t * t * t * f32x4::load_array(simd, j.map(|j| u[j as usize]))).to_array();
            for l in 0..LANES {
                sums[l % 2] += apart(own, &places[j[l] as usize]) * factor[l];
            }
        }
        let [x, y, z, _] = (sums[0] + sums[1]).to_array();
        [x, y, z].map(|a| scale.slope * f64::from(a))
    }

    /// `Σ m_j·∇W_ij` over the first three components of `m`, seen from a place.
    #[inline(always)]
    pub(crate) fn across<S: Simd>(&self, simd: S, scale: &Scale, own: Place, places: &[Place], m: &[[f32; 4]]) -> f64 {
        let own = i32x4::load_array(simd, own);
        let mut sums = [f32x4::splat(simd, 0.0); 2];
        for (j, &t) in self.near.iter().zip(self.inside) {
            let t = f32x4::load_array(simd, t);
            let factor = (t * t * t).to_array();
            for l in 0..LANES {
                let j = j[l] as usize;
                sums[l % 2] += apart(own, &places[j]) * f32x4::load_array_ref(simd, &m[j]) * factor[l];
            }
        }
        let [x, y, z, _] = (sums[0] + sums[1]).to_array().map(f64::from);
        scale.slope * (x + y + z)
    }

    /// `Σ u_j W_ij`.
    #[inline(always)]
    pub(crate) fn over<S: Simd>(&self, simd: S, scale: &Scale, u: impl Fn(usize) -> f32) -> f64 {
        let mut sum = f32x4::splat(simd, 0.0);
        for (j, &t) in self.near.iter().zip(self.inside) {
            let t = f32x4::load_array(simd, t);
            let (square, linear) = (t * t, 5.0 - 4.0 * t);
            sum += square * square * linear * f32x4::load_array(simd, j.map(|j| u(j as usize)));
        }
        scale.alpha * sum.to_array().map(f64::from).iter().sum::<f64>()
    }
}

/// Way from a place to the own one, in units.
#[inline(always)]
fn apart<S: Simd>(own: i32x4<S>, other: &Place) -> f32x4<S> {
    (own - i32x4::load_array_ref(own.token(), other)).to_float()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kernel::Kernel;
    use cosplat_core::boundary::{add, dot, norm, scale, sub};
    use fearless_simd::{Level, dispatch};

    /// Sums over the stored pairs of the first of some places about `origin` \[m\], and the same in double precision.
    fn sums(level: Level, origin: Vec3) -> [[f64; 5]; 2] {
        let kernel = Kernel::new(0.01).scaled();
        let near = |i: u32| [0.37, 0.61, 0.83].map(|a| 0.06 * ((f64::from(i) * a).fract() - 0.5));
        let all: Vec<Vec3> = (0..200).map(|i| add(origin, near(i))).collect();
        let (own, unit) = (all[0], Scale::new(&kernel));
        let places: Vec<Place> = all.iter().map(|&x| unit.place(x)).collect();
        let u = |j: usize| 1.0 + 0.01 * j as f64;
        let single: Vec<f32> = (0..all.len()).map(|j| u(j) as f32).collect();
        let flow: Vec<[f32; 4]> = single.iter().map(|&u| [u, 2.0 * u, -u, 7.0]).collect();
        let (mut pairs, list) = (Pairs::default(), (1..all.len() as u32 - 7).collect::<Vec<_>>());
        pairs.clear(list.len());
        let inside = |j: u32| 1.0 - norm(sub(own, all[j as usize])) * kernel.half_inverse;
        // Both ways: a third of them in fours, the others in eights.
        let (fours, eights) = list.split_at(list.len() / 24 * 8);
        dispatch!(level, simd => {
            for j in fours.as_chunks().0 {
                pairs.push(j, f64x4::load_array(simd, j.map(|j| inside(j).max(0.0))));
            }
            for j in eights.as_chunks().0 {
                pairs.push_eight(j, f32x8::load_array(simd, j.map(|j| inside(j).max(0.0) as f32)));
            }
        });
        pairs.end(all.len() - 1);
        let (mut along, mut across, mut over) = ([0.0; 3], 0.0, 0.0);
        for &j in &list {
            let (apart, u) = (sub(own, all[j as usize]), u(j as usize));
            let gradient = scale(apart, kernel.slope(norm(apart)));
            along = add(along, scale(gradient, u));
            across += dot(gradient, scale([1.0, 2.0, -1.0], u));
            over += u * kernel.weight(norm(apart));
        }
        let row = pairs.row(0);
        let [x, y, z] = dispatch!(level, simd => row.along(simd, &unit, places[0], &places, &single));
        let flows = dispatch!(level, simd => row.across(simd, &unit, places[0], &places, &flow));
        let weighed = dispatch!(level, simd => row.over(simd, &unit, |j| single[j]));
        [[x, y, z, flows, weighed], [along[0], along[1], along[2], across, over]]
    }

    #[test]
    fn sums_over_pairs_are_those_of_the_kernel_wherever_the_places_are() {
        for origin in [[0.0; 3], [-1e4, 3.0, 1e5]] {
            let [found, exact] = sums(Level::new(), origin);
            let [narrow, _] = sums(Level::baseline(), origin);
            assert_eq!(found.map(f64::to_bits), narrow.map(f64::to_bits), "whatever the registers");
            println!("{found:?} of {exact:?}");
            // Rounding to 24 bits of some hundred terms, the largest of which are a tenth of the sums.
            assert!(found.iter().zip(&exact).all(|(a, b)| (a / b - 1.0).abs() < 1e-5), "{found:?} {exact:?}");
        }
    }
}
