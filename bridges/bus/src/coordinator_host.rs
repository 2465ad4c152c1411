//! The coordinator's side of the bus: the router everybody connects to for control, and the loop around the
//! coordinator's machine.

use std::thread;
use std::time::{Duration, Instant};

use cosplat_core::checkpoint::Checkpoint;
use cosplat_core::control::{Done, PROTOCOL, ReadyInfo, RunId};
use cosplat_core::coordinator::{Action, Coordinator, Event, Limits, Outcome};
use cosplat_core::ledger::WindowRecord;
use cosplat_core::plan::{ParticipantId, Plan};
use cosplat_core::plugin::SolverScene;

use crate::config;
use crate::credentials::{RunFolder, new_password, new_run};
use crate::error::BusError;
use crate::keys::{Keys, run_to_hex};
use crate::life::Life;
use crate::partners::introduce;
use crate::queue::{Mailbox, Post, Spin, mailbox};
use crate::session::{Bus, Lane, Outlet, Payload};
use crate::ticket::JoinTicket;

/// Time for everybody to say goodbye once the run has ended.
const LINGER: Duration = Duration::from_secs(1);
/// Messages taken before the clock is looked at again, so that a flood cannot stop it.
const BATCH: usize = 256;
/// Least time between two ticks, whatever the machine asks for.
const TICK_GAP: Duration = Duration::from_millis(5);

/// What the run's owner hears about it, in order.
#[derive(Debug)]
pub enum CoordinatorEvent {
    /// A participant has joined and is set up.
    Ready(ParticipantId, Box<ReadyInfo>),
    /// Everybody hears everybody; the first window begins.
    Started,
    /// A window is settled.
    Settled(Box<WindowRecord>, Vec<Done>),
    /// All participants have stored their parts of this checkpoint. To be stored as well, and answered with
    /// [`CoordinatorHandle::recorded`]: only then is there a next one.
    Checkpoint(Box<Checkpoint>),
    /// Something people should read.
    Notice(String),
    /// Windows end here. Comes exactly once, unless the loop itself fails; nothing follows it.
    Ended(Outcome),
}

/// What the coordinator's loop is told.
#[derive(Debug)]
enum Incoming {
    Up(ParticipantId, Payload),
    Presence(ParticipantId, bool),
    Died(ParticipantId, String),
    Recorded(u64, Result<(), String>),
    Stop,
    Vanish,
}

/// Speaks to a running coordinator from other threads.
#[derive(Clone, Debug)]
pub struct CoordinatorHandle(Post<Incoming>);

impl CoordinatorHandle {
    /// A participant's process has ended, for whatever reason.
    pub fn died(&self, who: ParticipantId, how: impl Into<String>) {
        self.0.send(Incoming::Died(who, how.into()));
    }

    /// The checkpoint of the start of this window is stored, or why it could not be.
    pub fn recorded(&self, window: u64, answer: Result<(), String>) {
        self.0.send(Incoming::Recorded(window, answer));
    }

    /// End at the next window edge.
    pub fn stop(&self) {
        self.0.send(Incoming::Stop);
    }

    /// Leave without a word, as a killed process does. For tests of what participants make of that.
    pub fn vanish(&self) {
        self.0.send(Incoming::Vanish);
    }
}

/// A run's open bus and its coordinator, not yet running.
pub struct CoordinatorHost {
    coordinator: Coordinator,
    names: Vec<String>,
    run: RunId,
    outlets: Vec<Outlet>,
    bus: Bus,
    mailbox: Mailbox<Incoming>,
    handle: CoordinatorHandle,
    started: Instant,
    ticked: Duration,
    present: Vec<bool>,
    /// Last, so that the session is gone when the folder of its socket goes.
    _folder: RunFolder,
}

