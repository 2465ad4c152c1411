//! Working through a window: waiting for what a step needs, computing it, publishing what it gives.

use std::time::Duration;

use super::gather::{Gathered, gather};
use super::moment::Handed;
use super::{Action, Answer, Joined, Participant, Phase};
use crate::checks::{Check, Checks};
use crate::control::{Done, FailureKind, Times, Up};
use crate::participant::{Job, OutputError};
use crate::plan::schedule::{self, MessageId, Need, StepPlan};
use crate::plan::{Content, StreamId};
use crate::plugin::{Outputs, PluginError, Report, Step, count};

/// The window at hand.
#[derive(Debug, Default)]
pub(super) struct Underway {
    /// Its number.
    pub(super) window: u64,
    /// Step within it.
    step: usize,
    /// Whether the plugin is at work.
    pub(super) computing: bool,
    /// What will be reported about it.
    done: Done,
    /// Impulses given to the plugin in it.
    handed: Vec<Handed>,
}

impl Underway {
    /// Nothing of `window` has been computed.
    pub(super) fn at(window: u64) -> Self {
        Self { window, ..Self::default() }
    }

    /// Whether any of the window has been computed or is being.
    pub(super) fn is_begun(&self) -> bool {
        self.computing || self.step > 0
    }
}

impl<C: Checks> Participant<C> {
    /// The step that comes next.
    pub(super) fn current_step(&self, joined: &Joined) -> Option<StepPlan> {
        let steps = schedule::steps(&joined.plan, joined.id, self.underway.window);
        steps.into_iter().nth(self.underway.step)
    }

    /// Starts the next step if all it needs is there.
    pub(super) fn advance(&mut self, now: Duration, out: &mut Vec<Action>) {
        let Some(joined) = self.joined.as_ref() else { return };
        let window = self.underway.window;
        let granted = window < self.until || !self.checks.on(Check::GrantLimit);
        if self.phase != Phase::Running || self.underway.computing || !granted || window >= joined.plan.clock.windows {
            return;
        }
        let Some(step) = self.current_step(joined) else { return };
        let found: Vec<(Need, Option<MessageId>)> =
            step.needs.iter().map(|&need| (need, self.locate(joined, need.message))).collect();
        if let Some((need, _)) = found.iter().find(|(_, id)| id.is_none()) {
            self.progress.waiting_for = Some(need.message.stream);
            if self.checks.on(Check::AllNeeds) {
                return;
            }
        }
        match gather(joined, &step, window, &found) {
            Ok(Gathered { inputs, frames, consumed, applied, handed }) => {
                let steps = schedule::steps(&joined.plan, joined.id, window).len();
                let hash_state = self.underway.step + 1 == steps;
                let show =
                    if hash_state && joined.plan.has_frame_at(window + 1) { joined.shown_bodies() } else { Vec::new() };
                let step = Step::new(&joined.plan.clock, window, step.span);
                self.underway.computing = true;
                self.underway.done.consumed.extend(consumed);
                self.underway.done.applied.extend(applied);
                self.underway.handed.extend(handed);
                self.progress = crate::control::Progress { window, ..Default::default() };
                out.push(Action::Compute(Box::new(Job { step, inputs, hash_state, frames, show })));
            }
            Err(message) => self.fail(FailureKind::Bus, message, now, out),
        }
    }

    fn locate(&self, joined: &Joined, wanted: MessageId) -> Option<MessageId> {
        if self.checks.on(Check::ExactIndex) {
            joined.inbox.content(wanted).map(|_| wanted)
        } else {
            joined.inbox.newest(wanted.stream)
        }
    }

