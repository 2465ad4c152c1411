//! Pieces of cloth that touch, sorted by where they are, so that they can be solved at the same time.
//!
//! Vertices that have a part in contact are cut into regions, each by halves across the longest extent, with as many
//! vertices in one as in the other. Pairs within a region are solved by whoever has it, and those between regions after
//! them, one after the other. Where the cuts lie depends on positions alone: the result does not depend on how many
//! there are to work.

use crate::pair::{Contacts, Pair};
use crate::sweep::each;
use crate::tally::Tally;
use crate::vertex::Vertex;

/// Pairs for which a region of their own pays.
const WORTH: usize = 256;
/// Most times that vertices are cut in halves: more regions have more pairs between them.
const MOST_CUTS: u32 = 3;
/// Of a vertex that is in no pair.
const NONE: u32 = u32::MAX;

/// Pairs by regions, with vertices of their own.
#[derive(Debug, Default)]
pub(crate) struct Regions {
    /// Vertices with a part in a pair, region by region, and their numbers.
    vertices: Vec<Vertex>,
    numbers: Vec<u32>,
    parts: Vec<Region>,
    /// Between regions.
    across: Contacts,
    /// Vertices that others move as well: their place here.
    shared: Vec<u32>,
}

/// Pairs within a region, their ends counted from its first vertex.
#[derive(Debug, Default)]
struct Region {
    len: usize,
    contacts: Contacts,
    held: Tally,
}

impl Regions {
    /// Sorts pairs for a substep of `h` \[s\]; `others` are vertices that something else moves too.
    pub(crate) fn new(pairs: Vec<Pair>, all: &[Vertex], others: impl Iterator<Item = usize>, h: f64) -> Self {
        let mut place = vec![NONE; all.len()];
        let mut numbers = Vec::new();
        for i in pairs.iter().flat_map(|p| p.ends) {
            if place[i as usize] == NONE {
                place[i as usize] = 0;
                numbers.push(i);
            }
        }
        let cuts = (pairs.len() / WORTH).checked_ilog2().map_or(0, |n| n.min(MOST_CUTS));
        let mut regions = Vec::new();
        cut(&mut numbers, all, cuts, &mut regions);
        (0..).zip(&numbers).for_each(|(k, &i)| place[i as usize] = k);
        let begins: Vec<usize> = regions
            .iter()
            .scan(0, |end, r| {
                *end += r.len;
                Some(*end - r.len)
            })
            .collect();
        let of = |k: u32| begins.partition_point(|&b| b <= k as usize) - 1;
        let vertices: Vec<Vertex> = numbers.iter().map(|&i| all[i as usize]).collect();
        let mut across = Contacts::default();
        for pair in pairs {
            let ends = pair.ends.map(|i| place[i as usize]);
            let region = of(ends[0]);
            if ends[1..].iter().all(|&k| of(k) == region) {
                let begin = begins[region];
                let ends = ends.map(|k| k - begin as u32);
                regions[region].contacts.add(Pair { ends, ..pair }, &vertices[begin..], h);
            } else {
                across.add(Pair { ends, ..pair }, &vertices, h);
            }
        }
        let mut shared: Vec<u32> = others.map(|i| place[i]).filter(|&k| k != NONE).collect();
        shared.sort_unstable();
        shared.dedup();
        Self { vertices, numbers, parts: regions, across, shared }
    }

    /// One turn; what the world takes of pairs between regions goes to `held`.
    pub(crate) fn solve(&mut self, all: &mut [Vertex], parallel: bool, held: &mut Tally) {
        self.take(all);
        let (mut left, mut work) = (&mut self.vertices[..], Vec::new());
        for region in &mut self.parts {
            let (own, rest) = left.split_at_mut(region.len);
            work.push((own, region));
            left = rest;
        }
        let parallel = parallel && work.len() > 1;
        each(parallel, work, |_, (vertices, region)| {
            region.contacts.solve(vertices, &mut region.held);
        });
        self.across.solve(&mut self.vertices, held);
        for &k in &self.shared {
            all[self.numbers[k as usize] as usize].u = self.vertices[k as usize].u;
        }
    }

    /// Takes over what others have done.
    fn take(&mut self, all: &[Vertex]) {
        for &k in &self.shared {
            self.vertices[k as usize].u = all[self.numbers[k as usize] as usize].u;
        }
    }

