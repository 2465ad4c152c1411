//! The lock-step clock: joins participants, settles windows, ends the run. No socket, no timer, no disk.
//!
//! The coordinator is not on the critical path: participants start a window when the data they need is there, at most
//! [`Limits::ahead`] windows beyond the last settled one. A window is settled when every participant has reported it
//! and what each consumed is what another produced. Deadlines and deaths only end a run, with a reason that says who.

mod api;
mod assets;
mod checkpoint;
mod end;
mod settle;

use std::collections::BTreeMap;
use std::time::Duration;

use crate::checks::{AllChecks, Check, Checks};
use crate::control::{self, Done, Down, Envelope, FailureKind, PROTOCOL, Progress, ReadyInfo, RunId, Save, Up};
use crate::ledger::Ledger;
use crate::plan::{ParticipantId, Plan, StreamId};
use crate::plugin::SolverScene;

use assets::Shipment;
use checkpoint::Saving;

pub use api::{Action, Event, Failure, Limits, Outcome};

/// Where the run is in its life.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Phase {
    Joining,
    Probing,
    Running,
    Ended,
}

/// What is known of one participant.
#[derive(Debug, Default)]
struct Peer {
    instance: Option<u64>,
    ready: Option<Box<ReadyInfo>>,
    probed: bool,
    heard_at: Duration,
    noticed: bool,
    progress: Progress,
    died: Option<(Duration, String)>,
    left: bool,
}

/// The state machine.
#[derive(Debug)]
pub struct Coordinator<C: Checks = AllChecks> {
    run: RunId,
    epoch: u32,
    plan: Plan,
    plan_json: String,
    scenes: Vec<SolverScene>,
    shipments: Vec<Shipment>,
    limits: Limits,
    checks: C,
    phase: Phase,
    peers: Vec<Peer>,
    ledger: Option<Ledger>,
    /// Reports of windows not settled, by window.
    pending: BTreeMap<u64, Vec<Option<Done>>>,
    /// Content of recent messages, by stream and index.
    produced: BTreeMap<(StreamId, u64), u64>,
    /// First window of this incarnation.
    from: u64,
    committed: u64,
    until: u64,
    chain: u128,
    /// Hash of each participant's state after the last settled window.
    states: Vec<u128>,
    /// The checkpoint that is being made.
    saving: Option<Saving>,
    /// Edge of the last one that was stored or given up, and of the last one that was stored.
    saved: u64,
    recorded: Option<u64>,
    stop_at: Option<u64>,
    farewell: Option<Down>,
    strangers: u64,
    said_at: Duration,
    settled_at: Duration,
    noticed_wait: u64,
}

impl Coordinator {
    /// A coordinator that waits for the participants of `plan`; `scenes` are their parts, in the same order.
    pub fn new(run: RunId, epoch: u32, plan: Plan, scenes: Vec<SolverScene>, limits: Limits) -> Self {
        Self::with_checks(run, epoch, plan, scenes, limits, AllChecks)
    }
}

impl<C: Checks> Coordinator<C> {
    /// The same with checks switched off, for the simulation.
    pub fn with_checks(
        run: RunId,
        epoch: u32,
        plan: Plan,
        mut scenes: Vec<SolverScene>,
        limits: Limits,
        checks: C,
    ) -> Self {
        // Without a grant nobody would ever begin.
        let limits = Limits { ahead: limits.ahead.max(1), ..limits };
        let peers = plan.participants.iter().map(|_| Peer::default()).collect();
        // A plan is plain data: names, numbers and lists of them.
        let plan_json = serde_json::to_string(&plan).unwrap_or_default();
        Self {
            run,
            epoch,
            plan,
            plan_json,
            shipments: scenes.iter_mut().map(Shipment::unload).collect(),
            scenes,
            limits,
            checks,
            phase: Phase::Joining,
            peers,
            ledger: None,
            pending: BTreeMap::new(),
            produced: BTreeMap::new(),
            from: 0,
            committed: 0,
            until: 0,
            chain: 0,
            states: Vec::new(),
            saving: None,
            saved: 0,
            recorded: None,
            stop_at: None,
            farewell: None,
            strangers: 0,
            said_at: Duration::ZERO,
            settled_at: Duration::ZERO,
            noticed_wait: 0,
        }
    }

    /// Windows settled.
    pub fn settled(&self) -> u64 {
        self.committed
    }

    /// First window not granted.
    pub fn granted(&self) -> u64 {
        self.until
    }

    /// Chain of all settled states.
    pub fn state_hash(&self) -> u128 {
        self.chain
    }

    /// Messages that belonged to nobody here.
    pub fn strangers(&self) -> u64 {
        self.strangers
    }

