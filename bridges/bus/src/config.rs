//! zenoh's configuration for both sides. Everything that is open by default is closed here.

use std::path::Path;
use std::time::Duration;

use cosplat_core::plan::Plan;
use serde_json::{Value, json};
use zenoh::Config;

use crate::access::{access_control, size_limits};
use crate::error::BusError;
use crate::keys::Keys;
use crate::ticket::JoinTicket;

/// A connection without any sign of life for this long is closed \[ms\].
const LEASE_MS: u64 = 10_000;
/// A sender waits this long for a slow receiver before the connection is given up \[µs\]. The transport is patient;
/// that somebody is slow is said much earlier, by missing heartbeats.
const WAIT_BEFORE_CLOSE_US: u64 = 30_000_000;
/// Largest message that is put together from fragments: a participant's part of a scene with all its points.
const MAX_MESSAGE_BYTES: u64 = 64 << 20;
/// How long either side takes part in one handshake \[ms\].
const HANDSHAKE_MS: u64 = 5000;

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
                "rx": { "max_message_size": MAX_MESSAGE_BYTES },
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

/// Configuration of the coordinator: the one router, so that one place enforces the rules.
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
    config["access_control"] = access_control(plan, keys)?;
    config["low_pass_filter"] = size_limits(plan, keys);
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
