//! `checkpoints/`: what a run is taken up from after it was stopped or killed.
//!
//! Participants put their snapshots there, the program the coordinator's records, and beside each what it had counted by
//! then. `about.json` says whose they are.

use std::collections::BTreeMap;
use std::ffi::OsString;
use std::fs;
use std::io;
use std::path::Path;

use cosplat_bus::{BusError, CheckpointFolder, Life, file_name, run_from_hex, run_to_hex};
use cosplat_core::checkpoint::{Checkpoint, CheckpointError};
use cosplat_core::control::asset_hash;
use cosplat_core::plan::Plan;
use serde::{Deserialize, Serialize};

use super::tally::Tally;
use super::{CHECKPOINTS, RunFolder};
use crate::exit::{Code, Error, Problem};

const ABOUT: &str = "about.json";
/// Kind of the files that hold [`Sums`].
const SUMS: &str = "sums";

/// Whose checkpoints these are.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct About {
    /// Identity of the run, hexadecimal.
    run: String,
    /// Its newest incarnation.
    epoch: u32,
    /// Windows from one checkpoint to the next.
    every: u64,
    /// Hash of each file that a process is started from: another build may compute something else.
    programs: BTreeMap<String, String>,
}

/// What was counted up to the edge of a window.
#[derive(Debug, Serialize, Deserialize)]
pub(crate) struct Sums {
    /// Sums and extremes over all windows before.
    pub(crate) tally: Tally,
    /// Wall time in all lives of the run \[s\].
    pub(crate) wall_s: f64,
}

/// Where a run is taken up.
pub(crate) struct TakenUp {
    /// What the coordinator knew there.
    pub(crate) checkpoint: Box<Checkpoint>,
    /// What was counted by then.
    pub(crate) sums: Sums,
}

/// Keeps the checkpoints of a run.
#[derive(Debug)]
pub(crate) struct Checkpoints {
    folder: CheckpointFolder,
    about: About,
    /// Sums at edges at which a checkpoint may be, encoded: it is complete only when later windows are settled.
    noted: BTreeMap<u64, Vec<u8>>,
    /// The newest one that is stored.
    pub(crate) newest: Option<u64>,
}

impl Checkpoints {
    /// For a new run that keeps one every `every` windows.
    ///
    /// # Errors
    /// The folder cannot be written.
    pub(crate) fn begin(folder: &RunFolder, every: u64, commands: &[Vec<OsString>]) -> Result<Self, Error> {
        let life = Life::first().map_err(|e| no_identity(&e))?;
        let about = About { run: run_to_hex(&life.run), epoch: life.epoch, every, programs: programs(commands) };
        Self::new(folder, about, None)
    }

    /// For the next life of a run; answers where it is taken up.
    ///
    /// # Errors
    /// There is no complete checkpoint, or it is of another program.
    pub(crate) fn reopen(
        folder: &RunFolder,
        plan: &Plan,
        every: Option<u64>,
        commands: &[Vec<OsString>],
    ) -> Result<(Self, TakenUp), Error> {
        let path = folder.file(CHECKPOINTS);
        let refuse = |why: String| Error::new(Code::Scene, no_checkpoint(folder).because(why));
        let about = fs::read(path.join(ABOUT)).map_err(|e| refuse(e.to_string()))?;
        let about: About = serde_json::from_slice(&about).map_err(|e| refuse(format!("`{ABOUT}`: {e}")))?;
        same_programs(folder, &about.programs, &programs(commands))?;
        let store = CheckpointFolder::new(&path);
        let taken_up = take_up(&store, plan).map_err(|why| {
            let problem = no_checkpoint(folder);
            Error::new(Code::Scene, why.map_or(problem.clone(), |why| problem.because(why)))
        })?;
        let about = About { epoch: about.epoch.saturating_add(1), every: every.unwrap_or(about.every), ..about };
        let newest = Some(taken_up.checkpoint.window);
        Ok((Self::new(folder, about, newest)?, taken_up))
    }

