//! Pressure at points that the scene asks for.

use std::collections::BTreeMap;

use cosplat_core::boundary::{Vec3, norm, sub};
use cosplat_core::scene::{Probe, ProbeQuantity};

use crate::force::pressure;
use crate::model::Model;
use crate::params::Pressure;
use crate::store::Store;

/// Points at which pressure is asked for, with the names of their probes.
#[derive(Clone, Debug, Default)]
pub(crate) struct Points(Vec<(String, Vec3)>);

impl Points {
    /// Those of a scene.
    pub(crate) fn of(probes: &[Probe]) -> Self {
        let asked = probes.iter().filter(|p| p.quantity == ProbeQuantity::Pressure);
        Self(asked.filter_map(|p| Some((p.name.clone(), p.at_m?))).collect())
    }

    /// Pressures \[Pa\]: means over what lies within the reach of the kernel, weighted by it and by volume (Shepard 1968).
    /// Inside the liquid that is exact where pressure rises in proportion; beside a wall it is that of the place where the
    /// liquid is. A point without liquid has no answer.
    pub(crate) fn answers(&self, model: &Model, store: &Store) -> BTreeMap<String, f64> {
        let answer = |(name, at): &(String, Vec3)| Some((name.clone(), mean(model, store, *at)?));
        self.0.iter().filter_map(answer).collect()
    }
}

fn mean(model: &Model, store: &Store, at: Vec3) -> Option<f64> {
    let (mut sum, mut weight) = (0.0, 0.0);
    for (i, &x) in store.x.iter().enumerate() {
        let distance = norm(sub(x, at));
        // Particles that wait, have left or were put aside have no density of the liquid.
        if distance >= model.kernel.reach || store.rho[i] <= 0.0 {
            continue;
        }
        let id = store.id[i] as usize;
        let liquid = &model.liquids[model.body[id] as usize];
        let own = match model.params.pressure {
            Pressure::Weak => pressure(liquid.stiffness, store.rho[i] / liquid.rho),
            Pressure::Incompressible => store.warm.get(i).copied().unwrap_or(0.0),
        };
        let share = model.mass[id] / store.rho[i] * model.kernel.weight(distance);
        (sum, weight) = (sum + share * own, weight + share);
    }
    (weight > 0.0).then(|| sum / weight)
}
