//! Two tiles of cloth, and for how long nothing new of them can touch.
//!
//! A couple that is far apart sleeps until the fastest of all cloth could have brought it near. Of one that is near it is
//! known how much further apart than what touches those of its pieces are that are not listed; how fast the two have
//! moved relative to each other since is taken from that, and only when it is used up are they looked at again.

use cosplat_core::boundary::norm;

use crate::own::{Candidate, WATCHED};
use crate::pair::Pair;
use crate::pieces::{Bounds, ROUNDED, Room, Search, gap};

/// What is listed beyond what may close in a substep: so many times that, and the least and most of it in shortest edges.
const LISTED: (f64, [f64; 2]) = (3.0, [0.05, 0.45]);
/// Distance from which a couple sleeps, in ways that the fastest two vertices may close in a substep.
const ASLEEP: f64 = 2.0;

/// What a look at all couples goes by.
pub(crate) struct Now<'a> {
    pub(crate) search: &'a Search<'a>,
    /// Boxes of the places and of the velocities of all tiles \[m, m/s\].
    pub(crate) places: Vec<Bounds>,
    pub(crate) speeds: Vec<Bounds>,
    /// Distance below which pieces touch that do not move relative to each other \[m\].
    pub(crate) touching: f64,
    /// Length of the substep \[s\], and the most that may close in it \[m\].
    pub(crate) h: f64,
    pub(crate) fastest: f64,
    /// How far any two vertices may have moved towards each other since tiles were gathered \[m\].
    pub(crate) moved: f64,
    /// Shortest edge \[m\].
    pub(crate) shortest: f64,
}

impl Now<'_> {
    /// How much further apart than what touches the boxes of two tiles are \[m\].
    pub(crate) fn left(&self, a: usize, b: usize) -> f64 {
        gap(&self.places[a], &self.places[b]) - self.touching
    }
}

/// A tile near another one, or that one itself.
#[derive(Clone, Debug)]
struct Couple {
    other: u32,
    /// Whether a block of tiles holds both.
    beside: bool,
    /// How much further than what touches those of their pieces are apart that are not listed: when they were looked at, and
    /// now at least \[m\].
    room: f64,
    left: f64,
    /// What may close in this substep \[m\].
    closing: f64,
    is_due: bool,
    list: Vec<Candidate>,
}

impl Couple {
    /// Nothing of them is nearer than `left` beyond what touches \[m\].
    fn rest(&mut self, left: f64) {
        (self.room, self.left, self.is_due) = (left, left, false);
        self.list.clear();
    }
}

/// A tile that is far from another one.
#[derive(Clone, Copy, Debug)]
struct Far {
    other: u32,
    /// How far any two vertices may move before the two can touch \[m\].
    until: f64,
}

/// All tiles from one of them on that are watched with it.
#[derive(Clone, Debug, Default)]
pub(crate) struct Row {
    /// By their numbers.
    near: Vec<Couple>,
    far: Vec<Far>,
}

impl Row {
    /// Takes the tiles `found` near the tile `a`, in the order of their numbers; what is known of those that were near
    /// before is kept. Nothing has moved since.
    pub(crate) fn gather(&mut self, a: usize, found: &[u32], now: &Now) {
        self.far.clear();
        self.far.reserve(found.len());
        let mut before = std::mem::take(&mut self.near).into_iter().peekable();
        for &other in found {
            while before.next_if(|c| c.other < other).is_some() {}
            let left = now.left(a, other as usize);
            match before.next_if(|c| c.other == other && c.left >= left) {
                Some(couple) => self.near.push(couple),
                None => self.far.push(Far { other, until: left }),
            }
        }
    }

    /// Wakes what has come near, and notes what is due.
    pub(crate) fn wake(&mut self, a: usize, now: &Now) {
        let (near, most) = (&mut self.near, now.fastest + ROUNDED * now.touching);
        let awake = near.len();
        self.far.retain_mut(|far| {
            if far.until - now.moved > most {
                return true;
            }
            let left = now.left(a, far.other as usize);
            far.until = now.moved + left;
            if left < ASLEEP * most {
                let beside = now.search.mesh.tiles.blocks(a, far.other as usize).next().is_some();
                let (other, list) = (far.other, Vec::new());
                near.push(Couple { other, beside, room: left, left, closing: 0.0, is_due: false, list });
            }
            left >= ASLEEP * most
        });
        if near.len() > awake {
            near.sort_unstable_by_key(|c| c.other);
        }
        let far = &mut self.far;
        near.retain_mut(|couple| {
            let b = couple.other as usize;
            couple.closing = 2.0 * now.h * relative(&now.speeds[a], &now.speeds[b]) + ROUNDED * now.touching;
            if couple.left >= couple.closing {
                return true;
            }
            let left = now.left(a, b);
            if left >= ASLEEP * most {
                far.push(Far { other: couple.other, until: now.moved + left });
                return false;
            }
            couple.is_due = left < couple.closing;
            if !couple.is_due {
                couple.rest(left);
            }
            true
        });
    }

