//! Colliders and partners: their shapes and what they do to each body.

use cosplat_core::plan::BoundaryForm;
use cosplat_core::plugin::{InterfaceView, ViewRole};
use cosplat_core::scene::{Source, StaticCollider, Wall as WallKind};

use crate::contact::Surface;
use crate::model::{Face, Part};
use crate::read::Reader;
use crate::sim::{Partner, Wall};
use cosplat_core::distance::{Placed, Shape};

impl Reader<'_> {
    /// Shape of a collider or partner, in its own frame or about its centre of mass.
    fn shape(&mut self, name: &str, source: &Source, about_centre: bool) -> Option<Shape> {
        let asset = self.scene.assets.get(name).map(AsRef::as_ref);
        let why = match Shape::prepared(source, asset, about_centre, self.spacing) {
            Ok(Shape::HeightField(_)) => "terrain".to_owned(),
            Ok(shape) => return Some(shape),
            Err(wrong) => wrong.to_string(),
        };
        self.refused.push(format!("the shape of `{name}` as a collider: {why}"));
        None
    }

    /// A static collider.
    pub(crate) fn wall(&mut self, wall: &StaticCollider) -> Option<Wall> {
        if wall.motion.is_some() {
            self.refused.push(format!("moving static colliders (`{}`)", wall.name));
        }
        let shape = self.shape(&wall.name, &wall.source, false)?;
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
        let is_half_space = matches!(shape, Shape::Plane(None));
        Some(Wall { shape: Placed::at(shape, &wall.pose), is_half_space, surface })
    }

    /// Interfaces as this solver plays them, and the rigid partners among them.
    pub(crate) fn interfaces(&mut self) -> (Vec<Face>, Vec<Partner>) {
        let (mut faces, mut partners) = (Vec::new(), Vec::<Partner>::new());
        let scene = self.scene;
        for view in &scene.interfaces {
            let Some(body) = scene.bodies.iter().position(|b| b.name == view.own) else {
                self.refused
                    .push(format!("interfaces of bodies it does not have (`{}` and `{}`)", view.own, view.partner));
                continue;
            };
            let part = match (view.role, view.partner_form) {
                (ViewRole::ContactResponder, _) => Some(Part::Respond),
                (ViewRole::ContactResolver, BoundaryForm::Proxy) => self.partner(view, body, &mut partners),
                (
                    ViewRole::ContactResolver,
                    BoundaryForm::SamplesF32 { normals: true } | BoundaryForm::SamplesF64 { normals: true },
                ) => self.view_surface(view).map(Part::Samples),
                (ViewRole::ContactResolver, _) => {
                    self.refused.push(format!("contact with samples without normals (`{}`)", view.partner));
                    None
                }
                // Links are refused already.
                _ => None,
            };
            if let Some(part) = part {
                faces.push(Face { id: view.id, body, partner: view.partner.clone(), part });
            }
        }
        (faces, partners)
    }

    fn view_surface(&mut self, view: &InterfaceView) -> Option<Surface> {
        let Some(pair) = view.pair.clone() else {
            self.refused.push(format!("contact without parameters (`{}` and `{}`)", view.own, view.partner));
            return None;
        };
        let surface = self.surface(&pair);
        if surface.is_none() {
            self.refused.push(format!("an interface that its pair switches off (`{}` and `{}`)", pair.a, pair.b));
        }
        surface
    }

    fn partner(&mut self, view: &InterfaceView, body: usize, partners: &mut Vec<Partner>) -> Option<Part> {
        let surface = self.view_surface(view)?;
        let known = partners.iter().position(|p| p.name == view.partner);
        let index = if let Some(index) = known {
            index
        } else {
            let Some(source) = &view.partner_source else {
                self.refused.push(format!("rigid partners without a shape (`{}`)", view.partner));
                return None;
            };
            let shape = self.shape(&view.partner, source, true)?;
            let surface = vec![None; self.scene.bodies.len()];
            partners.push(Partner { name: view.partner.clone(), shape, surface });
            partners.len() - 1
        };
        partners[index].surface[body] = Some(surface);
        Some(Part::Proxy(index))
    }
}
