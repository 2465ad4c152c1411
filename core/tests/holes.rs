//! Holes that were found once and must stay closed.

mod honest;

use std::time::Duration;

use cosplat_core::checks::AllChecks;
use cosplat_core::control::{self, PROTOCOL, Up};
use cosplat_core::coordinator::{Action, Event, Limits, Outcome};
use cosplat_core::participant::{Frame, Inbox, Reject, Taken};
use cosplat_core::plan::schedule::MessageId;
use cosplat_core::sim::Scenario;
use cosplat_core::wire::{self, HEADER_BYTES, Header, Origin};

use honest::{EPOCH, RUN, fresh, honest_report, join, said};

/// A coordinator whose participants have all joined.
fn running(scenario: &Scenario) -> cosplat_core::coordinator::Coordinator {
    let mut coordinator = fresh(scenario, EPOCH, Limits::default());
    join(&mut coordinator, scenario, EPOCH, 0, None);
    coordinator
}

#[test]
fn a_report_may_list_streams_that_do_not_exist() {
    let scenario = Scenario::from_seed(0);
    let mut coordinator = running(&scenario);
    let mut settled = 0;
    for (who, _) in (0..).zip(&scenario.plan.participants) {
        let mut done = honest_report(&scenario.plan, who, 0);
        done.produced.push((60_000, u64::MAX, 7));
        done.applied.push((60_000, [0.0; 3], 0.0));
        let actions = coordinator.on(Event::Up(who, said(EPOCH, Up::Done(Box::new(done)))), Duration::ZERO);
        settled += actions.iter().filter(|a| matches!(a, Action::Settled(..))).count();
    }
    assert_eq!(settled, 1, "what the plan does not ask for is ignored");
}

#[test]
fn a_participant_that_publishes_less_than_the_plan_says_is_named() {
    let scenario = Scenario::from_seed(0);
    let mut coordinator = running(&scenario);
    let mut outcome = None;
    for (who, _) in (0..).zip(&scenario.plan.participants) {
        let mut done = honest_report(&scenario.plan, who, 0);
        if who == 1 {
            done.produced.clear();
        }
        for action in coordinator.on(Event::Up(who, said(EPOCH, Up::Done(Box::new(done)))), Duration::ZERO) {
            if let Action::Ended(end) = action {
                outcome = Some(end);
            }
        }
    }
    let Some(Outcome::Failed(failure)) = outcome else { panic!("it went on: {outcome:?}") };
    assert!(failure.to_string().contains("`p1`") && failure.to_string().contains("did not publish"), "{failure}");
}

#[test]
fn a_frame_that_contradicts_itself_does_not_hold_the_place_of_the_right_one() {
    let plan = Scenario::from_seed(0).plan;
    let (stream, declared) = plan.streams.iter().enumerate().next().expect("seed 0 couples");
    let reader = declared.to[0];
    let id = MessageId { stream: stream as u16, index: 0 };
    let origin = Origin {
        run: RUN,
        epoch: EPOCH,
        sender: declared.from,
        stream: id.stream,
        schema: wire::schema_hash(&declared.content),
        index: id.index,
    };
    let (frames, _) = wire::frames(&origin, 1, wire::cut(&[0; 48]), &mut 0);
    let mut inbox = Inbox::new(RUN, EPOCH, &plan, reader);
    let mut short = frames[0].as_ref().clone();
    short.truncate(HEADER_BYTES + 32);
    let header = Header::read(&short).expect("a header");
    let resealed = header.sealed(xxhash_rust::xxh3::xxh3_64(&short[HEADER_BYTES..]));
    short[..HEADER_BYTES].copy_from_slice(bytemuck::bytes_of(&resealed));
    assert_eq!(inbox.take(Frame::new(short), &AllChecks), None);
    assert_eq!(inbox.rejected().get(&Reject::Shape), Some(&1));
    assert_eq!(inbox.take(frames[0].clone(), &AllChecks), Some(Taken::Whole(id)));
}

#[test]
fn who_greets_after_the_end_is_told_so() {
    let scenario = Scenario::from_seed(0);
    let mut coordinator = running(&scenario);
    coordinator.on(
        Event::Up(0, said(EPOCH, Up::Failed { kind: control::FailureKind::Physics, message: "x".into() })),
        Duration::ZERO,
    );
    let hello = Up::Hello { name: "p0".into(), pid: 1, protocol: [PROTOCOL; 2], descriptor: String::new() };
    let actions = coordinator.on(Event::Up(0, said(EPOCH, hello)), Duration::ZERO);
    let told = actions.iter().any(|a| {
        matches!(a, Action::Send(0, bytes) if control::decode::<control::Down>(bytes)
            .is_ok_and(|e| matches!(e.body, control::Down::Refused { .. })))
    });
    assert!(told, "{actions:?}");
}

/// A participant repeats its failure until it is answered: without an abort it would linger for seconds.
#[test]
fn who_reports_its_failure_is_answered() {
    let scenario = Scenario::from_seed(0);
    let mut coordinator = running(&scenario);
    let failed = Up::Failed { kind: control::FailureKind::Physics, message: "it blew up".into() };
    let actions = coordinator.on(Event::Up(1, said(EPOCH, failed)), Duration::ZERO);
    let answered = actions.iter().any(|a| {
        matches!(a, Action::Send(1, bytes) if control::decode::<control::Down>(bytes)
            .is_ok_and(|e| matches!(e.body, control::Down::Abort { .. })))
    });
    assert!(answered, "{actions:?}");
}
