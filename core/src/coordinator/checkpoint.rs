//! Checkpoints: asking everybody for a snapshot of the same edge, recording that all of them are stored, and resuming.

use std::time::Duration;

use super::{Action, Coordinator, Failure, Phase, settle};
use crate::checkpoint::{Checkpoint, CheckpointError, identity_of};
use crate::checks::{Check, Checks};
use crate::control::ReadyInfo;
use crate::plan::schedule::{self, MessageId};
use crate::plan::{Content, ParticipantId, Plan};

/// A checkpoint that is being made.
#[derive(Debug)]
pub(super) struct Saving {
    /// Window at whose start.
    pub(super) edge: u64,
    /// Who has stored its snapshot.
    stored: Vec<bool>,
    /// What is known at the edge, once all windows before are settled.
    record: Option<Box<Checkpoint>>,
    /// The host is storing it.
    handed_out: bool,
}

impl<C: Checks> Coordinator<C> {
    /// Goes on from a checkpoint instead of t = 0. To be called before the first event.
    ///
    /// # Errors
    /// [`CheckpointError`] when it is not of this run, plan, scene and geometry, or of a later incarnation.
    pub fn resumed(mut self, checkpoint: Checkpoint) -> Result<Self, CheckpointError> {
        let Checkpoint { run, epoch, identity, window, state_hash, states, published, ledger } = checkpoint;
        if run != self.run {
            return Err(CheckpointError::Run);
        }
        if epoch >= self.epoch {
            return Err(CheckpointError::Epoch { written: epoch, epoch: self.epoch });
        }
        if identity != self.identity() {
            return Err(CheckpointError::Identity);
        }
        let malformed = |what: &str| CheckpointError::Malformed(what.to_owned());
        if window == 0 || window > self.plan.clock.windows || states.len() != self.peers.len() {
            return Err(malformed("its numbers do not fit the plan"));
        }
        self.ledger = Some(ledger.reopen(&self.plan, &self.scenes).ok_or_else(|| malformed("its ledger"))?);
        self.produced = published.into_iter().map(|(stream, index, content)| ((stream, index), content)).collect();
        let all = (0..self.peers.len() as ParticipantId).flat_map(|who| self.published_before(who, window));
        if !all.into_iter().all(|id| self.produced.contains_key(&(id.stream, id.index))) {
            return Err(malformed("it lacks messages"));
        }
        (self.from, self.committed, self.until, self.saved) = (window, window, window, window);
        self.recorded = Some(window);
        (self.chain, self.states) = (state_hash, states);
        Ok(self)
    }

    /// What is computed, as one number.
    fn identity(&self) -> u128 {
        identity_of(&self.plan, self.scenes.iter().zip(self.shipments.iter().map(|s| s.infos.as_slice())))
    }

    /// Chooses the next edge, if one is wanted: never one that somebody may have passed.
    pub(super) fn plan_save(&mut self) {
        let Some(every) = self.limits.checkpoint_every.filter(|_| self.saving.is_none()) else { return };
        let soonest = self.until.max(self.saved + 1);
        let edge = self.stop_at.or_else(|| soonest.checked_next_multiple_of(every.max(1)));
        let Some(edge) = edge.filter(|&e| e > self.saved && e < self.plan.clock.windows) else { return };
        self.saving = Some(Saving { edge, stored: vec![false; self.peers.len()], record: None, handed_out: false });
    }

    /// A stop comes before the edge that was chosen: nobody will get there.
    pub(super) fn save_at_stop(&mut self, stop_at: u64) {
        self.saving.take_if(|saving| saving.edge > stop_at);
        self.plan_save();
    }

    /// Remembers what is known at the edge while it is; hands it out when everybody has stored a snapshot.
    pub(super) fn try_record(&mut self, out: &mut Vec<Action>) {
        let Some(mut saving) = self.saving.take() else { return };
        if self.committed == saving.edge && saving.record.is_none() && !saving.handed_out {
            saving.record = self.record().map(Box::new);
        }
        let complete = saving.stored.iter().all(|stored| *stored) || !self.checks.on(Check::CheckpointComplete);
        let record = if complete { saving.record.take() } else { None };
        let now = record.is_some();
        saving.handed_out |= now;
        out.extend(record.map(Action::Checkpoint));
        let edge = saving.edge;
        self.saving = Some(saving);
        if now && !self.checks.on(Check::RecordedBeforeNext) {
            self.recorded = Some(edge);
            self.end_save(edge);
        }
    }