    /// Calls `f` with the tiles whose blocks hold two that are due.
    pub(crate) fn wanted(&self, a: usize, search: &Search, mut f: impl FnMut(usize)) {
        let due = self.near.iter().filter(|c| c.is_due && c.beside);
        due.for_each(|c| search.mesh.tiles.blocks(a, c.other as usize).for_each(&mut f));
    }

    /// Looks again at what is due: at how far apart pieces are where cloth is `flat`, of each tile that begins a block, at
    /// what is seen along the tiles, and last piece by piece.
    pub(crate) fn look(&mut self, a: usize, flat: &[f64], now: &Now, room: &mut Room) {
        for couple in &mut self.near {
            let b = couple.other as usize;
            if couple.beside {
                let blocks = now.search.mesh.tiles.blocks(a, b);
                let left = blocks.map(|n| flat[n]).fold(0.0, f64::max) - now.touching;
                // What is seen of one that is due tells of its neighbours as well.
                if left >= couple.closing && left > couple.left {
                    couple.rest(left);
                }
            }
            if couple.is_due && !couple.beside {
                let left = now.search.across(a, b) * (1.0 - ROUNDED) - now.touching;
                if left >= couple.closing {
                    couple.rest(left);
                }
            }
            if couple.is_due {
                let (share, [least, most]) = LISTED;
                let beyond = (share * couple.closing).clamp(least * now.shortest, most * now.shortest);
                couple.rest(couple.closing + beyond);
                let search = Search { reach: now.touching + couple.room, ..*now.search };
                search.between([a, b], [&now.places[a], &now.places[b]], room, &mut couple.list);
            }
        }
    }

    /// Notes that tiles move for `h` \[s\] with velocities in the boxes `speeds` \[m/s\].
    pub(crate) fn age(&mut self, a: usize, speeds: &[Bounds], h: f64) {
        for couple in &mut self.near {
            couple.left -= h * relative(&speeds[a], &speeds[couple.other as usize]);
        }
    }

    /// Pieces that touch in a substep of `h` \[s\].
    pub(crate) fn pairs(&mut self, search: &Search, h: f64) -> Vec<Pair> {
        let (touching, mut found) = (touching(search) * (1.0 + ROUNDED), Vec::new());
        for couple in self.near.iter_mut().filter(|c| !c.list.is_empty()) {
            let (spent, closing) = (couple.room - couple.left, couple.closing);
            for candidate in couple.list.iter_mut().filter(|c| c.apart - spent < touching + closing) {
                let ways = [touching, closing, spent];
                found.extend(candidate.touch(search.vertices, (search.thickness, h), ways));
            }
        }
        found
    }
}

/// Distance below which pieces touch that do not move relative to each other \[m\].
pub(crate) fn touching(search: &Search) -> f64 {
    (1.0 + WATCHED) * search.thickness
}

/// How fast any point of one tile and any of another move relative to each other at most, from the boxes of their
/// velocities \[m/s\].
fn relative(a: &Bounds, b: &Bounds) -> f64 {
    norm(std::array::from_fn(|k| (a.0[k] - b.0[k]).abs() + a.1[k] + b.1[k]))
}

#[cfg(test)]
mod tests {
    use super::*;
    use cosplat_core::boundary::{add, sub};

    #[test]
    fn points_of_tiles_are_no_faster_than_their_boxes_say() {
        let a: Bounds = ([1.0, 0.0, 0.0], [0.5, 0.2, 0.0]);
        let b: Bounds = ([-1.0, 0.3, 0.0], [0.1, 0.0, 0.4]);
        let corner =
            |b: &Bounds, n: u32| add(b.0, std::array::from_fn(|k| b.1[k] * if n >> k & 1 == 1 { 1.0 } else { -1.0 }));
        let most = relative(&a, &b);
        for (i, j) in (0..8).flat_map(|i| (0..8).map(move |j| (i, j))) {
            assert!(norm(sub(corner(&a, i), corner(&b, j))) <= most * (1.0 + ROUNDED));
        }
    }
}
