//! How a run of a study ended, by whether it can be believed.

use serde::{Deserialize, Serialize};

use crate::folder::summary::Summary;

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

/// Counters of the solvers of this project that say how much was done, not that anything went wrong. Whatever else is
/// counted, by these solvers or by foreign ones, is a complaint.
const WORK: [&str; 5] = ["boundary-particles", "contact-passes", "contact-places", "largest-compression-1e-6", "sorts"];

/// Clamps, quarantines, overflows and the like of a run.
pub(crate) fn complaints(summary: &Summary) -> u64 {
    let all = summary.counters.values().flatten();
    all.filter(|(name, _)| !WORK.contains(&name.as_str())).map(|(_, times)| times).sum()
}

impl Class {
    /// The class of an exit code (see the README) of a run that has so many complaints.
    pub(crate) fn of(code: u8, complaints: u64) -> Self {
        match code {
            0 if complaints == 0 => Self::Correct,
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
