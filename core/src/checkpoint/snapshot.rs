//! One participant at the edge of a window.

use serde::{Deserialize, Serialize};

use super::sealed::{Kind, open, seal};
use super::{CheckpointError, bytes};
use crate::control::RunId;
use crate::plan::StreamId;
use crate::plugin::Plugin;

/// One participant at the edge of a window: its state, and what it had published that later windows need.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Snapshot {
    /// Run.
    pub run: RunId,
    /// Identity of what the participant computes: plan, scene and geometry.
    pub identity: u128,
    /// Name of the participant.
    pub name: String,
    /// First window not computed.
    pub window: u64,
    /// Messages that windows from `window` on can need. Statics are not among them: set-up makes them anew.
    pub messages: Vec<KeptMessage>,
    /// What the plugin's `save` wrote.
    #[serde(with = "bytes")]
    pub state: Vec<u8>,
}

/// A message as it was published.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct KeptMessage {
    /// Stream.
    pub stream: StreamId,
    /// Index.
    pub index: u64,
    /// Elements.
    pub count: u32,
    /// Payload, without any header.
    #[serde(with = "bytes")]
    pub payload: Vec<u8>,
}

impl Snapshot {
    /// Bytes to store, with the state that `plugin` has now.
    pub fn of(mut self, plugin: &dyn Plugin) -> Vec<u8> {
        self.state.clear();
        plugin.save(&mut self.state);
        self.encode()
    }

    /// Bytes to store.
    pub fn encode(&self) -> Vec<u8> {
        seal(Kind::Snapshot, self)
    }

    /// Reads what [`Self::encode`] wrote.
    ///
    /// # Errors
    /// [`CheckpointError`].
    pub fn decode(bytes: &[u8]) -> Result<Self, CheckpointError> {
        open(Kind::Snapshot, bytes)
    }

    /// Whether it is of this run, participant and window.
    pub(crate) fn check(&self, run: RunId, identity: u128, name: &str, window: u64) -> Result<(), CheckpointError> {
        if self.run != run {
            return Err(CheckpointError::Run);
        }
        if self.name != name {
            let (found, expected) = (self.name.clone(), name.to_owned());
            return Err(CheckpointError::Participant { found, expected });
        }
        if self.identity != identity {
            return Err(CheckpointError::Identity);
        }
        if self.window != window {
            return Err(CheckpointError::Window { found: self.window, expected: window });
        }
        Ok(())
    }
}
