//! Plugin parameters.

use cosplat_core::plan::BoundaryForm;
use cosplat_core::plugin::{PluginError, SolverScene};
use cosplat_core::scene::Material;
use serde_json::{Value, json};

use crate::cohesion;
use crate::state::Equation;

/// Checked parameters.
#[derive(Clone, Debug)]
pub(crate) struct Params {
    /// Courant number of sound over the smoothing length.
    pub(crate) courant: f64,
    /// Longest substep \[s\].
    pub(crate) most: f64,
    /// Monaghan's α: least viscosity, as `ρ α h c / 10`.
    pub(crate) artificial: f64,
    /// δ of the density diffusion.
    pub(crate) diffusion: f64,
    /// How pressure is found, and why so, where the user does not say.
    pub(crate) pressure: Pressure,
    pub(crate) reason: Option<String>,
    /// How it follows from the density, where it does.
    pub(crate) equation: Equation,
    /// Whether viscosity is implicit, where the user says so.
    pub(crate) implicit: Option<bool>,
    /// Mean compression that incompressible solutions may leave.
    pub(crate) accuracy: f64,
    /// Most iterations of an incompressible solution.
    pub(crate) iterations: u64,
}

/// How pressure is found.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Pressure {
    /// From the density, by an equation of state.
    Weak,
    /// So that the liquid keeps its volume.
    Incompressible,
}

/// JSON Schema of the parameters.
pub(crate) fn schema() -> Value {
    let number = |least: &str, what: &str| json!({ "type": "number", least: 0, "description": what });
    json!({
        "type": "object",
        "additionalProperties": false,
        "properties": {
            "courant": number("exclusiveMinimum", "Courant number of sound over the smoothing length; default 0.5"),
            "max_substep_s": number("exclusiveMinimum", "Longest substep [s]"),
            "artificial_viscosity":
                number("minimum", "Least viscosity, as rho alpha h c / 10, for stability; for dfsph c is ten times the speed \
                                   of a fall through the liquid's height; default alpha = 0.02"),
            "density_diffusion": number("minimum", "delta of the density diffusion; default 0.1"),
            "pressure": {
                "enum": ["dfsph", "wcsph"],
                "description": "How pressure is found: dfsph keeps the volume, wcsph follows from the density; default \
                                dfsph, but wcsph beside partners that deform and for surface tension that counts"
            },
            "state_equation": {
                "enum": ["tait", "linear"],
                "description": "How the pressure of wcsph follows from the density: Tait's with exponent 7, or linear with the \
                                same speed of sound; default tait"
            },
            "viscosity": {
                "enum": ["explicit", "implicit"],
                "description": "How viscosity is computed; default implicit where explicit viscosity would bind the substep \
                                and no partner has friction, else explicit"
            },
            "pressure_accuracy": number(
                "exclusiveMinimum",
                "Mean compression that a solution of dfsph may leave, and fifty times that at any place; default 1e-4"
            ),
            "max_iterations": number("exclusiveMinimum", "Most iterations of a solution of dfsph; default 100")
        }
    })
}

impl Params {
    /// Reads them, for particles that are `spacing` apart \[m\].
    pub(crate) fn read(scene: &SolverScene, spacing: f64) -> Result<Self, PluginError> {
        let number = |key: &str, default: f64, least: f64| {
            let value = scene.number(key, default)?;
            let why = || PluginError::Unsupported(format!("parameter `{key}` is {value}, which is too small"));
            if value < least { Err(why()) } else { Ok(value) }
        };
        let (pressure, reason) = pressure(scene, spacing)?;
        Ok(Self {
            courant: number("courant", 0.5, f64::MIN_POSITIVE)?,
            most: number("max_substep_s", f64::MAX, f64::MIN_POSITIVE)?,
            artificial: number("artificial_viscosity", 0.02, 0.0)?,
            diffusion: number("density_diffusion", 0.1, 0.0)?,
            pressure,
            reason,
            equation: equation(scene, pressure)?,
            implicit: implicit(scene)?,
            accuracy: number("pressure_accuracy", 1e-4, f64::MIN_POSITIVE)?,
            iterations: number("max_iterations", 100.0, 1.0)? as u64,
        })
    }
}

