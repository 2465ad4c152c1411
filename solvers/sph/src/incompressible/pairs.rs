//! Pairs stored in single precision for the many passes of a solution: of each pair that the kernel reaches its neighbour and
//! `t = 1 - r/2h`, 8 bytes. Gradient `∇W = s t³ (x_i - x_j)` and weight `W = α t⁴ (5 - 4t)` follow from it and the places,
//! which stay in the cache, in fewer cycles than it takes to read them from memory. What is exact, the impulses of the
//! pressures found, is computed anew in double precision.

use cosplat_core::boundary::Vec3;
use wide::{f32x4, f64x4, i32x4};

use crate::kernel::Kernel;
use crate::lanes::LANES;

/// Units of places in the kernel's reach: differences of places are exact, and rounded once, to the 24 bits of single
/// precision, as they are converted. They wrap around, so that only neighbours must be near, and may move apart to sixteen
/// times the reach.
const FINE: f64 = (1_u32 << 27) as f64;

/// Places in units of the kernel's reach, wrapped around; then nothing.
pub(crate) type Place = i32x4;

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

/// The kernel in those units.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Scale {
    fine: f64,
    slope: f64,
    alpha: f64,
}

impl Scale {
    /// Of a kernel.
    pub(crate) fn new(kernel: &Kernel) -> Self {
        Self { fine: FINE / kernel.reach, slope: kernel.slope * kernel.reach / FINE, alpha: kernel.alpha }
    }

    /// A place \[m\] in units.
    pub(crate) fn place(&self, x: Vec3) -> Place {
        let [x, y, z] = x.map(|x| (x * self.fine) as i64 as i32);
        i32x4::new([x, y, z, 0])
    }
}

impl Pairs {
    /// Forgets all, with room for `count` in whole groups.
    pub(crate) fn clear(&mut self, count: usize) {
        self.ends.clear();
        self.near.reserve_exact(count.saturating_sub(self.near.len()));
        self.near.resize(count, 0);
        self.inside.reserve_exact(count.saturating_sub(self.inside.len()));
        self.inside.resize(count, 0.0);
        self.count = 0;
    }

    /// Adds those of four to which the kernel reaches.
    #[inline]
    pub(crate) fn push(&mut self, near: &[u32], inside: f64x4) {
        for (&j, t) in near.iter().zip(inside.to_array()) {
            let t = t as f32;
            // Written wherever it ends, and kept only if it counts: a branch would be foretold badly.
            (self.near[self.count], self.inside[self.count]) = (j, t);
            self.count += usize::from(t > 0.0);
        }
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

impl Row<'_> {
    /// `Σ u_j ∇W_ij`, seen from a place.
    #[inline]
    pub(crate) fn along(&self, scale: &Scale, own: Place, places: &[Place], u: &[f32]) -> Vec3 {
        let mut sums = [f32x4::ZERO; 2];
        for (j, &t) in self.near.iter().zip(self.inside) {
            let t = f32x4::new(t);
            let factor = (t * t * t * f32x4::new(j.map(|j| u[j as usize]))).to_array();
            for l in 0..LANES {
                sums[l % 2] += f32x4::from_i32x4(own - places[j[l] as usize]) * f32x4::splat(factor[l]);
            }
        }
        let [x, y, z, _] = (sums[0] + sums[1]).to_array();
        [x, y, z].map(|a| scale.slope * f64::from(a))
    }

    /// `Σ m_j·∇W_ij` over the first three components of `m`, seen from a place.
    #[inline]
    pub(crate) fn across(&self, scale: &Scale, own: Place, places: &[Place], m: &[f32x4]) -> f64 {
        let mut sums = [f32x4::ZERO; 2];
        for (j, &t) in self.near.iter().zip(self.inside) {
            let t = f32x4::new(t);
            let factor = (t * t * t).to_array();
            for l in 0..LANES {
                let j = j[l] as usize;
                sums[l % 2] += f32x4::from_i32x4(own - places[j]) * m[j] * f32x4::splat(factor[l]);
            }
        }
        let [x, y, z, _] = (sums[0] + sums[1]).to_array().map(f64::from);
        scale.slope * (x + y + z)
    }

    /// `Σ u_j W_ij`.
    #[inline]
    pub(crate) fn over(&self, scale: &Scale, u: impl Fn(usize) -> f32) -> f64 {
        let mut sum = f32x4::ZERO;
        for (j, &t) in self.near.iter().zip(self.inside) {
            let t = f32x4::new(t);
            let (square, linear) = (t * t, f32x4::splat(5.0) - f32x4::splat(4.0) * t);
            sum += square * square * linear * f32x4::new(j.map(|j| u(j as usize)));
        }
        scale.alpha * sum.to_array().map(f64::from).iter().sum::<f64>()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use cosplat_core::boundary::{add, dot, norm, scale, sub};

    /// Sums over the stored pairs of the first of some places about `origin` \[m\], and the same in double precision.
    fn sums(origin: Vec3) -> [[f64; 5]; 2] {
        let kernel = Kernel::new(0.01).scaled();
        let near = |i: u32| [0.37, 0.61, 0.83].map(|a| 0.06 * ((f64::from(i) * a).fract() - 0.5));
        let all: Vec<Vec3> = (0..200).map(|i| add(origin, near(i))).collect();
        let (own, unit) = (all[0], Scale::new(&kernel));
        let places: Vec<Place> = all.iter().map(|&x| unit.place(x)).collect();
        let u = |j: usize| 1.0 + 0.01 * j as f64;
        let single: Vec<f32> = (0..all.len()).map(|j| u(j) as f32).collect();
        let flow: Vec<f32x4> = single.iter().map(|&u| f32x4::new([u, 2.0 * u, -u, 7.0])).collect();
        let (mut pairs, list) = (Pairs::default(), (1..all.len() as u32 - 3).collect::<Vec<_>>());
        pairs.clear(list.len());
        for j in list.chunks_exact(LANES) {
            let r = [0, 1, 2, 3].map(|l| norm(sub(own, all[j[l] as usize])));
            pairs.push(j, kernel.inside(f64x4::new(r)));
        }
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
        let [x, y, z] = row.along(&unit, places[0], &places, &single);
        let flows = row.across(&unit, places[0], &places, &flow);
        [[x, y, z, flows, row.over(&unit, |j| single[j])], [along[0], along[1], along[2], across, over]]
    }

    #[test]
    fn sums_over_pairs_are_those_of_the_kernel_wherever_the_places_are() {
        for origin in [[0.0; 3], [-1e4, 3.0, 1e5]] {
            let [found, exact] = sums(origin);
            println!("{found:?} of {exact:?}");
            // Rounding to 24 bits of some hundred terms, the largest of which are a tenth of the sums.
            assert!(found.iter().zip(&exact).all(|(a, b)| (a / b - 1.0).abs() < 1e-5), "{found:?} {exact:?}");
        }
    }
}
