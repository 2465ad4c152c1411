//! From a solver's part of a scene to a [`Model`], with every feature that is missing refused by name.

use cosplat_core::plan::BoundaryForm;
use cosplat_core::plugin::{InterfaceView, PluginError, SolverScene, ViewRole};
use cosplat_core::scene::{
    Action, ActionKind, Body, Field, Link, Material, Pose, Probe, ProbeQuantity, Source, Space, VelocityField,
};
use nalgebra::{Quaternion, UnitQuaternion};

use crate::V3;
use crate::model::{Coupling, Influence, InfluenceKind, Model, PointMass, Spring};
use crate::modes::Modes;

/// Reads a scene.
pub(crate) fn read(scene: &SolverScene) -> Result<Model, PluginError> {
    let mut reader = Reader { scene, refused: Vec::new() };
    reader.refuse_whole_features();
    let bodies: Vec<PointMass> = scene.bodies.iter().map(|b| reader.body(b)).collect();
    let springs: Vec<Spring> = scene.links.iter().filter_map(|l| reader.spring(l)).collect();
    let couplings: Vec<Coupling> = scene.interfaces.iter().filter_map(|v| reader.coupling(v)).collect();
    let influences: Vec<Influence> = scene.actions.iter().filter_map(|a| reader.influence(a)).collect();
    if !reader.refused.is_empty() {
        let list = reader.refused.join("; ");
        return Err(PluginError::Unsupported(format!("the oscillator solver does not support: {list}")));
    }
    let mass: Vec<f64> = bodies.iter().map(|b| b.mass).collect();
    let modes = Modes::new(&mass, &Model::stiffness(bodies.len(), &springs, &couplings))
        .ok_or_else(|| PluginError::Physics("the normal modes of the springs could not be found".into()))?;
    Ok(Model { clock: scene.clock, bodies, springs, couplings, influences, modes })
}

struct Reader<'a> {
    scene: &'a SolverScene,
    refused: Vec<String>,
}

