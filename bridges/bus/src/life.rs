//! The lives of a run: the first, and one more each time it is taken up.

use std::path::PathBuf;

use cosplat_core::checkpoint::Checkpoint;
use cosplat_core::control::{FIRST_EPOCH, RunId};

use crate::credentials::new_run;
use crate::error::BusError;

/// Which run this is, which incarnation of it, and where its checkpoints lie.
#[derive(Clone, Debug)]
pub struct Life {
    /// The run, the same in all its lives.
    pub run: RunId,
    /// Incarnation: [`FIRST_EPOCH`], and one more each time the run is taken up.
    pub epoch: u32,
    /// Folder of its checkpoints; needed where any are made or taken up.
    pub checkpoints: Option<PathBuf>,
    /// Where it is taken up; at t = 0 without.
    pub from: Option<Box<Checkpoint>>,
}

impl Life {
    /// The first life of a new run, without checkpoints.
    ///
    /// # Errors
    /// [`BusError::Random`].
    pub fn first() -> Result<Self, BusError> {
        Ok(Self { run: new_run()?, epoch: FIRST_EPOCH, checkpoints: None, from: None })
    }
}
