//! `material`: a preset, a kind, or a table of either with numbers.

use std::collections::BTreeMap;

use super::fields::Fields;
use super::limits::{Limits, number};
use super::node::{Table, Value};
use super::report::{listed, nearest, quoted};
use super::value::At;
use crate::scene::material::{Lame, Material, SNOW};
use crate::scene::pair::DEFAULT_FRICTION;
use crate::scene::presets::{preset, presets};

const DENSITY: Limits = Limits::positive("kg/m³");
const PRESSURE: Limits = Limits::positive("Pa");
const POISSON: Limits = Limits::inside(-1.0, 0.5, "");
const FRICTION: Limits = Limits::not_negative("");
const SHARE: Limits = Limits::between(0.0, 1.0, "");

const KINDS: [&str; 11] = [
    "point-mass",
    "rigid",
    "elastic",
    "elastoplastic",
    "viscoplastic",
    "granular",
    "snow",
    "mpm-liquid",
    "sph-liquid",
    "cloth",
    "smoke",
];

/// Density of a rigid body whose mass the scene gives, where only the mass counts \[kg/m³\].
const UNUSED_DENSITY_KG_M3: f64 = 1000.0;
/// Above this wave speed \[m/s\] an explicit solver needs microsecond steps at centimetre spacing.
const FAST_WAVE_M_S: f64 = 1000.0;

/// Reads a material; `has_mass` says that the body gives its mass, so that a rigid one needs no density.
pub(super) fn material(at: &At<'_>, has_mass: bool) -> Option<Material> {
    let material = match &at.node.value {
        Value::Text(name) => by_name(at, name, has_mass),
        Value::Table(_) => at
            .table(|fields| {
                let material = by_table(fields, has_mass);
                if material.is_none() {
                    // Which keys belong here depends on the kind.
                    fields.accept_all_keys();
                }
                material
            })
            .flatten(),
        _ => {
            at.must_be("a preset, a kind or a table", None);
            None
        }
    }?;
    warn_of_fast_waves(at, &material);
    Some(material)
}

fn by_name(at: &At<'_>, name: &str, has_mass: bool) -> Option<Material> {
    if let Some(preset) = preset(name) {
        at.report.takes(preset.name);
        return Some(preset.material);
    }
    let kind = known_kind(at, name, true)?;
    let empty = Table::default();
    let read = |fields: &Fields<'_>| {
        fields.help_for_missing("write a table, as in { kind = \"rigid\", density = 500.0 }, or take a preset");
        build(kind, fields, defaults(kind, has_mass))
    };
    Fields::read(&empty, &at.node.origin, &at.path, at.report, read)
}

fn by_table(fields: &Fields<'_>, has_mass: bool) -> Option<Material> {
    match fields.one_key(&["kind", "preset"])? {
        ("preset", at) => {
            let name = at.text();
            let Some(preset) = preset(&name) else {
                unknown(&at, &name, &presets().map(|p| p.name).collect::<Vec<_>>(), "preset");
                return None;
            };
            at.report.takes(preset.name);
            build(preset.material.name(), fields, parameters(&preset.material))
        }
        (_, at) => {
            let kind = known_kind(&at, &at.text(), false)?;
            build(kind, fields, defaults(kind, has_mass))
        }
    }
}

