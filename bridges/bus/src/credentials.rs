//! Who may enter a run, and the folder only its owner can look into.

use std::fs::{self, DirBuilder, File, OpenOptions};
use std::io::{self, Write as _};
use std::os::unix::fs::{DirBuilderExt as _, OpenOptionsExt as _};
use std::path::{Path, PathBuf};

use cosplat_core::control::RunId;
use cosplat_core::plan::ParticipantId;
use rustix::fs::{FlockOperation, flock};

use crate::error::BusError;
use crate::keys::run_to_hex;

/// Bytes of a unix socket's path, the final zero not counted.
const MAX_SOCKET_PATH: usize = 107;
/// Random bytes of a password.
const PASSWORD_BYTES: usize = 24;
const FOLDER_PREFIX: &str = "cosplat-";
const SOCKET: &str = "bus.sock";
/// zenoh keeps an exclusive lock on this file while it listens; the system releases it when the process dies.
const SOCKET_LOCK: &str = "bus.sock.lock";
const USERS: &str = "users";
/// Longest name of a file in the folder that is bound to an address: two numbers of participants.
const LONGEST_SOCKET: &str = "65535-65535";

/// Random bytes from the system.
fn random<const N: usize>() -> Result<[u8; N], BusError> {
    let mut bytes = [0; N];
    getrandom::fill(&mut bytes).map_err(|e| BusError::Random { why: e.to_string() })?;
    Ok(bytes)
}

/// A new run's identity.
pub(crate) fn new_run() -> Result<RunId, BusError> {
    random()
}

/// A number that tells this process from others of its name.
pub(crate) fn new_instance() -> Result<u64, BusError> {
    Ok(u64::from_le_bytes(random()?))
}

/// A new password: 192 random bits, in characters that need no escaping anywhere.
pub(crate) fn new_password() -> Result<String, BusError> {
    let [low, high] = [random::<{ PASSWORD_BYTES / 2 }>()?, random()?];
    Ok(low.iter().chain(&high).fold(String::new(), |text, byte| text + &format!("{byte:02x}")))
}

/// Folder of a run's socket and passwords, for its owner only. Removed when dropped, however the run ended.
#[derive(Debug)]
pub struct RunFolder {
    path: PathBuf,
}

impl RunFolder {
    /// Makes the folder below `$XDG_RUNTIME_DIR`, or below `/tmp` where there is none.
    ///
    /// # Errors
    /// [`BusError::Folder`], [`BusError::PathTooLong`].
    pub fn new(run: &RunId) -> Result<Self, BusError> {
        let base = std::env::var_os("XDG_RUNTIME_DIR").map(PathBuf::from).filter(|p| p.is_dir());
        Self::below(&base.unwrap_or_else(|| PathBuf::from("/tmp")), run)
    }

    /// Makes the folder below `base`, and removes what killed runs have left there.
    ///
    /// # Errors
    /// [`BusError::Folder`], [`BusError::PathTooLong`], [`BusError::Name`].
    pub fn below(base: &Path, run: &RunId) -> Result<Self, BusError> {
        remove_leftovers(base);
        let path = base.join(format!("{FOLDER_PREFIX}{}", &run_to_hex(run)[..16]));
        let socket = path.join(LONGEST_SOCKET);
        let text = socket.to_string_lossy();
        if text.len() > MAX_SOCKET_PATH {
            return Err(BusError::PathTooLong { path: text.to_string(), bytes: text.len(), limit: MAX_SOCKET_PATH });
        }
        // These separate the parts of a zenoh endpoint.
        if socket.to_str().is_none_or(|p| p.contains(['#', '?', ';', '='])) {
            return Err(BusError::Name {
                name: text.to_string(),
                why: "a socket path must be text without # ? ; =".to_owned(),
            });
        }
        // The mode is given at creation: there is no moment at which others can enter. An existing folder is an error.
        let made = DirBuilder::new().mode(0o700).create(&path);
        made.map_err(|source| folder_error("create the folder", &path, source))?;
        Ok(Self { path })
    }

    /// The folder.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Where the coordinator listens.
    pub fn endpoint(&self) -> String {
        format!("unixsock-stream/{}", self.path.join(SOCKET).display())
    }

    /// Where the first of two partners listens for the second.
    pub fn pair_endpoint(&self, pair: (ParticipantId, ParticipantId)) -> String {
        format!("unixsock-stream/{}", self.path.join(pair_name(pair)).display())
    }

    /// Writes the user names and passwords that may enter the coordinator's bus; answers the file.
    ///
    /// # Errors
    /// [`BusError::Folder`].
    pub fn write_users(&self, users: &[(String, String)]) -> Result<PathBuf, BusError> {
        write_list(self.path.join(USERS), users)
    }

