//! How full the space around each particle is, and how that changes with the velocities.
//!
//! The rate of the filled share is `Σ_j V_j (v_i - v_j)·∇W_ij` over particles and boundary particles (`wall`), and the force
//! of pressures its transpose, `-V_i (p_i G_i + Σ_j V_j p_j ∇W_ij)` with `G_i = Σ_j V_j ∇W_ij`. The kernel is scaled so that a
//! cubic lattice is full.

use cosplat_core::boundary::{Vec3, dot, scale};
use wide::f64x4;

use crate::force::Pass;
use crate::incompressible::contact::Contacts;
use crate::incompressible::wall::Edge;
use crate::lanes::{Four, LANES, Pack, gather};
use crate::near::{CHUNK, for_chunks};
use crate::store::Store;
use crate::wall::Walls;

/// What a particle keeps over a substep.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Row {
    /// Gradient of the filled share \[1/m\].
    pull: Vec3,
    /// Filled share.
    pub(crate) filled: f64,
    /// Rate of the filled share's rate by the own pressure \[1/(Pa s²)\].
    pub(crate) diagonal: f64,
    /// Volume over mass \[m³/kg\].
    light: f64,
}

/// Gradients of the kernel over one substep.
#[derive(Clone, Debug, Default)]
pub(crate) struct Operator {
    pub(crate) rows: Vec<Row>,
    pub(crate) edge: Edge,
    /// Of each group of neighbours, in the order of the lists \[1/m⁴\].
    gradients: Vec<Vec<[f64x4; 3]>>,
}

impl Operator {
    /// Measures all that depends on the places alone.
    pub(crate) fn measure(&mut self, pass: &Pass<'_>, store: &Store, pack: &[Pack], walls: &Walls) {
        let (model, kernel) = (pass.model, pass.model.kernel.scaled());
        let n = store.len();
        let light = |i: u32| {
            let id = store.id.get(i as usize).map_or(0, |&id| id as usize);
            1.0 / model.liquids[model.body[id] as usize].rho
        };
        self.edge.measure(pass, pack, walls, &store.warm);
        self.rows.resize(n, Row::default());
        self.gradients.resize(n.div_ceil(CHUNK), Vec::new());
        let edge = &self.edge;
        for_chunks(pass.parallel, &mut self.rows, &mut self.gradients, &|c, rows, gradients| {
            gradients.clear();
            for (k, row) in rows.iter_mut().enumerate() {
                let i = c * CHUNK + k;
                let own = &pack[i];
                let (mut pull, mut filled, mut square) = ([f64x4::ZERO; 3], f64x4::ZERO, f64x4::ZERO);
                for j in pass.lists.chunks()[c].row(k).chunks_exact(LANES) {
                    let others = Four::new(own, pack, j);
                    let slope = kernel.slopes(others.r);
                    let gradient = others.apart.map(|a| a * slope);
                    filled += others.volume * kernel.weights(others.r);
                    pull = [0, 1, 2].map(|k| pull[k] + others.volume * gradient[k]);
                    let length = gradient[0] * gradient[0] + gradient[1] * gradient[1] + gradient[2] * gradient[2];
                    square += others.volume * f64x4::new([0, 1, 2, 3].map(|l| light(j[l]))) * length;
                    gradients.push(gradient);
                }
                let (by_walls, filled_by_walls) = edge.of(walls, i);
                let pull = [0, 1, 2].map(|k| gather(pull)[k] + by_walls[k]);
                // The pressure of a boundary particle follows: about as if its gradient counted twice.
                let twice = [0, 1, 2].map(|k| pull[k] + by_walls[k]);
                let light = light(i as u32);
                *row = Row {
                    pull,
                    filled: filled.reduce_add() + filled_by_walls + own.volume * kernel.weight(0.0),
                    diagonal: light * dot(pull, pull).max(dot(twice, twice)) + own.volume * square.reduce_add(),
                    light,
                };
            }
        });
    }

