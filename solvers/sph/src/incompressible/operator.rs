//! How full the space around each particle is, and how that changes with the velocities.
//!
//! The rate of the filled share is `Σ_j V_j (v_i - v_j)·∇W_ij/M_i` over particles and boundary particles (`wall`). `M_i` is
//! what that sum makes of the liquid swelling by one, a third of `-Σ_j V_j x_ij·∇W_ij`: with it the rate of a uniform
//! expansion is exact wherever the particles are. The force of pressures is the transpose, with `q = p/M`:
//! `-V_i (q_i G_i + Σ_j V_j q_j ∇W_ij)` and `G_i = Σ_j V_j ∇W_ij`; with it pressures are what the liquid presses with. The
//! kernel is scaled so that a cubic lattice is full.

use cosplat_core::boundary::{Vec3, Wrench, add, cross, dot, scale};
use wide::{f32x4, f64x4};

use crate::felt::{Felt, Rubs};
use crate::force::{Pass, Sums};
use crate::incompressible::contact::Contacts;
use crate::incompressible::pairs::{Pairs, Place, Scale};
use crate::incompressible::wall::Edge;
use crate::kernel::Kernel;
use crate::lanes::{Four, LANES, Pack, gather};
use crate::model::Model;
use crate::near::{CHUNK, for_chunks};
use crate::store::Store;
use crate::wall::Walls;

/// Range of `M`: half of a kernel beyond a surface is missing, but what is there does not swell to fill it.
const MOMENTS: [f64; 2] = [0.8, 1.2];

/// What a particle keeps over a substep.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Row {
    /// Gradient of the filled share \[1/m\].
    pull: Vec3,
    /// Filled share: all of it, and what the liquid and boundary particles fill.
    pub(crate) filled: f64,
    pub(crate) by_liquid: f64,
    pub(crate) by_walls: f64,
    /// Rate of the filled share's rate by the own pressure \[1/(Pa s²)\], and the same with what rigid partners answer to all
    /// that press them at once.
    pub(crate) diagonal: f64,
    /// Volume over mass \[m³/kg\].
    light: f64,
    /// One over `M`.
    pub(crate) swell: f64,
}

/// Pairs of a chunk, with the liquid and with boundary particles, and what its particles feel without pressure.
#[derive(Clone, Debug, Default)]
struct Stored {
    liquid: Pairs,
    walls: Pairs,
    felt: Vec<Felt>,
}

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

/// Sums over pairs with the liquid or with boundary particles.
#[derive(Clone, Copy, Debug, Default)]
struct Around {
    pull: Vec3,
    filled: f64,
    moment: f64,
    /// `Σ V²/m |∇W|²`.
    square: f64,
}

