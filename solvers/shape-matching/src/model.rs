//! What a scene is to this solver, and what changes in a run.

use cosplat_core::distance::Placed;
use cosplat_core::plan::InterfaceId;
use cosplat_core::time::Clock;

use crate::V3;
use crate::body::{Body, Moving};

/// A scene, read.
#[derive(Clone, Debug)]
pub(crate) struct Model {
    pub(crate) clock: Clock,
    pub(crate) bodies: Vec<Body>,
    /// Static colliders, and their surface for each body.
    pub(crate) walls: Vec<(Placed, Vec<Option<Surface>>)>,
    /// Surfaces of each two bodies, row by row.
    pub(crate) pairs: Vec<Option<Surface>>,
    pub(crate) views: Vec<View>,
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

/// An interface with a solver that computes the contact.
#[derive(Clone, Debug)]
pub(crate) struct View {
    pub(crate) id: InterfaceId,
    pub(crate) own: usize,
    pub(crate) partner: String,
}

/// An outside influence in a range of time.
#[derive(Clone, Debug)]
pub(crate) struct Influence {
    pub(crate) kind: InfluenceKind,
    pub(crate) bodies: Vec<usize>,
    /// \[s\].
    pub(crate) from: f64,
    /// \[s\].
    pub(crate) until: f64,
}

/// What an influence does.
#[derive(Clone, Copy, Debug)]
pub(crate) enum InfluenceKind {
    /// \[m/s²\], with the potential energy `-m g·x`.
    Gravity(V3),
    /// \[m/s²\].
    Acceleration(V3),
    /// \[N\] at the centre of mass.
    Force(V3),
    /// \[N s\] at `from`, at a point of the world or the centre of mass.
    Kick(V3, Option<V3>),
}

impl Influence {
    /// Constant force on a body of that mass \[N\].
    pub(crate) fn force(&self, mass: f64) -> V3 {
        match self.kind {
            InfluenceKind::Gravity(g) | InfluenceKind::Acceleration(g) => g * mass,
            InfluenceKind::Force(f) => f,
            InfluenceKind::Kick(..) => V3::zeros(),
        }
    }

    /// Whether it acts at `t` \[s\].
    pub(crate) fn acts_at(&self, t: f64) -> bool {
        t >= self.from && t < self.until
    }
}
