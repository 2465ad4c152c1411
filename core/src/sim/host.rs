//! What surrounds a simulated machine: its plugin, its disk, and the actions it asks for.

use std::collections::BTreeMap;

use xxhash_rust::xxh3::xxh3_64;

use super::toy::Toy;
use super::world::{Delivery, World};
use crate::checkpoint::{Checkpoint, CheckpointError, Snapshot};
use crate::checks::Checks;
use crate::coordinator;
use crate::participant::{self, Answer, Ending, Job, Participant};
use crate::plan::{ParticipantId, schedule};
use crate::plugin::{Plugin, StateHasher, Steady};

/// A participant's process.
pub(super) struct Node<C: Checks> {
    pub(super) machine: Participant<C>,
    pub(super) plugin: Toy,
    pub(super) alive: bool,
    pub(super) frozen: bool,
    pub(super) missed: Vec<Delivery>,
    /// Hash of the state after each window it computed.
    pub(super) states: BTreeMap<u64, u128>,
    /// Number of the frame that it must be given next.
    pub(super) next_frame: u64,
    /// Frames drawn that a crash would lose.
    pub(super) pending: BTreeMap<u64, u64>,
    pub(super) ending: Option<Ending>,
}

/// What outlives every process.
#[derive(Default)]
pub(super) struct Disks {
    /// Snapshots of each participant, by window.
    pub(super) snapshots: Vec<BTreeMap<u64, Vec<u8>>>,
    /// The newest checkpoint.
    pub(super) checkpoint: Option<(u64, Vec<u8>)>,
    /// Frames that are written for good.
    pub(super) frames: BTreeMap<u64, u64>,
    /// Every frame that was ever drawn.
    pub(super) drawn: BTreeMap<u64, u64>,
}

impl<C: Checks + Copy> World<'_, C> {
    pub(super) fn carry_out(&mut self, who: ParticipantId, actions: Vec<participant::Action>) {
        for action in actions {
            let node = &mut self.nodes[usize::from(who)];
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
                    let answer = node.plugin.setup(&scene).map(|setup| Answer::of(&node.plugin, setup, true, &show));
                    self.answer(who, participant::Event::SetUp(answer));
                }
                participant::Action::Connect(partners) => {
                    let answer = node.plugin.connect(&partners);
                    self.answer(who, participant::Event::Connected(answer));
                }
                participant::Action::Load(window) => {
                    let found = self.load(who, window);
                    self.answer(who, participant::Event::Loaded(found));
                }
                participant::Action::Restore(state) => {
                    let answer = node.plugin.restore(&state).map(|()| hash_of(&node.plugin));
                    self.answer(who, participant::Event::Restored(answer));
                }
                participant::Action::Save(snapshot, keep) => {
                    let window = snapshot.window;
                    let full = self.random.once_in(self.scenario.faults.disk);
                    let stored = if full { Err("disk full".to_owned()) } else { Ok(snapshot.of(&node.plugin)) };
                    self.disks.snapshots[usize::from(who)].retain(|&stored, _| Some(stored) == keep);
                    let takes = 50 + self.random.below(3000);
                    self.post(takes, Delivery::Stored(who, window, stored));
                }
                participant::Action::Compute(job) => self.compute(who, &job),
                participant::Action::Exit(ending) => node.ending = Some(ending),
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
            node.states.insert(window, hash_of(&node.plugin));
        }
        let drawn = node.plugin.take_drawn();
        self.check_drawn(who, &drawn);
        let takes = 50 + self.random.below(1000);
        self.post(takes, Delivery::Computed(who, Box::new(answer)));
    }

    /// A recorder is given frame after frame from where the run began or was resumed; one that is drawn again is the
    /// same.
    fn check_drawn(&mut self, who: ParticipantId, drawn: &[(u64, u64)]) {
        for &(number, hash) in drawn {
            let node = &mut self.nodes[usize::from(who)];
            if number != node.next_frame {
                self.broken = Some(format!("frame {number} was drawn instead of frame {}", node.next_frame));
            }
            node.next_frame = number + 1;
            node.pending.insert(number, hash);
            if *self.disks.drawn.entry(number).or_insert(hash) != hash {
                self.broken = Some(format!("frame {number} was drawn again and differs (I5)"));
            }
        }
    }

    /// Reads a snapshot; those of later windows belong to a life that is over.
    fn load(&mut self, who: ParticipantId, window: u64) -> Result<Box<Snapshot>, CheckpointError> {
        let disk = &mut self.disks.snapshots[usize::from(who)];
        disk.retain(|&stored, _| stored <= window);
        let bytes = disk.get(&window).ok_or_else(|| CheckpointError::Unreadable("there is none".to_owned()))?;
        Snapshot::decode(bytes).map(Box::new)
    }

    /// A participant's snapshot has reached its disk, or has not.
    pub(super) fn store(&mut self, who: ParticipantId, window: u64, stored: Result<Vec<u8>, String>) {
        let event = participant::Event::Saved(window, stored.as_ref().map(|_| ()).map_err(Clone::clone));
        if let Ok(bytes) = stored {
            self.disks.snapshots[usize::from(who)].insert(window, bytes);
            let written = std::mem::take(&mut self.nodes[usize::from(who)].pending);
            self.disks.frames.extend(written);
        }
        self.answer(who, event);
    }

    pub(super) fn write_checkpoint(&mut self, checkpoint: &Checkpoint) {
        let full = self.random.once_in(self.scenario.faults.disk);
        let stored = if full { Err("disk full".to_owned()) } else { Ok(checkpoint.encode()) };
        let takes = 50 + self.random.below(30_000);
        self.post(takes, Delivery::Recorded(checkpoint.window, stored));
    }

    /// A checkpoint has reached the coordinator's disk: it is worth something only if everybody has its part.
    pub(super) fn record(&mut self, window: u64, stored: Result<Vec<u8>, String>) {
        let event = coordinator::Event::Recorded(window, stored.as_ref().map(|_| ()).map_err(Clone::clone));
        if let Ok(bytes) = stored {
            self.keep_checkpoint(window, bytes);
        }
        self.tell_coordinator(event);
    }

    fn keep_checkpoint(&mut self, window: u64, bytes: Vec<u8>) {
        if self.disks.checkpoint.as_ref().is_some_and(|(newest, _)| *newest >= window) {
            self.broken = Some(format!("the checkpoint of window {window} came after a later one (I5)"));
        }
        self.disks.checkpoint = Some((window, bytes));
        self.check_complete();
    }

    /// I5: the newest checkpoint can be resumed from, whenever that is tried.
    pub(super) fn check_complete(&mut self) {
        let Some((window, _)) = self.disks.checkpoint else { return };
        if let Some(who) = self.disks.snapshots.iter().position(|disk| !disk.contains_key(&window)) {
            self.broken = Some(format!("participant {who} has no part of the checkpoint of window {window} (I5)"));
        }
    }

    /// All frames that a run leaves, as one number.
    pub(super) fn pictures(&self) -> u64 {
        let mut frames = self.disks.frames.clone();
        self.nodes.iter().for_each(|node| frames.extend(&node.pending));
        let all: Vec<u64> = frames.into_iter().flat_map(|(number, hash)| [number, hash]).collect();
        xxh3_64(bytemuck::cast_slice(&all))
    }
}

fn hash_of(plugin: &Toy) -> u128 {
    let mut hasher = StateHasher::default();
    plugin.save(&mut hasher);
    hasher.finish()
}
