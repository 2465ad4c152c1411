//! Points from which a run is resumed: their bytes, and who may resume with them.

mod honest;

use std::time::Duration;

use cosplat_core::checkpoint::{Checkpoint, CheckpointError, KeptMessage, Snapshot};
use cosplat_core::control::Up;
use cosplat_core::coordinator::{Action, Event, Failure, Limits, Outcome};
use cosplat_core::plan::ParticipantId;
use cosplat_core::sim::Scenario;
use xxhash_rust::xxh3::xxh3_128;

use honest::{EPOCH, RUN, fresh, honest_report, join, said};

/// Windows between checkpoints in these tests.
const EVERY: u64 = 3;

fn limits() -> Limits {
    Limits { checkpoint_every: Some(EVERY), ..Limits::default() }
}

/// The first checkpoint of a run, when everybody has stored a snapshot.
fn checkpoint(scenario: &Scenario) -> Checkpoint {
    let mut coordinator = fresh(scenario, EPOCH, limits());
    join(&mut coordinator, scenario, EPOCH, 0, None);
    let everyone = || 0..scenario.plan.participants.len() as ParticipantId;
    let mut actions = Vec::new();
    for window in 0..EVERY {
        for who in everyone() {
            let done = Up::Done(Box::new(honest_report(&scenario.plan, who, window)));
            actions.extend(coordinator.on(Event::Up(who, said(EPOCH, done)), Duration::ZERO));
        }
    }
    assert!(!actions.iter().any(|a| matches!(a, Action::Checkpoint(_))), "nobody has stored anything");
    for who in everyone() {
        let saved = Up::Saved { window: EVERY, problem: None };
        actions.extend(coordinator.on(Event::Up(who, said(EPOCH, saved)), Duration::ZERO));
    }
    let mut found = actions.into_iter().filter_map(|a| if let Action::Checkpoint(c) = a { Some(*c) } else { None });
    let first = found.next().expect("everybody has stored its snapshot");
    assert_eq!(found.next(), None, "once");
    first
}

fn snapshot() -> Snapshot {
    let message = |stream| KeptMessage { stream, index: 300, count: 2, payload: vec![1, 2, 3] };
    Snapshot {
        run: RUN,
        identity: 1 << 100,
        name: "mpm".to_owned(),
        window: 300,
        messages: vec![message(1), message(65_535)],
        state: (0..=255).collect(),
    }
}

#[test]
fn a_snapshot_and_a_checkpoint_survive_their_bytes() {
    assert_eq!(Snapshot::decode(&snapshot().encode()), Ok(snapshot()));
    let point = checkpoint(&Scenario::from_seed(0));
    let read = Checkpoint::decode(&point.encode()).expect("what was just written");
    // Links come from the scene and are not stored.
    assert_eq!(read.encode(), point.encode());
    assert_eq!((read.window, read.epoch, read.state_hash), (EVERY, EPOCH, point.state_hash));
}

#[test]
fn bytes_that_are_not_whole_are_refused() {
    let bytes = snapshot().encode();
    for length in 0..bytes.len() {
        assert!(Snapshot::decode(&bytes[..length]).is_err(), "cut to {length} bytes");
    }
    for bit in 0..bytes.len() * 8 {
        let mut spoiled = bytes.clone();
        spoiled[bit / 8] ^= 1 << (bit % 8);
        assert!(Snapshot::decode(&spoiled).is_err(), "bit {bit}");
    }
    assert_eq!(Snapshot::decode(b"ply\nformat ascii 1.0"), Err(CheckpointError::Foreign));
    assert!(matches!(Checkpoint::decode(&bytes), Err(CheckpointError::Malformed(_))), "a snapshot is no checkpoint");
}

/// Bytes with a right checksum.
fn sealed(body: &[u8]) -> Vec<u8> {
    [body, &xxh3_128(body).to_le_bytes()].concat()
}

#[test]
fn what_the_checksum_does_not_catch_is_refused_too() {
    let bytes = snapshot().encode();
    let body = &bytes[..bytes.len() - 16];
    assert!(Snapshot::decode(&sealed(body)).is_ok());
    assert!(matches!(Snapshot::decode(&sealed(&[body, &[0]].concat())), Err(CheckpointError::Malformed(_))));
    let mut newer = body.to_vec();
    newer[4] += 1;
    assert_eq!(Snapshot::decode(&sealed(&newer)), Err(CheckpointError::Version { found: 2 }));
    // The state claims 2^63 bytes and has none: the last two bytes of an empty list of messages and an empty state.
    let empty = Snapshot { messages: Vec::new(), state: Vec::new(), ..snapshot() }.encode();
    let head = &empty[..empty.len() - 17];
    for list in [&[][..], &[0]] {
        let huge = [head, list, &[0xff; 9], &[0x01]].concat();
        assert!(matches!(Snapshot::decode(&sealed(&huge)), Err(CheckpointError::Malformed(_))));
    }
    for length in 0..body.len() {
        // No panic, whatever it is.
        let _ = (Snapshot::decode(&sealed(&body[..length])), Checkpoint::decode(&sealed(&body[..length])));
    }
}

