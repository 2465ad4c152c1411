//! The join ticket: all a participant needs to find and enter its run, as one line of JSON on its standard input.
//!
//! Standard input rather than arguments or environment, because those are visible to every process of the machine, and
//! because the open pipe is also how a participant notices that its launcher is gone (see [`crate::Lifeline`]).

use std::fmt;
use std::path::PathBuf;

use cosplat_core::control::{FIRST_EPOCH, PROTOCOL, RunId};
use serde::{Deserialize, Serialize};

use crate::error::BusError;
use crate::keys::{check_name, run_from_hex};

/// Longest line that is taken for a ticket.
pub(crate) const MAX_TICKET_BYTES: usize = 256 * 1024;

/// How to meet one partner, directly: who shares streams has a bus of two, without anybody in between.
#[derive(Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Partner {
    /// Its name in the plan.
    pub name: String,
    /// Where the one that opens the door listens.
    pub endpoint: String,
    /// Who opens, who enters.
    pub door: Door,
}

/// A side of the way between two partners.
#[derive(Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Door {
    /// This participant listens, and lets in whom this file names.
    Open(String),
    /// This participant enters under its own name, with this password.
    Enter(String),
}

/// How to join a run, and as whom.
#[derive(Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct JoinTicket {
    /// Protocol version of the coordinator.
    pub protocol: u16,
    /// Identity of the run, hexadecimal.
    pub run: String,
    /// Name in the plan.
    pub name: String,
    /// Where the coordinator listens.
    pub endpoint: String,
    /// User name.
    pub user: String,
    /// Password of this user in this run.
    pub password: String,
    /// Threads the participant may use.
    pub threads: usize,
    /// Everybody it exchanges streams with.
    pub partners: Vec<Partner>,
    /// Incarnation of the coordinator.
    #[serde(default = "first_epoch")]
    pub epoch: u32,
    /// Folder of the run's checkpoints, where it makes any or is resumed from one.
    #[serde(default)]
    pub checkpoints: Option<PathBuf>,
}

fn first_epoch() -> u32 {
    FIRST_EPOCH
}

impl JoinTicket {
    /// The line to write, with its end.
    pub fn to_line(&self) -> String {
        // Strings and integers always have a JSON form; an empty line would be refused by `from_line`.
        let mut line = serde_json::to_string(self).unwrap_or_default();
        line.push('\n');
        line
    }

    /// Reads a line.
    ///
    /// # Errors
    /// [`BusError::BadTicket`].
    pub fn from_line(line: &str) -> Result<Self, BusError> {
        let refuse = |why: String| BusError::BadTicket { why };
        let ticket: Self = serde_json::from_str(line.trim()).map_err(|e| refuse(e.to_string()))?;
        if ticket.protocol != PROTOCOL {
            return Err(refuse(format!("it is for protocol {}, this plugin speaks {PROTOCOL}", ticket.protocol)));
        }
        check_name(&ticket.name)?;
        for partner in &ticket.partners {
            check_name(&partner.name)?;
        }
        ticket.run_id()?;
        Ok(ticket)
    }

    /// Identity of the run.
    ///
    /// # Errors
    /// [`BusError::BadTicket`].
    pub fn run_id(&self) -> Result<RunId, BusError> {
        run_from_hex(&self.run).ok_or_else(|| BusError::BadTicket { why: "its run is not 32 hex digits".to_owned() })
    }
}

/// Everything but the password, which must not reach a log.
impl fmt::Debug for Partner {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Partner").field("name", &self.name).field("endpoint", &self.endpoint).finish_non_exhaustive()
    }
}

/// Everything but the passwords.
impl fmt::Debug for JoinTicket {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("JoinTicket")
            .field("run", &self.run)
            .field("name", &self.name)
            .field("endpoint", &self.endpoint)
            .field("partners", &self.partners)
            .finish_non_exhaustive()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ticket() -> JoinTicket {
        JoinTicket {
            protocol: PROTOCOL,
            run: "00112233445566778899aabbccddeeff".to_owned(),
            name: "mpm".to_owned(),
            endpoint: "unixsock-stream//tmp/x/bus.sock".to_owned(),
            user: "mpm".to_owned(),
            password: "secret".to_owned(),
            threads: 2,
            partners: vec![
                Partner {
                    name: "a".to_owned(),
                    endpoint: "unixsock-stream//tmp/x/0-1".to_owned(),
                    door: Door::Enter("secret".to_owned()),
                },
                Partner {
                    name: "z".to_owned(),
                    endpoint: "unixsock-stream//tmp/x/1-2".to_owned(),
                    door: Door::Open("/tmp/x/1-2.users".to_owned()),
                },
            ],
            epoch: FIRST_EPOCH,
            checkpoints: None,
        }
    }

    #[test]
    fn a_ticket_is_one_line_and_survives_it() {
        let line = ticket().to_line();
        assert_eq!(line.matches('\n').count(), 1);
        assert_eq!(JoinTicket::from_line(&line).unwrap(), ticket());
    }

    #[test]
    fn the_password_is_not_shown() {
        assert!(!format!("{:?}", ticket()).contains("secret"));
    }

    #[test]
    fn another_protocol_and_a_broken_run_are_refused() {
        let other = JoinTicket { protocol: PROTOCOL + 1, ..ticket() };
        assert!(matches!(JoinTicket::from_line(&other.to_line()), Err(BusError::BadTicket { .. })));
        let broken = JoinTicket { run: "xyz".to_owned(), ..ticket() };
        assert!(matches!(JoinTicket::from_line(&broken.to_line()), Err(BusError::BadTicket { .. })));
        assert!(JoinTicket::from_line("").is_err());
    }
}
