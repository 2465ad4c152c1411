//! What can go wrong on the bus: who, what, why, and what to do.

use std::io;

use cosplat_core::checkpoint::CheckpointError;

/// Something the transport could not do.
#[derive(Debug, thiserror::Error)]
pub enum BusError {
    /// Nobody handed this process a ticket.
    #[error("no join ticket on standard input: {why}; solver processes are started by `cosplat`, not by hand")]
    NoTicket {
        /// What was found instead.
        why: String,
    },
    /// The ticket cannot be used.
    #[error("the join ticket cannot be used: {why}; start this plugin with a `cosplat` of the same version")]
    BadTicket {
        /// What is wrong with it.
        why: String,
    },
    /// The process that started this one ended during start-up.
    #[error("the process that started this one is gone")]
    ParentGone,
    /// The system gave no random bytes.
    #[error("no random numbers for this run's passwords: {why}")]
    Random {
        /// The system's words.
        why: String,
    },
    /// The folder of the run's socket.
    #[error("cannot {what} `{path}`: {source}; set XDG_RUNTIME_DIR to a folder that can be written")]
    Folder {
        /// What was tried.
        what: &'static str,
        /// On what.
        path: String,
        /// The system's words.
        source: io::Error,
    },
    /// Unix socket addresses have room for few bytes.
    #[error(
        "the socket path `{path}` has {bytes} bytes, the system allows {limit}; set XDG_RUNTIME_DIR to a shorter path"
    )]
    PathTooLong {
        /// The path.
        path: String,
        /// Its length.
        bytes: usize,
        /// Longest possible.
        limit: usize,
    },
    /// A name of the plan cannot be part of a key.
    #[error("`{name}` cannot be a name on the bus: {why}")]
    Name {
        /// The name.
        name: String,
        /// What is wrong with it.
        why: String,
    },
    /// zenoh does not take its configuration.
    #[error("zenoh refuses its configuration: {why}; this program was built against another zenoh")]
    Config {
        /// zenoh's words.
        why: String,
    },
    /// No session.
    #[error("{who} cannot open the bus at `{endpoint}`: {why}; is the run still going, and is this its own ticket?")]
    Open {
        /// Who tried.
        who: String,
        /// Where.
        endpoint: String,
        /// zenoh's words.
        why: String,
    },
    /// A publisher, subscriber or token could not be declared.
    #[error("cannot declare {what} on `{key}`: {why}")]
    Declare {
        /// Kind of declaration.
        what: &'static str,
        /// Key.
        key: String,
        /// zenoh's words.
        why: String,
    },
    /// A message could not be handed to the transport.
    #[error("cannot publish on `{key}`: {why}; the connection is gone")]
    Publish {
        /// Key.
        key: String,
        /// zenoh's words.
        why: String,
    },
    /// The run cannot be taken up.
    #[error("the checkpoint cannot be used: {0}")]
    Checkpoint(#[from] CheckpointError),
    /// No thread.
    #[error("cannot start the thread `{name}`: {source}; is the limit of processes reached?")]
    Thread {
        /// Its name.
        name: &'static str,
        /// The system's words.
        source: io::Error,
    },
}
