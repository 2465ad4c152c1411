//! From a solver's part of a scene to a [`Model`], with every feature that is missing refused by name.

use cosplat_core::asset::Asset;
use cosplat_core::plan::LeftOut;
use cosplat_core::plugin::{Descriptor, Moving, OffCentre, PluginError, Refusals, SolverScene};
use cosplat_core::rotation::angular_momentum;
use cosplat_core::scene::{Body as SceneBody, Joint as SceneJoint, JointKind, Material};

use crate::joints::Joint;
use crate::model::{Body, Model};
use crate::pairs::Pairs;
use crate::params::Params;
use crate::shape::Shape;
use crate::walls::StaticWall;
use crate::{V3, turn};

/// Range of extents that rapier's tolerances are scaled to \[m\].
const UNITS: [f64; 2] = [1e-4, 1.0];

/// Reads a scene; also answers what is left out of it.
pub(crate) fn read(plugin: &Descriptor, scene: &SolverScene) -> Result<(Model, Vec<LeftOut>), PluginError> {
    let refused = Refusals::undeclared(plugin, scene);
    let mut reader = Reader { scene, refused, left_out: Vec::new() };
    let bodies: Vec<Body> = scene.bodies.iter().filter_map(|b| reader.body(b)).collect();
    let extent = bodies.iter().map(|b| b.extent).fold(f64::INFINITY, f64::min);
    let unit = if extent.is_finite() { extent.clamp(UNITS[0], UNITS[1]) } else { UNITS[1] };
    let walls = reader.walls(unit);
    let views = reader.refused.views(scene);
    let influences = reader.refused.influences(scene, OffCentre { forces: true, kicks: true });
    let mut pairs = reader.pairs(&walls);
    // The rest refers to bodies by their place, which is right only where none was refused.
    reader.refused.clone().finish()?;
    let joints: Vec<Joint> = scene.joints.iter().filter_map(|j| reader.joint(j, &bodies)).collect();
    reader.refused.clone().finish()?;
    let params = Params::read(scene)?;
    joints.iter().filter_map(|j| Some((j.a, j.b?))).for_each(|(a, b)| pairs.join(a, b));
    let origin = bodies.iter().map(|b| b.start.position).sum::<V3>() / bodies.len().max(1) as f64;
    let walls = walls.into_iter().map(|w| w.1).collect();
    let model = Model { clock: scene.clock, params, bodies, walls, joints, views, influences, pairs, unit, origin };
    Ok((model, reader.left_out))
}

struct Reader<'a> {
    scene: &'a SolverScene,
    refused: Refusals,
    left_out: Vec<LeftOut>,
}

impl Reader<'_> {
    fn asset(&self, name: &str) -> Option<&Asset> {
        self.scene.assets.get(name).map(AsRef::as_ref)
    }

    fn body(&mut self, body: &SceneBody) -> Option<Body> {
        let name = &body.name;
        // Refused already.
        let Material::Rigid { density_kg_m3, .. } = body.material else { return None };
        let shape = match Shape::of(name, &body.source, self.asset(name)) {
            Ok(shape) => shape,
            Err(why) => {
                self.refused.push(why);
                return None;
            }
        };
        let mass = body.mass_kg.unwrap_or(shape.volume * density_kg_m3);
        if !(mass.is_finite() && mass > 0.0) {
            self.refused.push(format!("bodies without a positive mass (body `{name}`)"));
            return None;
        }
        let moments = shape.moments * mass;
        let turn = turn(body.pose.orientation) * shape.axes;
        let position = V3::from(body.pose.apply(shape.centre.into()));
        let [velocity, omega] = self.refused.twist(body, position.into()).map(V3::from);
        let start = Moving { position, turn, velocity, spin: angular_momentum(&turn, omega, moments) };
        if !start.is_finite() {
            self.refused.push(format!("positions or velocities that are not finite (body `{name}`)"));
        }
        self.left_out.extend(shape.left_out);
        Some(Body {
            name: name.clone(),
            mass,
            moments,
            inverse: moments.map(f64::recip),
            axes: shape.axes,
            centre: shape.centre,
            marks: shape.marks.iter().map(|&m| shape.axes.inverse() * m).collect(),
            parts: shape.parts,
            extent: shape.extent,
            start,
            motion: body.prescribed,
            coupled: self.scene.is_coupled(name),
        })
    }

    fn walls(&mut self, thickness: f64) -> Vec<(String, StaticWall)> {
        let mut walls = Vec::new();
        for collider in &self.scene.statics {
            match StaticWall::new(collider, self.asset(&collider.name), thickness) {
                Ok(wall) => walls.push((collider.name.clone(), wall)),
                Err(why) => self.refused.push(why),
            }
        }
        walls
    }

    fn pairs(&mut self, walls: &[(String, StaticWall)]) -> Pairs {
        let bodies = self.scene.bodies.iter().map(|b| (b.name.clone(), b.material)).collect();
        let mut refused = Vec::new();
        let pairs = Pairs::new(&self.scene.pairs, bodies, walls, &mut refused);
        for why in refused {
            self.refused.push(why);
        }
        pairs
    }

    fn joint(&mut self, joint: &SceneJoint, bodies: &[Body]) -> Option<Joint> {
        let name = &joint.name;
        let at = |body: &str| bodies.iter().position(|b| b.name == body);
        let Some(a) = at(&joint.a) else {
            self.refused.push(format!("joints of bodies it does not have (`{name}`)"));
            return None;
        };
        let b = joint.b.as_deref().map(at);
        if b == Some(None) {
            self.refused.push(format!("joints to anything but own bodies and the world (`{name}`)"));
        }
        let axis = V3::from(joint.axis).try_normalize(0.0);
        let numbers = [joint.stiffness, joint.damping];
        if !numbers.iter().all(|n| n.is_finite() && *n >= 0.0) || axis.is_none_or(|v| !v.iter().all(|c| c.is_finite()))
        {
            self.refused.push(format!("joints with a negative spring or damper, or no axis (`{name}`)"));
        }
        if joint.kind == JointKind::Fixed && numbers.iter().any(|n| *n > 0.0) {
            self.refused.push(format!("springs of fixed joints, which leave nothing free (`{name}`)"));
        }
        let b = b.flatten();
        if bodies[a].motion.is_some() && b.is_none_or(|b| bodies[b].motion.is_some()) {
            self.refused.push(format!("joints that move nothing (`{name}`)"));
        }
        let start = &bodies[a].start;
        let anchor = V3::from(joint.anchor_m);
        let (turn_b, from) = b.map_or((crate::Turn::identity(), V3::zeros()), |b| {
            let start = &bodies[b].start;
            (start.turn, start.position)
        });
        Some(Joint {
            kind: joint.kind,
            a,
            b,
            arm_a: start.turn.inverse_transform_vector(&(anchor - start.position)),
            arm_b: turn_b.inverse_transform_vector(&(anchor - from)),
            seen: turn_b.inverse() * start.turn,
            axis: turn_b.inverse_transform_vector(&axis.unwrap_or_else(V3::x)),
            stiffness: joint.stiffness,
            damping: joint.damping,
        })
    }
}
