//! What a particle feels of the liquid around it: sums over the pairs that two kinds of pressure share.
#![expect(clippy::inline_always, reason = "as said in `lanes`")]

use cosplat_core::boundary::{Vec3, add, scale};
use fearless_simd::{Simd, f64x4, prelude::*};

use crate::cohesion;
use crate::compress::Compression;
use crate::force::{Pass, drag};
use crate::kernel::Kernel;
use crate::lanes::{Four, LANES, Pack, Vec3x4, accumulate, gather, total, zero, zeros};
use crate::store::Store;

/// What a particle feels of the liquid around it: force, the viscous part of it \[N\] and power lost \[W\].
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Felt {
    pub(crate) force: Vec3,
    pub(crate) rubbed: Vec3,
    pub(crate) lost: f64,
}

/// Sums over the neighbours of a particle of what viscosity and cohesion do.
pub(crate) struct Rubs<'a, S: Simd> {
    pass: &'a Pass<'a>,
    store: &'a Store,
    body: usize,
    coheres: bool,
    /// Over its volume.
    rubbed: Vec3x4<S>,
    lost: f64x4<S>,
    pulled: Vec3x4<S>,
}

impl<'a, S: Simd> Rubs<'a, S> {
    /// Nothing yet.
    #[inline(always)]
    pub(crate) fn new(simd: S, pass: &'a Pass<'a>, store: &'a Store, own: &Pack, i: usize) -> Self {
        let body = pass.model.body[store.id[i] as usize] as usize;
        let coheres = pass.model.liquids[body].cohesion > 0.0 && own.volume > 0.0;
        Self { pass, store, body, coheres, rubbed: zeros(simd), lost: zero(simd), pulled: zeros(simd) }
    }

    /// Adds four, with `t = 1 - r/2h` and the slope of the kernel times their volumes.
    #[inline(always)]
    pub(crate) fn add(
        &mut self,
        kernel: &Kernel,
        others: &Four<S>,
        j: &[u32; LANES],
        (t, slope): (f64x4<S>, f64x4<S>),
    ) {
        let (approach, simd) = (others.approach(), slope.token());
        let viscosities = self.pass.viscosities(simd, self.store, self.body, j);
        let rub = slope * drag(kernel, viscosities, approach, others.square);
        self.lost -= rub * approach;
        accumulate(&mut self.rubbed, &others.apart, rub);
        if self.coheres {
            let pull = cohesion::pull(kernel, t) * self.pass.cohesions(simd, self.store, self.body, j);
            accumulate(&mut self.pulled, &others.apart, -pull);
        }
    }

    /// All of it, with a force of pressure \[N\] and for a volume \[m³\].
    #[inline(always)]
    pub(crate) fn felt(&self, pressed: Vec3, volume: f64) -> Felt {
        let rubbed = scale(gather(self.rubbed), volume);
        let force = add(add(pressed, rubbed), gather(self.pulled));
        Felt { force, rubbed, lost: 0.5 * volume * total(self.lost) }
    }
}

/// What knows or finds out what particles feel of the liquid.
pub(crate) trait Feels: Sync {
    /// What a particle feels of it.
    fn felt<S: Simd>(&self, simd: S, i: usize) -> Felt;
}

/// Sums over those in the kernel's reach, by the pressures in the packs.
pub(crate) struct Around<'a> {
    pub(crate) pass: &'a Pass<'a>,
    pub(crate) store: &'a Store,
    pub(crate) pack: &'a [Pack],
    pub(crate) compression: &'a Compression,
}

impl Feels for Around<'_> {
    #[inline(always)]
    fn felt<S: Simd>(&self, simd: S, i: usize) -> Felt {
        let (kernel, own) = (self.pass.model.kernel, &self.pack[i]);
        let mut rubs = Rubs::new(simd, self.pass, self.store, own, i);
        let mut force = zeros(simd);
        for (j, &[a, b, c, d]) in self.compression.close(i).groups() {
            let others = Four::new(simd, own, self.pack, j);
            let t = f64x4::load_array(simd, [f64::from(a), f64::from(b), f64::from(c), f64::from(d)]);
            let slope = kernel.slopes_at(t) * others.volume;
            rubs.add(&kernel, &others, j, (t, slope));
            accumulate(&mut force, &others.apart, -(slope * (own.pressure + others.pressure)));
        }
        rubs.felt(scale(gather(force), own.volume), own.volume)
    }
}
