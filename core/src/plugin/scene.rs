//! What a plugin is given before the first window, and what it answers.

use serde::{Deserialize, Serialize};

use super::exchange::Report;
use crate::boundary::{BoundaryState, SampleStatics};
use crate::plan::{BoundaryForm, InterfaceId, LeftOut};
use crate::scene::{Action, Body, Joint, Link, MotionRule, PairSpec, Probe, Space, StaticCollider};
use crate::time::{Clock, Span};

/// A participant's part of the scene. Links and joints here have both ends in this solver or the world.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SolverScene {
    /// Name of the participant.
    pub participant: String,
    /// Threads it may use; must never change a result.
    pub threads: usize,
    /// Clock of the run.
    pub clock: Clock,
    /// Dimensions that move.
    pub space: Space,
    /// Own bodies.
    pub bodies: Vec<Body>,
    /// Colliders that take no impulses.
    pub statics: Vec<StaticCollider>,
    /// Links inside this solver or to the world.
    pub links: Vec<Link>,
    /// Joints inside this solver or to the world.
    pub joints: Vec<Joint>,
    /// Outside influences on own bodies.
    pub actions: Vec<Action>,
    /// Contact parameters among own bodies and statics.
    pub pairs: Vec<PairSpec>,
    /// Probes this solver answers.
    pub probes: Vec<Probe>,
    /// Interfaces to other solvers.
    pub interfaces: Vec<InterfaceView>,
    /// Plugin parameters.
    pub params: serde_json::Map<String, serde_json::Value>,
}

/// An interface as seen from one side.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct InterfaceView {
    /// Identity in the plan.
    pub id: InterfaceId,
    /// Part this side plays.
    pub role: ViewRole,
    /// Own body.
    pub own: String,
    /// Partner's body.
    pub partner: String,
    /// Form of the partner's boundary.
    pub partner_form: BoundaryForm,
    /// How the partner moves inside a step.
    pub rule: MotionRule,
    /// Contact parameters, for contacts.
    pub pair: Option<PairSpec>,
    /// Potentials, for links.
    pub links: Vec<Link>,
}

/// Part played at an interface.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum ViewRole {
    /// Computes contact; gives impulses.
    ContactResolver,
    /// Takes contact impulses.
    ContactResponder,
    /// One of two equal sides of a link.
    LinkSide,
    /// Computes a link with the partner held; gives impulses.
    LinkResolver,
    /// Takes a link's impulses.
    LinkResponder,
}

impl ViewRole {
    /// Whether this side gives impulses to the other.
    pub fn gives_impulses(self) -> bool {
        matches!(self, Self::ContactResolver | Self::LinkResolver)
    }

    /// Whether this side is given impulses by the other.
    pub fn takes_impulses(self) -> bool {
        matches!(self, Self::ContactResponder | Self::LinkResponder)
    }
}

/// What never changes about a partner, and where it starts.
#[derive(Clone, Debug, PartialEq)]
pub struct PartnerSetup {
    /// Interface.
    pub interface: InterfaceId,
    /// Constants of its samples; empty for proxies.
    pub statics: SampleStatics,
}

/// A plugin's answer to its scene.
#[derive(Clone, Debug, PartialEq)]
pub struct Setup {
    /// One per own body that has an interface, in scene order.
    pub boundaries: Vec<SetupBoundary>,
    /// State at t = 0.
    pub report: Report,
    /// Largest stable substep \[s\] and the term that binds it, if there is a limit.
    pub stable_dt: Option<(f64, String)>,
    /// Particles of each own body, in scene order.
    pub particles: Vec<u64>,
    /// What this solver leaves out in this scene.
    pub left_out: Vec<LeftOut>,
}

/// Boundary of one body at t = 0.
#[derive(Clone, Debug, PartialEq)]
pub struct SetupBoundary {
    /// Body.
    pub body: String,
    /// Constants of its samples; empty for proxies.
    pub statics: SampleStatics,
    /// State at t = 0.
    pub state: BoundaryState,
}

/// A stretch of time to cover.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Step {
    /// Window it lies in.
    pub window: u64,
    /// Ticks.
    pub span: Span,
    /// Start \[s\].
    pub start_s: f64,
    /// Length \[s\].
    pub length_s: f64,
}

impl Step {
    /// The step over `span` of `window`.
    pub fn new(clock: &Clock, window: u64, span: Span) -> Self {
        Self { window, span, start_s: clock.seconds(span.from), length_s: clock.seconds(span.ticks()) }
    }
}
