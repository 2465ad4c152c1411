//! The zenoh transport of Cosplat: sessions, join, and the host loop around a plugin.
//!
//! This is the only crate that knows zenoh. It owns sockets, timers and threads; what is said and when is decided by
//! the state machines of `cosplat-core`, which it drives:
//!
//! * [`run_plugin`] is what the `main` of a plugin calls: it joins a run and serves the plugin until the run ends;
//! * [`CoordinatorHost`] opens a run's bus, hands out one [`JoinTicket`] per participant and drives the coordinator.
//!
//! Control goes through the coordinator's router. Data goes directly: each two participants that share a stream have a
//! bus of two, with a socket, a password and an access list of its own. A router between them would cost every window
//! two more hops and every byte two more sockets.
//!
//! zenoh is taken as a fast carrier that may lose, repeat and delay. What it is trusted with is keeping strangers out:
//! unix sockets in a folder of the run's own, a random password per participant or pair and run, and access lists that
//! are made from the plan and deny what they do not name. The key on which a message arrives is therefore its
//! authenticated sender.

mod access;
mod clock;
pub mod config;
mod coordinator_host;
mod credentials;
mod error;
mod host;
mod keys;
mod life;
mod lifeline;
mod partners;
mod queue;
mod session;
mod store;
mod ticket;

pub use coordinator_host::{CoordinatorEvent, CoordinatorHandle, CoordinatorHost};
pub use credentials::RunFolder;
pub use error::BusError;
pub use host::{describe, run_plugin, serve};
pub use keys::{Keys, run_from_hex, run_to_hex};
pub use life::Life;
pub use lifeline::Lifeline;
pub use partners::introduce;
pub use queue::{Mailbox, Post, Spin, mailbox};
pub use session::{Bus, Lane, Outlet, Payload, Presence};
pub use store::{CheckpointFolder, file_name};
pub use ticket::{Door, JoinTicket, Partner};