    /// Whether every participant has said goodbye or died.
    pub fn all_left(&self) -> bool {
        self.peers.iter().all(|p| p.left || p.died.is_some())
    }

    /// Moment of the next useful [`Event::Tick`].
    pub fn next_deadline(&self) -> Duration {
        self.said_at + self.limits.repeat
    }

    /// Takes one event and says what to do.
    pub fn on(&mut self, event: Event, now: Duration) -> Vec<Action> {
        let mut out = Vec::new();
        match event {
            Event::Up(who, bytes) if usize::from(who) < self.peers.len() => self.on_up(who, &bytes, now, &mut out),
            Event::Up(..) => self.strangers += 1,
            Event::Died { who, how } => self.on_died(who, how, now),
            Event::Recorded(window, answer) => self.on_recorded(window, answer, &mut out),
            Event::Stop => self.on_stop(&mut out),
            Event::Tick => self.on_tick(now, &mut out),
        }
        out
    }

    fn on_up(&mut self, who: ParticipantId, bytes: &[u8], now: Duration, out: &mut Vec<Action>) {
        if let Some(theirs) = control::protocol_of(bytes).filter(|v| *v != PROTOCOL && self.phase == Phase::Joining) {
            return self.refuse_version(who, theirs.to_string(), out);
        }
        let Ok(envelope) = control::decode::<Up>(bytes) else {
            self.strangers += 1;
            return;
        };
        let greets = matches!(envelope.body, Up::Hello { .. });
        if self.is_foreign(&envelope, greets, who) {
            self.strangers += 1;
            if greets && (envelope.run, envelope.epoch) == (self.run, self.epoch) {
                self.refuse_second(who, envelope.instance, out);
            }
            return;
        }
        let peer = &mut self.peers[usize::from(who)];
        peer.heard_at = now;
        peer.noticed = false;
        match envelope.body {
            Up::Hello { protocol, .. } if protocol[0] > PROTOCOL || protocol[1] < PROTOCOL => {
                self.refuse_version(who, format!("{}..={}", protocol[0], protocol[1]), out);
            }
            Up::Hello { name, .. } => self.on_hello(who, &name, envelope.instance, out),
            Up::Fetch { asset, chunk } => self.on_fetch(who, asset, chunk, out),
            Up::Ready(info) => self.on_ready(who, info, out),
            Up::Probed { streams, restored } => self.on_probed(who, &streams, restored, now, out),
            Up::Done(done) => self.on_done(who, *done, now, out),
            Up::Heartbeat(progress) => self.peers[usize::from(who)].progress = progress,
            Up::Saved { window, problem } => self.on_saved(who, window, problem, out),
            Up::Failed { kind, message } => self.on_failed(who, kind, message, out),
            Up::Bye => self.peers[usize::from(who)].left = true,
        }
    }

    /// Of another run, another incarnation, or another process under the same name.
    fn is_foreign(&self, envelope: &Envelope<Up>, greets: bool, who: ParticipantId) -> bool {
        let known = self.peers[usize::from(who)].instance;
        let other_instance = known.is_some_and(|i| i != envelope.instance) || (known.is_none() && !greets);
        (self.checks.on(Check::ControlRun) && envelope.run != self.run)
            || (self.checks.on(Check::ControlEpoch) && envelope.epoch != self.epoch)
            || (self.checks.on(Check::ControlInstance) && other_instance)
    }

    fn on_hello(&mut self, who: ParticipantId, name: &str, instance: u64, out: &mut Vec<Action>) {
        let expected = self.plan.name_of(who).to_owned();
        if name != expected {
            let message = format!("it calls itself `{name}`");
            return self.fail(Failure::Protocol { who: expected, window: 0, message }, out);
        }
        if self.phase == Phase::Ended {
            let reason = "the run has ended".to_owned();
            out.push(self.send_to(who, instance, Down::Refused { reason }));
            return;
        }
        self.peers[usize::from(who)].instance = Some(instance);
        let scene = self.scenes.get(usize::from(who)).and_then(|s| serde_json::to_string(s).ok()).unwrap_or_default();
        let assets = self.shipments.get(usize::from(who)).map(|s| s.infos.clone()).unwrap_or_default();
        let welcome = Down::Welcome { id: who, plan: self.plan_json.clone(), scene, assets, from: self.from };
        out.push(self.send(who, welcome));
    }

    /// Tells a second process under a taken name that it is not wanted.
    fn refuse_second(&mut self, who: ParticipantId, instance: u64, out: &mut Vec<Action>) {
        let name = self.plan.name_of(who).to_owned();
        let reason = format!("`{name}` has joined this run already");
        out.push(self.send_to(who, instance, Down::Refused { reason }));
        out.push(Action::Notice(format!("a second process tried to join as `{name}` and was refused")));
    }

