//! How full the space around each particle is, and how that changes with the velocities.
//!
//! The rate of the filled share is `Σ_j V_j (v_i - v_j)·∇W_ij/M_i` over particles and boundary particles (`wall`). `M_i` is
//! what that sum makes of the liquid swelling by one, a third of `-Σ_j V_j x_ij·∇W_ij`: with it the rate of a uniform
//! expansion is exact wherever the particles are. The force of pressures is the transpose, with `q = p/M`:
//! `-V_i (q_i G_i + Σ_j V_j q_j ∇W_ij)` and `G_i = Σ_j V_j ∇W_ij`; with it pressures are what the liquid presses with. The
//! kernel is scaled so that a cubic lattice is full.
#![expect(clippy::inline_always, reason = "as said in `lanes`")]

use cosplat_core::boundary::{Vec3, Wrench, add, cross, dot, scale};
use fearless_simd::{Level, Simd, dispatch};

use crate::felt::{Feels, Felt};
use crate::force::{Pass, Sums};
use crate::incompressible::contact::Contacts;
use crate::incompressible::measure::{Row, Stored, measured};
use crate::incompressible::wall::Edge;
use crate::kernel::Kernel;
use crate::lanes::{Four, Pack, accumulate, gather, groups, zeros};
use crate::model::Model;
use crate::near::{CHUNK, for_chunks};
use crate::single::{Place, Scale};
use crate::store::Store;
use crate::wall::Walls;

/// Gradients of the kernel over one substep.
#[derive(Clone, Debug, Default)]
pub(crate) struct Operator {
    pub(crate) rows: Vec<Row>,
    pub(crate) edge: Edge,
    stored: Vec<Stored>,
    /// Where each particle is, and nobody.
    places: Vec<Place>,
    /// Volume over mass of what pressure moves \[m³/kg\], 0 of what is driven; then nobody's.
    light: Vec<f64>,
}

/// Force of the liquid `near` a particle by the pressures in the packs \[N\].
#[inline(always)]
fn by_pressures<S: Simd>(simd: S, kernel: &Kernel, pack: &[Pack], own: &Pack, near: &[u32]) -> Vec3 {
    let mut force = zeros(simd);
    for j in groups(near) {
        let others = Four::new(simd, own, pack, j);
        let along = kernel.slopes(others.r) * others.volume * (own.pressure + others.pressure);
        accumulate(&mut force, &others.apart, -along);
    }
    scale(gather(force), own.volume)
}

impl Feels for Operator {
    /// What a particle feels without pressure.
    #[inline(always)]
    fn felt<S: Simd>(&self, _: S, i: usize) -> Felt {
        self.stored[i / CHUNK].felt[i % CHUNK]
    }
}

impl Operator {
    /// Says how light each particle is, and who is driven at a velocity of its own.
    pub(crate) fn hold(&mut self, model: &Model, store: &Store, driven: &[(usize, Vec3)]) {
        let light = store.id.iter().map(|&id| 1.0 / model.liquids[model.body[id as usize] as usize].rho);
        self.light.clear();
        self.light.extend(light.chain([0.0]));
        for &(i, _) in driven {
            self.light[i] = 0.0;
        }
    }

    /// Measures all that depends on the places alone, and what particles feel without pressure: both need the distances.
    pub(crate) fn measure(&mut self, pass: &Pass<'_>, store: &Store, pack: &[Pack], walls: &Walls) {
        let (scale, n) = (Scale::new(&pass.model.kernel.scaled()), store.len());
        self.places.clear();
        self.places.extend(pack.iter().map(|p| scale.place(p.x)));
        self.edge.measure(pass, pack, walls, &store.warm);
        self.rows.resize(n, Row::default());
        self.stored.resize(n.div_ceil(CHUNK), Stored::default());
        for_chunks(pass.parallel, &mut self.rows, &mut self.stored, &|c, rows, stored| {
            stored.liquid.clear(pass.lists.chunks()[c].len());
            stored.felt.clear();
            stored.walls.clear((0..rows.len()).map(|k| walls.near(c * CHUNK + k).len()).sum());
            for (k, row) in rows.iter_mut().enumerate() {
                let here = (c * CHUNK + k, &mut *stored);
                *row = dispatch!(Level::new(), simd => measured(simd, pass, &self.light, (store, pack, walls), here));
            }
        });
    }

    /// Adds to the diagonal what rigid partners would answer, as a bound over the row: a light one answers to all that
    /// press it at once.
    pub(crate) fn weigh(&mut self, contacts: &mut Contacts, pack: &[Pack]) {
        let rows = &mut self.rows;
        contacts.bound(pack, |i, more| rows[i].diagonal += more * rows[i].swell * rows[i].swell);
    }

    /// Changes of velocities over `dt` by pressures, times volumes \[m⁴/s\]; `pushed` are the products `q V` \[J\].
    pub(crate) fn accelerate(&mut self, pass: &Pass<'_>, pack: &[Pack], pushed: &[f32], moved: &mut [[f32; 4]]) {
        let (n, scale) = (self.rows.len(), Scale::new(&pass.model.kernel.scaled()));
        self.edge.press(pass, pushed);
        let mut nothing = vec![(); self.stored.len()];
        let beside = (self.edge.places(), self.edge.pressed());
        for_chunks(pass.parallel, &mut moved[..n], &mut nothing, &|c, moved, ()| {
            dispatch!(Level::new(), simd => self.accelerate_some(simd, &scale, pass.dt, (pack, pushed), beside, (c, moved)));
        });
    }

