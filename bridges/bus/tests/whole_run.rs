//! Runs from start to end through the real zenoh, participants in threads of this process.
#![allow(clippy::unwrap_used, reason = "helpers outside of test functions")]

mod common;
#[path = "common/point.rs"]
mod point;

use std::path::Path;
use std::sync::mpsc;
use std::thread;
use std::time::{Duration, Instant};

use common::{FORM, participant};
use cosplat_bus::{CoordinatorEvent, CoordinatorHandle, CoordinatorHost, Spin, serve};
use cosplat_core::control::Done;
use cosplat_core::coordinator::{Failure, Limits, Outcome};
use cosplat_core::ledger::WindowRecord;
use cosplat_core::participant::{Ending, Pace};
use cosplat_core::plan::{Content, Interface, InterfaceKind, Plan, Side, Stream};
use cosplat_core::plugin::{InterfaceView, SolverScene, ViewRole};
use cosplat_core::scene::{MotionRule, Scheme, Space};
use cosplat_core::time::Clock;
use point::{Point, Trouble};

const WINDOWS: u64 = 200;

fn side(id: u16, name: &str) -> Side {
    Side { participant: id, body: format!("{name}-body") }
}

/// `hard` resolves its contact with `soft`.
fn coupled() -> Plan {
    let body = "soft-body".to_owned();
    let stream = |key: &str, from: u16, to: u16, content| Stream { key: key.to_owned(), from, to: vec![to], content };
    Plan {
        clock: Clock::new(1.0, WINDOWS),
        window_bound_by: "test".to_owned(),
        participants: vec![participant("hard"), participant("soft")],
        interfaces: vec![Interface {
            name: "hard-body~soft-body".to_owned(),
            kind: InterfaceKind::Contact,
            scheme: Scheme::Serial,
            rule: MotionRule::Linear,
            a: side(0, "hard"),
            b: side(1, "soft"),
            at_once: false,
            from_a: None,
            from_b: 0,
            impulses: Some(2),
            links: Vec::new(),
        }],
        streams: vec![
            stream("b/soft/soft-body", 1, 0, Content::Boundary { body: body.clone(), form: FORM }),
            stream("s/soft/soft-body", 1, 0, Content::Statics { body }),
            stream("imp/hard/soft/0", 0, 1, Content::Impulses { interface: 0, form: FORM }),
        ],
        left_out: Vec::new(),
        recorder: None,
        break_with: None,
    }
}

fn scene(plan: &Plan, own: usize) -> SolverScene {
    let names: Vec<String> = plan.participants.iter().map(|p| p.name.clone()).collect();
    SolverScene {
        participant: names[own].clone(),
        threads: 1,
        clock: plan.clock,
        space: Space::Full,
        bodies: Vec::new(),
        statics: Vec::new(),
        links: Vec::new(),
        joints: Vec::new(),
        actions: Vec::new(),
        pairs: Vec::new(),
        probes: Vec::new(),
        interfaces: vec![InterfaceView {
            id: 0,
            role: [ViewRole::ContactResolver, ViewRole::ContactResponder][own],
            own: format!("{}-body", names[own]),
            partner: format!("{}-body", names[1 - own]),
            partner_form: FORM,
            partner_source: None,
            partner_pose: None,
            rule: MotionRule::Linear,
            pair: None,
            links: Vec::new(),
        }],
        params: serde_json::Map::default(),
        assets: std::collections::BTreeMap::new(),
    }
}

struct Result {
    outcome: Option<Outcome>,
    settled: Vec<(WindowRecord, Vec<Done>)>,
    notices: Vec<String>,
    endings: [Ending; 2],
    folder_is_gone: bool,
    seconds: f64,
}

