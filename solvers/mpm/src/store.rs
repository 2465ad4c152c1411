//! Particles in memory: groups of four ("quads"), ordered by blocks of 4³ grid cells and by body.
//!
//! Every block starts a new quad; lanes behind the last particle are dead (mass 0). A position is kept relative to
//! the block's corner, in cells, with the rounding error of its sum beside it (Kahan), so that it loses nothing over
//! millions of substeps wherever in the world it is. A block's particles may stray by up to one cell: the tiles of
//! `transfer` are that much larger.

use crate::real::{Lanes, Real};

/// Position in cells from the block's corner.
pub(crate) const X: usize = 0;
/// Rounding error of the position: the true one is `X - XLO`.
pub(crate) const XLO: usize = 3;
/// Velocity \[m/s\].
pub(crate) const V: usize = 6;
/// Velocity gradient \[1/s\], rows.
pub(crate) const C: usize = 9;
/// Elastic strain `B = b_e - I`: xx, yy, zz, xy, xz, yz.
pub(crate) const B: usize = 18;
/// Mass \[kg\].
pub(crate) const M: usize = 24;
/// Volume at rest \[m³\].
pub(crate) const VOL: usize = 25;
/// History of the material: equivalent plastic strain of a metal, gap of sand and liquids, plastic volume ratio of snow;
/// negative for a particle in quarantine.
pub(crate) const PAST: usize = 26;
/// Numbers of a particle.
pub(crate) const FIELDS: usize = 27;

/// Four particles.
pub(crate) type Quad<R> = [<R as Real>::V; FIELDS];
/// Total deformation gradients of four particles, rows.
pub(crate) type Grad<R> = [<R as Real>::V; 9];
/// Identity of a dead lane.
pub(crate) const DEAD: u32 = u32::MAX;

/// Particles of one part of a body in one block of cells. A part is all that a body has of one material.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Block {
    /// Corner, in blocks from the world origin.
    pub(crate) at: [i32; 3],
    /// Body.
    pub(crate) body: u32,
    /// Part, by which the materials are listed; of a body of one material, the body.
    pub(crate) part: u32,
    /// First quad.
    pub(crate) first: u32,
    /// Number of quads.
    pub(crate) quads: u32,
    /// Number of particles.
    pub(crate) live: u32,
}

impl Block {
    /// Its quads.
    pub(crate) fn range(&self) -> std::ops::Range<usize> {
        self.first as usize..(self.first + self.quads) as usize
    }
}

/// All particles.
#[derive(Clone, Debug, Default)]
pub(crate) struct Store<R: Real> {
    /// Blocks in Morton order, then by part.
    pub(crate) blocks: Vec<Block>,
    /// Particles.
    pub(crate) quads: Vec<Quad<R>>,
    /// Identity of each particle, [`DEAD`] for none.
    pub(crate) ids: Vec<[u32; 4]>,
    /// Total deformation gradients; empty when no body asks for them.
    pub(crate) grads: Vec<Grad<R>>,
    /// Lane of each identity: quad × 4 + lane.
    pub(crate) slot: Vec<u32>,
}

/// What a particle starts with.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Seed {
    /// \[m\].
    pub(crate) position: [f64; 3],
    /// \[m/s\].
    pub(crate) velocity: [f64; 3],
    /// \[1/s\], rows.
    pub(crate) gradient: [[f64; 3]; 3],
    /// \[kg\].
    pub(crate) mass: f64,
    /// \[m³\].
    pub(crate) volume: f64,
    /// History of its material.
    pub(crate) past: f64,
    /// Body.
    pub(crate) body: u32,
    /// Part.
    pub(crate) part: u32,
}

/// Block-order key: 18 bits of each block coordinate interleaved, then 10 bits of a body or a part.
pub(crate) fn key(at: [i32; 3], which: u32) -> u64 {
    let spread = |a: i32| {
        let mut x = (i64::from(a) + (1 << 17)) as u64 & 0x3_ffff;
        x = (x | (x << 32)) & 0x001f_0000_0000_ffff;
        x = (x | (x << 16)) & 0x001f_0000_ff00_00ff;
        x = (x | (x << 8)) & 0x100f_00f0_0f00_f00f;
        x = (x | (x << 4)) & 0x10c3_0c30_c30c_30c3;
        (x | (x << 2)) & 0x1249_2492_4924_9249
    };
    ((spread(at[0]) | (spread(at[1]) << 1) | (spread(at[2]) << 2)) << 10) | u64::from(which)
}

/// Largest block coordinate of a key.
pub(crate) const MAX_BLOCK: i32 = (1 << 17) - 2;

impl<R: Real> Store<R> {
    /// Particles in the order of their identities, for cells of size `dx`. `None` when one is too far out.
    pub(crate) fn new(seeds: &[Seed], dx: f64, with_gradients: bool) -> Option<Self> {
        let mut places = Vec::with_capacity(seeds.len());
        for (id, seed) in seeds.iter().enumerate() {
            let cells = seed.position.map(|x| x / dx);
            let at = cells.map(|x| ((x - 0.5) / 4.0).floor());
            let inside = |a: &f64| a.abs() < f64::from(MAX_BLOCK);
            if !at.iter().all(inside) {
                return None;
            }
            places.push((key(at.map(|a| a as i32), seed.part), id, at.map(|a| a as i32), cells));
        }
        places.sort_by_key(|&(key, id, ..)| (key, id));
        let mut store = Self { slot: vec![DEAD; seeds.len()], ..Self::default() };
        for same in places.chunk_by(|a, b| a.0 == b.0) {
            let (_, id, at, _) = same[0];
            let first = store.quads.len() as u32;
            let quads = same.len().div_ceil(4) as u32;
            store.blocks.push(Block {
                at,
                body: seeds[id].body,
                part: seeds[id].part,
                first,
                quads,
                live: same.len() as u32,
            });
            store.extend(quads as usize, with_gradients);
            for (i, (_, id, at, cells)) in same.iter().enumerate() {
                store.put(first as usize * 4 + i, *id as u32, &seeds[*id], *at, *cells);
            }
        }
        Some(store)
    }

