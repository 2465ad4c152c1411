//! Quarantine: a few particles whose strain or motion means nothing any more exert no stress, and the run goes on.
//!
//! A particle in quarantine keeps mass, volume and momentum, moves with the grid and meets colliders as before, but its
//! elastic strain stays zero: it flies, or is carried by its neighbours. The elastic energy that it had counts as
//! dissipated. The mark is a negative history of its material, so it is sorted, saved and restored with the particle,
//! and the bytes of a run without any are those of a run without this guard.
//!
//! Two ways lead into it, both from a state that is then kept:
//! - strain, looked at before each segment: see [`strained`]. Such a particle would otherwise shorten every substep;
//! - motion: what broke the guard of `sim` when six halvings of the substep had not helped, or is not finite, after the
//!   rollback. Halved six times and let go half a cell instead of 0.3, that is 107 times the speed for which the substep
//!   was chosen.
//!
//! Speed alone is no reason: it is momentum, which must stay in the books, and the next transfer shares it out.

use cosplat_core::plugin::PluginError;
use nalgebra::Matrix3;

use crate::math::{Sym, all, det_minus_one};
use crate::real::{Lanes, Real};
use crate::sim::{Books, MOST_STRETCH, MOST_WAY, Sim};
use crate::store::{B, C, PAST, Quad, Store, V, VOL};
use crate::transfer::strain;

/// Smallest and largest volume, over that at rest. Squeezed along one axis, a body may come down to the smallest stretch
/// that the law bears, 0.05, without running away: a foam that hits the floor at 1.4 times its speed of sound squeezes a
/// whole layer below 0.1. A hundredth is out of reach of that. At ten times its volume a lattice of two particles along a
/// cell leaves cells empty between them, and no neighbour feels the stress. Plastic flow keeps the volume, so this is the
/// range of the elastic and of the total deformation.
const VOLUME: [f64; 2] = [0.01, 10.0];
/// Largest root of the sum of the squared stretches: beyond it the lattice has holes as well.
const STRETCHED: f64 = 10.0;
/// Share of a body's particles above which its motion is no longer that of the body.
const MOST_QUARANTINED: f64 = 0.01;

/// A part of a body and one of its particles.
type Culprit = (u32, u32);

/// 1 in the lanes whose strain lies outside the range or is not finite, else 0.
#[inline]
pub(crate) fn strained<R: Real>(b: &Sym<R>) -> R::V {
    let (zero, one) = (R::V::default(), all::<R>(1.0));
    let det = det_minus_one::<R>(b);
    let [least, most] = VOLUME.map(|j| all::<R>(j * j - 1.0));
    // Written so that a lane that is not a number falls through to 1.
    let slim = R::V::if_less(b[0] + b[1] + b[2], all::<R>(STRETCHED * STRETCHED - 3.0), zero, one);
    R::V::if_less(least, det, R::V::if_less(det, most, slim, one), one)
}

/// A strain after a substep: zero in the lanes in quarantine.
#[inline]
pub(crate) fn released<R: Real>(quad: &Quad<R>, b: Sym<R>) -> Sym<R> {
    let zero = R::V::default();
    let pick = |b: R::V| R::V::if_less(quad[PAST], zero, zero, b);
    [pick(b[0]), pick(b[1]), pick(b[2]), pick(b[3]), pick(b[4]), pick(b[5])]
}

impl<R: Real> Store<R> {
    /// Whether a particle is in quarantine.
    fn in_quarantine(&self, slot: usize) -> bool {
        self.field(slot, PAST) < 0.0
    }

