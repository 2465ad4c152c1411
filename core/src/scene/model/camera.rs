//! Where pictures are taken from.

use serde::{Deserialize, Serialize};

use super::body::Vec3;

/// `[output.camera]`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct CameraSpec {
    /// Where it stands at first \[m\].
    pub eye_m: Vec3,
    /// Where it looks at first \[m\].
    pub target_m: Vec3,
    /// Upwards in the picture.
    pub up: Vec3,
    /// Vertical field of view \[°\].
    pub field_of_view_deg: f64,
    /// Width and height of a picture \[px\].
    pub size_px: [u32; 2],
    /// What shows where nothing is, linear RGB in 0..=1.
    pub background: [f64; 3],
    /// How it moves.
    pub travel: CameraTravel,
}

/// How a camera moves during a run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum CameraTravel {
    /// Not at all.
    Still,
    /// Around its target, about `up`, at a constant rate from the start to the end of the run.
    Orbit {
        /// Angle \[°\]; positive is counter-clockwise seen from above.
        degrees: f64,
    },
    /// Along a smooth curve through stops; it waits at the first and stays at the last.
    Path {
        /// At least two, each later than the one before.
        stops: Vec<CameraStop>,
    },
}

/// A place that a camera passes.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct CameraStop {
    /// Simulated time \[s\].
    pub time_s: f64,
    /// Where it stands \[m\].
    pub eye_m: Vec3,
    /// Where it looks \[m\].
    pub target_m: Vec3,
}
