//! From a solver's part of a scene to a [`Model`], with every feature that is missing refused by name.

use cosplat_core::plugin::{Descriptor, PluginError, Refusals, SolverScene};
use cosplat_core::rotation::{angular_momentum, angular_velocity};
use cosplat_core::scene::{Action, ActionKind, Body as SceneBody, Field, Material, Source, VelocityField};

use crate::model::{Body, Flying, Influence, InfluenceKind, Model, View};
use crate::shape::Shape;
use crate::{V3, turn};

/// Reads a scene.
pub(crate) fn read(plugin: &Descriptor, scene: &SolverScene) -> Result<Model, PluginError> {
    let mut reader = Reader { scene, refused: Refusals::undeclared(plugin, scene), hooks: 0 };
    reader.refused.contacts(scene);
    let bodies: Vec<Body> = scene.bodies.iter().filter_map(|b| reader.body(b)).collect();
    let views = reader.views();
    let influences = scene.actions.iter().filter_map(|a| reader.influence(a)).collect();
    reader.refused.finish()?;
    Ok(Model { clock: scene.clock, bodies, views, influences })
}

struct Reader<'a> {
    scene: &'a SolverScene,
    refused: Refusals,
    hooks: usize,
}

impl Reader<'_> {
    fn body(&mut self, body: &SceneBody) -> Option<Body> {
        let name = &body.name;
        // Refused already.
        let Material::Rigid { density_kg_m3, .. } = body.material else { return None };
        let Some(shape) = Shape::of(&body.source) else {
            if matches!(body.source, Source::Points { .. }) {
                self.refused.push(format!("bodies without points (body `{name}`)"));
            }
            return None;
        };
        let mass = body.mass_kg.or(shape.volume.map(|v| v * density_kg_m3)).unwrap_or(f64::NAN);
        if !(mass.is_finite() && mass > 0.0) {
            self.refused.push(format!("bodies without a positive mass (body `{name}`; points need `mass`)"));
            return None;
        }
        let moments = shape.moments * mass;
        let inverse = moments.map(|i| if i > 0.0 { i.recip() } else { 0.0 });
        let frame = turn(body.pose.orientation);
        let principal = frame * shape.axes;
        let position = V3::from(body.pose.apply(shape.centre.into()));
        let (velocity, omega) = self.twist(body, position);
        let spin = angular_momentum(&principal, omega, moments);
        let start = Flying { position, turn: principal, velocity, spin };
        // Rounding of two rotations; an axis without moment loses all of its part of ω.
        if (angular_velocity(&principal, spin, inverse) - omega).norm() > 1e-9 * omega.norm() {
            self.refused.push(format!("rotation about an axis that holds all mass (body `{name}`)"));
        }
        if !start.is_finite() {
            self.refused.push(format!("positions or velocities that are not finite (body `{name}`)"));
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
            coupled: self.scene.is_coupled(name),
        })
    }

    /// Velocity of the centre of mass and angular velocity at t = 0.
    fn twist(&mut self, body: &SceneBody, centre: V3) -> (V3, V3) {
        let omega = match body.velocity {
            VelocityField::Twist { angular_rad_s, .. } | VelocityField::Rotation { angular_rad_s, .. } => {
                angular_rad_s.into()
            }
            VelocityField::LinearMap { gradient_1_s: g, .. } => {
                let largest = g.iter().flatten().fold(0.0_f64, |most, v| most.max(v.abs()));
                // Rounding of the written numbers, no more.
                if (0..3).any(|i| (0..3).any(|j| (g[i][j] + g[j][i]).abs() > 1e-12 * largest)) {
                    self.refused.push(format!("velocity fields that deform (body `{}`)", body.name));
                }
                V3::new(g[2][1], g[0][2], g[1][0])
            }
        };
        let centre = centre.into();
        (body.velocity.at(centre, centre).into(), omega)
    }

    fn views(&mut self) -> Vec<View> {
        let mut views = Vec::new();
        for view in &self.scene.interfaces {
            let label = format!("`{}` and `{}`", view.own, view.partner);
            match self.scene.bodies.iter().position(|b| b.name == view.own) {
                Some(own) => views.push(View { id: view.id, own, partner: view.partner.clone() }),
                None => self.refused.push(format!("interfaces of bodies it does not have ({label})")),
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
            // Refused already.
            ActionKind::Wind { .. } => return None,
            ActionKind::AccelerationField { .. } => {
                self.refused.push("acceleration fields that vary in space");
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
