//! Does every schedule run? Whoever can goes on; nobody ever waits for what nobody gives.

use std::collections::{BTreeMap, BTreeSet};

use cosplat_core::plan::schedule::{MessageId, needed_at_start, published_at_start, published_before, steps};
use cosplat_core::plan::{ParticipantId, Plan};
use cosplat_core::plugin::SolverScene;
use cosplat_core::scene::{Scene, Scheme};
use proptest::prelude::*;

use crate::cast::{
    LIQUID, RIGID, attempt, body, elastic, four_kinds, joined, link, pair, planned, refused, run_with, scene,
};

const WINDOWS: u64 = 50;
const CONTACT_SCHEMES: [Scheme; 2] = [Scheme::Serial, Scheme::Parallel];
const LINK_SCHEMES: [Scheme; 4] = [Scheme::Serial, Scheme::Alternating, Scheme::Parallel, Scheme::Centred];

fn everybody(plan: &Plan) -> impl Iterator<Item = ParticipantId> + use<> {
    0..plan.participants.len() as ParticipantId
}

/// Every message of the run with the window in which it is given; those of the start count as window 0.
fn given(plan: &Plan) -> BTreeMap<MessageId, u64> {
    let mut given = BTreeMap::new();
    for who in everybody(plan) {
        let at_start = published_at_start(plan, who).into_iter().map(|id| (id, 0));
        let later = (0..WINDOWS).flat_map(|w| {
            steps(plan, who, w).into_iter().flat_map(move |s| s.gives.into_iter().map(move |id| (id, w)))
        });
        for (id, window) in at_start.chain(later) {
            assert_eq!(plan.streams[usize::from(id.stream)].from, who, "somebody else's stream");
            assert!(given.insert(id, window).is_none(), "{id:?} is given twice");
        }
    }
    given
}

/// Every need is on a stream that its reader has, and is given once, in the same window or before.
fn check_needs(plan: &Plan) {
    let given = given(plan);
    for who in everybody(plan) {
        for window in 0..WINDOWS {
            let steps = steps(plan, who, window);
            let spans: Vec<(u64, u64)> = steps.iter().map(|s| (s.span.from, s.span.to)).collect();
            assert_eq!((spans[0].0, spans[spans.len() - 1].1), (2 * window, 2 * window + 2));
            assert!(spans.windows(2).all(|two| two[0].1 == two[1].0), "a gap between steps");
            for need in steps.iter().flat_map(|s| &s.needs) {
                let stream = &plan.streams[usize::from(need.message.stream)];
                assert!(stream.to.contains(&who), "`{}` is not read by {who}", stream.key);
                assert!(
                    given.get(&need.message).is_some_and(|w| *w <= window),
                    "{:?} of `{}`",
                    need.message,
                    stream.key
                );
                // Senders keep, and readers take, what lies one window behind and one ahead.
                let index = need.message.index;
                assert!(index + 1 >= window && index <= window + 1, "{:?} in window {window}", need.message);
            }
        }
        for id in needed_at_start(plan, who) {
            assert_eq!(given.get(&id), Some(&0));
        }
    }
}

/// Whoever takes up the run at the start of any window finds all it needs: published before, or given from there on.
fn check_resume(plan: &Plan) {
    for window in 0..10 {
        let later = |who| (window..window + 4).flat_map(move |w| steps(plan, who, w));
        let mut there: BTreeSet<MessageId> = everybody(plan).flat_map(|who| later(who).flat_map(|s| s.gives)).collect();
        for id in everybody(plan).flat_map(|who| published_before(plan, who, window)) {
            assert!(there.insert(id), "{id:?} is given in window {window} or later");
        }
        for need in everybody(plan).flat_map(|who| later(who).flat_map(|s| s.needs)) {
            assert!(there.contains(&need.message), "{:?} is lost when the run is resumed at {window}", need.message);
        }
    }
}