/// Runs `hard` and `soft` with these troubles; `meddle` is called after every settled window.
fn run(troubles: [Trouble; 2], limits: Limits, meddle: impl Fn(u64, &CoordinatorHandle) + Send + 'static) -> Result {
    let start = Instant::now();
    let plan = coupled();
    let scenes = vec![scene(&plan, 0), scene(&plan, 1)];
    let (host, tickets) = CoordinatorHost::start(plan, scenes, limits, Spin::default()).unwrap();
    let socket = tickets[0].endpoint.strip_prefix("unixsock-stream/").unwrap().to_owned();
    assert!(Path::new(&socket).exists());
    let handle = host.handle();
    let (out, events) = mpsc::channel();
    let coordinator = thread::Builder::new().name("coordinator".to_owned()).spawn(move || {
        host.run(|event| {
            if let CoordinatorEvent::Settled(record, _) = &event {
                meddle(record.window, &handle);
            }
            out.send(event).unwrap();
        })
    });
    let speeds = [0.0, 8.0];
    let pace = Pace { orphaned: Duration::from_millis(1200), ..Pace::default() };
    let parts: Vec<_> = std::iter::zip(tickets, std::iter::zip(troubles, speeds))
        .map(|(ticket, (trouble, v))| thread::spawn(move || serve(&mut Point::new(v, trouble), &ticket, pace).unwrap()))
        .collect();
    let endings: Vec<Ending> = parts.into_iter().map(|p| p.join().unwrap()).collect();
    coordinator.unwrap().join().unwrap().unwrap();
    let (mut outcome, mut settled, mut notices) = (None, Vec::new(), Vec::new());
    for event in events {
        match event {
            CoordinatorEvent::Settled(record, done) => settled.push((*record, done)),
            CoordinatorEvent::Notice(text) => notices.push(text),
            CoordinatorEvent::Ended(how) => outcome = Some(how),
            CoordinatorEvent::Ready(..) | CoordinatorEvent::Started | CoordinatorEvent::Checkpoint(_) => {}
        }
    }
    Result {
        outcome,
        settled,
        notices,
        endings: endings.try_into().unwrap(),
        folder_is_gone: !Path::new(&socket).parent().unwrap().exists(),
        seconds: start.elapsed().as_secs_f64(),
    }
}

fn plain(troubles: [Trouble; 2]) -> Result {
    run(troubles, Limits::default(), |_, _| {})
}

#[test]
fn a_coupled_run_finishes_with_exact_transfer_and_splits_its_time() {
    let result = plain([Trouble::Nothing; 2]);
    assert_eq!(result.outcome, Some(Outcome::Finished));
    assert_eq!(result.endings, [Ending::Finished, Ending::Finished]);
    assert_eq!(result.settled.len() as u64, WINDOWS);
    assert!(result.folder_is_gone);
    assert_eq!(result.notices, Vec::<String>::new());
    for (i, (record, done)) in result.settled.iter().enumerate() {
        assert_eq!(record.window, i as u64);
        assert!(record.interfaces[0].transfer_defect == 0.0);
        assert!(record.solvers.iter().all(|s| s.closure < 1e-12), "{:?}", record.solvers);
        let [hard, soft] = [&done[0].times, &done[1].times];
        assert!(hard.end_s >= hard.start_s && soft.start_s >= hard.end_s, "one clock, and `soft` waits for `hard`");
        assert!(hard.wait_s >= 0.0 && hard.transfer_s >= 0.0);
    }
    // Both have the velocity of their common centre of mass in the end: something was exchanged.
    let (last, _) = result.settled.last().unwrap();
    assert!(last.solvers.iter().all(|s| (s.momentum[0] - 4.0).abs() < 1e-5));
    let again = plain([Trouble::Nothing; 2]);
    assert_eq!(again.settled.last().unwrap().0.state_hash, last.state_hash);
    assert!(result.seconds < 5.0, "{}", result.seconds);
}

