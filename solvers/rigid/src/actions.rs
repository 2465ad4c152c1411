//! Outside influences: what they do to which bodies, and when.

use crate::V3;
use crate::model::{Model, State};

/// An outside influence on some bodies in a range of time.
#[derive(Clone, Debug)]
pub(crate) struct Influence {
    pub(crate) kind: InfluenceKind,
    /// Those without a motion told in advance.
    pub(crate) bodies: Vec<usize>,
    /// \[s\].
    pub(crate) from: f64,
    /// \[s\].
    pub(crate) until: f64,
    /// First of its lever arms in [`State::hooks`], one per body, for a force at a point.
    pub(crate) hooks: Option<usize>,
}

/// What an influence does.
#[derive(Clone, Copy, Debug)]
pub(crate) enum InfluenceKind {
    /// \[m/s²\], with the potential energy `-m g·x`.
    Gravity(V3),
    /// \[m/s²\].
    Acceleration(V3),
    /// \[N\], at the point of the body that is at that place of the world when the force begins.
    Force(V3, Option<V3>),
    /// \[N s\] at `from`, at a point of the world.
    Kick(V3, Option<V3>),
}

impl Influence {
    pub(crate) fn acts_at(&self, t: f64) -> bool {
        t >= self.from && t < self.until
    }

    /// Whether it begins in `start..end` \[s\].
    pub(crate) fn begins_in(&self, start: f64, end: f64) -> bool {
        self.from >= start && self.from < end
    }

    /// Constant force on a body of that mass \[N\].
    pub(crate) fn force(&self, mass: f64) -> V3 {
        match self.kind {
            InfluenceKind::Gravity(g) | InfluenceKind::Acceleration(g) => g * mass,
            InfluenceKind::Force(f, _) => f,
            InfluenceKind::Kick(..) => V3::zeros(),
        }
    }
}

impl Model {
    /// Fixes the points of forces that begin in `start..end` \[s\] to their bodies.
    pub(crate) fn hook(&self, state: &mut State, start: f64, end: f64) {
        for influence in self.influences.iter().filter(|i| i.begins_in(start, end)) {
            if let (Some(first), InfluenceKind::Force(_, Some(at))) = (influence.hooks, influence.kind) {
                for (k, &body) in influence.bodies.iter().enumerate() {
                    let moving = &state.bodies[body];
                    state.hooks[first + k] = moving.turn.inverse_transform_vector(&(at - moving.position));
                }
            }
        }
    }

    /// Moments strictly inside `(start, end)` \[s\] at which an influence begins or ends, in order, each once.
    pub(crate) fn switches(&self, start: f64, end: f64) -> Vec<f64> {
        let mut cuts: Vec<f64> =
            self.influences.iter().flat_map(|i| [i.from, i.until]).filter(|&t| t > start && t < end).collect();
        cuts.sort_by(f64::total_cmp);
        cuts.dedup();
        cuts
    }

    /// Forces of outside influences on body `index` at time `t` \[s\]: force \[N\] and its lever arm in the principal
    /// frame \[m\], where it does not act at the centre of mass.
    pub(crate) fn forces<'a>(
        &'a self,
        hooks: &'a [V3],
        index: usize,
        t: f64,
    ) -> impl Iterator<Item = (V3, Option<V3>)> + 'a {
        self.influences.iter().filter(move |i| i.acts_at(t)).filter_map(move |i| {
            let k = i.bodies.iter().position(|&b| b == index)?;
            if matches!(i.kind, InfluenceKind::Kick(..)) {
                return None;
            }
            Some((i.force(self.bodies[index].mass), i.hooks.map(|first| hooks[first + k])))
        })
    }
}
