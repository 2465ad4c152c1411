//! How the program ends: exit codes, and the error that every command reports.

use std::fmt;
use std::io;
use std::path::Path;
use std::process::ExitCode;

use serde::Serialize;

/// Exit codes. They are part of the interface: scripts may rely on them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub(crate) enum Code {
    /// Everything went as asked.
    Ok = 0,
    /// The command line makes no sense.
    Usage = 2,
    /// The scene, or a file named by it or by the command line, cannot be used.
    Scene = 3,
    /// The physics left the range in which a result means anything.
    Physics = 4,
    /// A solver process died, fell silent or broke the protocol, or the bus failed.
    Process = 5,
    /// This machine lacks something: a plugin, a permission, space.
    Environment = 6,
    /// The run ended, but a verdict says that its result is not to be trusted.
    Verdict = 7,
    /// Stopped by the user.
    Interrupted = 130,
}

impl From<Code> for ExitCode {
    fn from(code: Code) -> Self {
        Self::from(code as u8)
    }
}

/// One thing that went wrong: what, where, why, what to do.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
pub(crate) struct Problem {
    /// What, as one sentence without a full stop.
    pub(crate) message: String,
    /// File or folder it is about.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) file: Option<String>,
    /// Line in the file, from 1.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) line: Option<usize>,
    /// Character in the line, from 1.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) column: Option<usize>,
    /// Place in the scene, as in `body[2].material.density`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) field: Option<String>,
    /// Why, one line each.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub(crate) details: Vec<String>,
    /// What to do.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) hint: Option<String>,
    /// The problem with the lines of the file it is about, ready for a terminal.
    #[serde(skip)]
    pub(crate) drawn: Option<String>,
}

impl Problem {
    /// A problem of which only the message is known yet.
    pub(crate) fn new(message: impl Into<String>) -> Self {
        Self { message: message.into(), ..Self::default() }
    }

    /// Adds the file or folder it is about.
    #[must_use]
    pub(crate) fn at(mut self, path: &Path) -> Self {
        self.file = Some(path.display().to_string());
        self
    }

    /// Adds a line that says why.
    #[must_use]
    pub(crate) fn because(mut self, detail: impl fmt::Display) -> Self {
        self.details.push(detail.to_string());
        self
    }

    /// Adds what to do.
    #[must_use]
    pub(crate) fn hint(mut self, hint: impl Into<String>) -> Self {
        self.hint = Some(hint.into());
        self
    }
}

/// Why a command could not do what it was asked.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Error {
    /// Exit code.
    pub(crate) code: Code,
    /// All problems found, the most important first.
    pub(crate) problems: Vec<Problem>,
}

impl Error {
    /// An error of one problem.
    pub(crate) fn new(code: Code, problem: Problem) -> Self {
        Self { code, problems: vec![problem] }
    }

    /// A file or folder of this program could not be read or written.
    pub(crate) fn io(doing: &str, path: &Path, error: &io::Error) -> Self {
        let mut problem = Problem::new(format!("Cannot {doing} `{}`", path.display())).at(path).because(error);
        problem.hint = match error.kind() {
            io::ErrorKind::StorageFull => Some("free some space, or choose another disk with `--out DIR`".into()),
            _ => Some("choose a folder that you may write to with `--out DIR`".into()),
        };
        Self::new(Code::Environment, problem)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn codes_are_what_the_help_says() {
        let codes =
            [Code::Ok, Code::Usage, Code::Scene, Code::Physics, Code::Process, Code::Environment, Code::Verdict];
        assert_eq!(codes.map(|c| c as u8), [0, 2, 3, 4, 5, 6, 7]);
        assert_eq!(Code::Interrupted as u8, 130);
        for code in codes.into_iter().chain([Code::Interrupted]) {
            let listed = crate::cli::EXIT_CODES.lines().any(|l| l.trim_start().starts_with(&(code as u8).to_string()));
            assert!(listed, "{code:?} is not in the help");
        }
    }
}
