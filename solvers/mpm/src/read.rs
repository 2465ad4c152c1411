//! From a solver's part of a scene to a [`Model`], with every feature that is missing refused by name.

use cosplat_core::boundary::{add, cross, scale, sub};
use cosplat_core::plan::BoundaryForm;
use cosplat_core::plugin::{InterfaceView, PluginError, SolverScene, ViewRole};
use cosplat_core::scene::{
    Body, ContactLaw, Material, PairSpec, Space, StaticCollider, VelocityField, Wall as WallKind,
};
use nalgebra::{Quaternion, UnitQuaternion, Vector3};

use crate::contact::Pairs;
use crate::law::Law;
use crate::model::{Face, Model, Shown};
use crate::params::Params;
use crate::proxy::Partner;
use crate::read_actions::actions;
use crate::real::Real;
use crate::sample::{Sampled, extent, sample};
use crate::shape::{Placed, Shape};
use crate::sim::Setting;
use crate::stable::Limits;
use crate::store::Seed;
use crate::walls::{Surface, Wall};

/// Cells across the smallest extent of a body without a spacing.
const CELLS_ACROSS: f64 = 6.0;
/// Bodies that fit into a sort key.
const MOST_BODIES: usize = 1 << 10;

/// Reads a scene.
pub(crate) fn read<R: Real>(scene: &SolverScene) -> Result<Model<R>, PluginError> {
    let params = Params::read(&scene.params).map_err(|wrong| refusal(&wrong))?;
    let mut reader = Reader { scene, params, refused: Vec::new() };
    reader.refuse_whole_features();
    let dx = reader.grid_spacing();
    let (mut seeds, mut shown, mut laws, mut particles) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
    for (i, body) in scene.bodies.iter().enumerate() {
        let law = reader.law::<R>(body);
        let first = seeds.len() as u32;
        let (new, show) = reader.body(body, i as u32, first, body.spacing_m.unwrap_or(0.5 * dx));
        particles.push(new.len() as u64);
        seeds.extend(new);
        shown.push(show);
        laws.push(law);
    }
    let walls = scene.statics.iter().filter_map(|s| reader.wall(s)).collect();
    let pairs = reader.own_pairs(&shown);
    let (faces, partners) = reader.interfaces();
    let actions = actions(scene, &shown, &particles, &mut reader.refused);
    if !reader.refused.is_empty() {
        return Err(refusal(&reader.refused));
    }
    let takes = |i: usize| faces.iter().any(|f| f.body == i && f.role.takes_impulses());
    let carries = scene.bodies.iter().enumerate().map(|(i, b)| takes(i) || reader.params.carry.contains(&b.name));
    let setting = Setting {
        dx,
        laws,
        carries: carries.collect(),
        actions,
        pairs,
        partners,
        limits: Limits {
            courant: reader.params.courant.unwrap_or(0.5),
            most: reader.params.most.unwrap_or(f64::INFINITY),
        },
        lightest: seeds.iter().map(|s: &Seed| s.mass).fold(f64::INFINITY, f64::min),
        threads: scene.threads > 1,
    };
    let names = scene.bodies.iter().map(|b| b.name.clone()).collect();
    Ok(Model { names, seeds, shown, faces, walls, setting, particles, threads: scene.threads })
}

fn refusal(list: &[String]) -> PluginError {
    PluginError::Unsupported(format!("the material point solver does not support: {}", list.join("; ")))
}

