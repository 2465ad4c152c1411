//! One solver process: started, watched, and ended with everything it has started.
//!
//! A process leads a process group of its own, so that Ctrl-C on the terminal reaches this program only, and so that
//! what the process starts can be ended with it. Its standard input carries the ticket and then stays open: its end
//! tells the process that this program is gone, whatever happened to it.

use std::fs::File;
use std::io::{self, Write as _};
use std::os::unix::process::{CommandExt as _, ExitStatusExt as _};
use std::path::Path;
use std::process::{ChildStdin, Command, ExitStatus, Stdio};
use std::sync::mpsc;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread;
use std::time::Duration;

use rustix::process::{Pid, Signal, WaitId, WaitIdOptions, kill_process_group, waitid};
use tokio::sync::mpsc::UnboundedSender;

use super::signals;
use super::tail::Tail;
use super::usage::Usage;

/// Longest wait for the rest of a pipe whose process has ended; somebody else may hold it open.
const REST_OF_PIPE: Duration = Duration::from_millis(300);

/// A process has ended.
#[derive(Clone, Debug)]
pub(crate) struct Exit {
    /// Number given to [`Child::spawn`].
    pub(crate) index: usize,
    /// `exit code 3`, `signal 9 (SIGKILL)`.
    pub(crate) how: String,
}

/// What the thread that reaps a process shares with its owner.
#[derive(Debug)]
struct Shared {
    /// The process group; `None` once the process is reaped and its number may belong to another.
    group: Option<Pid>,
    usage: Usage,
}

/// A solver process.
#[derive(Debug)]
pub(crate) struct Child {
    pid: u32,
    shared: Arc<Mutex<Shared>>,
    /// Open as long as this program lives.
    life_line: Option<ChildStdin>,
    /// Last lines on standard error.
    pub(crate) tail: Tail,
}

impl Child {
    /// Starts a process, hands it its ticket and watches it. Its end is sent to `exits` once.
    ///
    /// The calling thread must live as long as the process: on Linux the system tells the process when the *thread*
    /// that started it ends.
    ///
    /// # Errors
    /// The program cannot be started or its log cannot be written.
    pub(crate) fn spawn(
        index: usize,
        mut command: Command,
        ticket: &str,
        log: &Path,
        exits: UnboundedSender<Exit>,
    ) -> io::Result<Self> {
        // An earlier life of the run may have written to it; the folder of a new run has none.
        let log = File::options().create(true).append(true).open(log)?;
        command.stdin(Stdio::piped()).stdout(Stdio::null()).stderr(Stdio::piped()).process_group(0);
        let mut child = command.spawn()?;
        let pid = child.id();
        let group = i32::try_from(pid).ok().and_then(Pid::from_raw);
        let shared = Arc::new(Mutex::new(Shared { group, usage: Usage::default() }));
        let tail = Tail::default();
        // From here on the process is ended with `this`, whatever fails below.
        let mut this = Self { pid, shared: Arc::clone(&shared), life_line: child.stdin.take(), tail: tail.clone() };
        if let Some(stdin) = &mut this.life_line {
            // A ticket fits into the pipe. If nobody will read it, the process is about to end and says why itself.
            let _ = stdin.write_all(ticket.as_bytes());
        }
        let (read_all, has_read_all) = mpsc::channel::<()>();
        if let Some(stderr) = child.stderr.take() {
            thread::Builder::new().name(format!("stderr-{index}")).spawn(move || {
                tail.fill(stderr, log);
                drop(read_all);
            })?;
        }
        thread::Builder::new().name(format!("reaper-{index}")).spawn(move || {
            wait_for_end(group);
            let how = reap(&mut child, &shared);
            // Nothing is ever sent: this waits for the reader to be done.
            let _ = has_read_all.recv_timeout(REST_OF_PIPE);
            // Nobody listens any more when this program is on its way out.
            let _ = exits.send(Exit { index, how });
        })?;
        Ok(this)
    }

    /// Process number, for people.
    pub(crate) fn pid(&self) -> u32 {
        self.pid
    }

    /// Whether the process has not been reaped yet.
    #[cfg(test)]
    pub(crate) fn is_running(&self) -> bool {
        lock(&self.shared).group.is_some()
    }

    /// Looks at what the process has used so far.
    pub(crate) fn sample(&self) {
        let mut shared = lock(&self.shared);
        if shared.group.is_some() {
            shared.usage.sample(self.pid);
        }
    }

    /// What the process has used, as far as it was seen.
    pub(crate) fn usage(&self) -> Usage {
        lock(&self.shared).usage
    }

    /// Asks the process and all it has started to end.
    pub(crate) fn terminate(&mut self) {
        self.life_line = None;
        self.signal(Signal::TERM);
    }

    /// Ends the process and all it has started.
    pub(crate) fn kill(&self) {
        self.signal(Signal::KILL);
    }

    fn signal(&self, signal: Signal) {
        // Held while the signal is sent, so that the number cannot pass to another process in between.
        let shared = lock(&self.shared);
        if let Some(group) = shared.group {
            // The group may have emptied by itself, which is what was wanted.
            let _ = kill_process_group(group, signal);
        }
    }
}

/// Whatever happens to this program while it can still act, the process does not outlive its owner.
impl Drop for Child {
    fn drop(&mut self) {
        self.kill();
    }
}

/// Waits until the process has ended, and leaves it to be looked at.
fn wait_for_end(group: Option<Pid>) {
    let Some(pid) = group else { return };
    while let Err(rustix::io::Errno::INTR) = waitid(WaitId::Pid(pid), WaitIdOptions::EXITED | WaitIdOptions::NOWAIT) {}
}

/// Takes the last look at a process that has ended, ends what it has left behind, and lets the system forget it.
fn reap(child: &mut std::process::Child, shared: &Mutex<Shared>) -> String {
    let mut shared = lock(shared);
    shared.usage.sample(child.id());
    if let Some(group) = shared.group.take() {
        // While the ended process has not been reaped its number is its own, so this meets no stranger.
        let _ = kill_process_group(group, Signal::KILL);
    }
    match child.wait() {
        Ok(status) => describe(status),
        Err(e) => format!("an end that could not be seen: {e}"),
    }
}

/// How a process ended, in words.
pub(crate) fn describe(status: ExitStatus) -> String {
    match (status.code(), status.signal()) {
        (Some(code), _) => format!("exit code {code}"),
        (None, Some(signal)) => format!("signal {signal} ({})", signals::name(signal)),
        (None, None) => "unknown end".into(),
    }
}

fn lock(shared: &Mutex<Shared>) -> MutexGuard<'_, Shared> {
    // Both fields are whole at every moment, so a panic elsewhere cannot have left them half done.
    shared.lock().unwrap_or_else(PoisonError::into_inner)
}
