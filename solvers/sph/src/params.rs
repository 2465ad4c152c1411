//! Plugin parameters.

use cosplat_core::plugin::{PluginError, SolverScene};
use serde_json::{Value, json};

/// Checked parameters.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Params {
    /// Courant number of sound over the smoothing length.
    pub(crate) courant: f64,
    /// Longest substep \[s\].
    pub(crate) most: f64,
    /// Monaghan's α: least viscosity, as `ρ α h c / 10`.
    pub(crate) artificial: f64,
    /// δ of the density diffusion.
    pub(crate) diffusion: f64,
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
                number("minimum", "Least viscosity, as rho alpha h c / 10, for stability; default alpha = 0.02"),
            "density_diffusion": number("minimum", "delta of the density diffusion; default 0.1")
        }
    })
}

impl Params {
    /// Reads them.
    pub(crate) fn read(scene: &SolverScene) -> Result<Self, PluginError> {
        let number = |key: &str, default: f64, least: f64| {
            let value = scene.number(key, default)?;
            let why = || PluginError::Unsupported(format!("parameter `{key}` is {value}, which is too small"));
            if value < least { Err(why()) } else { Ok(value) }
        };
        Ok(Self {
            courant: number("courant", 0.5, f64::MIN_POSITIVE)?,
            most: number("max_substep_s", f64::MAX, f64::MIN_POSITIVE)?,
            artificial: number("artificial_viscosity", 0.02, 0.0)?,
            diffusion: number("density_diffusion", 0.1, 0.0)?,
        })
    }
}
