//! Friction of the liquid with samples, which show one velocity for a whole window.
//!
//! A sample of mass m that the liquid resists with the force `-K u` of their relative velocity u would be thrown past the
//! liquid by the impulse `K u W` of a window `W > m/K`, and farther in each window from `2 m/K` on. Where the largest
//! eigenvalue of `K W/m` is above one, the friction on both is divided by it: the liquid then stops the sample within the
//! window and no more. By sums over the lattice K is 2.0 μ/d of each square metre along a layer and 5.6 to 5.8 μ/d across:
//! a window of 0.2 ms is that long for a layer of 1 kg/m² in mud of 10 Pa s at a spacing of 12.5 mm.
//!
//! What friction takes from a sample is its impulse times the sample's mean velocity over the window, which is known when it
//! shows its next place. Until then it is booked by the velocity that it showed: for a sample that trembles with the
//! frequency ω beside its friction that is `ωW/sin ωW` times as much. The difference is booked in the next window.

use cosplat_core::boundary::{Vec3, add, dot, scale, sub};
use fearless_simd::{Level, Simd, dispatch, f64x4, prelude::*};

use crate::force::drag;
use crate::lanes::{Four, accumulate, gather, groups, zeros};
use crate::liquids::Liquids;
use crate::model::{Model, Solid};
use crate::near::{CHUNK, for_chunks};
use crate::partner::{Partners, sample_of};
use crate::wall::{Piece, Walls, friction};

/// Friction with a sample in the last window.
#[derive(Clone, Copy, Debug, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub(crate) struct Rubbed {
    /// Face and sample.
    face: u64,
    sample: u64,
    /// Mean force on the sample \[N\].
    force: Vec3,
    /// Where its velocity at the start of the window would have taken it \[m\].
    foreseen: Vec3,
}

impl Partners {
    /// Set and sample to which a boundary particle belongs.
    fn sample(&self, model: &Model, piece: &Piece) -> Option<(usize, usize)> {
        let solid = model.faces[piece.face as usize].solid;
        let set = self.sets.iter().position(|s| s.solid == solid)?;
        matches!(model.solids[solid], Solid::Sampled(_)).then_some((set, sample_of(piece.index)))
    }

    /// What the friction of a window of that length \[s\] did to samples whose way in it is not known yet.
    pub(crate) fn rubbed(&self, model: &Model, length: f64) -> Vec<Rubbed> {
        let mut all = Vec::new();
        for (f, crossed) in self.crossed.iter().enumerate() {
            let set = self.sets.iter().find(|s| s.solid == model.faces[f].solid && s.input.next.is_none());
            let Some(set) = set else { continue };
            for (i, impulse) in crossed.rubbed.iter().enumerate().filter(|(_, j)| dot(**j, **j) > 0.0) {
                let foreseen = add(set.start[i], scale(set.v[i], length));
                let force = scale(*impulse, 1.0 / length);
                all.push(Rubbed { face: f as u64, sample: i as u64, force, foreseen });
            }
        }
        all
    }

    /// How much more was lost to friction in the last window than was booked, now that the samples' ways are known \[J\].
    pub(crate) fn settle(&self, model: &Model, last: &[Rubbed]) -> f64 {
        let more = |r: &Rubbed| {
            let solid = model.faces.get(r.face as usize)?.solid;
            let now = self.sets.iter().find(|s| s.solid == solid)?.x.get(r.sample as usize)?;
            Some(dot(r.force, sub(r.foreseen, *now)))
        };
        last.iter().filter_map(more).sum()
    }
}

impl Walls {
    /// Divides the friction of samples by what would throw them past the liquid in a window of that length \[s\].
    pub(crate) fn ease(&mut self, liquids: &Liquids<'_>, partners: &Partners, window: f64) {
        if partners.sets.is_empty() {
            return;
        }
        let model = liquids.model;
        let mut pull = vec![0.0; self.pieces.len()];
        let mut nothing = vec![(); self.pieces.len().div_ceil(CHUNK)];
        for_chunks(liquids.parallel, &mut pull, &mut nothing, &|c, pull, ()| {
            for (k, pull) in pull.iter_mut().enumerate() {
                let piece = &self.pieces[c * CHUNK + k];
                if partners.sample(model, piece).is_some() {
                    *pull = dispatch!(Level::new(), simd => self.resistance(simd, liquids, c * CHUNK + k));
                }
            }
        });
        let mut all: Vec<Vec<f64>> = partners.sets.iter().map(|s| vec![0.0; s.mass.len()]).collect();
        for (piece, pull) in self.pieces.iter().zip(&pull) {
            if let Some((set, sample)) = partners.sample(model, piece) {
                all[set][sample] += pull;
            }
        }
        for (piece, rub) in self.pieces.iter().zip(&mut self.rubs) {
            if let Some((set, sample)) = partners.sample(model, piece) {
                let share = partners.sets[set].mass[sample] / (window * all[set][sample]);
                rub[0] = friction(model, &model.faces[piece.face as usize]) * share.min(1.0);
            }
        }
    }

    /// Bound of the largest eigenvalue of the resistance of the liquid to the motion of a boundary particle, by the
    /// Frobenius norm \[N s/m\].
    #[inline(always)]
    #[expect(clippy::inline_always, reason = "as said in `lanes`")]
    fn resistance<S: Simd>(&self, simd: S, liquids: &Liquids<'_>, piece: usize) -> f64 {
        let (kernel, own) = (liquids.model.kernel, &self.seen[piece]);
        let face = &liquids.model.faces[self.pieces[piece].face as usize];
        let viscosity = f64x4::splat(simd, friction(liquids.model, face) * self.grip[piece][1] * own.volume);
        let one = f64x4::splat(simd, 1.0);
        let (mut squares, mut mixed) = (zeros(simd), zeros(simd));
        for i in groups(self.lists.chunks()[piece / CHUNK].row(piece % CHUNK)) {
            let others = Four::new(simd, own, liquids.pack, i);
            let along = kernel.slopes(others.r) * others.volume * drag(&kernel, viscosity, one, others.square);
            let [x, y, z] = others.apart;
            accumulate(&mut squares, &[x * x, y * y, z * z], -along);
            accumulate(&mut mixed, &[x * y, x * z, y * z], -along);
        }
        let ([xx, yy, zz], [xy, xz, yz]) = (gather(squares), gather(mixed));
        (xx * xx + yy * yy + zz * zz + 2.0 * (xy * xy + xz * xz + yz * yz)).sqrt()
    }
}
