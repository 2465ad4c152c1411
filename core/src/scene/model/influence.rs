//! What acts from outside, and what is measured.

use serde::{Deserialize, Serialize};

use super::Vec3;

/// `[[action]]`: an outside influence in a time range.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Action {
    /// What it does.
    pub kind: ActionKind,
    /// Bodies it acts on; empty means all.
    pub bodies: Vec<String>,
    /// First moment \[s\].
    pub from_s: f64,
    /// Last moment \[s\]; infinity is written as `None`.
    pub until_s: Option<f64>,
}

impl Action {
    /// Whether it acts at all times. Gravity that does has a potential energy; one that begins or ends does work.
    pub fn always(&self) -> bool {
        self.from_s <= 0.0 && self.until_s.is_none()
    }
}

/// What an action does.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum ActionKind {
    /// Uniform acceleration.
    Gravity {
        /// \[m/s²\].
        acceleration_m_s2: Vec3,
    },
    /// Moving air: bodies feel drag relative to it.
    Wind {
        /// Air velocity \[m/s\].
        velocity_m_s: Vec3,
        /// Density of the air \[kg/m³\].
        air_density_kg_m3: f64,
        /// Drag coefficient.
        drag_coefficient: f64,
    },
    /// The seeds' force fields: accelerations that do not depend on mass.
    AccelerationField {
        /// Shape of the field.
        field: Field,
    },
    /// A force at a point of the body \[N\].
    PointForce {
        /// \[N\], world axes.
        force_n: Vec3,
        /// Point in the world at `from_s` \[m\]; `None` is the centre of mass.
        at_m: Option<Vec3>,
    },
    /// A sudden impulse at `from_s` \[N s\].
    Impulse {
        /// \[N s\], world axes.
        impulse_n_s: Vec3,
        /// Point in the world \[m\]; `None` is the centre of mass.
        at_m: Option<Vec3>,
    },
    /// Everything turns round at `from_s`: each velocity and spin becomes its opposite.
    Reverse,
    /// A liquid enters through an opening.
    Inflow {
        /// Middle of the opening \[m\].
        center_m: Vec3,
        /// Velocity with which it enters, square to the opening \[m/s\].
        velocity_m_s: Vec3,
        /// The opening.
        opening: Opening,
    },
    /// A liquid that enters a box leaves the scene.
    Drain {
        /// Middle of the box \[m\].
        center_m: Vec3,
        /// Sides of the box, along the axes \[m\].
        size_m: Vec3,
    },
}

/// Opening of an inflow.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Opening {
    /// A disc of that radius \[m\].
    Disc {
        /// \[m\].
        radius_m: f64,
    },
    /// A rectangle.
    Rectangle {
        /// Sides \[m\]; the first is level, or along x where the liquid enters straight up or down.
        size_m: [f64; 2],
    },
}

impl ActionKind {
    /// Kind, as scenes and descriptors write it.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Gravity { .. } => "gravity",
            Self::Wind { .. } => "wind",
            Self::AccelerationField { .. } => "acceleration-field",
            Self::PointForce { .. } => "point-force",
            Self::Impulse { .. } => "impulse",
            Self::Reverse => "reverse",
            Self::Inflow { .. } => "inflow",
            Self::Drain { .. } => "drain",
        }
    }
}

/// Shape of an acceleration field.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Field {
    /// The same everywhere.
    Constant {
        /// \[m/s²\].
        acceleration_m_s2: Vec3,
    },
    /// Inside an infinite cylinder.
    Cylinder {
        /// \[m/s²\], along the axis.
        strength_m_s2: f64,
        /// Unit axis.
        direction: Vec3,
        /// Point on the axis \[m\].
        center_m: Vec3,
        /// \[m\].
        radius_m: f64,
    },
    /// Towards (positive) or away from (negative) a point, `strength / (1 + r/1 m)^falloff`.
    Point {
        /// \[m/s²\].
        strength_m_s2: f64,
        /// \[m\].
        center_m: Vec3,
        /// Power of the falloff.
        falloff: f64,
    },
}

/// `[[probe]]`: a quantity written each window to `probes.csv`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Probe {
    /// Unique column name.
    pub name: String,
    /// What is measured.
    pub quantity: ProbeQuantity,
    /// Body measured; `None` for quantities at a point.
    pub body: Option<String>,
    /// Point of measurement \[m\], for quantities at a point.
    pub at_m: Option<Vec3>,
    /// Unit vector along which is measured, for quantities with a direction.
    #[serde(default)]
    pub along: Option<Vec3>,
}

/// What a probe measures.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum ProbeQuantity {
    /// Centre of mass \[m\].
    Position,
    /// Orientation quaternion.
    Orientation,
    /// Velocity of the centre of mass \[m/s\].
    Velocity,
    /// Linear momentum \[kg m/s\].
    Momentum,
    /// Pressure at a point \[Pa\].
    Pressure,
    /// Mean force in a window that bodies of other processes exert on a body, by contact and links \[N\].
    Force,
    /// Share of space taken at a point.
    VolumeFraction,
    /// Largest magnitude of a principal logarithmic strain, elastic where it yields, of all particles of a body.
    Strain,
    /// How far a body reaches along a direction: the largest coordinate of its particles \[m\].
    Reach,
}
