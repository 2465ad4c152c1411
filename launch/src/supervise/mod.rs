//! Runs a plan: opens the bus, starts one process per solver, passes on what happens, and leaves nothing behind.

pub(crate) mod child;
pub(crate) mod signals;
mod tail;
pub(crate) mod usage;

use std::ffi::OsString;
use std::process::Command;
use std::thread;
use std::time::Duration;

use cosplat_bus::{BusError, CoordinatorEvent, CoordinatorHandle, CoordinatorHost, JoinTicket, Life, Spin};
use cosplat_core::checkpoint::Checkpoint;
use cosplat_core::coordinator::{Limits, Outcome};
use cosplat_core::participant::Pace;
use cosplat_core::plan::{ParticipantId, Plan};
use cosplat_core::plugin::SolverScene;
use tokio::sync::mpsc::{UnboundedReceiver, unbounded_channel};
use tokio::sync::oneshot;
use tokio::time::{Instant, MissedTickBehavior, interval, timeout_at};

use crate::exit::{Code, Error, Problem};
use crate::folder::RunFolder;
use crate::frames::{FrameRecorder, Frames};
use child::{Child, Exit};
use signals::Signals;
use usage::Usage;

/// Between two looks at what the processes use, and two chances to say how far the run is.
const LOOK: Duration = Duration::from_millis(500);
/// Time for a process to end by itself after the run, and again after it was asked to.
const GRACE: Duration = Duration::from_secs(2);
/// Time for the system to end a process that was killed.
const KILL_GRACE: Duration = Duration::from_secs(5);

/// A run to carry out.
pub(crate) struct Job<'a> {
    /// Its plan.
    pub(crate) plan: &'a Plan,
    /// Each participant's part of the scene, in plan order.
    pub(crate) scenes: Vec<SolverScene>,
    /// Command of each participant, in plan order, program first.
    pub(crate) commands: Vec<Vec<OsString>>,
    /// Deadlines.
    pub(crate) limits: Limits,
    /// Which run this is, and where it begins.
    pub(crate) life: Life,
    /// Where logs go.
    pub(crate) folder: &'a RunFolder,
    /// What takes the frames, where there are any.
    pub(crate) recorder: Option<FrameRecorder>,
}

/// What the owner of a run hears about it.
#[derive(Debug)]
pub(crate) enum News {
    /// A process was started.
    Spawned(ParticipantId, u32),
    /// The coordinator says something.
    Bus(CoordinatorEvent),
    /// A checkpoint is to be stored, and the coordinator to be told when it is.
    Checkpoint(Box<Checkpoint>, CoordinatorHandle),
    /// The user wants the run to end; it does at the edge of this window.
    Stopping(&'static str),
    /// A moment has passed.
    Tick,
}

/// How a run went.
#[derive(Debug)]
pub(crate) struct Ended {
    /// How it ended; `None` when the user would not wait for the edge of a window.
    pub(crate) outcome: Option<Outcome>,
    /// What each process used, in plan order.
    pub(crate) usage: Vec<Usage>,
    /// Last lines of each process on standard error, in plan order.
    pub(crate) last_words: Vec<Vec<String>>,
    /// What was made of the frames; nothing where there are none, or where nobody waited for them.
    pub(crate) frames: Option<Frames>,
}

/// Carries out a run. Must be called on a thread that outlives it: the processes end with the thread that started them.
///
/// # Errors
/// The bus failed, a process could not be started, or `hear` failed. Nothing is left running.
pub(crate) async fn run(
    job: Job<'_>,
    signals: &mut Signals,
    hear: &mut dyn FnMut(News) -> Result<(), Error>,
) -> Result<Ended, Error> {
    let (host, tickets) =
        CoordinatorHost::start_as(job.life, job.plan.clone(), job.scenes, job.limits, Spin::default())
            .map_err(|e| bus_error(&e))?;
    let handle = host.handle();
    let (exit_post, exits) = unbounded_channel();
    let mut children = Vec::with_capacity(tickets.len());
    for (index, (ticket, words)) in tickets.iter().zip(&job.commands).enumerate() {
        let log = job.folder.file(&RunFolder::log_name(&ticket.name));
        let command = command(words, ticket.threads);
        let child = Child::spawn(index, command, &ticket.to_line(), &log, exit_post.clone());
        let child = child.map_err(|e| cannot_start(&ticket.name, words, &e))?;
        hear(News::Spawned(index as ParticipantId, child.pid()))?;
        children.push(child);
    }
    drop(exit_post);
    let recording = job.recorder.zip(tickets.into_iter().nth(children.len())).map(|(r, t)| record(r, t)).transpose()?;
    let (event_post, events) = unbounded_channel();
    let coordinate = move || {
        // The receiver is gone only when the run is being given up.
        host.run(|event| drop(event_post.send(event)))
    };
    let host = thread::Builder::new().name("coordinator".into()).spawn(coordinate).map_err(|e| {
        Error::new(Code::Environment, Problem::new("Cannot start the thread of the coordinator").because(e))
    })?;
    let mut supervisor = Supervisor { children, handle, exits, last_window: job.plan.clock.windows.saturating_sub(1) };
    let watched = supervisor.watch(events, signals, hear).await;
    supervisor.leave(&watched, signals).await;
    let frames = recorded(recording, &watched, signals).await;
    let bus = host.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic));
    let outcome = match watched? {
        Watched::Ended(outcome) => Some(outcome),
        Watched::Impatient => None,
        Watched::BusGone => {
            bus.map_err(|e| bus_error(&e))?;
            return Err(Error::new(Code::Process, Problem::new("The coordinator ended without a word")));
        }
    };
    let frames = match (&outcome, frames) {
        // A run that failed has said why already.
        (Some(Outcome::Failed(_)), _) => None,
        (_, frames) => frames?,
    };
    Ok(Ended {
        outcome,
        frames,
        usage: supervisor.children.iter().map(Child::usage).collect(),
        last_words: supervisor.children.iter().map(|c| c.tail.last()).collect(),
    })
}

