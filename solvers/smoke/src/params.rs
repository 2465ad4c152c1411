//! Plugin parameters.

use cosplat_core::boundary::Vec3;
use cosplat_core::plugin::{PluginError, SolverScene};
use serde_json::{Value, json};

/// Names of the sides, lower and upper along each axis.
const SIDES: [[&str; 2]; 3] = [["-x", "+x"], ["-y", "+y"], ["-z", "+z"]];
/// Density of air at 20 °C and 1013 hPa \[kg/m³\].
const AIR: f64 = 1.204;
/// Kinematic viscosity of air at 20 °C \[m²/s\].
const AIR_VISCOSITY: f64 = 1.5e-5;

/// Checked parameters.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Params {
    /// Whether particles are kept apart by constraints on their density, without a grid.
    pub(crate) positions: bool,
    /// Iterations of these constraints.
    pub(crate) sweeps: u64,
    /// Rate at which the air around takes a free particle along \[1/s\].
    pub(crate) drag: f64,
    /// Corners of the domain \[m\].
    pub(crate) domain: Option<[Vec3; 2]>,
    /// Edge of a cell \[m\].
    pub(crate) cell: Option<f64>,
    /// Sides that are not closed.
    pub(crate) open: [[bool; 2]; 3],
    /// Density of the air around \[kg/m³\], and its temperature \[K\].
    pub(crate) air: f64,
    pub(crate) ambient: f64,
    /// Temperature of the smoke \[K\].
    pub(crate) temperature: f64,
    /// Kinematic viscosity of air \[m²/s\].
    pub(crate) viscosity: f64,
    /// Rate of vorticity confinement \[1/s\].
    pub(crate) confinement: f64,
    /// Particles that an inflow lets go \[1/s\]; 0 for a cloud that is all there at the start.
    pub(crate) rate: f64,
    /// Velocity of the gas in the mouth of an inflow \[m/s\]; none lets it move freely.
    pub(crate) jet: Option<Vec3>,
    /// Speed of gas that is left out, over the largest; 0 to compute the whole domain.
    pub(crate) still: f64,
    /// Courant number.
    pub(crate) courant: f64,
    /// Longest substep \[s\].
    pub(crate) most: f64,
    /// Largest divergence of a cell, times its edge, over the largest speed.
    pub(crate) divergence: f64,
    /// Most iterations of a projection.
    pub(crate) iterations: u64,
}

