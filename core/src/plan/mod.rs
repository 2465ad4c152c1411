//! The plan of a run: who runs, who exchanges what with whom, and when.
//!
//! A plan is made once from a scene and the descriptors of its plugins (`build`), is the same for everybody, and
//! never changes during the run. What each participant does in each window follows from it (`schedule`).

mod build;
mod features;
mod interfaces;
pub mod schedule;
mod streams;
mod turns;
pub mod window;

use serde::{Deserialize, Serialize};

use crate::scene::{Break, MotionRule, Scheme};
use crate::time::Clock;
use crate::visual::VisualForm;

pub use build::{RECORDER, Refusal, build, plugin_of};
pub(crate) use features::REGIONS;
pub use features::{is_body_probe, source_kind};

/// Index into [`Plan::participants`].
pub type ParticipantId = u16;
/// Index into [`Plan::interfaces`].
pub type InterfaceId = u16;
/// Index into [`Plan::streams`].
pub type StreamId = u16;

/// Who runs, what couples, on which clock.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Plan {
    /// Windows and their length.
    pub clock: Clock,
    /// The term that bounds the window, in words.
    pub window_bound_by: String,
    /// Solver processes in name order, then the recorder, if there is one.
    pub participants: Vec<Participant>,
    /// Pairs of bodies in different solvers that touch or are joined.
    pub interfaces: Vec<Interface>,
    /// Every stream of the data plane.
    pub streams: Vec<Stream>,
    /// What the scene could have needed and does not, and why.
    pub left_out: Vec<LeftOut>,
    /// Who draws and writes frames, if anybody does, and how often.
    pub recorder: Option<Recorder>,
    /// Deliberate fault, for negative controls.
    pub break_with: Option<Break>,
}

/// The participant that draws and writes frames. It owns no body and has no part in the state's hash.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Recorder {
    /// Its place.
    pub participant: ParticipantId,
    /// Windows from one frame to the next.
    pub windows_per_frame: u64,
}

/// One solver process.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Participant {
    /// Name on the bus.
    pub name: String,
    /// Plugin it runs.
    pub plugin: String,
    /// Bodies it owns, in scene order.
    pub bodies: Vec<String>,
    /// Threads it may use.
    pub threads: usize,
}

/// One side of an interface.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub struct Side {
    /// Solver that owns the body.
    pub participant: ParticipantId,
    /// Body.
    pub body: String,
}

/// Two bodies in different solvers that may touch or are joined.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Interface {
    /// `a~b`.
    pub name: String,
    /// Contact or link.
    pub kind: InterfaceKind,
    /// How the sides take turns.
    pub scheme: Scheme,
    /// How the partner moves inside a window.
    pub rule: MotionRule,
    /// Impulses are taken at once at the start of the window, not spread over it: so a resolver that stops what it
    /// meets never makes energy, however fast that vibrates inside a window.
    #[serde(default)]
    pub at_once: bool,
    /// Contact and centred link: the resolver. Other links: the side that goes first (in even windows).
    pub a: Side,
    /// Contact and centred link: the responder. Other links: the other side.
    pub b: Side,
    /// Stream on which `a` shows its boundary to `b`, if `b` reads it.
    pub from_a: Option<StreamId>,
    /// Stream on which `b` shows its boundary to `a`.
    pub from_b: StreamId,
    /// Stream of impulses from `a` on `b`, if impulses cross.
    pub impulses: Option<StreamId>,
    /// Indices into the scene's links, for link interfaces.
    pub links: Vec<usize>,
}

impl Interface {
    /// True when impulses cross, so that momentum is exact by construction.
    pub fn carries_impulses(&self) -> bool {
        self.impulses.is_some()
    }
}

/// Contact or link.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum InterfaceKind {
    /// A resolver computes the force, a responder receives impulses.
    Contact,
    /// A potential of two positions; no resolver unless the scheme is centred.
    Link,
}

