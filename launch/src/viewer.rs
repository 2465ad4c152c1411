//! The rerun viewer, which is another program: found, opened beside a run, or offered to a browser.
//!
//! A window belongs to the user: it stays when the run is over. What serves a browser ends with the run, also where this
//! program is killed: a shell around it waits for the end of its standard input, which is held open here.

use std::io;
use std::net::{Ipv4Addr, SocketAddr, TcpListener, TcpStream};
use std::os::unix::process::CommandExt as _;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::Duration;

use crate::cli::RunArgs;
use crate::frames::LiveTo;
use crate::plugins::discover::on_path;

/// How to get the viewer.
pub(crate) const INSTALL: &str = "pip install rerun-sdk==0.36.3";
/// Port at which viewers listen by themselves, and at which a run looks for one.
const PORT: u16 = 9876;
/// Port of the page that holds the viewer.
const PAGE_PORT: u16 = 9090;
/// Memory for what a browser that comes later is given; the oldest is dropped beyond.
const MEMORY: &str = "512MB";
/// A viewer opens in a few seconds; a run that is over earlier waits for it so that it is seen at all.
const OPENING: Duration = Duration::from_secs(10);
/// Somebody who listens on this machine answers at once.
const ANSWER: Duration = Duration::from_millis(200);

/// Where `--live` shows a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Place {
    /// In a window of its own.
    Window,
    /// In what listens there.
    At(SocketAddr),
}

/// What a run was asked to be shown in.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Wish {
    /// A viewer that listens there, now or later.
    At(SocketAddr),
    /// A window of its own.
    Window(PathBuf),
    /// A browser on this machine.
    Browser(PathBuf),
}

/// A viewer beside a run.
#[derive(Debug)]
pub(crate) struct Viewer {
    /// Where frames go.
    pub(crate) to: LiveTo,
    /// What to tell the user.
    pub(crate) says: String,
    /// What serves a browser; ends when it is dropped.
    _served: Option<Served>,
}

/// Ends with this program and at the latest when it is dropped.
#[derive(Debug)]
struct Served(Child);

impl Wish {
    /// What the command line asks for; words for the user where it cannot be had.
    pub(crate) fn of(args: &RunArgs) -> Result<Option<Self>, String> {
        let program = || {
            on_path("rerun").ok_or_else(|| {
                format!("there is no rerun viewer on the path; `{INSTALL}` gets it; the run goes on without")
            })
        };
        match (args.live, args.serve) {
            (Some(Place::At(address)), _) => Ok(Some(Self::At(address))),
            (_, true) => program().map(|rerun| Some(Self::Browser(rerun))),
            (Some(Place::Window), false) => program().map(|rerun| Some(Self::Window(rerun))),
            (None, false) => Ok(None),
        }
    }

    /// Starts what is wished.
    ///
    /// # Errors
    /// The program cannot be started, or no port is free.
    pub(crate) fn open(&self) -> io::Result<Viewer> {
        match self {
            Self::At(address) => {
                let command = format!("rerun --bind 127.0.0.1 --port {}", address.port());
                let says =
                    format!("shown by whatever viewer listens at {address}; `{command}` opens one, now or later");
                Ok(Viewer { to: LiveTo { address: *address, patience: Duration::ZERO }, says, _served: None })
            }
            Self::Window(rerun) => window(rerun),
            Self::Browser(rerun) => browser(rerun),
        }
    }
}

fn here(port: u16) -> SocketAddr {
    SocketAddr::from((Ipv4Addr::LOCALHOST, port))
}

/// The viewer that is open already, or a new one.
fn window(rerun: &Path) -> io::Result<Viewer> {
    let address = here(PORT);
    let viewer =
        |says: &str, patience| Viewer { to: LiveTo { address, patience }, says: says.to_owned(), _served: None };
    if TcpStream::connect_timeout(&address, ANSWER).is_ok() {
        return Ok(viewer("shown in the viewer that is open", Duration::ZERO));
    }
    let has_display = ["DISPLAY", "WAYLAND_DISPLAY"].iter().any(|name| std::env::var_os(name).is_some());
    if cfg!(target_os = "linux") && !has_display {
        let says = "there is no display for a window; `--serve` shows the run in a browser, and a viewer that is opened \
                    with `rerun --bind 127.0.0.1` is found during the run";
        return Ok(viewer(says, Duration::ZERO));
    }
    let mut command = Command::new(rerun);
    command.args(["--bind", "127.0.0.1", "--port", &PORT.to_string(), "--expect-data-soon"]);
    // A group of its own: Ctrl-C on the terminal ends the run and leaves the window.
    quiet(&mut command).stdin(Stdio::null()).process_group(0).spawn()?;
    Ok(viewer("shown in a viewer that stays open after the run", OPENING))
}

