//! What the participant's state machine is told and what it asks for.

use std::sync::Arc;
use std::time::Duration;

use crate::checkpoint::{CheckpointError, Snapshot};
use crate::control::{RunId, Times};
use crate::plan::{ParticipantId, StreamId};
use crate::plugin::{
    Descriptor, Inputs, Outputs, PartnerSetup, Plugin, PluginError, Setup, SolverScene, StateHasher, Step,
};
use crate::visual::{VisualFrame, VisualState};

/// Bytes of one data frame: header and one chunk of payload. Cheap to clone; kept for resending.
pub type Frame = Arc<Vec<u8>>;

/// Who a participant is.
#[derive(Clone, Debug)]
pub struct Identity {
    /// Run it belongs to.
    pub run: RunId,
    /// Incarnation of the coordinator it was started for: others are not listened to.
    pub epoch: u32,
    /// Name it was started under.
    pub name: String,
    /// Random number of this process.
    pub instance: u64,
    /// Process id, for people.
    pub pid: u32,
    /// What the plugin says about itself.
    pub descriptor: Descriptor,
}

/// Intervals after which a participant says something again \[s\]. They decide when, never what.
#[derive(Clone, Copy, Debug)]
pub struct Pace {
    /// Between repetitions of a message that has not been answered.
    pub repeat: Duration,
    /// Between heartbeats.
    pub heartbeat: Duration,
    /// Without any word from the coordinator it gives up.
    pub orphaned: Duration,
}

impl Default for Pace {
    fn default() -> Self {
        Self {
            repeat: Duration::from_millis(100),
            heartbeat: Duration::from_millis(500),
            orphaned: Duration::from_secs(30),
        }
    }
}

/// What happened. The host passes bytes on as they come; checking them is the machine's business.
#[derive(Debug)]
pub enum Event {
    /// Bytes on `ctl/<own name>`.
    Control(Vec<u8>),
    /// Bytes on a stream that this participant reads.
    Data(Frame),
    /// Bytes on `resend/<own name>`.
    Resend(Vec<u8>),
    /// The plugin has answered `setup`.
    SetUp(Result<Answer<Setup>, PluginError>),
    /// The plugin has answered `connect`.
    Connected(Result<(), PluginError>),
    /// The answer to [`Action::Load`].
    Loaded(Result<Box<Snapshot>, CheckpointError>),
    /// The plugin has answered `restore`, with the hash of all that `save` writes after it.
    Restored(Result<u128, PluginError>),
    /// The snapshot of the start of a window is stored for good, or why it could not be.
    Saved(u64, Result<(), String>),
    /// The plugin has answered `advance`, with the time inside it.
    Computed(Result<Answer<Outputs>, PluginError>, Times),
    /// The plugin has finished `done` of `of` substeps of the step at hand.
    Beat {
        /// Finished.
        done: u64,
        /// In all.
        of: u64,
    },
    /// Time has passed.
    Tick,
}

/// What to do, in order.
#[derive(Debug)]
pub enum Action {
    /// Declare publishers and subscribers of all streams of the plan; comes once, before any `Publish`.
    Declare,
    /// Put these bytes on `ack/<own name>`.
    Control(Vec<u8>),
    /// Put this frame on a stream.
    Publish(StreamId, Frame),
    /// Put these bytes on `resend/<participant>`.
    Request(ParticipantId, Vec<u8>),
    /// Call `setup` and show these bodies, answer with [`Event::SetUp`].
    SetUp(Box<SolverScene>, Vec<String>),
    /// Call `connect`, answer with [`Event::Connected`].
    Connect(Vec<PartnerSetup>),
    /// Read the snapshot of the start of this window, answer with [`Event::Loaded`]. Those of later windows belong to a
    /// life that is over and are removed.
    Load(u64),
    /// Call `restore` with this state, then `save` into a [`StateHasher`]; answer with [`Event::Restored`].
    Restore(Vec<u8>),
    /// Call `save` at once, by [`Snapshot::of`]; store the bytes and answer with [`Event::Saved`] when they cannot be lost
    /// any more, which may be later. The snapshot of the window that is named beside it must be kept as well, others may
    /// go. A recorder answers when all frames it was given are written.
    Save(Box<Snapshot>, Option<u64>),
    /// Call `record` for each frame, then `advance`; answer with [`Event::Computed`].
    Compute(Box<Job>),
    /// Leave.
    Exit(Ending),
}

/// A step to compute.
#[derive(Debug)]
pub struct Job {
    /// Time to cover.
    pub step: Step,
    /// What acts on it.
    pub inputs: Inputs,
    /// Whether the state must be hashed after it: only the last step of a window.
    pub hash_state: bool,
    /// Frames to draw before it: for recorders only.
    pub frames: Vec<VisualFrame>,
    /// Bodies to show after it: where a frame is.
    pub show: Vec<String>,
}

impl<T> Answer<T> {
    /// What `plugin` gave, with what is to be known of it right after.
    pub fn of(plugin: &dyn Plugin, value: T, hash_state: bool, show: &[String]) -> Self {
        let mut hasher = StateHasher::default();
        if hash_state {
            plugin.save(&mut hasher);
        }
        // A body that is not shown is missed where it is to be sent, by name.
        let visuals = show.iter().filter_map(|body| Some((body.clone(), plugin.visual(body)?))).collect();
        Self { value, state_hash: if hash_state { hasher.finish() } else { 0 }, visuals }
    }
}

/// What a plugin gave, and its state after it.
#[derive(Clone, Debug, PartialEq)]
pub struct Answer<T> {
    /// What it gave.
    pub value: T,
    /// Hash of all that `save` writes; 0 where none was asked for.
    pub state_hash: u128,
    /// The bodies that were to be shown.
    pub visuals: Vec<(String, VisualState)>,
}

/// How a participant's part ended.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Ending {
    /// All windows are settled.
    Finished,
    /// The coordinator ended the run.
    Aborted(String),
    /// The coordinator would not have it.
    Refused(String),
    /// Its own plugin could not go on; the coordinator has been told.
    Failed(String),
    /// No word from the coordinator for too long.
    Orphaned,
}
