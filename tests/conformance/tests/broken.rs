//! The kit must let an honest plugin pass and catch each way of cheating by the right rule.

#[cfg(test)]
mod beads;

use beads::{Beads, Fault};
use cosplat_conformance::{Case, Rule, Violation, check, parts};
use cosplat_core::boundary::Impulses;
use cosplat_core::plugin::{Inputs, PartnerSetup, Plugin, ViewRole};

/// Two beads that fall; the first takes impulses from three partners, the second pulls on a fourth.
fn case() -> Case {
    let bodies = vec![
        parts::point("one", 1.3, [0.1, 0.2, 0.3], [1.0, 0.0, -0.5]),
        parts::point("two", 0.7, [2.0, 0.0, 1.0], [0.0, 0.3, 0.0]),
    ];
    let mut scene = parts::solver_scene("beads", bodies, 3, 0.01);
    scene.actions.push(parts::gravity());
    let links = vec![parts::spring("two", Some("far"), 50.0, [0.0; 3], [0.0; 3])];
    scene.interfaces = (0..3).map(|i| parts::view(i, ViewRole::ContactResponder, "one", "mud", Vec::new())).collect();
    scene.interfaces.push(parts::view(3, ViewRole::LinkResolver, "two", "far", links));
    let window_s = scene.clock.window_s();
    let windows = (0..3).map(|w| Inputs {
        partners: vec![parts::partner(3, [3.0, 0.1 * f64::from(w), 1.0], [0.0, 10.0, 0.0], window_s)],
        impulses: (0..3u16)
            .map(|i| {
                let j = f64::from(i + 1) * 0.1;
                parts::spread(i, Impulses::Samples(vec![[j, -j / 3.0, j * j]]))
            })
            .collect(),
    });
    let statics = cosplat_core::boundary::SampleStatics { id: vec![0], ..Default::default() };
    Case::new("beads", scene).hearing(vec![PartnerSetup { interface: 3, statics }], windows.collect())
}

fn violations(fault: Fault) -> Vec<Violation> {
    check(&|| Box::new(Beads::new(fault)) as Box<dyn Plugin>, &[case()])
}

#[test]
fn an_honest_plugin_passes() {
    assert_eq!(violations(Fault::Honest), []);
}

#[test]
fn every_way_of_cheating_is_caught_by_its_rule() {
    let caught = [
        (Fault::ShoutsItsName, Rule::DescriptorSane),
        (Fault::ChangesItsMind, Rule::DescribeAlways),
        (Fault::HatesEmptyScenes, Rule::EmptyScene),
        (Fault::HidesABody, Rule::ShapeOfAnswers),
        (Fault::LosesItsEnergy, Rule::FiniteAnswers),
        (Fault::BoundByNothing, Rule::BindingTerm),
        (Fault::RemembersTheLastRun, Rule::SetupRepeats),
        (Fault::KeepsSecrets, Rule::StateComplete),
        (Fault::KeepsSecrets, Rule::StepRepeats),
        (Fault::RestoresRoughly, Rule::RestoreIsIdentity),
        (Fault::TakesHalfAState, Rule::DamagedStateRefused),
        (Fault::RestoresBeforeItChecks, Rule::DamagedStateRefused),
        (Fault::SavesTheBeginning, Rule::StateMoves),
        (Fault::CountsThreads, Rule::ThreadsDoNotMatter),
        (Fault::AddsAsItHears, Rule::OrderDoesNotMatter),
        (Fault::LetsNanThrough, Rule::NonFiniteInput),
        (Fault::ThrowsNanAway, Rule::NonFiniteInput),
        (Fault::NeverStops, Rule::AbortHonoured),
        (Fault::BeatsBackwards, Rule::BeatsCount),
        (Fault::DropsImpulses, Rule::MomentumCloses),
        (Fault::ReportsOtherImpulses, Rule::ReceivedIsGiven),
        (Fault::GivesTooMuch, Rule::MomentumCloses),
        (Fault::ForgetsGravity, Rule::MomentumCloses),
        (Fault::ForgetsLeverArms, Rule::MomentumCloses),
        (Fault::AcceptsJoints, Rule::UnsupportedNamed),
        (Fault::RefusesWithoutNames, Rule::UnsupportedNamed),
    ];
    for (fault, rule) in caught {
        let found = violations(fault);
        assert!(found.iter().any(|v| v.rule == rule), "{fault:?} is not caught by {rule:?}, but by {found:#?}");
    }
}

#[test]
fn a_scene_that_cannot_be_played_is_said_to_be_so() {
    let mut case = case();
    case.scene.links.push(parts::spring("one", None, 1.0, [0.0; 3], [0.0; 3]));
    let found = check(&|| Box::new(Beads::new(Fault::Honest)) as Box<dyn Plugin>, &[case]);
    assert_eq!(found.len(), 1);
    assert_eq!(found[0].rule, Rule::ScenePlays);
    assert!(found[0].to_string().contains("one-world"), "{}", found[0]);
}
