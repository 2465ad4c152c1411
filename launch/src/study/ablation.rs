//! What each decision to leave something out changes, and what it saves: the scene is run again with the decision the
//! other way round.

use std::collections::BTreeSet;

use cosplat_core::scene::{Body, Material, Scene, Source};
use serde::Serialize;

use super::case::{Case, Comparison, Level, Measure, Reference};
use super::evaluate::{Finished, from_probes};
use super::norm;
use super::substitute::with;
use crate::folder::summary::Summary;

/// Yield stress over stiffness of what never yields.
const NEVER_YIELDS: f64 = 1e6;

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
}

/// What a decision is worth.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct Worth {
    /// Short name.
    pub(crate) name: String,
    /// What was done the other way round.
    pub(crate) instead: String,
    /// What the decision was taken by, in words; empty where it follows from what the scene asks for.
    pub(crate) indicator: String,
    /// Whether nothing was allowed to change.
    pub(crate) must_not_matter: bool,
    /// Whether both runs end in the same state, to the bit.
    pub(crate) same_bytes: bool,
    /// Largest distance of a probe between the two runs, relative to how far it moves; null where none moves.
    pub(crate) difference: Option<f64>,
    /// Wall time inside the windows that the decision saves \[s\], where both were run alone.
    pub(crate) saved_s: Option<f64>,
    /// Processor time of all solvers that it saves \[s\], set-up included: runs beside it disturb it least.
    pub(crate) saved_core_s: Option<f64>,
    /// Memory of all processes that it saves \[MiB\].
    pub(crate) saved_mib: Option<f64>,
    /// Messages over interfaces that it saves.
    pub(crate) saved_messages: i64,
    /// Why there is nothing to compare.
    pub(crate) why_not: Option<String>,
    /// False where something changed that was not allowed to.
    pub(crate) passed: bool,
}

