//! What the scene asks for: pressure at points, and how far a liquid reaches.

use std::collections::BTreeMap;

use cosplat_core::boundary::{Vec3, dot, norm, sub};
use cosplat_core::plugin::{Question, Questions, SolverScene};
use cosplat_core::scene::ProbeQuantity;

use crate::model::Model;
use crate::params::Pressure;
use crate::store::Store;

/// Points at which pressure is asked for, with the names of their probes, and how far liquids reach.
#[derive(Clone, Debug, Default)]
pub(crate) struct Points {
    pressures: Vec<(String, Vec3)>,
    questions: Questions,
}

impl Points {
    /// Those of a scene.
    pub(crate) fn of(scene: &SolverScene) -> Self {
        let pressures = scene.probes.iter().filter(|p| p.quantity == ProbeQuantity::Pressure);
        let pressures = pressures.filter_map(|p| Some((p.name.clone(), p.at_m?)));
        Self { pressures: pressures.collect(), questions: Questions::of(scene) }
    }

    /// Pressures \[Pa\]: means over what lies within the reach of the kernel, weighted by it and by volume (Shepard 1968).
    /// Inside the liquid that is exact where pressure rises in proportion; beside a wall it is that of the place where the
    /// liquid is. A point without liquid has no answer. A liquid reaches as far as the farthest of its particles \[m\].
    pub(crate) fn answers(&self, model: &Model, store: &Store) -> BTreeMap<String, f64> {
        let answer = |(name, at): &(String, Vec3)| Some((name.clone(), mean(model, store, *at)?));
        let far = |body: usize, question: Question| {
            let Question::Reach(along) = question else { return None };
            let own = store.x.iter().enumerate().filter(|&(i, _)| store.rho[i] > 0.0);
            let own = own.filter(|&(i, _)| model.body[store.id[i] as usize] as usize == body);
            own.map(|(_, x)| dot(*x, along)).reduce(f64::max)
        };
        self.pressures.iter().filter_map(answer).chain(self.questions.answers(far)).collect()
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
            Pressure::Weak => liquid.pressure(store.rho[i]),
            Pressure::Incompressible => store.warm.get(i).copied().unwrap_or(0.0),
        };
        let share = model.mass[id] / store.rho[i] * model.kernel.weight(distance);
        (sum, weight) = (sum + share * own, weight + share);
    }
    (weight > 0.0).then(|| sum / weight)
}