/// Sums over the pairs of `own` with a list, which are kept; `light` is what moves of a neighbour \[m³/kg\], and `also` takes
/// four with the slope of the kernel times their volumes.
#[inline]
fn around(
    kernel: &Kernel,
    own: &Pack,
    packs: &[Pack],
    list: &[u32],
    light: impl Fn(u32) -> f64,
    kept: &mut Pairs,
    mut also: impl FnMut(&Four, &[u32], f64x4),
) -> Around {
    let (mut pull, mut filled) = ([f64x4::ZERO; 3], f64x4::ZERO);
    let (mut moment, mut square) = (f64x4::ZERO, f64x4::ZERO);
    for j in list.chunks_exact(LANES) {
        let others = Four::new(own, packs, j);
        let (slope, weight) = (kernel.slopes(others.r), kernel.weights(others.r));
        let all = others.volume * slope;
        filled += others.volume * weight;
        pull = [0, 1, 2].map(|k| pull[k] + others.apart[k] * all);
        let length = all * others.square;
        moment -= length;
        also(&others, j, all);
        square += f64x4::new([light(j[0]), light(j[1]), light(j[2]), light(j[3])]) * length * slope;
        kept.push(j, kernel.inside(others.r));
    }
    kept.end(packs.len() - 1);
    let [filled, moment, square] = [filled, moment, square].map(f64x4::reduce_add);
    Around { pull: gather(pull), filled, moment, square }
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
        let (model, kernel) = (pass.model, pass.model.kernel.scaled());
        let n = store.len();
        let light = |i: u32| self.light[i as usize];
        // Forces of viscosity have the kernel as it is.
        let (scale, plain) = (Scale::new(&kernel), model.kernel.slope / kernel.slope);
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
                let i = c * CHUNK + k;
                let own = &pack[i];
                let (list, mut rubs) = (pass.lists.chunks()[c].row(k), Rubs::new(pass, store, own, i));
                let rub = |others: &Four, j: &[u32], slope| rubs.add(&kernel, others, j, slope);
                let liquid = around(&kernel, own, pack, list, light, &mut stored.liquid, rub);
                let nothing = |_: &Four, _: &[u32], _| ();
                let solid = around(&kernel, own, walls.packs(), walls.near(i), |_| 0.0, &mut stored.walls, nothing);
                stored.felt.push(rubs.felt([0.0; 3], own.volume * plain));
                let pull = add(liquid.pull, solid.pull);
                // The pressure of a boundary particle follows: about as if its gradient counted twice.
                let twice = add(pull, solid.pull);
                let by_liquid = liquid.filled + own.volume * kernel.weight(0.0);
                let moment = (liquid.moment + solid.moment) / 3.0;
                let swell = 1.0 / moment.clamp(MOMENTS[0], MOMENTS[1]);
                let light = light(i as u32);
                let square = light * dot(pull, pull).max(dot(twice, twice)) + own.volume * liquid.square;
                *row = Row {
                    pull,
                    filled: by_liquid + solid.filled,
                    by_liquid,
                    by_walls: solid.filled,
                    diagonal: square * swell * swell,
                    light,
                    swell,
                };
            }
        });
    }

    /// What a particle feels without pressure.
    pub(crate) fn felt(&self, i: usize) -> Felt {
        self.stored[i / CHUNK].felt[i % CHUNK]
    }

    /// Adds to the diagonal what rigid partners would answer, as a bound over the row: a light one answers to all that
    /// press it at once.
    pub(crate) fn weigh(&mut self, contacts: &mut Contacts, pack: &[Pack]) {
        let rows = &mut self.rows;
        contacts.bound(pack, |i, more| rows[i].diagonal += more * rows[i].swell * rows[i].swell);
    }

    /// Changes of velocities over `dt` by pressures, times volumes \[m⁴/s\]; `pushed` are the products `q V` \[J\].
    pub(crate) fn accelerate(&mut self, pass: &Pass<'_>, pack: &[Pack], pushed: &[f32], moved: &mut [f32x4]) {
        let (n, scale) = (self.rows.len(), Scale::new(&pass.model.kernel.scaled()));
        self.edge.press(pass, pushed);
        let mut nothing = vec![(); self.stored.len()];
        let (pressed, brims) = (self.edge.pressed(), self.edge.places());
        for_chunks(pass.parallel, &mut moved[..n], &mut nothing, &|c, moved, ()| {
            let Stored { liquid, walls, .. } = &self.stored[c];
            for (k, moved) in moved.iter_mut().enumerate() {
                let i = c * CHUNK + k;
                let (place, row) = (self.places[i], &self.rows[i]);
                let by_liquid = liquid.row(k).along(&scale, place, &self.places, pushed);
                let by_walls = walls.row(k).along(&scale, place, brims, pressed);
                let (own, factor) = (f64::from(pushed[i]), -row.light * pass.dt);
                // `q_i V_i G_i` holds the volume already.
                let one =
                    |k: usize| (factor * (own * row.pull[k] + pack[i].volume * (by_liquid[k] + by_walls[k]))) as f32;
                *moved = f32x4::new([one(0), one(1), one(2), 0.0]);
            }
        });
    }

    /// Rates of the filled shares \[1/s\] of particles whose velocities times volume are `moved`, and by the twists of rigid
    /// partners, their own or those that pressures have given.
    pub(crate) fn rates(
        &mut self,
        pass: &Pass<'_>,
        pack: &[Pack],
        contacts: &Contacts,
        own: bool,
        (moved, rates): (&[f32x4], &mut [f64]),
    ) {
        let scale = Scale::new(&pass.model.kernel.scaled());
        self.edge.squeeze(pass, &self.places, contacts, own, moved);
        let mut nothing = vec![(); self.stored.len()];
        let back = self.edge.back();
        for_chunks(pass.parallel, rates, &mut nothing, &|c, rates, ()| {
            let Stored { liquid, walls, .. } = &self.stored[c];
            for (k, rate) in rates.iter_mut().enumerate() {
                let i = c * CHUNK + k;
                let row = &self.rows[i];
                let others = liquid.row(k).across(&scale, self.places[i], &self.places, moved);
                let by_walls = walls.row(k).over(&scale, |b| back[b]);
                let [x, y, z, _] = moved[i].to_array().map(f64::from);
                let own = dot([x, y, z], row.pull) / pack[i].volume;
                *rate = row.swell * (own - others + by_walls);
            }
        });
        contacts.rates(own, |i, rate| rates[i] += self.rows[i].swell * rate);
    }

    /// Means around each particle of the fourth component of `moved`.
    pub(crate) fn means(&self, pass: &Pass<'_>, moved: &[f32x4], means: &mut [f64]) {
        let kernel = pass.model.kernel.scaled();
        let (scale, one) = (Scale::new(&kernel), kernel.weight(0.0));
        let mut nothing = vec![(); self.stored.len()];
        let of = |j: usize| moved[j].to_array()[3];
        for_chunks(pass.parallel, means, &mut nothing, &|c, means, ()| {
            for (k, mean) in means.iter_mut().enumerate() {
                *mean = self.stored[c].liquid.row(k).over(&scale, of) + f64::from(of(c * CHUNK + k)) * one;
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
                let mut force = [f64x4::ZERO; 3];
                for j in pass.lists.chunks()[c].row(k).chunks_exact(LANES) {
                    let others = Four::new(own, pack, j);
                    let along =
                        kernel.slopes(others.r) * others.volume * (f64x4::splat(own.pressure) + others.pressure);
                    force = [0, 1, 2].map(|k| force[k] - others.apart[k] * along);
                }
                let mut force = scale(gather(force), own.volume);
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
