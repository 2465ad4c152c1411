//! The lives of a run: processes are killed, and all are started again from the newest checkpoint while messages of
//! the life before are still on their way.

use super::birth::{fresh_coordinator, fresh_nodes};
use super::host::Disks;
use super::scenario::Trouble;
use super::world::{Delivery, World};
use crate::checkpoint::{Checkpoint, Snapshot};
use crate::checks::Checks;
use crate::coordinator::Outcome;
use crate::plan::ParticipantId;

/// What has happened to a snapshot between two lives. The bytes are sound except in the first case.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Rot {
    /// A bit has flipped.
    Bit,
    /// It is of another window.
    Stale,
    /// The state in it is another.
    State,
    /// A message in it is another.
    Message,
}

/// Messages of a life that are kept to be delivered in the next, and those of them that are its first: greetings.
const OVERHEARD: usize = 64;
const FIRST_OVERHEARD: usize = 8;

impl<C: Checks + Copy> World<'_, C> {
    /// Kills somebody and starts everything again later.
    pub(super) fn crash(&mut self, everybody: bool) {
        let peers = self.nodes.len() as u64;
        // The place behind the participants is the coordinator.
        let surely = self.random.below(peers + 1);
        for who in 0..=peers {
            if everybody || who == surely || self.random.once_in(2) {
                self.kill(who as usize);
            }
        }
        self.restart_later();
    }

    fn kill(&mut self, who: usize) {
        let Some(node) = self.nodes.get_mut(who) else {
            self.coordinator_alive = false;
            return;
        };
        node.alive = false;
        self.post(1000, Delivery::Buried(who as ParticipantId));
    }

    pub(super) fn restart_later(&mut self) {
        self.restarts = true;
        let after = self.random.below(400_000);
        self.post(after, Delivery::Restart);
    }

    /// The run was stopped: it must be possible to resume it from exactly there.
    pub(super) fn after_stop(&mut self, windows: u64) {
        let newest = self.disks.checkpoint.as_ref().map_or(0, |(window, _)| *window);
        let disks_work = self.scenario.faults.disk == 0;
        if disks_work && newest != windows {
            self.broken = Some(format!("it stopped before window {windows} with a checkpoint of {newest} (I5)"));
        }
        if self.scenario.trouble == Trouble::Interrupt {
            self.restart_later();
        }
    }

    /// Ends all processes and starts new ones, with the newest checkpoint if there is one.
    pub(super) fn restart(&mut self) {
        self.restarts = false;
        if self.outcome == Some(Outcome::Finished) {
            return;
        }
        if let Trouble::Rot(who) = self.scenario.trouble {
            self.rotten = self.spoil(who);
        }
        self.life += 1;
        self.began_us = self.now_us;
        let overheard = std::mem::take(&mut self.overheard);
        self.old.extend(overheard);
        let fresh = fresh_coordinator(self.scenario, self.epoch(), self.checks);
        let stored = self.disks.checkpoint.as_ref().map(|(_, bytes)| Checkpoint::decode(bytes));
        let resumed = match stored {
            None => Ok((0, fresh)),
            Some(stored) => stored.and_then(|point| Ok((point.window, fresh.resumed(point)?))),
        };
        match resumed {
            Ok((window, coordinator)) => {
                self.check_complete();
                self.resumed += u32::from(window > 0);
                self.coordinator = coordinator;
                self.settled = window;
                self.last_hash = self.coordinator.state_hash();
                self.nodes = fresh_nodes(self.scenario, self.life, window, self.checks);
            }
            Err(error) => self.broken = Some(format!("the newest checkpoint cannot be used: {error} (I5)")),
        }
        (self.coordinator_alive, self.outcome) = (true, None);
        self.start();
        if self.crashes > 0 {
            self.crashes -= 1;
            let at = 5_000 + self.random.below(150_000);
            self.post(at, Delivery::Trouble);
        }
    }

    /// Spoils the snapshot that a participant would resume from.
    fn spoil(&mut self, who: ParticipantId) -> Option<Rot> {
        let draw = self.random.below(8);
        let Disks { snapshots, checkpoint, .. } = &mut self.disks;
        let (window, _) = checkpoint.as_ref()?;
        let bytes = snapshots.get_mut(usize::from(who))?.get_mut(window)?;
        let mut snapshot = Snapshot::decode(bytes).ok()?;
        let rot = match draw {
            0 => Rot::Bit,
            1..=3 if !snapshot.state.is_empty() => Rot::State,
            4..=6 if !snapshot.messages.is_empty() => Rot::Message,
            _ => Rot::Stale,
        };
        match rot {
            Rot::Bit => {
                let at = self.random.below(bytes.len() as u64) as usize;
                bytes[at] ^= 1;
                return Some(rot);
            }
            Rot::Stale => snapshot.window -= 1,
            Rot::State => snapshot.state[0] ^= 1,
            // The lowest bit of a number: a payload that can be told from the right one only by its hash.
            Rot::Message => snapshot.messages[0].payload[0] ^= 1,
        }
        *bytes = snapshot.encode();
        Some(rot)
    }

    /// Remembers messages of a run that will be resumed, and delivers some of the life before.
    pub(super) fn haunt(&mut self, delivery: &Delivery) {
        if !self.scenario.trouble.resumes() {
            return;
        }
        if self.overheard.len() < OVERHEARD {
            self.overheard.push(delivery.clone());
        } else {
            let at = FIRST_OVERHEARD + self.random.below((OVERHEARD - FIRST_OVERHEARD) as u64) as usize;
            self.overheard[at] = delivery.clone();
        }
        if !self.old.is_empty() && self.random.once_in(8) {
            let which = self.random.below(self.old.len() as u64) as usize;
            let delay = self.random.below(5_000);
            self.schedule(delay, self.old[which].clone());
        }
    }
}
