//! Boundary particles in an incompressible solution: each has the mean pressure of the liquid around it, `p_b = Σ_i S_bi p_i`
//! with `S_bi = V_i W_bi/Σ_k V_k W_bk` and the weight of what lies between (Adami, Hu and Adams 2012, eq. 27), and hands its own change of filled share back by the transpose of that mean.

use cosplat_core::boundary::{Vec3, scale};
use wide::f64x4;

use crate::force::Pass;
use crate::incompressible::contact::Contacts;
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
    /// The last one is nobody.
    pub(crate) brims: Vec<Brim>,
    /// Gradients at the liquid and weights of each group, in the order of the boundary particles' lists and of the liquid's.
    by_brim: Vec<Vec<[f64x4; 4]>>,
    by_liquid: Vec<[f64x4; 4]>,
    statics: Vec<f64>,
}

impl Edge {
    /// Measures all that depends on the places alone.
    pub(crate) fn measure(&mut self, pass: &Pass<'_>, pack: &[Pack], walls: &Walls, warm: &[f64]) {
        let kernel = pass.model.kernel.scaled();
        let (own, count) = (walls.packs(), walls.pieces.len());
        self.brims.clear();
        self.brims.resize(count + 1, Brim::default());
        self.by_brim.resize(count.div_ceil(CHUNK), Vec::new());
        for_chunks(pass.parallel, &mut self.brims[..count], &mut self.by_brim, &|c, brims, groups| {
            groups.clear();
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
                    groups.push([g[0], g[1], g[2], weight]);
                }
                let sum = sum.reduce_add();
                let one = if sum > 0.0 { 1.0 / sum } else { 0.0 };
                // A liquid never pulls: only what was pressed in the last substep has a hydrostatic share.
                let (mean, column) = (before.reduce_add() * one, column.reduce_add() * one);
                let offset = if mean > 0.0 && mean + column > 0.0 { column } else { 0.0 };
                *brim = Brim { volume: own.volume, one, offset, pull: gather(pull), ..Brim::default() };
            }
        });
        self.by_liquid.clear();
        for (i, pack) in pack[..pack.len() - 1].iter().enumerate() {
            for b in walls.near(i).chunks_exact(LANES) {
                let others = Four::new(pack, own, b);
                let slope = kernel.slopes(others.r);
                let [x, y, z] = others.apart.map(|a| a * slope);
                self.by_liquid.push([x, y, z, kernel.weights(others.r)]);
            }
        }
        self.statics.clear();
        self.statics.extend((0..count).map(|b| if walls.of_partner(b) { 0.0 } else { 1.0 }));
        self.statics.push(0.0);
    }

    fn groups<'a>(&'a self, walls: &'a Walls, i: usize) -> impl Iterator<Item = (&'a [u32], &'a [f64x4; 4])> {
        let near = walls.near(i);
        let from = walls.first(i) / LANES;
        near.chunks_exact(LANES).zip(&self.by_liquid[from..from + near.len() / LANES])
    }

    fn sum(&self, walls: &Walls, i: usize, factor: impl Fn(usize) -> f64) -> Vec3 {
        let mut sum = [f64x4::ZERO; 3];
        for (b, g) in self.groups(walls, i) {
            let f = f64x4::new([0, 1, 2, 3].map(|l| factor(b[l] as usize)));
            sum = [0, 1, 2].map(|k| sum[k] + f * g[k]);
        }
        gather(sum)
    }

    /// Gradient of the filled share of a liquid particle by them, and what they fill.
    pub(crate) fn of(&self, walls: &Walls, i: usize) -> (Vec3, f64) {
        let filled: f64x4 = self.groups(walls, i).fold(f64x4::ZERO, |sum, (b, g)| {
            sum + g[3] * f64x4::new([0, 1, 2, 3].map(|l| self.brims[b[l] as usize].volume))
        });
        (self.sum(walls, i, |b| self.brims[b].volume), filled.reduce_add())
    }

    /// Sum of their pressures times volume and gradient at a liquid particle.
    pub(crate) fn pull(&self, walls: &Walls, i: usize) -> Vec3 {
        self.sum(walls, i, |b| self.brims[b].pushed)
    }

    /// The same two for static walls alone.
    pub(crate) fn statics(&self, walls: &Walls, i: usize) -> [Vec3; 2] {
        let own = self.sum(walls, i, |b| self.statics[b] * self.brims[b].volume);
        [own, self.sum(walls, i, |b| self.statics[b] * self.brims[b].pushed)]
    }

    /// Their pressures, where those of the liquid times volume are `pushed` \[J\].
    pub(crate) fn press(&mut self, pass: &Pass<'_>, walls: &Walls, pushed: &[f64]) {
        let count = walls.pieces.len();
        let by_brim = &self.by_brim;
        let mut nothing = vec![(); by_brim.len()];
        for_chunks(pass.parallel, &mut self.brims[..count], &mut nothing, &|c, brims, ()| {
            let mut groups = by_brim[c].iter();
            for (k, brim) in brims.iter_mut().enumerate() {
                let mut sum = f64x4::ZERO;
                for (i, g) in walls.lists().chunks()[c].row(k).chunks_exact(LANES).zip(&mut groups) {
                    sum += g[3] * f64x4::new([0, 1, 2, 3].map(|l| pushed[i[l] as usize]));
                }
                brim.pushed = brim.volume * (brim.one * sum.reduce_add() + brim.offset);
            }
        });
    }

    /// How their filled shares change, where the velocities of the liquid times volume are `moved` \[m⁴/s\].
    pub(crate) fn squeeze(&mut self, pass: &Pass<'_>, walls: &Walls, contacts: &Contacts, own: bool, moved: &[Vec3]) {
        let count = walls.pieces.len();
        let by_brim = &self.by_brim;
        let mut nothing = vec![(); by_brim.len()];
        for_chunks(pass.parallel, &mut self.brims[..count], &mut nothing, &|c, brims, ()| {
            let mut groups = by_brim[c].iter();
            for (k, brim) in brims.iter_mut().enumerate() {
                let mut sum = f64x4::ZERO;
                for (i, g) in walls.lists().chunks()[c].row(k).chunks_exact(LANES).zip(&mut groups) {
                    let [a, b, c, d] = [0, 1, 2, 3].map(|l| &moved[i[l] as usize]);
                    for k in 0..3 {
                        sum += f64x4::new([a[k], b[k], c[k], d[k]]) * g[k];
                    }
                }
                // Towards a boundary particle the gradient at the liquid points away: approach counts as it does there.
                brim.back = brim.volume * brim.one * sum.reduce_add();
            }
        });
        contacts.brims(own, |b, change| {
            let brim = &mut self.brims[b];
            brim.back += brim.volume * brim.one * change;
        });
    }

    /// What comes back to a liquid particle \[1/s\].
    pub(crate) fn rate(&self, walls: &Walls, i: usize) -> f64 {
        let mut sum = f64x4::ZERO;
        for (b, g) in self.groups(walls, i) {
            sum += g[3] * f64x4::new([0, 1, 2, 3].map(|l| self.brims[b[l] as usize].back));
        }
        sum.reduce_add()
    }
}