/// JSON Schema of the parameters.
pub(crate) fn schema() -> Value {
    let number = |least: &str, what: &str| json!({ "type": "number", least: 0, "description": what });
    let vector = |what: &str| {
        let item = json!({ "type": "number" });
        json!({ "type": "array", "items": item, "minItems": 3, "maxItems": 3, "description": what })
    };
    json!({
        "type": "object",
        "additionalProperties": false,
        "properties": {
            "method": {
                "enum": ["grid", "positions"],
                "description": "`grid` (default): an incompressible gas carries the particles; `positions`: the second \
                                seed's, position-based density constraints between the particles, no air around them"
            },
            "density_iterations": number("exclusiveMinimum", "Iterations of density constraints; default 8"),
            "surface_drag": number(
                "minimum",
                "Rate [1/s] at which the air around takes particles without neighbours along, with density \
                 constraints; default 5"
            ),
            "low": vector("Lower corner of the domain [m]; without it and `high` three sizes of the body around it"),
            "high": vector("Upper corner of the domain [m]; it grows to whole blocks of 8 cells"),
            "cell": number("exclusiveMinimum", "Edge of a cell [m]; default twice the spacing of the body"),
            "open": {
                "type": "array",
                "items": { "enum": ["-x", "+x", "-y", "+y", "-z", "+z"] },
                "description": "Sides through which air passes; default all six. The others let it slide along them"
            },
            "air_density": number("exclusiveMinimum", "Density of the air around [kg/m^3]; default 1.204"),
            "ambient_temperature": number("exclusiveMinimum", "Temperature of the air around [K]; default 293.15"),
            "temperature": number(
                "exclusiveMinimum",
                "Temperature of the smoke [K]; its material's density is that at the ambient one; default ambient"
            ),
            "kinematic_viscosity": number("minimum", "Kinematic viscosity of air [m^2/s]; default 1.5e-5"),
            "vorticity_confinement": number("minimum", "Rate of vorticity confinement [1/s]; default 0, none"),
            "inflow_rate": number(
                "minimum",
                "Particles [1/s] that leave the body's shape, which is then a source of smoke; default 0, all at once"
            ),
            "inflow_velocity": vector("Velocity of the gas in the source [m/s]; without it, it moves freely"),
            "still": number(
                "minimum",
                "Blocks of 8 cells whose gas moves less than this part of the largest speed beside the air around, and \
                 without smoke or solids, are not computed: a box follows the others; default 0, the whole domain is"
            ),
            "courant": number("exclusiveMinimum", "Courant number; default 0.7"),
            "max_substep_s": number("exclusiveMinimum", "Longest substep [s]"),
            "divergence": number(
                "exclusiveMinimum",
                "Largest divergence left in a cell, times its edge, over the largest speed; default 1e-4"
            ),
            "max_iterations": number("exclusiveMinimum", "Most iterations of a projection; default 100")
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
        let positive = |key: &str, default: f64| number(key, default, f64::MIN_POSITIVE);
        let (low, high) = (vector(scene, "low")?, vector(scene, "high")?);
        let domain = match (low, high) {
            (Some(low), Some(high)) if (0..3).all(|k| low[k] < high[k]) => Some([low, high]),
            (None, None) => None,
            _ => {
                return wrong(
                    "parameters `low` and `high` are two corners of a domain, given together, `low` below `high`",
                );
            }
        };
        let cell = scene.params.contains_key("cell").then(|| positive("cell", 1.0)).transpose()?;
        let ambient = positive("ambient_temperature", 293.15)?;
        Ok(Self {
            positions: positions(scene)?,
            sweeps: number("density_iterations", 8.0, 1.0)? as u64,
            drag: number("surface_drag", 5.0, 0.0)?,
            domain,
            cell,
            open: open(scene)?,
            air: positive("air_density", AIR)?,
            ambient,
            temperature: positive("temperature", ambient)?,
            viscosity: number("kinematic_viscosity", AIR_VISCOSITY, 0.0)?,
            confinement: number("vorticity_confinement", 0.0, 0.0)?,
            rate: number("inflow_rate", 0.0, 0.0)?,
            jet: vector(scene, "inflow_velocity")?,
            still: number("still", 0.0, 0.0)?,
            courant: positive("courant", 0.7)?,
            most: positive("max_substep_s", f64::MAX)?,
            divergence: positive("divergence", 1e-4)?,
            iterations: number("max_iterations", 100.0, 1.0)? as u64,
        })
    }
}

fn positions(scene: &SolverScene) -> Result<bool, PluginError> {
    let Some(value) = scene.params.get("method") else { return Ok(false) };
    match value.as_str() {
        Some("grid") => Ok(false),
        Some("positions") => Ok(true),
        _ => wrong(&format!("parameter `method` is {value}; there are `grid` and `positions`")),
    }
}

fn wrong<T>(what: &str) -> Result<T, PluginError> {
    Err(PluginError::Unsupported(what.to_owned()))
}

fn vector(scene: &SolverScene, key: &str) -> Result<Option<Vec3>, PluginError> {
    let Some(value) = scene.params.get(key) else { return Ok(None) };
    let numbers: Option<Vec<f64>> = value.as_array().and_then(|all| all.iter().map(Value::as_f64).collect());
    match numbers.as_deref() {
        Some(&[x, y, z]) if [x, y, z].iter().all(|v| v.is_finite()) => Ok(Some([x, y, z])),
        _ => wrong(&format!("parameter `{key}` is `{value}`, which is not three numbers")),
    }
}

fn open(scene: &SolverScene) -> Result<[[bool; 2]; 3], PluginError> {
    let Some(value) = scene.params.get("open") else { return Ok([[true; 2]; 3]) };
    let mut open = [[false; 2]; 3];
    let Some(all) = value.as_array() else { return wrong("parameter `open` is not a list of sides") };
    for side in all {
        let found = (0..6).find(|i| side.as_str() == Some(SIDES[i / 2][i % 2]));
        match found {
            Some(i) => open[i / 2][i % 2] = true,
            None => return wrong(&format!("parameter `open` names {side}; there are -x, +x, -y, +y, -z and +z")),
        }
    }
    Ok(open)
}
