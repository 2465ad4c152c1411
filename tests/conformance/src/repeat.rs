//! Same state, same step, same bits: set-up, steps, saved states, threads, order.

use cosplat_core::plugin::{Inputs, Outputs, PluginError, Setup};

use crate::rule::Rule;
use crate::trial::{Trial, Verdict, bits};
use crate::{Case, Make};

pub(crate) fn check(make: Make<'_>, case: &Case, verdict: &mut Verdict) {
    setups(make, case, verdict);
    threads(make, case, verdict);
    order(make, case, verdict);
    if make().describe().saves.bytes {
        states(make, case, verdict);
        damage(make, case, verdict);
    }
}

fn setups(make: Make<'_>, case: &Case, verdict: &mut Verdict) {
    let (Ok((mut one, first)), Ok((other, second))) = (Trial::start(make, case), Trial::start(make, case)) else {
        return;
    };
    let mut same = |a: &Setup, b: &Setup, what: &str| {
        verdict.must(bits(a) == bits(b), Rule::SetupRepeats, || format!("boundaries or report differ {what}"));
    };
    same(&first, &second, "between two instances");
    let hash = other.hash();
    verdict.must(one.hash() == hash, Rule::SetupRepeats, || "the states of two instances differ".into());
    // Again on an instance that has moved on.
    let moved = one.window(0);
    match (moved, one.plugin.setup(&case.scene)) {
        (Ok(_), Ok(again)) => {
            let differs = bits(&first) != bits(&again) || one.hash() != hash;
            verdict.must(!differs, Rule::SetupRepeats, || "set-up after a window differs from the first".into());
        }
        (_, Err(why)) => verdict.add(Rule::SetupRepeats, format!("the second set-up failed: {why}")),
        _ => {}
    }
}

/// Answers and final state of all windows.
fn run(make: Make<'_>, case: &Case, change: impl Fn(&mut Inputs), threads: usize) -> Option<(Vec<Outputs>, u128)> {
    let mut scene = case.scene.clone();
    scene.threads = threads;
    let (mut trial, _) = Trial::start_with(make, case, &scene).ok()?;
    let mut all = Vec::new();
    for (window, inputs) in case.windows.iter().enumerate() {
        let mut inputs = inputs.clone();
        change(&mut inputs);
        all.push(trial.hear(window, &inputs, &mut cosplat_core::plugin::Steady).ok()?);
    }
    Some((all, trial.hash()))
}

fn threads(make: Make<'_>, case: &Case, verdict: &mut Verdict) {
    let one = run(make, case, |_| {}, 1);
    for threads in [2, 5] {
        let same = bits(&one) == bits(&run(make, case, |_| {}, threads));
        verdict.must(same, Rule::ThreadsDoNotMatter, || format!("{threads} threads give other bits than one"));
    }
}

fn order(make: Make<'_>, case: &Case, verdict: &mut Verdict) {
    let swap = |inputs: &mut Inputs| {
        inputs.partners.reverse();
        inputs.impulses.reverse();
    };
    let same = bits(&run(make, case, |_| {}, 1)) == bits(&run(make, case, swap, 1));
    verdict.must(same, Rule::OrderDoesNotMatter, || "inputs in reverse order give other bits".into());
}

fn states(make: Make<'_>, case: &Case, verdict: &mut Verdict) {
    let Ok((mut trial, _)) = Trial::start(make, case) else { return };
    let last = case.windows.len() - 1;
    for window in 0..=last {
        let state = trial.saved();
        let hash = trial.hash();
        if let Err(why) = trial.plugin.restore(&state) {
            verdict.add(Rule::RestoreIsIdentity, format!("its own state is refused: {why}"));
            return;
        }
        let same = trial.saved() == state && trial.hash() == hash;
        verdict.must(same, Rule::RestoreIsIdentity, || format!("the state before window {window} comes back changed"));
        let first = trial.window(window);
        let after = trial.hash();
        if case.moves {
            verdict.must(after != hash, Rule::StateMoves, || format!("the hash stays the same in window {window}"));
        }
        let again = trial.plugin.restore(&state).and_then(|()| trial.window(window));
        let same = bits(&first) == bits(&again) && trial.hash() == after;
        verdict.must(same, Rule::StepRepeats, || format!("window {window} repeated from its state gives other bits"));
        // In a new process there is nothing but the scene and the state.
        let Ok((mut fresh, _)) = Trial::start(make, case) else { return };
        let moved = fresh.plugin.restore(&state).and_then(|()| fresh.window(window));
        let same = bits(&first) == bits(&moved) && fresh.hash() == after;
        verdict.must(same, Rule::StateComplete, || format!("window {window} in a new instance gives other bits"));
    }
}

fn damage(make: Make<'_>, case: &Case, verdict: &mut Verdict) {
    let Ok((mut trial, _)) = Trial::start(make, case) else { return };
    if trial.window(0).is_err() {
        return;
    }
    let state = trial.saved();
    let mut longer = state.clone();
    longer.push(0);
    let mut damaged =
        vec![("a state with a byte too many", longer), ("bytes that are no state", vec![0xa5; state.len()])];
    if !state.is_empty() {
        damaged.push(("a state that lacks its last byte", state[..state.len() - 1].to_vec()));
        damaged.push(("half a state", state[..state.len() / 2].to_vec()));
        damaged.push(("nothing", Vec::new()));
    }
    for (what, bytes) in damaged {
        match trial.plugin.restore(&bytes) {
            Err(PluginError::State(_)) => {}
            Err(why) => verdict.add(Rule::DamagedStateRefused, format!("{what} gives another error: {why}")),
            Ok(()) if bytes == state => {}
            Ok(()) => verdict.add(Rule::DamagedStateRefused, format!("{what} is accepted")),
        }
        let kept = trial.saved() == state;
        verdict.must(kept, Rule::DamagedStateRefused, || format!("{what} changes the plugin"));
        if !kept && trial.plugin.restore(&state).is_err() {
            return;
        }
    }
}
