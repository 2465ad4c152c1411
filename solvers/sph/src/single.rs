//! Single precision, half of the memory and twice the lanes, for sums that need not balance to rounding.
//!
//! Places are whole numbers of a fine unit, so that differences are exact however far from the origin the liquid is, and
//! what is made of them is the same for both of a pair.
#![expect(clippy::inline_always, reason = "as said in `lanes`")]

use cosplat_core::boundary::Vec3;
use fearless_simd::{Simd, f32x4, f32x8, i32x8, prelude::*};

use crate::kernel::Kernel;

/// Units of places in the kernel's reach: differences of places are exact, and rounded once, to the 24 bits of single
/// precision, as they are converted. They wrap around, so that only neighbours must be near, and may move apart to sixteen
/// times the reach.
const FINE: f64 = (1_u32 << 27) as f64;

/// Places in units of the kernel's reach, wrapped around; then nothing.
pub(crate) type Place = [i32; 4];

/// The kernel in those units.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Scale {
    pub(crate) fine: f64,
    /// Of `W'(r)/r`, times a unit \[1/m⁴\], and of `W` \[1/m³\].
    pub(crate) slope: f64,
    pub(crate) alpha: f64,
}

impl Scale {
    /// Of a kernel.
    pub(crate) fn new(kernel: &Kernel) -> Self {
        Self { fine: FINE / kernel.reach, slope: kernel.slope * kernel.reach / FINE, alpha: kernel.alpha }
    }

    /// A place \[m\] in units.
    pub(crate) fn place(&self, x: Vec3) -> Place {
        let [x, y, z] = x.map(|x| (x * self.fine) as i64 as i32);
        [x, y, z, 0]
    }
}

/// What the sum for densities reads of a particle: half a line of the cache.
#[derive(Clone, Copy, Debug, Default)]
#[repr(align(32))]
pub(crate) struct Brief {
    /// Place in units, and the volume \[m³\].
    place: [i32; 3],
    volume: f32,
    /// Velocity \[m/s\] and density above that at rest \[kg/m³\].
    flow: [f32; 4],
}

/// Neighbours in a group.
pub(crate) const WIDE: usize = 8;

/// Eight of them, seen from one particle.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Eight<S: Simd> {
    /// Way from each to the particle, in units.
    apart: [f32x8<S>; 3],
    /// `1 - r/2h`, not below 0.
    pub(crate) inside: f32x8<S>,
    /// Velocity of the particle relative to each \[m/s\].
    relative: [f32x8<S>; 3],
    pub(crate) volume: f32x8<S>,
    pub(crate) excess: f32x8<S>,
}

impl Brief {
    /// At a place \[m\] with a volume \[m³\], velocity \[m/s\] and density above that at rest \[kg/m³\].
    pub(crate) fn new(scale: &Scale, x: Vec3, volume: f64, v: Vec3, excess: f64) -> Self {
        let [x, y, z, _] = scale.place(x);
        Self { place: [x, y, z], volume: volume as f32, flow: [v[0] as f32, v[1] as f32, v[2] as f32, excess as f32] }
    }

    /// Place and volume, as bits of which only the last are those of a number.
    #[inline(always)]
    fn place<S: Simd>(&self, simd: S) -> f32x4<S> {
        let [x, y, z] = self.place;
        let bits = |x: i32| f32::from_bits(x as u32);
        f32x4::load_array(simd, [bits(x), bits(y), bits(z), self.volume])
    }

    /// Velocity and density.
    #[inline(always)]
    fn flow<S: Simd>(&self, simd: S) -> f32x4<S> {
        f32x4::load_array_ref(simd, &self.flow)
    }
}

/// Way from one coordinate of places, as bits, to another, in units.
#[inline(always)]
fn apart<S: Simd>(own: i32x8<S>, others: f32x8<S>) -> f32x8<S> {
    (own - others.bitcast::<i32x8<S>>()).to_float()
}

/// Takes turns between two registers in each of their halves.
#[inline(always)]
fn zip<S: Simd>(a: f32x8<S>, b: f32x8<S>) -> [f32x8<S>; 2] {
    let ((a, c), (b, d)) = (a.split(), b.split());
    [a.zip_low(b).combine(c.zip_low(d)), a.zip_high(b).combine(c.zip_high(d))]
}

/// Columns of a matrix of eight rows, of which each register holds one and the fourth after it.
#[inline(always)]
fn columns<S: Simd>([a, b, c, d]: [f32x8<S>; 4]) -> [f32x8<S>; 4] {
    let ([first, third], [second, fourth]) = (zip(a, c), zip(b, d));
    let ([x, y], [z, w]) = (zip(first, second), zip(third, fourth));
    [x, y, z, w]
}

