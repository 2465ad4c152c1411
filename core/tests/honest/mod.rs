//! Participants that say exactly what the protocol wants to hear.

use std::time::Duration;

use cosplat_core::control::{self, Done, Envelope, PROTOCOL, ReadyInfo, Up};
use cosplat_core::coordinator::{Action, Coordinator, Event, Limits};
use cosplat_core::plan::schedule::{self, MessageId};
use cosplat_core::plan::{ParticipantId, Plan};
use cosplat_core::sim::Scenario;

pub(crate) const RUN: [u8; 16] = [7; 16];
pub(crate) const EPOCH: u32 = 3;
/// Content hash of every message in these tests: the coordinator compares hashes and never sees a message.
const CONTENT: u64 = 1;

pub(crate) fn said(epoch: u32, body: Up) -> Vec<u8> {
    control::encode(&Envelope { protocol: PROTOCOL, run: RUN, epoch, instance: 9, body })
}

fn listed(ids: impl IntoIterator<Item = MessageId>) -> Vec<(u16, u64, u64)> {
    ids.into_iter().map(|id| (id.stream, id.index, CONTENT)).collect()
}

pub(crate) fn fresh(scenario: &Scenario, epoch: u32, limits: Limits) -> Coordinator {
    Coordinator::new(RUN, epoch, scenario.plan.clone(), scenario.scenes.clone(), limits)
}

/// Everybody joins a run that begins at window `from` with this state.
pub(crate) fn join(
    coordinator: &mut Coordinator,
    scenario: &Scenario,
    epoch: u32,
    from: u64,
    restored: Option<u128>,
) -> Vec<Action> {
    let plan = &scenario.plan;
    let everyone = || (0..).zip(&plan.participants);
    let mut tell = |who: ParticipantId, up: Up| coordinator.on(Event::Up(who, said(epoch, up)), Duration::ZERO);
    let mut last = Vec::new();
    for (who, participant) in everyone() {
        let hello =
            Up::Hello { name: participant.name.clone(), pid: 1, protocol: [PROTOCOL; 2], descriptor: String::new() };
        tell(who, hello);
        let produced = listed(schedule::published_before(plan, who, from));
        last.extend(tell(who, Up::Ready(Box::new(ReadyInfo { produced, ..ReadyInfo::default() }))));
    }
    for (who, _) in everyone() {
        last.extend(tell(who, Up::Probed { streams: (0..plan.streams.len() as u16).collect(), restored }));
    }
    last
}

pub(crate) fn honest_report(plan: &Plan, who: ParticipantId, window: u64) -> Done {
    let steps = schedule::steps(plan, who, window);
    Done {
        window,
        consumed: listed(steps.iter().flat_map(|s| s.needs.iter().map(|n| n.message))),
        produced: listed(steps.iter().flat_map(|s| s.gives.clone())),
        ..Done::default()
    }
}
