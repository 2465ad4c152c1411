//! Other programs that make more of a run: the viewer and the maker of films. No run needs them.

use std::io::{self, Read as _};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use super::Check;

/// Version of the recordings that a run writes: that of the rerun crate in `Cargo.toml`.
const RERUN: &str = "0.36.3";
/// A program that has not said its version after this long is taken as broken.
const PATIENCE: Duration = Duration::from_secs(5);
/// How often it is looked whether a program has ended.
const GLANCE: Duration = Duration::from_millis(10);

/// The viewer of recordings.
pub(super) fn rerun() -> Check {
    judge_rerun(version("rerun", "--version"))
}

fn judge_rerun(said: io::Result<String>) -> Check {
    const NAME: &str = "rerun viewer";
    let mend = format!("`cargo install rerun-cli --locked --version {RERUN}` or `pip install rerun-sdk=={RERUN}`");
    match said {
        Err(error) => Check::lacking(NAME, format!("recordings cannot be opened: {}", absent("rerun", &error)), mend),
        Ok(line) => {
            let found = line.split_whitespace().find(|word| word.starts_with(|c: char| c.is_ascii_digit()));
            // Only within a minor version is it sure that the viewer reads what the crate writes.
            let minor = |version: &str| version.split('.').take(2).map(str::to_owned).collect::<Vec<_>>();
            match found {
                Some(found) if minor(found) == minor(RERUN) => Check::good(NAME, found),
                _ => Check::lacking(NAME, format!("it is `{line}`, and recordings are of {RERUN}"), mend),
            }
        }
    }
}

/// The maker of films from pictures.
pub(super) fn ffmpeg() -> Check {
    const NAME: &str = "ffmpeg";
    match version("ffmpeg", "-version") {
        Ok(line) => Check::good(NAME, line.split(" Copyright").next().unwrap_or(&line)),
        Err(error) => {
            let found = format!("pictures cannot become a film: {}", absent("ffmpeg", &error));
            Check::lacking(NAME, found, "`sudo apt install ffmpeg`, or what your system has in its place")
        }
    }
}

fn absent(program: &str, error: &io::Error) -> String {
    if error.kind() == io::ErrorKind::NotFound {
        format!("there is no `{program}` on the path")
    } else {
        format!("`{program}` does not work: {error}")
    }
}

/// The first line that a program says about its version.
fn version(program: &str, flag: &str) -> io::Result<String> {
    let quiet = || Stdio::null();
    let mut child = Command::new(program).arg(flag).stdin(quiet()).stdout(Stdio::piped()).stderr(quiet()).spawn()?;
    let start = Instant::now();
    let status = loop {
        match child.try_wait()? {
            Some(status) => break status,
            None if start.elapsed() < PATIENCE => std::thread::sleep(GLANCE),
            None => {
                child.kill()?;
                child.wait()?;
                return Err(io::Error::other(format!("it says nothing within {} s", PATIENCE.as_secs())));
            }
        }
    };
    let mut text = Vec::new();
    if let Some(out) = child.stdout.take() {
        // A version is a few lines; whatever else comes is not waited for.
        out.take(1 << 16).read_to_end(&mut text)?;
    }
    let text = String::from_utf8_lossy(&text);
    match text.lines().next() {
        Some(line) if status.success() => Ok(line.trim().to_owned()),
        _ => Err(io::Error::other(format!("it ends with {status}"))),
    }
}

#[cfg(test)]
mod tests {
    use super::super::Status;
    use super::*;

    #[test]
    fn the_viewer_must_be_of_the_version_of_the_recordings() {
        let manifest = include_str!("../../../../Cargo.toml");
        assert!(manifest.contains(&format!("rerun = {{ version = \"={RERUN}\"")), "the crate has another version");
        let status = |line: &str| judge_rerun(Ok(line.to_owned())).status;
        assert_eq!(status("rerun-cli 0.36.3 [rustc 1.95.0, LLVM 21] x86_64-unknown-linux-gnu"), Status::Good);
        assert_eq!(status("rerun-cli 0.36.9"), Status::Good);
        assert_eq!(status("rerun-cli 0.35.0"), Status::Lacking);
        assert_eq!(status("something else"), Status::Lacking);
        let missing = judge_rerun(Err(io::Error::from(io::ErrorKind::NotFound)));
        assert!(missing.mend.is_some_and(|mend| mend.contains(RERUN)));
    }

    #[test]
    fn programs_are_asked_once_and_never_waited_for_long() {
        assert_eq!(version("echo", "1.2.3").unwrap(), "1.2.3");
        assert!(version("false", "x").is_err());
        assert_eq!(version("no-such-program-anywhere", "x").unwrap_err().kind(), io::ErrorKind::NotFound);
    }
}
