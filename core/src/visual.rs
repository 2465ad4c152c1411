//! What a solver shows of a body for pictures and files: enough to draw it, nothing that another solver computes with.

use serde::{Deserialize, Serialize};

use crate::boundary::Vec3;

/// How a body is shown.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum VisualForm {
    /// Pose of the body's frame: rigid bodies.
    Pose,
    /// Its particles, in the order of its asset (or as the solver made them).
    Particles {
        /// Whether each comes with its total deformation gradient, for Gaussians that ride on it.
        gradients: bool,
    },
}

/// A body at one moment.
#[derive(Clone, Debug, PartialEq)]
pub enum VisualState {
    /// Pose of the body's frame in the world: at t = 0 the pose that the scene gives.
    Pose {
        /// Position of the frame's origin \[m\].
        position: Vec3,
        /// Unit quaternion `[x, y, z, w]`.
        orientation: [f64; 4],
    },
    /// Particles.
    Particles {
        /// Positions \[m\], world frame.
        position: Vec<Vec3>,
        /// Total deformation gradient of each since t = 0, rows one after the other; empty where none was asked for.
        gradient: Vec<[f32; 9]>,
    },
}

/// All drawn bodies at one moment.
#[derive(Clone, Debug, PartialEq)]
pub struct VisualFrame {
    /// Number of the frame: 0 at the start.
    pub number: u64,
    /// Moment \[s\].
    pub time_s: f64,
    /// Bodies by name, in the order of the plan's streams.
    pub bodies: Vec<(String, VisualState)>,
}

impl VisualState {
    /// Whether it is of a form.
    pub fn has_form(&self, form: VisualForm) -> bool {
        match (self, form) {
            (Self::Pose { .. }, VisualForm::Pose) => true,
            (Self::Particles { position, gradient }, VisualForm::Particles { gradients }) => {
                gradient.len() == if gradients { position.len() } else { 0 }
            }
            _ => false,
        }
    }
}
