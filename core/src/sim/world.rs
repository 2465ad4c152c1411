//! The simulated world: machines, a queue of deliveries, and the invariants.

use std::collections::BTreeMap;
use std::time::Duration;

use xxhash_rust::xxh3::xxh3_64;

use super::birth::{EPOCH, fresh_coordinator, fresh_nodes};
use super::host::{Disks, Node};
use super::lives::Rot;
use super::random::Random;
use super::scenario::Scenario;
use crate::checks::{AllChecks, Checks};
use crate::control::Times;
use crate::coordinator::{self, Coordinator, Outcome};
use crate::participant::{self, Answer, Frame, Participant};
use crate::plan::ParticipantId;
use crate::plugin::{Outputs, PluginError};

/// A simulated run that ended as it should.
#[derive(Clone, Debug)]
pub struct Report {
    /// How it ended.
    pub outcome: Outcome,
    /// Chain of all settled states.
    pub state_hash: u128,
    /// Windows settled.
    pub windows: u64,
    /// Deliveries made.
    pub messages: u64,
    /// Times it went on from a checkpoint.
    pub resumed: u32,
}

/// A run in which something did not hold. Invariants as in the project's reliability contract.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("seed {seed}: {what}; replay with `COSPLAT_SIM_SEED={seed} cargo test --release one_seed -- --nocapture`")]
pub struct Violation {
    /// Seed of the scenario.
    pub seed: u64,
    /// What did not hold.
    pub what: String,
}

/// Something on its way.
#[derive(Clone)]
pub(super) enum Delivery {
    Up(ParticipantId, Vec<u8>),
    Down(ParticipantId, Vec<u8>),
    Data(ParticipantId, Frame),
    Resend(ParticipantId, Vec<u8>),
    Computed(ParticipantId, Box<Result<Answer<Outputs>, PluginError>>),
    Stored(ParticipantId, u64, Result<Vec<u8>, String>),
    Recorded(u64, Result<Vec<u8>, String>),
    TickNode(ParticipantId),
    TickCoordinator,
    Trouble,
    Restart,
    Thaw(ParticipantId),
    Buried(ParticipantId),
}

pub(super) struct World<'s, C: Checks> {
    pub(super) scenario: &'s Scenario,
    pub(super) random: Random,
    pub(super) now_us: u64,
    pub(super) order: u64,
    /// What is on its way, with the life it began in.
    pub(super) queue: BTreeMap<(u64, u64), (u32, Delivery)>,
    pub(super) checks: C,
    pub(super) coordinator: Coordinator<C>,
    pub(super) coordinator_alive: bool,
    pub(super) nodes: Vec<Node<C>>,
    /// A second process under a taken name, if the scenario has one.
    pub(super) double: Option<Participant<AllChecks>>,
    pub(super) settled: u64,
    pub(super) last_hash: u128,
    /// Hash of each settled window's row of the ledger.
    pub(super) rows: Vec<u64>,
    pub(super) disks: Disks,
    /// Lives before this one, and when this one began.
    pub(super) life: u32,
    pub(super) began_us: u64,
    /// A new life is about to begin.
    pub(super) restarts: bool,
    /// Lives that began at a checkpoint.
    pub(super) resumed: u32,
    /// Crashes to come.
    pub(super) crashes: u64,
    pub(super) rotten: Option<Rot>,
    /// Messages of this life, and of those before.
    pub(super) overheard: Vec<Delivery>,
    pub(super) old: Vec<Delivery>,
    pub(super) outcome: Option<Outcome>,
    pub(super) broken: Option<String>,
    pub(super) messages: u64,
}

/// Virtual time after which a run counts as hanging \[µs\].
const DEADLINE_US: u64 = 120_000_000;
/// Simulates a scenario. `expected` is the chain of the run without faults.
///
/// # Errors
/// The first invariant that did not hold.
pub fn run<C: Checks + Copy>(scenario: &Scenario, checks: C, expected: Option<u128>) -> Result<Report, Violation> {
    let mut world = World::new(scenario, checks);
    let broken = world.play().or_else(|| world.judge(expected));
    match broken {
        Some(what) => Err(Violation { seed: scenario.seed, what }),
        None => Ok(Report {
            state_hash: world.fingerprint(),
            outcome: world.outcome.unwrap_or(Outcome::Finished),
            windows: world.settled,
            messages: world.messages,
            resumed: world.resumed,
        }),
    }
}

