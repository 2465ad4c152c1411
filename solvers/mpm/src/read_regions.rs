//! Regions of bodies: which particle is of which material.
//!
//! Parts are numbered bodies first, then regions in the order of the scene: the part of a body's own material has the
//! body's number, and a scene without regions is as it was.

use cosplat_core::scene::{Body, Material};

use crate::law::Law;
use crate::read::Reader;
use crate::real::Real;

/// Parts of all bodies.
pub(crate) struct Parts<R: Real> {
    /// Law by part.
    pub(crate) laws: Vec<Law<R>>,
    /// Body by part.
    pub(crate) owners: Vec<u32>,
    /// Parts by body, in the order of its materials.
    pub(crate) of: Vec<Vec<u32>>,
}

impl Reader<'_> {
    /// Numbers the parts and refuses by name what they cannot be.
    pub(crate) fn parts<R: Real>(&mut self) -> Parts<R> {
        let scene = self.scene;
        let mut laws: Vec<Law<R>> = scene.bodies.iter().map(|b| self.law(b, &b.material)).collect();
        let mut owners: Vec<u32> = (0..laws.len() as u32).collect();
        let mut of: Vec<Vec<u32>> = owners.iter().map(|&i| vec![i]).collect();
        for (i, body) in scene.bodies.iter().enumerate() {
            for region in &body.regions {
                of[i].push(laws.len() as u32);
                laws.push(self.law(body, &region.material));
                owners.push(i as u32);
            }
            if !body.regions.is_empty() && of[i].iter().any(|&part| laws[part as usize].flows()) {
                self.refuse(format!("regions of sand or liquid, or in them (body `{}`)", body.name));
            }
            // Whether bodies touch at a node is told from volumes, which are masses over one density.
            if scene.bodies.len() > 1 && relative_densities(body).iter().any(|&r| (r - 1.0).abs() > SAME_DENSITY) {
                self.refuse(format!(
                    "regions of another density beside other bodies in one process (body `{}`; give it a solver of its own)",
                    body.name
                ));
            }
        }
        if self.params.f_bar == Some(false) {
            laws = laws.into_iter().map(Law::without_f_bar).collect();
        }
        Parts { laws, owners, of }
    }

    /// Place of each particle's material in those of the body; refuses regions without a particle.
    pub(crate) fn kinds(&mut self, body: &Body, points: &[[f64; 3]]) -> Vec<usize> {
        if body.regions.is_empty() {
            return vec![0; points.len()];
        }
        let kinds: Vec<usize> = points.iter().map(|&x| body.material_at(x)).collect();
        for empty in (1..=body.regions.len()).filter(|kind| !kinds.contains(kind)) {
            self.refuse(format!(
                "regions without a particle (region {} of body `{}`: it lies outside, under a later one, or is smaller than the spacing)",
                empty - 1,
                body.name
            ));
        }
        kinds
    }
}

/// Part by which densities may differ and still count as one: rounding of written numbers.
const SAME_DENSITY: f64 = 1e-9;

/// Densities of a body's materials over that of its own, which is 1 exactly.
pub(crate) fn relative_densities(body: &Body) -> Vec<f64> {
    let own = body.material.density().unwrap_or(1.0);
    let of = |m: &Material| m.density().map_or(1.0, |density| density / own);
    std::iter::once(1.0).chain(body.regions.iter().map(|r| of(&r.material))).collect()
}
