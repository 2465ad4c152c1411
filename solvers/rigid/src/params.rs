//! Plugin parameters.

use cosplat_core::plugin::{PluginError, SolverScene};
use serde_json::{Value, json};

/// Longest substep where the scene gives none \[s\].
///
/// rapier's own default is 1/60 s in four parts, 1/240 s each. Twice as fine halves the first-order errors that contact
/// has per substep (what a body sinks before it is caught, what a joint turns before it is set right) and still costs
/// little beside a deformable solver; flight does not depend on it.
const SUBSTEP_S: f64 = 1.0 / 480.0;
/// Sweeps over all contacts in a substep where the scene gives none.
const ITERATIONS: f64 = 8.0;

/// Checked parameters.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Params {
    /// Longest substep \[s\].
    pub(crate) substep: f64,
    /// Sweeps over all contacts in a substep, for positions and again for velocities.
    pub(crate) iterations: usize,
    /// Whether contact is looked for as far ahead as a body moves in a substep, up to half its size.
    pub(crate) ccd: bool,
    /// What bounds the substep.
    pub(crate) bound_by: &'static str,
}

/// JSON Schema of the parameters.
pub(crate) fn schema() -> Value {
    json!({
        "type": "object",
        "additionalProperties": false,
        "properties": {
            "substep_s": {
                "type": "number",
                "exclusiveMinimum": 0,
                "description": "Longest substep [s]; default 1/480"
            },
            "substeps": {
                "type": "integer",
                "minimum": 1,
                "description": "Substeps per window, instead of a longest one"
            },
            "solver_iterations": {
                "type": "integer",
                "minimum": 1,
                "maximum": 1000,
                "description": "Sweeps over all contacts in a substep; default 8"
            },
            "ccd": {
                "type": "boolean",
                "description": "Continuous collision detection: contact is looked for as far ahead as a body moves in a substep; default true"
            }
        }
    })
}

impl Params {
    /// Reads them.
    pub(crate) fn read(scene: &SolverScene) -> Result<Self, PluginError> {
        let refused = PluginError::Unsupported;
        let count = |param: &str, default: f64, most: f64| {
            let found = scene.number(param, default)?;
            if found >= 1.0 && found <= most && found.fract() == 0.0 {
                return Ok(found);
            }
            Err(refused(format!("parameter `{param}` is {found}; it must be a whole number from 1 to {most}")))
        };
        let iterations = count("solver_iterations", ITERATIONS, 1000.0)? as usize;
        let ccd = match scene.params.get("ccd") {
            None => true,
            Some(value) => value
                .as_bool()
                .ok_or_else(|| refused(format!("parameter `ccd` is `{value}`; it must be true or false")))?,
        };
        if scene.params.contains_key("substeps") {
            if scene.params.contains_key("substep_s") {
                return Err(refused("parameters `substeps` and `substep_s` exclude each other; give one".into()));
            }
            let substep = scene.clock.window_s() / count("substeps", 1.0, 1e6)?;
            return Ok(Self { substep, iterations, ccd, bound_by: "parameter `substeps`" });
        }
        let substep = scene.number("substep_s", SUBSTEP_S)?;
        if substep <= 0.0 {
            return Err(refused(format!("parameter `substep_s` is {substep} s; it must be positive")));
        }
        let given = scene.params.contains_key("substep_s");
        let bound_by = if given { "parameter `substep_s`" } else { "contact: default longest substep of 1/480 s" };
        Ok(Self { substep, iterations, ccd, bound_by })
    }
}
