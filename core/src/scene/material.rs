//! Materials as data, and the few numbers every plan needs from them: density, wave speed, stable step.

use serde::{Deserialize, Serialize};

/// Exponent of the Tait equation of state of weakly compressible SPH, `p = stiffness ((ρ/ρ0)^7 - 1)`.
///
/// Source: Becker and Teschner, "Weakly compressible SPH for free surface flows" (2007).
pub const TAIT_EXPONENT: f64 = 7.0;

/// Published constants of snow: largest elastic compression and extension, hardening.
///
/// Source: Stomakhin et al., "A material point method for snow simulation" (2013), table 2.
pub const SNOW: [f64; 3] = [2.5e-2, 7.5e-3, 10.0];

/// What a body is made of, or a region of it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Material {
    /// Points with a mass and nothing else; the mass stands at the body.
    PointMass,
    /// Keeps its shape.
    Rigid {
        /// Mass density \[kg/m³\].
        density_kg_m3: f64,
        /// Coulomb friction coefficient of its surface.
        friction: f64,
    },
    /// Isotropic elastic solid.
    Elastic {
        /// Mass density \[kg/m³\].
        density_kg_m3: f64,
        /// Young's modulus E \[Pa\].
        youngs_modulus_pa: f64,
        /// Poisson's ratio ν.
        poissons_ratio: f64,
        /// Dynamic viscosity η beside the elasticity \[Pa s\] (Kelvin and Voigt): what damps its swings. A swing of the
        /// angular frequency ω loses the part `2π ω η / G` of its energy in a period, G being the shear modulus.
        viscosity_pa_s: f64,
    },
    /// Isotropic elastic solid with von Mises plasticity.
    Elastoplastic {
        /// Mass density \[kg/m³\].
        density_kg_m3: f64,
        /// Young's modulus E \[Pa\].
        youngs_modulus_pa: f64,
        /// Poisson's ratio ν.
        poissons_ratio: f64,
        /// Yield stress in uniaxial tension \[Pa\].
        yield_stress_pa: f64,
    },
    /// Elastic solid that flows as Herschel and Bulkley say: in simple shear `shear stress = Y/√3 + K (shear rate)^n`. Foam,
    /// dough, plasticine, mud that keeps a heap.
    Viscoplastic {
        /// Mass density \[kg/m³\].
        density_kg_m3: f64,
        /// Young's modulus E \[Pa\].
        youngs_modulus_pa: f64,
        /// Poisson's ratio ν.
        poissons_ratio: f64,
        /// Yield stress Y in slow uniaxial tension \[Pa\].
        yield_stress_pa: f64,
        /// Rise H of the yield stress with the equivalent plastic strain \[Pa\]; negative softens, down to no yield stress.
        hardening_pa: f64,
        /// Consistency K in simple shear \[Pa sⁿ\]; a viscosity where n is 1.
        consistency_pa_sn: f64,
        /// Flow index n; below 1 it thins when sheared fast.
        flow_index: f64,
    },
    /// Frictional grains: elastic inside the Drucker-Prager cone.
    Granular {
        /// Bulk mass density \[kg/m³\].
        density_kg_m3: f64,
        /// Young's modulus E \[Pa\].
        youngs_modulus_pa: f64,
        /// Poisson's ratio ν.
        poissons_ratio: f64,
        /// Angle of internal friction \[degrees\].
        friction_angle_deg: f64,
        /// Cohesion of the Mohr-Coulomb criterion \[Pa\]; 0 for dry grains.
        cohesion_pa: f64,
    },
    /// Snow: an elastic solid that breaks where it is stretched or squeezed too far, and hardens as it is packed.
    ///
    /// Source: Stomakhin et al., "A material point method for snow simulation" (2013).
    Snow {
        /// Mass density \[kg/m³\].
        density_kg_m3: f64,
        /// Young's modulus E of unpacked snow \[Pa\].
        youngs_modulus_pa: f64,
        /// Poisson's ratio ν.
        poissons_ratio: f64,
        /// Largest elastic compression θc: principal stretches stay above `1 - θc`.
        critical_compression: f64,
        /// Largest elastic extension θs: principal stretches stay below `1 + θs`.
        critical_stretch: f64,
        /// Hardening ξ: both moduli grow by `exp(ξ (1 - J_p))` with the plastic volume ratio `J_p`.
        hardening: f64,
    },
    /// Weakly compressible liquid without shear stiffness, as material points.
    MpmLiquid {
        /// Mass density at rest \[kg/m³\].
        density_kg_m3: f64,
        /// Bulk modulus K \[Pa\].
        bulk_modulus_pa: f64,
        /// Dynamic viscosity \[Pa s\].
        viscosity_pa_s: f64,
    },
    /// Weakly compressible liquid, as smoothed particles.
    SphLiquid {
        /// Mass density at rest \[kg/m³\].
        density_kg_m3: f64,
        /// Stiffness of the Tait equation of state \[Pa\], see [`TAIT_EXPONENT`].
        stiffness_pa: f64,
        /// Dynamic viscosity \[Pa s\].
        viscosity_pa_s: f64,
        /// Surface tension \[N/m\].
        surface_tension_n_m: f64,
    },
    /// Thin sheet of distance and bending constraints.
    Cloth {
        /// Mass per area \[kg/m²\].
        areal_density_kg_m2: f64,
        /// Static friction coefficient.
        static_friction: f64,
        /// Kinetic friction coefficient.
        kinetic_friction: f64,
        /// Compliance of one stretch constraint \[m/N\].
        stretch_compliance_m_n: f64,
        /// Compliance of one bending constraint, printed by the seeds as \[rad/N\]; an angle constraint uses \[rad/(N m)\].
        bending_compliance_rad_n: f64,
        /// Share of a stretch correction applied per iteration, 0..=1; 1 leaves the compliance in charge.
        stretch_relaxation: f64,
        /// Share of a bending correction applied per iteration, 0..=1; 1 leaves the compliance in charge.
        bending_relaxation: f64,
    },
    /// Smoke carried by air.
    Smoke {
        /// Mass density of the gas \[kg/m³\].
        density_kg_m3: f64,
        /// Share of the neighbours' relative velocity taken over per step, 0..=1; of the seeds' step of 1 ms for solvers in
        /// which nothing may depend on the step.
        viscosity: f64,
    },
}

