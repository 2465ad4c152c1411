//! zenoh's configuration for all sides. Everything that is open by default is closed here.

use std::path::Path;
use std::time::Duration;

use cosplat_core::plan::Plan;
use serde_json::{Value, json};
use zenoh::Config;

use crate::access::{control_access, control_limits, data_access, data_limits};
use crate::error::BusError;
use crate::keys::Keys;
use crate::ticket::{Door, JoinTicket, Partner};

/// A connection without any sign of life for this long is closed \[ms\].
const LEASE_MS: u64 = 10_000;
/// A sender waits this long for a slow receiver before the connection is given up \[µs\]. The transport is patient;
/// that somebody is slow is said much earlier, by missing heartbeats.
const WAIT_BEFORE_CLOSE_US: u64 = 30_000_000;
/// Largest message that is put together from fragments: a participant's part of a scene with all its points.
const MAX_MESSAGE_BYTES: u64 = 64 << 20;
/// Receive buffers that are kept for reuse, per connection: about as many as a sender has on its way at once.
const RECEIVE_BYTES: u64 = 1 << 20;
/// How long either side takes part in one handshake \[ms\].
const HANDSHAKE_MS: u64 = 5000;

/// What whoever starts a participant should put into its environment, for speed alone.
///
/// zenoh has threads that wait for connections, others that open them, and others that receive. A connection wakes the
/// thread that made it, which then wakes the receiver: one wake-up more per message, a fifth of a short window. With the
/// first line the receiver is woken directly. Sending keeps a thread of its own: with that handed over too, runs stalled.
///
/// The other two keep the allocator of glibc from giving every window's buffers back to the system and fetching them
/// again page by page: a sixth of a window of several megabytes.
pub const ENVIRONMENT: [(&str, &str); 3] = [
    ("ZENOH_RUNTIME", "(acc:(handover:rx),net:(handover:rx))"),
    ("MALLOC_MMAP_THRESHOLD_", "33554432"),
    ("MALLOC_TRIM_THRESHOLD_", "268435456"),
];

/// What both sides have in common.
fn common(mode: &str, auth: &Value, max_sessions: usize) -> Value {
    json!({
        "mode": mode,
        "scouting": { "delay": 1, "multicast": { "enabled": false }, "gossip": { "enabled": false } },
        "adminspace": { "enabled": false },
        "timestamping": { "enabled": false },
        "open": { "return_conditions": { "connect_scouted": false, "declares": true } },
        "transport": {
            "unicast": {
                "open_timeout": HANDSHAKE_MS, "accept_timeout": HANDSHAKE_MS,
                "accept_pending": max_sessions, "max_sessions": max_sessions, "max_links": 1,
            },
            "link": {
                "protocols": ["unixsock-stream"],
                "tx": {
                    "lease": LEASE_MS, "keep_alive": 4,
                    "queue": {
                        // One full chunk and more, so that a sender is back at its work while the chunk is on its way.
                        "size": { "interactive_high": 16 },
                        "congestion_control": { "block": { "wait_before_close": WAIT_BEFORE_CLOSE_US } },
                    },
                },
                "rx": { "max_message_size": MAX_MESSAGE_BYTES, "buffer_size": RECEIVE_BYTES },
            },
            // Chunks of a receiver that is not scheduled for a while would be lost without a word (zenoh #2628).
            "shared_memory": { "enabled": false },
            "auth": { "usrpwd": auth },
        },
    })
}

fn finish(config: &Value) -> Result<Config, BusError> {
    // zenoh rejects keys it does not know: a protection that is misspelt cannot be silently off.
    Config::from_json5(&config.to_string()).map_err(|e| BusError::Config { why: e.to_string() })
}

/// Configuration of the coordinator: the one router of all control, so that one place enforces its rules.
///
/// # Errors
/// [`BusError::Config`], [`BusError::Name`].
pub fn coordinator(plan: &Plan, keys: &Keys, endpoint: &str, users: &Path) -> Result<Config, BusError> {
    if plan.participants.is_empty() {
        // zenoh asks nobody for a password while its list of users is empty.
        return Err(BusError::Config { why: "a run without participants needs no bus".to_owned() });
    }
    let auth = json!({ "dictionary_file": users });
    // Two more than the plan has: one that is still being given up, one that comes back.
    let mut config = common("router", &auth, plan.participants.len() + 2);
    config["listen"] = json!({ "endpoints": [endpoint], "exit_on_failure": true });
    config["connect"] = json!({ "endpoints": [] });
    config["access_control"] = control_access(plan, keys)?;
    config["low_pass_filter"] = control_limits(keys);
    finish(&config)
}

/// Configuration of a participant, which gives up when it has not been let in after `patience`.
///
/// # Errors
/// [`BusError::Config`].
pub fn participant(ticket: &JoinTicket, patience: Duration) -> Result<Config, BusError> {
    let auth = json!({ "user": ticket.user, "password": ticket.password });
    let mut config = common("client", &auth, 2);
    config["listen"] = json!({ "endpoints": [] });
    config["connect"] = json!({
        "endpoints": [ticket.endpoint],
        "timeout_ms": patience.as_millis() as u64,
        "exit_on_failure": true,
        "retry": { "period_init_ms": 50, "period_max_ms": 400, "period_increase_factor": 2 },
    });
    finish(&config)
}

/// Configuration of a participant's side of the way to a partner: a bus of these two, beside the coordinator's.
///
/// The side that enters looks for the other in the background, for as long as the session is open: whether the way
/// works is found out by the probes that the join is made of.
///
/// # Errors
/// [`BusError::Config`], [`BusError::Name`], [`BusError::BadTicket`] for a partner that the plan does not know.
pub fn partner(ticket: &JoinTicket, partner: &Partner, plan: &Plan) -> Result<Config, BusError> {
    let find = |name: &str| {
        let why = || format!("`{name}` is not in the plan");
        plan.participant(name).ok_or_else(|| BusError::BadTicket { why: why() })
    };
    let (me, other, keys) = (find(&ticket.name)?, find(&partner.name)?, Keys::new(&ticket.run_id()?));
    let endpoints = [partner.endpoint.as_str()];
    let (auth, listen, connect): (_, &[&str], &[&str]) = match &partner.door {
        Door::Open(users) => (json!({ "dictionary_file": users }), &endpoints, &[]),
        Door::Enter(password) => (json!({ "user": ticket.name, "password": password }), &[], &endpoints),
    };
    let mut config = common("peer", &auth, 2);
    config["listen"] = json!({ "endpoints": listen, "exit_on_failure": true });
    config["connect"] = json!({
        "endpoints": connect,
        "timeout_ms": -1,
        "exit_on_failure": false,
        "retry": { "period_init_ms": 5, "period_max_ms": 100, "period_increase_factor": 2 },
    });
    config["access_control"] = data_access(plan, &keys, me, other, !listen.is_empty())?;
    config["low_pass_filter"] = data_limits(plan, &keys);
    finish(&config)
}
