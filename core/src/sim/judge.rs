//! The blow of a scenario, and whether the run answered it as it must.

use super::birth::{identity, pace};
use super::lives::Rot;
use super::scenario::Trouble;
use super::world::{Delivery, World};
use crate::checks::Checks;
use crate::coordinator::{self, Failure, Outcome};
use crate::participant::{self, Participant};
use crate::plan::{Content, ParticipantId};

/// How long a pause lasts \[µs\]: longer than the notice, shorter than the limit.
const PAUSE_US: u64 = 700_000;

impl<C: Checks + Copy> World<'_, C> {
    pub(super) fn make_trouble(&mut self) {
        match self.scenario.trouble {
            Trouble::None | Trouble::Lie(_) => {}
            Trouble::Kill(who) => {
                self.nodes[usize::from(who)].alive = false;
                self.post(1000, Delivery::Buried(who));
            }
            Trouble::Freeze(who) => self.nodes[usize::from(who)].frozen = true,
            Trouble::Pause(who) => {
                self.nodes[usize::from(who)].frozen = true;
                self.post(PAUSE_US, Delivery::Thaw(who));
            }
            Trouble::Stop | Trouble::Interrupt => self.tell_coordinator(coordinator::Event::Stop),
            Trouble::Double(who) => {
                let name = self.scenario.plan.name_of(who).to_owned();
                let mut double = Participant::new(identity(&name, self.epoch(), 9_999), pace());
                let now = self.now();
                for action in double.on(participant::Event::Tick, now) {
                    if let participant::Action::Control(bytes) = action {
                        self.post(5, Delivery::Up(who, bytes));
                    }
                }
                self.double = Some(double);
            }
            Trouble::Crash => {
                if self.life == 0 {
                    self.crashes = self.random.below(3);
                }
                self.crash(false);
            }
            Trouble::Rot(_) => self.crash(true),
        }
    }

    /// Whether the run ended as its scenario must (I3, I6).
    pub(super) fn judge(&self, expected: Option<u128>) -> Option<String> {
        let outcome = self.outcome.as_ref()?;
        let windows = self.scenario.plan.clock.windows;
        let finished = *outcome == Outcome::Finished;
        if finished && self.settled != windows {
            return Some(format!("it finished with {} of {windows} windows settled (I2)", self.settled));
        }
        if finished && expected.is_some_and(|e| e != self.fingerprint()) {
            return Some("it finished with another state than without faults (I3)".to_owned());
        }
        let late = finished && self.now_us <= self.scenario.trouble_at_us + 2 * PAUSE_US;
        let name = |who: ParticipantId| self.scenario.plan.name_of(who).to_owned();
        let as_it_must = match (self.scenario.trouble, outcome) {
            (Trouble::None | Trouble::Pause(_) | Trouble::Double(_) | Trouble::Crash | Trouble::Interrupt, end) => {
                *end == Outcome::Finished
            }
            // Who is told nothing has nothing to lie about.
            (Trouble::Lie(who), Outcome::Finished) if !self.is_told(who) => true,
            // Without a checkpoint there was nothing to spoil.
            (Trouble::Rot(who), end) => self.spoiled(end, &name(who)),
            // A blow after the last window comes too late to matter.
            (Trouble::Kill(_) | Trouble::Freeze(_) | Trouble::Stop | Trouble::Lie(_), Outcome::Finished) => late,
            (Trouble::Kill(who), Outcome::Failed(Failure::Died { who: named, .. }))
            | (Trouble::Freeze(who), Outcome::Failed(Failure::Silent { who: named, .. }))
            | (Trouble::Lie(who), Outcome::Failed(Failure::Protocol { who: named, .. })) => *named == name(who),
            (Trouble::Freeze(who), Outcome::Failed(Failure::Missing { who: named, .. })) => named.contains(&name(who)),
            (Trouble::Stop, Outcome::Stopped { windows }) => self.settled == *windows,
            _ => false,
        };
        (!as_it_must).then(|| format!("{:?} ended as {outcome:?} (I6)", self.scenario.trouble))
    }

    /// Whether a participant computes with anything that others send.
    fn is_told(&self, who: ParticipantId) -> bool {
        let counts = |content: &Content| !matches!(content, Content::Statics { .. });
        self.scenario.plan.read_by(who).any(|(_, stream)| counts(&stream.content))
    }

    /// Whose snapshot was spoiled must be told so, and for the right reason.
    fn spoiled(&self, outcome: &Outcome, name: &str) -> bool {
        match (self.rotten, outcome) {
            (None, end) => *end == Outcome::Finished,
            (Some(Rot::Bit | Rot::Stale), Outcome::Failed(Failure::Environment { who, .. }))
            | (Some(Rot::State | Rot::Message), Outcome::Failed(Failure::Protocol { who, .. })) => who == name,
            _ => false,
        }
    }
}
