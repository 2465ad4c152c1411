//! From a solver's part of a scene to a [`Model`], with every feature that is missing refused by name.

use cosplat_core::plan::BoundaryForm;
use cosplat_core::plugin::{Descriptor, InterfaceView, OffCentre, PluginError, Refusals, SolverScene};
use cosplat_core::scene::{Body, Link, Source};

use crate::V3;
use crate::model::{Coupling, Model, PointMass, Spring};
use crate::modes::Modes;

/// Reads a scene.
pub(crate) fn read(plugin: &Descriptor, scene: &SolverScene) -> Result<Model, PluginError> {
    let mut reader = Reader { scene, refused: Refusals::undeclared(plugin, scene) };
    reader.refused.contacts(scene);
    let bodies: Vec<PointMass> = scene.bodies.iter().map(|b| reader.body(b)).collect();
    let springs: Vec<Spring> = scene.links.iter().filter_map(|l| reader.spring(l)).collect();
    let couplings: Vec<Coupling> = scene.interfaces.iter().filter_map(|v| reader.coupling(v)).collect();
    let influences = reader.refused.influences(scene, OffCentre::default());
    reader.refused.finish()?;
    let mass: Vec<f64> = bodies.iter().map(|b| b.mass).collect();
    let modes = Modes::new(&mass, &Model::stiffness(bodies.len(), &springs, &couplings))
        .ok_or_else(|| PluginError::Physics("the normal modes of the springs could not be found".into()))?;
    Ok(Model { clock: scene.clock, bodies, springs, couplings, influences, modes })
}

struct Reader<'a> {
    scene: &'a SolverScene,
    refused: Refusals,
}

impl Reader<'_> {
    fn index(&self, body: &str) -> Option<usize> {
        self.scene.bodies.iter().position(|b| b.name == body)
    }

    fn body(&mut self, body: &Body) -> PointMass {
        let name = &body.name;
        let local = match &body.source {
            Source::Points { positions_m } if positions_m.len() == 1 => positions_m[0],
            Source::Points { positions_m } => {
                self.refused.push(format!("bodies of {} points, only of one (body `{name}`)", positions_m.len()));
                [0.0; 3]
            }
            // Refused already.
            _ => [0.0; 3],
        };
        let at = body.pose.apply(local);
        // A lone point is its own centre of mass.
        let (position, velocity) = (V3::from(at), V3::from(body.velocity.at(at, at)));
        let mass = body.mass_kg.unwrap_or(f64::NAN);
        if !(mass.is_finite() && mass > 0.0) {
            self.refused.push(format!("bodies without a positive mass (body `{name}`)"));
        }
        if !position.iter().chain(velocity.iter()).all(|v| v.is_finite()) {
            self.refused.push(format!("positions or velocities that are not finite (body `{name}`)"));
        }
        let coupled = self.scene.is_coupled(name);
        PointMass { name: name.clone(), mass, position, velocity, coupled }
    }

    /// Refuses what no link here may have.
    fn link_is_plain(&mut self, link: &Link) {
        if link.damping_n_s_m != 0.0 {
            self.refused.push(format!("damped links (`{}`)", link.name));
        }
        if !(link.stiffness_n_m.is_finite() && link.stiffness_n_m >= 0.0) {
            self.refused.push(format!("links of negative or infinite stiffness (`{}`)", link.name));
        }
    }

    fn spring(&mut self, link: &Link) -> Option<Spring> {
        self.link_is_plain(link);
        let a = self.index(&link.a);
        let b = link.b.as_deref().map(|b| self.index(b));
        let (Some(a), None | Some(Some(_))) = (a, b) else {
            self.refused.push(format!("links to bodies of other solvers without an interface (`{}`)", link.name));
            return None;
        };
        if b == Some(Some(a)) {
            self.refused.push(format!("links of a body with itself (`{}`)", link.name));
            return None;
        }
        let anchor = if b.is_none() { V3::from(link.anchor_m) } else { V3::zeros() };
        Some(Spring { a, b: b.flatten(), stiffness: link.stiffness_n_m, rest: anchor + V3::from(link.rest_m) })
    }

    fn coupling(&mut self, view: &InterfaceView) -> Option<Coupling> {
        let label = format!("`{}` and `{}`", view.own, view.partner);
        let Some(own) = self.index(&view.own) else {
            self.refused.push(format!("interfaces of bodies it does not have ({label})"));
            return None;
        };
        let mut coupling = Coupling {
            id: view.id,
            role: view.role,
            own,
            partner: view.partner.clone(),
            partner_is_rigid: view.partner_form == BoundaryForm::Proxy,
            stiffness: 0.0,
            preload: V3::zeros(),
        };
        for link in &view.links {
            self.link_is_plain(link);
            let rest = V3::from(link.rest_m) * link.stiffness_n_m;
            coupling.stiffness += link.stiffness_n_m;
            match (link.a == view.own, link.b.as_ref() == Some(&view.partner)) {
                (true, true) => coupling.preload += rest,
                _ if link.a == view.partner && link.b.as_ref() == Some(&view.own) => coupling.preload -= rest,
                _ => self.refused.push(format!("links between other bodies than their interface's (`{}`)", link.name)),
            }
        }
        if coupling.computes() && view.links.is_empty() {
            self.refused.push(format!("link interfaces without a link ({label})"));
        }
        Some(coupling)
    }
}
