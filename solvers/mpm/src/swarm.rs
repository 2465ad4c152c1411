//! Stand-ins of a deformable partner's samples over one window.
//!
//! A sample is a free mass where its particle is. It takes every contact impulse of every substep at once and moves by the
//! result, so that a light body gives way: taken as a wall it would throw back what weighs more. What crosses back is the
//! sum of the impulses on each sample.
//!
//! What holds a sample from behind is unknown within a window. It is foreseen as what held it in the last one, `(Δv - J/m)/W`
//! from the velocities that it showed, as far as that opposed the impulse that it took and no more: a body that rests
//! keeps still, and a bounce is not repeated.
//!
//! Known limit: a blow on a partner whose wave crosses many spacings in a window is felt too softly, as its layers behind
//! the samples take part only from the next window on: half the force at 12 spacings, all of it below 1.4. The mass is
//! counted whole by each solver that meets the samples.

use std::ops::RangeInclusive;

use cosplat_core::boundary::{Samples, Vec3, add, dot, norm, scale, sub};
use cosplat_core::plugin::{StateError, StateReader, StateSink};

use crate::patch::{Marks, Patch};
use crate::store::Block;
use crate::tally::Tally;
use crate::walls::Surface;

/// Part of the support in the last window that is foreseen. With `q = (ωW)²` of the layer behind the samples, the lag of a
/// part θ is stable up to `q (1 + θ) = 2`, for θ < 1. With none of it a load sinks in by `F W / 2m` a second, and layers
/// oscillate at the longest window, where q = 2 for one spacing and about 1 for what a grid of two lets move; with all of
/// it a bounce there keeps half more energy than in short windows, with three quarters it keeps less.
const FORESEEN: f64 = 0.75;

/// A partner that shows samples.
#[derive(Clone, Debug, Default)]
pub(crate) struct Cloud {
    /// Body.
    pub(crate) name: String,
    /// Surface for each own body.
    pub(crate) pairs: Vec<Option<Surface>>,
    /// Its samples; known when all partners are.
    pub(crate) marks: Marks,
}

/// Samples of a partner over one window.
#[derive(Clone, Debug)]
pub(crate) struct Swarm {
    /// Position \[m\] and velocity \[m/s\].
    x: Vec<Vec3>,
    v: Vec<Vec3>,
    /// Velocity at the start of the window, and what is foreseen to hold it \[m/s²\].
    start: Vec<Vec3>,
    support: Vec<Vec3>,
    /// Block of cells and number of each sample near own particles, sorted.
    near: Vec<([i32; 3], u32)>,
    /// Effect on own bodies.
    pub(crate) on_own: Vec<Tally>,
    /// Impulses on the samples by own body \[N s\].
    pub(crate) on_partner: Vec<Vec<Vec3>>,
}

/// What samples felt in the last window: number, velocity at its start, impulse, and velocity foreseen at its end.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Felt(Vec<(u32, [Vec3; 3])>);

impl Swarm {
    /// Stand-ins of `cloud` from what it shows, for so many own bodies and a window of `length` \[s\].
    pub(crate) fn new(cloud: &Cloud, shown: &Samples, felt: &Felt, length: f64) -> Self {
        let count = cloud.marks.len();
        let mut support = vec![[0.0; 3]; count];
        for &(i, [before, impulse, _]) in &felt.0 {
            let i = i as usize;
            let given = scale(impulse, cloud.marks.inverse(i));
            let size = norm(given);
            if size > 0.0 {
                let held = sub(sub(shown.velocity[i], before), given);
                let against = (-dot(held, given) / size).clamp(0.0, size);
                support[i] = scale(given, -FORESEEN * against / (size * length));
            }
        }
        let each = |pair: &Option<Surface>| pair.map_or(Vec::new(), |_| vec![[0.0; 3]; count]);
        Self {
            x: shown.position.clone(),
            v: shown.velocity.clone(),
            start: shown.velocity.clone(),
            support,
            near: Vec::new(),
            on_own: vec![Tally::default(); cloud.pairs.len()],
            on_partner: cloud.pairs.iter().map(each).collect(),
        }
    }

    /// What its samples felt.
    pub(crate) fn felt(&self) -> Felt {
        let whole = |i: usize| self.on_partner.iter().filter_map(|all| all.get(i)).fold([0.0; 3], |s, &j| add(s, j));
        let one = |i: usize| {
            let impulse = whole(i);
            impulse.iter().any(|j| j.abs() > 0.0).then(|| (i as u32, [self.start[i], impulse, self.v[i]]))
        };
        Felt((0..self.x.len()).filter_map(one).collect())
    }

    /// Motion without contact over `dt`; contact comes after it.
    pub(crate) fn push(&mut self, dt: f64) {
        for (v, held) in self.v.iter_mut().zip(&self.support) {
            *v = add(*v, scale(*held, dt));
        }
    }

    /// Moves by its velocities.
    pub(crate) fn drift(&mut self, dt: f64) {
        for (x, v) in self.x.iter_mut().zip(&self.v) {
            *x = add(*x, scale(*v, dt));
        }
    }

