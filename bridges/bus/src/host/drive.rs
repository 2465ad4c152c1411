//! Between the state machine, the wire and the plugin: events in, actions carried out in order.

use std::collections::VecDeque;
use std::time::{Duration, Instant};

use cosplat_core::participant::{Action, Ending, Event, Identity, Pace, Participant};
use cosplat_core::plugin::{Plugin, PluginError};

use super::compute::{self, Stopwatch};
use super::heartbeat::Heartbeat;
use super::keep::Keeper;
use super::wire::{Incoming, Wire};
use crate::error::BusError;
use crate::queue::Mailbox;

/// Messages taken before the clock is looked at again, so that a flood cannot stop it.
const BATCH: usize = 256;
/// Least time between two ticks, whatever the machine asks for.
const TICK_GAP: Duration = Duration::from_millis(5);

/// How it ended.
#[derive(Debug)]
pub(crate) struct Conclusion {
    pub(crate) ending: Ending,
    /// The plugin itself could not go on, as against the bus.
    pub(crate) plugin_failed: bool,
}

/// Everything of a participant but its plugin.
pub(crate) struct Driver {
    participant: Participant,
    wire: Wire,
    mailbox: Mailbox<Incoming>,
    heartbeat: Heartbeat,
    pub(super) keeper: Keeper,
    started: Instant,
    head_start: Duration,
    ticked: Duration,
    /// Actions that have not been carried out.
    work: VecDeque<Action>,
    /// Set once there is nothing more to do but leave.
    ending: Option<Ending>,
    plugin_failed: bool,
    pub(super) watch: Stopwatch,
}

impl Driver {
    pub(crate) fn new(
        identity: Identity,
        pace: Pace,
        wire: Wire,
        mailbox: Mailbox<Incoming>,
        keeper: Keeper,
    ) -> Result<Self, BusError> {
        let heartbeat = Heartbeat::start(wire.ack(), identity.run, identity.instance, pace.heartbeat)?;
        Ok(Self {
            participant: Participant::new(identity, pace),
            wire,
            mailbox,
            heartbeat,
            keeper,
            started: Instant::now(),
            // The machine's clock starts one repetition in, so that the first greeting is due at once.
            head_start: pace.repeat,
            ticked: Duration::ZERO,
            work: VecDeque::new(),
            ending: None,
            plugin_failed: false,
            watch: Stopwatch::default(),
        })
    }

    /// Takes part until the end, then leaves the bus.
    pub(crate) fn run(mut self, plugin: &mut dyn Plugin) -> Result<Conclusion, BusError> {
        let ending = self.participate(plugin);
        let Self { wire, heartbeat, plugin_failed, .. } = self;
        drop(heartbeat);
        wire.close();
        ending.map(|ending| Conclusion { ending, plugin_failed })
    }

    fn participate(&mut self, plugin: &mut dyn Plugin) -> Result<Ending, BusError> {
        self.tick();
        loop {
            self.work_off(plugin)?;
            if let Some(ending) = self.ending.take() {
                return Ok(ending);
            }
            // Everything that has arrived comes before the tick: after a long computation it holds signs of life that
            // the machine would otherwise miss.
            let arrived = (0..BATCH).find_map(|_| self.take_one());
            if arrived.is_none() {
                self.wait();
            }
        }
    }

    /// Takes a message that is there already. `Some` when that gave something to do.
    fn take_one(&mut self) -> Option<()> {
        let message = self.mailbox.try_receive()?;
        self.take(message);
        (!self.work.is_empty() || self.ending.is_some()).then_some(())
    }

    /// Waits for a message, or for the moment at which the machine wants to be asked again.
    fn wait(&mut self) {
        let due = self.participant.next_deadline().max(self.ticked + TICK_GAP);
        if due <= self.now() {
            return self.tick();
        }
        let waited = Instant::now();
        let message = self.mailbox.receive_until(self.started + due.saturating_sub(self.head_start));
        self.watch.waited(waited.elapsed());
        match message {
            Some(message) => self.take(message),
            None => self.tick(),
        }
    }

