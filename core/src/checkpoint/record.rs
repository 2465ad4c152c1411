//! What the coordinator knows at the edge of a window.

use serde::{Deserialize, Serialize};

use super::CheckpointError;
use super::sealed::{Kind, open, seal};
use crate::control::RunId;
use crate::ledger::Ledger;
use crate::plan::StreamId;

/// The coordinator at the edge of a window: all windows before are settled, and every participant has stored its
/// [`super::Snapshot`] of this edge.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Checkpoint {
    /// Run.
    pub run: RunId,
    /// Incarnation that wrote it.
    pub epoch: u32,
    /// Identity of what is computed: plan, scenes and geometry.
    pub identity: u128,
    /// First window not settled.
    pub window: u64,
    /// Chain of all states before.
    pub state_hash: u128,
    /// Hash of each participant's state, in participant order.
    pub states: Vec<u128>,
    /// Messages that later windows need: stream, index, content hash.
    pub published: Vec<(StreamId, u64, u64)>,
    /// What the ledger compares the next window with.
    pub ledger: Ledger,
}

impl Checkpoint {
    /// Bytes to store.
    pub fn encode(&self) -> Vec<u8> {
        seal(Kind::Checkpoint, self)
    }

    /// Reads what [`Self::encode`] wrote.
    ///
    /// # Errors
    /// [`CheckpointError`].
    pub fn decode(bytes: &[u8]) -> Result<Self, CheckpointError> {
        open(Kind::Checkpoint, bytes)
    }
}
