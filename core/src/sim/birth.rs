//! New processes: what every life of a simulated run begins with.

use std::collections::BTreeMap;
use std::time::Duration;

use super::host::Node;
use super::scenario::Scenario;
use super::toy::{Toy, descriptor};
use crate::checks::Checks;
use crate::coordinator::{Coordinator, Limits};
use crate::participant::{Identity, Pace, Participant};

pub(super) const RUN: [u8; 16] = *b"simulated run 01";
pub(super) const EPOCH: u32 = 7;

fn limits(checkpoint_every: Option<u64>) -> Limits {
    Limits {
        join: Duration::from_secs(20),
        silence_notice: Duration::from_millis(300),
        silence: Duration::from_secs(4),
        repeat: Duration::from_millis(10),
        ahead: 2,
        checkpoint_every,
    }
}

pub(super) fn pace() -> Pace {
    Pace { repeat: Duration::from_millis(10), heartbeat: Duration::from_millis(50), orphaned: Duration::from_secs(30) }
}

pub(super) fn identity(name: &str, epoch: u32, instance: u64) -> Identity {
    Identity { run: RUN, epoch, name: name.to_owned(), instance, pid: 1, descriptor: descriptor() }
}

pub(super) fn fresh_coordinator<C: Checks + Copy>(scenario: &Scenario, epoch: u32, checks: C) -> Coordinator<C> {
    let (plan, scenes) = (scenario.plan.clone(), scenario.scenes.clone());
    Coordinator::with_checks(RUN, epoch, plan, scenes, limits(scenario.checkpoint_every), checks)
}

/// New processes for a life that begins at `window`.
pub(super) fn fresh_nodes<C: Checks + Copy>(scenario: &Scenario, life: u32, window: u64, checks: C) -> Vec<Node<C>> {
    let drawn = scenario.plan.recorder.filter(|_| window > 0).map(|r| window / r.windows_per_frame + 1);
    let instance = |i: usize| 100 + i as u64 * 2 + 10_000 * u64::from(life);
    let node = |(i, p): (usize, &crate::plan::Participant)| Node {
        machine: Participant::with_checks(identity(&p.name, EPOCH + life, instance(i)), pace(), checks),
        plugin: Toy::of(&p.plugin),
        alive: true,
        frozen: false,
        missed: Vec::new(),
        states: BTreeMap::new(),
        next_frame: drawn.unwrap_or(0),
        pending: BTreeMap::new(),
        ending: None,
    };
    scenario.plan.participants.iter().enumerate().map(node).collect()
}
