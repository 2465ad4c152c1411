//! A material with one number changed, as a scene file writes it: also where the scene takes a preset.

use cosplat_core::scene::Material;

/// The material as a table with `key` set to `value`; none for kinds of which nothing is left out.
pub(super) fn with(material: &Material, key: &str, value: f64) -> Option<String> {
    let (kind, numbers) = match *material {
        Material::Elastoplastic { density_kg_m3, youngs_modulus_pa, poissons_ratio, yield_stress_pa } => {
            let numbers = vec![
                ("density", density_kg_m3),
                ("youngs_modulus", youngs_modulus_pa),
                ("poissons_ratio", poissons_ratio),
                ("yield_stress", yield_stress_pa),
            ];
            ("elastoplastic", numbers)
        }
        Material::SphLiquid { density_kg_m3, stiffness_pa, viscosity_pa_s, surface_tension_n_m } => {
            let numbers = vec![
                ("density", density_kg_m3),
                ("stiffness", stiffness_pa),
                ("viscosity", viscosity_pa_s),
                ("surface_tension", surface_tension_n_m),
            ];
            ("sph-liquid", numbers)
        }
        Material::Cloth {
            areal_density_kg_m2,
            static_friction,
            kinetic_friction,
            stretch_compliance_m_n,
            bending_compliance_rad_n,
            stretch_relaxation,
            bending_relaxation,
        } => {
            let numbers = vec![
                ("areal_density", areal_density_kg_m2),
                ("static_friction", static_friction),
                ("kinetic_friction", kinetic_friction),
                ("stretch_compliance", stretch_compliance_m_n),
                ("bending_compliance", bending_compliance_rad_n),
                ("stretch_relaxation", stretch_relaxation),
                ("bending_relaxation", bending_relaxation),
            ];
            ("cloth", numbers)
        }
        _ => return None,
    };
    let written = numbers.iter().map(|(name, number)| {
        // The shortest decimal number that is read as the same bits.
        format!("{name} = {:?}", if *name == key { value } else { *number })
    });
    Some(format!("{{ kind = \"{kind}\", {} }}", written.collect::<Vec<_>>().join(", ")))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::render::Paint;
    use crate::scene_source::{load, parse};

    #[test]
    fn a_preset_becomes_a_table_that_differs_in_one_number() {
        let source = load("silk-over-rock").unwrap();
        let read = |changes: &[String]| {
            let (scene, _) = parse(&source, changes, Paint::off()).unwrap();
            scene.bodies.into_iter().find(|body| body.name == "silk").unwrap().material
        };
        let silk = read(&[]);
        let Material::Cloth { stretch_compliance_m_n, .. } = silk else { panic!("silk is cloth") };
        let same = with(&silk, "stretch_compliance", stretch_compliance_m_n).unwrap();
        assert_eq!(read(&[format!("body.silk.material={same}")]), silk);
        let stiff = with(&silk, "stretch_compliance", 0.0).unwrap();
        let Material::Cloth { stretch_compliance_m_n, .. } = read(&[format!("body.silk.material={stiff}")]) else {
            panic!("it is still cloth")
        };
        assert_eq!(stretch_compliance_m_n.to_bits(), 0);
    }
}
