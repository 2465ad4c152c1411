//! Plugin parameters.

use serde_json::{Map, Value, json};

use crate::law::{Cone, YieldNorm};

/// Checked parameters.
#[derive(Clone, Debug, Default)]
pub(crate) struct Params {
    /// Grid spacing \[m\].
    pub(crate) spacing: Option<f64>,
    /// Courant number of the elastic wave.
    pub(crate) courant: Option<f64>,
    /// Way of sound after which particles of what flows have lost what their motion has beside the grid's, in cells.
    pub(crate) memory: Option<f64>,
    /// Longest substep \[s\].
    pub(crate) most: Option<f64>,
    /// Norm of the yield condition.
    pub(crate) norm: YieldNorm,
    /// Test in which sand yields at its friction angle.
    pub(crate) cone: Cone,
    /// Whether solids near incompressibility average their volume ratio.
    pub(crate) f_bar: Option<bool>,
    /// Own bodies that stick together where they meet.
    pub(crate) bonded: Vec<[String; 2]>,
}

/// JSON Schema of the parameters.
pub(crate) fn schema() -> Value {
    let positive = |what: &str| json!({ "type": "number", "exclusiveMinimum": 0, "description": what });
    json!({
        "type": "object",
        "additionalProperties": false,
        "properties": {
            "grid_spacing_m": positive("Grid spacing [m]; default twice the coarsest particle spacing"),
            "courant": positive("Courant number of the elastic wave; default 0.5, stable up to about 0.74"),
            "max_substep_s": positive("Longest substep [s]"),
            "transfer_memory": {
                "type": "number",
                "minimum": 0,
                "description": "Way of sound, in grid cells, in which sand and liquids lose what their particles' motion has beside the grid's: less loses more; default 4, 0 in each substep (APIC)"
            },
            "split_by_stiffness": {
                "type": "number",
                "minimum": 1,
                "description": "Largest ratio of wave speeds in one process: stiffer bodies get another; heard before the run, not by the solver"
            },
            "yield_norm": { "enum": ["physical", "genesis"], "description": "Norm compared with the yield stress" },
            "friction_cone": {
                "enum": ["compression", "shear"],
                "description": "Test in which sand yields at its friction angle: triaxial compression, or simple shear as on a long slope"
            },
            "f_bar": {
                "type": "boolean",
                "description": "Whether solids whose bulk modulus exceeds ten times their shear modulus average their volume ratio over cells; default true"
            },
            "bonded": {
                "type": "array",
                "items": { "type": "array", "items": { "type": "string" }, "minItems": 2, "maxItems": 2 },
                "description": "Pairs of own bodies that stick together"
            }
        }
    })
}

impl Params {
    /// Reads them; names what does not fit.
    pub(crate) fn read(map: &Map<String, Value>) -> Result<Self, Vec<String>> {
        let (mut params, mut wrong) = (Self::default(), Vec::new());
        for (key, value) in map {
            let number = value.as_f64().filter(|v| v.is_finite() && *v > 0.0);
            let fits = match key.as_str() {
                "grid_spacing_m" => set(&mut params.spacing, number),
                "courant" => set(&mut params.courant, number),
                "transfer_memory" => set(&mut params.memory, value.as_f64().filter(|v| v.is_finite() && *v >= 0.0)),
                "max_substep_s" => set(&mut params.most, number),
                // Whoever starts the processes has heard it.
                "split_by_stiffness" => value.as_f64().is_some_and(|v| v >= 1.0),
                "yield_norm" => {
                    params.norm = if value == "genesis" { YieldNorm::Genesis } else { YieldNorm::Physical };
                    value == "genesis" || value == "physical"
                }
                "friction_cone" => {
                    params.cone = if value == "shear" { Cone::Shear } else { Cone::Compression };
                    value == "shear" || value == "compression"
                }
                "f_bar" => {
                    params.f_bar = value.as_bool();
                    params.f_bar.is_some()
                }
                "bonded" => read_into(&mut params.bonded, value),
                _ => false,
            };
            if !fits {
                wrong.push(format!("parameter `{key}` = {value}"));
            }
        }
        if wrong.is_empty() { Ok(params) } else { Err(wrong) }
    }
}

fn set(target: &mut Option<f64>, number: Option<f64>) -> bool {
    *target = number;
    number.is_some()
}

fn read_into<T: serde::de::DeserializeOwned>(target: &mut T, value: &Value) -> bool {
    serde_json::from_value(value.clone()).map(|read| *target = read).is_ok()
}