    /// Writes down the new life before it begins, so that no later one has its number.
    fn new(folder: &RunFolder, about: About, newest: Option<u64>) -> Result<Self, Error> {
        let path = folder.file(CHECKPOINTS);
        // Snapshots are written by processes with working folders of their own.
        let path = std::path::absolute(&path).unwrap_or(path);
        let this = Self { folder: CheckpointFolder::new(&path), about, noted: BTreeMap::new(), newest };
        let written = serde_json::to_vec_pretty(&this.about).map_err(io::Error::from);
        written.and_then(|bytes| this.folder.put(ABOUT, &bytes)).map_err(|e| Error::io("write", &path, &e))?;
        Ok(this)
    }

    /// Windows from one checkpoint to the next.
    pub(crate) fn every(&self) -> u64 {
        self.about.every
    }

    /// Incarnation of the run.
    pub(crate) fn epoch(&self) -> u32 {
        self.about.epoch
    }

    /// The life that begins now.
    ///
    /// # Errors
    /// The identity of the run cannot be read.
    pub(crate) fn life(&self, from: Option<Box<Checkpoint>>) -> Result<Life, Error> {
        let run = run_from_hex(&self.about.run).ok_or_else(|| {
            let problem = Problem::new(format!("`{ABOUT}` is damaged")).at(self.folder.path());
            Error::new(Code::Scene, problem.because("its run is not 32 hex digits").hint(ANEW))
        })?;
        Ok(Life { run, epoch: self.about.epoch, checkpoints: Some(self.folder.path().to_owned()), from })
    }

    /// Remembers what is counted where a checkpoint may be.
    pub(crate) fn note(&mut self, tally: &Tally, wall_s: f64) {
        if tally.windows.is_multiple_of(self.about.every.max(1)) {
            self.noted.insert(tally.windows, encode(tally, wall_s));
        }
    }

    /// Stores a checkpoint of which all participants have stored their parts; `tally` is what is counted now.
    ///
    /// # Errors
    /// A file cannot be written.
    pub(crate) fn store(&mut self, checkpoint: &Checkpoint, tally: &Tally, wall_s: f64) -> io::Result<()> {
        let window = checkpoint.window;
        let sums = match self.noted.get(&window) {
            Some(noted) => noted.clone(),
            // At a stop nothing is settled behind the edge.
            None if tally.windows == window => encode(tally, wall_s),
            None => return Err(io::Error::other(format!("nothing was counted at window {window}"))),
        };
        self.folder.put(&file_name(window, SUMS), &sums)?;
        self.folder.put_record(checkpoint)?;
        self.folder.remove(SUMS, |stored| stored < window);
        self.noted = self.noted.split_off(&(window + 1));
        self.newest = Some(window);
        Ok(())
    }
}

const ANEW: &str = "begin the run anew with `cosplat run`";

fn no_identity(error: &BusError) -> Error {
    Error::new(Code::Environment, Problem::new("The run cannot get an identity").because(error))
}

fn no_checkpoint(folder: &RunFolder) -> Problem {
    Problem::new(format!("There is no complete checkpoint in `{}`", folder.path().display()))
        .at(folder.path())
        .hint("begin the run anew with `cosplat run --checkpoint-every SECONDS`")
}

/// The newest complete checkpoint; why not, where that is known.
fn take_up(store: &CheckpointFolder, plan: &Plan) -> Result<TakenUp, Option<String>> {
    let broken = |e: CheckpointError| Some(e.to_string());
    let names = plan.participants.iter().map(|p| p.name.as_str());
    let checkpoint = store.newest(&names).map_err(broken)?.ok_or(None)?;
    let path = store.path().join(file_name(checkpoint.window, SUMS));
    let bytes = fs::read(&path).map_err(|e| Some(format!("`{}`: {e}", path.display())))?;
    let damaged = || Some(format!("`{}` is damaged", path.display()));
    let sums = decode(&bytes).filter(|sums| sums.tally.windows == checkpoint.window).ok_or_else(damaged)?;
    Ok(TakenUp { checkpoint: Box::new(checkpoint), sums })
}