fn known_kind(at: &At<'_>, name: &str, or_preset: bool) -> Option<&'static str> {
    let kind = KINDS.into_iter().find(|kind| *kind == name);
    if kind.is_none() && or_preset {
        unknown(at, name, &presets().map(|p| p.name).chain(KINDS).collect::<Vec<_>>(), "material");
    } else if kind.is_none() {
        unknown(at, name, &KINDS, "kind of material");
    }
    kind
}

fn unknown(at: &At<'_>, name: &str, candidates: &[&str], what: &str) {
    if name.is_empty() && !matches!(at.node.value, Value::Text(_)) {
        return;
    }
    let help = match nearest(name, candidates.iter().copied()) {
        Some(near) => format!("did you mean `{near}`?"),
        None => format!("there are {}", listed(candidates)),
    };
    at.error(format!("there is no {what} named {}", quoted(name)), Some(help));
}

/// Values of keys that need not be written.
type Values = BTreeMap<&'static str, f64>;

fn defaults(kind: &str, has_mass: bool) -> Values {
    match kind {
        "rigid" if has_mass => Values::from([("friction", DEFAULT_FRICTION), ("density", UNUSED_DENSITY_KG_M3)]),
        "rigid" => Values::from([("friction", DEFAULT_FRICTION)]),
        "viscoplastic" => Values::from([("hardening", 0.0), ("flow_index", 1.0)]),
        "granular" => Values::from([("cohesion", 0.0)]),
        "snow" => {
            let [compression, stretch, hardening] = SNOW;
            Values::from([
                ("critical_compression", compression),
                ("critical_stretch", stretch),
                ("hardening", hardening),
            ])
        }
        "sph-liquid" => Values::from([("viscosity", 0.0), ("surface_tension", 0.0)]),
        "cloth" => Values::from([
            ("static_friction", DEFAULT_FRICTION),
            ("kinetic_friction", DEFAULT_FRICTION),
            ("stretch_relaxation", 1.0),
            ("bending_relaxation", 1.0),
        ]),
        "elastic" | "mpm-liquid" | "smoke" => Values::from([("viscosity", 0.0)]),
        _ => Values::new(),
    }
}

/// The numbers of a material by the keys of a scene file.
fn parameters(material: &Material) -> Values {
    match *material {
        Material::PointMass => Values::new(),
        Material::Rigid { density_kg_m3: density, friction } => {
            Values::from([("density", density), ("friction", friction)])
        }
        Material::Elastic { density_kg_m3, youngs_modulus_pa, poissons_ratio, viscosity_pa_s } => {
            solid(density_kg_m3, youngs_modulus_pa, poissons_ratio, &[("viscosity", viscosity_pa_s)])
        }
        Material::Elastoplastic { density_kg_m3, youngs_modulus_pa, poissons_ratio, yield_stress_pa } => {
            solid(density_kg_m3, youngs_modulus_pa, poissons_ratio, &[("yield_stress", yield_stress_pa)])
        }
        Material::Viscoplastic {
            density_kg_m3,
            youngs_modulus_pa,
            poissons_ratio,
            yield_stress_pa,
            hardening_pa,
            consistency_pa_sn,
            flow_index,
        } => {
            let more = [
                ("yield_stress", yield_stress_pa),
                ("hardening", hardening_pa),
                ("consistency", consistency_pa_sn),
                ("flow_index", flow_index),
            ];
            solid(density_kg_m3, youngs_modulus_pa, poissons_ratio, &more)
        }
        Material::Granular { density_kg_m3, youngs_modulus_pa, poissons_ratio, friction_angle_deg, cohesion_pa } => {
            let more = [("friction_angle", friction_angle_deg), ("cohesion", cohesion_pa)];
            solid(density_kg_m3, youngs_modulus_pa, poissons_ratio, &more)
        }
        Material::Snow {
            density_kg_m3,
            youngs_modulus_pa,
            poissons_ratio,
            critical_compression,
            critical_stretch,
            hardening,
        } => {
            let more = [
                ("critical_compression", critical_compression),
                ("critical_stretch", critical_stretch),
                ("hardening", hardening),
            ];
            solid(density_kg_m3, youngs_modulus_pa, poissons_ratio, &more)
        }
        Material::MpmLiquid { density_kg_m3: density, bulk_modulus_pa, viscosity_pa_s } => {
            Values::from([("density", density), ("bulk_modulus", bulk_modulus_pa), ("viscosity", viscosity_pa_s)])
        }
        Material::SphLiquid { density_kg_m3, stiffness_pa, viscosity_pa_s, surface_tension_n_m } => Values::from([
            ("density", density_kg_m3),
            ("stiffness", stiffness_pa),
            ("viscosity", viscosity_pa_s),
            ("surface_tension", surface_tension_n_m),
        ]),
        Material::Cloth {
            areal_density_kg_m2,
            static_friction,
            kinetic_friction,
            stretch_compliance_m_n,
            bending_compliance_rad_n,
            stretch_relaxation,
            bending_relaxation,
        } => Values::from([
            ("areal_density", areal_density_kg_m2),
            ("static_friction", static_friction),
            ("kinetic_friction", kinetic_friction),
            ("stretch_compliance", stretch_compliance_m_n),
            ("bending_compliance", bending_compliance_rad_n),
            ("stretch_relaxation", stretch_relaxation),
            ("bending_relaxation", bending_relaxation),
        ]),
        Material::Smoke { density_kg_m3, viscosity } => {
            Values::from([("density", density_kg_m3), ("viscosity", viscosity)])
        }
    }
}

fn solid(density: f64, youngs_modulus: f64, poissons_ratio: f64, more: &[(&'static str, f64)]) -> Values {
    let common = [("density", density), ("youngs_modulus", youngs_modulus), ("poissons_ratio", poissons_ratio)];
    common.into_iter().chain(more.iter().copied()).collect()
}

/// Reads numbers that may have a default.
struct Numbers<'f, 'a> {
    fields: &'f Fields<'a>,
    defaults: Values,
}

impl Numbers<'_, '_> {
    fn get(&self, key: &'static str, limits: Limits) -> f64 {
        match self.defaults.get(key) {
            Some(default) => self.fields.num_or(key, *default, limits),
            None => self.fields.num(key, limits),
        }
    }
}

fn build(kind: &str, fields: &Fields<'_>, defaults: Values) -> Option<Material> {
    of_kind(kind, &Numbers { fields, defaults })
}

fn of_kind(kind: &str, numbers: &Numbers<'_, '_>) -> Option<Material> {
    let get = |key, limits| numbers.get(key, limits);
    let density = || get("density", DENSITY);
    let youngs_modulus = || get("youngs_modulus", PRESSURE);
    let poissons_ratio = || get("poissons_ratio", POISSON);
    Some(match kind {
        "point-mass" => Material::PointMass,
        "rigid" => Material::Rigid { density_kg_m3: density(), friction: get("friction", FRICTION) },
        "elastic" => Material::Elastic {
            density_kg_m3: density(),
            youngs_modulus_pa: youngs_modulus(),
            poissons_ratio: poissons_ratio(),
            viscosity_pa_s: get("viscosity", Limits::not_negative("Pa s")),
        },
        "elastoplastic" => Material::Elastoplastic {
            density_kg_m3: density(),
            youngs_modulus_pa: youngs_modulus(),
            poissons_ratio: poissons_ratio(),
            yield_stress_pa: get("yield_stress", PRESSURE),
        },
        "viscoplastic" => viscoplastic(numbers),
        "granular" => Material::Granular {
            density_kg_m3: density(),
            youngs_modulus_pa: youngs_modulus(),
            poissons_ratio: poissons_ratio(),
            friction_angle_deg: get("friction_angle", Limits::inside(0.0, 90.0, "degrees")),
            cohesion_pa: get("cohesion", Limits::not_negative("Pa")),
        },
        "snow" => Material::Snow {
            density_kg_m3: density(),
            youngs_modulus_pa: youngs_modulus(),
            poissons_ratio: poissons_ratio(),
            critical_compression: get("critical_compression", Limits::inside(0.0, 0.5, "")),
            critical_stretch: get("critical_stretch", Limits::inside(0.0, 0.5, "")),
            hardening: get("hardening", Limits::between(0.0, 50.0, "")),
        },
        "mpm-liquid" => Material::MpmLiquid {
            density_kg_m3: density(),
            bulk_modulus_pa: bulk_modulus(numbers),
            viscosity_pa_s: get("viscosity", Limits::not_negative("Pa s")),
        },
        "sph-liquid" => Material::SphLiquid {
            density_kg_m3: density(),
            stiffness_pa: get("stiffness", PRESSURE),
            viscosity_pa_s: get("viscosity", Limits::not_negative("Pa s")),
            surface_tension_n_m: get("surface_tension", Limits::not_negative("N/m")),
        },
        "cloth" => cloth(numbers),
        "smoke" => Material::Smoke { density_kg_m3: density(), viscosity: get("viscosity", SHARE) },
        _ => return None,
    })
}

/// It may soften, but not faster than its elasticity gives way.
fn viscoplastic(numbers: &Numbers<'_, '_>) -> Material {
    let youngs_modulus_pa = numbers.get("youngs_modulus", PRESSURE);
    let poissons_ratio = numbers.get("poissons_ratio", POISSON);
    let steepest = -3.0 * Lame::from_young_poisson(youngs_modulus_pa, poissons_ratio).mu_pa;
    Material::Viscoplastic {
        density_kg_m3: numbers.get("density", DENSITY),
        youngs_modulus_pa,
        poissons_ratio,
        yield_stress_pa: numbers.get("yield_stress", PRESSURE),
        hardening_pa: numbers.get("hardening", Limits::above(steepest, "Pa")),
        consistency_pa_sn: numbers.get("consistency", Limits::not_negative("Pa sⁿ")),
        flow_index: numbers.get("flow_index", Limits::between(0.1, 1.0, "")),
    }
}

/// A liquid's bulk modulus, or the one that E and ν leave without the shear part: λ.
fn bulk_modulus(numbers: &Numbers<'_, '_>) -> f64 {
    if numbers.fields.has("youngs_modulus") && !numbers.fields.has("bulk_modulus") {
        let limits = Limits::inside(0.0, 0.5, "");
        Lame::from_young_poisson(numbers.get("youngs_modulus", PRESSURE), numbers.get("poissons_ratio", limits))
            .lambda_pa
    } else {
        numbers.get("bulk_modulus", PRESSURE)
    }
}

fn cloth(numbers: &Numbers<'_, '_>) -> Material {
    let (static_friction, kinetic_friction) =
        (numbers.get("static_friction", FRICTION), numbers.get("kinetic_friction", FRICTION));
    super::pair::check_frictions(numbers.fields, static_friction, kinetic_friction);
    Material::Cloth {
        areal_density_kg_m2: numbers.get("areal_density", Limits::positive("kg/m²")),
        static_friction,
        kinetic_friction,
        stretch_compliance_m_n: numbers.get("stretch_compliance", Limits::not_negative("m/N")),
        bending_compliance_rad_n: numbers.get("bending_compliance", Limits::not_negative("rad/N")),
        stretch_relaxation: numbers.get("stretch_relaxation", SHARE),
        bending_relaxation: numbers.get("bending_relaxation", SHARE),
    }
}

fn warn_of_fast_waves(at: &At<'_>, material: &Material) {
    let fast = material.wave_speed_m_s().filter(|speed| *speed > FAST_WAVE_M_S);
    if let (Some(speed), Some(step)) = (fast, material.stable_dt_s(0.01)) {
        let message = format!(
            "waves in this material run at {speed:.0} m/s: explicit steps stay below {} s for each cm of spacing",
            number(format!("{step:.1e}").parse().unwrap_or(step))
        );
        at.warning(message, Some("if it only has to stay where it is, make it a `[[static]]`".to_owned()));
    }
}
