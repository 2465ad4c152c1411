//! Keys of a run. One prefix per run, so that processes left over from another run cannot be heard.

use std::fmt::Write as _;

use cosplat_core::control::RunId;

use crate::error::BusError;

/// Hexadecimal text of a run's identity.
pub fn run_to_hex(run: &RunId) -> String {
    run.iter().fold(String::with_capacity(32), |mut text, byte| {
        // Writing to a string cannot fail.
        let _ = write!(text, "{byte:02x}");
        text
    })
}

/// Reads what [`run_to_hex`] wrote.
pub fn run_from_hex(text: &str) -> Option<RunId> {
    if text.len() != 32 || !text.bytes().all(|b| b.is_ascii_hexdigit()) {
        return None;
    }
    u128::from_str_radix(text, 16).ok().map(u128::to_be_bytes)
}

/// Key expressions of one run.
#[derive(Clone, Debug)]
pub struct Keys {
    prefix: String,
}

impl Keys {
    /// Keys of that run.
    pub fn new(run: &RunId) -> Self {
        Self { prefix: format!("cosplat/v1/{}", run_to_hex(run)) }
    }

    /// What a participant says to the coordinator.
    pub fn ack(&self, participant: &str) -> String {
        format!("{}/ack/{participant}", self.prefix)
    }

    /// What the coordinator says to a participant.
    pub fn ctl(&self, participant: &str) -> String {
        format!("{}/ctl/{participant}", self.prefix)
    }

    /// Requests to a participant to send something again.
    pub fn resend(&self, participant: &str) -> String {
        format!("{}/resend/{participant}", self.prefix)
    }

    /// Presence of a participant.
    pub fn live(&self, participant: &str) -> String {
        format!("{}/live/{participant}", self.prefix)
    }

    /// A stream of the plan.
    pub fn stream(&self, key: &str) -> String {
        format!("{}/{key}", self.prefix)
    }
}

/// Checks a participant's name: it is a user name, part of keys and part of a colon-separated file.
pub(crate) fn check_name(name: &str) -> Result<(), BusError> {
    let fits = |b: u8| b.is_ascii_alphanumeric() || b == b'-' || b == b'_' || b == b'.';
    if name.is_empty() || name.len() > 64 || !name.bytes().all(fits) {
        return Err(BusError::Name {
            name: name.to_owned(),
            why: "use 1 to 64 letters, digits, `-`, `_` or `.`".to_owned(),
        });
    }
    Ok(())
}

/// Checks a stream's key below the run's prefix: plain, canonical, no wildcard.
pub(crate) fn check_stream(key: &str) -> Result<(), BusError> {
    let refuse = |why: String| BusError::Name { name: key.to_owned(), why };
    let parsed = zenoh::key_expr::KeyExpr::try_from(key).map_err(|e| refuse(e.to_string()))?;
    if parsed.is_wild() {
        return Err(refuse("it contains a wildcard".to_owned()));
    }
    let reserved = key.split('/').next().is_some_and(|head| ["ack", "ctl", "resend", "live"].contains(&head));
    if reserved {
        return Err(refuse("its first part is kept for the protocol".to_owned()));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_run_survives_its_text() {
        let run: RunId = [0, 1, 2, 3, 0xff, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 0xa0];
        assert_eq!(run_from_hex(&run_to_hex(&run)), Some(run));
        assert_eq!(run_from_hex("+0010203040506070809101112131415"), None);
    }

    #[test]
    fn names_that_would_change_a_key_or_the_password_file_are_refused() {
        for bad in ["", "a/b", "a:b", "*", "a b", "a\n", "$x", "ä"] {
            assert!(check_name(bad).is_err(), "{bad:?}");
        }
        assert!(check_name("rigid-lite_2").is_ok());
        for bad in ["b/*", "b//x", "/b", "ack/other", "b/$*", "b/x?y"] {
            assert!(check_stream(bad).is_err(), "{bad:?}");
        }
        assert!(check_stream("b/mpm/wolf").is_ok());
    }
}
