//! What the machine itself has: processors, memory, room, sockets, limits.

use std::fs;
use std::io::{self, Read as _, Write as _};
use std::os::unix::fs::DirBuilderExt as _;
use std::os::unix::net::{UnixListener, UnixStream};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use rustix::process::{Resource, getrlimit};

use super::Check;

const GIB: u64 = 1 << 30;
/// Memory of the default scene with its recorder, and some more.
const MEMORY: u64 = 2 * GIB;
/// Room for a run with pictures and splat files.
const ROOM: u64 = 2 * GIB;
/// Files and sockets that a run of a dozen processes opens, with room to spare.
const OPEN_FILES: u64 = 512;
/// Length of the longest socket path of a run below the folder for sockets: `cosplat-`, 16 digits of the run, a slash and
/// two numbers of participants.
const SOCKET_NAME: usize = 36;
/// Messages there and back.
const ROUND_TRIPS: u32 = 200;
/// A socket that is silent for this long is broken.
const SILENCE: Duration = Duration::from_secs(2);

/// Processors that this program may use.
pub(super) fn processors() -> Check {
    const NAME: &str = "processors";
    match std::thread::available_parallelism().map(usize::from) {
        Ok(1) => Check::lacking(
            NAME,
            "1: solver processes take turns on it",
            "give this program more of them: `nproc --all` says how many there are",
        ),
        Ok(count) => Check::good(NAME, count.to_string()),
        Err(error) => {
            Check::lacking(NAME, format!("cannot be counted: {error}"), "say how many with `cosplat run --threads N`")
        }
    }
}

/// Memory that is free or can be freed.
pub(super) fn memory() -> Check {
    const NAME: &str = "memory";
    let text = fs::read_to_string("/proc/meminfo").unwrap_or_default();
    let of = |key: &str| kib(&text, key).map(|kib| kib << 10);
    match (of("MemTotal:"), of("MemAvailable:")) {
        (Some(total), Some(free)) if free >= MEMORY => {
            Check::good(NAME, format!("{} of {} free", size(free), size(total)))
        }
        (Some(total), Some(free)) => Check::lacking(
            NAME,
            format!("{} of {} free; captures take up to {}", size(free), size(total), size(MEMORY)),
            "end other programs, or give the bodies of a scene a larger `spacing`",
        ),
        _ => Check::lacking(NAME, "/proc/meminfo does not say", "look yourself: `free -h`"),
    }
}

/// Number behind a key of `/proc/meminfo` \[KiB\].
fn kib(text: &str, key: &str) -> Option<u64> {
    let rest = text.lines().find_map(|line| line.strip_prefix(key))?;
    rest.split_whitespace().next()?.parse().ok()
}

/// Room, and whether it may be written to.
pub(super) fn disk(out: &Path) -> Check {
    const NAME: &str = "disk";
    let wanted = std::path::absolute(out).unwrap_or_else(|_| out.to_owned());
    let folder = wanted.ancestors().find(|p| p.exists()).unwrap_or(Path::new("/")).to_owned();
    let shown = out.display();
    let elsewhere = format!("write runs elsewhere: `cosplat run --out {}`", example_folder().display());
    if !folder.is_dir() {
        return Check::broken(NAME, format!("`{}` is no folder", folder.display()), elsewhere);
    }
    let probe = folder.join(format!(".cosplat-doctor-{}", std::process::id()));
    let written = fs::write(&probe, b"cosplat");
    let _ = fs::remove_file(&probe);
    if let Err(error) = written {
        return Check::broken(NAME, format!("`{shown}` cannot be written: {error}"), elsewhere);
    }
    match rustix::fs::statvfs(&folder) {
        Ok(about) => {
            let free = about.f_bavail.saturating_mul(about.f_frsize);
            let found = format!("{} free at `{shown}`", size(free));
            if free >= ROOM { Check::good(NAME, found) } else { Check::lacking(NAME, found, elsewhere) }
        }
        Err(error) => Check::lacking(NAME, format!("nobody knows the room at `{shown}`: {error}"), elsewhere),
    }
}

fn example_folder() -> PathBuf {
    std::env::home_dir().unwrap_or_else(|| PathBuf::from("/var/tmp")).join("cosplat-runs")
}

