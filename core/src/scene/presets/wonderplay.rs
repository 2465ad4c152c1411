//! Materials of the second seed: `WonderPlay`, supplementary Table S2.

use super::Preset;
use crate::scene::material::{Lame, Material};
use crate::scene::pair::PairDefaults;

const TABLE: &str = "WonderPlay (2025), supplementary Table S2 (simulation parameters and default values)";

/// Rows of Table S2 that belong to no material.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SimulationDefaults {
    /// Step time \[s\].
    pub step_s: f64,
    /// Substeps in a step.
    pub substeps: u32,
    /// Sampled particle size \[m\].
    pub particle_size_m: f64,
    /// Gravity \[m/s²\].
    pub gravity_m_s2: [f64; 3],
    /// MPM grid cells per metre \[1/m\].
    pub grid_density_1_m: f64,
}

/// "General simulation" and "Grid density" of Table S2. No MPM default of the same table is stable at this step.
pub const SIMULATION: SimulationDefaults = SimulationDefaults {
    step_s: 1e-2,
    substeps: 10,
    particle_size_m: 1e-2,
    gravity_m_s2: [0.0, 0.0, -9.8],
    grid_density_1_m: 128.0,
};

/// Density the table leaves open: the simulator's default for deformable materials \[kg/m³\].
const DENSITY_KG_M3: f64 = 1000.0;

const fn preset(name: &'static str, material: Material, note: &'static str) -> Preset {
    Preset { name, material, source: TABLE, note, coupling: None }
}

pub(super) const PRESETS: &[Preset] = &[
    Preset {
        coupling: Some(PairDefaults {
            static_friction: 0.1,
            kinetic_friction: 0.1,
            restitution: 0.0,
            softness_m: 0.002,
        }),
        ..preset(
            "wonderplay-rigid",
            Material::Rigid { density_kg_m3: 600.0, friction: 0.1 },
            "Only the friction is printed. The density is Genesis's default for rigid bodies (600, in its first public \
             version 200), softness and restitution too. The original moves rigid bodies by shape matching",
        )
    },
    preset(
        "wonderplay-elastic",
        Material::Elastic {
            density_kg_m3: DENSITY_KG_M3,
            youngs_modulus_pa: 3e5,
            poissons_ratio: 0.2,
            viscosity_pa_s: 0.0,
        },
        "No density is printed; 1000 is Genesis's default. The published step of 1 ms at 128 cells a metre is 2.3 \
         times the Courant limit",
    ),
    preset(
        "wonderplay-liquid",
        Material::MpmLiquid {
            density_kg_m3: DENSITY_KG_M3,
            bulk_modulus_pa: Lame::from_young_poisson(1e7, 0.2).lambda_pa,
            viscosity_pa_s: 0.0,
        },
        "Printed as E = 1e7 Pa and ν = 0.2. Genesis drops the shear part of a liquid, so what is left is a bulk \
         modulus of λ = 2.78e6 Pa. Unstable at the published step: 1 ms at 128 cells a metre is 6.7 times the Courant \
         limit. No density is printed; 1000 is Genesis's default",
    ),
    preset(
        "wonderplay-granular",
        Material::Granular {
            density_kg_m3: DENSITY_KG_M3,
            youngs_modulus_pa: 1e6,
            poissons_ratio: 0.2,
            friction_angle_deg: 45.0,
            cohesion_pa: 0.0,
        },
        "The angle is in degrees. No density is printed; 1000 is Genesis's default. The published step of 1 ms at 128 \
         cells a metre is 4.3 times the Courant limit",
    ),
    preset(
        "wonderplay-cloth",
        Material::Cloth {
            areal_density_kg_m2: 4.0,
            static_friction: 0.15,
            kinetic_friction: 0.15,
            stretch_compliance_m_n: 1e-7,
            bending_compliance_rad_n: 1e-5,
            stretch_relaxation: 0.3,
            bending_relaxation: 0.1,
        },
        "Only the compliances are printed; areal density, frictions and relaxations are Genesis's defaults. In Genesis \
         the relaxations, not the compliances, set the stiffness, which changes with step, iterations and mesh",
    ),
    preset(
        "wonderplay-smoke",
        Material::Smoke { density_kg_m3: 1.2, viscosity: 0.1 },
        "The viscosity is the share of the neighbours' relative velocity a particle takes over per step (XSPH), \
         without a unit and dependent on the step. No density is printed; 1.2 is that of air",
    ),
];