impl CoordinatorHost {
    /// Opens a new run's bus and makes a ticket for each participant, in plan order. The run's time starts here.
    ///
    /// No window waits for the coordinator, so [`Spin::NONE`] leaves the cores to the solvers at no cost in speed.
    ///
    /// # Errors
    /// [`BusError`]; nothing stays behind.
    pub fn start(
        plan: Plan,
        scenes: Vec<SolverScene>,
        limits: Limits,
        spin: Spin,
    ) -> Result<(Self, Vec<JoinTicket>), BusError> {
        Self::start_as(Life::first()?, plan, scenes, limits, spin)
    }

    /// As [`Self::start`], with an identity that is known, or from a checkpoint.
    ///
    /// # Errors
    /// [`BusError`], [`BusError::Checkpoint`] when the checkpoint is of something else; nothing stays behind.
    pub fn start_as(
        life: Life,
        plan: Plan,
        scenes: Vec<SolverScene>,
        limits: Limits,
        spin: Spin,
    ) -> Result<(Self, Vec<JoinTicket>), BusError> {
        // zenoh refuses to wait on a thread that drives a single-threaded tokio runtime; whose thread this is, is the
        // caller's business, so the session is opened on one of our own.
        let opener = thread::Builder::new().name("bus-open".to_owned());
        let opened = opener.spawn(move || Self::open(life, &plan, scenes, limits, spin));
        let opened = opened.map_err(|source| BusError::Thread { name: "bus-open", source })?.join();
        opened.unwrap_or_else(|panic| std::panic::resume_unwind(panic))
    }

    fn open(
        life: Life,
        plan: &Plan,
        scenes: Vec<SolverScene>,
        limits: Limits,
        spin: Spin,
    ) -> Result<(Self, Vec<JoinTicket>), BusError> {
        let Life { run, epoch, checkpoints, from } = life;
        let coordinator = Coordinator::new(run, epoch, plan.clone(), scenes, limits);
        let coordinator = match from {
            Some(checkpoint) => coordinator.resumed(*checkpoint)?,
            None => coordinator,
        };
        let keys = Keys::new(&run);
        // A name of its own: a life that was killed may have left its folder behind.
        let folder = RunFolder::new(&new_run()?)?;
        let names: Vec<String> = plan.participants.iter().map(|p| p.name.clone()).collect();
        let users = names.iter().map(|n| Ok((n.clone(), new_password()?))).collect::<Result<Vec<_>, BusError>>()?;
        let endpoint = folder.endpoint();
        let config = config::coordinator(plan, &keys, &endpoint, &folder.write_users(&users)?)?;
        let bus = Bus::open(config, "the coordinator", &endpoint)?;
        let (post, mailbox) = mailbox(spin);
        let mut outlets = Vec::with_capacity(names.len());
        for (name, who) in names.iter().zip(0..) {
            let (heard, seen) = (post.clone(), post.clone());
            // The access list lets only `name` put on this key: the key is the proof of who speaks.
            bus.subscribe(&keys.ack(name), move |p| heard.send(Incoming::Up(who, p)))?;
            bus.watch_presence(&keys.live(name), move |here| seen.send(Incoming::Presence(who, here)))?;
            outlets.push(bus.publisher(keys.ctl(name), Lane::Control)?);
        }
        let partners = introduce(plan, &folder)?;
        let holders = plan.participants.iter().zip(&users).zip(partners);
        let tickets = holders.map(|((participant, (user, password)), partners)| JoinTicket {
            protocol: PROTOCOL,
            run: run_to_hex(&run),
            name: participant.name.clone(),
            endpoint: endpoint.clone(),
            user: user.clone(),
            password: password.clone(),
            threads: participant.threads,
            partners,
            epoch,
            checkpoints: checkpoints.clone(),
        });
        let tickets = tickets.collect();
        let host = Self {
            present: vec![false; names.len()],
            coordinator,
            names,
            run,
            outlets,
            bus,
            mailbox,
            handle: CoordinatorHandle(post),
            started: Instant::now(),
            ticked: Duration::ZERO,
            _folder: folder,
        };
        Ok((host, tickets))
    }

    /// Identity of the run.
    pub fn run_id(&self) -> RunId {
        self.run
    }

    /// For other threads.
    pub fn handle(&self) -> CoordinatorHandle {
        self.handle.clone()
    }