    pub(super) fn on_computed(
        &mut self,
        answer: Result<Answer<Outputs>, PluginError>,
        times: Times,
        now: Duration,
        out: &mut Vec<Action>,
    ) {
        let Answer { value: outputs, state_hash, visuals } = match answer {
            Ok(answer) => answer,
            Err(error) => return self.fail_plugin(&error, now, out),
        };
        self.underway.computing = false;
        let Some(joined) = &mut self.joined else { return };
        let window = self.underway.window;
        let steps = schedule::steps(&joined.plan, joined.id, window);
        let Some(step) = steps.get(self.underway.step) else { return };
        let done = &mut self.underway.done;
        for &id in &step.gives {
            let drawn = matches!(joined.plan.streams[usize::from(id.stream)].content, Content::Visual { .. });
            let given = if drawn {
                joined.outbox.visual(&joined.plan, id, &visuals).map(|content| (content, None))
            } else {
                joined.outbox.give(&joined.plan, id, &outputs)
            };
            match given {
                Ok((content, impulses)) => {
                    done.produced.push((id.stream, id.index, content));
                    if let (Some(j), Some(interface)) = (impulses, interface_of(joined, id.stream)) {
                        let (total, gross) = j.sums();
                        done.sent.push((interface, total, gross));
                    }
                }
                Err(error) => {
                    let kind = match error {
                        OutputError::Missing { .. } => FailureKind::Bus,
                        OutputError::NotFinite { .. } => FailureKind::Physics,
                    };
                    return self.fail(kind, error.to_string(), now, out);
                }
            }
            out.extend(joined.outbox.frames(id).iter().map(|f| Action::Publish(id.stream, f.clone())));
        }
        if !self.checks.on(Check::KeepUntilSettled) {
            joined.outbox.forget_all();
        }
        merge_report(&mut done.report, outputs.report, self.underway.step == 0);
        merge_times(&mut done.times, times, self.underway.step == 0);
        if self.underway.step + 1 < steps.len() {
            self.underway.step += 1;
        } else {
            self.finish_window(window, state_hash, now, out);
        }
        self.advance(now, out);
    }

    fn finish_window(&mut self, window: u64, state_hash: u128, now: Duration, out: &mut Vec<Action>) {
        let mut done = std::mem::take(&mut self.underway.done);
        let handed = std::mem::take(&mut self.underway.handed);
        if let Some(joined) = &self.joined {
            done.moments.extend(handed.iter().filter_map(|h| h.moment(joined, window)));
        }
        done.window = window;
        done.state_hash = state_hash;
        self.underway.window = window + 1;
        self.underway.step = 0;
        self.progress = crate::control::Progress { window: window + 1, ..Default::default() };
        if let Some(joined) = &mut self.joined {
            forget_used(joined, window + 1);
        }
        let done = Box::new(done);
        self.unsettled.push((window, done.clone()));
        self.say(Up::Done(done), now, out);
        self.save_if_due(out);
    }
}

fn interface_of(joined: &Joined, stream: StreamId) -> Option<u16> {
    match joined.plan.streams[usize::from(stream)].content {
        Content::Impulses { interface, .. } => Some(interface),
        _ => None,
    }
}

/// Forgets messages below those that windows from `next` on can need.
pub(super) fn forget_used(joined: &mut Joined, next: u64) {
    let streams: Vec<(StreamId, bool)> =
        joined.plan.read_by(joined.id).map(|(id, s)| (id, matches!(s.content, Content::Statics { .. }))).collect();
    for (stream, statics) in streams {
        // Parallel impulses of the window before are needed, so one window is kept behind.
        if !statics {
            joined.inbox.forget_below(stream, next.saturating_sub(1));
        }
    }
}

/// Adds what a later step of a window reports.
fn merge_report(into: &mut Report, from: Report, first: bool) {
    if first {
        *into = from;
        return;
    }
    into.substeps += from.substeps;
    into.substep_bound_by = from.substep_bound_by;
    into.bodies = from.bodies;
    into.external = into.external.plus(from.external);
    into.supplied_j += from.supplied_j;
    into.energy = from.energy;
    into.probes = from.probes;
    for (name, n) in from.counters {
        count(&mut into.counters, &name, n);
    }
    for later in from.interfaces {
        match into.interfaces.iter_mut().find(|i| i.interface == later.interface) {
            Some(earlier) => {
                earlier.received = earlier.received.plus(later.received);
                earlier.gross += later.gross;
                earlier.work_j += later.work_j;
                earlier.residual = earlier.residual.max(later.residual);
            }
            None => into.interfaces.push(later),
        }
    }
}

fn merge_times(into: &mut Times, from: Times, first: bool) {
    if first {
        into.start_s = from.start_s;
    }
    into.end_s = from.end_s;
    into.compute_s += from.compute_s;
    into.wait_s += from.wait_s;
    into.transfer_s += from.transfer_s;
}
