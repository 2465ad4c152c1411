//! Cores are divided within a level; a level with one member gets all of them.

use cosplat_core::plan::build;
use cosplat_core::scene::{Scene, Scheme};

use crate::cast::{LIQUID, RIGID, body, four_kinds, joined, pair, plugins, run_with, scene};

/// Threads of each participant in name order.
fn threads(scene: &Scene, cores: usize) -> Vec<usize> {
    let (plan, parts) = build(scene, &plugins(), cores).expect("a plan");
    let told: Vec<usize> = parts.iter().map(|p| p.threads).collect();
    let planned: Vec<usize> = plan.participants.iter().map(|p| p.threads).collect();
    assert_eq!(told, planned);
    planned
}

#[test]
fn solvers_that_run_one_after_the_other_get_all_cores() {
    assert_eq!(threads(&four_kinds(), 8), [8, 8, 8, 8]);
    let mut chain = joined(&["a", "b", "c"]);
    for scheme in [Scheme::Serial, Scheme::Alternating] {
        chain.clock.link_scheme = scheme;
        assert_eq!(threads(&chain, 8), [8, 8, 8], "{scheme:?}");
    }
}

#[test]
fn solvers_that_run_at_once_share_the_cores() {
    let mut scene = four_kinds();
    scene.clock.contact_scheme = Scheme::Parallel;
    assert_eq!(threads(&scene, 8), [2, 2, 2, 2]);
    let mut chain = joined(&["a", "b", "c"]);
    chain.clock.link_scheme = Scheme::Parallel;
    assert_eq!(threads(&chain, 8), [2, 2, 2]);
}

#[test]
fn two_resolvers_of_one_rock_share_and_the_rock_gets_all() {
    let mut scene = scene([body("mud", "sph", LIQUID), body("clay", "wet", LIQUID), body("rock", "rigid", RIGID)]);
    run_with(&mut scene, "sph", &["wet"]);
    let mut apart = pair("mud", "clay");
    apart.enabled = false;
    scene.pairs = vec![apart];
    // In name order: rigid, sph, wet.
    assert_eq!(threads(&scene, 8), [8, 4, 4]);
}

#[test]
fn a_halved_solver_and_its_partner_take_turns() {
    let mut scene = joined(&["a", "b"]);
    scene.clock.link_scheme = Scheme::Centred;
    assert_eq!(threads(&scene, 8), [8, 8]);
}

#[test]
fn solvers_without_interface_run_at_once() {
    let mut scene = joined(&["a", "b"]);
    scene.links.clear();
    assert_eq!(threads(&scene, 8), [4, 4]);
}

#[test]
fn nobody_gets_less_than_one_and_the_scene_may_say_how_many() {
    let mut scene = four_kinds();
    scene.clock.contact_scheme = Scheme::Parallel;
    assert_eq!(threads(&scene, 2), [1, 1, 1, 1]);
    scene.run.threads = Some(12);
    assert_eq!(threads(&scene, 2), [3, 3, 3, 3]);
}
