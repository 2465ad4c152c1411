//! Saying things again: unanswered messages, missing messages, signs of life.

use std::time::Duration;

use super::{Action, Ending, Participant, Phase};
use crate::checks::{Check, Checks};
use crate::control::{self, PROTOCOL, Resend, Up};
use crate::plan::schedule::{self, MessageId};

/// How long a failure is repeated before the process leaves without an answer.
const PATIENCE: Duration = Duration::from_secs(3);

impl<C: Checks> Participant<C> {
    pub(super) fn on_resend(&mut self, bytes: &[u8], out: &mut Vec<Action>) {
        let Some(joined) = &self.joined else { return };
        let Ok(envelope) = control::decode::<Resend>(bytes) else { return };
        let foreign = envelope.run != self.identity.run || envelope.epoch != self.identity.epoch;
        if envelope.protocol != PROTOCOL || foreign {
            return;
        }
        let Resend { stream, index } = envelope.body;
        out.extend(
            joined.outbox.frames(MessageId { stream, index }).iter().map(|f| Action::Publish(stream, f.clone())),
        );
    }

    pub(super) fn on_tick(&mut self, now: Duration, out: &mut Vec<Action>) {
        if self.heard_at + self.pace.orphaned < now {
            return self.end(Ending::Orphaned, out);
        }
        if self.said_at + self.pace.repeat <= now || !self.greeted {
            self.repeat(now, out);
        }
        if self.asked_at + self.pace.repeat <= now {
            self.asked_at = now;
            if self.checks.on(Check::AskAgain) {
                self.ask_again(out);
            }
        }
        if self.beat_at + self.pace.heartbeat <= now && self.phase > Phase::Greeting {
            self.beat_at = now;
            out.push(self.envelope(Up::Heartbeat(self.progress)));
        }
    }

    /// Says again what has not been answered.
    pub(super) fn repeat(&mut self, now: Duration, out: &mut Vec<Action>) {
        let first = !std::mem::replace(&mut self.greeted, true);
        self.said_at = now;
        match self.phase {
            Phase::Greeting if first || self.checks.on(Check::RepeatHello) => {
                let descriptor = serde_json::to_string(&self.identity.descriptor).unwrap_or_default();
                let hello = Up::Hello {
                    name: self.identity.name.clone(),
                    pid: self.identity.pid,
                    protocol: self.identity.descriptor.protocol,
                    descriptor,
                };
                out.push(self.envelope(hello));
            }
            Phase::Ready => {
                let ready = self.joined.as_ref().map(|j| Up::Ready(Box::new(j.ready.clone())));
                out.extend(ready.map(|r| self.envelope(r)));
            }
            Phase::Probing => self.report_probes(now, out),
            Phase::Failing => self.repeat_failure(now, out),
            Phase::Running if self.checks.on(Check::RepeatDone) => {
                let again: Vec<Action> =
                    self.unsettled.iter().map(|(_, done)| self.envelope(Up::Done(done.clone()))).collect();
                out.extend(again);
            }
            _ => {}
        }
    }

    /// Says again why it cannot go on; leaves when nobody seems to want to know.
    fn repeat_failure(&mut self, now: Duration, out: &mut Vec<Action>) {
        let Some((kind, message, since)) = self.failure.clone() else { return };
        if now > since + PATIENCE {
            return self.end(Ending::Failed(message), out);
        }
        let failed = self.envelope(Up::Failed { kind, message });
        out.push(failed);
    }

    /// Asks senders for what is missing.
    pub(super) fn ask_again(&self, out: &mut Vec<Action>) {
        let Some(joined) = &self.joined else { return };
        if self.phase == Phase::Fetching {
            return self.fetch_again(out);
        }
        let missing = match self.phase {
            Phase::Ready | Phase::Probing => schedule::needed_at_start(&joined.plan, joined.id),
            Phase::Running if !self.underway.computing && self.underway.window < self.until => {
                self.current_step(joined).map(|s| s.needs.iter().map(|n| n.message).collect()).unwrap_or_default()
            }
            _ => Vec::new(),
        };
        for id in missing.into_iter().filter(|&id| joined.inbox.message(id).is_none()) {
            let from = joined.plan.streams[usize::from(id.stream)].from;
            let request = Resend { stream: id.stream, index: id.index };
            out.push(Action::Request(from, self.wrap(request)));
        }
    }
}
