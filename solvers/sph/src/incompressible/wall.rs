//! Boundary particles in an incompressible solution: each has the mean pressure of the liquid around it, `q_b = Σ_i S_bi q_i`
//! with `S_bi = V_i W_bi/Σ_k V_k W_bk` and the weight of what lies between (Adami, Hu and Adams 2012, eq. 27), and hands its
//! own change of filled share back by the transpose of that mean.

use cosplat_core::boundary::{Vec3, scale};
use wide::{f32x4, f64x4};

use crate::force::Pass;
use crate::incompressible::contact::Contacts;
use crate::incompressible::pairs::{Pairs, Place, Scale};
use crate::kernel::Kernel;
use crate::lanes::{Four, LANES, Pack, gather};
use crate::near::{CHUNK, for_chunks};
use crate::wall::Walls;

/// A boundary particle over a substep.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Brim {
    /// Volume \[m³\], and one over the sum of weights.
    pub(crate) volume: f64,
    one: f64,
    /// `Σ_i V_i ∇W_ib` \[1/m\].
    pub(crate) pull: Vec3,
    /// What its pressure is above that mean, by the weight of the liquid between \[Pa\].
    offset: f64,
    /// Pressure times volume \[J\].
    pub(crate) pushed: f64,
    /// Share of the filled share's change that goes back to each neighbour, over its weight \[m³/s\].
    back: f64,
}

/// All of them.
#[derive(Clone, Debug, Default)]
pub(crate) struct Edge {
    kernel: Option<Kernel>,
    /// The last one is nobody.
    pub(crate) brims: Vec<Brim>,
    /// Pairs with the liquid, and where each is, and nobody.
    pairs: Vec<Pairs>,
    places: Vec<Place>,
    /// Pressures times volume, or what goes back, of each and of nobody.
    pressed: Vec<f32>,
    back: Vec<f32>,
    statics: Vec<f64>,
}

impl Edge {
    /// Measures all that depends on the places alone.
    pub(crate) fn measure(&mut self, pass: &Pass<'_>, pack: &[Pack], walls: &Walls, warm: &[f64]) {
        let kernel = pass.model.kernel.scaled();
        self.kernel = Some(kernel);
        let (own, count) = (walls.packs(), walls.pieces.len());
        self.brims.clear();
        self.brims.resize(count + 1, Brim::default());
        self.pairs.resize(count.div_ceil(CHUNK), Pairs::default());
        let scaled = Scale::new(&kernel);
        self.places.clear();
        self.places.extend(own.iter().map(|p| scaled.place(p.x)));
        for_chunks(pass.parallel, &mut self.brims[..count], &mut self.pairs, &|c, brims, pairs| {
            pairs.clear(walls.lists().chunks()[c].len());
            for (k, brim) in brims.iter_mut().enumerate() {
                let body = pass.model.faces[walls.pieces[c * CHUNK + k].face as usize].body;
                let weight_of = scale(pass.gravity[body], pass.model.liquids[body].rho).map(f64x4::splat);
                let own = &own[c * CHUNK + k];
                let (mut sum, mut pull) = (f64x4::ZERO, [f64x4::ZERO; 3]);
                let (mut before, mut column) = (f64x4::ZERO, f64x4::ZERO);
                for i in walls.lists().chunks()[c].row(k).chunks_exact(LANES) {
                    let others = Four::new(own, pack, i);
                    let (slope, weight) = (kernel.slopes(others.r), kernel.weights(others.r));
                    let g = others.apart.map(|a| -a * slope);
                    sum += others.volume * weight;
                    let p = [0, 1, 2, 3].map(|l| warm.get(i[l] as usize).copied().unwrap_or(0.0));
                    before += others.volume * weight * f64x4::new(p);
                    let [a, b, c] = [0, 1, 2].map(|k| others.apart[k] * weight_of[k]);
                    column += others.volume * weight * (a + b + c);
                    pull = [0, 1, 2].map(|k| pull[k] + others.volume * g[k]);
                    pairs.push(i, kernel.inside(others.r));
                }
                pairs.end(pack.len() - 1);
                let sum = sum.reduce_add();
                let one = if sum > 0.0 { 1.0 / sum } else { 0.0 };
                // A liquid never pulls: only what was pressed in the last substep has a hydrostatic share.
                let (mean, column) = (before.reduce_add() * one, column.reduce_add() * one);
                let offset = if mean > 0.0 && mean + column > 0.0 { column } else { 0.0 };
                *brim = Brim { volume: own.volume, one, offset, pull: gather(pull), ..Brim::default() };
            }
        });
        self.statics.clear();
        self.statics.extend((0..count).map(|b| if walls.of_partner(b) { 0.0 } else { 1.0 }));
        self.statics.push(0.0);
    }