    fn now(&self) -> Duration {
        self.started.elapsed() + self.head_start
    }

    pub(super) fn feed(&mut self, event: Event) {
        let now = self.now();
        self.work.extend(self.participant.on(event, now));
    }

    fn tick(&mut self) {
        self.ticked = self.now();
        self.feed(Event::Tick);
    }

    fn take(&mut self, message: Incoming) {
        match message {
            Incoming::Control(payload) => self.feed(Event::Control(payload.into_vec())),
            Incoming::Data(payload) => self.feed(Event::Data(payload.into_vec().into())),
            Incoming::Resend(payload) => self.feed(Event::Resend(payload.into_vec())),
            Incoming::Stored(window, answer) => self.feed(Event::Saved(window, answer)),
            Incoming::LauncherGone => self.ending = Some(Ending::Orphaned),
        }
    }

    /// Carries out all actions, in order; what the plugin answers may add more.
    fn work_off(&mut self, plugin: &mut dyn Plugin) -> Result<(), BusError> {
        while self.ending.is_none() {
            let Some(action) = self.work.pop_front() else { return Ok(()) };
            let Some(action) = self.send(action)? else { continue };
            match action {
                Action::SetUp(scene, show) => compute::set_up(self, plugin, &scene, &show),
                Action::Connect(partners) => compute::connect(self, plugin, &partners),
                Action::Compute(job) => compute::advance(self, plugin, &job),
                Action::Restore(state) => compute::restore(self, plugin, &state),
                Action::Save(snapshot, keep) => compute::save(self, plugin, *snapshot, keep),
                _ => {}
            }
        }
        Ok(())
    }

    /// Carries out an action that needs no plugin; gives the others back.
    fn send(&mut self, action: Action) -> Result<Option<Action>, BusError> {
        match action {
            Action::Control(bytes) => {
                self.heartbeat.spoke(self.participant.epoch());
                self.wire.ack().send(bytes)?;
            }
            Action::Publish(stream, frame) => self.wire.publish(stream, &frame)?,
            Action::Request(from, bytes) => self.wire.request(from, bytes)?,
            Action::Declare => {
                if let (Some(plan), Some(id)) = (self.participant.plan(), self.participant.id()) {
                    self.wire.declare(plan, id)?;
                }
            }
            Action::Load(window) => {
                let found = self.keeper.load(window);
                self.feed(Event::Loaded(found));
            }
            Action::Exit(ending) => self.ending = Some(ending),
            plugin_work => return Ok(Some(plugin_work)),
        }
        Ok(None)
    }

    /// Keeps the protocol going from inside a computation. True while the computation should go on.
    pub(super) fn breathe(&mut self, done: u64, of: u64) -> bool {
        self.feed(Event::Beat { done, of });
        while let Some(message) = self.mailbox.try_receive() {
            self.take(message);
        }
        if self.participant.next_deadline().max(self.ticked + TICK_GAP) <= self.now() {
            self.tick();
        }
        // What needs the plugin waits until it is free.
        for action in std::mem::take(&mut self.work) {
            match self.send(action) {
                Ok(kept) => self.work.extend(kept),
                // Without a connection there is nobody left to compute for.
                Err(_) => self.ending = Some(Ending::Orphaned),
            }
        }
        self.ending.is_none()
    }

    /// The plugin's answer, unless it no longer matters.
    pub(super) fn answer(&mut self, event: Event) {
        if self.ending.is_none() {
            self.feed(event);
        }
    }

    /// Remembers whose fault it was.
    pub(super) fn note_failure<T>(&mut self, answer: &Result<T, PluginError>) {
        self.plugin_failed |= answer.is_err();
    }

    pub(super) fn heartbeat(&self) -> &Heartbeat {
        &self.heartbeat
    }
}
