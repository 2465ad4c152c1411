//! What a scene is to this solver, and what changes in a run.

use cosplat_core::distance::Placed;
use cosplat_core::plugin::{Influence, Moving, OwnView};
use cosplat_core::time::Clock;

use crate::body::Body;

/// A scene, read.
#[derive(Clone, Debug)]
pub(crate) struct Model {
    pub(crate) clock: Clock,
    pub(crate) bodies: Vec<Body>,
    /// Static colliders, and their surface for each body.
    pub(crate) walls: Vec<(Placed, Vec<Option<Surface>>)>,
    /// Surfaces of each two bodies, row by row.
    pub(crate) pairs: Vec<Option<Surface>>,
    pub(crate) views: Vec<OwnView>,
    pub(crate) influences: Vec<Influence>,
    /// Longest substep \[s\].
    pub(crate) longest: f64,
    /// Turns in which contact is solved.
    pub(crate) turns: u32,
}

/// All that changes in a run.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct State {
    pub(crate) bodies: Vec<Moving>,
    /// Energy lost in contact, and gained or lost by the error of the substeps \[J\].
    pub(crate) dissipated: f64,
}

/// Static and kinetic friction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Surface(pub(crate) f64, pub(crate) f64);
