//! What a plugin is given before the first window, and what it answers.

use std::collections::BTreeMap;
use std::sync::Arc;

use serde::{Deserialize, Serialize};

use super::PluginError;
use super::exchange::Report;
use crate::asset::Asset;
use crate::boundary::{BoundaryState, SampleStatics};
use crate::plan::{BoundaryForm, InterfaceId, LeftOut};
use crate::scene::{Action, Body, Joint, Link, MotionRule, PairSpec, Pose, Probe, Source, Space, StaticCollider};
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
    /// Prepared geometry, by the name of the body, static collider or rigid partner it belongs to. It travels beside the
    /// scene, not in it.
    #[serde(skip)]
    pub assets: BTreeMap<String, Arc<Asset>>,
}

impl SolverScene {
    /// Whether a body has an interface, so that its boundary must be shown.
    pub fn is_coupled(&self, body: &str) -> bool {
        self.interfaces.iter().any(|i| i.own == body)
    }

    /// A parameter that is a number.
    ///
    /// # Errors
    /// [`PluginError::Unsupported`] where the scene sets it to something else.
    pub fn number(&self, param: &str, default: f64) -> Result<f64, PluginError> {
        let Some(value) = self.params.get(param) else { return Ok(default) };
        let found = value.as_f64().filter(|v| v.is_finite());
        found.ok_or_else(|| PluginError::Unsupported(format!("parameter `{param}` is `{value}`, which is no number")))
    }

    /// The static colliders of a scene, as left out by a plugin that has none.
    pub fn left_out_statics(&self, plugin: &str) -> Vec<LeftOut> {
        let one = |wall: &StaticCollider| LeftOut {
            what: format!("static collider `{}`", wall.name),
            why: format!("plugin `{plugin}` takes no static colliders"),
            indicator: None,
            limit: None,
            saved: "not measured".to_owned(),
        };
        self.statics.iter().map(one).collect()
    }
}

/// An interface of a body that receives impulses, by the place of the body.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct OwnView {
    /// Interface.
    pub id: InterfaceId,
    /// Place of the own body in the solver's scene.
    pub own: usize,
    /// Body on the other side.
    pub partner: String,
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
    /// Shape of a partner that fills it at t = 0. A rigid one keeps it: its record gives the place and orientation of this
    /// shape's centre of mass. Of others only meshes are handed out as assets, not clouds of particles.
    pub partner_source: Option<Source>,
    /// Pose of the partner's own frame at t = 0.
    pub partner_pose: Option<Pose>,
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

#[cfg(test)]
mod tests {
    use super::super::fixtures::scene;
    use super::*;
    use crate::scene::{Pose, Source, Wall};

    #[test]
    fn a_body_is_coupled_when_an_interface_names_it() {
        let scene = scene();
        assert!(scene.is_coupled("cloud") && !scene.is_coupled("mud"));
    }

    #[test]
    fn a_number_is_the_scene_s_or_the_default_s() {
        let mut scene = scene();
        let bits = |found: Result<f64, PluginError>| found.map(f64::to_bits);
        assert_eq!(bits(scene.number("drag", 1.5)), Ok(1.5_f64.to_bits()));
        scene.params.insert("drag".into(), 2.into());
        assert_eq!(bits(scene.number("drag", 1.5)), Ok(2.0_f64.to_bits()));
        scene.params.insert("drag".into(), "much".into());
        let why = scene.number("drag", 1.5).unwrap_err().to_string();
        assert_eq!(why, "parameter `drag` is `\"much\"`, which is no number");
    }

    #[test]
    fn every_static_collider_is_left_out_by_name() {
        let mut scene = scene();
        assert!(scene.left_out_statics("tester").is_empty());
        scene.statics = ["floor", "wall"]
            .map(|name| StaticCollider {
                name: name.into(),
                source: Source::Plane { size_m: None },
                pose: Pose { position_m: [0.0; 3], orientation: [0.0, 0.0, 0.0, 1.0] },
                wall: Wall::Slip,
                motion: None,
                color: None,
            })
            .into();
        let left_out = scene.left_out_statics("tester");
        let what: Vec<&str> = left_out.iter().map(|l| l.what.as_str()).collect();
        assert_eq!(what, ["static collider `floor`", "static collider `wall`"]);
        assert!(left_out.iter().all(|l| l.why == "plugin `tester` takes no static colliders"));
    }
}