/// A message there and back through a socket where runs make theirs.
pub(super) fn sockets() -> Check {
    const NAME: &str = "sockets";
    let base = std::env::var_os("XDG_RUNTIME_DIR").map(PathBuf::from).filter(|p| p.is_dir());
    let base = base.unwrap_or_else(|| PathBuf::from("/tmp"));
    // Not named as the folder of a run, which a later run may tidy up.
    let folder = base.join(format!(".cosplat-doctor-{}", std::process::id()));
    let taken = fs::DirBuilder::new().mode(0o700).create(&folder).and_then(|()| {
        let folder_name = folder.file_name().map_or(0, std::ffi::OsStr::len);
        let name = "s".repeat(SOCKET_NAME.saturating_sub(folder_name + 1).max(1));
        round_trips(&folder.join(name))
    });
    let _ = fs::remove_dir_all(&folder);
    match taken {
        Ok(each) => {
            let micros = each.as_secs_f64() * 1e6;
            Check::good(NAME, format!("{micros:.0} µs there and back through `{}`", base.display()))
        }
        Err(error) => Check::broken(
            NAME,
            format!("cannot be used in `{}`: {error}", base.display()),
            "choose a short path of a local disk: `mkdir -m 700 ~/.run && export XDG_RUNTIME_DIR=~/.run`",
        ),
    }
}

/// Mean time of a message of one byte there and back.
fn round_trips(path: &Path) -> io::Result<Duration> {
    let listener = UnixListener::bind(path)?;
    let mut near = UnixStream::connect(path)?;
    let (mut far, _) = listener.accept()?;
    for stream in [&near, &far] {
        stream.set_read_timeout(Some(SILENCE))?;
    }
    let echo = std::thread::spawn(move || -> io::Result<()> {
        let mut byte = [0];
        for _ in 0..ROUND_TRIPS {
            far.read_exact(&mut byte)?;
            far.write_all(&byte)?;
        }
        Ok(())
    });
    let start = Instant::now();
    for k in 0..ROUND_TRIPS {
        let (sent, mut back) = ([k as u8], [0]);
        near.write_all(&sent)?;
        near.read_exact(&mut back)?;
        if sent != back {
            return Err(io::Error::other("another byte came back"));
        }
    }
    let taken = start.elapsed() / ROUND_TRIPS;
    echo.join().unwrap_or_else(|_| Err(io::Error::other("the far end died")))?;
    Ok(taken)
}

/// How many files and sockets a process may open.
pub(super) fn open_files() -> Check {
    const NAME: &str = "open files";
    let limits = getrlimit(Resource::Nofile);
    let shown = |limit: Option<u64>| limit.map_or_else(|| "any number".to_owned(), |n| n.to_string());
    let found = format!("{} allowed, at most {}", shown(limits.current), shown(limits.maximum));
    if limits.current.is_none_or(|n| n >= OPEN_FILES) {
        return Check::good(NAME, found);
    }
    let enough = limits.maximum.is_none_or(|n| n >= OPEN_FILES);
    let mend = if enough { "`ulimit -n 4096`" } else { "ask who runs this machine for a higher limit of `nofile`" };
    Check::lacking(NAME, found, mend)
}

/// Bytes for people.
fn size(bytes: u64) -> String {
    format!("{:.1} GiB", bytes as f64 / GIB as f64)
}

#[cfg(test)]
mod tests {
    use super::super::Status;
    use super::*;

    #[test]
    fn memory_is_read_by_its_key() {
        let text = "MemTotal:       16384 kB\nMemAvailable:    1024 kB\n";
        assert_eq!(
            (kib(text, "MemTotal:"), kib(text, "MemAvailable:"), kib(text, "Swap:")),
            (Some(16_384), Some(1024), None)
        );
    }

    #[test]
    fn a_file_in_the_way_is_no_place_for_runs_and_nothing_is_left_behind() {
        let place = tempfile::tempdir().unwrap();
        let file = place.path().join("out");
        fs::write(&file, "").unwrap();
        assert_eq!(disk(&file.join("deeper")).status, Status::Broken);
        assert_ne!(disk(&place.path().join("new/folder")).status, Status::Broken);
        assert_eq!(fs::read_dir(place.path()).unwrap().count(), 1);
    }

    #[test]
    fn a_path_too_long_for_a_socket_is_an_error() {
        let place = tempfile::tempdir().unwrap();
        assert!(round_trips(&place.path().join("short")).is_ok());
        assert!(round_trips(&place.path().join("l".repeat(200))).is_err());
    }
}
