//! How a run ends: done, stopped, or failed with a name attached. And what is said while somebody is waited for.

use std::time::Duration;

use super::{Action, Coordinator, Failure, Outcome, Peer, Phase};
use crate::checks::{Check, Checks};
use crate::control::Down;
use crate::plan::ParticipantId;

/// Time for the last words of a process that has died: what it said before is more telling than its exit code.
const LAST_WORDS: Duration = Duration::from_millis(200);

impl<C: Checks> Coordinator<C> {
    pub(super) fn on_died(&mut self, who: ParticipantId, how: String, now: Duration) {
        let Some(peer) = self.peers.get_mut(usize::from(who)) else { return };
        if self.checks.on(Check::NoticeDeath) {
            peer.died.get_or_insert((now, how));
        }
    }

    pub(super) fn on_stop(&mut self, out: &mut Vec<Action>) {
        match self.phase {
            Phase::Ended => {}
            Phase::Joining | Phase::Probing => {
                let windows = self.committed;
                self.finish(Outcome::Stopped { windows }, out);
            }
            Phase::Running => {
                let stop_at = *self.stop_at.get_or_insert(self.until);
                self.save_at_stop(stop_at);
                if !self.checks.on(Check::StopAtEdge) {
                    let windows = self.until;
                    self.finish(Outcome::Stopped { windows }, out);
                }
            }
        }
    }

    pub(super) fn on_tick(&mut self, now: Duration, out: &mut Vec<Action>) {
        if self.said_at + self.limits.repeat > now {
            return;
        }
        self.said_at = now;
        match self.phase {
            Phase::Ended => self.tell_farewell(out),
            Phase::Joining | Phase::Probing if now > self.limits.join => self.miss(out),
            // They have nothing to do until everybody is set up, but must not take the silence for a death.
            Phase::Joining => self.tell_joined(out),
            Phase::Probing => self.tell_all(&Down::Probe, out),
            Phase::Running => self.tell_all(&self.grant(), out),
        }
        if self.phase == Phase::Ended {
            return;
        }
        self.look_for_dead(now, out);
        if self.phase != Phase::Ended {
            self.look_for_silent(now, out);
        }
        if self.phase == Phase::Running {
            self.explain_waiting(now, out);
            self.give_up_saving(now, out);
            self.look_for_deadlock(now, out);
        }
    }

    /// Everybody lives and everybody waits: somebody's message is lost for good, or the plan has a circle.
    fn look_for_deadlock(&mut self, now: Duration, out: &mut Vec<Action>) {
        let waited = now.saturating_sub(self.settled_at);
        let alive = |p: &Peer| now.saturating_sub(p.heard_at) <= self.limits.silence_notice;
        let all_wait = self.peers.iter().all(|p| alive(p) && p.progress.waiting_for.is_some());
        if waited > self.limits.silence && all_wait {
            let waiting: Vec<String> = (0..self.peers.len() as ParticipantId)
                .map(|who| format!("`{}` is {}", self.plan.name_of(who), self.describe(who)))
                .collect();
            let (window, seconds) = (self.committed, waited.as_secs());
            self.fail(Failure::Deadlock { window, seconds, waiting: waiting.join(", ") }, out);
        }
    }

    fn look_for_dead(&mut self, now: Duration, out: &mut Vec<Action>) {
        let dead = self.peers.iter().enumerate().filter_map(|(i, p)| p.died.as_ref().map(|(at, how)| (*at, i, how)));
        // The first to die is the cause; the others follow it.
        let Some((at, i, how)) = dead.min_by_key(|(at, i, _)| (*at, *i)) else { return };
        if now < at + LAST_WORDS {
            return;
        }
        let who = i as ParticipantId;
        let failure =
            Failure::Died { who: self.plan.name_of(who).to_owned(), window: self.window_of(who), how: how.clone() };
        self.fail(failure, out);
    }