    /// Pressures times volume of each and of nobody.
    pub(crate) fn pressed(&self) -> &[f32] {
        &self.pressed
    }

    /// Where each is, and nobody.
    pub(crate) fn places(&self) -> &[Place] {
        &self.places
    }

    /// What goes back from each and from nobody, over its weight.
    pub(crate) fn back(&self) -> &[f32] {
        &self.back
    }

    /// Force of all and of static ones alone on a liquid particle \[N\].
    pub(crate) fn force(&self, walls: &Walls, own: &Pack, near: &[u32]) -> [Vec3; 2] {
        let Some(kernel) = self.kernel else { return [[0.0; 3]; 2] };
        let (mut all, mut statics) = ([f64x4::ZERO; 3], [f64x4::ZERO; 3]);
        for b in near.chunks_exact(LANES) {
            let others = Four::new(own, walls.packs(), b);
            let pressed = f64x4::new([0, 1, 2, 3].map(|l| self.brims[b[l] as usize].pushed));
            let fixed = f64x4::new([0, 1, 2, 3].map(|l| self.statics[b[l] as usize]));
            let pushed = f64x4::splat(own.pressure * own.volume) * others.volume + f64x4::splat(own.volume) * pressed;
            let along = kernel.slopes(others.r) * pushed;
            for k in 0..3 {
                let force = others.apart[k] * along;
                all[k] -= force;
                statics[k] -= force * fixed;
            }
        }
        [gather(all), gather(statics)]
    }

    /// Their pressures, where those of the liquid times volume are `pushed` \[J\].
    pub(crate) fn press(&mut self, pass: &Pass<'_>, pushed: &[f32]) {
        let (count, scale) = (self.brims.len() - 1, Scale::new(&pass.model.kernel.scaled()));
        let pairs = &self.pairs;
        let mut nothing = vec![(); pairs.len()];
        for_chunks(pass.parallel, &mut self.brims[..count], &mut nothing, &|c, brims, ()| {
            for (k, brim) in brims.iter_mut().enumerate() {
                let sum = pairs[c].row(k).over(&scale, |i| pushed[i]);
                brim.pushed = brim.volume * (brim.one * sum + brim.offset);
            }
        });
        self.pressed.clear();
        self.pressed.extend(self.brims.iter().map(|b| b.pushed as f32));
    }

    /// How their filled shares change, where the velocities of the liquid times volume are `moved` \[m⁴/s\].
    pub(crate) fn squeeze(
        &mut self,
        pass: &Pass<'_>,
        liquid: &[Place],
        contacts: &Contacts,
        own: bool,
        moved: &[f32x4],
    ) {
        let (count, scale) = (self.brims.len() - 1, Scale::new(&pass.model.kernel.scaled()));
        let Self { pairs, places, .. } = self;
        let mut nothing = vec![(); pairs.len()];
        for_chunks(pass.parallel, &mut self.brims[..count], &mut nothing, &|c, brims, ()| {
            for (k, brim) in brims.iter_mut().enumerate() {
                // Seen from the liquid, where the gradient points the other way.
                let sum = -pairs[c].row(k).across(&scale, places[c * CHUNK + k], liquid, moved);
                brim.back = brim.volume * brim.one * sum;
            }
        });
        contacts.brims(own, |b, change| {
            let brim = &mut self.brims[b];
            brim.back += brim.volume * brim.one * change;
        });
        self.back.clear();
        self.back.extend(self.brims.iter().map(|b| b.back as f32));
    }
}
