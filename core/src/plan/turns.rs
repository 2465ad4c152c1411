//! Who waits for whom within a window, and what follows: whether anybody can start, and who shares the cores.

use std::collections::{BTreeMap, BTreeSet};

use super::schedule::{self, MessageId};
use super::{Interface, Participant, ParticipantId, Plan, Refusal};
use crate::scene::Scheme;

/// Within a window nobody may wait for somebody who waits for him. Schemes that swap are checked in both orders.
pub(super) fn check(found: &[Interface], participants: &[Participant], refusals: &mut Vec<Refusal>) {
    for swapped in [false, true] {
        let waits: BTreeSet<_> = found.iter().filter_map(|i| waiting(i, swapped)).collect();
        let stuck = circle(waits);
        if !stuck.is_empty() {
            let names: Vec<&str> = stuck.iter().map(|&p| participants[usize::from(p)].name.as_str()).collect();
            let why = "within one window each would wait for the other; choose the `resolver` of their pairs and the \
                       `first` of their serial links so that the order has no circle, or use the parallel scheme";
            refusals.push(Refusal::new(format!("solvers `{}`", names.join("`, `")), why));
            break;
        }
    }
    let centred = found.iter().filter(|i| i.scheme == Scheme::Centred);
    let halved: BTreeSet<ParticipantId> = centred.map(|i| i.b.participant).collect();
    for i in found {
        let other = i.scheme != Scheme::Centred && halved.contains(&i.b.participant);
        if other || halved.contains(&i.a.participant) {
            let why = "its solver takes a centred link in two half windows, which goes with no other interface";
            refusals.push(Refusal::new(format!("interface `{}`", i.name), why));
        }
    }
}

/// Who waits for whom within a window, if anybody: waiter, then source.
fn waiting(i: &Interface, swapped: bool) -> Option<(ParticipantId, ParticipantId)> {
    let (a, b) = (i.a.participant, i.b.participant);
    match i.scheme {
        Scheme::Parallel | Scheme::Centred => None,
        Scheme::Serial => Some((b, a)),
        Scheme::Alternating => Some(if swapped { (a, b) } else { (b, a) }),
    }
}

/// Members of circles of waiting, in order: what is left when those who wait for nobody, and those nobody waits for,
/// are taken away again and again.
fn circle(mut waits: BTreeSet<(ParticipantId, ParticipantId)>) -> BTreeSet<ParticipantId> {
    loop {
        let waiters: BTreeSet<ParticipantId> = waits.iter().map(|&(waiter, _)| waiter).collect();
        let sources: BTreeSet<ParticipantId> = waits.iter().map(|&(_, source)| source).collect();
        let before = waits.len();
        waits.retain(|(waiter, source)| sources.contains(waiter) && waiters.contains(source));
        if waits.len() == before {
            return waiters;
        }
    }
}

/// Threads of each participant: the cores are divided within a level; a level with one member gets all of them.
pub(super) fn threads(plan: &Plan, cores: usize) -> Vec<usize> {
    let mut most = vec![1; plan.participants.len()];
    // Two windows: the schemes that swap have two orders.
    for window in 0..2 {
        let levels = levels(plan, window);
        let mut members: BTreeMap<usize, usize> = BTreeMap::new();
        let solvers = || levels.iter().zip(0..).filter(|(_, id)| plan.is_solver(*id)).map(|(own, _)| own);
        solvers().flatten().for_each(|&level| *members.entry(level).or_default() += 1);
        for (most, own) in most.iter_mut().zip(&levels) {
            *most = own.iter().filter_map(|level| members.get(level)).copied().fold(*most, usize::max);
        }
    }
    // A recorder has no turn: what it does beside the solvers takes what they leave.
    let most = most.into_iter().zip(0..);
    most.map(|(members, id)| if plan.is_solver(id) { (cores / members).max(1) } else { cores }).collect()
}

/// Level of each step of each participant: one more than the highest it waits for within the window.
fn levels(plan: &Plan, window: u64) -> Vec<Vec<usize>> {
    let all: Vec<_> = (0..plan.participants.len()).map(|p| schedule::steps(plan, p as ParticipantId, window)).collect();
    let mut givers: BTreeMap<MessageId, (usize, usize)> = BTreeMap::new();
    for (p, steps) in all.iter().enumerate() {
        for (s, step) in steps.iter().enumerate() {
            givers.extend(step.gives.iter().map(|&id| (id, (p, s))));
        }
    }
    let mut levels: Vec<Vec<usize>> = all.iter().map(|steps| vec![0; steps.len()]).collect();
    // Each round settles at least one more step, for there is no circle of waiting: `check` has refused it.
    for _ in 0..all.iter().map(Vec::len).sum() {
        for (p, steps) in all.iter().enumerate() {
            for (s, step) in steps.iter().enumerate() {
                let sources = step.needs.iter().filter_map(|n| givers.get(&n.message)).copied();
                let earlier = s.checked_sub(1).map(|s| (p, s));
                let highest = sources.chain(earlier).map(|(p, s)| levels[p][s] + 1).max();
                levels[p][s] = highest.unwrap_or(0);
            }
        }
    }
    levels
}
