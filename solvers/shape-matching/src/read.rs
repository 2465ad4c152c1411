//! From a solver's part of a scene to a [`Model`], with every feature that is missing refused by name.

use std::sync::Arc;

use cosplat_core::asset::Asset;
use cosplat_core::distance::{MeshSolid, Placed, Shape};
use cosplat_core::plugin::{Descriptor, Moving, OffCentre, PluginError, Refusals, SolverScene};
use cosplat_core::scene::{Body as SceneBody, ContactLaw, Material, PairDefaults, StaticCollider, Wall};

use crate::body::Body;
use crate::model::{Model, Surface};
use crate::particles::Particles;
use crate::{M3, V3, turn};

/// Longest substep without a parameter \[s\], and turns of contact.
const SUBSTEP: f64 = 5e-4;
const TURNS: u32 = 20;
/// Friction of a wall that nothing slides on.
const NO_SLIP: f64 = 1e6;

/// Reads a scene.
pub(crate) fn read(plugin: &Descriptor, scene: &SolverScene) -> Result<Model, PluginError> {
    let mut reader = Reader { scene, refused: Refusals::undeclared(plugin, scene) };
    let bodies: Vec<Body> = scene.bodies.iter().filter_map(|b| reader.body(b)).collect();
    let extent = bodies.iter().map(|b| b.radius).fold(f64::INFINITY, f64::min);
    let walls = scene.statics.iter().filter_map(|s| reader.wall(s, extent)).collect();
    let pairs = scene.bodies.iter().flat_map(|a| scene.bodies.iter().map(move |b| (a, b)));
    let of_materials = |a: &SceneBody, b: &SceneBody| {
        let pair = PairDefaults::of_materials(&a.material, &b.material);
        Surface(pair.static_friction, pair.kinetic_friction)
    };
    let pairs = pairs.map(|(a, b)| reader.surface(&a.name, &b.name, of_materials(a, b))).collect();
    let views = reader.refused.views(scene);
    let influences = reader.refused.influences(scene, OffCentre { forces: false, kicks: true });
    let mut number = |key: &str, default: f64| match scene.params.get(key) {
        None => default,
        Some(value) => value.as_f64().filter(|v| v.is_finite() && *v > 0.0).unwrap_or_else(|| {
            reader.refused.push(format!("parameter `{key}` = {value}"));
            default
        }),
    };
    let (longest, turns) = (number("max_substep_s", SUBSTEP), number("contact_turns", TURNS.into()));
    reader.refused.finish()?;
    // A count beyond this is of no use.
    let turns = turns.clamp(1.0, 1000.0) as u32;
    Ok(Model { clock: scene.clock, bodies, walls, pairs, views, influences, longest, turns })
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
        let asset = self.scene.assets.get(name).map(AsRef::as_ref);
        let particles = match Particles::new(&body.source, asset, body.spacing_m) {
            Ok(particles) => particles,
            Err(why) => {
                self.refused.push(format!("{why} (body `{name}`)"));
                return None;
            }
        };
        let mass = body.mass_kg.unwrap_or(particles.volume * density_kg_m3);
        let spread = particles.spread * mass;
        let inverse = (M3::identity() * spread.trace() - spread).try_inverse();
        let Some(inverse) = inverse.filter(|_| mass.is_finite() && mass > 0.0) else {
            self.refused.push(format!("bodies without a positive mass and moments (body `{name}`)"));
            return None;
        };
        let position = V3::from(body.pose.apply(particles.centre.into()));
        let [velocity, omega] = self.refused.twist(body, position.into()).map(V3::from);
        let turn = turn(body.pose.orientation);
        let r = turn.to_rotation_matrix();
        let inertia = M3::identity() * spread.trace() - spread;
        let spin = r.matrix() * inertia * r.matrix().transpose() * omega;
        let start = Moving { position, turn, velocity, spin };
        if !start.is_finite() {
            self.refused.push(format!("positions or velocities that are not finite (body `{name}`)"));
        }
        Some(Body {
            name: name.clone(),
            mass,
            spread,
            inverse,
            centre: particles.centre,
            origin: particles.origin - particles.centre,
            radius: particles.points.iter().map(|(p, r)| p.norm() + r).fold(0.0, f64::max),
            shape: particles.shape,
            points: particles.points,
            particles: particles.count,
            start,
            coupled: self.scene.is_coupled(name),
        })
    }

    fn wall(&mut self, wall: &StaticCollider, extent: f64) -> Option<(Placed, Vec<Option<Surface>>)> {
        let name = &wall.name;
        if wall.motion.is_some() {
            self.refused.push(format!("static colliders that move (`{name}`)"));
            return None;
        }
        let mesh = || match self.scene.assets.get(name).map(AsRef::as_ref) {
            Some(asset @ Asset::Mesh(mesh)) => {
                let solid = asset.check().and_then(|()| MeshSolid::new(mesh, [0.0; 3], 0.1 * extent));
                solid.map_err(|e| format!("the mesh of `{name}` as a solid: {e}"))
            }
            _ => Err(format!("colliders other than planes, boxes, spheres, cylinders and closed meshes (`{name}`)")),
        };
        let shape = Shape::of(&wall.source).map_or_else(|| mesh().map(|m| Shape::Mesh(Arc::new(m))), Ok);
        let shape = match shape {
            Ok(shape) => shape,
            Err(why) => {
                self.refused.push(why);
                return None;
            }
        };
        let plain = match wall.wall {
            Wall::NoSlip => Surface(NO_SLIP, NO_SLIP),
            Wall::Slip => Surface(0.0, 0.0),
            Wall::Friction { static_friction, kinetic_friction } => Surface(static_friction, kinetic_friction),
        };
        let scene = self.scene;
        let surfaces = scene.bodies.iter().map(|b| self.surface(&b.name, name, plain)).collect();
        Some((Placed::at(shape, &wall.pose), surfaces))
    }

    /// Surface of two things: what the scene lists, or what they have by themselves.
    fn surface(&mut self, a: &str, b: &str, plain: Surface) -> Option<Surface> {
        let is = |x: &str, y: &str| (x == a && y == b) || (x == b && y == a);
        let Some(pair) = self.scene.pairs.iter().find(|p| is(&p.a, &p.b)) else { return Some(plain) };
        if pair.enabled && (pair.contact == ContactLaw::Genesis || pair.restitution != 0.0) {
            self.refused.push(format!("restitution and the contact law genesis (`{}` and `{}`)", pair.a, pair.b));
        }
        pair.enabled.then_some(Surface(pair.static_friction, pair.kinetic_friction))
    }
}
