//! Materials of the first seed: captured splat scenes simulated with Genesis, supplementary Tables 3 to 6.

use super::Preset;
use crate::scene::material::Material;
use crate::scene::pair::PairDefaults;

const CLOTH_TABLE: &str = "captured splat scenes with Genesis, supplementary Table 3 (PBD cloth)";
const MPM_TABLE: &str = "captured splat scenes with Genesis, supplementary Table 4 (MPM elastoplastic)";
const RIGID_TABLE: &str = "captured splat scenes with Genesis, supplementary Table 5 (rigid bodies)";
const SPH_TABLE: &str = "captured splat scenes with Genesis, supplementary Table 6 (SPH fluid)";

const STIFF_SHELL: &str = "E and density are those of a hollow shell taken as a filled solid. Genesis yields at a \
    deviatoric stress of Y, that is √(3/2) Y = 1.22 Y in uniaxial tension; here the yield stress is the uniaxial one, \
    so multiply it by 1.2247 to repeat Genesis. Yields at 1.8 % strain, so it dents";
const SOFT_TOY: &str = "The yield stress is four times Young's modulus, so it never yields and acts as an elastic \
    solid. Genesis yields at √(3/2) Y in uniaxial tension; here the yield stress is the uniaxial one";
const BAG: &str = "The yield stress is half of Young's modulus, so it is elastic in practice. Genesis yields at \
    √(3/2) Y in uniaxial tension; here the yield stress is the uniaxial one";
const GROUND: &str = "Meant as practically fixed: its P-wave runs at 5737 m/s, explicit steps stay below 2.7 µs at 64 \
    cells a metre, and its strain under its own weight is rounding noise in single precision. Use a static collider";
const ROCK: &str = "Coupling friction 3 stops all sliding up to a tangential speed of three times the normal one, \
    close to sticking. Coupling softness is a length, 0.002 m, printed without a unit: contact begins at softness × \
    ln 10 = 4.6 mm. Restitution 0";

/// Contact parameters of Table 5, the same for all three bodies.
const ROCK_COUPLING: PairDefaults =
    PairDefaults { static_friction: 3.0, kinetic_friction: 3.0, restitution: 0.0, softness_m: 0.002 };

const fn elastoplastic(
    name: &'static str,
    [youngs_modulus_pa, poissons_ratio, density_kg_m3, yield_stress_pa]: [f64; 4],
    note: &'static str,
) -> Preset {
    let material = Material::Elastoplastic { density_kg_m3, youngs_modulus_pa, poissons_ratio, yield_stress_pa };
    Preset { name, material, source: MPM_TABLE, note, coupling: None }
}

const fn rock(name: &'static str, density_kg_m3: f64) -> Preset {
    let material = Material::Rigid { density_kg_m3, friction: ROCK_COUPLING.static_friction };
    Preset { name, material, source: RIGID_TABLE, note: ROCK, coupling: Some(ROCK_COUPLING) }
}

pub(super) const PRESETS: &[Preset] = &[
    Preset {
        name: "silk",
        material: Material::Cloth {
            areal_density_kg_m2: 1.5,
            static_friction: 0.05,
            kinetic_friction: 0.03,
            stretch_compliance_m_n: 1e-6,
            bending_compliance_rad_n: 1e-4,
            stretch_relaxation: 0.05,
            bending_relaxation: 0.02,
        },
        source: CLOTH_TABLE,
        note: "In Genesis the relaxations, not the compliances, set the stiffness: with four Jacobi iterations of \
            relaxation 0.05 an edge acts as if its compliance were 0.03 to 0.06 m/N at a step of 1 ms, changing with \
            the square of the step. A converged solver with 1e-6 m/N is far stiffer than the pictures. Compliances \
            are per constraint, so they depend on the mesh; the bending unit is printed as rad/N, an angle constraint \
            uses rad/(N m). The density is per area",
        coupling: None,
    },
    elastoplastic("can", [2e6, 0.22, 30.0, 3e4], STIFF_SHELL),
    elastoplastic("plushie", [0.25e4, 0.09, 50.0, 1e4], SOFT_TOY),
    elastoplastic("lunch-bag", [1e4, 0.20, 120.0, 5e3], BAG),
    elastoplastic("car", [2e6, 0.22, 30.0, 3e4], STIFF_SHELL),
    elastoplastic("environment", [5e10, 0.49, 2.6e4, 1e8], GROUND),
    rock("brown-rock", 5000.0),
    rock("gray-rock", 2500.0),
    rock("log", 2500.0),
    Preset {
        name: "mudslide",
        material: Material::SphLiquid {
            density_kg_m3: 1000.0,
            stiffness_pa: 60_000.0,
            viscosity_pa_s: 0.1,
            surface_tension_n_m: 0.01,
        },
        source: SPH_TABLE,
        note: "Genesis uses the viscosity as a kinematic one: the printed 0.1 Pa s acts as 0.1 m²/s, that is 100 Pa s; \
            set viscosity = 100 to repeat the pictures. Its surface tension is no N/m either: an acceleration per \
            neighbour distance. Stiffness is the factor of the Tait equation with exponent 7, so waves run at 20.5 m/s",
        coupling: None,
    },
];
