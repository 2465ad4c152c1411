//! The whole protocol on a simulated bus: a seeded scheduler that delays, drops, duplicates, reorders, corrupts,
//! forges, kills and freezes. Thousands of runs a minute, each repeatable from its seed.
//!
//! The machines are the real ones; only the bus, the clock and the physics are not. What must hold is in [`Violation`].

mod birth;
mod faults;
mod host;
mod judge;
mod lives;
mod network;
mod random;
mod scenario;
mod toy;
mod world;

pub use faults::{Faults, Forgery};
pub use random::Random;
pub use scenario::{Scenario, Trouble};
pub use world::{Report, Violation, run};

use crate::checks::{AllChecks, Checks};

/// Runs the scenario of a seed without faults and then with them, and answers what did not hold.
///
/// # Errors
/// The first violation; it says how to replay it.
pub fn check_seed(seed: u64) -> Result<Report, Violation> {
    check_seed_with(seed, AllChecks)
}

/// The same with some protocol checks switched off in the faulty run.
///
/// # Errors
/// The first violation.
pub fn check_seed_with<C: Checks + Copy>(seed: u64, checks: C) -> Result<Report, Violation> {
    let scenario = Scenario::from_seed(seed);
    let calm = run(&scenario.calm(), AllChecks, None)?;
    run(&scenario, checks, Some(calm.state_hash))
}
