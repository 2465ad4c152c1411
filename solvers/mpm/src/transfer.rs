//! Transfers between particles and their tile: quadratic MLS-MPM with affine velocities (APIC).
//!
//! Kernel per axis: base node `floor(x - 1/2)`, `f = x - base` in cells, weights `(1.5-f)²/2`, `3/4-(f-1)²`,
//! `(f-1/2)²/2`. With `Q = m C - dt V0 (4/dx²) τ`, a node gets mass `w m` and momentum `w (m v + Q (x_i - x_p))`; back,
//! `v = Σ w v_i`, `C = (4/dx²) Σ w v_i (x_i - x_p)ᵀ`. Sources: Hu et al., "A moving least squares material point method"
//! (2018); Jiang et al., "The affine particle-in-cell method" (2015).
//!
//! What is transferred and not the grid's — motion that changes within a cell — is lost each time. Bodies that flow keep
//! part of it, by a second transfer without stress (`particles::remember`).
//!
//! The sums over 27 nodes are nested by axis: about 110 four-lane operations each way and particle.

use crate::fbar::{Average, weighted};
use crate::law::Law;
use crate::math::{Full, Sym, all};
use crate::real::{Lanes, Real};
use crate::store::{B, C, M, PAST, Quad, V, VOL, X};
use crate::tile::{EDGE, Extent, Tile};

/// Nodes between the first and the last of a particle's 27, and one.
const SPAN: usize = 2 * EDGE * EDGE + 2 * EDGE + 3;

/// Weights of four particles.
struct Weights<R: Real> {
    /// By axis and node.
    weight: [[[R; 4]; 3]; 3],
    /// Distance from the middle node, in cells, by axis.
    from_middle: [R::V; 3],
    /// Base node, as number, by axis.
    base: [R::V; 3],
    /// Base node in the tile.
    node: [usize; 4],
}

impl<R: Real> Weights<R> {
    #[inline]
    fn new(x: &[R::V]) -> Self {
        let [half, most] = [0.5, 0.75].map(all::<R>);
        let mut weight = [[[R::default(); 4]; 3]; 3];
        let (mut from_middle, mut base) = ([R::V::default(); 3], [R::V::default(); 3]);
        let mut node = [0_usize; 4];
        for axis in 0..3 {
            // The tile begins one node below the block: base node in the tile = floor(x - 1/2) + 1.
            let (floor, index) = (x[axis] + half).whole();
            let d = x[axis] - floor;
            let (low, high) = (half - d, half + d);
            weight[axis] = [(half * low * low).array(), (most - d * d).array(), (half * high * high).array()];
            (from_middle[axis], base[axis]) = (d, floor);
            for (node, i) in node.iter_mut().zip(index) {
                *node = *node * EDGE + i as usize;
            }
        }
        Self { weight, from_middle, base, node }
    }

    #[inline]
    fn lane(&self, lane: usize) -> [[R::V; 3]; 3] {
        // Written out: `map` on arrays is not inlined.
        let w = |axis: usize, node: usize| R::V::splat(self.weight[axis][node][lane]);
        [[w(0, 0), w(0, 1), w(0, 2)], [w(1, 0), w(1, 1), w(1, 2)], [w(2, 0), w(2, 1), w(2, 2)]]
    }
}

/// Strain of four particles.
#[inline]
pub(crate) fn strain<R: Real>(quad: &Quad<R>) -> Sym<R> {
    [quad[B], quad[B + 1], quad[B + 2], quad[B + 3], quad[B + 4], quad[B + 5]]
}

/// Velocity gradient of four particles.
#[inline]
pub(crate) fn gradient<R: Real>(quad: &Quad<R>) -> Full<R> {
    [0, 1, 2].map(|i| [quad[C + 3 * i], quad[C + 3 * i + 1], quad[C + 3 * i + 2]])
}

