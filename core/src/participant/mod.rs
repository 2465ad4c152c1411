//! A solver's side of the protocol, without a socket or a clock.
//!
//! The host feeds [`Event`]s and carries out the [`Action`]s it gets back, in order. Everything that can go wrong on a
//! network is therefore an argument, and can be replayed.

mod api;
mod fault;
mod fetch;
mod gather;
mod inbox;
mod join;
mod moment;
mod outbox;
mod repeat;
mod resume;
mod window;

use std::time::Duration;

use crate::checkpoint::Snapshot;
use crate::checks::{AllChecks, Check, Checks};
use crate::control::{self, Done, Down, Envelope, FailureKind, PROTOCOL, Progress, ReadyInfo, Up};
use crate::plan::{ParticipantId, Plan};
use crate::plugin::{PluginError, SolverScene};

pub use api::{Action, Answer, Ending, Event, Frame, Identity, Job, Pace};
pub use inbox::{Inbox, Reject, Taken};
pub use outbox::{Outbox, OutputError};

use fetch::Fetch;
use resume::Saving;
use window::Underway;

/// Where a participant is in its life.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Phase {
    Greeting,
    Fetching,
    Loading,
    SettingUp,
    Ready,
    Probing,
    Running,
    Failing,
    Ended,
}

/// Everything that exists once the coordinator has said welcome.
#[derive(Debug)]
struct Joined {
    id: ParticipantId,
    plan: Plan,
    scene: SolverScene,
    inbox: Inbox,
    outbox: Outbox,
    ready: ReadyInfo,
    /// The plugin has been told its partners.
    connecting: bool,
    /// It has taken them, and stands where the run begins.
    connected: bool,
    /// Identity of what it computes.
    identity: u128,
    /// First window to compute.
    from: u64,
    /// Where a resumed run takes it up, until the plugin is there.
    snapshot: Option<Box<Snapshot>>,
    /// Hash of its state there.
    restored: Option<u128>,
}

/// The state machine.
#[derive(Debug)]
pub struct Participant<C: Checks = AllChecks> {
    identity: Identity,
    pace: Pace,
    checks: C,
    phase: Phase,
    greeted: bool,
    fetch: Fetch,
    joined: Option<Joined>,
    until: u64,
    committed: u64,
    underway: Underway,
    unsettled: Vec<(u64, Box<Done>)>,
    saving: Saving,
    /// Why it cannot go on, and since when.
    failure: Option<(FailureKind, String, Duration)>,
    progress: Progress,
    heard_at: Duration,
    said_at: Duration,
    asked_at: Duration,
    beat_at: Duration,
}

impl Participant {
    /// A participant that has not said hello yet; the first [`Event::Tick`] makes it.
    pub fn new(identity: Identity, pace: Pace) -> Self {
        Self::with_checks(identity, pace, AllChecks)
    }
}

impl<C: Checks> Participant<C> {
    /// The same with checks switched off, for the simulation.
    pub fn with_checks(identity: Identity, pace: Pace, checks: C) -> Self {
        Self {
            identity,
            pace,
            checks,
            phase: Phase::Greeting,
            greeted: false,
            fetch: Fetch::default(),
            joined: None,
            until: 0,
            committed: 0,
            underway: Underway::default(),
            unsettled: Vec::new(),
            saving: Saving::default(),
            failure: None,
            progress: Progress::default(),
            heard_at: Duration::ZERO,
            said_at: Duration::ZERO,
            asked_at: Duration::ZERO,
            beat_at: Duration::ZERO,
        }
    }

    /// The plan, once welcomed.
    pub fn plan(&self) -> Option<&Plan> {
        self.joined.as_ref().map(|j| &j.plan)
    }

    /// Place in the plan, once welcomed.
    pub fn id(&self) -> Option<ParticipantId> {
        self.joined.as_ref().map(|j| j.id)
    }

    /// Incarnation of the coordinator, once welcomed; 0 before.
    pub fn epoch(&self) -> u32 {
        self.joined.as_ref().map_or(0, |_| self.identity.epoch)
    }

    /// Where it is, for heartbeats and for people.
    pub fn progress(&self) -> Progress {
        self.progress
    }

    /// First window that is not finished here, and the first not settled.
    pub fn windows(&self) -> (u64, u64) {
        (self.underway.window, self.committed)
    }

    /// What has arrived, for tests and counters.
    pub fn inbox(&self) -> Option<&Inbox> {
        self.joined.as_ref().map(|j| &j.inbox)
    }

    /// Moment of the next useful [`Event::Tick`].
    pub fn next_deadline(&self) -> Duration {
        if !self.greeted {
            return Duration::ZERO;
        }
        let repeat = self.said_at.min(self.asked_at) + self.pace.repeat;
        if self.phase == Phase::Greeting { repeat } else { repeat.min(self.beat_at + self.pace.heartbeat) }
    }