    /// Writes who may enter at the first of two partners; answers the file.
    ///
    /// # Errors
    /// [`BusError::Folder`].
    pub fn write_pair(
        &self,
        pair: (ParticipantId, ParticipantId),
        user: &str,
        password: &str,
    ) -> Result<PathBuf, BusError> {
        let path = self.path.join(format!("{}.{USERS}", pair_name(pair)));
        write_list(path, &[(user.to_owned(), password.to_owned())])
    }
}

fn write_list(path: PathBuf, users: &[(String, String)]) -> Result<PathBuf, BusError> {
    let text = users.iter().fold(String::new(), |text, (user, password)| text + &format!("{user}:{password}\n"));
    let file = OpenOptions::new().write(true).create_new(true).mode(0o600).open(&path);
    file.and_then(|mut file| file.write_all(text.as_bytes()))
        .map_err(|source| folder_error("write the passwords", &path, source))?;
    Ok(path)
}

fn pair_name((first, second): (ParticipantId, ParticipantId)) -> String {
    format!("{first}-{second}")
}

impl Drop for RunFolder {
    fn drop(&mut self) {
        // Nothing can be done about a failure here, and the next run tries again.
        let _ = fs::remove_dir_all(&self.path);
    }
}

fn folder_error(what: &'static str, path: &Path, source: io::Error) -> BusError {
    BusError::Folder { what, path: path.display().to_string(), source }
}

/// Removes folders whose coordinator was killed: the lock beside their socket is free. A folder without a lock may be
/// one that is just being made, and is left alone; so is one that belongs to somebody else.
fn remove_leftovers(base: &Path) {
    let Ok(entries) = fs::read_dir(base) else { return };
    for entry in entries.flatten() {
        let ours = entry.file_name().to_str().is_some_and(|n| n.starts_with(FOLDER_PREFIX));
        let folder = entry.file_type().is_ok_and(|t| t.is_dir());
        if !ours || !folder {
            continue;
        }
        let path = entry.path();
        let Ok(lock) = File::open(path.join(SOCKET_LOCK)) else { continue };
        if path.join(SOCKET).exists() && flock(&lock, FlockOperation::NonBlockingLockExclusive).is_ok() {
            let _ = fs::remove_dir_all(&path);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::os::unix::fs::PermissionsExt as _;

    #[test]
    fn only_the_owner_can_enter_and_nothing_stays() {
        let base = tempfile::tempdir().unwrap();
        let folder = RunFolder::below(base.path(), &[7; 16]).unwrap();
        let users = folder.write_users(&[("a".to_owned(), new_password().unwrap())]).unwrap();
        assert_eq!(fs::metadata(folder.path()).unwrap().permissions().mode() & 0o777, 0o700);
        assert_eq!(fs::metadata(&users).unwrap().permissions().mode() & 0o777, 0o600);
        assert!(RunFolder::below(base.path(), &[7; 16]).is_err(), "a folder that exists is not taken");
        assert!(folder.write_users(&[]).is_err(), "a file that exists is not taken");
        drop(folder);
        assert_eq!(fs::read_dir(base.path()).unwrap().count(), 0);
    }

    #[test]
    fn a_path_that_no_socket_can_have_is_refused_with_its_length() {
        let base = tempfile::tempdir().unwrap();
        let deep = base.path().join("x".repeat(100));
        fs::create_dir(&deep).unwrap();
        let error = RunFolder::below(&deep, &[7; 16]).unwrap_err();
        assert!(matches!(error, BusError::PathTooLong { limit: 107, .. }), "{error}");
    }

    #[test]
    fn leftovers_of_a_killed_run_are_removed_and_a_living_one_is_kept() {
        let base = tempfile::tempdir().unwrap();
        let leave = |name: &str| {
            let path = base.path().join(name);
            fs::create_dir(&path).unwrap();
            fs::write(path.join(SOCKET), "").unwrap();
            File::create(path.join(SOCKET_LOCK)).unwrap()
        };
        drop(leave("cosplat-dead"));
        let lock = leave("cosplat-alive");
        flock(&lock, FlockOperation::NonBlockingLockExclusive).unwrap();
        drop(leave("other-dead"));
        remove_leftovers(base.path());
        assert!(!base.path().join("cosplat-dead").exists());
        assert!(base.path().join("cosplat-alive").exists());
        assert!(base.path().join("other-dead").exists());
    }

    #[test]
    fn passwords_are_long_and_differ() {
        let [a, b] = [new_password().unwrap(), new_password().unwrap()];
        assert_eq!(a.len(), 2 * PASSWORD_BYTES);
        assert_ne!(a, b);
    }
}
