//! What a run has left in its folder, read back.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use serde::Deserialize;

use crate::exit::{Code, Error, Problem};
use crate::folder::curves::Table;
use crate::folder::summary::Summary;
use crate::folder::{LEDGER, PICTURES, PROBES, REPORT, RUN, SUMMARY, is_of_a_run};

/// A run that has ended.
#[derive(Debug)]
pub(crate) struct ArchivedRun {
    /// Its folder as given, or found below a folder given.
    pub(crate) folder: PathBuf,
    /// Outcome and budgets.
    pub(crate) summary: Summary,
    /// How it was started.
    pub(crate) start: Start,
    /// What the scene says about itself; may be empty.
    pub(crate) title: String,
    /// The picture in the middle of the run, a PNG file.
    pub(crate) picture: Option<Vec<u8>>,
    /// Whether it has a report.
    pub(crate) has_report: bool,
    /// What the probes measured; empty where the scene has none.
    pub(crate) probes: Table,
    /// Budgets by window.
    pub(crate) ledger: Table,
}

/// How a run was started, as its record says.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct Start {
    /// Moment, UTC.
    pub(crate) moment: String,
    /// Command line, program first.
    pub(crate) command: Vec<String>,
    /// Values and plugins changed on the command line.
    pub(crate) changes: Vec<String>,
    /// Process and the plugin in it.
    pub(crate) plugins: Vec<(String, String)>,
}

/// The parts of a [`RUN`] file that are shown. What another version wrote beside them is no mistake.
#[derive(Debug, Deserialize)]
struct Record {
    run: RunPart,
    scene: ScenePart,
    #[serde(default)]
    plugins: Vec<PluginPart>,
}

#[derive(Debug, Deserialize)]
struct RunPart {
    started: String,
    command: Vec<String>,
}

#[derive(Debug, Deserialize)]
struct ScenePart {
    text: String,
    #[serde(default)]
    overrides: Vec<String>,
    #[serde(default)]
    solvers: Vec<String>,
}

#[derive(Debug, Deserialize)]
struct PluginPart {
    process: String,
    name: String,
}

/// The run folders that are meant: each folder given, or where it is none, the run folders in it by name.
///
/// # Errors
/// A folder cannot be read, or holds no run.
pub(crate) fn run_folders(given: &[PathBuf]) -> Result<Vec<PathBuf>, Error> {
    let mut found = Vec::new();
    for folder in given {
        if is_of_a_run(folder) {
            found.push(folder.clone());
            continue;
        }
        let refuse = |problem| Error::new(Code::Scene, problem);
        let inside = runs_in(folder).map_err(|e| refuse(missing(folder).because(e)))?;
        if inside.is_empty() {
            return Err(refuse(missing(folder)));
        }
        found.extend(inside);
    }
    Ok(found)
}

fn runs_in(folder: &Path) -> io::Result<Vec<PathBuf>> {
    let mut runs: Vec<PathBuf> = fs::read_dir(folder)?.map(|e| Ok(e?.path())).collect::<io::Result<_>>()?;
    runs.retain(|path| is_of_a_run(path));
    runs.sort_unstable();
    Ok(runs)
}

fn missing(folder: &Path) -> Problem {
    Problem::new(format!("`{}` is no run folder and holds none", folder.display())).at(folder).hint(format!(
        "give a folder with a `{RUN}` that a run wrote, or the folder around several; `cosplat run` makes one"
    ))
}

impl ArchivedRun {
    /// Reads a run.
    ///
    /// # Errors
    /// In words: what is missing or cannot be understood. A run that was killed has no summary.
    pub(crate) fn read(folder: &Path) -> Result<Self, String> {
        let text = |name: &str| {
            fs::read_to_string(folder.join(name)).map_err(|e| match e.kind() {
                io::ErrorKind::NotFound => format!("it has no `{name}`: the run is not over, or was killed"),
                _ => format!("`{name}` cannot be read: {e}"),
            })
        };
        let other = |name: &str, e: &dyn std::fmt::Display| {
            format!("`{name}` was written by another version, or changed: {}", e.to_string().trim_end())
        };
        let summary: Summary = serde_json::from_str(&text(SUMMARY)?).map_err(|e| other(SUMMARY, &e))?;
        let record: Record = toml::from_str(&text(RUN)?).map_err(|e| other(RUN, &e))?;
        let table = |name: &str| match Table::read(&folder.join(name), 0) {
            Ok(table) => Ok(table),
            Err(e) if e.kind() == io::ErrorKind::NotFound => Ok(Table::default()),
            Err(e) => Err(format!("`{name}` cannot be read: {e}")),
        };
        Ok(Self {
            probes: table(PROBES)?,
            ledger: table(LEDGER)?,
            title: title(&record.scene.text),
            start: Start::of(record),
            picture: middle_picture(&folder.join(PICTURES)),
            has_report: folder.join(REPORT).is_file(),
            folder: folder.to_owned(),
            summary,
        })
    }

    /// Its folder's own name.
    pub(crate) fn name(&self) -> String {
        self.folder.file_name().map_or_else(|| self.folder.display().to_string(), |n| n.to_string_lossy().into_owned())
    }
}

impl Start {
    fn of(record: Record) -> Self {
        let mut changes = record.scene.overrides;
        changes.extend(record.scene.solvers.into_iter().map(|s| format!("--solver {s}")));
        Self {
            moment: record.run.started,
            command: record.run.command,
            changes,
            plugins: record.plugins.into_iter().map(|p| (p.process, p.name)).collect(),
        }
    }
}

/// The title that a scene gives itself.
fn title(scene: &str) -> String {
    let scene: toml::Table = toml::from_str(scene).unwrap_or_default();
    scene.get("title").and_then(toml::Value::as_str).unwrap_or_default().to_owned()
}

/// The middle one of the pictures, whose names are in the order of time.
fn middle_picture(folder: &Path) -> Option<Vec<u8>> {
    let mut pictures: Vec<PathBuf> = fs::read_dir(folder).ok()?.filter_map(|e| Some(e.ok()?.path())).collect();
    pictures.retain(|p| p.extension().is_some_and(|e| e == "png"));
    pictures.sort_unstable();
    fs::read(pictures.get(pictures.len() / 2)?).ok()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::folder::MARK;

    #[test]
    fn a_folder_without_runs_is_refused_with_what_to_give() {
        let place = tempfile::tempdir().unwrap();
        for folder in [place.path().to_owned(), place.path().join("missing")] {
            let error = run_folders(&[folder]).unwrap_err();
            assert_eq!(error.code, Code::Scene);
            assert!(error.problems[0].hint.as_deref().unwrap_or_default().contains(RUN), "{error:?}");
        }
    }

    #[test]
    fn runs_are_found_below_a_folder_by_name() {
        let place = tempfile::tempdir().unwrap();
        for name in ["b", "a", "notes"] {
            fs::create_dir(place.path().join(name)).unwrap();
        }
        for name in ["b", "a"] {
            fs::write(place.path().join(name).join(RUN), MARK).unwrap();
        }
        let found = run_folders(&[place.path().to_owned()]).unwrap();
        assert_eq!(found, [place.path().join("a"), place.path().join("b")]);
    }

    #[test]
    fn a_run_that_was_killed_says_so() {
        let place = tempfile::tempdir().unwrap();
        fs::write(place.path().join(RUN), MARK).unwrap();
        assert!(ArchivedRun::read(place.path()).unwrap_err().contains("was killed"));
        fs::write(place.path().join(SUMMARY), "{\"status\": \"splendid\"}").unwrap();
        assert!(ArchivedRun::read(place.path()).unwrap_err().contains("another version"));
    }
}
