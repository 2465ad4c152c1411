//! The oscillator passes what every plugin must pass, in each part it can play.

use cosplat_conformance::{Case, assert_conforms, parts};
use cosplat_core::boundary::{BoundaryState, Impulses, SampleStatics, Samples};
use cosplat_core::plugin::{Inputs, PartnerInput, PartnerSetup, Plugin, SolverScene, ViewRole};
use cosplat_core::scene::{ActionKind, MotionRule};
use cosplat_oscillator::Oscillator;

fn one_sample(interface: u16) -> PartnerSetup {
    PartnerSetup { interface, statics: SampleStatics { id: vec![0], ..SampleStatics::default() } }
}

fn sample(position: [f64; 3], velocity: [f64; 3]) -> BoundaryState {
    BoundaryState::Samples(Samples { position: vec![position], velocity: vec![velocity], normal: Vec::new() })
}

/// Three masses, chained and anchored, with gravity and a push that begins and ends inside windows.
fn masses() -> SolverScene {
    let bodies = vec![
        parts::point("one", 1.3, [0.1, 0.2, 0.3], [1.0, 0.0, -0.5]),
        parts::point("two", 0.7, [2.0, 0.0, 1.0], [0.0, 0.3, 0.0]),
        parts::point("three", 5.0, [2.0, 3.0, 1.0], [0.0; 3]),
    ];
    let mut scene = parts::solver_scene("oscillator", bodies, 4, 0.02);
    scene.links = vec![
        parts::spring("one", None, 30.0, [0.0; 3], [0.0; 3]),
        parts::spring("one", Some("two"), 70.0, [0.0; 3], [-1.5, 0.2, 0.0]),
    ];
    let push = ActionKind::PointForce { force_n: [1.0, 2.0, 3.0], at_m: None };
    scene.actions = vec![parts::gravity(), parts::action(push, 0.013, Some(0.047))];
    scene
}

/// Two equal sides of a link each, with every rule of motion, from one record or from two.
fn sides(rule: MotionRule, both_records: bool) -> Case {
    let mut scene = masses();
    let spring = |own: &str, partner: &str| vec![parts::spring(own, Some(partner), 50.0, [0.0; 3], [0.1, 0.0, 0.0])];
    scene.interfaces = vec![
        parts::view(0, ViewRole::LinkSide, "two", "far", spring("far", "two")),
        parts::view(1, ViewRole::LinkSide, "three", "near", spring("three", "near")),
    ];
    scene.interfaces.iter_mut().for_each(|v| v.rule = rule);
    let length_s = scene.clock.window_s();
    let partner = |interface: u16, w: f64| PartnerInput {
        interface,
        rule,
        now: sample([3.0, 0.1 * w, 1.0], [0.0, 5.0, 0.3]),
        next: both_records.then(|| sample([3.0, 0.1 * (w + 1.0), 1.1], [0.2, 4.0, 0.0])),
        length_s,
    };
    let windows = (0..4)
        .map(|w| Inputs { partners: vec![partner(0, f64::from(w)), partner(1, -f64::from(w))], impulses: Vec::new() });
    let name = format!("sides of links, {rule:?}, both records: {both_records}");
    Case::new(&name, scene).hearing(vec![one_sample(0), one_sample(1)], windows.collect())
}

/// A link resolver, a link responder with its kick, and two contact responders on one body.
fn impulses() -> Case {
    let mut scene = masses();
    let spring = |own: &str, partner: &str| vec![parts::spring(own, Some(partner), 50.0, [0.0; 3], [0.0; 3])];
    scene.interfaces = vec![
        parts::view(0, ViewRole::LinkResolver, "two", "far", spring("two", "far")),
        parts::view(1, ViewRole::LinkResponder, "three", "near", spring("three", "near")),
        parts::view(2, ViewRole::ContactResponder, "one", "mud", Vec::new()),
        parts::view(3, ViewRole::ContactResponder, "one", "sand", Vec::new()),
    ];
    let length_s = scene.clock.window_s();
    let windows = (0..4).map(|w| {
        let push = |i: u16| Impulses::Samples(vec![[0.1 * f64::from(i), -0.3, 0.07 * f64::from(w)]]);
        let mut impulses = vec![parts::spread(1, push(1)), parts::spread(2, push(2)), parts::spread(3, push(3))];
        impulses[0].spread = false;
        Inputs {
            partners: vec![parts::partner(0, [3.0, 0.1 * f64::from(w), 1.0], [0.0, 5.0, 0.0], length_s)],
            impulses,
        }
    });
    Case::new("impulses", scene).hearing(vec![one_sample(0)], windows.collect())
}

#[test]
fn the_contract_is_kept() {
    let mut cases = vec![Case::new("alone", masses()), impulses()];
    for rule in [MotionRule::Hold, MotionRule::Linear, MotionRule::Hermite] {
        cases.extend([sides(rule, false), sides(rule, true)]);
    }
    assert_conforms(&|| Box::new(Oscillator::default()) as Box<dyn Plugin>, &cases);
}
