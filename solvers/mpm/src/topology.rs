//! Which grid blocks exist, and which particle blocks reach them.
//!
//! A particle block writes and reads a tile of 8³ nodes: its own 4³ nodes, one layer below and three above (a quadratic
//! kernel reaches two nodes past the base node; one more on each side lets particles stray by a cell between sorts).
//! Each body has its own velocity at a node, so a grid block is an entry (place, body). Entries of one place lie
//! together and form a group. Parts of a body have blocks of particles of their own and share its nodes: so they stick.

use std::ops::Range;

use crate::store::{Block, key};

/// No entry or no block.
pub(crate) const NONE: u32 = u32::MAX;

/// Tile nodes along an axis that lie in the neighbour at -1, 0, +1, and the first of them inside that neighbour.
pub(crate) const REACH: [(Range<usize>, usize); 3] = [(0..1, 3), (1..5, 0), (5..8, 0)];

/// A body's grid block.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Entry {
    /// Corner, in blocks from the world origin.
    pub(crate) at: [i32; 3],
    /// Body.
    pub(crate) body: u32,
}

/// Grid blocks and their neighbours.
#[derive(Clone, Debug, Default)]
pub(crate) struct Topology {
    /// In Morton order, then by body.
    pub(crate) entries: Vec<Entry>,
    /// Particle blocks that reach an entry, by the offset (block − entry), see [`offset`]: the first at each.
    pub(crate) sources: Vec<[u32; 27]>,
    /// By particle block, the next of the same body at the same place: another part of it.
    pub(crate) next: Vec<u32>,
    /// Entries that a particle block reaches, by the offset (entry − block).
    pub(crate) reached: Vec<[u32; 27]>,
    /// First entry of each group, and the end.
    pub(crate) groups: Vec<u32>,
}

/// Offset `i` of 27 as components in -1..=1.
pub(crate) fn offset(i: usize) -> [i32; 3] {
    [i / 9, i / 3 % 3, i % 3].map(|k| i32::from(k as u8) - 1)
}

impl Topology {
    /// Topology of a sorted list of blocks.
    pub(crate) fn new(blocks: &[Block]) -> Self {
        let moved = |at: [i32; 3], by: [i32; 3]| [at[0] + by[0], at[1] + by[1], at[2] + by[2]];
        let mut keyed: Vec<(u64, Entry)> = Vec::with_capacity(blocks.len() * 27);
        for block in blocks {
            keyed.extend((0..27).map(|i| {
                let at = moved(block.at, offset(i));
                (key(at, block.body), Entry { at, body: block.body })
            }));
        }
        keyed.sort_unstable_by_key(|&(key, _)| key);
        keyed.dedup_by_key(|&mut (key, _)| key);
        let (mut sources, mut next) = (vec![[NONE; 27]; keyed.len()], vec![NONE; blocks.len()]);
        let mut reached = vec![[NONE; 27]; blocks.len()];
        for (b, block) in blocks.iter().enumerate() {
            for (i, reached) in reached[b].iter_mut().enumerate() {
                let wanted = key(moved(block.at, offset(i)), block.body);
                if let Ok(entry) = keyed.binary_search_by_key(&wanted, |&(key, _)| key) {
                    *reached = entry as u32;
                    append(&mut sources[entry][26 - i], &mut next, b as u32);
                }
            }
        }
        let starts = |&i: &usize| i == 0 || keyed[i].1.at != keyed[i - 1].1.at;
        let mut groups: Vec<u32> = (0..keyed.len()).filter(starts).map(|i| i as u32).collect();
        groups.push(keyed.len() as u32);
        Self { entries: keyed.into_iter().map(|(_, e)| e).collect(), sources, next, reached, groups }
    }

    /// Entries of a group.
    pub(crate) fn group(&self, group: usize) -> Range<usize> {
        self.groups[group] as usize..self.groups[group + 1] as usize
    }

    /// Number of groups.
    pub(crate) fn group_count(&self) -> usize {
        self.groups.len().saturating_sub(1)
    }

    /// Entry of a body at a place.
    pub(crate) fn find(&self, at: [i32; 3], body: u32) -> Option<usize> {
        let wanted = key(at, body);
        self.entries.binary_search_by_key(&wanted, |e| key(e.at, e.body)).ok()
    }
}

/// Ends the chain that starts at `first` with a block, once: all entries around a place have the same chain.
fn append(first: &mut u32, next: &mut [u32], block: u32) {
    if *first == NONE {
        *first = block;
        return;
    }
    let mut last = *first;
    while next[last as usize] != NONE {
        last = next[last as usize];
    }
    if last != block {
        next[last as usize] = block;
    }
}
