//! Points from which a run can be resumed, as values: hosts put them into files.
//!
//! A [`Snapshot`] is one participant at the edge of a window. It stays where the participant is; nothing large crosses
//! the bus. A [`Checkpoint`] is what the coordinator knows at the same edge. It is handed out only after every
//! participant has said that its snapshot is stored, so that its being there means that all of it is: a two-phase commit
//! (Gray, "Notes on data base operating systems", 1978), with the coordinator's record as the commit.

mod bytes;
mod identity;
mod record;
mod sealed;
mod snapshot;

pub use record::Checkpoint;
pub use snapshot::{KeptMessage, Snapshot};

pub(crate) use identity::{identity_of, identity_of_part};

/// Why a stored point cannot be used.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum CheckpointError {
    /// None was found, or it could not be read.
    #[error("it cannot be read: {0}")]
    Unreadable(String),
    /// Not one of ours.
    #[error("it is no checkpoint of this program: it does not begin like one")]
    Foreign,
    /// Of another version.
    #[error("it has version {found}, this program reads {}; resume with the program that wrote it", sealed::VERSION)]
    Version {
        /// In the bytes.
        found: u16,
    },
    /// A bit is wrong somewhere, or the end is missing.
    #[error("its checksum does not match: it is damaged or not complete; use an earlier one")]
    Checksum,
    /// The checksum is right and the content is not what it should be.
    #[error("its content cannot be understood: {0}")]
    Malformed(String),
    /// Of another run.
    #[error("it belongs to another run")]
    Run,
    /// Of another scene, plan or geometry.
    #[error("it belongs to another scene or plan; resume with the scene it was made with")]
    Identity,
    /// Of another participant.
    #[error("it is of `{found}`, not of `{expected}`")]
    Participant {
        /// In the snapshot.
        found: String,
        /// Wanted.
        expected: String,
    },
    /// Of another edge.
    #[error("it is of the start of window {found}, not of window {expected}")]
    Window {
        /// In the snapshot.
        found: u64,
        /// Wanted.
        expected: u64,
    },
    /// The run has been resumed with this incarnation or a later one before.
    #[error("it was written by incarnation {written}, which {epoch} does not follow; a resumed run counts up")]
    Epoch {
        /// Of the one that wrote it.
        written: u32,
        /// Of the one that wants to resume.
        epoch: u32,
    },
}