#[test]
fn a_panic_in_a_plugin_ends_the_run_with_its_words_and_the_window() {
    let result = plain([Trouble::Nothing, Trouble::Panics(7)]);
    let Some(Outcome::Failed(Failure::Physics { who, window, message })) = &result.outcome else {
        panic!("{:?}", result.outcome)
    };
    assert_eq!((who.as_str(), *window), ("soft", 7));
    assert!(message.contains("lost in window 7"), "{message}");
    assert!(matches!(result.endings[1], Ending::Failed(_)));
    assert!(matches!(result.endings[0], Ending::Aborted(_)));
    assert!(result.folder_is_gone && result.seconds < 3.0, "{}", result.seconds);
}

#[test]
fn a_blow_up_is_told_to_the_partner_that_computes() {
    let result = plain([Trouble::Lingers(3), Trouble::BlowsUp(2)]);
    assert!(matches!(&result.outcome, Some(Outcome::Failed(Failure::Physics { who, .. })) if who == "soft"));
    assert!(matches!(result.endings[0], Ending::Aborted(_)));
    assert!(result.seconds < 3.0, "{}", result.seconds);
}

#[test]
fn a_long_silent_computation_is_not_taken_for_death() {
    let limits = Limits {
        silence: Duration::from_millis(1800),
        silence_notice: Duration::from_millis(1500),
        ..Limits::default()
    };
    let trouble = Trouble::Sleeps(5, Duration::from_millis(2600));
    let result = run([trouble, Trouble::Nothing], limits, |_, _| {});
    assert_eq!(result.outcome, Some(Outcome::Finished));
    assert!(!result.notices.iter().any(|n| n.contains("no sign of life")), "{:?}", result.notices);
}

#[test]
fn a_stop_ends_at_a_window_edge() {
    let result = run([Trouble::Nothing; 2], Limits::default(), |window, handle| {
        if window == 20 {
            handle.stop();
        }
    });
    let Some(Outcome::Stopped { windows }) = result.outcome else { panic!("{:?}", result.outcome) };
    assert!((21..WINDOWS).contains(&windows));
    assert_eq!(result.settled.len() as u64, windows);
}

#[test]
fn the_death_of_a_process_ends_the_run_by_name() {
    let plan = coupled();
    let scenes = vec![scene(&plan, 0), scene(&plan, 1)];
    let (host, _) = CoordinatorHost::start(plan, scenes, Limits::default(), Spin::default()).unwrap();
    host.handle().died(1, "signal 9 (SIGKILL)");
    let mut outcome = None;
    let start = Instant::now();
    host.run(|event| {
        if let CoordinatorEvent::Ended(how) = event {
            outcome = Some(how);
        }
    })
    .unwrap();
    let Some(Outcome::Failed(Failure::Died { who, how, .. })) = &outcome else { panic!("{outcome:?}") };
    assert_eq!((who.as_str(), how.as_str()), ("soft", "signal 9 (SIGKILL)"));
    assert!(start.elapsed() < Duration::from_secs(2));
}

#[test]
fn participants_do_not_outlive_a_coordinator_that_vanishes() {
    let result = run([Trouble::Nothing; 2], Limits::default(), |window, handle| {
        if window == 5 {
            handle.vanish();
        }
    });
    assert_eq!(result.outcome, None);
    assert_eq!(result.endings, [Ending::Orphaned, Ending::Orphaned]);
    assert!(result.folder_is_gone && result.seconds < 5.0, "{}", result.seconds);
}

#[test]
fn a_run_that_is_given_up_before_it_starts_leaves_nothing() {
    let plan = coupled();
    let scenes = vec![scene(&plan, 0), scene(&plan, 1)];
    let (host, tickets) = CoordinatorHost::start(plan, scenes, Limits::default(), Spin::NONE).unwrap();
    let socket = Path::new(tickets[0].endpoint.strip_prefix("unixsock-stream/").unwrap());
    assert!(socket.exists());
    drop(host);
    assert!(!socket.parent().unwrap().exists());
}
