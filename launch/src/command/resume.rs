//! `cosplat run --resume`: what is to be known about the run that is taken up.

use std::path::{Path, PathBuf};

use cosplat_core::control::PROTOCOL;
use cosplat_core::coordinator::{Coordinator, Limits};
use toml::{Table, Value};

use crate::cli::SceneArgs;
use crate::exit::{Code, Error, Problem};
use crate::folder::checkpoints::{Checkpoints, TakenUp};
use crate::folder::{RUN, RunFolder};
use crate::prepare::Prepared;
use crate::scene_source::Source;

/// A run that was begun before, by its record.
pub(crate) struct Earlier {
    /// Its folder, which is this program's now.
    pub(crate) folder: RunFolder,
    /// The scene as it was run.
    pub(crate) source: Source,
    /// What was changed in it.
    pub(crate) changes: SceneArgs,
    /// Moment at which the run began, as its record says.
    pub(crate) started: String,
}

impl Earlier {
    /// Opens the folder of a run. `threads` are those wanted now: they change no result.
    ///
    /// # Errors
    /// It is no run folder, in use, or of another protocol.
    pub(crate) fn open(path: &Path, threads: Option<u16>) -> Result<Self, Error> {
        let folder = RunFolder::reopen(path)?;
        let file = folder.file(RUN);
        let text = std::fs::read_to_string(&file).map_err(|e| Error::io("read", &file, &e))?;
        let refuse = |why: String| {
            let problem = Problem::new(format!("The run in `{}` cannot be resumed", path.display())).at(&file);
            Error::new(Code::Scene, problem.because(why).hint("begin it anew with `cosplat run`"))
        };
        let record: Table = text.parse().map_err(|e: toml::de::Error| refuse(e.to_string()))?;
        let protocol = find(&record, &["run", "protocol"]).and_then(Value::as_integer);
        if protocol != Some(i64::from(PROTOCOL)) {
            let found = protocol.map_or_else(|| "none".to_owned(), |p| p.to_string());
            return Err(refuse(format!("its protocol is {found}, this program speaks {PROTOCOL}")));
        }
        let word = |path: &[&str]| {
            let found = find(&record, path).and_then(Value::as_str).map(str::to_owned);
            found.ok_or_else(|| refuse(format!("its record lacks `{}`", path.join("."))))
        };
        let file = PathBuf::from(word(&["run", "folder"])?).join(word(&["scene", "source"])?);
        let is_file = word(&["scene", "source"])? != BUILT_IN;
        let source = Source {
            shown: if is_file { file.display().to_string() } else { format!("built-in {}", word(&["scene", "name"])?) },
            file: is_file.then_some(file),
            text: word(&["scene", "text"])?,
        };
        let before = find(&record, &["run", "threads"]).and_then(Value::as_integer);
        let changes = SceneArgs {
            set: list(&record, "overrides"),
            solver: list(&record, "solvers").iter().filter_map(|s| s.split_once('=')).map(owned).collect(),
            threads: threads.or_else(|| before.and_then(|n| u16::try_from(n).ok())),
            live: false,
        };
        Ok(Self { started: word(&["run", "started"])?, folder, source, changes })
    }

    /// Finds where the run is taken up, and that it is the same run. Changes nothing but the number of its life.
    ///
    /// # Errors
    /// There is no complete checkpoint, or it is of another program, scene or plan.
    pub(crate) fn take_up(&self, prepared: &Prepared, every: Option<u64>) -> Result<(Checkpoints, TakenUp), Error> {
        let (kept, taken_up) = Checkpoints::reopen(&self.folder, &prepared.plan, every, &prepared.commands())?;
        let (plan, scenes) = (prepared.plan.clone(), prepared.scenes.clone());
        let coordinator = Coordinator::new(taken_up.checkpoint.run, kept.epoch(), plan, scenes, Limits::default());
        match coordinator.resumed((*taken_up.checkpoint).clone()) {
            Ok(_) => Ok((kept, taken_up)),
            Err(why) => {
                let path = self.folder.path();
                let problem =
                    Problem::new(format!("The checkpoint in `{}` is not of this run", path.display())).at(path);
                let hint = "undo what was changed in the files that the scene names, or begin the run anew";
                Err(Error::new(Code::Scene, problem.because(why).hint(hint)))
            }
        }
    }
}

/// What a record says instead of a file.
const BUILT_IN: &str = "built-in";

fn find<'t>(record: &'t Table, path: &[&str]) -> Option<&'t Value> {
    let (last, tables) = path.split_last()?;
    tables.iter().try_fold(record, |table, name| table.get(*name)?.as_table())?.get(*last)
}

fn list(record: &Table, name: &str) -> Vec<String> {
    let values = find(record, &["scene", name]).and_then(Value::as_array).into_iter().flatten();
    values.filter_map(|value| value.as_str().map(str::to_owned)).collect()
}

fn owned((key, value): (&str, &str)) -> (String, String) {
    (key.to_owned(), value.to_owned())
}