/// Runs the schedule in the order that `prefer` gives to those who can; panics where nobody can.
fn check_run(plan: &Plan, mut prefer: impl FnMut(usize) -> usize) {
    let mut there: BTreeSet<MessageId> = everybody(plan).flat_map(|who| published_at_start(plan, who)).collect();
    let mut places: Vec<(u64, usize)> = vec![(0, 0); plan.participants.len()];
    while places.iter().any(|(window, _)| *window < WINDOWS) {
        let able: Vec<ParticipantId> = everybody(plan)
            .filter(|&who| {
                let (window, step) = places[usize::from(who)];
                window < WINDOWS && steps(plan, who, window)[step].needs.iter().all(|n| there.contains(&n.message))
            })
            .collect();
        assert!(!able.is_empty(), "everybody waits at {places:?}");
        let who = able[prefer(able.len())];
        let (window, step) = &mut places[usize::from(who)];
        let own = steps(plan, who, *window);
        for &id in &own[*step].gives {
            assert!(there.insert(id), "{id:?} was there before it was given");
        }
        *step += 1;
        if *step == own.len() {
            (*window, *step) = (*window + 1, 0);
        }
    }
}

fn check(plan: &Plan) {
    check_needs(plan);
    check_resume(plan);
    check_run(plan, |_| 0);
    check_run(plan, |able| able - 1);
}

fn with_links(mut scene: Scene, scheme: Scheme) -> Scene {
    scene.clock.link_scheme = scheme;
    scene
}

/// Contacts of three kinds, and a ball that hangs on one of them.
fn mixed(contact: Scheme, links: Scheme) -> Scene {
    let mut scene = scene([
        body("mud", "sph", LIQUID),
        body("toy", "all", elastic(1e4)),
        body("rock", "rigid", RIGID),
        body("ball", "spring", RIGID),
    ]);
    scene.links = vec![link("rope", "toy", "ball")];
    scene.pairs = vec![pair("toy", "ball"), pair("mud", "ball")];
    scene.pairs.iter_mut().for_each(|p| p.enabled = false);
    scene.clock.contact_scheme = contact;
    with_links(scene, links)
}

#[test]
fn contacts_of_four_kinds_run_in_every_scheme() {
    for scheme in CONTACT_SCHEMES {
        let mut scene = four_kinds();
        scene.clock.contact_scheme = scheme;
        check(&planned(&scene));
    }
}

#[test]
fn two_and_three_solvers_joined_in_a_row_run_in_every_scheme() {
    for scheme in LINK_SCHEMES {
        check(&planned(&with_links(joined(&["a", "b"]), scheme)));
    }
    for scheme in [Scheme::Serial, Scheme::Alternating, Scheme::Parallel] {
        check(&planned(&with_links(joined(&["a", "b", "c"]), scheme)));
    }
    // Centred: the middle one computes the impulses of both links.
    let mut scene = with_links(joined(&["a", "b", "c"]), Scheme::Centred);
    scene.links[0].first = Some("b".to_owned());
    check(&planned(&scene));
    // Centred: the middle one takes the impulses of both links.
    scene.links[0].first = Some("a".to_owned());
    scene.links[1].first = Some("c".to_owned());
    check(&planned(&scene));
}

#[test]
fn contacts_and_links_run_together_in_every_scheme() {
    for contact in CONTACT_SCHEMES {
        for links in LINK_SCHEMES {
            let plan = planned(&mixed(contact, links));
            assert_eq!(plan.interfaces.len(), 4, "{:?}", plan.interfaces);
            check(&plan);
        }
    }
}

#[test]
fn solvers_that_wait_for_each_other_in_a_circle_are_refused_by_name() {
    let mut scene = four_kinds();
    scene.pairs = vec![pair("mud", "toy"), pair("cloud", "mud"), pair("cloud", "toy")];
    check(&planned(&scene));
    // Smoke before liquid before solid before smoke; the rock only follows.
    scene.pairs[2].resolver = Some("mpm".to_owned());
    let text = refused(&scene);
    assert!(text.starts_with("solvers `mpm`, `smoke`, `sph`: "), "{text}");
    assert_eq!(text.lines().count(), 1, "{text}");
    scene.clock.contact_scheme = Scheme::Parallel;
    check(&planned(&scene));
}

#[test]
fn a_circle_of_alternating_links_is_refused_in_whichever_window_it_closes() {
    let mut scene = with_links(joined(&["a", "b", "c"]), Scheme::Alternating);
    scene.links.push(link("c-a", "c", "a"));
    assert!(refused(&scene).starts_with("solvers `a`, `b`, `c`: "));
    scene.links[2] = link("a-c", "a", "c");
    check(&planned(&scene));
}

