//! Bodies of a scene as particles with mass, velocity and material.

use cosplat_core::asset::Asset;
use cosplat_core::boundary::{add, cross, scale, sub};
use cosplat_core::scene::{Body, Material, Source, VelocityField};

use crate::law::Law;
use crate::model::{Mark, Shown};
use crate::read::Reader;
use crate::read_regions::relative_densities;
use crate::real::Real;
use crate::sample::{Sampled, prepared, sample};
use crate::store::Seed;

impl Reader<'_> {
    /// Law of one of the materials of a body.
    pub(crate) fn law<R: Real>(&mut self, body: &Body, material: &Material) -> Law<R> {
        let lame = material.lame();
        match (*material, lame) {
            (Material::Elastic { viscosity_pa_s, .. }, Some(lame)) => Some(Law::elastic(lame, viscosity_pa_s)),
            (Material::Elastoplastic { yield_stress_pa, .. }, Some(lame)) => {
                Some(Law::elastoplastic(lame, yield_stress_pa, self.params.norm))
            }
            (
                Material::Viscoplastic { yield_stress_pa, hardening_pa, consistency_pa_sn, flow_index, .. },
                Some(lame),
            ) => {
                let fluid = (consistency_pa_sn, flow_index);
                Some(Law::viscoplastic(lame, [yield_stress_pa, hardening_pa], fluid, self.params.norm))
            }
            (Material::Granular { friction_angle_deg, cohesion_pa, .. }, Some(lame)) => {
                Some(Law::sand(lame, friction_angle_deg, cohesion_pa, self.params.cone))
            }
            (Material::Snow { critical_compression, critical_stretch, hardening, .. }, Some(lame)) => {
                Some(Law::snow(lame, [critical_compression, critical_stretch, hardening]))
            }
            (Material::MpmLiquid { bulk_modulus_pa, viscosity_pa_s, .. }, _) => {
                Some(Law::liquid(bulk_modulus_pa, viscosity_pa_s))
            }
            _ => None,
        }
        .unwrap_or_else(|| {
            self.refuse(format!("material {} (body `{}`)", material.name(), body.name));
            Law::elastic(cosplat_core::scene::Lame { lambda_pa: 1.0, mu_pa: 1.0 }, 0.0)
        })
    }

    /// Particles of a body, of which `first` come before, and what is shown of it. `kinds` are the part and the history at
    /// the start of each of its materials.
    pub(crate) fn body(&mut self, body: &Body, index: u32, first: u32, kinds: &[(u32, f64)]) -> (Vec<Seed>, Shown) {
        if body.prescribed.is_some() {
            self.refuse(format!("prescribed motion (body `{}`)", body.name));
        }
        let has_interface = self.scene.is_coupled(&body.name);
        let Sampled { points, volumes, surface, area } = match self.sampled(body, has_interface) {
            Ok(sampled) => sampled,
            Err(what) => {
                self.refuse(what);
                return (Vec::new(), Shown::default());
            }
        };
        let turn = |v: [f64; 3]| body.pose.rotate(v);
        let places: Vec<[f64; 3]> = points.iter().map(|&p| body.pose.apply(p)).collect();
        let volume: f64 = volumes.iter().sum();
        let kind_of = self.kinds(body, &points);
        // Volumes of the same mass in the body's own material.
        let heavy = relative_densities(body);
        let weights: Vec<f64> = volumes.iter().zip(&kind_of).map(|(v, &kind)| v * heavy[kind]).collect();
        let weight: f64 = weights.iter().sum();
        let mass = body.mass_kg.unwrap_or(body.material.density().unwrap_or(0.0) * weight);
        let density = mass / weight;
        let sound = |x: f64| x.is_finite() && x > 0.0;
        if !(sound(mass) && weights.iter().all(|&w| sound(w * density))) {
            self.refuse(format!("bodies without a positive mass and volume (body `{}`)", body.name));
        }
        let weighted = places.iter().zip(&weights).fold([0.0; 3], |s, (&x, &w)| add(s, scale(x, w)));
        let center = scale(weighted, 1.0 / weight);
        let seeds = (0..places.len()).map(|i| {
            let (position, volume, (part, past)) = (places[i], volumes[i], kinds[kind_of[i]]);
            let (velocity, gradient) = velocity_at(&body.velocity, position, center);
            Seed { position, velocity, gradient, mass: density * weights[i], volume, past, body: index, part }
        });
        let each = area / surface.len().max(1) as f64;
        let mark = |&(i, normal): &(usize, [f64; 3])| Mark {
            id: first + i as u32,
            normal: turn(normal),
            area: each,
            volume: volumes[i],
            mass: density * weights[i],
        };
        let shown = Shown {
            has_interface,
            is_capture: matches!(body.source, Source::Splat { .. }),
            surface: surface.iter().map(mark).collect(),
            volume,
            mass,
        };
        (seeds.collect(), shown)
    }

    fn sampled(&self, body: &Body, shown: bool) -> Result<Sampled, String> {
        if !matches!(body.source, Source::Splat { .. } | Source::Mesh { .. }) {
            return sample(body, body.spacing_m.unwrap_or(0.5 * self.dx));
        }
        let name = &body.name;
        let cloud = self.cloud(body).ok_or_else(|| {
            format!("captures and meshes that were not filled with particles before the run (body `{name}`)")
        })?;
        let wrong = match Asset::Particles(cloud.clone()).check() {
            Err(wrong) => wrong.to_string(),
            Ok(()) if cloud.position_m.is_empty() => "it has no particle".into(),
            Ok(()) if !(cloud.spacing_m.is_finite() && cloud.spacing_m > 0.0) => {
                format!("its spacing is {} m", cloud.spacing_m)
            }
            Ok(()) => return Ok(prepared(cloud, shown)),
        };
        Err(format!("the particles that were prepared for body `{name}`: {wrong}"))
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
