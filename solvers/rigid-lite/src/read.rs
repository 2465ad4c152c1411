//! From a solver's part of a scene to a [`Model`], with every feature that is missing refused by name.

use cosplat_core::plugin::{PluginError, SolverScene, ViewRole};
use cosplat_core::scene::{
    Action, ActionKind, Body as SceneBody, Field, Material, Probe, ProbeQuantity, Space, VelocityField,
};

use crate::model::{Body, Flying, Influence, InfluenceKind, Model, View};
use crate::rotation::{angular_momentum, angular_velocity};
use crate::shape::Shape;
use crate::{V3, turn};

/// Reads a scene.
pub(crate) fn read(scene: &SolverScene) -> Result<Model, PluginError> {
    let mut reader = Reader { scene, refused: Vec::new(), hooks: 0 };
    reader.refuse_whole_features();
    let bodies: Vec<Body> = scene.bodies.iter().filter_map(|b| reader.body(b)).collect();
    let views = reader.views();
    let influences = scene.actions.iter().filter_map(|a| reader.influence(a)).collect();
    if !reader.refused.is_empty() {
        let list = reader.refused.join("; ");
        return Err(PluginError::Unsupported(format!("the rigid-lite solver does not support: {list}")));
    }
    Ok(Model { clock: scene.clock, bodies, views, influences })
}

struct Reader<'a> {
    scene: &'a SolverScene,
    refused: Vec<String>,
    hooks: usize,
}

impl Reader<'_> {
    fn refuse(&mut self, what: String) {
        self.refused.push(what);
    }

    fn refuse_whole_features(&mut self) {
        let scene = self.scene;
        if scene.space != Space::Full {
            self.refuse("slab".into());
        }
        for joint in &scene.joints {
            self.refuse(format!("joints (`{}`)", joint.name));
        }
        for link in &scene.links {
            self.refuse(format!("links (`{}`)", link.name));
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

    fn body(&mut self, body: &SceneBody) -> Option<Body> {
        let name = &body.name;
        let Material::Rigid { density_kg_m3, .. } = body.material else {
            self.refuse(format!("material {} (body `{name}`)", body.material.name()));
            return None;
        };
        let Some(shape) = Shape::of(&body.source) else {
            self.refuse(format!("sources other than box, sphere, cylinder and points (body `{name}`)"));
            return None;
        };
        let mass = body.mass_kg.or(shape.volume.map(|v| v * density_kg_m3)).unwrap_or(f64::NAN);
        if !(mass.is_finite() && mass > 0.0) {
            self.refuse(format!("bodies without a positive mass (body `{name}`; points need `mass`)"));
            return None;
        }
        let moments = shape.moments * mass;
        let inverse = moments.map(|i| if i > 0.0 { i.recip() } else { 0.0 });
        let frame = turn(body.pose.orientation);
        let principal = frame * shape.axes;
        let position = V3::from(body.pose.position_m) + frame * shape.centre;
        let (velocity, omega) = self.twist(body, position);
        let spin = angular_momentum(&principal, omega, moments);
        let start = Flying { position, turn: principal, velocity, spin };
        // Rounding of two rotations; an axis without moment loses all of its part of ω.
        if (angular_velocity(&principal, spin, inverse) - omega).norm() > 1e-9 * omega.norm() {
            self.refuse(format!("rotation about an axis that holds all mass (body `{name}`)"));
        }
        if !start.is_finite() {
            self.refuse(format!("positions or velocities that are not finite (body `{name}`)"));
        }
        Some(Body {
            name: name.clone(),
            mass,
            moments,
            inverse,
            axes: shape.axes,
            centre: shape.centre,
            marks: shape.marks.iter().map(|&m| shape.axes.inverse() * m).collect(),
            particles: shape.particles,
            start,
            motion: body.prescribed,
            coupled: self.scene.interfaces.iter().any(|i| i.own == *name),
        })
    }

    /// Velocity of the centre of mass and angular velocity at t = 0.
    fn twist(&mut self, body: &SceneBody, centre: V3) -> (V3, V3) {
        match body.velocity {
            VelocityField::Twist { linear_m_s, angular_rad_s } => (linear_m_s.into(), angular_rad_s.into()),
            VelocityField::Rotation { angular_rad_s, about_m } => {
                let omega = V3::from(angular_rad_s);
                (omega.cross(&(centre - V3::from(about_m))), omega)
            }
            VelocityField::LinearMap { linear_m_s, gradient_1_s: g, about_m } => {
                let largest = g.iter().flatten().fold(0.0_f64, |most, v| most.max(v.abs()));
                // Rounding of the written numbers, no more.
                if (0..3).any(|i| (0..3).any(|j| (g[i][j] + g[j][i]).abs() > 1e-12 * largest)) {
                    self.refuse(format!("velocity fields that deform (body `{}`)", body.name));
                }
                let omega = V3::new(g[2][1], g[0][2], g[1][0]);
                (V3::from(linear_m_s) + omega.cross(&(centre - V3::from(about_m))), omega)
            }
        }
    }

    fn views(&mut self) -> Vec<View> {
        let mut views = Vec::new();
        for view in &self.scene.interfaces {
            let label = format!("`{}` and `{}`", view.own, view.partner);
            match view.role {
                ViewRole::ContactResponder => {}
                ViewRole::ContactResolver => self.refuse(format!("resolving contacts ({label})")),
                ViewRole::LinkSide | ViewRole::LinkResolver | ViewRole::LinkResponder => {
                    self.refuse(format!("links to other solvers ({label})"));
                }
            }
            match self.scene.bodies.iter().position(|b| b.name == view.own) {
                Some(own) => views.push(View { id: view.id, own, partner: view.partner.clone() }),
                None => self.refuse(format!("interfaces of bodies it does not have ({label})")),
            }
        }
        views
    }

    fn influence(&mut self, action: &Action) -> Option<Influence> {
        let kind = match action.kind {
            ActionKind::Gravity { acceleration_m_s2 } => InfluenceKind::Gravity(acceleration_m_s2.into()),
            ActionKind::AccelerationField { field: Field::Constant { acceleration_m_s2 } } => {
                InfluenceKind::Acceleration(acceleration_m_s2.into())
            }
            ActionKind::PointForce { force_n, at_m } => InfluenceKind::Force(force_n.into(), at_m.map(V3::from)),
            ActionKind::Impulse { impulse_n_s, at_m } => InfluenceKind::Kick(impulse_n_s.into(), at_m.map(V3::from)),
            ActionKind::Wind { .. } => {
                self.refuse("wind".into());
                return None;
            }
            ActionKind::AccelerationField { .. } => {
                self.refuse("acceleration fields that vary in space".into());
                return None;
            }
        };
        let all = action.bodies.is_empty();
        let bodies: Vec<usize> = (0..self.scene.bodies.len())
            .filter(|&i| all || action.bodies.contains(&self.scene.bodies[i].name))
            .filter(|&i| self.scene.bodies[i].prescribed.is_none())
            .collect();
        let hooks = matches!(kind, InfluenceKind::Force(_, Some(_))).then_some(self.hooks);
        self.hooks += if hooks.is_some() { bodies.len() } else { 0 };
        Some(Influence { kind, bodies, from: action.from_s, until: action.until_s.unwrap_or(f64::INFINITY), hooks })
    }
}