impl<S: Simd> Eight<S> {
    /// Those with the numbers `j`, seen from a place in units and a velocity \[m/s\].
    #[inline(always)]
    pub(crate) fn new(simd: S, place: &[i32x8<S>; 3], v: &[f32x8<S>; 3], all: &[Brief], j: &[u32; WIDE]) -> Self {
        let r = j.map(|j| &all[j as usize]);
        let [x, y, z, volume] = columns([
            r[0].place(simd).combine(r[4].place(simd)),
            r[1].place(simd).combine(r[5].place(simd)),
            r[2].place(simd).combine(r[6].place(simd)),
            r[3].place(simd).combine(r[7].place(simd)),
        ]);
        let [vx, vy, vz, excess] = columns([
            r[0].flow(simd).combine(r[4].flow(simd)),
            r[1].flow(simd).combine(r[5].flow(simd)),
            r[2].flow(simd).combine(r[6].flow(simd)),
            r[3].flow(simd).combine(r[7].flow(simd)),
        ]);
        let apart = [apart(place[0], x), apart(place[1], y), apart(place[2], z)];
        let square = apart[0] * apart[0] + apart[1] * apart[1] + apart[2] * apart[2];
        let inside = (1.0 - square.sqrt() * (1.0 / FINE) as f32).max(f32x8::splat(simd, 0.0));
        Self { apart, inside, relative: [v[0] - vx, v[1] - vy, v[2] - vz], volume, excess }
    }

    /// Velocity along the way between them, times its length in units.
    #[inline(always)]
    pub(crate) fn approach(&self) -> f32x8<S> {
        self.relative[0] * self.apart[0] + self.relative[1] * self.apart[1] + self.relative[2] * self.apart[2]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lanes::{Four, Pack};
    use fearless_simd::{Level, dispatch};

    fn some(i: u32, a: f64) -> f64 {
        (f64::from(i) * a).fract() - 0.5
    }

    /// `t`, approach \[m²/s\], volume and density of eight.
    fn eight<S: Simd>(simd: S, unit: &Scale, briefs: &[Brief]) -> [[f32; WIDE]; 4] {
        let [x, y, z] = briefs[8].place;
        let place = [i32x8::splat(simd, x), i32x8::splat(simd, y), i32x8::splat(simd, z)];
        let [u, v, w, _] = briefs[8].flow;
        let v = [f32x8::splat(simd, u), f32x8::splat(simd, v), f32x8::splat(simd, w)];
        let found = Eight::new(simd, &place, &v, briefs, &[6, 1, 2, 5, 4, 3, 0, 7]);
        let approach = found.approach() * (1.0 / unit.fine) as f32;
        [found.inside.to_array(), approach.to_array(), found.volume.to_array(), found.excess.to_array()]
    }

    fn four<S: Simd>(simd: S, kernel: &Kernel, own: &Pack, packs: &[Pack], j: &[u32; 4]) -> [[f64; 4]; 3] {
        let found = Four::new(simd, own, packs, j);
        [kernel.inside(found.r).to_array(), found.approach().to_array(), found.volume.to_array()]
    }

    #[test]
    fn eight_are_those_that_were_named_wherever_they_are_and_whatever_the_registers() {
        let kernel = Kernel::new(0.01);
        let unit = Scale::new(&kernel);
        for origin in [0.0, 1e4] {
            let pack = |i: u32| Pack {
                x: [0.37, 0.61, 0.83].map(|a| origin + 0.02 * some(i, a)),
                volume: 1e-6 * (1.0 + some(i, 0.11)),
                v: [0.23, 0.47, 0.71].map(|a| some(i, a)),
                pressure: 0.0,
            };
            let packs: Vec<Pack> = (0..9).map(pack).collect();
            let density = |i: usize| 3.0 * i as f64;
            let all = packs.iter().enumerate();
            let briefs: Vec<Brief> = all.map(|(i, p)| Brief::new(&unit, p.x, p.volume, p.v, density(i))).collect();
            let [narrow, wide] =
                [Level::baseline(), Level::new()].map(|level| dispatch!(level, simd => eight(simd, &unit, &briefs)));
            assert_eq!(narrow.map(|a| a.map(f32::to_bits)), wide.map(|a| a.map(f32::to_bits)));
            for (half, j) in [[6, 1, 2, 5], [4, 3, 0, 7]].iter().enumerate() {
                let exact = dispatch!(Level::new(), simd => four(simd, &kernel, &packs[8], &packs, j));
                for (lane, &j) in j.iter().enumerate() {
                    let at = 4 * half + lane;
                    // Places to 2^-27 of the reach, and some roundings to 24 bits of what is at most one.
                    for (found, exact) in narrow[..3].iter().zip(exact).map(|(f, e)| (f64::from(f[at]), e[lane])) {
                        assert!((found - exact).abs() < 1e-6 * exact.abs().max(1e-2), "{found} of {exact}");
                    }
                    assert_eq!(narrow[3][at].to_bits(), (density(j as usize) as f32).to_bits());
                }
            }
        }
    }
}
