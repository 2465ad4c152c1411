//! Input that no partner should send, and being told to stop.

use cosplat_core::boundary::{BoundaryState, Impulses};
use cosplat_core::plugin::{Inputs, PluginError, Pulse, Signal, Steady};

use crate::rule::Rule::{AbortHonoured, BeatsCount, NonFiniteInput};
use crate::shape::finite_outputs;
use crate::trial::{Trial, Verdict};
use crate::{Case, Make};

pub(crate) fn check(make: Make<'_>, case: &Case, verdict: &mut Verdict) {
    let window = &case.windows[0];
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        for i in 0..window.impulses.len() {
            for (angular, name) in [(false, "an impulse"), (true, "an angular impulse")] {
                let mut inputs = window.clone();
                if spoil_impulses(&mut inputs.impulses[i].impulses, angular, bad) {
                    expect_physics(make, case, &inputs, &format!("{name} of {bad}"), verdict);
                }
            }
        }
        for i in 0..window.partners.len() {
            let mut inputs = window.clone();
            // Of two records the newer one counts for some rules, the older one for others: spoil both.
            let partner = &mut inputs.partners[i];
            spoil_position(&mut partner.now, bad);
            partner.next.iter_mut().for_each(|next| spoil_position(next, bad));
            expect_physics(make, case, &inputs, &format!("a partner at {bad} m"), verdict);
        }
    }
    beats(make, case, verdict);
}

/// False where there is nothing of that kind to spoil.
fn spoil_impulses(impulses: &mut Impulses, angular: bool, bad: f64) -> bool {
    let number = match impulses {
        Impulses::Samples(each) if !angular => each.last_mut().map(|j| &mut j[1]),
        Impulses::Samples(_) => None,
        Impulses::Rigid(wrench) if angular => Some(&mut wrench.angular[1]),
        Impulses::Rigid(wrench) => Some(&mut wrench.linear[1]),
    };
    number.is_some_and(|number| {
        *number = bad;
        true
    })
}

fn spoil_position(state: &mut BoundaryState, bad: f64) {
    match state {
        BoundaryState::Samples(s) => {
            if let Some(last) = s.position.last_mut() {
                last[1] = bad;
            }
        }
        BoundaryState::Proxy(p) => p.position[1] = bad,
    }
}

fn expect_physics(make: Make<'_>, case: &Case, inputs: &Inputs, what: &str, verdict: &mut Verdict) {
    let Ok((mut trial, _)) = Trial::start(make, case) else { return };
    match trial.hear(0, inputs, &mut Steady) {
        Err(PluginError::Physics(_)) => {}
        Err(why) => verdict.add(NonFiniteInput, format!("{what} gives another error: {why}")),
        Ok(outputs) => {
            let answer = if finite_outputs(&outputs) { "is ignored" } else { "comes out again" };
            verdict.add(NonFiniteInput, format!("{what} {answer} without an error"));
        }
    }
}

/// Counts beats and stops at one of them.
struct Stop {
    at: u64,
    beats: u64,
    last: (u64, u64),
    sane: bool,
}

impl Pulse for Stop {
    fn beat(&mut self, done: u64, of: u64) -> Signal {
        self.beats += 1;
        self.sane &= done <= of && done >= self.last.0;
        self.last = (done, of);
        if self.beats >= self.at { Signal::Abort } else { Signal::Continue }
    }
}

fn beats(make: Make<'_>, case: &Case, verdict: &mut Verdict) {
    let play = |at: u64| {
        let mut pulse = Stop { at, beats: 0, last: (0, 0), sane: true };
        let (mut trial, _) = Trial::start(make, case).ok()?;
        let result = trial.hear(0, &case.windows[0], &mut pulse);
        Some((result, pulse))
    };
    let Some((_, whole)) = play(u64::MAX) else { return };
    if whole.beats == 0 {
        // A step too short to beat in cannot be stopped, and need not be.
        return;
    }
    verdict.must(whole.sane, BeatsCount, || "beats go back, or beyond what they announce".into());
    let Some((result, pulse)) = play(1) else { return };
    verdict.must(matches!(result, Err(PluginError::Aborted)), AbortHonoured, || {
        format!("told to stop at its first beat, it ends with {:?}", result.map(|_| "a result"))
    });
    verdict.must(pulse.beats <= 2, AbortHonoured, || format!("it beats {} times after the word", pulse.beats - 1));
}