    /// Sorts the samples that particles of these blocks can reach over `reach` \[m\].
    pub(crate) fn look(&mut self, blocks: &[Block], dx: f64, reach: f64) {
        self.near.clear();
        let (mut low, mut high) = ([i32::MAX; 3], [i32::MIN; 3]);
        for block in blocks {
            low = std::array::from_fn(|k| low[k].min(block.at[k]));
            high = std::array::from_fn(|k| high[k].max(block.at[k]));
        }
        if blocks.is_empty() {
            return;
        }
        let around = around(dx, reach);
        let (low, high) = (low.map(|a| a + around.start()), high.map(|a| a + around.end()));
        for (i, x) in self.x.iter().enumerate() {
            let at = x.map(|x| (x / (4.0 * dx)).floor() as i32);
            if (0..3).all(|k| low[k] <= at[k] && at[k] <= high[k]) {
                self.near.push((at, i as u32));
            }
        }
        self.near.sort_unstable();
    }

    /// Samples that particles of a block can reach, after `look`, and the box around them \[m\].
    pub(crate) fn around(&self, block: &Block, dx: f64, reach: f64) -> (Vec<u32>, [Vec3; 2]) {
        let (mut found, mut bounds) = (Vec::new(), [[f64::INFINITY; 3], [f64::NEG_INFINITY; 3]]);
        let around = around(dx, reach);
        let [x, y, z] = block.at;
        for (a, b) in around.clone().flat_map(|a| around.clone().map(move |b| (x + a, y + b))) {
            let first = self.near.partition_point(|(at, _)| *at < [a, b, z + around.start()]);
            let here = self.near[first..].iter().take_while(|(at, _)| *at <= [a, b, z + around.end()]);
            found.extend(here.map(|&(_, i)| i));
        }
        for &i in &found {
            for (k, x) in self.x[i as usize].into_iter().enumerate() {
                bounds[0][k] = bounds[0][k].min(x);
                bounds[1][k] = bounds[1][k].max(x);
            }
        }
        (found, bounds)
    }

    /// What a particle at `x`, twice `half` wide, meets of these samples.
    pub(crate) fn patch(&self, marks: &Marks, near: &[u32], x: Vec3, half: f64) -> Option<Patch> {
        marks.patch(&self.x, near, x, half)
    }

    /// Velocity of a patch \[m/s\].
    pub(crate) fn at(&self, shares: &[(u32, f64)]) -> Vec3 {
        shares.iter().fold([0.0; 3], |sum, &(i, share)| add(sum, scale(self.v[i as usize], share)))
    }

    /// Gives a patch an impulse \[N s\].
    pub(crate) fn take(&mut self, marks: &Marks, shares: &[(u32, f64)], impulse: Vec3) {
        for &(i, share) in shares {
            let v = &mut self.v[i as usize];
            *v = add(*v, scale(impulse, share * marks.inverse(i as usize)));
        }
    }

    /// Books an impulse \[N s\] of an own body on a patch.
    pub(crate) fn book(&mut self, body: usize, shares: &[(u32, f64)], impulse: Vec3) {
        for &(i, share) in shares {
            let sum = &mut self.on_partner[body][i as usize];
            *sum = add(*sum, scale(impulse, share));
        }
    }
}

/// Blocks of cells beside a block that its particles, strayed ones too, reach over `reach` \[m\].
fn around(dx: f64, reach: f64) -> RangeInclusive<i32> {
    let (low, high) = ((-1.0 - reach / dx) / 4.0, (5.0 + reach / dx) / 4.0);
    low.floor() as i32..=high.floor() as i32
}

impl Felt {
    /// Largest difference of the velocities shown from those foreseen \[m/s\].
    pub(crate) fn residual(&self, shown: &Samples) -> f64 {
        self.0.iter().map(|&(i, [_, _, v])| norm(sub(shown.velocity[i as usize], v))).fold(0.0, f64::max)
    }

    /// Writes it.
    pub(crate) fn save(&self, sink: &mut dyn StateSink) {
        sink.u64(self.0.len() as u64);
        for (i, vectors) in &self.0 {
            sink.u64(u64::from(*i));
            for v in vectors {
                sink.vec3(*v);
            }
        }
    }

    /// Reads what `save` wrote, for so many samples.
    pub(crate) fn load(reader: &mut StateReader, samples: usize) -> Result<Self, StateError> {
        let (count, expected) = (reader.u64()?, samples as u64);
        if count > expected {
            return Err(StateError::Count { what: "samples", found: count, expected });
        }
        let one = |_| {
            let i = reader.u64()?;
            if i >= expected {
                return Err(StateError::Count { what: "samples", found: i, expected });
            }
            Ok((i as u32, [reader.vec3()?, reader.vec3()?, reader.vec3()?]))
        };
        (0..count).map(one).collect::<Result<_, StateError>>().map(Self)
    }
}
