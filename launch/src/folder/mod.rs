//! The run folder: everything a run leaves behind, readable after a kill at any moment.
//!
//! Tables grow by whole lines that are handed to the system at every window. Files that only make sense as a whole
//! (`run.toml`, `summary.json`) are written beside their place and renamed into it.

pub(crate) mod checkpoints;
pub(crate) mod curves;
#[cfg(test)]
pub(crate) mod fixtures;
mod foreseen;
pub(crate) mod ledger;
pub(crate) mod probes;
pub(crate) mod record;
pub(crate) mod recorder;
pub(crate) mod report;
pub(crate) mod summary;
pub(crate) mod tally;
pub(crate) mod trace;

use std::fs::{self, File};
use std::io::{self, Write as _};
use std::path::{Path, PathBuf};

use cosplat_core::control::FIRST_EPOCH;
use rustix::fs::{FlockOperation, flock};
use rustix::io::Errno;

use crate::exit::{Code, Error, Problem};

/// The scene as run, versions, plan. Its presence says that a folder was made by this program.
pub(crate) const RUN: &str = "run.toml";
/// Budgets, one row a window.
pub(crate) const LEDGER: &str = "ledger.csv";
/// One row per window, one column per component of a probe.
pub(crate) const PROBES: &str = "probes.csv";
/// Where the time went, for Perfetto.
pub(crate) const TRACE: &str = "trace.json";
/// Outcome and budgets.
pub(crate) const SUMMARY: &str = "summary.json";
/// Pictures, curves and verdicts for people.
pub(crate) const REPORT: &str = "report.html";
/// A picture of each frame.
pub(crate) const PICTURES: &str = "frames";
/// All pictures as one animation.
pub(crate) const PREVIEW: &str = "preview.png";
/// All pictures as a film.
pub(crate) const VIDEO: &str = "video.mp4";
/// Depth, mask and flow of each frame, where the scene has a preset.
pub(crate) const CONDITIONS: &str = "conditions";
/// Each frame as a splat file.
pub(crate) const SPLATS: &str = "splats";
/// The surface of each liquid at each frame as a mesh.
pub(crate) const SURFACES: &str = "surfaces";
/// Gaussians, particles, impulses and curves over time.
pub(crate) const RECORDING: &str = "run.rrd";
/// What a run is taken up from after it was stopped or killed, where it was asked to keep that.
pub(crate) const CHECKPOINTS: &str = "checkpoints";
/// What each process wrote to standard error.
pub(crate) const LOGS: &str = "logs";

/// Before the name of a file that is not whole yet.
const PART: &str = ".part-";

/// First line of a [`RUN`] file.
pub(crate) const MARK: &str = "# Record of a Cosplat run.";

/// A folder that this run alone writes to.
#[derive(Debug)]
pub(crate) struct RunFolder {
    path: PathBuf,
    /// Holds the lock; released when the run ends, however it ends.
    _lock: File,
}

impl RunFolder {
    /// Takes a folder for a run: a new one, an empty one, or one of an earlier run, whose files are removed.
    ///
    /// # Errors
    /// The folder holds something else, another run is writing to it, or it cannot be written.
    pub(crate) fn claim(path: &Path) -> Result<Self, Error> {
        if path.exists() && !path.is_dir() {
            let problem = Problem::new(format!("`{}` is a file, not a folder", path.display())).at(path);
            return Err(Error::new(Code::Scene, problem.hint("choose another run folder with `--out DIR`")));
        }
        fs::create_dir_all(path).map_err(|e| Error::io("create the run folder", path, &e))?;
        let lock = lock(path)?;
        let is_empty = fs::read_dir(path).map_err(|e| Error::io("read the run folder", path, &e))?.next().is_none();
        if !is_empty {
            if !is_of_a_run(path) {
                let problem = Problem::new(format!("`{}` is not empty and holds no run", path.display()))
                    .at(path)
                    .because(format!("a run replaces only folders with a `{RUN}` written by a run"));
                let hint = "choose a new or empty folder with `--out DIR`, or remove that one yourself";
                return Err(Error::new(Code::Scene, problem.hint(hint)));
            }
            remove_old(path).map_err(|e| Error::io("replace the earlier run in", path, &e))?;
        }
        let logs = path.join(LOGS);
        fs::create_dir_all(&logs).map_err(|e| Error::io("create", &logs, &e))?;
        Ok(Self { path: path.to_owned(), _lock: lock })
    }