    /// Takes one event and says what to do.
    pub fn on(&mut self, event: Event, now: Duration) -> Vec<Action> {
        if self.phase == Phase::Ended {
            return Vec::new();
        }
        let mut out = Vec::new();
        match event {
            Event::Control(bytes) => self.on_control(&bytes, now, &mut out),
            Event::Data(frame) => self.on_data(frame, now, &mut out),
            Event::Resend(bytes) => self.on_resend(&bytes, &mut out),
            Event::SetUp(answer) => self.on_set_up(answer, now, &mut out),
            Event::Connected(answer) => self.on_connected(answer, now, &mut out),
            Event::Loaded(found) => self.on_loaded(found, now, &mut out),
            Event::Restored(answer) => self.on_restored(answer, now, &mut out),
            Event::Saved(window, answer) => self.on_saved(window, answer, now, &mut out),
            Event::Computed(answer, times) => self.on_computed(answer, times, now, &mut out),
            Event::Beat { done, of } => {
                self.progress.substep = done;
                self.progress.substeps = of;
            }
            Event::Tick => self.on_tick(now, &mut out),
        }
        out
    }

    fn on_control(&mut self, bytes: &[u8], now: Duration, out: &mut Vec<Action>) {
        let Ok(envelope) = control::decode::<Down>(bytes) else { return };
        if envelope.protocol != PROTOCOL
            || (self.checks.on(Check::ControlRun) && envelope.run != self.identity.run)
            || (self.checks.on(Check::ControlInstance) && envelope.instance != self.identity.instance)
        {
            return;
        }
        if envelope.epoch != self.identity.epoch && self.checks.on(Check::ControlEpoch) {
            return;
        }
        self.heard_at = now;
        match envelope.body {
            // A second copy of the welcome must not undo what the first began.
            Down::Welcome { .. } if self.phase != Phase::Greeting => {}
            Down::Welcome { id, plan, scene, assets, from } => {
                self.on_welcome(id, from, [&plan, &scene], assets, now, out);
            }
            Down::Chunk { asset, chunk, bytes } => self.on_chunk(asset, chunk, bytes, now, out),
            Down::Refused { reason } => self.end(Ending::Refused(reason), out),
            Down::Probe => self.on_probe(now, out),
            Down::Start if self.phase == Phase::Probing || self.phase == Phase::Ready => {
                self.phase = Phase::Running;
                self.advance(now, out);
            }
            Down::Start => {}
            Down::Grant { until, committed, save } => {
                self.on_save(save, now, out);
                self.on_grant(until, committed, now, out);
            }
            Down::Finish => self.leave(Ending::Finished, now, out),
            Down::Abort { reason } => {
                let own = self.failure.take().map(|(_, message, _)| Ending::Failed(message));
                self.leave(own.unwrap_or(Ending::Aborted(reason)), now, out);
            }
        }
    }

    fn on_data(&mut self, frame: Frame, now: Duration, out: &mut Vec<Action>) {
        let Some(joined) = &mut self.joined else { return };
        let taken = joined.inbox.take(frame, &self.checks);
        if matches!(taken, Some(Taken::Part)) {
            // More of it is on its way: it is too early to ask for it again.
            self.asked_at = now;
        }
        match taken {
            Some(Taken::Probe(_)) => self.report_probes(now, out),
            Some(Taken::Whole(_)) if self.phase == Phase::Running => self.advance(now, out),
            Some(Taken::Whole(_)) => {
                self.try_connect(now, out);
                self.report_probes(now, out);
            }
            Some(Taken::Part) | None => {}
        }
    }

    fn on_grant(&mut self, until: u64, committed: u64, now: Duration, out: &mut Vec<Action>) {
        self.until = self.until.max(until);
        if committed > self.committed {
            self.committed = committed;
            self.unsettled.retain(|(window, _)| *window >= committed);
            if let Some(joined) = &mut self.joined {
                joined.outbox.settle(&joined.plan, committed);
            }
        }
        self.advance(now, out);
    }

    fn say(&mut self, message: Up, now: Duration, out: &mut Vec<Action>) {
        self.said_at = now;
        out.push(self.envelope(message));
    }

    fn envelope(&self, body: Up) -> Action {
        Action::Control(self.wrap(body))
    }

    fn wrap<M: serde::Serialize>(&self, body: M) -> Vec<u8> {
        control::encode(&Envelope {
            protocol: PROTOCOL,
            run: self.identity.run,
            epoch: self.identity.epoch,
            instance: self.identity.instance,
            body,
        })
    }

    fn fail_plugin(&mut self, error: &PluginError, now: Duration, out: &mut Vec<Action>) {
        let kind = match error {
            PluginError::Unsupported(_) => FailureKind::Unsupported,
            // After an abort this machine has ended already; without one, the plugin stopped by itself.
            PluginError::Physics(_) | PluginError::Aborted => FailureKind::Physics,
            PluginError::State(_) | PluginError::Contract(_) => FailureKind::Bus,
            PluginError::Environment(_) => FailureKind::Environment,
        };
        self.fail(kind, error.to_string(), now, out);
    }

    /// Says why until it is heard: the coordinator answers with an abort.
    fn fail(&mut self, kind: FailureKind, message: String, now: Duration, out: &mut Vec<Action>) {
        self.say(Up::Failed { kind, message: message.clone() }, now, out);
        self.phase = Phase::Failing;
        self.failure = Some((kind, message, now));
    }

    fn leave(&mut self, ending: Ending, now: Duration, out: &mut Vec<Action>) {
        self.say(Up::Bye, now, out);
        self.end(ending, out);
    }

    fn end(&mut self, ending: Ending, out: &mut Vec<Action>) {
        self.phase = Phase::Ended;
        out.push(Action::Exit(ending));
    }
}
