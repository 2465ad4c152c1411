//! Steps of every scheme, spelled out for the first three windows.

use cosplat_core::plan::Plan;
use cosplat_core::plan::schedule::{MessageId, Need, Role, needed_at_start, published_at_start, steps};
use cosplat_core::scene::Scheme;

use crate::cast::{LIQUID, RIGID, body, elastic, joined, planned, scene};

/// A message by the key of its stream and its index.
fn message(plan: &Plan, id: MessageId) -> String {
    format!("{} {}", plan.streams[usize::from(id.stream)].key, id.index)
}

fn need(plan: &Plan, need: &Need) -> String {
    let role = match need.role {
        Role::PartnerNow => "now",
        Role::PartnerNext => "next",
        Role::ImpulseSpread => "spread",
        Role::ImpulseAtStart => "at once",
        Role::Visual => "drawn",
    };
    format!("{} {role}", message(plan, need.message))
}

/// Steps of a participant in a window: ticks, needs, gives.
fn told(plan: &Plan, who: &str, window: u64) -> Vec<String> {
    let who = plan.participant(who).expect("a participant of that name");
    let of = |step: &cosplat_core::plan::schedule::StepPlan| {
        let needs: Vec<String> = step.needs.iter().map(|n| need(plan, n)).collect();
        let gives: Vec<String> = step.gives.iter().map(|&id| message(plan, id)).collect();
        format!("{}..{}: {} -> {}", step.span.from, step.span.to, needs.join(", "), gives.join(", "))
    };
    steps(plan, who, window).iter().map(of).collect()
}

/// Checks the steps of the first three windows.
fn check(plan: &Plan, who: &str, wanted: [&[&str]; 3]) {
    for (window, wanted) in wanted.into_iter().enumerate() {
        assert_eq!(told(plan, who, window as u64), wanted, "`{who}` in window {window}");
    }
}

fn contact(scheme: Scheme) -> Plan {
    let mut scene = scene([body("mud", "sph", LIQUID), body("toy", "mpm", elastic(1e4))]);
    scene.clock.contact_scheme = scheme;
    planned(&scene)
}

fn linked(scheme: Scheme) -> Plan {
    let mut scene = joined(&["a", "b"]);
    scene.clock.link_scheme = scheme;
    planned(&scene)
}

#[test]
fn serial_contact_lets_the_responder_take_fresh_impulses() {
    let plan = contact(Scheme::Serial);
    check(
        &plan,
        "sph",
        [
            &["0..2: b/mpm/toy 0 now -> imp/sph/mpm/0 0"],
            &["2..4: b/mpm/toy 1 now -> imp/sph/mpm/0 1"],
            &["4..6: b/mpm/toy 2 now -> imp/sph/mpm/0 2"],
        ],
    );
    check(
        &plan,
        "mpm",
        [
            &["0..2: imp/sph/mpm/0 0 spread -> b/mpm/toy 1"],
            &["2..4: imp/sph/mpm/0 1 spread -> b/mpm/toy 2"],
            &["4..6: imp/sph/mpm/0 2 spread -> b/mpm/toy 3"],
        ],
    );
}

#[test]
fn parallel_contact_lets_impulses_act_one_window_later() {
    let plan = contact(Scheme::Parallel);
    check(
        &plan,
        "sph",
        [
            &["0..2: b/mpm/toy 0 now -> imp/sph/mpm/0 0"],
            &["2..4: b/mpm/toy 1 now -> imp/sph/mpm/0 1"],
            &["4..6: b/mpm/toy 2 now -> imp/sph/mpm/0 2"],
        ],
    );
    check(
        &plan,
        "mpm",
        [
            &["0..2:  -> b/mpm/toy 1"],
            &["2..4: imp/sph/mpm/0 0 spread -> b/mpm/toy 2"],
            &["4..6: imp/sph/mpm/0 1 spread -> b/mpm/toy 3"],
        ],
    );
}

#[test]
fn serial_links_let_the_second_side_know_the_end_of_the_first() {
    let plan = linked(Scheme::Serial);
    check(
        &plan,
        "a",
        [&["0..2: b/b/b 0 now -> b/a/a 1"], &["2..4: b/b/b 1 now -> b/a/a 2"], &["4..6: b/b/b 2 now -> b/a/a 3"]],
    );
    check(
        &plan,
        "b",
        [
            &["0..2: b/a/a 0 now, b/a/a 1 next -> b/b/b 1"],
            &["2..4: b/a/a 1 now, b/a/a 2 next -> b/b/b 2"],
            &["4..6: b/a/a 2 now, b/a/a 3 next -> b/b/b 3"],
        ],
    );
}