    /// Takes the folder of an earlier run to go on with it. Nothing is removed but what says how that run ended.
    ///
    /// # Errors
    /// There is no run in it, or it is still being written to.
    pub(crate) fn reopen(path: &Path) -> Result<Self, Error> {
        if !is_of_a_run(path) {
            let problem = Problem::new(format!("There is no run in `{}`", path.display())).at(path);
            let problem = problem.because(format!("a run folder has a `{RUN}`"));
            return Err(Error::new(Code::Scene, problem.hint("name the folder of a run that kept checkpoints")));
        }
        let lock = lock(path)?;
        Ok(Self { path: path.to_owned(), _lock: lock })
    }

    /// Removes what says how an earlier life of the run ended, and what it left half written.
    ///
    /// # Errors
    /// A file cannot be removed.
    pub(crate) fn forget_end(&self) -> Result<(), Error> {
        let forget = || {
            remove_parts(&self.path)?;
            [SUMMARY, REPORT, PREVIEW].iter().try_for_each(|name| absent_is_fine(fs::remove_file(self.file(name))))
        };
        forget().map_err(|e| Error::io("go on in", &self.path, &e))
    }

    /// Where it is.
    pub(crate) fn path(&self) -> &Path {
        &self.path
    }

    /// Place of a file in it.
    pub(crate) fn file(&self, name: &str) -> PathBuf {
        self.path.join(name)
    }

    /// Name, below the folder, of the log of a process.
    pub(crate) fn log_name(process: &str) -> String {
        let is_plain = |c: char| c.is_ascii_alphanumeric() || c == '-' || c == '_';
        let safe: String = process.chars().map(|c| if is_plain(c) { c } else { '_' }).collect();
        format!("{LOGS}/{safe}.txt")
    }

    /// Puts a whole file in place: readers see the old one or the new one, never a part.
    ///
    /// # Errors
    /// The file cannot be written.
    pub(crate) fn put(&self, name: &str, content: &[u8]) -> Result<(), Error> {
        let path = self.file(name);
        replace(&path, content).map_err(|e| Error::io("write", &path, &e))
    }
}

/// Puts a whole file of a run folder in place.
pub(crate) fn replace(path: &Path, content: &[u8]) -> io::Result<()> {
    // The folder belongs to this run alone, so the name is free.
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    let part = path.with_file_name(format!("{PART}{name}"));
    let mut file = File::create(&part)?;
    file.write_all(content)?;
    file.sync_data()?;
    fs::rename(&part, path)
}

/// Locks a folder for this run alone.
fn lock(path: &Path) -> Result<File, Error> {
    let lock = File::open(path).map_err(|e| Error::io("open the run folder", path, &e))?;
    // A file system without locks is used without one.
    if flock(&lock, FlockOperation::NonBlockingLockExclusive) == Err(Errno::WOULDBLOCK) {
        let problem = Problem::new(format!("Another run is writing to `{}`", path.display())).at(path);
        return Err(Error::new(Code::Scene, problem.hint("wait for it, or choose another folder with `--out DIR`")));
    }
    Ok(lock)
}

/// Whether the folder was made by a run: it holds a [`RUN`] file that begins with [`MARK`].
pub(crate) fn is_of_a_run(path: &Path) -> bool {
    fs::read_to_string(path.join(RUN)).is_ok_and(|text| text.starts_with(MARK))
}

