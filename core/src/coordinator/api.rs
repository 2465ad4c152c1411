//! What the coordinator's state machine is told and what it asks for.

use std::time::Duration;

use crate::checkpoint::Checkpoint;
use crate::control::{Done, ReadyInfo};
use crate::ledger::WindowRecord;
use crate::plan::ParticipantId;

/// Deadlines. They end a run with a named reason; they never change a result.
#[derive(Clone, Copy, Debug)]
pub struct Limits {
    /// From start to the last participant's join, set-up included; from a stop to its checkpoint.
    pub join: Duration,
    /// Without heartbeat before it is said who is silent.
    pub silence_notice: Duration,
    /// Without heartbeat before the run ends.
    pub silence: Duration,
    /// Between repetitions of an unanswered message.
    pub repeat: Duration,
    /// Windows that participants may run ahead of the last settled one.
    pub ahead: u64,
    /// Windows from one checkpoint to the next, at least; a stop makes one as well. None are made without.
    pub checkpoint_every: Option<u64>,
}

impl Default for Limits {
    fn default() -> Self {
        Self {
            join: Duration::from_secs(30),
            silence_notice: Duration::from_secs(2),
            silence: Duration::from_secs(10),
            repeat: Duration::from_millis(100),
            ahead: 2,
            checkpoint_every: None,
        }
    }
}

/// What happened.
#[derive(Debug)]
pub enum Event {
    /// Bytes on `ack/<participant>`; the key is the sender's authenticated identity.
    Up(ParticipantId, Vec<u8>),
    /// A participant's process has ended: how, and the last words on its standard error.
    Died {
        /// Who.
        who: ParticipantId,
        /// `exit code 3`, `signal 9 (SIGKILL)` …
        how: String,
    },
    /// The checkpoint of this window is stored for good, or why it could not be.
    Recorded(u64, Result<(), String>),
    /// The user wants to stop at the next window edge.
    Stop,
    /// Time has passed.
    Tick,
}

/// What to do, in order.
#[derive(Debug)]
pub enum Action {
    /// Put these bytes on `ctl/<participant>`.
    Send(ParticipantId, Vec<u8>),
    /// A participant has joined and is set up.
    Ready(ParticipantId, Box<ReadyInfo>),
    /// Everybody hears everybody; the first window begins.
    Started,
    /// A window is settled: its ledger row and what each participant reported, in participant order.
    Settled(Box<WindowRecord>, Vec<Done>),
    /// Store this checkpoint: all participants have stored their parts. Answer with [`Event::Recorded`] when it cannot be
    /// lost any more, which may be later; there is no next one before.
    Checkpoint(Box<Checkpoint>),
    /// Something people should read: who is waited for and why.
    Notice(String),
    /// Windows end here, for good or bad. All participants have been told.
    Ended(Outcome),
}

/// How a run ended.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// All windows settled.
    Finished,
    /// Stopped by the user at a window edge; that many windows are settled.
    Stopped {
        /// Settled windows.
        windows: u64,
    },
    /// Ended early.
    Failed(Failure),
}

/// Why a run ended early: who, where, what.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Failure {
    /// A plugin lacks what the scene asks for.
    #[error("solver `{who}` cannot play this scene: {message}")]
    Unsupported {
        /// Participant.
        who: String,
        /// In words.
        message: String,
    },
    /// The physics left the range in which a result means anything.
    #[error("solver `{who}` stopped in window {window}: {message}")]
    Physics {
        /// Participant.
        who: String,
        /// Window it worked on.
        window: u64,
        /// In words.
        message: String,
    },
    /// What surrounds a participant failed it: a disk, a file, a device.
    #[error("`{who}` could not go on in window {window}: {message}")]
    Environment {
        /// Participant.
        who: String,
        /// Window it worked on.
        window: u64,
        /// In words.
        message: String,
    },
    /// A process ended by itself.
    #[error("solver `{who}` ended unexpectedly in window {window}: {how}")]
    Died {
        /// Participant.
        who: String,
        /// First window it had not finished.
        window: u64,
        /// Exit code or signal.
        how: String,
    },
    /// A process stopped talking.
    #[error("solver `{who}` has been silent for {seconds} s in window {window}, {waiting}")]
    Silent {
        /// Participant.
        who: String,
        /// First window it had not finished.
        window: u64,
        /// Whole seconds of silence.
        seconds: u64,
        /// What it was last known to do.
        waiting: String,
    },
    /// Everybody lives and everybody waits.
    #[error("no window has been finished for {seconds} s after window {window}: {waiting}")]
    Deadlock {
        /// First window not settled.
        window: u64,
        /// Whole seconds waited.
        seconds: u64,
        /// Who waits for what.
        waiting: String,
    },
    /// Somebody never arrived.
    #[error("no word from {} within {seconds} s of the start: {phase}", list(.who))]
    Missing {
        /// Participants.
        who: Vec<String>,
        /// Whole seconds waited.
        seconds: u64,
        /// What was waited for.
        phase: String,
    },
    /// A participant speaks another protocol version.
    #[error("solver `{who}` speaks protocol {theirs}, this program {ours}; install matching versions")]
    Version {
        /// Participant.
        who: String,
        /// Its range.
        theirs: String,
        /// Ours.
        ours: u16,
    },
    /// Two participants disagree about a message, or one broke the protocol.
    #[error("solver `{who}` broke the protocol in window {window}: {message}")]
    Protocol {
        /// Participant.
        who: String,
        /// Window.
        window: u64,
        /// In words.
        message: String,
    },
}

fn list(names: &[String]) -> String {
    let quoted: Vec<String> = names.iter().map(|n| format!("`{n}`")).collect();
    quoted.join(", ")
}
