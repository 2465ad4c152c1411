//! Saving at an edge, and taking up a run there.

use std::collections::BTreeMap;
use std::time::Duration;

use super::window::{Underway, forget_used};
use super::{Action, Joined, Participant, Phase};
use crate::checkpoint::{CheckpointError, KeptMessage, Snapshot};
use crate::checks::{Check, Checks};
use crate::control::{FailureKind, Save, Up};
use crate::plan::Content;
use crate::plan::schedule::{self, MessageId};
use crate::plugin::PluginError;

/// Snapshots asked for, taken and stored.
#[derive(Debug, Default)]
pub(super) struct Saving {
    /// Edges ahead at which one is wanted, each with the one that must be kept beside it.
    asked: BTreeMap<u64, Option<u64>>,
    /// The last one that was taken.
    taken: Option<u64>,
    /// The last one that is stored, and why it could not be.
    stored: Option<(u64, Option<String>)>,
}

impl<C: Checks> Participant<C> {
    /// Goes on once the geometry is there: a run that is resumed needs its snapshot before anything is published.
    pub(super) fn load_or_set_up(&mut self, out: &mut Vec<Action>) {
        match &self.joined {
            Some(joined) if joined.from > 0 => {
                self.phase = Phase::Loading;
                out.push(Action::Load(joined.from));
            }
            _ => self.set_up(out),
        }
    }

    pub(super) fn on_loaded(
        &mut self,
        found: Result<Box<Snapshot>, CheckpointError>,
        now: Duration,
        out: &mut Vec<Action>,
    ) {
        let Some(joined) = self.joined.as_mut().filter(|_| self.phase == Phase::Loading) else { return };
        let window = joined.from;
        let checked = found.and_then(|snapshot| {
            let fits = snapshot.check(self.identity.run, joined.identity, &self.identity.name, window);
            if self.checks.on(Check::SnapshotFits) { fits.map(|()| snapshot) } else { Ok(snapshot) }
        });
        match checked {
            Ok(snapshot) => {
                joined.snapshot = Some(snapshot);
                self.begin_at(window);
                self.set_up(out);
            }
            Err(error) => {
                let message = format!("its snapshot of the start of window {window} cannot be used: {error}");
                self.fail(FailureKind::Environment, message, now, out);
            }
        }
    }

    /// Everything before `window` is settled.
    fn begin_at(&mut self, window: u64) {
        (self.until, self.committed) = (window, window);
        self.underway = Underway::at(window);
        self.progress = crate::control::Progress { window, ..Default::default() };
        if let Some(joined) = &mut self.joined {
            forget_used(joined, window);
        }
    }

    pub(super) fn on_restored(&mut self, answer: Result<u128, PluginError>, now: Duration, out: &mut Vec<Action>) {
        match answer {
            Ok(state_hash) => {
                if let Some(joined) = &mut self.joined {
                    joined.restored = Some(state_hash);
                    joined.connected = true;
                }
                self.report_probes(now, out);
            }
            Err(error) => self.fail_plugin(&error, now, out),
        }
    }

    /// Hears at which edge a snapshot is wanted; says again what has been stored where it is asked again.
    pub(super) fn on_save(&mut self, save: Option<Save>, now: Duration, out: &mut Vec<Action>) {
        let Some(save) = save else { return };
        let known = self.saving.stored.as_ref().filter(|(stored, _)| *stored >= save.at);
        if let Some((window, problem)) = known {
            let saved = Up::Saved { window: *window, problem: problem.clone() };
            if self.checks.on(Check::RepeatSaved) {
                self.say(saved, now, out);
            }
        } else if self.saving.taken < Some(save.at) {
            self.saving.asked.insert(save.at, save.keep);
            self.save_if_due(out);
        }
    }

    /// Asks for a snapshot where the plugin stands at an edge at which one is wanted.
    pub(super) fn save_if_due(&mut self, out: &mut Vec<Action>) {
        let Some(joined) = self.joined.as_ref().filter(|_| self.phase == Phase::Running) else { return };
        let asked = &self.saving.asked;
        let here = if self.checks.on(Check::SaveAtEdge) {
            asked.get_key_value(&self.underway.window).filter(|_| !self.underway.is_begun())
        } else {
            asked.first_key_value()
        };
        if let Some((&window, &keep)) = here {
            let snapshot = Snapshot {
                run: self.identity.run,
                identity: joined.identity,
                name: self.identity.name.clone(),
                window,
                messages: joined.kept_messages(window),
                state: Vec::new(),
            };
            out.push(Action::Save(Box::new(snapshot), keep));
            self.saving.taken = Some(window);
            self.saving.asked.clear();
        }
    }

    pub(super) fn on_saved(&mut self, window: u64, answer: Result<(), String>, now: Duration, out: &mut Vec<Action>) {
        let problem = answer.err();
        self.saving.stored = Some((window, problem.clone()));
        self.say(Up::Saved { window, problem }, now, out);
    }
}

impl Joined {
    /// What later windows need of what has been published, as it was. Statics come from set-up.
    fn kept_messages(&self, window: u64) -> Vec<KeptMessage> {
        let made_again =
            |id: &MessageId| matches!(self.plan.streams[usize::from(id.stream)].content, Content::Statics { .. });
        let ids = schedule::published_before(&self.plan, self.id, window).into_iter().filter(|id| !made_again(id));
        ids.filter_map(|id| {
            let (count, payload) = self.outbox.payload(id)?;
            Some(KeptMessage { stream: id.stream, index: id.index, count, payload })
        })
        .collect()
    }
}
