//! Scene model, wire types, clock, coupling schemes and plugin contract of Cosplat.
//!
//! This crate does no input or output. It knows no solver, file format, transport, graphics processor or window. Both
//! sides of the protocol, [`participant::Participant`] and [`coordinator::Coordinator`], are pure state machines
//! `(state, event) → actions`: sockets, timers and disks belong to the hosts around them.

pub mod asset;
pub mod boundary;
pub mod checkpoint;
pub mod checks;
pub mod control;
pub mod coordinator;
pub mod distance;
pub mod ledger;
pub mod participant;
pub mod plan;
pub mod plugin;
pub mod rotation;
pub mod scene;
pub mod sim;
pub mod time;
pub mod visual;
pub mod wire;

#[cfg(target_endian = "big")]
compile_error!("the wire format is little-endian and arrays are copied as they are in memory");
