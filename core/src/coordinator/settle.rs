//! Settling windows: everybody has reported, and nobody computed with anything but what another sent.

use std::time::Duration;

use xxhash_rust::xxh3::Xxh3;

use super::{Action, Coordinator, Failure, Outcome, Phase};
use crate::checks::{Check, Checks};
use crate::control::Done;
use crate::plan::schedule::{self, MessageId};
use crate::plan::{Content, ParticipantId, Plan};

impl<C: Checks> Coordinator<C> {
    pub(super) fn on_done(&mut self, who: ParticipantId, done: Done, now: Duration, out: &mut Vec<Action>) {
        let window = done.window;
        if self.phase != Phase::Running || window >= self.until {
            return;
        }
        if window < self.committed {
            // It has not heard that this window is settled.
            out.push(self.send(who, self.grant()));
            return;
        }
        let peers = self.peers.len();
        let reports = self.pending.entry(window).or_insert_with(|| vec![None; peers]);
        if self.checks.on(Check::DoneOnce) {
            reports[usize::from(who)] = Some(done);
        } else if let Some(free) = reports.iter_mut().find(|r| r.is_none()) {
            // The hand-made bug: reports are counted, not attributed.
            *free = Some(done);
        }
        while self.phase == Phase::Running {
            let next = match self.pending.iter().find(|(_, r)| r.iter().all(Option::is_some)) {
                Some((&w, _)) if w == self.committed || !self.checks.on(Check::SettleInOrder) => w,
                _ => break,
            };
            self.settle(next, now, out);
        }
    }

    fn settle(&mut self, window: u64, now: Duration, out: &mut Vec<Action>) {
        let Some(reports) = self.pending.remove(&window) else { return };
        let dones: Vec<Done> = reports.into_iter().flatten().collect();
        for done in &dones {
            self.produced.extend(done.produced.iter().map(|&(s, i, h)| ((s, i), h)));
        }
        if self.checks.on(Check::ConsumedIsProduced)
            && let Some(failure) = self.disagreement(window, &dones)
        {
            return self.fail(failure, out);
        }
        self.chain = chain(self.chain, window, &self.plan, &dones);
        self.committed = self.committed.max(window + 1);
        self.settled_at = now;
        let committed = self.committed;
        let plan = &self.plan;
        self.produced.retain(|&(stream, index), _| {
            index + 2 >= committed || matches!(plan.streams[usize::from(stream)].content, Content::Statics { .. })
        });
        if let Some(ledger) = &mut self.ledger {
            let record = ledger.record(&self.plan, window, self.chain, &dones);
            out.push(Action::Settled(Box::new(record), dones));
        }
        self.grant_more(out);
    }

    fn grant_more(&mut self, out: &mut Vec<Action>) {
        let end = self.stop_at.unwrap_or(self.plan.clock.windows);
        if self.committed >= end {
            let stopped = self.stop_at.filter(|&at| at < self.plan.clock.windows);
            return match stopped {
                Some(windows) => self.finish(Outcome::Stopped { windows }, out),
                None => self.finish(Outcome::Finished, out),
            };
        }
        self.until = self.until.max((self.committed + self.limits.ahead).min(end));
        self.tell_all(&self.grant(), out);
    }

    /// Who computed with something else than what was sent, or did not send what the plan says.
    fn disagreement(&self, window: u64, dones: &[Done]) -> Option<Failure> {
        for (i, done) in dones.iter().enumerate() {
            let who = i as ParticipantId;
            let steps = schedule::steps(&self.plan, who, window);
            let broke =
                |message: String| Some(Failure::Protocol { who: self.plan.name_of(who).to_owned(), window, message });
            if done.window != window {
                return broke(format!("it reported window {} in its place", done.window));
            }
            let listed = |list: &[(u16, u64, u64)], id: MessageId| {
                list.iter().find(|(s, n, _)| *s == id.stream && *n == id.index).map(|&(_, _, hash)| hash)
            };
            for id in steps.iter().flat_map(|s| s.needs.iter().map(|n| n.message)) {
                let key = &self.plan.streams[usize::from(id.stream)].key;
                let Some(used) = listed(&done.consumed, id) else {
                    return broke(format!("it computed without message {} of `{key}`", id.index));
                };
                if self.produced.get(&(id.stream, id.index)) != Some(&used) {
                    return broke(format!("it computed with another message {} of `{key}` than was sent", id.index));
                }
            }
            for id in steps.iter().flat_map(|s| &s.gives) {
                if listed(&done.produced, *id).is_none() {
                    let key = &self.plan.streams[usize::from(id.stream)].key;
                    return broke(format!("it did not publish message {} of `{key}`", id.index));
                }
            }
        }
        None
    }
}

/// xxh3-128 over the chain so far, the window number and, in name order, each solver's state.
fn chain(before: u128, window: u64, plan: &Plan, dones: &[Done]) -> u128 {
    let mut hasher = Xxh3::new();
    hasher.update(&before.to_le_bytes());
    hasher.update(&window.to_le_bytes());
    for (participant, done) in plan.participants.iter().zip(dones) {
        hasher.update(participant.name.as_bytes());
        hasher.update(&done.state_hash.to_le_bytes());
    }
    hasher.digest128()
}
