//! The ledger: what crossed each interface in a window, and whether the states agree.
//!
//! `transfer_defect` compares what one host sent with what the other handed to its solver: it must be exactly zero.
//! `closure` compares the change of each solver's momentum, summed over its own state, with all impulses that explain
//! it; an echo of what was sent could not pass it. `moment_closure` compares the moments that both sides book with those
//! that the responder's host computed from what the body showed.

mod book;

use serde::{Deserialize, Serialize};

pub use book::Ledger;

/// One window of a run.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct WindowRecord {
    /// Window.
    pub window: u64,
    /// Moment at its end \[s\].
    pub end_s: f64,
    /// Chain of all states up to here.
    pub state_hash: u128,
    /// One per solver, in participant order.
    pub solvers: Vec<SolverRecord>,
    /// One per interface, in plan order.
    pub interfaces: Vec<InterfaceRecord>,
    /// Total energy \[J\]: kinetic and potential of all solvers, and what is stored in links between them.
    pub total_energy_j: f64,
}

/// A solver's budget over a window.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct SolverRecord {
    /// Kinetic energy \[J\].
    pub kinetic_j: f64,
    /// Potential energy \[J\].
    pub potential_j: f64,
    /// Dissipated since t = 0 \[J\].
    pub dissipated_j: f64,
    /// Supplied from outside in this window \[J\].
    pub supplied_j: f64,
    /// Linear momentum \[kg m/s\].
    pub momentum: [f64; 3],
    /// `|ΔP − ΣJ_in + ΣJ_out − J_external|` over the run's largest Σ m|v| so far.
    pub closure: f64,
    /// The same for angular momentum about the world origin, over the largest Σ m|v| times the largest |x|.
    pub angular_closure: f64,
    /// Over the same scale: moments of what crossed that its books do not have, beyond what the way of the bodies within
    /// the window explains.
    pub moment_closure: f64,
}

/// An interface's budget over a window.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct InterfaceRecord {
    /// Impulse given by `a` \[N s\].
    pub given: [f64; 3],
    /// Impulse received by `b` \[N s\].
    pub received: [f64; 3],
    /// Σ|J| \[N s\].
    pub gross: f64,
    /// |given − received| \[N s\]: exactly zero where impulses cross; of first order in the window for other links.
    pub transfer_defect: f64,
    /// Angular momentum made or lost in the crossing \[N m s\]: zero for rigid bodies. Samples move between the window
    /// that an impulse is computed in and the one it is applied in, and may have been reached a little beside them.
    pub moment_defect: f64,
    /// Work done on `a` plus work done on `b` plus change of the link's potential \[J\].
    pub work_defect: f64,
    /// Largest difference between a stand-in and the partner itself.
    pub residual: f64,
    /// Energy stored in the link \[J\].
    pub stored_j: f64,
}