    /// Hands back all velocities, and what the world has taken within regions.
    pub(crate) fn finish(mut self, all: &mut [Vertex], held: &mut Tally) {
        self.take(all);
        for (vertex, &i) in self.vertices.iter().zip(&self.numbers) {
            all[i as usize].u = vertex.u;
        }
        self.parts.iter().for_each(|region| held.add(&region.held));
    }
}

/// Cuts numbers of vertices into halves, so many times.
fn cut(numbers: &mut [u32], all: &[Vertex], cuts: u32, regions: &mut Vec<Region>) {
    if cuts == 0 {
        regions.push(Region { len: numbers.len(), ..Region::default() });
        return;
    }
    let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
    for &i in &*numbers {
        let x = all[i as usize].x;
        low = std::array::from_fn(|k| low[k].min(x[k]));
        high = std::array::from_fn(|k| high[k].max(x[k]));
    }
    let wide = |k: usize| high[k] - low[k];
    let axis = (1..3).fold(0, |a, k| if wide(k) > wide(a) { k } else { a });
    let along = |i: u32| all[i as usize].x[axis];
    let half = numbers.len() / 2;
    // Equal places are told apart by their numbers: the halves are the same sets whatever the order before.
    numbers.select_nth_unstable_by(half, |&i, &j| along(i).total_cmp(&along(j)).then(i.cmp(&j)));
    let (first, second) = numbers.split_at_mut(half);
    cut(first, all, cuts - 1, regions);
    cut(second, all, cuts - 1, regions);
}

#[cfg(test)]
mod tests {
    use super::*;
    use cosplat_core::boundary::{Vec3, add, norm, scale, sub};

    /// A row of vertices that fall on each other, and pairs of neighbours.
    fn row(count: u32) -> (Vec<Vertex>, Vec<Pair>) {
        let vertices = (0..count).map(|i| f64::from(i) * 0.37).map(|t| Vertex {
            x: [t.sin(), (1.3 * t).cos(), 0.2 * t],
            u: [(2.0 * t).cos(), t.sin(), (0.7 * t).sin()],
            w: 0.5,
            mass: 2.0,
        });
        let pair = |i: u32| Pair {
            ends: [i, i + 1, i + 2, i + 3],
            share: [1.0, -0.5, -0.3, -0.2],
            normal: [0.0, 0.6, 0.8],
            apart: 0.01,
            gap: 0.0,
            friction: [0.4, 0.3],
        };
        (vertices.collect(), (0..count - 3).map(pair).collect())
    }

    #[test]
    fn regions_settle_as_a_single_one_does_and_keep_the_momentum() {
        let (start, pairs) = row(3000);
        let momentum = |v: &[Vertex]| v.iter().fold([0.0; 3], |sum: Vec3, v| add(sum, scale(v.u, v.mass)));
        let run = |parallel: bool| {
            let (mut all, mut held) = (start.clone(), Tally::default());
            // Others that have a part in the last turn too.
            let mut regions = Regions::new(pairs.clone(), &all, (0..all.len()).step_by(7), 1e-3);
            assert!(regions.parts.len() == 8 && !regions.across.is_empty());
            (0..400).for_each(|_| regions.solve(&mut all, parallel, &mut held));
            all[7].u = add(all[7].u, [1.0, 0.0, 0.0]);
            all[14].u = sub(all[14].u, [1.0, 0.0, 0.0]);
            regions.finish(&mut all, &mut held);
            all
        };
        let (one, two) = (run(false), run(true));
        assert!(
            one.iter().zip(&two).all(|(a, b)| a.u.map(f64::to_bits) == b.u.map(f64::to_bits)),
            "threads change nothing"
        );
        // Roundings of 3000 momenta of 2 kg m/s.
        let moved = sub(momentum(&one), momentum(&start));
        assert!(norm(moved) < 1e-10, "{moved:?}");
        let closing = |v: &[Vertex]| -> f64 {
            pairs.iter().map(|p| -cosplat_core::boundary::dot(p.velocity(v), p.normal)).fold(0.0, f64::max)
        };
        // Turns of a chain of 3000 converge slowly, but regions must not stand in their way.
        let (before, after) = (closing(&start), closing(&one));
        assert!(after < 0.05 * before, "{before} {after}");
    }
}