/// A recorder at work, and its result once it has ended.
type Recording = oneshot::Receiver<Result<Frames, String>>;

/// Lets a recorder take part in the run, on a thread of its own.
fn record(mut recorder: FrameRecorder, ticket: JoinTicket) -> Result<Recording, Error> {
    let (post, result) = oneshot::channel();
    let work = move || {
        // Why it left is the coordinator's to tell; here it matters what was written.
        let _ = cosplat_bus::serve(&mut recorder, &ticket, Pace::default());
        let _ = post.send(recorder.finish());
    };
    let thread = thread::Builder::new().name("recorder".into()).spawn(work);
    let problem = |e| Error::new(Code::Environment, Problem::new("Cannot start the thread of the recorder").because(e));
    thread.map(|_| result).map_err(problem)
}

/// Waits for the last frames, unless the run was given up or the user is tired of waiting.
async fn recorded(
    recording: Option<Recording>,
    watched: &Result<Watched, Error>,
    signals: &mut Signals,
) -> Result<Option<Frames>, Error> {
    let (Some(recording), Ok(Watched::Ended(_))) = (recording, watched) else { return Ok(None) };
    let failed = |why: String| Error::new(Code::Environment, Problem::new("Cannot write the frames").because(why));
    tokio::select! {
        result = recording => match result {
            Ok(result) => result.map(Some).map_err(failed),
            Err(_) => Err(failed("the thread that takes them panicked".to_owned())),
        },
        _ = signals.next() => Ok(None),
    }
}

/// Why watching ended.
enum Watched {
    /// The coordinator ended the run.
    Ended(Outcome),
    /// The user asked twice.
    Impatient,
    /// The coordinator's loop failed.
    BusGone,
}

/// The processes of a run and what is said to their coordinator.
struct Supervisor {
    children: Vec<Child>,
    handle: CoordinatorHandle,
    exits: UnboundedReceiver<Exit>,
    last_window: u64,
}

