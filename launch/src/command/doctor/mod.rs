//! `cosplat doctor`: what this machine lacks, and the command that mends it.

mod machine;
mod programs;

use std::path::PathBuf;

use clap::Args;
use serde::Serialize;

use crate::cli::Format;
use crate::exit::{Code, Error};
use crate::render::{Paint, json, print, printable};

/// `cosplat doctor`.
#[derive(Clone, Debug, Args)]
pub(crate) struct DoctorArgs {
    /// Folder in which runs will be written
    #[arg(long, value_name = "DIR", default_value = "out")]
    pub(crate) out: PathBuf,
    /// Form of the answer on standard output
    #[arg(long, value_enum, default_value_t)]
    pub(crate) format: Format,
}

/// How a check ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
enum Status {
    /// As it should be.
    Good,
    /// Runs work, with less than there could be.
    Lacking,
    /// Runs do not work.
    Broken,
}

/// A check and what came of it.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
struct Check {
    /// What was looked at.
    name: &'static str,
    status: Status,
    /// What was found.
    found: String,
    /// What to do; a command where one mends it.
    #[serde(skip_serializing_if = "Option::is_none")]
    mend: Option<String>,
}

impl Check {
    fn good(name: &'static str, found: impl Into<String>) -> Self {
        Self { name, status: Status::Good, found: found.into(), mend: None }
    }

    fn lacking(name: &'static str, found: impl Into<String>, mend: impl Into<String>) -> Self {
        Self { name, status: Status::Lacking, found: found.into(), mend: Some(mend.into()) }
    }

    fn broken(name: &'static str, found: impl Into<String>, mend: impl Into<String>) -> Self {
        Self { name, status: Status::Broken, found: found.into(), mend: Some(mend.into()) }
    }
}

/// What was found on this machine.
#[derive(Debug, Serialize)]
struct Findings {
    status: &'static str,
    version: &'static str,
    checks: Vec<Check>,
}

/// Looks at this machine. The exit code says whether runs work.
///
/// # Errors
/// The findings cannot be printed.
pub(crate) fn doctor(args: &DoctorArgs) -> Result<Code, Error> {
    let checks = vec![
        machine::processors(),
        machine::memory(),
        machine::disk(&args.out),
        machine::sockets(),
        machine::open_files(),
        programs::rerun(),
        programs::ffmpeg(),
    ];
    let works = checks.iter().all(|c| c.status != Status::Broken);
    let status = if works { "ok" } else { "failed" };
    let findings = Findings { status, version: env!("CARGO_PKG_VERSION"), checks };
    match args.format {
        Format::Json => print(&json(&findings)?)?,
        Format::Human => print(&findings.human(Paint::stdout()))?,
    }
    Ok(if works { Code::Ok } else { Code::Environment })
}

impl Findings {
    fn human(&self, paint: Paint) -> String {
        let width = self.checks.iter().map(|c| c.name.len()).max().unwrap_or(0);
        let head = format!("{} {}\n", paint.bold("cosplat"), self.version);
        let lines = self.checks.iter().map(|Check { name, status, found, mend }| {
            let mark = match status {
                Status::Good => paint.good("good   "),
                Status::Lacking => paint.warn("lacking"),
                Status::Broken => paint.bad("broken "),
            };
            let mend = mend
                .as_ref()
                .map(|mend| format!("           {:<width$}  {} {}\n", "", paint.cyan("mend:"), printable(mend)));
            format!("  {mark}  {name:<width$}  {}\n{}", printable(found), mend.unwrap_or_default())
        });
        [head].into_iter().chain(lines).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn findings_say_how_to_mend_what_is_not_good() {
        let checks = vec![Check::good("one", "fine"), Check::lacking("three", "is\x1b missing", "install it")];
        let findings = Findings { status: "ok", version: "0", checks };
        let text = findings.human(Paint::off());
        assert!(text.contains("good     one    fine\n"), "{text}");
        assert!(text.contains("lacking  three  is  missing\n") && text.contains("mend: install it"), "{text}");
    }

    #[test]
    fn a_machine_that_runs_this_test_is_healthy_enough_to_ask() {
        let place = tempfile::tempdir().unwrap();
        let all = [machine::processors(), machine::memory(), machine::disk(place.path()), machine::sockets()];
        for check in all.into_iter().chain([machine::open_files(), programs::rerun(), programs::ffmpeg()]) {
            assert_eq!(check.status == Status::Good, check.mend.is_none(), "{check:?}");
            assert!(!check.found.is_empty(), "{check:?}");
        }
    }
}
