//! The simulated world: machines, a queue of deliveries, and the invariants.

use std::collections::BTreeMap;
use std::time::Duration;

use super::random::Random;
use super::scenario::Scenario;
use super::toy::{Toy, descriptor};
use crate::checks::{AllChecks, Checks};
use crate::control::Times;
use crate::coordinator::{self, Coordinator, Limits, Outcome};
use crate::participant::{self, Answer, Ending, Frame, Identity, Job, Pace, Participant};
use crate::plan::{ParticipantId, schedule};
use crate::plugin::{Outputs, Plugin, PluginError, StateHasher, Steady};

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
pub(super) enum Delivery {
    Up(ParticipantId, Vec<u8>),
    Down(ParticipantId, Vec<u8>),
    Data(ParticipantId, Frame),
    Resend(ParticipantId, Vec<u8>),
    Computed(ParticipantId, Box<Result<Answer<Outputs>, PluginError>>),
    TickNode(ParticipantId),
    TickCoordinator,
    Trouble,
    Thaw(ParticipantId),
    Buried(ParticipantId),
}

pub(super) struct Node<C: Checks> {
    pub(super) machine: Participant<C>,
    pub(super) plugin: Toy,
    pub(super) alive: bool,
    pub(super) frozen: bool,
    pub(super) missed: Vec<Delivery>,
    pub(super) states: Vec<u128>,
    pub(super) ending: Option<Ending>,
}

pub(super) struct World<'s, C: Checks> {
    pub(super) scenario: &'s Scenario,
    pub(super) random: Random,
    pub(super) now_us: u64,
    pub(super) order: u64,
    pub(super) queue: BTreeMap<(u64, u64), Delivery>,
    pub(super) coordinator: Coordinator<C>,
    pub(super) nodes: Vec<Node<C>>,
    /// A second process under a taken name, if the scenario has one.
    pub(super) double: Option<Participant<AllChecks>>,
    pub(super) settled: u64,
    pub(super) last_hash: u128,
    pub(super) outcome: Option<Outcome>,
    pub(super) broken: Option<String>,
    pub(super) messages: u64,
}

/// Virtual time after which a run counts as hanging \[µs\].
const DEADLINE_US: u64 = 120_000_000;
pub(super) const RUN: [u8; 16] = *b"simulated run 01";
pub(super) const EPOCH: u32 = 7;

fn limits() -> Limits {
    Limits {
        join: Duration::from_secs(20),
        silence_notice: Duration::from_millis(300),
        silence: Duration::from_secs(4),
        repeat: Duration::from_millis(10),
        ahead: 2,
    }
}

pub(super) fn pace() -> Pace {
    Pace { repeat: Duration::from_millis(10), heartbeat: Duration::from_millis(50), orphaned: Duration::from_secs(30) }
}

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
        }),
    }
}

pub(super) fn identity(name: &str, instance: u64) -> Identity {
    Identity { run: RUN, name: name.to_owned(), instance, pid: 1, descriptor: descriptor() }
}

impl<'s, C: Checks + Copy> World<'s, C> {
    fn new(scenario: &'s Scenario, checks: C) -> Self {
        let plan = scenario.plan.clone();
        let node = |(i, p): (usize, &crate::plan::Participant)| Node {
            machine: Participant::with_checks(identity(&p.name, 100 + i as u64 * 2), pace(), checks),
            plugin: Toy::default(),
            alive: true,
            frozen: false,
            missed: Vec::new(),
            states: Vec::new(),
            ending: None,
        };
        let nodes = plan.participants.iter().enumerate().map(node).collect();
        Self {
            scenario,
            random: Random::new(scenario.seed ^ 0x5eed_5eed),
            now_us: 0,
            order: 0,
            queue: BTreeMap::new(),
            coordinator: Coordinator::with_checks(RUN, EPOCH, plan, scenario.scenes.clone(), limits(), checks),
            nodes,
            double: None,
            settled: 0,
            last_hash: 0,
            outcome: None,
            broken: None,
            messages: 0,
        }
    }

    /// All that a run leaves: the chain of the states, and what was drawn, which has no part in it.
    pub(super) fn fingerprint(&self) -> u128 {
        let drawn = self.nodes.iter().fold(0u64, |mixed, n| mixed.rotate_left(1) ^ n.plugin.drawn());
        self.last_hash ^ u128::from(drawn)
    }

    pub(super) fn now(&self) -> Duration {
        Duration::from_micros(self.now_us)
    }

    pub(super) fn post(&mut self, delay_us: u64, delivery: Delivery) {
        self.order += 1;
        self.queue.insert((self.now_us + delay_us, self.order), delivery);
    }

