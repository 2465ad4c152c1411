//! Boundary particles in an incompressible solution: each has the mean pressure of the liquid around it, `q_b = Σ_i S_bi q_i`
//! with `S_bi = V_i W_bi/Σ_k V_k W_bk` and the weight of what lies between (Adami, Hu and Adams 2012, eq. 27), and hands its
//! own change of filled share back by the transpose of that mean.
#![expect(clippy::inline_always, reason = "as said in `lanes`")]

use cosplat_core::boundary::{Vec3, scale};
use fearless_simd::{Level, Simd, dispatch, f64x4, prelude::*};

use crate::force::Pass;
use crate::incompressible::contact::Contacts;
use crate::kernel::Kernel;
use crate::lanes::{Four, Pack, accumulate, along_one, gather, groups, total, zero, zeros};
use crate::near::{CHUNK, for_chunks};
use crate::pairs::Pairs;
use crate::single::{Place, Scale};
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

/// Measures one among the liquid particles near it, which weigh `g` \[N/m³\].
#[inline(always)]
fn measured<S: Simd>(
    simd: S,
    kernel: &Kernel,
    (own, pack, near): (&Pack, &[Pack], &[u32]),
    warm: &[f64],
    g: Vec3,
    pairs: &mut Pairs,
) -> Brim {
    let (mut sum, mut pull) = (zero(simd), zeros(simd));
    let (mut before, mut column) = (zero(simd), zero(simd));
    for i in groups(near) {
        let others = Four::new(simd, own, pack, i);
        let t = kernel.inside(others.r);
        let weight = others.volume * kernel.weights_at(t);
        sum += weight;
        let pressures = i.map(|i| warm.get(i as usize).copied().unwrap_or(0.0));
        before += weight * f64x4::load_array(simd, pressures);
        column += weight * along_one(&others.apart, g);
        accumulate(&mut pull, &others.apart, -(others.volume * kernel.slopes_at(t)));
        pairs.push(i, t);
    }
    pairs.end(pack.len() - 1);
    let sum = total(sum);
    let one = if sum > 0.0 { 1.0 / sum } else { 0.0 };
    // A liquid never pulls: only what was pressed in the last substep has a hydrostatic share.
    let (mean, column) = (total(before) * one, total(column) * one);
    let offset = if mean > 0.0 && mean + column > 0.0 { column } else { 0.0 };
    Brim { volume: own.volume, one, offset, pull: gather(pull), ..Brim::default() }
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
                let g = scale(pass.gravity[body], pass.model.liquids[body].rho);
                let near = (&own[c * CHUNK + k], pack, walls.lists().chunks()[c].row(k));
                *brim = dispatch!(Level::new(), simd => measured(simd, &kernel, near, warm, g, pairs));
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
        dispatch!(Level::new(), simd => self.forces(simd, &kernel, walls, own, near))
    }

    /// The same with a kernel.
    #[inline(always)]
    fn forces<S: Simd>(&self, simd: S, kernel: &Kernel, walls: &Walls, own: &Pack, near: &[u32]) -> [Vec3; 2] {
        let (mut all, mut statics) = (zeros(simd), zeros(simd));
        for b in groups(near) {
            let others = Four::new(simd, own, walls.packs(), b);
            let pressed = f64x4::load_array(simd, b.map(|b| self.brims[b as usize].pushed));
            let fixed = f64x4::load_array(simd, b.map(|b| self.statics[b as usize]));
            let pushed = own.pressure * own.volume * others.volume + own.volume * pressed;
            let along = kernel.slopes(others.r) * pushed;
            accumulate(&mut all, &others.apart, -along);
            accumulate(&mut statics, &others.apart, -(along * fixed));
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
                let row = pairs[c].row(k);
                let sum = dispatch!(Level::new(), simd => row.over(simd, &scale, |i| pushed[i]));
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
        moved: &[[f32; 4]],
    ) {
        let (count, scale) = (self.brims.len() - 1, Scale::new(&pass.model.kernel.scaled()));
        let Self { pairs, places, .. } = self;
        let mut nothing = vec![(); pairs.len()];
        for_chunks(pass.parallel, &mut self.brims[..count], &mut nothing, &|c, brims, ()| {
            for (k, brim) in brims.iter_mut().enumerate() {
                // Seen from the liquid, where the gradient points the other way.
                let (row, place) = (pairs[c].row(k), places[c * CHUNK + k]);
                let sum = dispatch!(Level::new(), simd => row.across(simd, &scale, place, liquid, moved));
                brim.back = -brim.volume * brim.one * sum;
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
