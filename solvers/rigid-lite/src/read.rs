//! From a solver's part of a scene to a [`Model`], with every feature that is missing refused by name.

use cosplat_core::plugin::{Descriptor, Moving, OffCentre, PluginError, Refusals, SolverScene};
use cosplat_core::rotation::{angular_momentum, angular_velocity};
use cosplat_core::scene::{Body as SceneBody, Material, Source};

use crate::model::{Body, Model};
use crate::shape::Shape;
use crate::{V3, turn};

/// Reads a scene.
pub(crate) fn read(plugin: &Descriptor, scene: &SolverScene) -> Result<Model, PluginError> {
    let mut reader = Reader { scene, refused: Refusals::undeclared(plugin, scene) };
    reader.refused.contacts(scene);
    let bodies: Vec<Body> = scene.bodies.iter().filter_map(|b| reader.body(b)).collect();
    let views = reader.refused.views(scene);
    let influences = reader.refused.influences(scene, OffCentre { forces: true, kicks: true });
    reader.refused.finish()?;
    Ok(Model { clock: scene.clock, bodies, views, influences })
}

struct Reader<'a> {
    scene: &'a SolverScene,
    refused: Refusals,
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
        let [velocity, omega] = self.refused.twist(body, position.into()).map(V3::from);
        let spin = angular_momentum(&principal, omega, moments);
        let start = Moving { position, turn: principal, velocity, spin };
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
}