impl Supervisor {
    /// Passes everything on until the run ends.
    async fn watch(
        &mut self,
        mut events: UnboundedReceiver<CoordinatorEvent>,
        signals: &mut Signals,
        hear: &mut dyn FnMut(News) -> Result<(), Error>,
    ) -> Result<Watched, Error> {
        let mut looks = interval(LOOK);
        looks.set_missed_tick_behavior(MissedTickBehavior::Delay);
        let mut has_asked = false;
        loop {
            tokio::select! {
                event = events.recv() => match event {
                    None => return Ok(Watched::BusGone),
                    Some(CoordinatorEvent::Ended(outcome)) => return Ok(Watched::Ended(outcome)),
                    Some(CoordinatorEvent::Checkpoint(checkpoint)) => {
                        hear(News::Checkpoint(checkpoint, self.handle.clone()))?;
                    }
                    Some(event) => {
                        self.look_at(&event);
                        hear(News::Bus(event))?;
                    }
                },
                // Exits come in the order in which they happened, so the first that is told is the cause.
                Some(exit) = self.exits.recv() => self.handle.died(exit.index as ParticipantId, exit.how),
                asked = signals.next() => {
                    if std::mem::replace(&mut has_asked, true) {
                        return Ok(Watched::Impatient);
                    }
                    self.handle.stop();
                    hear(News::Stopping(asked))?;
                }
                _ = looks.tick() => {
                    self.children.iter().for_each(Child::sample);
                    hear(News::Tick)?;
                }
            }
        }
    }

    /// Looks at what processes use when they are set up, and before they leave: a short run has no other moment.
    fn look_at(&self, event: &CoordinatorEvent) {
        match event {
            CoordinatorEvent::Ready(who, _) => {
                if let Some(child) = self.children.get(usize::from(*who)) {
                    child.sample();
                }
            }
            CoordinatorEvent::Settled(record, _) if record.window == self.last_window => {
                self.children.iter().for_each(Child::sample);
            }
            _ => {}
        }
    }

    /// Sees every process off: gives those that were told time to leave, then asks, then ends them.
    async fn leave(&mut self, watched: &Result<Watched, Error>, signals: &mut Signals) {
        let were_told = matches!(watched, Ok(Watched::Ended(_)));
        if were_told {
            if self.all_left(GRACE, signals).await {
                return;
            }
            self.children.iter_mut().for_each(Child::terminate);
            if self.all_left(GRACE, signals).await {
                return;
            }
        } else {
            self.handle.vanish();
        }
        self.children.iter().for_each(Child::kill);
        self.all_left(KILL_GRACE, signals).await;
    }

    /// Waits until every process has ended, until the time is over, or until the user is tired of waiting.
    async fn all_left(&mut self, patience: Duration, signals: &mut Signals) -> bool {
        let deadline = Instant::now() + patience;
        loop {
            tokio::select! {
                exit = timeout_at(deadline, self.exits.recv()) => match exit {
                    Ok(Some(_)) => {}
                    // Every process has a thread that reports its end; when none is left to report, all have ended.
                    Ok(None) => return true,
                    Err(_) => return false,
                },
                _ = signals.next() => return false,
            }
        }
    }
}

fn command(words: &[OsString], threads: usize) -> Command {
    let (program, words) = words.split_first().map_or((OsString::new(), [].as_slice()), |(p, w)| (p.clone(), w));
    let mut command = Command::new(program);
    command.args(words).env("RAYON_NUM_THREADS", threads.to_string()).envs(cosplat_bus::config::ENVIRONMENT);
    command
}

fn cannot_start(name: &str, words: &[OsString], error: &std::io::Error) -> Error {
    let words: Vec<_> = words.iter().map(|w| w.to_string_lossy()).collect();
    let problem = Problem::new(format!("Cannot start the process of solver `{name}`"))
        .because(format!("command: {}", words.join(" ")))
        .because(error)
        .hint("`cosplat plugins` says which plugins can be used");
    Error::new(Code::Environment, problem)
}

pub(crate) fn bus_error(error: &BusError) -> Error {
    let code = match error {
        BusError::Random { .. } | BusError::Folder { .. } | BusError::PathTooLong { .. } => Code::Environment,
        BusError::Name { .. } | BusError::Checkpoint(_) => Code::Scene,
        _ => Code::Process,
    };
    Error::new(code, Problem::new("The bus failed").because(error))
}

#[cfg(test)]
mod tests;