/// The two Lamé parameters of an isotropic solid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lame {
    /// First parameter λ \[Pa\].
    pub lambda_pa: f64,
    /// Shear modulus μ \[Pa\].
    pub mu_pa: f64,
}

impl Lame {
    /// `λ = E ν / ((1+ν)(1-2ν))`, `μ = E / (2(1+ν))`.
    pub const fn from_young_poisson(youngs_modulus_pa: f64, poissons_ratio: f64) -> Self {
        Self {
            lambda_pa: youngs_modulus_pa * poissons_ratio / ((1.0 + poissons_ratio) * (1.0 - 2.0 * poissons_ratio)),
            mu_pa: youngs_modulus_pa / (2.0 * (1.0 + poissons_ratio)),
        }
    }

    /// Young's modulus `μ (3λ + 2μ)/(λ + μ)` \[Pa\].
    pub fn youngs_modulus_pa(self) -> f64 {
        self.mu_pa * (3.0 * self.lambda_pa + 2.0 * self.mu_pa) / (self.lambda_pa + self.mu_pa)
    }

    /// P-wave modulus `λ + 2μ` \[Pa\]: stress over strain of a uniaxial strain.
    pub fn p_wave_modulus_pa(self) -> f64 {
        self.lambda_pa + 2.0 * self.mu_pa
    }
}

impl Material {
    /// Kind as a scene file writes it.
    pub fn name(&self) -> &'static str {
        match self {
            Self::PointMass => "point-mass",
            Self::Rigid { .. } => "rigid",
            Self::Elastic { .. } => "elastic",
            Self::Elastoplastic { .. } => "elastoplastic",
            Self::Viscoplastic { .. } => "viscoplastic",
            Self::Granular { .. } => "granular",
            Self::Snow { .. } => "snow",
            Self::MpmLiquid { .. } => "mpm-liquid",
            Self::SphLiquid { .. } => "sph-liquid",
            Self::Cloth { .. } => "cloth",
            Self::Smoke { .. } => "smoke",
        }
    }

    /// Mass per volume at rest \[kg/m³\]; none for point masses and for cloth, which has a mass per area.
    pub fn density(&self) -> Option<f64> {
        match *self {
            Self::Rigid { density_kg_m3, .. }
            | Self::Elastic { density_kg_m3, .. }
            | Self::Elastoplastic { density_kg_m3, .. }
            | Self::Viscoplastic { density_kg_m3, .. }
            | Self::Granular { density_kg_m3, .. }
            | Self::Snow { density_kg_m3, .. }
            | Self::MpmLiquid { density_kg_m3, .. }
            | Self::SphLiquid { density_kg_m3, .. }
            | Self::Smoke { density_kg_m3, .. } => Some(density_kg_m3),
            Self::PointMass | Self::Cloth { .. } => None,
        }
    }

    /// Lamé parameters, for materials with a shear stiffness.
    pub fn lame(&self) -> Option<Lame> {
        match *self {
            Self::Elastic { youngs_modulus_pa, poissons_ratio, .. }
            | Self::Elastoplastic { youngs_modulus_pa, poissons_ratio, .. }
            | Self::Viscoplastic { youngs_modulus_pa, poissons_ratio, .. }
            | Self::Granular { youngs_modulus_pa, poissons_ratio, .. }
            | Self::Snow { youngs_modulus_pa, poissons_ratio, .. } => {
                Some(Lame::from_young_poisson(youngs_modulus_pa, poissons_ratio))
            }
            _ => None,
        }
    }

    /// Speed of the fastest small wave \[m/s\]; none where the model has no wave.
    ///
    /// Solids `√((λ+2μ)/ρ)`, MPM liquid `√(K/ρ)`, Tait liquid `√(7 stiffness/ρ)`.
    pub fn wave_speed_m_s(&self) -> Option<f64> {
        let modulus_pa = match *self {
            Self::MpmLiquid { bulk_modulus_pa, .. } => bulk_modulus_pa,
            Self::SphLiquid { stiffness_pa, .. } => TAIT_EXPONENT * stiffness_pa,
            _ => self.lame()?.p_wave_modulus_pa(),
        };
        Some((modulus_pa / self.density()?).sqrt())
    }

    /// Largest step at which a wave crosses at most one spacing \[s\]: `spacing / c`, that is Courant number 1.
    pub fn stable_dt_s(&self, spacing_m: f64) -> Option<f64> {
        Some(spacing_m / self.wave_speed_m_s()?)
    }

    /// Plugin that takes a body of this material when the scene names none.
    pub fn default_solver(&self) -> &'static str {
        match self {
            Self::PointMass => "oscillator",
            Self::Rigid { .. } => "rigid",
            Self::Elastic { .. }
            | Self::Elastoplastic { .. }
            | Self::Viscoplastic { .. }
            | Self::Granular { .. }
            | Self::Snow { .. }
            | Self::MpmLiquid { .. } => "mpm",
            Self::SphLiquid { .. } => "sph",
            Self::Cloth { .. } => "pbd",
            Self::Smoke { .. } => "smoke",
        }
    }
}
