//! One run of a study: `cosplat run` as a process of its own, or what an earlier one has left.

use std::fs;
use std::path::Path;
use std::pin::pin;
use std::process::Stdio;

use rustix::process::{Pid, Signal, kill_process};
use serde::{Deserialize, Serialize};
use serde_json::Value;
use tokio::process::Command;

use super::outcome::{Class, complaints};
use crate::exit::{Code, Error};
use crate::folder::curves::Table;
use crate::folder::summary::Summary;
use crate::folder::{PROBES, SUMMARY};
use crate::supervise::signals::Signals;

/// What a run has left behind.
#[derive(Debug)]
pub(crate) struct Trial {
    /// How it ended.
    pub(crate) end: End,
    /// Its summary, where it has one.
    pub(crate) summary: Option<Summary>,
    /// Its probes; empty where it has none.
    pub(crate) probes: Table,
    /// Whether it was not run now.
    pub(crate) cached: bool,
}

/// How a run ended, as it is kept beside its folder.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct End {
    /// Exit code of `cosplat run`; 255 where a signal ended it.
    pub(crate) code: u8,
    /// What it complained about first.
    pub(crate) why: Option<String>,
}

impl Trial {
    /// How it counts.
    pub(crate) fn class(&self) -> Class {
        let class = Class::of(self.end.code, self.summary.as_ref().map_or(0, |s| complaints(s).map(|c| c.2).sum()));
        let has_result = self.summary.is_some();
        if matches!(class, Class::Correct | Class::Degraded) && !has_result { Class::Failed } else { class }
    }

    /// What an earlier study has left, where that is the end of this run for good.
    pub(crate) fn kept(folder: &Path) -> Option<Self> {
        let end: End = serde_json::from_slice(&fs::read(end_file(folder)).ok()?).ok()?;
        Some(Self::read(folder, end, true))
    }

    fn read(folder: &Path, end: End, cached: bool) -> Self {
        let summary = fs::read(folder.join(SUMMARY)).ok().and_then(|text| serde_json::from_slice(&text).ok());
        Self { end, summary, probes: Table::read(&folder.join(PROBES), 0).unwrap_or_default(), cached }
    }
}

/// Runs a scene into a folder; none where the user has stopped it.
///
/// # Errors
/// This program cannot start itself, or the folder cannot be written.
pub(crate) async fn run(
    scene: &str,
    overrides: &[String],
    folder: &Path,
    signals: &mut Signals,
) -> Result<Option<Trial>, Error> {
    let program = std::env::current_exe().map_err(|e| Error::io("find", Path::new("cosplat"), &e))?;
    let cannot = |e: &std::io::Error| Error::io("start", &program, e);
    let mut command = Command::new(&program);
    command.args(["run", scene, "--quiet", "--format", "json", "--ends-with-parent", "--out"]).arg(folder);
    for change in overrides {
        command.args(["--set", change]);
    }
    // A process group of its own: Ctrl-C on the terminal reaches this program only, which passes it on once.
    command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped()).process_group(0).kill_on_drop(true);
    let child = command.spawn().map_err(|e| cannot(&e))?;
    let pid = child.id().and_then(|id| i32::try_from(id).ok()).and_then(Pid::from_raw);
    let mut ended = pin!(child.wait_with_output());
    let mut was_asked = false;
    let output = loop {
        tokio::select! {
            output = &mut ended => break output.map_err(|e| cannot(&e))?,
            _ = signals.next() => {
                was_asked = true;
                // It may have ended by itself, which is what was wanted.
                let _ = pid.map(|pid| kill_process(pid, Signal::INT));
            }
        }
    };
    if was_asked {
        return Ok(None);
    }
    let code = output.status.code().and_then(|code| u8::try_from(code).ok()).unwrap_or(u8::MAX);
    let end = End { code, why: complaint(&output.stdout, &output.stderr, code) };
    // Deaths, what this machine lacks and folders that are in use may be others next time.
    let is_final = [Code::Ok, Code::Physics, Code::Verdict].iter().any(|c| *c as u8 == code);
    if is_final {
        let file = end_file(folder);
        let text = serde_json::to_vec(&end).unwrap_or_default();
        fs::write(&file, text).map_err(|e| Error::io("write", &file, &e))?;
    }
    Ok(Some(Trial::read(folder, end, false)))
}

/// Beside the run folder, because a run that is refused makes none.
fn end_file(folder: &Path) -> std::path::PathBuf {
    folder.with_extension("json")
}

/// The first thing that a run complained about.
fn complaint(stdout: &[u8], stderr: &[u8], code: u8) -> Option<String> {
    if code == 0 {
        return None;
    }
    let answer: Value = serde_json::from_slice(stdout).unwrap_or_default();
    let text = |value: &Value| value.as_str().filter(|t| !t.is_empty()).map(str::to_owned);
    let verdict = || {
        let failed = answer["verdicts"].as_array()?.iter().find(|v| v["passed"] == false)?;
        Some(format!("verdict {} of {}: {}", failed["name"].as_str()?, failed["of"].as_str()?, failed["value"]))
    };
    let last_words = || {
        let words = String::from_utf8_lossy(stderr);
        words.lines().find(|line| !line.trim().is_empty()).map(str::to_owned)
    };
    text(&answer["failure"]).or_else(|| text(&answer["problems"][0]["message"])).or_else(verdict).or_else(last_words)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_complaint_is_found_wherever_it_stands() {
        let of = |out: &str, err: &str| complaint(out.as_bytes(), err.as_bytes(), 3);
        assert_eq!(of(r#"{"problems":[{"message":"no scene"}]}"#, "x").as_deref(), Some("no scene"));
        assert_eq!(of(r#"{"failure":"left died","verdicts":[]}"#, "x").as_deref(), Some("left died"));
        let verdict = r#"{"failure":null,"verdicts":[{"name":"closure","of":"a","value":2,"passed":false}]}"#;
        assert_eq!(of(verdict, "").as_deref(), Some("verdict closure of a: 2"));
        assert_eq!(of("", "\nlost\n").as_deref(), Some("lost"));
        assert_eq!(complaint(b"{}", b"warning", 0), None);
    }
}
