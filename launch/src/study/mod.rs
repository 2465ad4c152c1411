//! Studies: what a scene's result is worth, against the time that it takes.
//!
//! A case is a scene and a reference, both files. Every combination of what it varies is run by `cosplat run` as a
//! process of its own, and compared: errors, their split into coupling and solvers, orders of convergence, the cheapest
//! run for a given error, and gates with the reason why each must hold.

pub(crate) mod ablation;
pub(crate) mod case;
pub(crate) mod catalogue;
pub(crate) mod conduct;
pub(crate) mod control;
mod design;
pub(crate) mod evaluate;
pub(crate) mod fingerprint;
mod formula;
pub(crate) mod front;
mod gate;
mod norm;
pub(crate) mod order;
pub(crate) mod outcome;
pub(crate) mod pictures;
mod pool;
pub(crate) mod read;
mod read_gate;
pub(crate) mod recording;
pub(crate) mod result;
pub(crate) mod rows;
mod section;
pub(crate) mod sheet;
pub(crate) mod stability;
mod substitute;
pub(crate) mod suite;
mod table;
pub(crate) mod text;
mod trial;
