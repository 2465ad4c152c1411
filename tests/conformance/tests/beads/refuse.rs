//! What beads do not take.

use cosplat_core::boundary::{BoundaryState, Impulses};
use cosplat_core::plugin::{Inputs, PluginError, SolverScene};
use cosplat_core::scene::{ActionKind, Material, Source, Space};

use super::Fault;

pub(crate) fn refuse(fault: Fault, scene: &SolverScene) -> Result<(), PluginError> {
    let mut missing: Vec<String> = Vec::new();
    if scene.space != Space::Full {
        missing.push("slab".into());
    }
    if fault != Fault::AcceptsJoints {
        missing.extend(scene.joints.iter().map(|j| format!("joint {}", j.name)));
    }
    missing.extend(scene.links.iter().map(|l| format!("link {}", l.name)));
    for action in &scene.actions {
        match action.kind {
            ActionKind::Gravity { .. } => {}
            ActionKind::Wind { .. } => missing.push("wind".into()),
            ActionKind::AccelerationField { .. } => missing.push("acceleration-field".into()),
            ActionKind::PointForce { .. } => missing.push("point-force".into()),
            ActionKind::Impulse { .. } => missing.push("impulse".into()),
            ActionKind::Reverse | ActionKind::Inflow { .. } | ActionKind::Drain { .. } => {
                missing.push(action.kind.name().into());
            }
        }
    }
    for body in &scene.bodies {
        if body.prescribed.is_some() {
            missing.push(format!("prescribed motion of {}", body.name));
        }
        if body.material != Material::PointMass {
            missing.push(format!("material {}", body.material.name()));
        }
        if !matches!(&body.source, Source::Points { positions_m } if positions_m.len() == 1) {
            missing.push(format!("the source of {}", body.name));
        }
    }
    match missing.is_empty() {
        true => Ok(()),
        false if fault == Fault::RefusesWithoutNames => Err(PluginError::Unsupported("this cannot be done".into())),
        false => Err(PluginError::Unsupported(missing.join(", "))),
    }
}

pub(crate) fn finite(inputs: &Inputs) -> Result<(), PluginError> {
    let partners = inputs.partners.iter().flat_map(|p| [Some(&p.now), p.next.as_ref()]).flatten();
    let places = partners.flat_map(|state| match state {
        BoundaryState::Samples(s) => [s.position.clone(), s.velocity.clone()].concat(),
        BoundaryState::Proxy(p) => vec![p.position, p.linear_velocity],
    });
    let impulses = inputs.impulses.iter().flat_map(|i| match &i.impulses {
        Impulses::Samples(each) => each.clone(),
        Impulses::Rigid(w) => vec![w.linear, w.angular],
    });
    if places.chain(impulses).flatten().all(f64::is_finite) {
        Ok(())
    } else {
        Err(PluginError::Physics("an input is not finite".into()))
    }
}