fn encode(tally: &Tally, wall_s: f64) -> Vec<u8> {
    // Plain data into a growing vector cannot fail; nothing would be refused by `decode`.
    let mut bytes = postcard::to_stdvec(&(tally, wall_s)).unwrap_or_default();
    bytes.extend_from_slice(&asset_hash(&bytes).to_le_bytes());
    bytes
}

fn decode(bytes: &[u8]) -> Option<Sums> {
    let (body, sum) = bytes.split_last_chunk::<8>()?;
    (asset_hash(body) == u64::from_le_bytes(*sum)).then_some(())?;
    let (tally, wall_s) = postcard::from_bytes(body).ok()?;
    Some(Sums { tally, wall_s })
}

/// Hashes of all files that are named in command lines, and of this program.
fn programs(commands: &[Vec<OsString>]) -> BTreeMap<String, String> {
    let own = std::env::current_exe().into_iter().map(OsString::from);
    let words = commands.iter().flatten().cloned().chain(own);
    let files = words.filter(|word| Path::new(word).is_file());
    let mut programs = BTreeMap::new();
    for file in files {
        let name = file.to_string_lossy().into_owned();
        programs.entry(name).or_insert_with(|| match fs::read(&file) {
            Ok(bytes) => format!("{:016x}", asset_hash(&bytes)),
            Err(error) => error.to_string(),
        });
    }
    programs
}

fn same_programs(
    folder: &RunFolder,
    before: &BTreeMap<String, String>,
    now: &BTreeMap<String, String>,
) -> Result<(), Error> {
    let other = now.iter().find(|(file, hash)| before.get(*file) != Some(*hash)).map(|(file, _)| file);
    let Some(file) = other.or_else(|| before.keys().find(|file| !now.contains_key(*file))) else { return Ok(()) };
    let problem = Problem::new(format!("The run in `{}` was begun with another program", folder.path().display()))
        .at(folder.path())
        .because(format!("`{file}` is not what it was, and may compute something else"))
        .hint(format!("go on with the program that began the run, or {ANEW}"));
    Err(Error::new(Code::Scene, problem))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::folder::fixtures::{done, plan, record};

    #[test]
    fn sums_come_back_to_the_bit_and_damage_is_seen() {
        let mut tally = Tally::new(&plan(9), Vec::new());
        tally.settled(&record(0), &[done(0), done(0)]);
        let bytes = encode(&tally, 1.5);
        let sums = decode(&bytes).unwrap();
        assert_eq!((format!("{:?}", sums.tally), sums.wall_s), (format!("{tally:?}"), 1.5));
        for at in 0..bytes.len() {
            let mut damaged = bytes.clone();
            damaged[at] ^= 4;
            assert!(decode(&damaged).is_none(), "byte {at}");
        }
    }

    #[test]
    fn another_build_is_refused_by_name() {
        let place = tempfile::tempdir().unwrap();
        let folder = RunFolder::claim(&place.path().join("out")).unwrap();
        let program = place.path().join("solver");
        fs::write(&program, "one").unwrap();
        let commands = [vec![program.clone().into_os_string()]];
        let kept = Checkpoints::begin(&folder, 5, &commands).unwrap();
        assert_eq!((kept.every(), kept.epoch()), (5, 1));
        let refused = || Checkpoints::reopen(&folder, &plan(9), None, &commands).err().unwrap();
        assert!(refused().problems[0].message.contains("no complete checkpoint"));
        fs::write(&program, "two").unwrap();
        let error = refused();
        assert_eq!(error.code, Code::Scene);
        assert!(error.problems[0].details[0].contains("solver"), "{error:?}");
    }
}
