//! What each decision to leave something out changes, and what it saves: the scene is run again with the decision the
//! other way round.

mod kept;
mod material;
mod output;
mod worth;

use std::collections::BTreeSet;

use cosplat_core::scene::{Scene, Scheme};

use super::case::{Case, Level};
use crate::folder::summary::Summary;
pub(crate) use kept::{Kept, kept};
use material::of_material;
pub(crate) use worth::{Worth, worth};

/// A decision that can be taken the other way round.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Decision {
    /// Short name.
    pub(crate) name: String,
    /// What is done the other way round.
    pub(crate) instead: String,
    /// What the decision was taken by, in words; empty where it follows from what the scene asks for.
    pub(crate) indicator: String,
    /// Changes of the scene that do so.
    pub(crate) set: Vec<(String, String)>,
    /// Whether nothing may change, because the indicator of the decision says that it has no effect.
    pub(crate) must_not_matter: bool,
    /// Whether that is said of the probes: a solver that has a partner remembers it, so that its state is another one.
    pub(crate) by_probes: bool,
    /// The decision whose run this one is compared with, where that is not the run as it is.
    pub(crate) beside: Option<&'static str>,
}

/// All decisions that a scene and its run offer.
pub(crate) fn decisions(scene: &Scene, summary: &Summary) -> Vec<Decision> {
    let has = |what: &str| by(summary, what).is_some();
    let of = |what: &str| by(summary, what).unwrap_or_default();
    let empty = [("solver.idle-solver.plugin", "\"oscillator\"")];
    let mut found = vec![decision("idle-process", "an empty solver takes part", &empty, true)];
    found.extend(output::decisions(scene, summary));
    if scene.clock.contact_scheme == Scheme::Serial && summary.interfaces.iter().any(|i| i.kind == "contact") {
        let set = [("clock.contact_scheme", "\"parallel\"")];
        found.push(decision("serial", "nobody waits for a partner's contact: it is felt a window late", &set, false));
    }
    if has("deformation of body") {
        let rigidify = decision("rigidify", "every body deforms", &[("run.rigidify", "false")], false);
        found.push(Decision { indicator: of("deformation of body"), ..rigidify });
    }
    for body in &scene.bodies {
        found.extend(of_material(body, summary));
    }
    let names: BTreeSet<&str> = scene.bodies.iter().map(|body| body.solver.as_str()).collect();
    for name in names {
        let plugin = scene.solvers.get(name).and_then(|spec| spec.plugin.as_deref()).unwrap_or(name);
        if plugin == "pbd" && !has("self-collision") {
            let key = format!("solver.{name}.params.self_collision");
            let set = vec![(key, "false".to_owned())];
            found.push(Decision { set, ..decision("self-collision", "cloth passes through itself", &[], false) });
        }
        if plugin == "rigid" {
            found.push(ccd(name, summary));
        }
        if plugin.starts_with("mpm") {
            found.extend(material::averaging(scene, name));
        }
    }
    // Without its striker a body may be rigid enough: that is another decision, which must stay as it is.
    if scene.pairs.is_empty() && !has("deformation of body") {
        let idle = summary.interfaces.iter().filter(|i| i.kind == "contact" && i.gross_impulse == 0.0);
        found.extend(idle.map(|i| {
            let pair = format!("[{{ a = \"{}\", b = \"{}\", enabled = false }}]", i.a, i.b);
            // Nothing else bounds the window, and another one is another result. A hair more, so that as many fit.
            let window = format!("{:?}", summary.window_s * (1.0 + 1e-9));
            let instead = format!("`{}` and `{}`, which never met, do not exchange", i.a, i.b);
            Decision {
                indicator: "impulses of 0 N s".into(),
                set: vec![
                    ("pair".into(), pair),
                    ("run.rigidify".into(), "false".into()),
                    ("clock.window".into(), window),
                ],
                by_probes: true,
                ..decision(&format!("pair-{}-{}", i.a, i.b), &instead, &[], !scene.probes.is_empty())
            }
        }));
    }
    found
}