    /// Adds to the diagonal what rigid partners would answer, as a bound over the row: a light one answers to all that
    /// press it at once.
    pub(crate) fn weigh(&mut self, contacts: &mut Contacts, pack: &[Pack]) {
        contacts.bound(pack, |i, more| self.rows[i].diagonal += more);
    }

    /// Accelerations by pressures, of which `pushed` are the products with volumes \[J\], and the same times volume.
    pub(crate) fn accelerate(
        &mut self,
        pass: &Pass<'_>,
        walls: &Walls,
        pressure: &[f64],
        pushed: &[f64],
        acceleration: &mut [Vec3],
    ) {
        let n = self.rows.len();
        self.edge.press(pass, walls, pushed);
        let mut nothing = vec![(); self.gradients.len()];
        for_chunks(pass.parallel, &mut acceleration[..n], &mut nothing, &|c, acceleration, ()| {
            let mut groups = self.gradients[c].iter();
            for (k, acceleration) in acceleration.iter_mut().enumerate() {
                let row = &self.rows[c * CHUNK + k];
                let mut sum = [f64x4::ZERO; 3];
                for j in pass.lists.chunks()[c].row(k).chunks_exact(LANES) {
                    let Some(g) = groups.next() else { break };
                    let u = f64x4::new([0, 1, 2, 3].map(|l| pushed[j[l] as usize]));
                    sum = [0, 1, 2].map(|k| sum[k] + u * g[k]);
                }
                let (sum, p) = (gather(sum), pressure[c * CHUNK + k]);
                let by_walls = self.edge.pull(walls, c * CHUNK + k);
                *acceleration = [0, 1, 2].map(|k| -row.light * (p * row.pull[k] + sum[k] + by_walls[k]));
            }
        });
    }

    /// Rate of the filled share of each particle where they move by `v`, of which `moved` are the products with volumes.
    pub(crate) fn rates(
        &mut self,
        pass: &Pass<'_>,
        walls: &Walls,
        contacts: &Contacts,
        own: bool,
        flow: &mut Flow<'_>,
    ) {
        let Flow { v, moved, rates } = flow;
        self.edge.squeeze(pass, walls, contacts, own, moved);
        let mut nothing = vec![(); self.gradients.len()];
        for_chunks(pass.parallel, rates, &mut nothing, &|c, rates, ()| {
            let mut groups = self.gradients[c].iter();
            for (k, rate) in rates.iter_mut().enumerate() {
                let i = c * CHUNK + k;
                let mut sum = f64x4::ZERO;
                for j in pass.lists.chunks()[c].row(k).chunks_exact(LANES) {
                    let Some(g) = groups.next() else { break };
                    let [a, b, c, d] = [0, 1, 2, 3].map(|l| &moved[j[l] as usize]);
                    for k in 0..3 {
                        sum += f64x4::new([a[k], b[k], c[k], d[k]]) * g[k];
                    }
                }
                *rate = dot(v[i], self.rows[i].pull) - sum.reduce_add() + self.edge.rate(walls, i);
            }
        });
        contacts.rates(own, |i, rate| rates[i] += rate);
    }

    /// Impulse of static walls by pressures over a second on particle `i` \[N\], where pushed are the products of pressure and
    /// volume.
    pub(crate) fn by_statics(&self, walls: &Walls, pack: &[Pack], i: usize, pushed: &[f64]) -> Vec3 {
        let [own, others] = self.edge.statics(walls, i);
        [0, 1, 2].map(|k| scale(own, -pushed[i])[k] - pack[i].volume * others[k])
    }
}

/// Velocities, their products with volumes, and what comes of them.
pub(crate) struct Flow<'a> {
    pub(crate) v: &'a [Vec3],
    pub(crate) moved: &'a [Vec3],
    pub(crate) rates: &'a mut [f64],
}
