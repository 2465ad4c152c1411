//! The contract between a solver and the rest: one trait, and the data that crosses it.
//!
//! A plugin only computes. It opens no socket, reads no clock, writes no file and starts no process; the host loop
//! around it does all that, and is the same for every plugin.

mod budget;
mod descriptor;
mod exchange;
#[cfg(test)]
mod fixtures;
mod heard;
mod influence;
mod moving;
mod points;
mod push;
mod question;
mod refusals;
mod scene;
mod state;

pub use budget::Budget;
pub use descriptor::{BodyKind, Descriptor, InterfaceRole, Saves};
pub use exchange::{
    BodyState, BoundaryOutput, Energy, ImpulseInput, Inputs, InterfaceReport, Outputs, PartnerInput, Report, count,
};
pub use influence::{Influence, InfluenceKind, OffCentre, hooks, switches};
pub use moving::Moving;
pub use points::Points;
pub use push::{PartAction, PartInfluence, Push, part_actions};
pub use question::{Question, Questions};
pub use refusals::Refusals;
pub use scene::{InterfaceView, OwnView, PartnerSetup, Setup, SetupBoundary, SolverScene, Step, ViewRole};
pub use state::{StateError, StateHasher, StateReader, StateSink};

use crate::visual::{VisualFrame, VisualState};

/// Says how far a long computation is, and hears whether to go on.
pub trait Pulse {
    /// Substep `done` of `of` is finished. Call it at least a few times a second.
    fn beat(&mut self, done: u64, of: u64) -> Signal;
}

/// Answer to a beat.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Signal {
    /// Carry on.
    Continue,
    /// Return [`PluginError::Aborted`] as soon as possible; the state will not be used again.
    Abort,
}

/// A pulse for tests and simulations: always continue.
#[derive(Clone, Copy, Debug, Default)]
pub struct Steady;

impl Pulse for Steady {
    fn beat(&mut self, _done: u64, _of: u64) -> Signal {
        Signal::Continue
    }
}

/// Why a plugin could not do what it was asked.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum PluginError {
    /// The scene asks for something this plugin lacks.
    #[error("{0}")]
    Unsupported(String),
    /// The physics left the range in which a result means anything.
    #[error("{0}")]
    Physics(String),
    /// A saved state does not fit.
    #[error("the saved state does not fit: {0}")]
    State(#[from] StateError),
    /// The host broke the contract: a call out of order, inputs that the plan does not name.
    #[error("the host broke the contract: {0}")]
    Contract(String),
    /// What surrounds the plugin failed it: a disk, a file, a device.
    #[error("{0}")]
    Environment(String),
    /// It was told to stop.
    #[error("stopped on request")]
    Aborted,
}

/// One physics solver.
///
/// Order of calls: `setup` once, `connect` once, then any number of `advance`, `save` and `restore`. Equal state, step
/// and inputs must give bit-equal outputs on any number of threads.
pub trait Plugin {
    /// Who it is and what it can do; needs no set-up.
    fn describe(&self) -> Descriptor;

    /// Takes its part of a checked scene and shows its boundaries at t = 0.
    ///
    /// # Errors
    /// [`PluginError::Unsupported`] naming each feature that this plugin lacks.
    fn setup(&mut self, scene: &SolverScene) -> Result<Setup, PluginError>;

    /// Learns what never changes about its partners. Called once, with nothing where there are no partners.
    ///
    /// # Errors
    /// [`PluginError::Unsupported`] when a partner's boundary cannot be handled.
    fn connect(&mut self, _partners: &[PartnerSetup]) -> Result<(), PluginError> {
        Ok(())
    }

    /// Advances the state over exactly `step`; substeps inside are its own business.
    ///
    /// # Errors
    /// [`PluginError::Physics`] when the state blew up, [`PluginError::Aborted`] after [`Signal::Abort`].
    fn advance(&mut self, step: &Step, inputs: &Inputs, pulse: &mut dyn Pulse) -> Result<Outputs, PluginError>;

    /// A body as it is now, for pictures and files; asked for only in the form that the descriptor declares, and only for
    /// bodies that somebody draws. `None` where the plugin has nothing to show.
    fn visual(&self, _body: &str) -> Option<VisualState> {
        None
    }

    /// Takes a frame to draw or to write. Only recorders are given any, before the `advance` of the window that ends
    /// with it.
    ///
    /// # Errors
    /// [`PluginError::Environment`] when it cannot be written.
    fn record(&mut self, _frame: &VisualFrame, _pulse: &mut dyn Pulse) -> Result<(), PluginError> {
        Ok(())
    }

    /// Finishes what `record` was given, so that it outlives this machine. Called before a snapshot is taken: whoever
    /// resumes from it is not given those frames again.
    ///
    /// # Errors
    /// [`PluginError::Environment`] when something cannot be written.
    fn flush(&mut self) -> Result<(), PluginError> {
        Ok(())
    }

    /// Writes everything that `advance` depends on.
    fn save(&self, sink: &mut dyn StateSink);

    /// Returns to a saved state, bitwise.
    ///
    /// # Errors
    /// [`PluginError::State`]; the plugin is then unchanged.
    fn restore(&mut self, state: &[u8]) -> Result<(), PluginError>;
}