/// One sender, some receivers, one message per window (or one in all, for statics).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Stream {
    /// Key below the run's prefix: `b/<from>/<body>`, `imp/<from>/<to>/<interface>` …
    pub key: String,
    /// Sender.
    pub from: ParticipantId,
    /// Receivers.
    pub to: Vec<ParticipantId>,
    /// What its messages hold.
    pub content: Content,
}

/// What the messages of a stream hold.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Content {
    /// What never changes about a body's samples: one message, index 0.
    Statics {
        /// Body described.
        body: String,
    },
    /// Boundary of a body. Message n is the state at the start of window n.
    Boundary {
        /// Body shown.
        body: String,
        /// Form and number types.
        form: BoundaryForm,
    },
    /// Boundary of a body in the middle of window n (centred scheme).
    MidBoundary {
        /// Body shown.
        body: String,
        /// Form and number types.
        form: BoundaryForm,
    },
    /// Impulses of window n on the responder of an interface.
    Impulses {
        /// Interface.
        interface: InterfaceId,
        /// Form of the responder's boundary.
        form: BoundaryForm,
    },
    /// What pictures show of a body. Message n is the state at the start of window n; there is one where a frame is.
    Visual {
        /// Body shown.
        body: String,
        /// Form.
        form: VisualForm,
    },
}

/// Form in which a body shows its boundary.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum BoundaryForm {
    /// Samples with single-precision numbers relative to a double-precision origin.
    SamplesF32 {
        /// Whether normals are sent.
        normals: bool,
    },
    /// Samples with double-precision numbers.
    SamplesF64 {
        /// Whether normals are sent.
        normals: bool,
    },
    /// Proxy record of a rigid body.
    Proxy,
}

/// A thing not started, computed, sent or written.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct LeftOut {
    /// What.
    pub what: String,
    /// Why, in words.
    pub why: String,
    /// Value on which the decision rests.
    pub indicator: Option<f64>,
    /// Limit it was compared with.
    pub limit: Option<f64>,
    /// What was saved, or `not measured`.
    pub saved: String,
}

impl Plan {
    /// Participant of that name.
    pub fn participant(&self, name: &str) -> Option<ParticipantId> {
        self.participants.iter().position(|p| p.name == name).map(|i| i as ParticipantId)
    }

    /// Name of a participant.
    pub fn name_of(&self, id: ParticipantId) -> &str {
        self.participants.get(usize::from(id)).map_or("?", |p| p.name.as_str())
    }

    /// Whether a frame shows the state at the start of window `edge`.
    pub fn has_frame_at(&self, edge: u64) -> bool {
        self.recorder.is_some_and(|r| edge.is_multiple_of(r.windows_per_frame))
    }

    /// Number of participants that simulate: they come first.
    pub fn solver_count(&self) -> usize {
        self.participants.len() - usize::from(self.recorder.is_some())
    }

    /// Whether `b` of an interface is shown as one rigid body.
    pub fn shows_rigid(&self, interface: &Interface) -> bool {
        let shown = self.streams.get(usize::from(interface.from_b)).map(|s| &s.content);
        matches!(shown, Some(Content::Boundary { form: BoundaryForm::Proxy, .. }))
    }

    /// Participants that simulate, in order.
    pub fn solvers(&self) -> &[Participant] {
        &self.participants[..self.solver_count()]
    }

    /// Whether a participant simulates, as against one that only records.
    pub fn is_solver(&self, id: ParticipantId) -> bool {
        self.recorder.is_none_or(|r| r.participant != id)
    }

    /// Streams sent by a participant.
    pub fn sent_by(&self, id: ParticipantId) -> impl Iterator<Item = (StreamId, &Stream)> {
        self.streams.iter().enumerate().filter(move |(_, s)| s.from == id).map(|(i, s)| (i as StreamId, s))
    }

    /// Streams read by a participant.
    pub fn read_by(&self, id: ParticipantId) -> impl Iterator<Item = (StreamId, &Stream)> {
        self.streams.iter().enumerate().filter(move |(_, s)| s.to.contains(&id)).map(|(i, s)| (i as StreamId, s))
    }
}