    fn extend(&mut self, quads: usize, with_gradients: bool) {
        let (quad, grad) = dead::<R>();
        self.quads.extend(std::iter::repeat_n(quad, quads));
        self.ids.extend(std::iter::repeat_n([DEAD; 4], quads));
        if with_gradients {
            self.grads.extend(std::iter::repeat_n(grad, quads));
        }
    }

    fn put(&mut self, slot: usize, id: u32, seed: &Seed, at: [i32; 3], cells: [f64; 3]) {
        for k in 0..3 {
            let x = cells[k] - 4.0 * f64::from(at[k]);
            let rounded = self.set(slot, X + k, x);
            self.set(slot, XLO + k, rounded - x);
            self.set(slot, V + k, seed.velocity[k]);
            for j in 0..3 {
                self.set(slot, C + 3 * k + j, seed.gradient[k][j]);
            }
        }
        self.set(slot, M, seed.mass);
        self.set(slot, VOL, seed.volume);
        self.set(slot, PAST, seed.past);
        self.ids[slot / 4][slot % 4] = id;
        self.slot[id as usize] = slot as u32;
    }

    /// Becomes a copy of another, in the memory it has.
    pub(crate) fn copy_from(&mut self, other: &Self) {
        self.blocks.clone_from(&other.blocks);
        self.quads.clone_from(&other.quads);
        self.ids.clone_from(&other.ids);
        self.grads.clone_from(&other.grads);
        self.slot.clone_from(&other.slot);
    }

    /// Number of particles.
    pub(crate) fn len(&self) -> usize {
        self.slot.len()
    }

    /// One number of a particle.
    pub(crate) fn field(&self, slot: usize, field: usize) -> f64 {
        let numbers: &[R] = bytemuck::cast_slice(std::slice::from_ref(&self.quads[slot / 4]));
        numbers[field * 4 + slot % 4].f64()
    }

    /// Sets one number of a particle, and returns what it became.
    pub(crate) fn set(&mut self, slot: usize, field: usize, value: f64) -> f64 {
        let numbers: &mut [R] = bytemuck::cast_slice_mut(std::slice::from_mut(&mut self.quads[slot / 4]));
        let number = &mut numbers[field * 4 + slot % 4];
        *number = R::of(value);
        number.f64()
    }

    /// Three numbers of a particle.
    pub(crate) fn triple(&self, slot: usize, field: usize) -> [f64; 3] {
        [0, 1, 2].map(|k| self.field(slot, field + k))
    }

    /// Position of a particle of that block \[m\].
    pub(crate) fn position(&self, block: &Block, slot: usize, dx: f64) -> [f64; 3] {
        let (x, lo) = (self.triple(slot, X), self.triple(slot, XLO));
        [0, 1, 2].map(|k| (4.0 * f64::from(block.at[k]) + (x[k] - lo[k])) * dx)
    }

    /// Every particle as (block, slot), block by block.
    pub(crate) fn each(&self) -> impl Iterator<Item = (&Block, usize)> {
        self.blocks.iter().flat_map(|b| (0..b.live as usize).map(move |i| (b, b.first as usize * 4 + i)))
    }
}

/// Quads of dead lanes: mass 0 at a harmless place.
pub(crate) fn dead<R: Real>() -> (Quad<R>, Grad<R>) {
    let mut quad = [R::V::default(); FIELDS];
    quad[X..X + 3].fill(R::V::splat(R::of(1.0)));
    let mut grad = [R::V::default(); 9];
    for k in 0..3 {
        grad[4 * k] = R::V::splat(R::of(1.0));
    }
    (quad, grad)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_of_different_blocks_differ_and_keep_the_body() {
        let mut keys: Vec<u64> = Vec::new();
        for x in [-MAX_BLOCK, -1, 0, 1, 5, MAX_BLOCK] {
            for y in [-7, 0, 131_000] {
                for z in [-3, 2] {
                    keys.extend([0, 1, 1023].map(|body| key([x, y, z], body)));
                    assert_eq!(key([x, y, z], 1023) >> 10, key([x, y, z], 0) >> 10);
                }
            }
        }
        let count = keys.len();
        keys.sort_unstable();
        keys.dedup();
        assert_eq!(keys.len(), count);
    }

    #[test]
    fn positions_survive_far_from_the_origin() {
        let position = [1_234.567_890_123, -0.1, 3.3];
        let seed = Seed {
            position,
            velocity: [0.0; 3],
            gradient: [[0.0; 3]; 3],
            mass: 1.0,
            volume: 1.0,
            past: 0.0,
            body: 0,
            part: 0,
        };
        let store = Store::<f32>::new(&[seed], 0.01, false).expect("in range");
        let found = store.position(&store.blocks[0], 0, 0.01);
        for (a, b) in found.iter().zip(position) {
            // Two f32 numbers hold 48 bits of a position of up to 8 cells of 0.01 m.
            assert!((a - b).abs() < 1e-12, "{a} instead of {b}");
        }
    }
}