    /// Runs until everybody has left. Answers what broke on the way.
    fn play(&mut self) -> Option<String> {
        for who in 0..self.nodes.len() as ParticipantId {
            let start = self.random.below(3000);
            self.post(start, Delivery::TickNode(who));
        }
        self.post(0, Delivery::TickCoordinator);
        self.post(self.scenario.trouble_at_us, Delivery::Trouble);
        while let Some(((at, _), delivery)) = self.queue.pop_first() {
            self.now_us = at;
            self.messages += 1;
            self.deliver(delivery);
            if self.broken.is_some() {
                return self.broken.take();
            }
            let gone = self.nodes.iter().all(|n| n.ending.is_some() || !n.alive || n.frozen);
            if self.outcome.is_some() && gone {
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

    fn carry_out(&mut self, who: ParticipantId, actions: Vec<participant::Action>) {
        for action in actions {
            match action {
                participant::Action::Declare => {}
                participant::Action::Control(bytes) => self.send_up(who, bytes),
                participant::Action::Publish(stream, frame) => {
                    let readers = self.scenario.plan.streams[usize::from(stream)].to.clone();
                    for to in readers {
                        self.send_data(to, &frame);
                    }
                }
                participant::Action::Request(to, bytes) => self.send(&bytes, move |b| Delivery::Resend(to, b)),
                participant::Action::SetUp(scene, show) => {
                    let node = &mut self.nodes[usize::from(who)];
                    let answer = node.plugin.setup(&scene).map(|setup| Answer::of(&node.plugin, setup, true, &show));
                    self.answer(who, participant::Event::SetUp(answer));
                }
                participant::Action::Connect(partners) => {
                    let answer = self.nodes[usize::from(who)].plugin.connect(&partners);
                    self.answer(who, participant::Event::Connected(answer));
                }
                participant::Action::Compute(job) => self.compute(who, &job),
                participant::Action::Exit(ending) => self.nodes[usize::from(who)].ending = Some(ending),
            }
        }
    }

    fn answer(&mut self, who: ParticipantId, event: participant::Event) {
        let now = self.now();
        let actions = self.nodes[usize::from(who)].machine.on(event, now);
        self.carry_out(who, actions);
    }

    /// Computes at once, delivers the result later; checks that all inputs were there (I1) and the grant was kept.
    fn compute(&mut self, who: ParticipantId, job: &Job) {
        let window = job.step.window;
        let steps = schedule::steps(&self.scenario.plan, who, window);
        let step = steps.iter().find(|s| s.span == job.step.span);
        let needed = step.map_or(0, |s| s.needs.len());
        let given = job.inputs.impulses.len()
            + job.frames.iter().map(|f| f.bodies.len()).sum::<usize>()
            + job.inputs.partners.iter().map(|p| 1 + usize::from(p.next.is_some())).sum::<usize>();
        if given != needed {
            self.broken =
                Some(format!("participant {who} computed window {window} with {given} of {needed} inputs (I1)"));
        }
        if window >= self.coordinator.granted() {
            self.broken = Some(format!("participant {who} computed window {window} before it was granted"));
        }
        let node = &mut self.nodes[usize::from(who)];
        let drawn = job.frames.iter().try_for_each(|frame| node.plugin.record(frame, &mut Steady));
        let answer = drawn.and_then(|()| node.plugin.advance(&job.step, &job.inputs, &mut Steady));
        let answer = answer.map(|outputs| Answer::of(&node.plugin, outputs, true, &job.show));
        if job.hash_state {
            node.states.push(hash_of(&node.plugin));
        }
        let takes = 50 + self.random.below(1000);
        self.post(takes, Delivery::Computed(who, Box::new(answer)));
    }

    pub(super) fn tell_coordinator(&mut self, event: coordinator::Event) {
        let now = self.now();
        let actions = self.coordinator.on(event, now);
        for action in actions {
            match action {
                coordinator::Action::Send(to, bytes) => self.send_down(to, &bytes),
                coordinator::Action::Settled(record, dones) => self.check_settled(&record, &dones),
                coordinator::Action::Started => self.check_started(),
                coordinator::Action::Ended(outcome) => self.outcome = Some(outcome),
                coordinator::Action::Ready(..) | coordinator::Action::Notice(_) => {}
            }
        }
    }

    /// I2: every window once, in order, with what each participant really computed.
    fn check_settled(&mut self, record: &crate::ledger::WindowRecord, dones: &[crate::control::Done]) {
        if record.window != self.settled {
            self.broken = Some(format!("window {} was settled after {} windows (I2)", record.window, self.settled));
        }
        self.settled += 1;
        self.last_hash = record.state_hash;
        for (node, done) in self.nodes.iter().zip(dones) {
            let computed = node.states.get(record.window as usize);
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

fn hash_of(plugin: &Toy) -> u128 {
    let mut hasher = StateHasher::default();
    plugin.save(&mut hasher);
    hasher.finish()
}
