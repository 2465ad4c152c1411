//! Colliders and partners: their shapes and what they do to each body.

use cosplat_core::plan::BoundaryForm;
use cosplat_core::plugin::{InterfaceView, ViewRole};
use cosplat_core::scene::{Source, StaticCollider, Wall as WallKind};

use crate::model::Face;
use crate::proxy::Partner;
use crate::read::Reader;
use crate::swarm::Cloud;
use crate::walls::{Surface, Wall};
use cosplat_core::distance::{Placed, Shape};

impl Reader<'_> {
    /// Shape of a collider or partner, in its own frame or about its centre of mass.
    fn shape(&mut self, name: &str, source: &Source, about_centre: bool) -> Option<Shape> {
        let asset = self.scene.assets.get(name).map(AsRef::as_ref);
        match Shape::prepared(source, asset, about_centre, self.dx) {
            Ok(shape) => Some(shape),
            Err(wrong) => {
                self.refuse(format!("the shape of `{name}` as a collider: {wrong}"));
                None
            }
        }
    }

    /// A static collider.
    pub(crate) fn wall(&mut self, wall: &StaticCollider) -> Option<Wall> {
        if wall.motion.is_some() {
            self.refuse(format!("moving static colliders (`{}`)", wall.name));
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
        Some(Wall { shape: Placed::at(shape, &wall.pose), surface })
    }

    /// Interfaces as this solver plays them, the rigid partners among them, and those that show samples.
    pub(crate) fn interfaces(&mut self) -> (Vec<Face>, Vec<Partner>, Vec<Cloud>) {
        let (mut faces, mut partners, mut clouds) = (Vec::new(), Vec::<Partner>::new(), Vec::<Cloud>::new());
        for view in &self.scene.interfaces {
            let label = format!("`{}` and `{}`", view.own, view.partner);
            let Some(body) = self.scene.bodies.iter().position(|b| b.name == view.own) else {
                self.refuse(format!("interfaces of bodies it does not have ({label})"));
                continue;
            };
            let (mut partner, mut cloud) = (None, None);
            match view.role {
                ViewRole::ContactResponder => {}
                ViewRole::ContactResolver if view.partner_form == BoundaryForm::Proxy => {
                    partner = self.partner(view, body, &mut partners);
                }
                ViewRole::ContactResolver => cloud = self.sampled_partner(view, body, &mut clouds),
                _ => self.refuse(format!("links ({label})")),
            }
            faces.push(Face { id: view.id, body, role: view.role, partner, cloud });
        }
        (faces, partners, clouds)
    }

    fn sampled_partner(&mut self, view: &InterfaceView, body: usize, clouds: &mut Vec<Cloud>) -> Option<usize> {
        let Some(pair) = view.pair.clone() else {
            self.refuse(format!("partners without a listed pair (`{}`)", view.partner));
            return None;
        };
        let surface = self.surface(&pair)?;
        let index = clouds.iter().position(|c| c.name == view.partner).unwrap_or_else(|| {
            let pairs = vec![None; self.scene.bodies.len()];
            clouds.push(Cloud { name: view.partner.clone(), pairs, ..Cloud::default() });
            clouds.len() - 1
        });
        clouds[index].pairs[body] = Some(surface);
        Some(index)
    }

    fn partner(&mut self, view: &InterfaceView, body: usize, partners: &mut Vec<Partner>) -> Option<usize> {
        let (Some(source), Some(pair)) = (&view.partner_source, view.pair.clone()) else {
            self.refuse(format!("rigid partners without a shape or a listed pair (`{}`)", view.partner));
            return None;
        };
        let surface = self.surface(&pair)?;
        let known = partners.iter().position(|p| p.name == view.partner);
        let index = if let Some(index) = known {
            index
        } else {
            let shape = self.shape(&view.partner, source, true)?;
            let pairs = vec![None; self.scene.bodies.len()];
            partners.push(Partner { name: view.partner.clone(), shape, pairs });
            partners.len() - 1
        };
        partners[index].pairs[body] = Some((view.id, surface));
        Some(index)
    }
}