    /// Puts a particle into quarantine. A total deformation that means nothing becomes none; else it stays as it is.
    fn put_in_quarantine(&mut self, slot: usize) {
        let past = self.field(slot, PAST);
        self.set(slot, PAST, if past.is_finite() { -1.0 - past } else { -1.0 });
        for k in 0..6 {
            self.set(slot, B + k, 0.0);
        }
        let Some(grad) = self.grads.get_mut(slot / 4) else { return };
        let numbers: &mut [R] = bytemuck::cast_slice_mut(std::slice::from_mut(grad));
        let f = Matrix3::from_fn(|i, j| numbers[(3 * i + j) * 4 + slot % 4].f64());
        if !(VOLUME[0]..=VOLUME[1]).contains(&f.determinant()) {
            for k in 0..9 {
                numbers[k * 4 + slot % 4] = R::of(if k % 4 == 0 { 1.0 } else { 0.0 });
            }
        }
    }
}

impl<R: Real> Sim<R> {
    /// Puts particles whose strain left its range into quarantine.
    pub(crate) fn isolate_strained(&mut self, time: f64, books: &mut Books) -> Result<(), PluginError> {
        let of_slot = |slot: usize| strained::<R>(&strain::<R>(&self.store.quads[slot / 4])).array()[slot % 4];
        let culprits = self.those(|slot| of_slot(slot) > R::default());
        let cause = "their volume left the range of 0.01 to 10 times that at rest, or they are stretched tenfold";
        self.isolate(&culprits, time, books, cause).map(|_| ())
    }

    /// Particles whose motion in a substep of `dt` broke the guard, or is not finite.
    pub(crate) fn runaways(&self, dt: f64) -> Vec<Culprit> {
        let sum = |slot: usize, first: usize, count: usize| -> f64 {
            (first..first + count).map(|k| self.store.field(slot, k).powi(2)).sum()
        };
        self.those(|slot| {
            let way = sum(slot, V, 3).sqrt() * dt <= MOST_WAY * self.setting.dx;
            let stretch = sum(slot, C, 9).sqrt() * dt <= MOST_STRETCH;
            !(way && stretch && sum(slot, B, 6).is_finite())
        })
    }

    fn those(&self, which: impl Fn(usize) -> bool) -> Vec<Culprit> {
        let found = self.store.each().filter(|&(_, slot)| which(slot));
        found.map(|(block, slot)| (block.part, self.store.ids[slot / 4][slot % 4])).collect()
    }

    /// Puts particles into quarantine. Returns whether any was not in it yet.
    ///
    /// # Errors
    ///
    /// When a body has too many.
    pub(crate) fn isolate(
        &mut self,
        culprits: &[Culprit],
        time: f64,
        books: &mut Books,
        cause: &str,
    ) -> Result<bool, PluginError> {
        let before = books.quarantined;
        for &(part, id) in culprits {
            let slot = self.store.slot[id as usize] as usize;
            if self.store.in_quarantine(slot) {
                continue;
            }
            let b = std::array::from_fn(|k| self.store.field(slot, B + k));
            let energy =
                self.store.field(slot, VOL) * self.setting.laws[part as usize].energy(b, self.store.field(slot, PAST));
            books.dissipated += if energy.is_finite() { energy } else { 0.0 };
            books.quarantined += 1;
            self.store.put_in_quarantine(slot);
        }
        if books.quarantined > before {
            self.count_quarantined(time, cause)?;
        }
        Ok(books.quarantined > before)
    }

    fn count_quarantined(&self, time: f64, cause: &str) -> Result<(), PluginError> {
        for (body, name) in self.setting.names.iter().enumerate() {
            let own = || self.store.each().filter(|(block, _)| block.body as usize == body);
            let (all, out) = (own().count(), own().filter(|&(_, slot)| self.store.in_quarantine(slot)).count());
            if out as f64 > MOST_QUARANTINED * all as f64 {
                return Err(PluginError::Physics(format!(
                    "{out} of the {all} particles of `{name}` are in quarantine at t = {time:.6e} s, more than 1 %: \
                     {cause}; try a shorter window or `max_substep_s`, finer particles, or a stiffer material"
                )));
            }
        }
        Ok(())
    }
}