/// Particles of one block to its tile, and without stress to `before`. `extent` holds the nodes in use before, and after.
pub(crate) fn to_tile<R: Real>(
    quads: &[Quad<R>],
    live: usize,
    (law, average): (&Law<R>, Option<Average<R>>),
    (dt, dx): (f64, f64),
    (tile, mut before): (&mut Tile<R>, Option<&mut Tile<R>>),
    extent: &mut Extent,
) {
    extent.clear::<R>(tile);
    if let Some(before) = &mut before {
        extent.clear::<R>(before);
    }
    let (dx_v, stress_factor) = (all::<R>(dx), all::<R>(dt * 4.0 / dx));
    let mut reach = Reach::<R>::default();
    for (i, quad) in quads.iter().enumerate() {
        let w = Weights::<R>::new(&quad[X..X + 3]);
        reach.add(&w);
        let c = gradient::<R>(quad);
        let mut tau = law.stress(&strain::<R>(quad), quad[PAST], &c);
        if let Some(average) = average {
            let pressure = average.pressure(quad, (live - 4 * i).min(4));
            tau[..3].iter_mut().for_each(|on| *on += pressure);
        }
        let (affine, kt) = (quad[M] * dx_v, quad[VOL] * stress_factor);
        let tau = [[tau[0], tau[3], tau[4]], [tau[3], tau[1], tau[5]], [tau[4], tau[5], tau[2]]];
        let q = [0, 1, 2].map(|a| [0, 1, 2].map(|b| affine * c[a][b] - kt * tau[a][b]));
        let live = (live - 4 * i).min(4);
        scatter_quad::<R>(tile, &w, quad, &q, live);
        if let Some(before) = &mut before {
            scatter_quad::<R>(before, &w, quad, &c.map(|row| row.map(|c| affine * c)), live);
        }
    }
    *extent = reach.extent();
}

/// Base nodes of the particles of a block.
struct Reach<R: Real> {
    low: [R::V; 3],
    high: [R::V; 3],
}

impl<R: Real> Default for Reach<R> {
    fn default() -> Self {
        Self { low: [all::<R>(EDGE as f64); 3], high: [R::V::default(); 3] }
    }
}

impl<R: Real> Reach<R> {
    #[inline]
    fn add(&mut self, w: &Weights<R>) {
        for axis in 0..3 {
            self.low[axis] = self.low[axis].min(w.base[axis]);
            self.high[axis] = self.high[axis].max(w.base[axis]);
        }
    }

    /// Nodes that they reach.
    fn extent(&self) -> Extent {
        let least = |v: R::V| v.array().iter().fold(EDGE as u8, |a, b| a.min(b.f64() as u8));
        let most = |v: R::V| v.array().iter().fold(0, |a, b| a.max(b.f64() as u8 + 3));
        Extent { lo: self.low.map(least), hi: self.high.map(most) }
    }
}

/// Volumes of the particles of one block and the logarithms of their ratios to a tile, in its first two numbers.
pub(crate) fn averages_to_tile<R: Real>(
    quads: &[Quad<R>],
    live: usize,
    cells: f64,
    tile: &mut Tile<R>,
    extent: &mut Extent,
) {
    extent.clear::<R>(tile);
    let (mut reach, zero) = (Reach::<R>::default(), R::V::default());
    for (i, quad) in quads.iter().enumerate() {
        let w = Weights::<R>::new(&quad[X..X + 3]);
        reach.add(&w);
        let [logs, volume] = weighted::<R>(quad, cells);
        let middle = R::V::transpose([logs, volume, zero, zero]);
        for (lane, &middle) in middle.iter().enumerate().take(live - 4 * i) {
            scatter::<R>(tile, w.node[lane], &w.lane(lane), middle, [zero; 3]);
        }
    }
    *extent = reach.extent();
}

/// Average of the first number of a tile at four particles.
#[inline]
pub(crate) fn average_from_tile<R: Real>(quad: &Quad<R>, live: usize, tile: &Tile<R>) -> R::V {
    let w = Weights::<R>::new(&quad[X..X + 3]);
    let mut out = [R::default(); 4];
    for (lane, out) in out.iter_mut().enumerate().take(live) {
        *out = collect::<R>(tile, w.node[lane], &w.lane(lane))[0].array()[0];
    }
    R::V::from_array(out)
}

