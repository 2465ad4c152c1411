//! Where the parts of checkpoints lie: one file each, which is whole or not there.
//!
//! Each participant writes its snapshots, the owner of the run the coordinator's records; nobody writes another's. What
//! makes a checkpoint is the record, and that is written last.

use std::fs::{self, File};
use std::io::{self, Write as _};
use std::path::{Path, PathBuf};

use cosplat_core::checkpoint::{Checkpoint, CheckpointError, Snapshot};

/// Before the name of a file that is not whole yet.
const PART: &str = ".part-";
const SNAPSHOT: &str = "snapshot";
const RECORD: &str = "checkpoint";

/// A folder of checkpoints.
#[derive(Clone, Debug)]
pub struct CheckpointFolder {
    path: PathBuf,
}

impl CheckpointFolder {
    /// The folder at `path`; it need not be there yet.
    pub fn new(path: impl Into<PathBuf>) -> Self {
        Self { path: path.into() }
    }

    /// Where it is.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Puts a file in place: readers find the old one or the whole new one, also after the machine went down.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn put(&self, name: &str, content: &[u8]) -> io::Result<()> {
        fs::create_dir_all(&self.path)?;
        let part = self.path.join(format!("{PART}{name}"));
        let mut file = File::create(&part)?;
        file.write_all(content)?;
        file.sync_all()?;
        fs::rename(&part, self.path.join(name))?;
        // The name lies in the folder, which has to reach the disk as well.
        File::open(&self.path)?.sync_all()
    }

    /// Stores a participant's snapshot of the start of `window`, and removes its others but the one of `keep`.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn put_snapshot(&self, name: &str, window: u64, keep: Option<u64>, bytes: &[u8]) -> io::Result<()> {
        let kind = snapshot(name);
        self.remove(&kind, |stored| Some(stored) != keep);
        self.put(&file_name(window, &kind), bytes)
    }

    /// Reads a participant's snapshot of the start of `window`. Those of later windows belong to a life of the run that is
    /// over and are removed.
    ///
    /// # Errors
    /// [`CheckpointError`].
    pub fn snapshot(&self, name: &str, window: u64) -> Result<Snapshot, CheckpointError> {
        let kind = snapshot(name);
        self.remove(&kind, |stored| stored > window);
        Snapshot::decode(&self.read(window, &kind)?)
    }

    /// Stores what makes a checkpoint of snapshots, and removes the records before.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn put_record(&self, checkpoint: &Checkpoint) -> io::Result<()> {
        self.put(&file_name(checkpoint.window, RECORD), &checkpoint.encode())?;
        self.remove(RECORD, |stored| stored < checkpoint.window);
        Ok(())
    }

    /// The newest checkpoint of which every participant has its part; `None` where there is none.
    ///
    /// # Errors
    /// [`CheckpointError`] when the newest one cannot be read.
    pub fn newest<'n>(
        &self,
        participants: &(impl Iterator<Item = &'n str> + Clone),
    ) -> Result<Option<Checkpoint>, CheckpointError> {
        let mut windows = self.windows(RECORD);
        windows.sort_unstable();
        let is_whole = |window: &u64| {
            participants.clone().all(|name| self.path.join(file_name(*window, &snapshot(name))).exists())
        };
        let newest = windows.into_iter().rev().find(is_whole);
        newest.map(|window| Checkpoint::decode(&self.read(window, RECORD)?)).transpose()
    }

    fn read(&self, window: u64, kind: &str) -> Result<Vec<u8>, CheckpointError> {
        let path = self.path.join(file_name(window, kind));
        fs::read(&path).map_err(|e| CheckpointError::Unreadable(format!("`{}`: {e}", path.display())))
    }

    /// Removes files of a kind by their window. What cannot be removed is in nobody's way.
    pub fn remove(&self, kind: &str, is_old: impl Fn(u64) -> bool) {
        for window in self.windows(kind).into_iter().filter(|window| is_old(*window)) {
            let _ = fs::remove_file(self.path.join(file_name(window, kind)));
        }
    }

    /// Windows of which there is a file of that kind.
    fn windows(&self, kind: &str) -> Vec<u64> {
        let entries = fs::read_dir(&self.path).into_iter().flatten().flatten();
        let names = entries.filter_map(|entry| entry.file_name().into_string().ok());
        names.filter_map(|name| name.split_once('.').filter(|(_, found)| *found == kind)?.0.parse().ok()).collect()
    }
}

/// Name of a file: the window first, so that a listing is in order of time.
pub fn file_name(window: u64, kind: &str) -> String {
    format!("{window:010}.{kind}")
}

fn snapshot(name: &str) -> String {
    format!("{name}.{SNAPSHOT}")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn record(window: u64) -> Checkpoint {
        let ledger = "{\"previous\":[],\"stored\":[],\"underway\":[],\"scale\":0.0,\"angular_scale\":0.0}";
        Checkpoint {
            run: [1; 16],
            epoch: 1,
            identity: 2,
            window,
            state_hash: 3,
            states: vec![4],
            published: Vec::new(),
            ledger: serde_json::from_str(ledger).unwrap(),
        }
    }

    fn part(window: u64) -> Vec<u8> {
        Snapshot { window, name: "a".to_owned(), ..Snapshot::default() }.encode()
    }

    #[test]
    fn a_checkpoint_counts_when_all_have_their_part_and_the_one_before_stays_until_then() {
        let place = tempfile::tempdir().unwrap();
        let folder = CheckpointFolder::new(place.path().join("checkpoints"));
        let newest = || folder.newest(&["a", "b.2"].into_iter()).unwrap().map(|c| c.window);
        assert_eq!(newest(), None);
        for name in ["a", "b.2"] {
            folder.put_snapshot(name, 5, None, &part(5)).unwrap();
        }
        assert_eq!(newest(), None, "parts without a record are no checkpoint");
        folder.put_record(&record(5)).unwrap();
        assert_eq!(newest(), Some(5));
        folder.put_snapshot("a", 10, Some(5), &part(10)).unwrap();
        folder.put_record(&record(10)).unwrap();
        assert_eq!(newest(), None, "a record without parts is none either");
        folder.put_snapshot("b.2", 10, Some(5), &part(10)).unwrap();
        assert_eq!(newest(), Some(10));
        folder.put_snapshot("a", 15, Some(10), &part(15)).unwrap();
        assert_eq!(folder.windows("a.snapshot").len(), 2, "at most two are kept");
        assert_eq!(folder.snapshot("a", 10).unwrap().window, 10);
        assert_eq!(folder.windows("a.snapshot"), [10], "what a life that is over has stored later is gone");
    }

    #[test]
    fn what_is_damaged_is_refused_by_name() {
        let place = tempfile::tempdir().unwrap();
        let folder = CheckpointFolder::new(place.path());
        assert!(matches!(folder.snapshot("a", 3), Err(CheckpointError::Unreadable(_))));
        let mut bytes = part(3);
        bytes[20] ^= 1;
        folder.put_snapshot("a", 3, None, &bytes).unwrap();
        assert_eq!(folder.snapshot("a", 3), Err(CheckpointError::Checksum));
    }
}