impl<'s, C: Checks + Copy> World<'s, C> {
    fn new(scenario: &'s Scenario, checks: C) -> Self {
        let nodes = fresh_nodes(scenario, 0, 0, checks);
        Self {
            scenario,
            random: Random::new(scenario.seed ^ 0x5eed_5eed),
            now_us: 0,
            order: 0,
            queue: BTreeMap::new(),
            checks,
            coordinator: fresh_coordinator(scenario, EPOCH, checks),
            coordinator_alive: true,
            disks: Disks { snapshots: vec![BTreeMap::new(); nodes.len()], ..Disks::default() },
            nodes,
            double: None,
            settled: 0,
            last_hash: 0,
            rows: Vec::new(),
            life: 0,
            began_us: 0,
            restarts: false,
            resumed: 0,
            crashes: 0,
            rotten: None,
            overheard: Vec::new(),
            old: Vec::new(),
            outcome: None,
            broken: None,
            messages: 0,
        }
    }

    /// All that a run leaves: the chain of the states, the ledger, and what was drawn, which has no part in the chain.
    pub(super) fn fingerprint(&self) -> u128 {
        let rows = xxh3_64(bytemuck::cast_slice(&self.rows));
        self.last_hash ^ u128::from(self.pictures()) ^ (u128::from(rows) << 64)
    }

    pub(super) fn epoch(&self) -> u32 {
        EPOCH + self.life
    }

    /// Time since this life began: processes know no other.
    pub(super) fn now(&self) -> Duration {
        Duration::from_micros(self.now_us - self.began_us)
    }

    pub(super) fn post(&mut self, delay_us: u64, delivery: Delivery) {
        if delivery.travels() {
            self.haunt(&delivery);
        }
        self.schedule(delay_us, delivery);
    }

    pub(super) fn schedule(&mut self, delay_us: u64, delivery: Delivery) {
        self.order += 1;
        self.queue.insert((self.now_us + delay_us, self.order), (self.life, delivery));
    }

    /// Everybody's first sign of life.
    pub(super) fn start(&mut self) {
        for who in 0..self.nodes.len() as ParticipantId {
            let start = self.random.below(3000);
            self.post(start, Delivery::TickNode(who));
        }
        self.post(0, Delivery::TickCoordinator);
    }

    /// Runs until everybody has left. Answers what broke on the way.
    fn play(&mut self) -> Option<String> {
        self.start();
        self.post(self.scenario.trouble_at_us, Delivery::Trouble);
        while let Some(((at, _), (life, delivery))) = self.queue.pop_first() {
            self.now_us = at;
            if life != self.life && !delivery.travels() {
                continue;
            }
            self.messages += 1;
            self.deliver(delivery);
            if self.broken.is_some() {
                return self.broken.take();
            }
            let gone = self.nodes.iter().all(|n| n.ending.is_some() || !n.alive || n.frozen);
            if self.outcome.is_some() && gone && !self.restarts {
                return None;
            }
            if self.now_us > DEADLINE_US {
                return Some(format!("it hangs with {} windows settled (I6)", self.settled));
            }
        }
        Some("nothing is left to happen, yet the run has not ended (I6)".to_owned())
    }

    fn deliver(&mut self, delivery: Delivery) {
        let now = self.now();
        match delivery {
            Delivery::Up(who, bytes) => self.tell_coordinator(coordinator::Event::Up(who, bytes)),
            Delivery::TickCoordinator => {
                self.tell_coordinator(coordinator::Event::Tick);
                self.post(10_000, Delivery::TickCoordinator);
            }
            Delivery::Buried(who) => {
                let how = "signal 9 (SIGKILL)".to_owned();
                self.tell_coordinator(coordinator::Event::Died { who, how });
            }
            Delivery::Trouble => self.make_trouble(),
            Delivery::Restart => self.restart(),
            Delivery::Recorded(window, stored) if self.coordinator_alive => self.record(window, stored),
            Delivery::Recorded(..) => {}
            Delivery::Thaw(who) => {
                self.nodes[usize::from(who)].frozen = false;
                for missed in std::mem::take(&mut self.nodes[usize::from(who)].missed) {
                    self.post(1, missed);
                }
            }
            Delivery::Down(who, bytes) => {
                if let Some(double) = &mut self.double {
                    let seen = double.on(participant::Event::Control(bytes.clone()), now);
                    let joined = seen.iter().any(|a| matches!(a, participant::Action::SetUp(..)));
                    if joined {
                        self.broken = Some("a second process joined under a taken name (I4)".to_owned());
                    }
                }
                self.tell(who, Delivery::Down(who, bytes));
            }
            Delivery::Data(who, _)
            | Delivery::Resend(who, _)
            | Delivery::Computed(who, _)
            | Delivery::Stored(who, ..)
            | Delivery::TickNode(who) => {
                self.tell(who, delivery);
            }
        }
    }