    /// Coordinates the run until it has ended and everybody has left or a second has passed; then closes the bus and
    /// removes its folder. Blocks: give it a thread of its own.
    ///
    /// # Errors
    /// [`BusError`] when the bus itself fails.
    pub fn run(mut self, mut sink: impl FnMut(CoordinatorEvent)) -> Result<(), BusError> {
        let result = self.coordinate(&mut sink);
        let Self { outlets, bus, .. } = self;
        drop(outlets);
        bus.close();
        result
    }

    fn coordinate(&mut self, sink: &mut impl FnMut(CoordinatorEvent)) -> Result<(), BusError> {
        let mut ended: Option<Instant> = None;
        loop {
            for _ in 0..BATCH {
                let Some(message) = self.mailbox.try_receive() else { break };
                if self.take(message, &mut ended, sink)? {
                    return Ok(());
                }
            }
            let now = self.started.elapsed();
            let due = self.coordinator.next_deadline().max(self.ticked + TICK_GAP);
            if due <= now {
                self.ticked = now;
                self.feed(Event::Tick, &mut ended, sink)?;
                continue;
            }
            let mut deadline = self.started + due;
            if let Some(at) = ended {
                if self.coordinator.all_left() || at.elapsed() >= LINGER {
                    return Ok(());
                }
                deadline = deadline.min(at + LINGER);
            }
            if let Some(message) = self.mailbox.receive_until(deadline)
                && self.take(message, &mut ended, sink)?
            {
                return Ok(());
            }
        }
    }

    /// True when the loop should end at once.
    fn take(
        &mut self,
        message: Incoming,
        ended: &mut Option<Instant>,
        sink: &mut impl FnMut(CoordinatorEvent),
    ) -> Result<bool, BusError> {
        let event = match message {
            Incoming::Up(who, payload) => Event::Up(who, payload.into_vec()),
            Incoming::Died(who, how) => Event::Died { who, how },
            Incoming::Recorded(window, answer) => Event::Recorded(window, answer),
            Incoming::Stop => Event::Stop,
            Incoming::Vanish => return Ok(true),
            Incoming::Presence(who, here) => {
                self.note_presence(usize::from(who), here, ended.is_some(), sink);
                return Ok(false);
            }
        };
        self.feed(event, ended, sink)?;
        Ok(false)
    }

    fn feed(
        &mut self,
        event: Event,
        ended: &mut Option<Instant>,
        sink: &mut impl FnMut(CoordinatorEvent),
    ) -> Result<(), BusError> {
        for action in self.coordinator.on(event, self.started.elapsed()) {
            let heard = match action {
                Action::Send(who, bytes) => {
                    if let Some(outlet) = self.outlets.get(usize::from(who)) {
                        outlet.send(bytes)?;
                    }
                    continue;
                }
                // What still settles or is noticed while everybody leaves is of no interest any more.
                _ if ended.is_some() => continue,
                Action::Ready(who, info) => CoordinatorEvent::Ready(who, info),
                Action::Started => CoordinatorEvent::Started,
                Action::Settled(record, done) => CoordinatorEvent::Settled(record, done),
                Action::Checkpoint(checkpoint) => CoordinatorEvent::Checkpoint(checkpoint),
                Action::Notice(text) => CoordinatorEvent::Notice(text),
                Action::Ended(outcome) => {
                    *ended = Some(Instant::now());
                    CoordinatorEvent::Ended(outcome)
                }
            };
            sink(heard);
        }
        Ok(())
    }

    /// Liveliness is a hint: it is said, and nothing follows from it.
    fn note_presence(&mut self, who: usize, here: bool, ended: bool, sink: &mut impl FnMut(CoordinatorEvent)) {
        let (Some(present), Some(name)) = (self.present.get_mut(who), self.names.get(who)) else { return };
        let left = std::mem::replace(present, here) && !here;
        if left && !ended {
            sink(CoordinatorEvent::Notice(format!("`{name}` is no longer connected to the bus")));
        }
    }
}
