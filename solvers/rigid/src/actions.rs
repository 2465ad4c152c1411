//! Outside influences: what they do to which bodies, and when.

use cosplat_core::plugin::InfluenceKind;

use crate::V3;
use crate::model::{Model, State};

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

    /// Forces of outside influences on body `index` at time `t` \[s\]: force \[N\] and its lever arm in the principal
    /// frame \[m\], where it does not act at the centre of mass; whether it has a potential.
    pub(crate) fn forces<'a>(
        &'a self,
        hooks: &'a [V3],
        index: usize,
        t: f64,
    ) -> impl Iterator<Item = (V3, Option<V3>, bool)> + 'a {
        self.influences.iter().filter(move |i| i.acts_at(t)).filter_map(move |i| {
            let k = i.bodies.iter().position(|&b| b == index)?;
            if i.is_sudden() {
                return None;
            }
            Some((i.force(self.bodies[index].mass), i.hooks.map(|first| hooks[first + k]), i.has_potential()))
        })
    }
}
