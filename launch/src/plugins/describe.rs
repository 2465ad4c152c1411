//! Asks a candidate what it is, and refuses what does not answer like a plugin.

use std::fmt;
use std::io;
use std::process::{ExitStatus, Stdio};
use std::time::Duration;

use cosplat_core::control::PROTOCOL;
use cosplat_core::plugin::Descriptor;
use rustix::process::{Pid, Signal, kill_process_group};
use tokio::io::{AsyncRead, AsyncReadExt as _};
use tokio::process::Command;
use tokio::time::timeout;

use super::built_in;
use super::discover::{Candidate, Origin};
use crate::exit::{Code, Error, Problem};
use crate::supervise::child::describe as describe_exit;

/// Time for an answer.
const PATIENCE: Duration = Duration::from_secs(5);
/// Longest answer.
const LARGEST_BYTES: u64 = 1 << 20;
/// Bytes of standard error that are looked at.
const STDERR_BYTES: u64 = 1 << 14;
/// Bytes of a wrong answer that are shown.
const SHOWN_BYTES: usize = 64;

/// Why a candidate is not taken for a plugin.
#[derive(Debug, thiserror::Error)]
pub(crate) enum Refusal {
    /// It cannot be started.
    #[error("it cannot be started: {0}")]
    Start(#[from] io::Error),
    /// It took too long.
    #[error("it gave no answer to `--describe` within {} s", PATIENCE.as_secs())]
    Silent,
    /// It would not stop talking.
    #[error("its answer to `--describe` is longer than {} MiB; it begins with {begin}", LARGEST_BYTES >> 20)]
    Endless {
        /// First bytes.
        begin: Shown,
    },
    /// It ended as if something were wrong.
    #[error("`--describe` ended with {how}{}", said(stderr.as_deref()))]
    Failed {
        /// Exit code or signal.
        how: String,
        /// Last line on standard error.
        stderr: Option<String>,
    },
    /// It said nothing.
    #[error("its answer to `--describe` is empty")]
    Empty,
    /// It answered something else.
    #[error("its answer to `--describe` is no descriptor: {why}; it begins with {begin}")]
    Garbage {
        /// What is wrong with it.
        why: String,
        /// First bytes.
        begin: Shown,
    },
    /// It calls itself something else.
    #[error("it calls itself `{theirs}`, but was found as `{ours}`")]
    Name {
        /// In its answer.
        theirs: String,
        /// By which it was found.
        ours: String,
    },
    /// Its name cannot be used.
    #[error("it calls itself {0}, but names are made of `a` to `z`, `0` to `9` and `-`")]
    BadName(Shown),
    /// It speaks other versions of the protocol.
    #[error("it speaks protocol {} to {}, this program {PROTOCOL}", .0[0], .0[1])]
    Protocol([u16; 2]),
}

fn said(stderr: Option<&str>) -> String {
    stderr.map_or_else(String::new, |line| format!(" and said: {line}"))
}

/// First bytes of something, readable and harmless.
#[derive(Debug, PartialEq, Eq)]
pub(crate) struct Shown(String);

impl Shown {
    fn new(bytes: &[u8]) -> Self {
        let cut = if bytes.len() > SHOWN_BYTES { "…" } else { "" };
        Self(format!("`{}`{cut}", bytes[..bytes.len().min(SHOWN_BYTES)].escape_ascii()))
    }
}

impl fmt::Display for Shown {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

impl Refusal {
    /// The refusal as an error of a command that needs the plugin.
    pub(crate) fn into_error(self, candidate: &Candidate) -> Error {
        let hint = match &self {
            Self::Protocol(_) => "install a plugin and a `cosplat` that share a protocol version",
            Self::Start(_) => "check that the program exists and may be executed",
            _ => "run it by hand with `--describe`; a plugin answers with its descriptor as JSON on standard output",
        };
        let problem = Problem::new(format!("The solver plugin `{}` cannot be used", candidate.name))
            .because(format!("found as: {}", candidate.place()))
            .because(&self)
            .hint(hint);
        Error::new(Code::Environment, problem)
    }
}

/// What a candidate says about itself.
///
/// # Errors
/// It does not answer like a plugin that can take part here.
pub(crate) async fn describe(candidate: &Candidate) -> Result<Descriptor, Refusal> {
    if candidate.origin == Origin::BuiltIn
        && let Some(plugin) = built_in::make(&candidate.name)
    {
        return Ok(plugin.describe());
    }
    let (answer, status, stderr) = ask(candidate, PATIENCE).await?;
    if !status.success() {
        let last = stderr.lines().rfind(|l| !l.trim().is_empty());
        let stderr = last.map(|l| l.chars().take(200).collect());
        return Err(Refusal::Failed { how: describe_exit(status), stderr });
    }
    check(candidate, &answer)
}

fn check(candidate: &Candidate, answer: &[u8]) -> Result<Descriptor, Refusal> {
    if answer.iter().all(u8::is_ascii_whitespace) {
        return Err(Refusal::Empty);
    }
    let descriptor: Descriptor = serde_json::from_slice(answer)
        .map_err(|e| Refusal::Garbage { why: e.to_string(), begin: Shown::new(answer) })?;
    let is_allowed = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '-';
    if descriptor.name.is_empty() || descriptor.name.len() > 48 || !descriptor.name.chars().all(is_allowed) {
        return Err(Refusal::BadName(Shown::new(descriptor.name.as_bytes())));
    }
    // A command of the scene may be given to a solver process of any name.
    if candidate.origin != Origin::Scene && descriptor.name != candidate.name {
        return Err(Refusal::Name { theirs: descriptor.name, ours: candidate.name.clone() });
    }
    if !(descriptor.protocol[0]..=descriptor.protocol[1]).contains(&PROTOCOL) {
        return Err(Refusal::Protocol(descriptor.protocol));
    }
    Ok(descriptor)
}

/// Ends a process group when dropped: a candidate that hangs, and whatever it has started.
struct Group(Option<Pid>);

impl Drop for Group {
    fn drop(&mut self) {
        if let Some(group) = self.0 {
            // It has most probably ended by itself.
            let _ = kill_process_group(group, Signal::KILL);
        }
    }
}

async fn ask(candidate: &Candidate, patience: Duration) -> Result<(Vec<u8>, ExitStatus, String), Refusal> {
    let Some((program, words)) = candidate.command.split_first() else {
        return Err(io::Error::from(io::ErrorKind::NotFound).into());
    };
    let mut command = Command::new(program);
    command.args(words).arg("--describe").stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
    let mut child = command.process_group(0).kill_on_drop(true).spawn()?;
    let group = Group(child.id().and_then(|id| i32::try_from(id).ok()).and_then(Pid::from_raw));
    let (stdout, stderr) = (child.stdout.take(), child.stderr.take());
    let answer = timeout(patience, async {
        let (answer, stderr) = tokio::join!(first_bytes(stdout, LARGEST_BYTES + 1), first_bytes(stderr, STDERR_BYTES));
        if answer.len() as u64 > LARGEST_BYTES {
            return Err(Refusal::Endless { begin: Shown::new(&answer) });
        }
        let status = child.wait().await?;
        Ok((answer, status, String::from_utf8_lossy(&stderr).into_owned()))
    })
    .await;
    drop(group);
    answer.map_err(|_| Refusal::Silent)?
}

/// Reads to the end, or that many bytes; what comes after stays unread.
async fn first_bytes(pipe: Option<impl AsyncRead + Unpin>, limit: u64) -> Vec<u8> {
    let mut bytes = Vec::new();
    if let Some(pipe) = pipe {
        // What was read before an error is the answer.
        let _ = pipe.take(limit).read_to_end(&mut bytes).await;
    }
    bytes
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;
    use std::time::Instant;

    fn shell(script: &str) -> Candidate {
        let words = ["/bin/sh", "-c", script].map(str::to_owned);
        Candidate::of_scene("mud", &words, Path::new("/"))
    }

    fn refusal(script: &str) -> String {
        let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build().unwrap();
        runtime.block_on(describe(&shell(script))).unwrap_err().to_string()
    }

    fn descriptor() -> serde_json::Value {
        serde_json::to_value(built_in::make("oscillator").unwrap().describe()).unwrap()
    }

    #[test]
    fn garbage_is_refused_with_its_first_bytes() {
        let text = refusal("printf 'hello\\033[2J'; seq 100");
        assert!(text.contains("no descriptor") && text.contains("`hello\\x1b[2J1\\n2\\n"), "{text}");
        assert!(refusal("true").contains("is empty"));
    }

    #[test]
    fn failures_are_refused_with_their_last_words() {
        let text = refusal("echo first >&2; echo 'no GPU here' >&2; exit 3");
        assert_eq!(text, "`--describe` ended with exit code 3 and said: no GPU here");
        assert!(refusal("kill -9 $$").contains("signal 9 (SIGKILL)"));
    }

    #[test]
    fn an_endless_answer_is_cut_off() {
        let started = Instant::now();
        let text = refusal("yes");
        assert!(text.contains("longer than 1 MiB") && text.contains("`y\\ny\\n"), "{text}");
        assert!(started.elapsed() < PATIENCE);
    }

    #[test]
    fn a_silent_candidate_is_ended_with_its_children() {
        let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build().unwrap();
        let place = tempfile::tempdir().unwrap();
        let script = format!("sleep 1000 & echo $! > {}/pid; wait", place.path().display());
        let asked = runtime.block_on(async { ask(&shell(&script), Duration::from_millis(300)).await });
        assert!(matches!(asked, Err(Refusal::Silent)));
        let pid: i32 = std::fs::read_to_string(place.path().join("pid")).unwrap().trim().parse().unwrap();
        let gone = || {
            // An orphan is reaped by whoever adopts it, so it may be seen as a zombie for a while.
            std::fs::read_to_string(format!("/proc/{pid}/stat")).map_or(true, |s| s.contains(") Z "))
        };
        (0..100).find(|_| {
            std::thread::sleep(Duration::from_millis(10));
            gone()
        });
        assert!(gone());
    }

    #[test]
    fn names_and_protocols_must_fit() {
        let found = Candidate { origin: Origin::File("/x".into()), ..shell("") };
        let answer = |value: &serde_json::Value| check(&found, value.to_string().as_bytes());
        assert!(matches!(answer(&descriptor()), Err(Refusal::Name { .. })));
        let mut other = descriptor();
        other["name"] = "mud".into();
        assert!(answer(&other).is_ok());
        other["protocol"] = serde_json::json!([PROTOCOL + 1, PROTOCOL + 3]);
        assert!(answer(&other).unwrap_err().to_string().contains(&format!("this program {PROTOCOL}")));
        other["name"] = "../x".into();
        assert!(matches!(answer(&other), Err(Refusal::BadName(_))));
    }
}