/// Momentum and mass of four particles, with the momentum `q` per cell of distance.
#[inline]
fn scatter_quad<R: Real>(tile: &mut Tile<R>, w: &Weights<R>, quad: &Quad<R>, q: &Full<R>, live: usize) {
    let (m, d) = (quad[M], &w.from_middle);
    // At the middle node.
    let p = [0, 1, 2].map(|a| m * quad[V + a] - (q[a][0] * d[0] + q[a][1] * d[1] + q[a][2] * d[2]));
    let zero = R::V::default();
    let middle = R::V::transpose([p[0], p[1], p[2], m]);
    let slope = [0, 1, 2].map(|b| R::V::transpose([q[0][b], q[1][b], q[2][b], zero]));
    for lane in 0..live {
        let slopes = [slope[0][lane], slope[1][lane], slope[2][lane]];
        scatter::<R>(tile, w.node[lane], &w.lane(lane), middle[lane], slopes);
    }
}

#[inline]
fn scatter<R: Real>(tile: &mut Tile<R>, node: usize, w: &[[R::V; 3]; 3], middle: R::V, [sx, sy, sz]: [R::V; 3]) {
    let Some(nodes) = tile[node..].first_chunk_mut::<SPAN>() else { return };
    for (i, along_x) in [middle - sx, middle, middle + sx].into_iter().enumerate() {
        let (p, y, z) = (along_x * w[0][i], sy * w[0][i], sz * w[0][i]);
        for (j, along_y) in [p - y, p, p + y].into_iter().enumerate() {
            let (p, z) = (along_y * w[1][j], z * w[1][j]);
            let row = (i * EDGE + j) * EDGE;
            nodes[row] += (p - z) * w[2][0];
            nodes[row + 1] += p * w[2][1];
            nodes[row + 2] += (p + z) * w[2][2];
        }
    }
}

/// Velocities of four particles and their gradients from the tile, and the mass of a cell there.
#[inline]
pub(crate) fn from_tile<R: Real>(
    quad: &Quad<R>,
    live: usize,
    inverse_dx: f64,
    tile: &Tile<R>,
) -> ([R::V; 3], Full<R>, R::V) {
    let w = Weights::<R>::new(&quad[X..X + 3]);
    let mut out = [[R::V::default(); 4]; 4];
    for (lane, out) in out.iter_mut().enumerate().take(live) {
        *out = collect::<R>(tile, w.node[lane], &w.lane(lane));
    }
    let column = |k: usize| R::V::transpose([out[0][k], out[1][k], out[2][k], out[3][k]]);
    let (v, x, y, z) = (column(0), column(1), column(2), column(3));
    let factor = all::<R>(4.0 * inverse_dx);
    let d = &w.from_middle;
    let row = |a: usize| [(x[a] - d[0] * v[a]) * factor, (y[a] - d[1] * v[a]) * factor, (z[a] - d[2] * v[a]) * factor];
    ([v[0], v[1], v[2]], [row(0), row(1), row(2)], v[3])
}

/// `Σ w v_i` and `Σ w v_i n` with `n` = -1, 0, 1 nodes from the middle, along each axis.
#[inline]
fn collect<R: Real>(tile: &Tile<R>, node: usize, w: &[[R::V; 3]; 3]) -> [R::V; 4] {
    let Some(nodes) = tile[node..].first_chunk::<SPAN>() else { return [R::V::default(); 4] };
    let plane = |i: usize| {
        let row = |j: usize| {
            let row = (i * EDGE + j) * EDGE;
            let (low, high) = (nodes[row] * w[2][0], nodes[row + 2] * w[2][2]);
            ((low + high + nodes[row + 1] * w[2][1]) * w[1][j], (high - low) * w[1][j])
        };
        let (a, b, c) = (row(0), row(1), row(2));
        [(a.0 + c.0 + b.0) * w[0][i], (c.0 - a.0) * w[0][i], (a.1 + c.1 + b.1) * w[0][i]]
    };
    let (a, b, c) = (plane(0), plane(1), plane(2));
    [a[0] + c[0] + b[0], c[0] - a[0], a[1] + c[1] + b[1], a[2] + c[2] + b[2]]
}