#[test]
fn only_the_same_run_with_a_later_incarnation_goes_on() {
    let scenario = Scenario::from_seed(0);
    let point = checkpoint(&scenario);
    let resume = |point: &Checkpoint, scenario: &Scenario, epoch| {
        fresh(scenario, epoch, limits()).resumed(point.clone()).map(|c| c.settled())
    };
    assert_eq!(resume(&point, &scenario, EPOCH + 1), Ok(EVERY));
    for epoch in [0, EPOCH] {
        assert_eq!(resume(&point, &scenario, epoch), Err(CheckpointError::Epoch { written: EPOCH, epoch }));
    }
    let other = Checkpoint { run: [8; 16], ..point.clone() };
    assert_eq!(resume(&other, &scenario, EPOCH + 1), Err(CheckpointError::Run));
    assert_eq!(resume(&point, &Scenario::from_seed(1), EPOCH + 1), Err(CheckpointError::Identity));
    let mut threads = scenario.clone();
    threads.plan.participants.iter_mut().for_each(|p| p.threads += 5);
    threads.scenes.iter_mut().for_each(|scene| scene.threads += 5);
    assert_eq!(resume(&point, &threads, EPOCH + 1), Ok(EVERY), "results do not depend on the number of threads");
    let mut slower = scenario.clone();
    slower.plan.clock.tick_s *= 2.0;
    assert_eq!(resume(&point, &slower, EPOCH + 1), Err(CheckpointError::Identity));
    for spoiled in [
        Checkpoint { window: 0, ..point.clone() },
        Checkpoint { window: u64::MAX, ..point.clone() },
        Checkpoint { states: Vec::new(), ..point.clone() },
        Checkpoint { published: Vec::new(), ..point.clone() },
    ] {
        let refused = resume(&spoiled, &scenario, EPOCH + 1);
        assert!(matches!(refused, Err(CheckpointError::Malformed(_))), "{refused:?}");
    }
}

#[test]
fn a_participant_that_does_not_restore_its_state_is_named() {
    let scenario = Scenario::from_seed(0);
    let point = checkpoint(&scenario);
    for (restored, word) in [(None, "did not restore"), (Some(1), "is not the one")] {
        let mut coordinator = fresh(&scenario, EPOCH + 1, limits()).resumed(point.clone()).expect("the same run");
        let actions = join(&mut coordinator, &scenario, EPOCH + 1, EVERY, restored);
        let failure = actions.into_iter().find_map(|a| match a {
            Action::Ended(Outcome::Failed(failure @ Failure::Protocol { .. })) => Some(failure.to_string()),
            _ => None,
        });
        let failure = failure.expect("it went on");
        assert!(failure.contains("`p0`") && failure.contains(word), "{failure}");
    }
    // Honest reports say that every state is 0.
    let mut coordinator = fresh(&scenario, EPOCH + 1, limits()).resumed(point).expect("the same run");
    let actions = join(&mut coordinator, &scenario, EPOCH + 1, EVERY, Some(0));
    assert!(actions.iter().any(|a| matches!(a, Action::Started)));
    assert_eq!(coordinator.granted(), EVERY + Limits::default().ahead);
}

/// Hosts that store nothing do not hold a stop for ever.
#[test]
fn a_stop_does_not_wait_for_ever_for_its_checkpoint() {
    let scenario = Scenario::from_seed(0);
    let mut coordinator = fresh(&scenario, EPOCH, limits());
    join(&mut coordinator, &scenario, EPOCH, 0, None);
    coordinator.on(Event::Stop, Duration::ZERO);
    let stop = coordinator.granted();
    let everyone = || 0..scenario.plan.participants.len() as ParticipantId;
    for window in 0..stop {
        for who in everyone() {
            let done = Up::Done(Box::new(honest_report(&scenario.plan, who, window)));
            let actions = coordinator.on(Event::Up(who, said(EPOCH, done)), Duration::ZERO);
            assert!(!actions.iter().any(|a| matches!(a, Action::Ended(_))), "its checkpoint is not stored");
        }
    }
    let mut ended = None;
    for seconds in 1..=limits().join.as_secs() + 1 {
        for who in everyone() {
            let alive = said(EPOCH, Up::Heartbeat(cosplat_core::control::Progress::default()));
            coordinator.on(Event::Up(who, alive), Duration::from_secs(seconds));
        }
        for action in coordinator.on(Event::Tick, Duration::from_secs(seconds)) {
            if let Action::Ended(outcome) = action {
                ended = Some((seconds, outcome));
            }
        }
    }
    assert_eq!(ended, Some((limits().join.as_secs() + 1, Outcome::Stopped { windows: stop })));
}