impl Reader<'_> {
    fn refuse(&mut self, what: String) {
        self.refused.push(what);
    }

    fn index(&self, body: &str) -> Option<usize> {
        self.scene.bodies.iter().position(|b| b.name == body)
    }

    fn refuse_whole_features(&mut self) {
        let scene = self.scene;
        if scene.space != Space::Full {
            self.refuse("slab".into());
        }
        for joint in &scene.joints {
            self.refuse(format!("joints (`{}`)", joint.name));
        }
        for pair in scene.pairs.iter().filter(|p| p.enabled) {
            self.refuse(format!("contact pairs (`{}` and `{}`)", pair.a, pair.b));
        }
        for key in scene.params.keys() {
            self.refuse(format!("parameters (`{key}`)"));
        }
        let from_states =
            [ProbeQuantity::Position, ProbeQuantity::Orientation, ProbeQuantity::Velocity, ProbeQuantity::Momentum];
        // A probe without a body is shown to every solver; this one has nothing to say to it.
        let asked = |p: &&Probe| p.body.is_some() && !from_states.contains(&p.quantity);
        for probe in scene.probes.iter().filter(asked) {
            self.refuse(format!("probes of that kind (`{}`)", probe.name));
        }
    }

    fn body(&mut self, body: &Body) -> PointMass {
        let name = &body.name;
        if body.material != Material::PointMass {
            self.refuse(format!("material {} (body `{name}`)", body.material.name()));
        }
        if body.prescribed.is_some() {
            self.refuse(format!("prescribed motion (body `{name}`)"));
        }
        let local = match &body.source {
            Source::Points { positions_m } if positions_m.len() == 1 => positions_m[0],
            Source::Points { positions_m } => {
                self.refuse(format!("bodies of {} points, only of one (body `{name}`)", positions_m.len()));
                [0.0; 3]
            }
            _ => {
                self.refuse(format!("sources other than points (body `{name}`)"));
                [0.0; 3]
            }
        };
        let position = place(&body.pose, local);
        let velocity = velocity_at(&body.velocity, position);
        let mass = body.mass_kg.unwrap_or(f64::NAN);
        if !(mass.is_finite() && mass > 0.0) {
            self.refuse(format!("bodies without a positive mass (body `{name}`)"));
        }
        if !position.iter().chain(velocity.iter()).all(|v| v.is_finite()) {
            self.refuse(format!("positions or velocities that are not finite (body `{name}`)"));
        }
        let coupled = self.scene.interfaces.iter().any(|i| i.own == *name);
        PointMass { name: name.clone(), mass, position, velocity, coupled }
    }

    /// Refuses what no link here may have.
    fn link_is_plain(&mut self, link: &Link) {
        if link.damping_n_s_m != 0.0 {
            self.refuse(format!("damped links (`{}`)", link.name));
        }
        if !(link.stiffness_n_m.is_finite() && link.stiffness_n_m >= 0.0) {
            self.refuse(format!("links of negative or infinite stiffness (`{}`)", link.name));
        }
    }

    fn spring(&mut self, link: &Link) -> Option<Spring> {
        self.link_is_plain(link);
        let a = self.index(&link.a);
        let b = link.b.as_deref().map(|b| self.index(b));
        let (Some(a), None | Some(Some(_))) = (a, b) else {
            self.refuse(format!("links to bodies of other solvers without an interface (`{}`)", link.name));
            return None;
        };
        if b == Some(Some(a)) {
            self.refuse(format!("links of a body with itself (`{}`)", link.name));
            return None;
        }
        let anchor = if b.is_none() { V3::from(link.anchor_m) } else { V3::zeros() };
        Some(Spring { a, b: b.flatten(), stiffness: link.stiffness_n_m, rest: anchor + V3::from(link.rest_m) })
    }

    fn coupling(&mut self, view: &InterfaceView) -> Option<Coupling> {
        let label = format!("`{}` and `{}`", view.own, view.partner);
        if view.role == ViewRole::ContactResolver {
            self.refuse(format!("resolving contacts ({label})"));
        }
        let Some(own) = self.index(&view.own) else {
            self.refuse(format!("interfaces of bodies it does not have ({label})"));
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
                _ => self.refuse(format!("links between other bodies than their interface's (`{}`)", link.name)),
            }
        }
        if coupling.computes() && view.links.is_empty() {
            self.refuse(format!("link interfaces without a link ({label})"));
        }
        Some(coupling)
    }

    fn influence(&mut self, action: &Action) -> Option<Influence> {
        let kind = match action.kind {
            ActionKind::Gravity { acceleration_m_s2 } => InfluenceKind::Gravity(acceleration_m_s2.into()),
            ActionKind::AccelerationField { field: Field::Constant { acceleration_m_s2 } } => {
                InfluenceKind::Acceleration(acceleration_m_s2.into())
            }
            ActionKind::PointForce { force_n, at_m: None } => InfluenceKind::Force(force_n.into()),
            ActionKind::Impulse { impulse_n_s, at_m: None } => InfluenceKind::Kick(impulse_n_s.into()),
            ActionKind::Wind { .. } => return self.no_action("wind"),
            ActionKind::AccelerationField { .. } => return self.no_action("acceleration fields that vary in space"),
            ActionKind::PointForce { .. } => return self.no_action("point forces beside the point (`at_m`)"),
            ActionKind::Impulse { .. } => return self.no_action("impulses beside the point (`at_m`)"),
        };
        let all = action.bodies.is_empty();
        let bodies = (0..self.scene.bodies.len())
            .filter(|&i| all || action.bodies.contains(&self.scene.bodies[i].name))
            .collect();
        Some(Influence { kind, bodies, from: action.from_s, until: action.until_s.unwrap_or(f64::INFINITY) })
    }

    fn no_action(&mut self, what: &str) -> Option<Influence> {
        self.refuse(what.into());
        None
    }
}

/// A point of a body's frame in the world.
fn place(pose: &Pose, local: [f64; 3]) -> V3 {
    let [x, y, z, w] = pose.orientation;
    let rotation = UnitQuaternion::from_quaternion(Quaternion::new(w, x, y, z));
    rotation * V3::from(local) + V3::from(pose.position_m)
}

/// Velocity of a lone point: it is its own centre of mass.
fn velocity_at(field: &VelocityField, x: V3) -> V3 {
    match *field {
        VelocityField::Twist { linear_m_s, .. } => linear_m_s.into(),
        VelocityField::LinearMap { linear_m_s, gradient_1_s, about_m } => {
            let r = x - V3::from(about_m);
            V3::from(linear_m_s) + V3::from(gradient_1_s.map(|row| V3::from(row).dot(&r)))
        }
        VelocityField::Rotation { angular_rad_s, about_m } => V3::from(angular_rad_s).cross(&(x - V3::from(about_m))),
    }
}