#[test]
fn alternating_links_swap_the_order_every_window() {
    let plan = linked(Scheme::Alternating);
    check(
        &plan,
        "a",
        [
            &["0..2: b/b/b 0 now -> b/a/a 1"],
            &["2..4: b/b/b 1 now, b/b/b 2 next -> b/a/a 2"],
            &["4..6: b/b/b 2 now -> b/a/a 3"],
        ],
    );
    check(
        &plan,
        "b",
        [
            &["0..2: b/a/a 0 now, b/a/a 1 next -> b/b/b 1"],
            &["2..4: b/a/a 1 now -> b/b/b 2"],
            &["4..6: b/a/a 2 now, b/a/a 3 next -> b/b/b 3"],
        ],
    );
}

#[test]
fn parallel_links_know_the_partner_at_the_start_only() {
    let plan = linked(Scheme::Parallel);
    for (who, other) in [("a", "b"), ("b", "a")] {
        for window in 0..3 {
            let wanted = format!(
                "{}..{}: b/{other}/{other} {window} now -> b/{who}/{who} {}",
                2 * window,
                2 * window + 2,
                window + 1
            );
            assert_eq!(told(&plan, who, window), [wanted]);
        }
    }
}

#[test]
fn centred_links_take_one_side_in_two_halves() {
    let plan = linked(Scheme::Centred);
    check(
        &plan,
        "a",
        [
            &["0..2: m/b/b 0 now -> imp/a/b/0 0"],
            &["2..4: m/b/b 1 now -> imp/a/b/0 1"],
            &["4..6: m/b/b 2 now -> imp/a/b/0 2"],
        ],
    );
    check(
        &plan,
        "b",
        [
            &["0..1:  -> m/b/b 0", "1..2: imp/a/b/0 0 at once -> "],
            &["2..3:  -> m/b/b 1", "3..4: imp/a/b/0 1 at once -> "],
            &["4..5:  -> m/b/b 2", "5..6: imp/a/b/0 2 at once -> "],
        ],
    );
}

#[test]
fn a_solver_between_two_others_waits_for_one_and_gives_to_the_other() {
    let plan =
        planned(&scene([body("mud", "sph", LIQUID), body("toy", "mpm", elastic(1e4)), body("rock", "rigid", RIGID)]));
    check(
        &plan,
        "mpm",
        [
            &["0..2: imp/sph/mpm/0 0 spread, b/rigid/rock 0 now -> b/mpm/toy 1, imp/mpm/rigid/2 0"],
            &["2..4: imp/sph/mpm/0 1 spread, b/rigid/rock 1 now -> b/mpm/toy 2, imp/mpm/rigid/2 1"],
            &["4..6: imp/sph/mpm/0 2 spread, b/rigid/rock 2 now -> b/mpm/toy 3, imp/mpm/rigid/2 2"],
        ],
    );
}

#[test]
fn boundaries_at_the_start_and_statics_are_published_before_the_first_window() {
    let told = |plan: &Plan, who: &str| {
        let id = plan.participant(who).expect("a participant of that name");
        let list = |ids: Vec<MessageId>| ids.into_iter().map(|id| message(plan, id)).collect::<Vec<String>>();
        (list(published_at_start(plan, id)), list(needed_at_start(plan, id)))
    };
    let words = |all: &[&str]| all.iter().map(|&w| w.to_owned()).collect::<Vec<String>>();
    let plan = contact(Scheme::Serial);
    assert_eq!(told(&plan, "mpm"), (words(&["b/mpm/toy 0", "s/mpm/toy 0"]), vec![]));
    assert_eq!(told(&plan, "sph"), (vec![], words(&["s/mpm/toy 0"])));
    // Links know no statics, a centred one shows nothing before the middle of the first window.
    assert_eq!(told(&linked(Scheme::Alternating), "a"), (words(&["b/a/a 0"]), vec![]));
    assert_eq!(told(&linked(Scheme::Centred), "b"), (vec![], vec![]));
}
