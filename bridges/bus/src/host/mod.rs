//! The loop around a plugin: it joins a run, calls the plugin when the protocol says so, and leaves.
//!
//! The plugin runs on the thread that called [`run_plugin`], so it may hold what cannot be sent between threads. While
//! it computes, its beats keep the protocol alive; a second thread says that the process lives even when it does not
//! beat.

mod compute;
mod drive;
mod heartbeat;
mod keep;
mod pulse;
mod wire;

use std::io::{IsTerminal as _, Write as _};
use std::process::{self, ExitCode};
use std::thread;
use std::time::Duration;

use cosplat_core::participant::{Ending, Identity, Pace};
use cosplat_core::plugin::Plugin;
use rustix::process::{Signal, getppid, set_parent_process_death_signal};

use crate::credentials::new_instance;
use crate::error::BusError;
use crate::lifeline::Lifeline;
use crate::queue::{Spin, mailbox};
use crate::ticket::JoinTicket;
use drive::{Conclusion, Driver};
use keep::Keeper;
use wire::{Incoming, Wire};

/// Waiting for the ticket.
const TICKET_PATIENCE: Duration = Duration::from_secs(10);
/// Waiting to be let in.
const CONNECT_PATIENCE: Duration = Duration::from_secs(10);
/// Time for an orderly end after the launcher has gone; then the process ends as it is.
const ORPHAN_PATIENCE: Duration = Duration::from_secs(2);

/// Exit codes of a plugin's process.
mod exit {
    pub(super) const DONE: u8 = 0;
    pub(super) const USAGE: u8 = 2;
    pub(super) const PLUGIN: u8 = 4;
    pub(super) const BUS: u8 = 5;
}

/// What the `main` of a plugin calls, and all it has to do.
///
/// With `--describe` among the arguments it prints the plugin's descriptor and ends. Otherwise it reads a join ticket
/// from standard input, takes part in the run and answers with the code the process should end with: 0 when the run
/// is over, 2 when it was called wrongly, 4 when the plugin could not go on, 5 when the bus could not.
pub fn run_plugin(plugin: &mut dyn Plugin) -> ExitCode {
    let name = plugin.describe().name;
    if std::env::args_os().skip(1).any(|a| a == "--describe") {
        return describe(plugin);
    }
    if std::io::stdin().is_terminal() {
        explain(&name);
        return ExitCode::from(exit::USAGE);
    }
    let conclusion = tie_to_parent().and_then(|()| {
        let lifeline = Lifeline::new(std::io::stdin())?;
        let ticket = lifeline.ticket(TICKET_PATIENCE)?;
        serve_with(plugin, &ticket, Pace::default(), Some(lifeline))
    });
    match conclusion {
        Ok(conclusion) => ExitCode::from(report(&name, &conclusion)),
        Err(error) => {
            eprintln!("{name}: {error}");
            if matches!(error, BusError::NoTicket { .. } | BusError::BadTicket { .. }) {
                explain(&name);
                return ExitCode::from(exit::USAGE);
            }
            ExitCode::from(exit::BUS)
        }
    }
}

/// Prints the descriptor as JSON.
pub fn describe(plugin: &dyn Plugin) -> ExitCode {
    let text = serde_json::to_string_pretty(&plugin.describe());
    let printed = text.map_err(std::io::Error::from).and_then(|text| writeln!(std::io::stdout(), "{text}"));
    match printed {
        Ok(()) => ExitCode::from(exit::DONE),
        Err(error) => {
            eprintln!("cannot print the descriptor: {error}");
            ExitCode::from(exit::USAGE)
        }
    }
}

/// Takes part in a run as the holder of `ticket`, without a launcher: for tests and for processes that are not
/// children of `cosplat`.
///
/// # Errors
/// [`BusError`] when the run could not be joined.
pub fn serve(plugin: &mut dyn Plugin, ticket: &JoinTicket, pace: Pace) -> Result<Ending, BusError> {
    serve_with(plugin, ticket, pace, None).map(|c| c.ending)
}

fn serve_with(
    plugin: &mut dyn Plugin,
    ticket: &JoinTicket,
    pace: Pace,
    lifeline: Option<Lifeline>,
) -> Result<Conclusion, BusError> {
    let (post, mailbox) = mailbox(Spin::default());
    if let Some(lifeline) = lifeline {
        let post = post.clone();
        lifeline.at_end(move || {
            post.send(Incoming::LauncherGone);
            // The plugin may be deep in a computation that does not beat; nobody is left to want its result.
            thread::sleep(ORPHAN_PATIENCE);
            process::exit(i32::from(exit::BUS));
        });
    }
    let identity = Identity {
        run: ticket.run_id()?,
        epoch: ticket.epoch,
        name: ticket.name.clone(),
        instance: new_instance()?,
        pid: process::id(),
        descriptor: plugin.describe(),
    };
    let keeper = Keeper::new(ticket, post.clone());
    let wire = Wire::open(ticket, CONNECT_PATIENCE, post)?;
    Driver::new(identity, pace, wire, mailbox, keeper)?.run(plugin)
}

/// Ends this process with its parent, whatever it is doing then.
///
/// Linux sends the signal when the *thread* that started this process ends: a launcher must start its solvers from one
/// that lives as long as the run.
fn tie_to_parent() -> Result<(), BusError> {
    let before = getppid();
    // Where the system lacks it the life-line still works.
    let _ = set_parent_process_death_signal(Some(Signal::KILL));
    // A parent that ended earlier sends no signal, but its child has been given to another one.
    if getppid() == before { Ok(()) } else { Err(BusError::ParentGone) }
}

/// Says how it ended where that is not as it should be, and turns it into an exit code.
fn report(name: &str, conclusion: &Conclusion) -> u8 {
    match &conclusion.ending {
        Ending::Finished | Ending::Aborted(_) => exit::DONE,
        Ending::Failed(message) => {
            eprintln!("{name}: {message}");
            if conclusion.plugin_failed { exit::PLUGIN } else { exit::BUS }
        }
        Ending::Refused(reason) => {
            eprintln!("{name}: the coordinator refused it: {reason}");
            exit::BUS
        }
        Ending::Orphaned => {
            eprintln!("{name}: the coordinator is gone");
            exit::BUS
        }
    }
}

fn explain(name: &str) {
    eprintln!(
        "{name} is a Cosplat solver plugin: `cosplat` starts it and tells it on standard input which run to join.\n\
         By hand, `--describe` prints what it can do. To use it, name it in a scene (`solver = \"{name}\"`) and run\n\
         `cosplat run SCENE`, or see `cosplat plugins` for what is found."
    );
}