    fn refuse_version(&mut self, who: ParticipantId, theirs: String, out: &mut Vec<Action>) {
        if self.phase == Phase::Ended {
            return;
        }
        let name = self.plan.name_of(who).to_owned();
        self.fail(Failure::Version { who: name, theirs, ours: PROTOCOL }, out);
    }

    fn on_ready(&mut self, who: ParticipantId, info: Box<ReadyInfo>, out: &mut Vec<Action>) {
        if self.peers[usize::from(who)].ready.is_some() || self.phase != Phase::Joining {
            // It says so again because it has not heard the answer.
            if self.phase == Phase::Probing {
                out.push(self.send(who, Down::Probe));
            }
            return;
        }
        if let Err(failure) = self.takes_up(who, &info) {
            return self.fail(failure, out);
        }
        for id in self.published_before(who, self.from) {
            let Some(content) = settle::listed(&info.produced, id) else {
                let message = "it did not publish all its boundaries at the start".to_owned();
                return self.fail(self.broke(who, self.from, message), out);
            };
            self.produced.insert((id.stream, id.index), content);
        }
        self.peers[usize::from(who)].ready = Some(info.clone());
        out.push(Action::Ready(who, info));
        if self.peers.iter().all(|p| p.ready.is_some()) {
            self.phase = Phase::Probing;
            self.tell_all(&Down::Probe, out);
        }
    }

    fn on_probed(
        &mut self,
        who: ParticipantId,
        streams: &[StreamId],
        restored: Option<u128>,
        now: Duration,
        out: &mut Vec<Action>,
    ) {
        if self.phase == Phase::Running {
            // It has not heard the start.
            out.push(self.send(who, Down::Start));
            out.push(self.send(who, self.grant()));
            return;
        }
        if self.phase != Phase::Probing {
            return;
        }
        if let Err(failure) = self.has_state(who, restored) {
            return self.fail(failure, out);
        }
        let heard_all = self.plan.read_by(who).all(|(id, _)| streams.contains(&id));
        self.peers[usize::from(who)].probed |= heard_all;
        let enough = self.peers.iter().all(|p| p.probed) || !self.checks.on(Check::WaitForProbes);
        if enough {
            self.start(now, out);
        }
    }

    fn start(&mut self, now: Duration, out: &mut Vec<Action>) {
        self.phase = Phase::Running;
        self.settled_at = now;
        self.until = (self.from + self.limits.ahead).min(self.plan.clock.windows);
        let ready: Vec<&ReadyInfo> = self.peers.iter().filter_map(|p| p.ready.as_deref()).collect();
        let opened = || Ledger::open(&self.plan, &self.scenes, &ready);
        self.ledger = Some(self.ledger.take().unwrap_or_else(opened));
        self.plan_save();
        self.tell_all(&Down::Start, out);
        self.tell_all(&self.grant(), out);
        out.push(Action::Started);
        if self.from >= self.plan.clock.windows {
            self.finish(Outcome::Finished, out);
        }
    }

    fn on_failed(&mut self, who: ParticipantId, kind: FailureKind, message: String, out: &mut Vec<Action>) {
        let window = self.window_of(who);
        let who = self.plan.name_of(who).to_owned();
        let failure = match kind {
            FailureKind::Unsupported => Failure::Unsupported { who, message },
            FailureKind::Physics => Failure::Physics { who, window, message },
            FailureKind::Bus => Failure::Protocol { who, window, message },
            FailureKind::Environment => Failure::Environment { who, window, message },
        };
        self.fail(failure, out);
    }

    /// First window that a participant has not reported.
    fn window_of(&self, who: ParticipantId) -> u64 {
        let reported =
            |w: &u64| self.pending.get(w).is_some_and(|dones| dones.get(usize::from(who)).is_some_and(Option::is_some));
        (self.committed..self.until).find(|w| !reported(w)).unwrap_or(self.until)
    }

    fn grant(&self) -> Down {
        let save = self.saving.as_ref().map(|s| Save { at: s.edge, keep: self.recorded });
        Down::Grant { until: self.until, committed: self.committed, save }
    }

    fn tell_all(&self, message: &Down, out: &mut Vec<Action>) {
        let all = 0..self.peers.len() as ParticipantId;
        out.extend(all.map(|who| self.send(who, message.clone())));
    }

    fn send(&self, who: ParticipantId, body: Down) -> Action {
        let instance = self.peers[usize::from(who)].instance.unwrap_or_default();
        self.send_to(who, instance, body)
    }

    fn send_to(&self, who: ParticipantId, instance: u64, body: Down) -> Action {
        let envelope = Envelope { protocol: PROTOCOL, run: self.run, epoch: self.epoch, instance, body };
        Action::Send(who, control::encode(&envelope))
    }
}
