//! Decisions about what bodies are made of.

use cosplat_core::scene::{Body, Material, Scene, Source};

use super::super::substitute::with;
use super::{Decision, by, decision};
use crate::folder::summary::Summary;

/// Yield stress over stiffness of what never yields.
const NEVER_YIELDS: f64 = 1e6;
/// Bulk over shear modulus above which the material point method averages the volume ratio of a solid over cells.
const STIFF_VOLUME: f64 = 10.0;

/// Decisions about what a body is made of. What a solver leaves out may as well not stand in the scene.
pub(super) fn of_material(body: &Body, summary: &Summary) -> Vec<Decision> {
    let name = &body.name;
    let without = |feature: &str, set: (String, String), indicator: Option<String>, must_not_matter: bool| {
        let instead = format!("`{name}` without {feature}");
        let plain = decision(&format!("{}-{name}", feature.replace(' ', "-")), &instead, &[], must_not_matter);
        Decision { set: vec![set], indicator: indicator.unwrap_or_default(), ..plain }
    };
    let number = |feature: &str, key: &str, value: f64, indicator: Option<String>, must_not_matter: bool| {
        let material = with(&body.material, key, value)?;
        Some(without(feature, (format!("body.{name}.material"), material), indicator, must_not_matter))
    };
    let mut found = Vec::new();
    match body.material {
        Material::SphLiquid { surface_tension_n_m, viscosity_pa_s, .. } => {
            let tension = by(summary, &format!("surface tension of `{name}`")).filter(|_| surface_tension_n_m > 0.0);
            if tension.is_some() {
                found.extend(number("surface tension", "surface_tension", 0.0, tension, true));
            }
            if viscosity_pa_s > 0.0 {
                let known = by(summary, &format!("the viscosity of `{name}`"));
                let is_known = known.is_some();
                found.extend(number("viscosity", "viscosity", 0.0, known, is_known));
            }
        }
        Material::Elastoplastic { youngs_modulus_pa, yield_stress_pa, .. } => {
            let part = yield_stress_pa / youngs_modulus_pa;
            let indicator = Some(format!("yield stress over stiffness {part:.3e} against 1.000e0"));
            let never = NEVER_YIELDS * youngs_modulus_pa;
            // A solid is not strained by its whole size: what yields only there never does.
            found.extend(number("plasticity", "yield_stress", never, indicator, part > 1.0));
        }
        Material::Cloth { areal_density_kg_m2, stretch_compliance_m_n, .. } => {
            if stretch_compliance_m_n > 0.0 {
                let part = compliance_part(body, areal_density_kg_m2, stretch_compliance_m_n, summary);
                found.extend(number("compliance", "stretch_compliance", 0.0, part, false));
            }
            if by(summary, "relaxation factors").is_some() {
                found.extend(number("relaxation", "stretch_relaxation", 1.0, None, true));
            }
        }
        _ => {}
    }
    if matches!(body.source, Source::Splat { .. }) {
        found.push(without("inside", (format!("body.{name}.splat.fill"), "\"none\"".into()), None, false));
    }
    found
}

/// Compliance of a thread over the square of a substep, against the inverse masses of its two ends: below a thousandth
/// a constraint is as good as inextensible (Macklin et al. 2016, equation 18).
fn compliance_part(body: &Body, areal_density: f64, compliance: f64, summary: &Summary) -> Option<String> {
    let process = summary.processes.iter().find(|process| process.name == body.solver)?;
    let substep = summary.simulated_s / process.substeps.max(1) as f64;
    let inverse_masses = 2.0 / (areal_density * body.spacing_m?.powi(2));
    Some(format!("{:.3e} against 1.000e-3", compliance / substep.powi(2) / inverse_masses))
}

/// The average of the volume ratio over cells, which keeps solids near incompressibility from locking.
pub(super) fn averaging(scene: &Scene, solver: &str) -> Option<Decision> {
    let ratio = |body: &Body| {
        let lame = body.material.lame()?;
        Some((lame.lambda_pa + lame.mu_pa * 2.0 / 3.0) / lame.mu_pa)
    };
    let own = scene.bodies.iter().filter(|body| body.solver == solver);
    let most = own.filter_map(ratio).reduce(f64::max)?;
    let instead = "volume ratios are not averaged over cells";
    let set = vec![(format!("solver.{solver}.params.f_bar"), "false".to_owned())];
    let indicator = format!("bulk over shear modulus {most:.3e} against {STIFF_VOLUME:.3e}");
    Some(Decision { indicator, set, ..decision(&format!("f-bar-{solver}"), instead, &[], most <= STIFF_VOLUME) })
}
