//! Moves particles to the blocks they are in now: a stable counting sort, the same for any number of threads.

use rayon::prelude::*;

use crate::real::{Lanes, Real};
use crate::store::{Block, DEAD, FIELDS, Store, X, XLO, dead, key};

impl<R: Real> Store<R> {
    /// Sorts. Particles of a block keep their order; arrivals line up by the block they come from.
    ///
    /// Returns whether the list of blocks changed in place or part.
    pub(crate) fn sort(&mut self, parallel: bool) -> bool {
        let shifts = self.rebase();
        let (places, list) = self.destinations(&shifts);
        let mut blocks: Vec<Block> = list.iter().map(|&(_, b)| b).collect();
        let mut index = vec![0_u32; places.len()];
        let mut last = (u64::MAX, 0);
        for (index, &key) in index.iter_mut().zip(&places) {
            if key != last.0 {
                last = (key, list.partition_point(|&(k, _)| k < key));
            }
            *index = last.1 as u32;
            blocks[last.1].live += 1;
        }
        let mut quads = 0;
        for block in &mut blocks {
            block.first = quads;
            block.quads = block.live.div_ceil(4);
            quads += block.quads;
            block.live = 0;
        }
        let mut source = vec![DEAD; quads as usize * 4];
        for ((_, slot), &to) in self.each().zip(&index) {
            let block = &mut blocks[to as usize];
            source[(block.first * 4 + block.live) as usize] = slot as u32;
            block.live += 1;
        }
        self.move_to(&source, parallel);
        let same = |(a, b): (&Block, &Block)| a.at == b.at && a.part == b.part;
        let changed = blocks.len() != self.blocks.len() || !blocks.iter().zip(&self.blocks).all(same);
        self.blocks = blocks;
        changed
    }

    /// Makes positions relative to the block that holds the base node, and returns the way to it in blocks by slot.
    fn rebase(&mut self) -> Vec<[i8; 3]> {
        let mut shifts = vec![[0_i8; 3]; self.quads.len() * 4];
        for (quad, shifts) in self.quads.iter_mut().zip(shifts.chunks_exact_mut(4)) {
            for k in 0..3 {
                let (mut x, mut lo) = (quad[X + k].array(), quad[XLO + k].array());
                for lane in 0..4 {
                    let blocks = ((x[lane].f64() - 0.5) / 4.0).floor();
                    if blocks == 0.0 {
                        continue;
                    }
                    // Two-sum: the rounding of the new position joins the old one.
                    let exact = x[lane].f64() - 4.0 * blocks;
                    let rounded = R::of(exact);
                    lo[lane] += R::of(rounded.f64() - exact);
                    x[lane] = rounded;
                    shifts[lane][k] = blocks as i8;
                }
                quad[X + k] = R::V::from_array(x);
                quad[XLO + k] = R::V::from_array(lo);
            }
        }
        shifts
    }

    /// Key of each particle's block, in storage order, and the sorted list of blocks with it.
    fn destinations(&self, shifts: &[[i8; 3]]) -> (Vec<u64>, Vec<(u64, Block)>) {
        let mut places = Vec::with_capacity(self.len());
        let mut list: Vec<(u64, Block)> = Vec::new();
        let mut last = ([0; 3], u32::MAX, u64::MAX);
        for (block, slot) in self.each() {
            let at = [0, 1, 2].map(|k| block.at[k] + i32::from(shifts[slot][k]));
            if (at, block.part) != (last.0, last.1) {
                last = (at, block.part, key(at, block.part));
                list.push((last.2, Block { at, first: 0, quads: 0, live: 0, ..*block }));
            }
            places.push(last.2);
        }
        list.sort_unstable_by_key(|&(key, _)| key);
        list.dedup_by_key(|&mut (key, _)| key);
        (places, list)
    }

    /// Brings slot `source[i]` to slot `i`.
    fn move_to(&mut self, source: &[u32], parallel: bool) {
        let quads = gather::<R, FIELDS>(&self.quads, source, dead::<R>().0, parallel);
        if !self.grads.is_empty() {
            self.grads = gather::<R, 9>(&self.grads, source, dead::<R>().1, parallel);
        }
        let id = |&slot: &u32| if slot == DEAD { DEAD } else { self.ids[slot as usize / 4][slot as usize % 4] };
        self.ids = source.chunks_exact(4).map(|s| [id(&s[0]), id(&s[1]), id(&s[2]), id(&s[3])]).collect();
        for (slot, &id) in self.ids.as_flattened().iter().enumerate() {
            if id != DEAD {
                self.slot[id as usize] = slot as u32;
            }
        }
        self.quads = quads;
    }
}

fn gather<R: Real, const N: usize>(
    from: &[[R::V; N]],
    source: &[u32],
    dead: [R::V; N],
    parallel: bool,
) -> Vec<[R::V; N]> {
    let numbers: &[R] = bytemuck::cast_slice(from.as_flattened());
    let mut to = vec![dead; source.len() / 4];
    let fill = |(quad, slots): (&mut [R::V; N], &[u32])| {
        let mut lanes = quad.map(R::V::array);
        for (lane, &slot) in slots.iter().enumerate().filter(|&(_, &slot)| slot != DEAD) {
            let at = slot as usize / 4 * (4 * N) + slot as usize % 4;
            for (k, lanes) in lanes.iter_mut().enumerate() {
                lanes[lane] = numbers[at + 4 * k];
            }
        }
        *quad = lanes.map(R::V::from_array);
    };
    if parallel {
        to.par_iter_mut().with_min_len(256).zip(source.par_chunks_exact(4)).for_each(fill);
    } else {
        to.iter_mut().zip(source.chunks_exact(4)).for_each(fill);
    }
    to
}