    /// Hands something to a participant, unless it is dead or frozen.
    fn tell(&mut self, who: ParticipantId, delivery: Delivery) {
        let now = self.now();
        let node = &mut self.nodes[usize::from(who)];
        if !node.alive || node.ending.is_some() {
            return;
        }
        if node.frozen {
            node.missed.push(delivery);
            return;
        }
        let event = match delivery {
            Delivery::Stored(_, window, stored) => return self.store(who, window, stored),
            Delivery::Down(_, bytes) => participant::Event::Control(bytes),
            Delivery::Data(_, frame) => participant::Event::Data(frame),
            Delivery::Resend(_, bytes) => participant::Event::Resend(bytes),
            Delivery::Computed(_, result) => participant::Event::Computed(*result, Times::default()),
            _ => participant::Event::Tick,
        };
        let ticked = matches!(event, participant::Event::Tick);
        let actions = node.machine.on(event, now);
        self.carry_out(who, actions);
        if ticked {
            self.post(10_000, Delivery::TickNode(who));
        }
        let node = &self.nodes[usize::from(who)];
        // Streams times the fence and the window behind it: more would be memory a stranger can fill.
        let held = node.machine.inbox().map_or(0, participant::Inbox::held);
        if held > self.scenario.plan.streams.len() * 12 {
            self.broken = Some(format!("participant {who} holds {held} messages (bounded memory)"));
        }
    }

    pub(super) fn tell_coordinator(&mut self, event: coordinator::Event) {
        if !self.coordinator_alive {
            return;
        }
        let now = self.now();
        let actions = self.coordinator.on(event, now);
        for action in actions {
            match action {
                coordinator::Action::Send(to, bytes) => self.send_down(to, &bytes),
                coordinator::Action::Settled(record, dones) => self.check_settled(&record, &dones),
                coordinator::Action::Started => self.check_started(),
                coordinator::Action::Checkpoint(checkpoint) => self.write_checkpoint(&checkpoint),
                coordinator::Action::Ended(outcome) => self.on_ended(outcome),
                coordinator::Action::Ready(..) | coordinator::Action::Notice(_) => {}
            }
        }
    }

    fn on_ended(&mut self, outcome: Outcome) {
        if let (Some(_), Outcome::Stopped { windows }) = (self.scenario.checkpoint_every, &outcome) {
            self.after_stop(*windows);
        }
        self.outcome = Some(outcome);
    }

    /// I2: every window once, in order, with what each participant really computed.
    fn check_settled(&mut self, record: &crate::ledger::WindowRecord, dones: &[crate::control::Done]) {
        if record.window != self.settled {
            self.broken = Some(format!("window {} was settled after {} windows (I2)", record.window, self.settled));
        }
        let row = xxh3_64(&postcard::to_stdvec(record).unwrap_or_default());
        match self.rows.get(self.settled as usize) {
            Some(before) if *before != row => {
                self.broken = Some(format!("window {} has another row than in the life before (I5)", record.window));
            }
            Some(_) => {}
            None => self.rows.push(row),
        }
        self.settled += 1;
        self.last_hash = record.state_hash;
        for (node, done) in self.nodes.iter().zip(dones) {
            let computed = node.states.get(&record.window);
            if done.window != record.window || computed != Some(&done.state_hash) {
                self.broken = Some(format!("window {} was settled with another's report (I2)", record.window));
            }
        }
    }

    fn check_started(&mut self) {
        let deaf = self.nodes.iter().any(|n| !n.machine.inbox().is_some_and(participant::Inbox::all_heard));
        if deaf {
            self.broken = Some("the first window began before every stream was heard".to_owned());
        }
    }
}

impl Delivery {
    /// Whether it is on the bus: what is not dies with the process.
    fn travels(&self) -> bool {
        matches!(self, Self::Up(..) | Self::Down(..) | Self::Data(..) | Self::Resend(..))
    }
}