struct Reader<'a> {
    scene: &'a SolverScene,
    params: Params,
    refused: Vec<String>,
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
        self.refused.extend(scene.joints.iter().map(|j| format!("joints (`{}`)", j.name)));
        self.refused.extend(scene.links.iter().map(|l| format!("links (`{}`)", l.name)));
        if scene.bodies.len() > MOST_BODIES {
            self.refuse(format!("more than {MOST_BODIES} bodies"));
        }
    }

    fn grid_spacing(&self) -> f64 {
        let bodies = &self.scene.bodies;
        let given = bodies.iter().filter_map(|b| b.spacing_m).fold(0.0, f64::max);
        let size = bodies.iter().filter_map(|b| extent(&b.source)).fold(f64::INFINITY, f64::min);
        let chosen = if given > 0.0 {
            2.0 * given
        } else if size.is_finite() {
            size / CELLS_ACROSS
        } else {
            1.0
        };
        self.params.spacing.unwrap_or(chosen)
    }

    fn law<R: Real>(&mut self, body: &Body) -> Law<R> {
        match body.material {
            Material::Elastoplastic { yield_stress_pa, .. } => {
                body.material.lame().map(|lame| Law::elastoplastic(lame, yield_stress_pa, self.params.norm))
            }
            Material::Elastic { .. } => body.material.lame().map(Law::elastic),
            _ => None,
        }
        .unwrap_or_else(|| {
            self.refuse(format!("material {} (body `{}`)", body.material.name(), body.name));
            Law::elastic(cosplat_core::scene::Lame { lambda_pa: 1.0, mu_pa: 1.0 })
        })
    }

    fn body(&mut self, body: &Body, index: u32, first: u32, spacing: f64) -> (Vec<Seed>, Shown) {
        if body.prescribed.is_some() {
            self.refuse(format!("prescribed motion (body `{}`)", body.name));
        }
        let Sampled { points, volume, surface, area } = match sample(body, spacing) {
            Ok(sampled) => sampled,
            Err(what) => {
                self.refuse(what);
                return (Vec::new(), Shown::default());
            }
        };
        let [x, y, z, w] = body.pose.orientation;
        let turn = UnitQuaternion::from_quaternion(Quaternion::new(w, x, y, z));
        let place =
            |p: [f64; 3]| -> [f64; 3] { (turn * Vector3::from(p) + Vector3::from(body.pose.position_m)).into() };
        let places: Vec<[f64; 3]> = points.iter().map(|&p| place(p)).collect();
        let (count, density) = (places.len() as f64, body.material.density().unwrap_or(0.0));
        let mass = body.mass_kg.unwrap_or(density * volume) / count;
        let volume = volume / count;
        if !(mass.is_finite() && mass > 0.0 && volume.is_finite() && volume > 0.0) {
            self.refuse(format!("bodies without a positive mass and volume (body `{}`)", body.name));
        }
        let center = scale(places.iter().fold([0.0; 3], |s, &x| add(s, x)), 1.0 / count);
        let seeds = places.iter().map(|&position| {
            let (velocity, gradient) = velocity_at(&body.velocity, position, center);
            Seed { position, velocity, gradient, mass, volume, body: index }
        });
        let shown = Shown {
            has_interface: self.scene.interfaces.iter().any(|v| v.own == body.name),
            area: area / surface.len().max(1) as f64,
            surface: surface.iter().map(|&(i, n)| (first + i as u32, (turn * Vector3::from(n)).into())).collect(),
            volume,
            mass,
        };
        (seeds.collect(), shown)
    }

    fn pair(&self, a: &str, b: &str) -> Option<&PairSpec> {
        self.scene.pairs.iter().find(|p| (p.a == a && p.b == b) || (p.a == b && p.b == a))
    }

    /// Surface of a listed pair; `None` where it is left out.
    fn surface(&mut self, pair: &PairSpec) -> Option<Surface> {
        if pair.enabled && pair.contact == ContactLaw::Genesis {
            self.refuse(format!("contact law genesis (`{}` and `{}`)", pair.a, pair.b));
        }
        if pair.enabled && pair.restitution != 0.0 {
            self.refuse(format!("restitution (`{}` and `{}`)", pair.a, pair.b));
        }
        pair.enabled.then_some(Surface::Coulomb(pair.static_friction, pair.kinetic_friction))
    }

    fn wall(&mut self, wall: &StaticCollider) -> Option<Wall> {
        if wall.motion.is_some() {
            self.refuse(format!("moving static colliders (`{}`)", wall.name));
        }
        let Some(shape) = Shape::of(&wall.source) else {
            self.refuse(format!("static colliders other than planes, boxes, spheres and cylinders (`{}`)", wall.name));
            return None;
        };
        let plain = match wall.wall {
            WallKind::NoSlip => Surface::Stick,
            WallKind::Slip => Surface::Coulomb(0.0, 0.0),
            WallKind::Friction { static_friction, kinetic_friction } => {
                Surface::Coulomb(static_friction, kinetic_friction)
            }
        };
        let surface = self.scene.bodies.iter().map(|b| match self.pair(&b.name, &wall.name).cloned() {
            // Sticking is the wall's own: a pair may only leave it out.
            Some(pair) if plain == Surface::Stick => pair.enabled.then_some(plain),
            Some(pair) => self.surface(&pair),
            None => Some(plain),
        });
        let surface = surface.collect();
        Some(Wall { shape: Placed::at(shape, &wall.pose), surface })
    }

    fn own_pairs(&mut self, shown: &[Shown]) -> Pairs {
        let bodies = &self.scene.bodies;
        let bonded =
            |a: &str, b: &str| self.params.bonded.iter().any(|[p, q]| (p == a && q == b) || (p == b && q == a));
        let sticks: Vec<Vec<bool>> =
            bodies.iter().map(|a| bodies.iter().map(|b| bonded(&a.name, &b.name)).collect()).collect();
        let surface = (0..bodies.len()).map(|a| {
            let row = (0..bodies.len()).map(|b| {
                if sticks[a][b] {
                    return Some(Surface::Stick);
                }
                let (a, b) = (&bodies[a], &bodies[b]);
                let defaults = cosplat_core::scene::PairDefaults::of_materials(&a.material, &b.material);
                match self.pair(&a.name, &b.name).cloned() {
                    Some(pair) => self.surface(&pair),
                    None => Some(Surface::Coulomb(defaults.static_friction, defaults.kinetic_friction)),
                }
            });
            row.collect()
        });
        Pairs { surface: surface.collect(), density: shown.iter().map(|s| s.mass / s.volume).collect() }
    }

    fn interfaces(&mut self) -> (Vec<Face>, Vec<Partner>) {
        let (mut faces, mut partners) = (Vec::new(), Vec::<Partner>::new());
        for view in &self.scene.interfaces {
            let label = format!("`{}` and `{}`", view.own, view.partner);
            let Some(body) = self.scene.bodies.iter().position(|b| b.name == view.own) else {
                self.refuse(format!("interfaces of bodies it does not have ({label})"));
                continue;
            };
            let partner = match view.role {
                ViewRole::ContactResponder => None,
                ViewRole::ContactResolver if view.partner_form == BoundaryForm::Proxy => {
                    self.partner(view, body, &mut partners)
                }
                ViewRole::ContactResolver => {
                    self.refuse(format!("resolving contact with partners that show samples ({label})"));
                    None
                }
                _ => {
                    self.refuse(format!("links ({label})"));
                    None
                }
            };
            faces.push(Face { id: view.id, body, role: view.role, partner });
        }
        (faces, partners)
    }

    fn partner(&mut self, view: &InterfaceView, body: usize, partners: &mut Vec<Partner>) -> Option<usize> {
        let shape = self.params.shapes.get(&view.partner).and_then(Shape::of);
        let (Some(shape), Some(pair)) = (shape, view.pair.clone()) else {
            self.refuse(format!(
                "rigid partners without a box, sphere, cylinder or plane as shape (`{}`)",
                view.partner
            ));
            return None;
        };
        let surface = self.surface(&pair)?;
        let index = partners.iter().position(|p| p.name == view.partner).unwrap_or_else(|| {
            let pairs = vec![None; self.scene.bodies.len()];
            partners.push(Partner { name: view.partner.clone(), shape, pairs });
            partners.len() - 1
        });
        partners[index].pairs[body] = Some((view.id, surface));
        Some(index)
    }
}

/// Velocity and its gradient at `x` for a body whose centre of mass is `center`.
fn velocity_at(field: &VelocityField, x: [f64; 3], center: [f64; 3]) -> ([f64; 3], [[f64; 3]; 3]) {
    let spin = |[x, y, z]: [f64; 3]| [[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]];
    match *field {
        VelocityField::Twist { linear_m_s, angular_rad_s } => {
            (add(linear_m_s, cross(angular_rad_s, sub(x, center))), spin(angular_rad_s))
        }
        VelocityField::Rotation { angular_rad_s, about_m } => {
            (cross(angular_rad_s, sub(x, about_m)), spin(angular_rad_s))
        }
        VelocityField::LinearMap { linear_m_s, gradient_1_s, about_m } => {
            let r = sub(x, about_m);
            let moved = gradient_1_s.map(|row| row[0] * r[0] + row[1] * r[1] + row[2] * r[2]);
            (add(linear_m_s, moved), gradient_1_s)
        }
    }
}
