//! One file per command.

pub(crate) mod check;
mod failure;
pub(crate) mod plugins;
pub(crate) mod run;
pub(crate) mod solver;
