//! Plugin parameters.

use std::collections::BTreeMap;

use cosplat_core::boundary::Vec3;
use serde_json::{Map, Value, json};

use crate::read_held::{BondSpec, PullSpec};

/// Longest substep without a parameter \[s\]; the published one in the mode that repeats published pictures.
const SUBSTEP: f64 = 2.5e-4;
pub(crate) const GENESIS_SUBSTEP: f64 = 1e-3;
/// Iterations of stretch and bending: one of each in small substeps; as published otherwise.
const ITERATIONS: [u32; 2] = [1, 1];
pub(crate) const GENESIS_ITERATIONS: [u32; 2] = [4, 1];
/// Most iterations that are of any use.
const MOST_ITERATIONS: u64 = 1000;

/// Checked parameters.
#[derive(Clone, Debug)]
pub(crate) struct Params {
    /// Published factors scale the corrections; otherwise compliances count.
    pub(crate) relaxed: bool,
    /// Longest substep \[s\].
    pub(crate) longest: f64,
    /// Iterations of stretch and of bending.
    pub(crate) iterations: [u32; 2],
    /// Thickness \[m\].
    pub(crate) thickness: f64,
    /// Whether cloths touch themselves and each other.
    pub(crate) own: bool,
    /// Rate at which velocities decay \[1/s\].
    pub(crate) damping: f64,
    /// Compliance of diagonals \[m/N\], where it differs from that of the threads.
    pub(crate) shear: Option<f64>,
    /// Turns of contact with partners.
    pub(crate) turns: u32,
    /// Points of the world at t = 0 near which vertices are fixed, by body \[m\].
    pub(crate) pins: BTreeMap<String, Vec<Vec3>>,
    /// Vertices that are moved, and those that are attached to partners, by body.
    pub(crate) pulls: BTreeMap<String, Vec<PullSpec>>,
    pub(crate) bonds: BTreeMap<String, Vec<BondSpec>>,
}

/// JSON Schema of the parameters.
pub(crate) fn schema() -> Value {
    let number = |least: &str, what: &str| json!({ "type": "number", least: 0, "description": what });
    let count =
        |what: &str| json!({ "type": "integer", "minimum": 1, "maximum": MOST_ITERATIONS, "description": what });
    let vector = json!({ "type": "array", "items": { "type": "number" }, "minItems": 3, "maxItems": 3 });
    json!({
        "type": "object",
        "additionalProperties": false,
        "properties": {
            "mode": {
                "enum": ["physical", "genesis"],
                "description": "physical: compliances count; genesis: relaxation factors scale corrections as published"
            },
            "max_substep_s": number("exclusiveMinimum", "Longest substep [s]; default 2.5e-4, genesis 1e-3"),
            "iterations": count("Iterations of stretch in a substep; default 1, genesis 4"),
            "bending_iterations": count("Iterations of bending in a substep; default 1"),
            "contact_turns": count("Turns in which contact with partners is solved in a substep; default 8"),
            "thickness_m": number("minimum", "Thickness in contact [m]; default 0.001"),
            "self_collision": {
                "type": "boolean",
                "description": "Whether cloths touch themselves and each other, a thickness apart; default true"
            },
            "damping_1_s": number("minimum", "Rate at which velocities decay [1/s]; default 0"),
            "shear_compliance_m_n": number("minimum", "Compliance of diagonals [m/N]; default that of the threads"),
            "pins": {
                "type": "object",
                "additionalProperties": { "type": "array", "items": vector },
                "description": "Points of the world at t = 0 [m], by body: vertices within half a spacing are fixed"
            },
            "pulls": {
                "type": "object",
                "additionalProperties": {
                    "type": "array",
                    "items": {
                        "type": "object",
                        "additionalProperties": false,
                        "required": ["at", "velocity"],
                        "properties": { "at": vector, "velocity": vector, "until": { "type": "number", "minimum": 0 } }
                    }
                },
                "description": "Pins that move, by body: a point [m], a velocity [m/s] and when it stops [s]"
            },
            "bonds": {
                "type": "object",
                "additionalProperties": {
                    "type": "array",
                    "items": {
                        "type": "object",
                        "additionalProperties": false,
                        "required": ["to", "at"],
                        "properties": { "to": { "type": "string" }, "at": { "type": "array", "items": vector } }
                    }
                },
                "description": "Points [m], by body: vertices there are attached to a body of another solver"
            }
        }
    })
}

impl Params {
    /// Reads them; names what does not fit.
    pub(crate) fn read(map: &Map<String, Value>) -> Result<Self, Vec<String>> {
        let relaxed = map.get("mode").is_some_and(|m| m == "genesis");
        let mut params = Self {
            relaxed,
            longest: if relaxed { GENESIS_SUBSTEP } else { SUBSTEP },
            iterations: if relaxed { GENESIS_ITERATIONS } else { ITERATIONS },
            thickness: 1e-3,
            own: true,
            damping: 0.0,
            shear: None,
            turns: 8,
            pins: BTreeMap::new(),
            pulls: BTreeMap::new(),
            bonds: BTreeMap::new(),
        };
        let mut wrong = Vec::new();
        for (key, value) in map {
            let number = value.as_f64().filter(|v| v.is_finite() && *v >= 0.0);
            let count = value.as_u64().filter(|n| (1..=MOST_ITERATIONS).contains(n)).map(|n| n as u32);
            let fits = match key.as_str() {
                "mode" => value == "genesis" || value == "physical",
                "max_substep_s" => set(&mut params.longest, number.filter(|v| *v > 0.0)),
                "iterations" => set(&mut params.iterations[0], count),
                "bending_iterations" => set(&mut params.iterations[1], count),
                "contact_turns" => set(&mut params.turns, count),
                "self_collision" => set(&mut params.own, value.as_bool()),
                "thickness_m" => set(&mut params.thickness, number),
                "damping_1_s" => set(&mut params.damping, number),
                "shear_compliance_m_n" => set(&mut params.shear, number.map(Some)),
                "pins" => set(&mut params.pins, serde_json::from_value(value.clone()).ok()),
                "pulls" => set(&mut params.pulls, serde_json::from_value(value.clone()).ok()),
                "bonds" => set(&mut params.bonds, serde_json::from_value(value.clone()).ok()),
                _ => false,
            };
            if !fits {
                wrong.push(format!("parameter `{key}` = {value}"));
            }
        }
        if wrong.is_empty() { Ok(params) } else { Err(wrong) }
    }
}

fn set<T>(target: &mut T, value: Option<T>) -> bool {
    let fits = value.is_some();
    if let Some(value) = value {
        *target = value;
    }
    fits
}
