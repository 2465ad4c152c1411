//! Densities of a weakly compressible liquid, by continuity with diffusion (`force`): the first of two passes over the pairs
//! in a substep, in single precision. Rates, which are integrated in double precision, are rounded by some 1e-7 of themselves and
//! of the speed over the spacing, but for a speed that all have. Forces, which must balance, are summed in double precision over
//! the pairs that this pass found in the kernel's reach.
#![expect(clippy::inline_always, reason = "as said in `lanes`")]

use cosplat_core::boundary::{add, scale};
use fearless_simd::{Level, Simd, dispatch, f32x8, i32x8, prelude::*};

use crate::force::{Pass, volume};
use crate::lanes::{Four, Pack, groups, total, zero};
use crate::near::{CHUNK, for_chunks};
use crate::pairs::{Pairs, Row};
use crate::single::{Brief, Eight, Scale, WIDE};
use crate::store::Store;
use crate::wall::Walls;

/// Kernel sum below which a particle is spray: it forgets that it was ever rarefied.
const SPRAY: f64 = 0.6;

/// Working memory of the pass.
#[derive(Clone, Debug, Default)]
pub(crate) struct Compression {
    /// What it reads of each particle; then nobody's.
    briefs: Vec<Brief>,
    /// Of the lists, the pairs that the kernel reaches, chunk by chunk.
    close: Vec<Pairs>,
}

impl Compression {
    /// Neighbours of a particle in the kernel's reach in the last pass.
    #[inline]
    pub(crate) fn close(&self, i: usize) -> Row<'_> {
        self.close[i / CHUNK].row(i % CHUNK)
    }

    /// Densities of the substep, from the velocities and places at its start.
    pub(crate) fn pass(&mut self, pass: &Pass<'_>, store: &Store, walls: &Walls, next: &mut [f64]) {
        let Self { briefs, close } = self;
        let units = Scale::new(&pass.model.kernel);
        briefs.resize(store.len() + 1, Brief::default());
        close.resize(store.len().div_ceil(CHUNK), Pairs::default());
        let mut nothing = vec![(); close.len()];
        for_chunks(pass.parallel, &mut briefs[..store.len()], &mut nothing, &|c, briefs, ()| {
            for (k, brief) in briefs.iter_mut().enumerate() {
                let (pack, excess) = pass.seen(store, c * CHUNK + k);
                *brief = Brief::new(&units, pack.x, pack.volume, pack.v, excess);
            }
        });
        let seen = (&units, &briefs[..]);
        for_chunks(pass.parallel, next, close, &|c, next, close| {
            dispatch!(Level::new(), simd => pass.compress(simd, store, seen, walls, (c, next, close)));
        });
    }
}

impl Pass<'_> {
    /// A particle without its pressure, and its density above that at rest \[kg/m³\].
    fn seen(&self, store: &Store, i: usize) -> (Pack, f64) {
        let (id, rho) = (store.id[i] as usize, store.rho[i]);
        let rest = self.model.liquids[self.model.body[id] as usize].rho;
        let volume = volume(self.model.mass[id], rho);
        (Pack { x: store.x[i], volume, v: store.v[i], pressure: 0.0 }, rho - rest)
    }

    /// Densities of a chunk after the substep.
    #[inline(always)]
    fn compress<S: Simd>(
        &self,
        simd: S,
        store: &Store,
        seen: (&Scale, &[Brief]),
        walls: &Walls,
        (c, next, close): (usize, &mut [f64], &mut Pairs),
    ) {
        let lists = &self.lists.chunks()[c];
        close.clear(lists.len());
        for (k, next) in next.iter_mut().enumerate() {
            let i = c * CHUNK + k;
            *next = store.rho[i];
            if *next > 0.0 {
                *next = self.compressed(simd, store, i, seen, walls, (lists.row(k), &mut *close));
            }
            close.end(store.len());
        }
    }

    /// Density of a particle after the substep \[kg/m³\]; which of its list the kernel reaches is noted.
    #[inline(always)]
    fn compressed<S: Simd>(
        &self,
        simd: S,
        store: &Store,
        i: usize,
        (units, briefs): (&Scale, &[Brief]),
        walls: &Walls,
        (list, close): (&[u32], &mut Pairs),
    ) -> f64 {
        let (model, kernel) = (self.model, &self.model.kernel);
        let body = model.body[store.id[i] as usize];
        let liquid = &model.liquids[body as usize];
        let (own, excess) = self.seen(store, i);
        let slant = scale(self.gravity[body as usize], liquid.rho / (liquid.sound * liquid.sound));
        // What diffuses counts as an approach: its hydrostatic part as one by a velocity of the particle.
        let spread = 2.0 * model.params.diffusion * kernel.h * liquid.sound / store.rho[i];
        let slanted = add(own.v, scale(slant, -spread));
        let [x, y, z, _] = units.place(own.x);
        let place = [i32x8::splat(simd, x), i32x8::splat(simd, y), i32x8::splat(simd, z)];
        let v = slanted.map(|v| v as f32);
        let v = [f32x8::splat(simd, v[0]), f32x8::splat(simd, v[1]), f32x8::splat(simd, v[2])];
        let (spread, excess) = (f32x8::splat(simd, (spread * units.fine) as f32), f32x8::splat(simd, excess as f32));
        let (mut squeeze, mut sum) = (f32x8::splat(simd, 0.0), f32x8::splat(simd, 0.0));
        for j in list.as_chunks::<WIDE>().0 {
            let others = Eight::new(simd, &place, &v, briefs, j);
            let t = others.inside;
            let cube = t * t * t * others.volume;
            let denser = self.excesses(store, body, excess, &others, j) - excess;
            squeeze += cube * (others.approach() - spread * denser);
            sum += cube * t * (5.0 - 4.0 * t);
            close.push_eight(j, t);
        }
        let (mut beside, mut filled) = (zero(simd), zero(simd));
        for b in groups(walls.near(i)) {
            let others = Four::new(simd, &own, walls.sliding(), b);
            beside += kernel.slopes(others.r) * others.volume * others.approach();
            filled += kernel.weights(others.r) * others.volume;
        }
        let squeeze = units.slope * f64::from(whole(squeeze)) + total(beside);
        let sum = units.alpha * f64::from(whole(sum)) + total(filled) + own.volume * kernel.weight(0.0);
        let next = store.rho[i] * (1.0 + self.dt * squeeze);
        if sum < SPRAY { next.max(liquid.rho) } else { next }
    }

    /// Densities above those at rest of eight neighbours; the own one for those of another body, between which nothing diffuses.
    #[inline(always)]
    fn excesses<S: Simd>(
        &self,
        store: &Store,
        body: u32,
        own: f32x8<S>,
        others: &Eight<S>,
        j: &[u32; WIDE],
    ) -> f32x8<S> {
        if self.model.liquids.len() == 1 {
            // Nobody has no volume, so that its density does not matter.
            return others.excess;
        }
        let of_body = |j: u32| store.id.get(j as usize).is_some_and(|&id| self.model.body[id as usize] == body);
        let (mut each, simd, own) = (others.excess.to_array(), own.token(), own.to_array());
        for k in (0..WIDE).filter(|&k| !of_body(j[k])) {
            each[k] = own[k];
        }
        f32x8::load_array(simd, each)
    }
}

/// Sum of eight, in the same order whatever the processor.
#[inline(always)]
fn whole<S: Simd>(eight: f32x8<S>) -> f32 {
    let (first, second) = eight.split();
    let [a, b, c, d] = (first + second).to_array();
    (a + c) + (b + d)
}
