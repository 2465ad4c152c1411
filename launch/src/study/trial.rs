//! One run of a study: `cosplat run` as a process of its own, or what an earlier one has left.

use std::fs;
use std::path::{Path, PathBuf};
use std::pin::pin;
use std::process::Stdio;

use rustix::process::{Pid, Signal, kill_process};
use serde::{Deserialize, Serialize};
use serde_json::Value;
use tokio::process::Command;
use tokio::sync::watch;

use super::outcome::{Class, complaints};
use crate::exit::{Code, Error};
use crate::folder::curves::Table;
use crate::folder::summary::Summary;
use crate::folder::{PROBES, SUMMARY};

/// What a run has left behind.
#[derive(Clone, Debug)]
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
    /// Whether other runs were made beside it, so that its times are not its own.
    #[serde(default)]
    pub(crate) beside_others: bool,
}

/// A run that is wanted.
#[derive(Clone, Debug)]
pub(crate) struct Order {
    /// Scene file or name of a built-in scene.
    pub(crate) scene: String,
    /// Changes of the scene, as `--set` takes them.
    pub(crate) overrides: Vec<String>,
    /// Its run folder.
    pub(crate) place: PathBuf,
    /// Threads that it may use, where other runs are made beside it.
    pub(crate) share: Option<usize>,
}

impl Trial {
    /// How it counts.
    pub(crate) fn class(&self) -> Class {
        let class = Class::of(self.end.code, self.summary.as_ref().map_or(0, |s| complaints(s).map(|c| c.2).sum()));
        let has_result = self.summary.is_some();
        if matches!(class, Class::Correct | Class::Degraded) && !has_result { Class::Failed } else { class }
    }

    /// What an earlier study has left, where that is the end of this run for good. Times that are not a run's own are
    /// none where it shall be alone.
    pub(crate) fn kept(folder: &Path, alone: bool) -> Option<Self> {
        let end: End = serde_json::from_slice(&fs::read(end_file(folder)).ok()?).ok()?;
        (!alone || !end.beside_others).then(|| Self::read(folder, end, true))
    }

    fn read(folder: &Path, end: End, cached: bool) -> Self {
        let summary = fs::read(folder.join(SUMMARY)).ok().and_then(|text| serde_json::from_slice(&text).ok());
        Self { end, summary, probes: Table::read(&folder.join(PROBES), 0).unwrap_or_default(), cached }
    }
}

/// Makes a run; none where the user has stopped it, which `stopped` tells.
///
/// # Errors
/// This program cannot start itself, or the folder cannot be written.
pub(crate) async fn run(order: Order, mut stopped: watch::Receiver<u32>) -> Result<Option<Trial>, Error> {
    let folder = order.place.as_path();
    let above = folder.parent().unwrap_or(folder);
    fs::create_dir_all(above).map_err(|e| Error::io("create", above, &e))?;
    let program = std::env::current_exe().map_err(|e| Error::io("find", Path::new("cosplat"), &e))?;
    let cannot = |e: &std::io::Error| Error::io("start", &program, e);
    let mut command = Command::new(&program);
    command.args(["run", &order.scene, "--quiet", "--format", "json", "--ends-with-parent", "--out"]).arg(folder);
    for change in &order.overrides {
        command.args(["--set", change]);
    }
    if let Some(threads) = order.share {
        command.args(["--threads", &threads.to_string()]);
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
            Ok(()) = stopped.changed() => {
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
    let why = complaint(&output.stdout, &output.stderr, code);
    let end = End { code, why, beside_others: order.share.is_some() };
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