    fn record(&self) -> Option<Checkpoint> {
        let everyone = 0..self.peers.len() as ParticipantId;
        let published = everyone.flat_map(|who| self.published_before(who, self.committed));
        let known = |id: MessageId| Some((id.stream, id.index, *self.produced.get(&(id.stream, id.index))?));
        Some(Checkpoint {
            run: self.run,
            epoch: self.epoch,
            identity: self.identity(),
            window: self.committed,
            state_hash: self.chain,
            states: self.states.clone(),
            published: published.filter_map(known).collect(),
            ledger: self.ledger.clone()?,
        })
    }

    pub(super) fn published_before(&self, who: ParticipantId, window: u64) -> Vec<MessageId> {
        schedule::published_before(&self.plan, who, window)
    }

    pub(super) fn on_saved(&mut self, who: ParticipantId, window: u64, problem: Option<String>, out: &mut Vec<Action>) {
        let Some(saving) = self.saving.as_mut().filter(|s| s.edge == window && self.phase == Phase::Running) else {
            return;
        };
        if let Some(problem) = problem {
            let name = self.plan.name_of(who);
            let text =
                format!("no checkpoint of the start of window {window}: `{name}` could not store its part: {problem}");
            out.push(Action::Notice(text));
            self.end_save(window);
            return self.grant_more(out);
        }
        saving.stored[usize::from(who)] = true;
        self.try_record(out);
    }

    /// The host has stored a checkpoint, or could not.
    pub(super) fn on_recorded(&mut self, window: u64, answer: Result<(), String>, out: &mut Vec<Action>) {
        if self.phase != Phase::Running || self.saving.as_ref().is_none_or(|s| s.edge != window) {
            return;
        }
        match answer {
            Ok(()) => self.recorded = Some(window),
            Err(problem) => {
                out.push(Action::Notice(format!("no checkpoint of the start of window {window}: {problem}")));
            }
        }
        self.end_save(window);
        self.grant_more(out);
    }

    fn end_save(&mut self, edge: u64) {
        self.saving = None;
        self.saved = edge;
        self.plan_save();
    }

    /// Who resumes must publish what was published before.
    pub(super) fn takes_up(&self, who: ParticipantId, info: &ReadyInfo) -> Result<(), Failure> {
        let other = |id: &MessageId| {
            let before = self.produced.get(&(id.stream, id.index)).copied();
            before.is_some() && settle::listed(&info.produced, *id) != before
        };
        match self.published_before(who, self.from).iter().find(|id| other(id)) {
            Some(id) if self.from > 0 && self.checks.on(Check::RestoredMessages) => {
                let (index, key) = (id.index, self.key(*id));
                let message = format!("it resumes with another message {index} of `{key}` than it had published");
                Err(self.broke(who, self.from, message))
            }
            _ => Ok(()),
        }
    }

    /// Who resumes must have the state that it had.
    pub(super) fn has_state(&self, who: ParticipantId, restored: Option<u128>) -> Result<(), Failure> {
        let settled = self.states.get(usize::from(who)).copied();
        if self.from == 0 || restored == settled || !self.checks.on(Check::RestoredState) {
            return Ok(());
        }
        let message = match restored {
            Some(_) => format!("its restored state is not the one it had at the start of window {}", self.from),
            None => format!("it did not restore its state of the start of window {}", self.from),
        };
        Err(self.broke(who, self.from, message))
    }

    /// A stopped run waits for its checkpoint as long as for a set-up: storing a state takes no longer than making it.
    pub(super) fn give_up_saving(&mut self, now: Duration, out: &mut Vec<Action>) {
        let stopped = self.stop_at.is_some_and(|at| self.committed >= at);
        if stopped && now > self.settled_at + self.limits.join {
            out.extend(self.explain_saving().map(|text| Action::Notice(format!("{text}, and is given up"))));
            self.end_save(self.committed);
            self.grant_more(out);
        }
    }

    /// Whose snapshot is waited for at a stop.
    pub(super) fn explain_saving(&self) -> Option<String> {
        let saving = self.saving.as_ref().filter(|s| s.edge == self.committed)?;
        let late = saving.stored.iter().zip(&self.plan.participants).filter(|(stored, _)| !**stored);
        let late: Vec<String> = late.map(|(_, p)| format!("`{}`", p.name)).collect();
        let who = if late.is_empty() { "its record".to_owned() } else { format!("the part of {}", late.join(", ")) };
        Some(format!("the checkpoint of the start of window {} waits for {who} to be stored", saving.edge))
    }
}

/// Whether the messages of a stream never grow old.
pub(super) fn lasts(plan: &Plan, stream: u16) -> bool {
    plan.streams.get(usize::from(stream)).is_some_and(|s| matches!(s.content, Content::Statics { .. }))
}
