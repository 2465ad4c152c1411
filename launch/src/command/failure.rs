//! Why a run ended early, for people: the cause first, then its last words, then what to do.

use cosplat_core::coordinator::Failure;
use cosplat_core::plan::Plan;

use crate::exit::{Code, Error, Problem};
use crate::folder::RunFolder;

/// Lines of standard error that are shown; the log has them all.
const SHOWN_LINES: usize = 20;

/// The failure as an error. `last_words` has the last lines of each process on standard error, in plan order.
pub(crate) fn explain(failure: &Failure, plan: &Plan, folder: &RunFolder, last_words: &[Vec<String>]) -> Error {
    let (code, culprits, hint): (_, Vec<&str>, String) = match failure {
        Failure::Unsupported { who, .. } => {
            (Code::Scene, vec![who], "change the scene, or give its bodies another plugin with `--solver`".into())
        }
        Failure::Physics { who, .. } => {
            let hint = "a smaller `clock.window`, a finer spacing or a softer material may help; `ledger.csv` shows how it went there";
            (Code::Physics, vec![who], hint.into())
        }
        Failure::Environment { who, .. } => {
            (Code::Environment, vec![who], "make room on the disk, or choose another folder with `--out DIR`".into())
        }
        Failure::Died { who, how, .. } => (Code::Process, vec![who], after_death(how)),
        Failure::Silent { who, .. } => {
            let hint = "if it only needs longer between two signs of life, raise `run.silence_limit` in the scene";
            (Code::Process, vec![who], hint.into())
        }
        Failure::Deadlock { .. } => {
            let all = plan.participants.iter().map(|p| p.name.as_str()).collect();
            (Code::Process, all, "this is a mistake in a plugin or in `cosplat`; please report it with the logs".into())
        }
        Failure::Missing { who, .. } => {
            let hint = "its log may say why; start fewer processes at once if this machine is busy";
            (Code::Process, who.iter().map(String::as_str).collect(), hint.into())
        }
        Failure::Version { who, .. } => {
            (Code::Process, vec![who], "install a plugin and a `cosplat` that share a protocol version".into())
        }
        Failure::Protocol { who, .. } => {
            (Code::Process, vec![who], "this is a mistake in that plugin or in `cosplat`; please report it".into())
        }
    };
    let mut problem = Problem::new(upper_first(&failure.to_string()));
    for who in culprits {
        let words = plan.participant(who).and_then(|id| last_words.get(usize::from(id)));
        let words = words.map_or(&[][..], Vec::as_slice);
        // What a plugin gave as its reason is in the message; only what nobody foresaw is worth its last words.
        if code == Code::Process && !words.is_empty() {
            problem = problem.because(format!("last words of `{who}`:"));
            for line in &words[words.len().saturating_sub(SHOWN_LINES)..] {
                problem = problem.because(format!("  | {line}"));
            }
        }
        problem = problem.because(format!("log: {}", folder.file(&RunFolder::log_name(who)).display()));
    }
    Error::new(code, problem.hint(hint))
}

fn after_death(how: &str) -> String {
    if how.contains("SIGKILL") {
        "somebody killed it, or the system did because memory ran out; the system's log says which".into()
    } else if how.contains("signal") {
        "this is a mistake in that plugin; please report it with its log".into()
    } else {
        "its log says why".into()
    }
}

fn upper_first(text: &str) -> String {
    let mut letters = text.chars();
    letters.next().map_or_else(String::new, |first| first.to_uppercase().chain(letters).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::folder::fixtures::plan;

    fn explained(failure: &Failure) -> Error {
        let place = tempfile::tempdir().unwrap();
        let folder = RunFolder::claim(place.path()).unwrap();
        explain(failure, &plan(3), &folder, &[vec!["left's words".into()], (0..40).map(|i| format!("{i}")).collect()])
    }

    #[test]
    fn a_death_is_told_with_the_words_of_the_dead() {
        let how = "signal 9 (SIGKILL)".to_owned();
        let error = explained(&Failure::Died { who: "right".into(), window: 4, how });
        assert_eq!(error.code, Code::Process);
        let problem = &error.problems[0];
        assert!(problem.message.starts_with("Solver `right` ended unexpectedly in window 4"), "{problem:?}");
        assert_eq!(problem.details.len(), 1 + SHOWN_LINES + 1);
        assert!(problem.details.iter().any(|d| d == "  | 39") && !problem.details.iter().any(|d| d.contains("left")));
        assert!(problem.details.last().unwrap().ends_with("logs/right.txt"));
        assert!(problem.hint.as_ref().unwrap().contains("memory"));
    }

    #[test]
    fn every_failure_has_its_code() {
        let who = || "left".to_owned();
        let message = || "m".to_owned();
        let code = |f: Failure| explained(&f).code;
        assert_eq!(code(Failure::Unsupported { who: who(), message: message() }), Code::Scene);
        assert_eq!(code(Failure::Physics { who: who(), window: 1, message: message() }), Code::Physics);
        assert_eq!(code(Failure::Protocol { who: who(), window: 1, message: message() }), Code::Process);
        assert_eq!(code(Failure::Version { who: who(), theirs: message(), ours: 1 }), Code::Process);
        assert_eq!(code(Failure::Missing { who: vec![who()], seconds: 3, phase: message() }), Code::Process);
    }
}