    /// Those of a chunk.
    #[inline(always)]
    fn accelerate_some<S: Simd>(
        &self,
        simd: S,
        scale: &Scale,
        dt: f64,
        (pack, pushed): (&[Pack], &[f32]),
        (brims, pressed): (&[Place], &[f32]),
        (c, moved): (usize, &mut [[f32; 4]]),
    ) {
        let Stored { liquid, walls, .. } = &self.stored[c];
        for (k, moved) in moved.iter_mut().enumerate() {
            let i = c * CHUNK + k;
            let (place, row) = (self.places[i], &self.rows[i]);
            let by_liquid = liquid.row(k).along(simd, scale, place, &self.places, pushed);
            let by_walls = walls.row(k).along(simd, scale, place, brims, pressed);
            let (own, factor) = (f64::from(pushed[i]), -row.light * dt);
            // `q_i V_i G_i` holds the volume already.
            let one = |k: usize| (factor * (own * row.pull[k] + pack[i].volume * (by_liquid[k] + by_walls[k]))) as f32;
            *moved = [one(0), one(1), one(2), 0.0];
        }
    }

    /// Rates of the filled shares \[1/s\] of particles whose velocities times volume are `moved`, and by the twists of rigid
    /// partners, their own or those that pressures have given.
    pub(crate) fn rates(
        &mut self,
        pass: &Pass<'_>,
        pack: &[Pack],
        contacts: &Contacts,
        own: bool,
        (moved, rates): (&[[f32; 4]], &mut [f64]),
    ) {
        let scale = Scale::new(&pass.model.kernel.scaled());
        self.edge.squeeze(pass, &self.places, contacts, own, moved);
        let mut nothing = vec![(); self.stored.len()];
        for_chunks(pass.parallel, rates, &mut nothing, &|c, rates, ()| {
            dispatch!(Level::new(), simd => self.rate_some(simd, &scale, pack, moved, (c, rates)));
        });
        contacts.rates(own, |i, rate| rates[i] += self.rows[i].swell * rate);
    }

    /// Those of a chunk, but for twists.
    #[inline(always)]
    fn rate_some<S: Simd>(
        &self,
        simd: S,
        scale: &Scale,
        pack: &[Pack],
        moved: &[[f32; 4]],
        (c, rates): (usize, &mut [f64]),
    ) {
        let (Stored { liquid, walls, .. }, back) = (&self.stored[c], self.edge.back());
        for (k, rate) in rates.iter_mut().enumerate() {
            let i = c * CHUNK + k;
            let row = &self.rows[i];
            let others = liquid.row(k).across(simd, scale, self.places[i], &self.places, moved);
            let by_walls = walls.row(k).over(simd, scale, |b| back[b]);
            let [x, y, z, _] = moved[i].map(f64::from);
            let own = dot([x, y, z], row.pull) / pack[i].volume;
            *rate = row.swell * (own - others + by_walls);
        }
    }

    /// Means around each particle of the fourth component of `moved`.
    pub(crate) fn means(&self, pass: &Pass<'_>, moved: &[[f32; 4]], means: &mut [f64]) {
        let kernel = pass.model.kernel.scaled();
        let (scale, one) = (Scale::new(&kernel), kernel.weight(0.0));
        let mut nothing = vec![(); self.stored.len()];
        let of = |j: usize| moved[j][3];
        for_chunks(pass.parallel, means, &mut nothing, &|c, means, ()| {
            for (k, mean) in means.iter_mut().enumerate() {
                let row = self.stored[c].liquid.row(k);
                let others = dispatch!(Level::new(), simd => row.over(simd, &scale, of));
                *mean = others + f64::from(of(c * CHUNK + k)) * one;
            }
        });
    }

    /// Accelerations by pressures, of which the packs hold `q`, exactly as partners book them; what static walls do; and the
    /// power of pressures, with the velocities `before` the substep.
    pub(crate) fn press(
        &self,
        pass: &Pass<'_>,
        walls: &Walls,
        (pack, before): (&[Pack], &[Vec3]),
        gained: &mut [Vec3],
        sums: &mut [Sums],
    ) {
        let kernel = pass.model.kernel.scaled();
        for_chunks(pass.parallel, gained, sums, &|c, gained, sums| {
            sums.pressed = 0.0;
            for (k, gained) in gained.iter_mut().enumerate() {
                let i = c * CHUNK + k;
                let own = &pack[i];
                let near = pass.lists.chunks()[c].row(k);
                let mut force = dispatch!(Level::new(), simd => by_pressures(simd, &kernel, pack, own, near));
                let held = self.rows[i].light <= 0.0;
                if !walls.near(i).is_empty() {
                    let [all, by_statics] = self.edge.force(walls, own, walls.near(i));
                    sums.walls = sums.walls.plus(Wrench { linear: by_statics, angular: cross(own.x, by_statics) });
                    force = add(force, all);
                }
                if held {
                    // What drives it bears what presses it.
                    sums.walls = sums.walls.minus(Wrench { linear: force, angular: cross(own.x, force) });
                    sums.driven -= dot(force, own.v);
                }
                *gained = scale(force, self.rows[i].light / own.volume);
                let after = add(own.v, scale(*gained, pass.dt));
                sums.pressed += 0.5 * dot(force, add(before[i], after));
            }
        });
    }
}
