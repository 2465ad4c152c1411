//! Signals that ask this program to end.

use std::io;

use rustix::process::Signal as Named;
use tokio::signal::unix::{Signal, SignalKind, signal};

/// Ctrl-C, a termination request and a closed terminal, which all mean the same here.
#[derive(Debug)]
pub(crate) struct Signals {
    interrupt: Signal,
    terminate: Signal,
    hangup: Signal,
}

impl Signals {
    /// Takes the signals over from the system's default, which would leave processes behind.
    ///
    /// # Errors
    /// The system refuses a handler.
    pub(crate) fn take() -> io::Result<Self> {
        Ok(Self {
            interrupt: signal(SignalKind::interrupt())?,
            terminate: signal(SignalKind::terminate())?,
            hangup: signal(SignalKind::hangup())?,
        })
    }

    /// Waits for the next of them and gives its name.
    pub(crate) async fn next(&mut self) -> &'static str {
        tokio::select! {
            _ = self.interrupt.recv() => "Ctrl-C",
            _ = self.terminate.recv() => "a termination request",
            _ = self.hangup.recv() => "the closing of the terminal",
        }
    }
}

/// Name of a signal by its number, as people know it.
pub(crate) fn name(number: i32) -> &'static str {
    const NAMES: [(Named, &str); 12] = [
        (Named::HUP, "SIGHUP"),
        (Named::INT, "SIGINT"),
        (Named::QUIT, "SIGQUIT"),
        (Named::ILL, "SIGILL"),
        (Named::ABORT, "SIGABRT"),
        (Named::BUS, "SIGBUS"),
        (Named::FPE, "SIGFPE"),
        (Named::KILL, "SIGKILL"),
        (Named::SEGV, "SIGSEGV"),
        (Named::PIPE, "SIGPIPE"),
        (Named::TERM, "SIGTERM"),
        (Named::XCPU, "SIGXCPU"),
    ];
    NAMES.iter().find(|(signal, _)| signal.as_raw() == number).map_or("unnamed", |(_, name)| name)
}