    fn look_for_silent(&mut self, now: Duration, out: &mut Vec<Action>) {
        for i in 0..self.peers.len() {
            let who = i as ParticipantId;
            let peer = &self.peers[i];
            if peer.instance.is_none() {
                continue;
            }
            let silent = now.saturating_sub(peer.heard_at);
            let waiting = self.describe(who);
            let (name, window) = (self.plan.name_of(who).to_owned(), self.window_of(who));
            if silent > self.limits.silence && self.checks.on(Check::NoticeSilence) {
                return self.fail(Failure::Silent { who: name, window, seconds: silent.as_secs(), waiting }, out);
            }
            if silent > self.limits.silence_notice && !peer.noticed {
                self.peers[i].noticed = true;
                let seconds = silent.as_secs_f64();
                let text = format!("no sign of life from `{name}` for {seconds:.1} s in window {window}, {waiting}");
                out.push(Action::Notice(text));
            }
        }
    }

    /// Says who is waited for when no window has been settled for a while.
    fn explain_waiting(&mut self, now: Duration, out: &mut Vec<Action>) {
        let waited = now.saturating_sub(self.settled_at);
        let periods = (waited.as_secs_f64() / self.limits.silence_notice.as_secs_f64().max(1e-3)) as u64;
        if periods == 0 {
            self.noticed_wait = 0;
        }
        if periods <= self.noticed_wait {
            return;
        }
        self.noticed_wait = periods;
        if let Some(text) = self.stop_at.and_then(|_| self.explain_saving()) {
            return out.push(Action::Notice(text));
        }
        let late: Vec<String> = (0..self.peers.len() as ParticipantId)
            .filter(|&who| self.window_of(who) == self.committed)
            .map(|who| format!("`{}` ({})", self.plan.name_of(who), self.describe(who)))
            .collect();
        let seconds = waited.as_secs_f64();
        out.push(Action::Notice(format!(
            "window {} after {seconds:.1} s: waiting for {}",
            self.committed,
            late.join(", ")
        )));
    }

    /// What a participant was last known to do.
    fn describe(&self, who: ParticipantId) -> String {
        let progress = &self.peers[usize::from(who)].progress;
        match progress.waiting_for.and_then(|s| self.plan.streams.get(usize::from(s))) {
            Some(stream) => format!("waiting for `{}` from `{}`", stream.key, self.plan.name_of(stream.from)),
            None if progress.substeps > 0 => format!("substep {} of {}", progress.substep, progress.substeps),
            None => "computing".to_owned(),
        }
    }

    fn miss(&mut self, out: &mut Vec<Action>) {
        let joining = self.phase == Phase::Joining;
        let absent = |ready: bool, probed: bool| if joining { !ready } else { !probed };
        let who: Vec<String> = self
            .peers
            .iter()
            .zip(&self.plan.participants)
            .filter(|(peer, _)| absent(peer.ready.is_some(), peer.probed))
            .map(|(_, participant)| participant.name.clone())
            .collect();
        let greeted = self.peers.iter().filter(|p| p.instance.is_some()).count();
        let phase = match (joining, greeted == self.peers.len()) {
            (true, false) => "it never said hello".to_owned(),
            (true, true) => "it did not finish its set-up".to_owned(),
            (false, _) => "it does not hear all its streams".to_owned(),
        };
        self.fail(Failure::Missing { who, seconds: self.limits.join.as_secs(), phase }, out);
    }

    pub(super) fn finish(&mut self, outcome: Outcome, out: &mut Vec<Action>) {
        self.phase = Phase::Ended;
        self.farewell = Some(Down::Finish);
        self.tell_farewell(out);
        out.push(Action::Ended(outcome));
    }

    pub(super) fn fail(&mut self, failure: Failure, out: &mut Vec<Action>) {
        if self.phase == Phase::Ended {
            return;
        }
        self.phase = Phase::Ended;
        self.farewell = Some(Down::Abort { reason: failure.to_string() });
        self.tell_farewell(out);
        out.push(Action::Ended(Outcome::Failed(failure)));
    }

    fn tell_joined(&self, out: &mut Vec<Action>) {
        let here = self.peers.iter().enumerate().filter(|(_, p)| p.instance.is_some());
        out.extend(here.map(|(i, _)| self.send(i as ParticipantId, self.grant())));
    }

    /// Says goodbye to those who have not answered it; to the dead too, who may be alive after all.
    fn tell_farewell(&self, out: &mut Vec<Action>) {
        let Some(farewell) = &self.farewell else { return };
        let here = self.peers.iter().enumerate().filter(|(_, p)| !p.left && p.instance.is_some());
        out.extend(here.map(|(i, _)| self.send(i as ParticipantId, farewell.clone())));
    }
}
