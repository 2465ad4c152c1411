//! Actions of a scene as influences on the grid.

use cosplat_core::boundary::scale;
use cosplat_core::plugin::SolverScene;
use cosplat_core::scene::ActionKind;

use crate::model::Shown;
use crate::push::{Action, Influence};

/// Reads all actions; what is missing is added to `refused`.
pub(crate) fn actions(scene: &SolverScene, shown: &[Shown], refused: &mut Vec<String>) -> Vec<Action> {
    let mut list = Vec::new();
    for action in &scene.actions {
        let all = action.bodies.is_empty();
        let acts: Vec<bool> = scene.bodies.iter().map(|b| all || action.bodies.contains(&b.name)).collect();
        let until = action.until_s.unwrap_or(f64::INFINITY);
        let mut add = |influence: Influence, bodies: Vec<bool>, gravity: bool| {
            list.push(Action { influence, bodies, from: action.from_s, until, gravity });
        };
        // A force at the centre of mass accelerates every particle alike.
        let mut each = |per_mass: &dyn Fn(f64) -> Influence| {
            for (i, _) in acts.iter().enumerate().filter(|(_, acts)| **acts) {
                let only = (0..acts.len()).map(|k| k == i).collect();
                add(per_mass(1.0 / shown[i].mass), only, false);
            }
        };
        match action.kind {
            ActionKind::Gravity { acceleration_m_s2 } => add(Influence::Uniform(acceleration_m_s2), acts, true),
            ActionKind::AccelerationField { field } => add(Influence::Field(field), acts, false),
            ActionKind::PointForce { force_n, at_m: None } => each(&|per| Influence::Uniform(scale(force_n, per))),
            ActionKind::Impulse { impulse_n_s, at_m: None } => each(&|per| Influence::Kick(scale(impulse_n_s, per))),
            ActionKind::Wind { .. } => refused.push("wind".into()),
            ActionKind::Inflow { .. } | ActionKind::Drain { .. } => refused.push("inflows and drains".into()),
            ActionKind::PointForce { .. } => refused.push("point forces beside the centre of mass (`at_m`)".into()),
            ActionKind::Impulse { .. } => refused.push("impulses beside the centre of mass (`at_m`)".into()),
        }
    }
    list
}
