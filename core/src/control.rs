//! Control messages: small, rare, idempotent. Postcard behind a version, with a checksum behind it.

use serde::{Deserialize, Serialize};
use xxhash_rust::xxh3::xxh3_64;

use crate::plan::{InterfaceId, LeftOut, ParticipantId, StreamId};
use crate::plugin::Report;

/// Version of the whole protocol, control and data.
pub const PROTOCOL: u16 = 4;

/// First incarnation of a run's coordinator; each one that resumes the run counts up.
pub const FIRST_EPOCH: u32 = 1;

/// Bytes of prepared geometry in one message.
pub const ASSET_CHUNK_BYTES: u64 = 256 * 1024;

/// Identity of a run: 16 random bytes. What carries another is from somewhere else and is ignored.
pub type RunId = [u8; 16];

/// A message with its addressing.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Envelope<M> {
    /// [`PROTOCOL`] of the sender.
    pub protocol: u16,
    /// Run.
    pub run: RunId,
    /// Incarnation of the coordinator.
    pub epoch: u32,
    /// Incarnation of the participant's process: the sender's, or the one addressed. 0 where it is not known.
    pub instance: u64,
    /// Content.
    pub body: M,
}

/// From a participant.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Up {
    /// Here I am. Repeated until answered.
    Hello {
        /// Name it was started under.
        name: String,
        /// Process id, for people.
        pid: u32,
        /// Lowest and highest protocol version it speaks.
        protocol: [u16; 2],
        /// Descriptor as JSON.
        descriptor: String,
    },
    /// Send me this chunk of prepared geometry.
    Fetch {
        /// Number in the welcome's list.
        asset: u16,
        /// Number of the chunk.
        chunk: u32,
    },
    /// Set up; streams are declared.
    Ready(Box<ReadyInfo>),
    /// Probes have arrived on these streams, and every partner's statics.
    Probed {
        /// Streams heard.
        streams: Vec<StreamId>,
        /// Hash of the state after it was restored, where the run is resumed.
        restored: Option<u128>,
    },
    /// A window is finished.
    Done(Box<Done>),
    /// Still alive.
    Heartbeat(Progress),
    /// The snapshot that was asked for is stored, or could not be.
    Saved {
        /// Its window.
        window: u64,
        /// Why it could not be stored, in words.
        problem: Option<String>,
    },
    /// Cannot go on.
    Failed {
        /// Kind.
        kind: FailureKind,
        /// In words.
        message: String,
    },
    /// Has heard `Finish` or `Abort` and is leaving.
    Bye,
}

/// What a participant reports after set-up.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ReadyInfo {
    /// State at t = 0.
    pub report: Report,
    /// Largest stable substep \[s\] and the term that binds it.
    pub stable_dt: Option<(f64, String)>,
    /// Particles of each body.
    pub particles: Vec<u64>,
    /// What this solver leaves out.
    pub left_out: Vec<LeftOut>,
    /// Hash of the state at t = 0.
    pub state_hash: u128,
    /// Messages published at the start: stream, index, content hash.
    pub produced: Vec<(StreamId, u64, u64)>,
}

/// Kind of a participant's failure.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum FailureKind {
    /// The scene asks for what the plugin lacks.
    Unsupported,
    /// Blow-up, limit exceeded.
    Physics,
    /// Protocol or transport.
    Bus,
    /// What surrounds it: a disk, a file, a device.
    Environment,
}

/// Where a participant is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Progress {
    /// Window it works on.
    pub window: u64,
    /// Substeps of the step finished.
    pub substep: u64,
    /// Substeps of the step in all.
    pub substeps: u64,
    /// Stream it waits for, if it does.
    pub waiting_for: Option<StreamId>,
}

/// A window is finished.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Done {
    /// Window.
    pub window: u64,
    /// Iteration of the window; 0 for explicit schemes.
    pub iteration: u32,
    /// Messages used: stream, index, content hash.
    pub consumed: Vec<(StreamId, u64, u64)>,
    /// Messages published: stream, index, content hash.
    pub produced: Vec<(StreamId, u64, u64)>,
    /// Hash of all that `save` writes.
    pub state_hash: u128,
    /// Impulses published: interface, sum and sum of magnitudes \[N s\].
    pub sent: Vec<(InterfaceId, [f64; 3], f64)>,
    /// Impulses given to the solver, before any deliberate fault: interface, sum and sum of magnitudes \[N s\].
    pub applied: Vec<(InterfaceId, [f64; 3], f64)>,
    /// Moments of the same, where the body shows where it is at both edges of the window.
    pub moments: Vec<Moment>,
    /// State and budgets over the window.
    pub report: Report,
    /// Time split \[s\]; never part of a hash.
    pub times: Times,
}