/// Removes what an earlier run wrote and nothing else. The record goes last, so that a kill leaves a run folder.
fn remove_old(path: &Path) -> io::Result<()> {
    absent_is_fine(fs::remove_dir_all(path.join(LOGS)))?;
    remove_parts(path)?;
    for entry in fs::read_dir(path)? {
        let entry = entry?;
        if is_later_recording(&entry.file_name().to_string_lossy()) {
            absent_is_fine(fs::remove_file(entry.path()))?;
        }
    }
    for folder in [PICTURES, CONDITIONS, SPLATS, SURFACES, CHECKPOINTS] {
        absent_is_fine(fs::remove_dir_all(path.join(folder)))?;
    }
    for name in [SUMMARY, REPORT, PREVIEW, VIDEO, RECORDING, LEDGER, PROBES, TRACE, RUN] {
        absent_is_fine(fs::remove_file(path.join(name)))?;
    }
    Ok(())
}

/// Recording of a life of a run: what an earlier one has recorded is kept, and a viewer shows all of them as one.
pub(crate) fn recording(epoch: u32) -> String {
    if epoch == FIRST_EPOCH { RECORDING.to_owned() } else { format!("run-{epoch}.rrd") }
}

fn is_later_recording(name: &str) -> bool {
    let number = name.strip_prefix("run-").and_then(|rest| rest.strip_suffix(".rrd"));
    number.is_some_and(|number| number.parse::<u32>().is_ok())
}

/// Removes files that are not whole.
fn remove_parts(path: &Path) -> io::Result<()> {
    for entry in fs::read_dir(path)? {
        let entry = entry?;
        if entry.file_name().to_string_lossy().starts_with(PART) {
            absent_is_fine(fs::remove_file(entry.path()))?;
        }
    }
    Ok(())
}

fn absent_is_fine(result: io::Result<()>) -> io::Result<()> {
    match result {
        Err(e) if e.kind() == io::ErrorKind::NotFound => Ok(()),
        other => other,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_folder_of_something_else_is_refused_and_left_alone() {
        let place = tempfile::tempdir().unwrap();
        fs::write(place.path().join("thesis.txt"), "years of work").unwrap();
        let error = RunFolder::claim(place.path()).unwrap_err();
        assert_eq!(error.code, Code::Scene);
        assert!(error.problems[0].hint.is_some());
        assert!(place.path().join("thesis.txt").exists());
        assert!(!place.path().join(LOGS).exists());
    }

    #[test]
    fn a_file_of_the_same_name_by_somebody_else_does_not_make_it_ours() {
        let place = tempfile::tempdir().unwrap();
        fs::write(place.path().join(RUN), "[run]\n").unwrap();
        assert!(RunFolder::claim(place.path()).is_err());
    }

    #[test]
    fn an_earlier_run_is_replaced_but_notes_beside_it_stay() {
        let place = tempfile::tempdir().unwrap();
        let folder = RunFolder::claim(place.path()).unwrap();
        folder.put(RUN, MARK.as_bytes()).unwrap();
        folder.put(SUMMARY, b"{}").unwrap();
        fs::write(folder.file("notes.txt"), "mine").unwrap();
        drop(folder);
        let folder = RunFolder::claim(place.path()).unwrap();
        assert!(!folder.file(SUMMARY).exists() && !folder.file(RUN).exists());
        assert!(folder.file("notes.txt").exists());
    }

    #[test]
    fn two_runs_cannot_share_a_folder() {
        let place = tempfile::tempdir().unwrap();
        let _first = RunFolder::claim(place.path()).unwrap();
        let error = RunFolder::claim(place.path()).unwrap_err();
        assert!(error.problems[0].message.starts_with("Another run"), "{error:?}");
    }

    #[test]
    fn names_of_logs_stay_inside_the_folder() {
        assert_eq!(RunFolder::log_name("../left"), "logs/___left.txt");
    }
}
