//! How a run of a study ended, by whether it can be believed.

use serde::{Deserialize, Serialize};

/// Classes of outcomes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum Class {
    /// The run ended and had nothing to complain about. Whether it is *right* is for its error to say.
    Correct,
    /// The run ended and says itself that it is not to be trusted, or that it has clamped or lost something.
    Degraded,
    /// The run was refused with a reason, before it began or when the physics left the range of meaning.
    Refused,
    /// A process died or fell silent, or the result cannot be read.
    Failed,
}

/// Names of the classes, for files.
pub(crate) const CLASSES: [(&str, Class); 4] = [
    ("correct", Class::Correct),
    ("degraded", Class::Degraded),
    ("refused", Class::Refused),
    ("failed", Class::Failed),
];

impl Class {
    /// The class of an exit code (see the README) of a run that has counted so many clamps and the like.
    pub(crate) fn of(code: u8, counters: u64) -> Self {
        match code {
            0 if counters == 0 => Self::Correct,
            0 | 7 => Self::Degraded,
            2 | 3 | 4 | 6 => Self::Refused,
            _ => Self::Failed,
        }
    }

    /// As it is called in files and on pages.
    pub(crate) fn word(self) -> &'static str {
        CLASSES.iter().find(|(_, class)| *class == self).map_or("", |(word, _)| word)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exit_codes_have_their_class() {
        let classes = [0, 7, 3, 4, 6, 5, 130].map(|code| Class::of(code, 0).word());
        assert_eq!(classes, ["correct", "degraded", "refused", "refused", "refused", "failed", "failed"]);
        assert_eq!(Class::of(0, 3), Class::Degraded);
    }
}