/// All decisions that a scene and its run offer.
pub(crate) fn decisions(scene: &Scene, summary: &Summary) -> Vec<Decision> {
    let has = |what: &str| by(summary, what).is_some();
    let of = |what: &str| by(summary, what).unwrap_or_default();
    let mut found = vec![
        decision(
            "idle-process",
            "an empty solver takes part",
            &[("solver.idle-solver.plugin", "\"oscillator\"")],
            true,
        ),
        decision("trace", "with `trace.json`", &[("output.trace", "true")], true),
    ];
    if scene.output.draws() {
        let on = ["pictures", "splats", "recording"].map(|key| (format!("output.{key}"), "true".to_owned()));
        found.push(Decision {
            set: on.into(),
            ..decision("frames", "frames are drawn, written and recorded", &[], true)
        });
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
    Decision { name: name.into(), instead: instead.into(), indicator, set, must_not_matter, by_probes: false }
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

/// Decisions about what a body is made of. What a solver leaves out may as well not stand in the scene.
fn of_material(body: &Body, summary: &Summary) -> Vec<Decision> {
    let name = &body.name;
    let without = |feature: &str, set: (String, String), indicator: Option<String>, must_not_matter: bool| {
        let instead = format!("`{name}` without {feature}");
        let plain = decision(&format!("{}-{name}", feature.replace(' ', "-")), &instead, &[], must_not_matter);
        Decision { set: vec![set], indicator: indicator.unwrap_or_default(), ..plain }
    };
    let number = |feature: &str, key: &str, value: f64, indicator: Option<String>, must_not_matter: bool| {
        let material = with(&body.material, key, value)?;
        Some(without(feature, (format!("body.{name}.material"), material), indicator, must_not_matter))
    };
    let mut found = Vec::new();
    match body.material {
        Material::SphLiquid { surface_tension_n_m, viscosity_pa_s, .. } => {
            let tension = by(summary, &format!("surface tension of `{name}`")).filter(|_| surface_tension_n_m > 0.0);
            if tension.is_some() {
                found.extend(number("surface tension", "surface_tension", 0.0, tension, true));
            }
            if viscosity_pa_s > 0.0 {
                let known = by(summary, &format!("the viscosity of `{name}`"));
                let is_known = known.is_some();
                found.extend(number("viscosity", "viscosity", 0.0, known, is_known));
            }
        }
        Material::Elastoplastic { youngs_modulus_pa, yield_stress_pa, .. } => {
            let part = yield_stress_pa / youngs_modulus_pa;
            let indicator = Some(format!("yield stress over stiffness {part:.3e} against 1.000e0"));
            let never = NEVER_YIELDS * youngs_modulus_pa;
            // A solid is not strained by its whole size: what yields only there never does.
            found.extend(number("plasticity", "yield_stress", never, indicator, part > 1.0));
        }
        Material::Cloth { areal_density_kg_m2, stretch_compliance_m_n, .. } => {
            if stretch_compliance_m_n > 0.0 {
                let part = compliance_part(body, areal_density_kg_m2, stretch_compliance_m_n, summary);
                found.extend(number("compliance", "stretch_compliance", 0.0, part, false));
            }
            if by(summary, "relaxation factors").is_some() {
                found.extend(number("relaxation", "stretch_relaxation", 1.0, None, true));
            }
        }
        _ => {}
    }
    if matches!(body.source, Source::Splat { .. }) {
        found.push(without("inside", (format!("body.{name}.splat.fill"), "\"none\"".into()), None, false));
    }
    found
}

/// Compliance of a thread over the square of a substep, against the inverse masses of its two ends: below a thousandth
/// a constraint is as good as inextensible (Macklin et al. 2016, equation 18).
fn compliance_part(body: &Body, areal_density: f64, compliance: f64, summary: &Summary) -> Option<String> {
    let process = summary.processes.iter().find(|process| process.name == body.solver)?;
    let substep = summary.simulated_s / process.substeps.max(1) as f64;
    let inverse_masses = 2.0 / (areal_density * body.spacing_m?.powi(2));
    Some(format!("{:.3e} against 1.000e-3", compliance / substep.powi(2) / inverse_masses))
}

/// The case of a scene with changes.
pub(crate) fn case_of(scene: &str, [name, title]: [&str; 2], set: Vec<(String, Level)>) -> Case {
    Case {
        name: name.to_owned(),
        title: title.to_owned(),
        scene: scene.to_owned(),
        source: String::new(),
        quantities: Vec::new(),
        set,
        vary: Vec::new(),
        gates: Vec::new(),
        slow: false,
    }
}

/// Compares the run as it is with the run the other way round.
pub(crate) fn worth(decision: &Decision, plain: &Finished, other: &Finished) -> Worth {
    let summaries = (plain.summary(), other.summary());
    let hash = |summary: Option<&Summary>| summary.and_then(|s| s.state_hash.clone());
    let same_bytes = hash(summaries.0).is_some() && hash(summaries.0) == hash(summaries.1);
    let both = summaries.0.zip(summaries.1);
    let memory = |s: &Summary| s.processes.iter().map(|p| p.peak_rss_mib).sum::<Option<f64>>();
    let messages = |s: &Summary| (2 * s.windows * s.interfaces.len() as u64).cast_signed();
    let difference = difference(plain, other);
    let same_probes = decision.by_probes && difference.is_some_and(|d| d <= 0.0);
    Worth {
        name: decision.name.clone(),
        instead: decision.instead.clone(),
        indicator: decision.indicator.clone(),
        must_not_matter: decision.must_not_matter,
        same_bytes,
        difference,
        saved_s: both.and_then(|_| Some(other.wall_s()? - plain.wall_s()?)),
        saved_core_s: both.and_then(|_| Some(other.core_s()? - plain.core_s()?)),
        saved_mib: both.and_then(|(plain, other)| Some(memory(other)? - memory(plain)?)),
        saved_messages: both.map_or(0, |(plain, other)| messages(other) - messages(plain)),
        why_not: both.is_none().then(|| other.complaint().unwrap_or_else(|| "it has no result".into())),
        passed: same_bytes || same_probes || !decision.must_not_matter,
    }
}

/// Largest distance of a probe between two runs.
fn difference(plain: &Finished, other: &Finished) -> Option<f64> {
    let quantities = from_probes(plain.probes()?);
    let apart = quantities.iter().filter_map(|quantity| {
        let super::case::Kind::Probe(known) = &quantity.kind else { return None };
        let comparison = Comparison { reference: Reference::Finest, measure: Measure::L2, ..(**known).clone() };
        norm::error(&other.curve(&quantity.name), &comparison, &plain.curve(&quantity.name))
    });
    apart.reduce(f64::max)
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
        assert!(names("dam-and-raft", "x").iter().any(|(name, _)| name == "ccd-rigid"));
        let cloth = names("silk-over-rock", "x");
        assert!(cloth.iter().any(|(name, matters_not)| name.starts_with("compliance-") && !matters_not), "{cloth:?}");
        let water = names("dam-and-raft", "the viscosity of `water` below 1 Pa s");
        assert!(water.contains(&("viscosity-water".into(), true)), "{water:?}");
        assert!(names("dam-and-raft", "x").contains(&("viscosity-water".into(), false)));
        assert!(names("ball-on-block", "deformation of body `block`").contains(&("rigidify".into(), false)));
    }
}