/// Moment about the world origin of the impulses given to a solver, before any deliberate fault, as its host computes it
/// from what the body showed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Moment {
    /// Interface.
    pub interface: InterfaceId,
    /// With the body where the resolver saw it \[N m s\].
    pub given: [f64; 3],
    /// By how much the resolver may differ, for whom the body moves within the window \[N m s\].
    pub given_reach: f64,
    /// With the body at the start of this window \[N m s\].
    pub applied: [f64; 3],
    /// By how much the solver may differ, whose body moves while the impulses act \[N m s\].
    pub applied_reach: f64,
}

/// Where a window's wall time went \[s\], and when it began on the host's monotonic clock.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Times {
    /// Start of the first step on the system's monotonic clock \[s\].
    pub start_s: f64,
    /// End of the last step on the same clock \[s\].
    pub end_s: f64,
    /// Inside the solver.
    pub compute_s: f64,
    /// Waiting for inputs or for the clock.
    pub wait_s: f64,
    /// Encoding, sending, decoding.
    pub transfer_s: f64,
}

/// To a participant.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Down {
    /// You are in.
    Welcome {
        /// Your place in the plan.
        id: ParticipantId,
        /// The plan as JSON.
        plan: String,
        /// Your part of the scene as JSON.
        scene: String,
        /// Prepared geometry that belongs to it, to be fetched.
        assets: Vec<AssetInfo>,
        /// First window to compute: 0, or the one whose start a checkpoint holds.
        from: u64,
    },
    /// A piece of prepared geometry.
    Chunk {
        /// Number in the welcome's list.
        asset: u16,
        /// Number of the chunk: each but the last has [`ASSET_CHUNK_BYTES`].
        chunk: u32,
        /// The piece.
        bytes: Vec<u8>,
    },
    /// You are not, because.
    Refused {
        /// In words.
        reason: String,
    },
    /// Everybody has declared what it reads: send a probe on each stream, and what is published at the start.
    Probe,
    /// Everybody hears everybody: begin, as far as the grant goes.
    Start,
    /// Windows below `until` may be computed; windows below `committed` are settled and need not be kept.
    Grant {
        /// First window not granted.
        until: u64,
        /// First window not settled.
        committed: u64,
        /// A snapshot that is wanted.
        save: Option<Save>,
    },
    /// All windows are settled.
    Finish,
    /// The run ends here.
    Abort {
        /// In words.
        reason: String,
    },
}

/// A snapshot that is wanted.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Save {
    /// Window at whose start.
    pub at: u64,
    /// Window of the newest complete checkpoint: its snapshot must stay until a later one is complete.
    pub keep: Option<u64>,
}

/// Prepared geometry that can be fetched: an [`crate::asset::Asset`] in postcard.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct AssetInfo {
    /// Body, static collider or rigid partner it belongs to.
    pub name: String,
    /// Length.
    pub bytes: u64,
    /// [`asset_hash`] of all of it.
    pub hash: u64,
}

/// Identity of encoded geometry.
pub fn asset_hash(bytes: &[u8]) -> u64 {
    xxh3_64(bytes)
}

/// Request of a receiver for a message it lacks, on the sender's `resend` key.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Resend {
    /// Stream.
    pub stream: StreamId,
    /// Index.
    pub index: u64,
}

/// Protocol version of a message of any version: it always comes first, and the checksum last.
pub fn protocol_of(bytes: &[u8]) -> Option<u16> {
    let body = checked(bytes).ok()?;
    postcard::take_from_bytes(body).ok().map(|(version, _)| version)
}

/// Bytes that are no message.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum ControlError {
    /// Checksum or length wrong.
    #[error("checksum of a control message does not match")]
    Checksum,
    /// Not what the type says.
    #[error("control message cannot be decoded")]
    Malformed,
}

/// Bytes of a control message: postcard, then xxh3-64 of it.
pub fn encode<M: Serialize>(envelope: &Envelope<M>) -> Vec<u8> {
    // Serialising these plain types into a growing vector cannot fail; an empty message would be refused by `decode`.
    let mut bytes = postcard::to_stdvec(envelope).unwrap_or_default();
    bytes.extend_from_slice(&xxh3_64(&bytes).to_le_bytes());
    bytes
}

/// Reads what [`encode`] wrote, and nothing that goes on behind it.
///
/// # Errors
/// [`ControlError`]; a list is not allocated before the bytes show that they can hold it.
pub fn decode<M: for<'a> Deserialize<'a>>(bytes: &[u8]) -> Result<Envelope<M>, ControlError> {
    match postcard::take_from_bytes(checked(bytes)?) {
        Ok((envelope, [])) => Ok(envelope),
        _ => Err(ControlError::Malformed),
    }
}

/// The bytes before the checksum, if it matches.
fn checked(bytes: &[u8]) -> Result<&[u8], ControlError> {
    let (body, sum) = bytes.split_last_chunk::<8>().ok_or(ControlError::Checksum)?;
    if xxh3_64(body) == u64::from_le_bytes(*sum) { Ok(body) } else { Err(ControlError::Checksum) }
}