/// Against what deforms, only a liquid that gives way stays bounded; drops that keep their volume swing too slowly.
fn pressure(scene: &SolverScene, spacing: f64) -> Result<(Pressure, Option<String>), PluginError> {
    let sampled = scene.interfaces.iter().find(|v| v.partner_form != BoundaryForm::Proxy);
    match (scene.params.get("pressure").map(|v| v.as_str()), sampled) {
        (None, Some(view)) => Ok(weak(&format!("`{}` may deform", view.partner))),
        (None, None) => Ok(match drop(scene, spacing) {
            Some(body) => weak(&format!("surface tension of `{body}` counts")),
            None => (Pressure::Incompressible, Some("pressure keeps the volume (dfsph), as no partner deforms".into())),
        }),
        (Some(Some("wcsph")), _) => Ok((Pressure::Weak, None)),
        (Some(Some("dfsph")), None) => Ok((Pressure::Incompressible, None)),
        (Some(Some("dfsph")), Some(view)) => Err(PluginError::Unsupported(format!(
            "the sph solver does not support: an incompressible liquid against a body that deforms (`{}`); use pressure = \
             \"wcsph\"",
            view.partner
        ))),
        (Some(_), _) => Err(PluginError::Unsupported("parameter `pressure` is neither \"dfsph\" nor \"wcsph\"".into())),
    }
}

fn weak(why: &str) -> (Pressure, Option<String>) {
    (Pressure::Weak, Some(format!("pressure follows from the density (wcsph), as {why}")))
}

/// A body whose surface tension counts at that spacing \[m\].
fn drop(scene: &SolverScene, spacing: f64) -> Option<&str> {
    let counts = |material: &Material| {
        matches!(*material, Material::SphLiquid { density_kg_m3, surface_tension_n_m, .. }
            if cohesion::bond(scene, density_kg_m3, surface_tension_n_m, spacing) < cohesion::WEAK)
    };
    scene.bodies.iter().find(|b| counts(&b.material)).map(|b| b.name.as_str())
}

fn equation(scene: &SolverScene, pressure: Pressure) -> Result<Equation, PluginError> {
    let wrong = |what: &str| Err(PluginError::Unsupported(format!("parameter `state_equation` {what}")));
    match scene.params.get("state_equation").map(|v| v.as_str()) {
        Some(_) if pressure == Pressure::Incompressible => {
            wrong("has no meaning for dfsph, which keeps the volume; leave it out, or use pressure = \"wcsph\"")
        }
        None | Some(Some("tait")) => Ok(Equation::Tait),
        Some(Some("linear")) => Ok(Equation::Linear),
        Some(_) => wrong("is neither \"tait\" nor \"linear\""),
    }
}

fn implicit(scene: &SolverScene) -> Result<Option<bool>, PluginError> {
    let wrong = |what: &str| Err(PluginError::Unsupported(what.into()));
    match scene.params.get("viscosity").map(|v| v.as_str()) {
        None => Ok(None),
        Some(Some("explicit")) => Ok(Some(false)),
        Some(Some("implicit")) if rough(scene) => wrong(
            "the sph solver does not support: implicit viscosity beside partners with friction; use viscosity = \"explicit\", \
             or pairs without friction",
        ),
        Some(Some("implicit")) => Ok(Some(true)),
        Some(_) => wrong("parameter `viscosity` is neither \"explicit\" nor \"implicit\""),
    }
}

/// Whether the liquid sticks to a partner.
pub(crate) fn rough(scene: &SolverScene) -> bool {
    scene.interfaces.iter().any(|v| v.pair.as_ref().is_none_or(|p| p.kinetic_friction > 0.0))
}