#[test]
fn an_alternating_link_beside_a_serial_contact_of_the_same_solvers_is_refused() {
    let mut scene = joined(&["a", "b"]);
    run_with(&mut scene, "all", &["a", "b"]);
    let text = refused(&scene);
    assert!(text.starts_with("solvers `a`, `b`: ") && text.contains("serial"), "{text}");
    check(&planned(&with_links(scene, Scheme::Serial)));
}

#[test]
fn a_centred_link_goes_with_no_other_interface_of_its_halved_side() {
    let halved_twice = with_links(joined(&["a", "b", "c"]), Scheme::Centred);
    let text = refused(&halved_twice);
    assert!(text.contains("interface `b~c`") && text.contains("two half windows"), "{text}");
    let mut scene = mixed(Scheme::Serial, Scheme::Centred);
    scene.links[0].first = Some("ball".to_owned());
    let text = refused(&scene);
    for contact in ["interface `mud~toy`", "interface `toy~rock`"] {
        assert!(text.contains(contact), "{text}");
    }
}

#[test]
fn a_scene_from_text_runs() {
    let text = include_str!("oscillator.toml");
    let (scene, warnings) = cosplat_core::scene::read::parse(text).expect("the text is a scene");
    assert!(warnings.is_empty());
    let plan = planned(&scene);
    assert_eq!((plan.clock.windows, plan.interfaces.len(), plan.streams.len()), (100, 1, 2));
    check(&plan);
}

/// Any links among five solvers, any order of their sides, any scheme.
fn any_links() -> impl Strategy<Value = Scene> {
    let ends = (0_usize..5, 0_usize..5, any::<bool>());
    (prop::collection::vec(ends, 1..8), prop::sample::select(LINK_SCHEMES.to_vec())).prop_map(|(ends, scheme)| {
        let names = ["a", "b", "c", "d", "e"];
        let mut scene = with_links(joined(&names), scheme);
        scene.links.clear();
        for (i, (a, b, turned)) in ends.into_iter().filter(|(a, b, _)| a != b).enumerate() {
            let mut link = link(&format!("l{i}"), names[a], names[b]);
            link.first = turned.then(|| names[b].to_owned());
            scene.links.push(link);
        }
        scene
    })
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(256) })]

    #[test]
    fn whatever_is_planned_runs(scene in any_links(), order in any::<u64>()) {
        if let Ok((plan, _)) = attempt(&scene) {
            check_needs(&plan);
            let mut state = order;
            check_run(&plan, |able| {
                state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
                (state >> 33) as usize % able
            });
        }
    }

    #[test]
    fn a_plan_and_its_parts_survive_json_bitwise(
        scene in any_links(),
        duration_s in 1e-4..1e6_f64,
        part in 1e-4..1.0_f64,
        velocity in any::<[f64; 3]>(),
    ) {
        let mut scene = scene;
        scene.clock.duration_s = duration_s;
        scene.clock.window_s = Some((duration_s * part).max(2e-5));
        let numbers = velocity.map(|v| if v.is_finite() { v } else { -0.0 });
        scene.bodies[0].velocity =
            cosplat_core::scene::VelocityField::Twist { linear_m_s: numbers, angular_rad_s: numbers };
        if let Ok((plan, parts)) = attempt(&scene) {
            let text = serde_json::to_string(&plan).expect("a plan is plain data");
            let found: Plan = serde_json::from_str(&text).expect("a plan");
            prop_assert_eq!(found.clock.tick_s.to_bits(), plan.clock.tick_s.to_bits());
            prop_assert_eq!(&found, &plan);
            prop_assert_eq!(serde_json::to_string(&found).expect("a plan is plain data"), text);
            for part in parts {
                let text = serde_json::to_string(&part).expect("a part is plain data");
                let found: SolverScene = serde_json::from_str(&text).expect("a part");
                prop_assert_eq!(&found, &part);
                // As text, in which -0 is not 0.
                prop_assert_eq!(serde_json::to_string(&found).expect("a part is plain data"), text);
            }
        }
    }
}