/// A page for browsers on this machine.
fn browser(rerun: &Path) -> io::Result<Viewer> {
    let (data, page) = (free_port(PORT)?, free_port(PAGE_PORT)?);
    let mut command = Command::new("sh");
    // `kill 0` ends the group that the shell leads, and so whatever the viewer has started.
    command.args(["-c", "\"$@\" </dev/null & read -r _; kill -KILL 0", "sh"]).arg(rerun);
    command.args(["--serve-web", "--bind", "127.0.0.1", "--server-memory-limit", MEMORY]);
    command.args(["--port", &data.to_string(), "--web-viewer-port", &page.to_string()]);
    let served = Served(quiet(&mut command).stdin(Stdio::piped()).process_group(0).spawn()?);
    let says = format!(
        "http://127.0.0.1:{page}/?url=rerun%2Bhttp%3A%2F%2F127.0.0.1%3A{data}%2Fproxy shows the run in a browser on this \
         machine until it ends"
    );
    Ok(Viewer { to: LiveTo { address: here(data), patience: OPENING }, says, _served: Some(served) })
}

fn quiet(command: &mut Command) -> &mut Command {
    command.stdout(Stdio::null()).stderr(Stdio::null())
}

/// The port, or another where it is taken.
fn free_port(wanted: u16) -> io::Result<u16> {
    let listener = TcpListener::bind(here(wanted)).or_else(|_| TcpListener::bind(here(0)))?;
    Ok(listener.local_addr()?.port())
}

impl Drop for Served {
    fn drop(&mut self) {
        // The end of its standard input ends the shell and its group.
        drop(self.0.stdin.take());
        let _ = self.0.wait();
    }
}

/// `window`, a port of this machine, or a loopback address and a port.
pub(crate) fn parse_place(text: &str) -> Result<Place, String> {
    if text == "window" {
        return Ok(Place::Window);
    }
    let address = text.parse().or_else(|_| text.parse::<u16>().map(here));
    match address {
        Ok(address) if address.ip().is_loopback() && address.port() != 0 => Ok(Place::At(address)),
        Ok(_) => {
            Err("a run is shown on this machine only; for another one, carry a port over with `ssh -R`".to_owned())
        }
        Err(_) => Err("expected a port or an address of this machine, as in `9876` or `127.0.0.1:9876`".to_owned()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_this_machine_is_an_address() {
        assert_eq!(parse_place("window"), Ok(Place::Window));
        assert_eq!(parse_place("9876"), Ok(Place::At(here(9876))));
        assert_eq!(parse_place("127.0.0.1:1234"), Ok(Place::At(here(1234))));
        assert!(parse_place("[::1]:1234").is_ok());
        assert!(parse_place("192.168.0.1:9876").unwrap_err().contains("this machine only"));
        assert!(["", "0", "x", "127.0.0.1", "99999"].iter().all(|t| parse_place(t).is_err()));
    }

    #[test]
    fn what_serves_a_browser_ends_with_its_owner() {
        let mut command = Command::new("sh");
        command.args(["-c", "\"$@\" </dev/null & read -r _; kill -KILL 0", "sh", "sleep", "1000"]);
        let child = command.stdin(Stdio::piped()).process_group(0).spawn().unwrap();
        let group = rustix::process::Pid::from_raw(i32::try_from(child.id()).unwrap()).unwrap();
        let begin = std::time::Instant::now();
        drop(Served(child));
        assert!(begin.elapsed() < Duration::from_secs(5));
        // Killed members are reaped by the system a moment later.
        let is_there = || rustix::process::test_kill_process_group(group).is_ok();
        while is_there() && begin.elapsed() < Duration::from_secs(5) {
            std::thread::sleep(Duration::from_millis(10));
        }
        assert!(!is_there());
    }
}
