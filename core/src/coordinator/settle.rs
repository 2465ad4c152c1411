//! Settling windows: everybody has reported, and nobody computed with anything but what another sent.

use std::time::Duration;

use xxhash_rust::xxh3::Xxh3;

use super::checkpoint::lasts;
use super::{Action, Coordinator, Failure, Outcome, Phase};
use crate::checks::{Check, Checks};
use crate::control::Done;
use crate::plan::schedule::{self, MessageId};
use crate::plan::{ParticipantId, Plan, StreamId};

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
        let strict = self.checks.on(Check::ConsumedIsProduced);
        let failure = self.missing_output(window, &dones).or_else(|| self.disagreement(window, &dones));
        if let Some(failure) = failure.filter(|_| strict) {
            return self.fail(failure, out);
        }
        self.chain = chain(self.chain, window, &self.plan, &dones);
        self.states = dones.iter().map(|d| d.state_hash).collect();
        self.committed = self.committed.max(window + 1);
        self.settled_at = now;
        let committed = self.committed;
        let plan = &self.plan;
        self.produced.retain(|&(stream, index), _| index + 2 >= committed || lasts(plan, stream));
        if let Some(ledger) = &mut self.ledger {
            let record = ledger.record(&self.plan, window, self.chain, &dones);
            out.push(Action::Settled(Box::new(record), dones));
        }
        self.grant_more(out);
    }

    pub(super) fn grant_more(&mut self, out: &mut Vec<Action>) {
        let end = self.stop_at.unwrap_or(self.plan.clock.windows);
        self.plan_save();
        self.try_record(out);
        if self.committed >= end {
            let stopped = self.stop_at.filter(|&at| at < self.plan.clock.windows);
            return match stopped {
                // Everybody stands at the edge: the run ends when it can be resumed from there.
                Some(_) if self.saving.is_some() => self.tell_all(&self.grant(), out),
                Some(windows) => self.finish(Outcome::Stopped { windows }, out),
                None => self.finish(Outcome::Finished, out),
            };
        }
        self.until = self.until.max((self.committed + self.limits.ahead).min(end));
        self.tell_all(&self.grant(), out);
    }

    /// Who did not publish what the plan says. Only what it says is taken over: a report may list anything.
    fn missing_output(&mut self, window: u64, dones: &[Done]) -> Option<Failure> {
        for (who, done) in (0..).zip(dones) {
            if done.window != window {
                let message = format!("it reported window {} in its place", done.window);
                return Some(self.broke(who, window, message));
            }
            for id in schedule::steps(&self.plan, who, window).iter().flat_map(|s| &s.gives) {
                let Some(content) = listed(&done.produced, *id) else {
                    let message = format!("it did not publish message {} of `{}`", id.index, self.key(*id));
                    return Some(self.broke(who, window, message));
                };
                self.produced.insert((id.stream, id.index), content);
            }
        }
        None
    }

    /// Who computed with something else than what was sent.
    fn disagreement(&self, window: u64, dones: &[Done]) -> Option<Failure> {
        for (who, done) in (0..).zip(dones) {
            for id in schedule::steps(&self.plan, who, window).iter().flat_map(|s| s.needs.iter().map(|n| n.message)) {
                let (index, key) = (id.index, self.key(id));
                let message = match listed(&done.consumed, id) {
                    None => format!("it computed without message {index} of `{key}`"),
                    Some(used) if self.produced.get(&(id.stream, index)) != Some(&used) => {
                        format!("it computed with another message {index} of `{key}` than was sent")
                    }
                    Some(_) => continue,
                };
                return Some(self.broke(who, window, message));
            }
        }
        None
    }

    pub(super) fn broke(&self, who: ParticipantId, window: u64, message: String) -> Failure {
        Failure::Protocol { who: self.plan.name_of(who).to_owned(), window, message }
    }

    pub(super) fn key(&self, id: MessageId) -> &str {
        self.plan.streams.get(usize::from(id.stream)).map_or("?", |s| s.key.as_str())
    }
}

/// Content hash of a message in a report.
pub(super) fn listed(list: &[(StreamId, u64, u64)], id: MessageId) -> Option<u64> {
    list.iter().find(|(stream, index, _)| *stream == id.stream && *index == id.index).map(|&(_, _, hash)| hash)
}

/// xxh3-128 over the chain so far, the window number and, in name order, each solver's state.
fn chain(before: u128, window: u64, plan: &Plan, dones: &[Done]) -> u128 {
    let mut hasher = Xxh3::new();
    hasher.update(&before.to_le_bytes());
    hasher.update(&window.to_le_bytes());
    let solvers = (0..).zip(&plan.participants).zip(dones).filter(|((id, _), _)| plan.is_solver(*id));
    for ((_, participant), done) in solvers {
        hasher.update(participant.name.as_bytes());
        hasher.update(&done.state_hash.to_le_bytes());
    }
    hasher.digest128()
}
