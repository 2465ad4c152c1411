//! A participant's snapshots: written beside its computation, read before it begins.

use std::io;
use std::thread;

use cosplat_core::checkpoint::{CheckpointError, Snapshot};

use super::wire::Incoming;
use crate::queue::Post;
use crate::store::CheckpointFolder;
use crate::ticket::JoinTicket;

/// Keeps the snapshots of one participant.
pub(crate) struct Keeper {
    folder: Option<CheckpointFolder>,
    name: String,
    post: Post<Incoming>,
}

impl Keeper {
    /// For the holder of `ticket`; what was stored is told to `post`.
    pub(crate) fn new(ticket: &JoinTicket, post: Post<Incoming>) -> Self {
        let folder = ticket.checkpoints.as_ref().map(CheckpointFolder::new);
        Self { folder, name: ticket.name.clone(), post }
    }

    pub(super) fn load(&self, window: u64) -> Result<Box<Snapshot>, CheckpointError> {
        let nowhere = || CheckpointError::Unreadable("the ticket names no folder of checkpoints".to_owned());
        self.folder.as_ref().ok_or_else(nowhere)?.snapshot(&self.name, window).map(Box::new)
    }

    /// Writes a snapshot on a thread of its own: a disk may need longer than a window. Nobody asks for the next one
    /// before it has been told about this one.
    pub(super) fn store(&self, window: u64, bytes: Vec<u8>, keep: Option<u64>) {
        let (folder, name, post) = (self.folder.clone(), self.name.clone(), self.post.clone());
        let write = move || {
            let nowhere = || io::Error::other("the ticket names no folder of checkpoints");
            let stored = folder.ok_or_else(nowhere).and_then(|f| f.put_snapshot(&name, window, keep, &bytes));
            post.send(Incoming::Stored(window, stored.map_err(|e| e.to_string())));
        };
        if let Err(error) = thread::Builder::new().name("checkpoint".to_owned()).spawn(write) {
            self.post.send(Incoming::Stored(window, Err(format!("no thread to write it: {error}"))));
        }
    }
}
