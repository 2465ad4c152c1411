//! What a particle feels of the liquid around it: sums over the pairs that two kinds of pressure share.

use cosplat_core::boundary::{Vec3, add, scale};
use wide::f64x4;

use crate::cohesion;
use crate::force::{Pass, drag};
use crate::kernel::Kernel;
use crate::lanes::{Four, LANES, Pack, gather};
use crate::near::CHUNK;
use crate::store::Store;

/// What a particle feels of the liquid around it: force, the viscous part of it \[N\] and power lost \[W\].
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Felt {
    pub(crate) force: Vec3,
    pub(crate) rubbed: Vec3,
    pub(crate) lost: f64,
}

/// Sums over the neighbours of a particle of what viscosity and cohesion do.
pub(crate) struct Rubs<'a> {
    pass: &'a Pass<'a>,
    store: &'a Store,
    body: usize,
    coheres: bool,
    /// Over its volume.
    rubbed: [f64x4; 3],
    lost: f64x4,
    pulled: [f64x4; 3],
}

impl<'a> Rubs<'a> {
    /// Nothing yet.
    #[inline]
    pub(crate) fn new(pass: &'a Pass<'a>, store: &'a Store, own: &Pack, i: usize) -> Self {
        let body = pass.model.body[store.id[i] as usize] as usize;
        let coheres = pass.model.liquids[body].cohesion > 0.0 && own.volume > 0.0;
        let zero = [f64x4::ZERO; 3];
        Self { pass, store, body, coheres, rubbed: zero, lost: f64x4::ZERO, pulled: zero }
    }

    /// Adds four, with the slope of the kernel times their volumes.
    #[inline(always)]
    #[expect(clippy::inline_always, reason = "a call for every group of pairs costs a tenth of the pass")]
    pub(crate) fn add(&mut self, kernel: &Kernel, others: &Four, j: &[u32], slope: f64x4) {
        let approach = others.approach();
        let rub = slope * drag(kernel, self.pass.viscosities(self.store, self.body, j), approach, others.square);
        self.lost -= rub * approach;
        self.rubbed = [0, 1, 2].map(|k| self.rubbed[k] + others.apart[k] * rub);
        if self.coheres {
            let pull = cohesion::pull(kernel, others.r) * self.pass.cohesions(self.store, self.body, j);
            self.pulled = [0, 1, 2].map(|k| self.pulled[k] - others.apart[k] * pull);
        }
    }

    /// All of it, with a force of pressure \[N\] and for a volume \[m³\].
    #[inline]
    pub(crate) fn felt(&self, pressed: Vec3, volume: f64) -> Felt {
        let rubbed = scale(gather(self.rubbed), volume);
        let force = add(add(pressed, rubbed), gather(self.pulled));
        Felt { force, rubbed, lost: 0.5 * volume * self.lost.reduce_add() }
    }
}

impl Pass<'_> {
    /// What a particle feels of the liquid around it.
    pub(crate) fn feel(&self, store: &Store, pack: &[Pack], i: usize) -> Felt {
        let (kernel, own) = (self.model.kernel, &pack[i]);
        let mut rubs = Rubs::new(self, store, own, i);
        let (mut force, pressure) = ([f64x4::ZERO; 3], f64x4::splat(own.pressure));
        for j in self.lists.chunks()[i / CHUNK].row(i % CHUNK).chunks_exact(LANES) {
            let others = Four::new(own, pack, j);
            let slope = kernel.slopes(others.r) * others.volume;
            rubs.add(&kernel, &others, j, slope);
            let along = slope * (pressure + others.pressure);
            force = [0, 1, 2].map(|k| force[k] - others.apart[k] * along);
        }
        rubs.felt(scale(gather(force), own.volume), own.volume)
    }
}