fn decision(name: &str, instead: &str, set: &[(&str, &str)], must_not_matter: bool) -> Decision {
    let set = set.iter().map(|(key, value)| ((*key).to_owned(), (*value).to_owned())).collect();
    let indicator = String::new();
    Decision {
        name: name.into(),
        instead: instead.into(),
        indicator,
        set,
        must_not_matter,
        by_probes: false,
        beside: None,
    }
}

/// Contact that is looked for ahead of a body: needed where one moves by more than half its size in a substep.
fn ccd(solver: &str, summary: &Summary) -> Decision {
    let travel = summary.counters.get(solver).and_then(|counters| counters.get("largest-travel-1e-6"));
    let indicator =
        travel.map(|part| format!("{:.3e} of a body's size in a substep against 5.000e-1", 1e-6 * *part as f64));
    let set = vec![(format!("solver.{solver}.params.ccd"), "false".to_owned())];
    // A body that never moves finds the same contacts.
    let never = travel == Some(&0);
    let plain =
        decision(&format!("ccd-{solver}"), "contact is looked for where a body is, not ahead of it", &[], never);
    Decision { indicator: indicator.unwrap_or_default(), set, ..plain }
}

/// What the first decision that begins like this was taken by: its indicator against its limit, or its reason.
fn by(summary: &Summary, what: &str) -> Option<String> {
    let found = summary.left_out.iter().find(|l| l.what.starts_with(what))?;
    Some(match (found.indicator, found.limit) {
        (Some(indicator), Some(limit)) => format!("{indicator:.3e} against {limit:.3e}"),
        _ => found.why.clone(),
    })
}

/// The case of a scene with changes.
pub(crate) fn case_of(scene: &str, [name, title]: [&str; 2], set: Vec<(String, Level)>) -> Case {
    Case::plain(name, title, scene, set)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::render::Paint;
    use crate::scene_source::{load, parse};

    fn names(scene: &str, left_out: &str) -> Vec<(String, bool)> {
        let (scene, _) = parse(&load(scene).unwrap(), &[], Paint::off()).unwrap();
        let text = format!(
            r#"{{"status":"ok","exit_code":0,"failure":null,"scene":"x","windows":3,"window_s":0.1,
            "window_bound_by":"x","simulated_s":0.3,"wall_s":1.0,"state_hash":null,"verdicts":[],"processes":[],
            "frames":null,"bodies":[],"interfaces":[],"energy":[],"counters":{{}},"files":{{}},"left_out":
            [{{"what":"{left_out}","why":"","indicator":null,"limit":null,"saved":""}}]}}"#
        );
        let summary: Summary = serde_json::from_str(&text).unwrap();
        decisions(&scene, &summary).into_iter().map(|d| (d.name, d.must_not_matter)).collect()
    }

    #[test]
    fn decisions_are_those_that_the_scene_offers() {
        let plain: Vec<String> = names("oscillator", "x").into_iter().map(|d| d.0).collect();
        assert_eq!(plain, ["idle-process", "trace"]);
        let block = names("ball-on-block", "x");
        assert!(block.contains(&("f-bar-mpm".into(), true)), "its material does not lock: {block:?}");
        let plant = names("plant-and-rock", "x");
        assert!(plant.contains(&("colours".into(), true)) && plant.contains(&("pictures".into(), true)), "{plant:?}");
        assert!(names("dam-and-raft", "x").iter().any(|(name, _)| name == "ccd-rigid"));
        let cloth = names("silk-over-rock", "x");
        assert!(cloth.iter().any(|(name, matters_not)| name.starts_with("compliance-") && !matters_not), "{cloth:?}");
        let water = names("dam-and-raft", "the viscosity of `water` below 1 Pa s");
        assert!(water.contains(&("viscosity-water".into(), true)), "{water:?}");
        assert!(names("dam-and-raft", "x").contains(&("viscosity-water".into(), false)));
        assert!(names("ball-on-block", "deformation of body `block`").contains(&("rigidify".into(), false)));
    }
}
