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

/// Counters of the solvers of this project that say how much was done, not that anything went wrong;
/// `contact-unsettled` is judged as an estimate, by its share.
const WORK: [&str; 7] = [
    "contact-passes",
    "contact-places",
    "contact-unsettled",
    "contacts",
    "pressure-iterations",
    "sorts",
    "viscosity-iterations",
];
/// How counters begin that are no complaint: work that was done, and extremes, which estimates judge. Whatever else is
/// counted, by solvers of this project or by foreign ones, is a complaint.
const NO_COMPLAINT: [&str; 2] = ["work-", "largest"];

fn is_complaint(name: &str) -> bool {
    !WORK.contains(&name) && !NO_COMPLAINT.iter().any(|begin| name.starts_with(begin))
}

/// Clamps, quarantines, overflows and the like of a run: process, name and how many.
pub(crate) fn complaints(summary: &Summary) -> impl Iterator<Item = (&str, &str, u64)> {
    let all = summary.counters.iter().flat_map(|(process, counters)| counters.iter().map(move |c| (process, c)));
    let said = all.map(|(process, (name, times))| (process.as_str(), name.as_str(), *times));
    said.filter(|(_, name, times)| is_complaint(name) && *times > 0)
}

/// What a run says against itself, in words: red verdicts first, then complaints.
pub(crate) fn reported(summary: &Summary) -> Vec<String> {
    let red = summary.verdicts.iter().filter(|v| !v.passed);
    let red = red.map(|v| format!("verdict {} of {}: {:.2e} above {:.0e}", v.name, v.of, v.value, v.limit));
    let high = summary.estimates.iter().filter(|e| e.is_high).map(|e| format!("{}: {}", e.of, e.meaning));
    red.chain(high)
        .chain(complaints(summary).map(|(process, name, times)| format!("{process}: {times} {name}")))
        .collect()
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

    #[test]
    fn work_and_extremes_are_no_complaints() {
        let names = ["sorts", "work-of-a-stranger", "largest-overlap-1e-6-m", "stretch-clamps", "lost"];
        assert_eq!(names.map(is_complaint), [false, false, false, true, true]);
    }
}
