//! Scenes without bodies, and scenes that ask for more than a plugin has.

use cosplat_core::plugin::{Descriptor, Inputs, PluginError, SolverScene, Steady};
use cosplat_core::scene::{ActionKind, Joint, JointKind, Material, Motion, Source, Space};

use crate::rule::Rule::{EmptyScene, UnsupportedNamed};
use crate::shape::finite_outputs;
use crate::trial::Verdict;
use crate::{Case, Make, parts};

pub(crate) fn check(make: Make<'_>, case: &Case, verdict: &mut Verdict) {
    empty(make, case, verdict);
    let descriptor = make().describe();
    if case.scene.bodies.is_empty() {
        return;
    }
    for (what, names, scene) in unsupported(&descriptor, &case.scene) {
        match make().setup(&scene) {
            Ok(_) => verdict.add(UnsupportedNamed, format!("{what} is accepted, although it is not declared")),
            Err(PluginError::Unsupported(message)) => {
                let lower = message.to_lowercase();
                verdict.must(names.iter().any(|n| lower.contains(n.as_str())), UnsupportedNamed, || {
                    format!("{what} is refused without a name: {message}")
                });
            }
            Err(other) => verdict.add(UnsupportedNamed, format!("{what} gives another error: {other}")),
        }
    }
}

fn empty(make: Make<'_>, case: &Case, verdict: &mut Verdict) {
    let mut scene = case.scene.clone();
    scene.bodies.clear();
    scene.links.clear();
    scene.joints.clear();
    scene.interfaces.clear();
    scene.probes.clear();
    scene.pairs.clear();
    let mut plugin = make();
    let played = plugin.setup(&scene).and_then(|setup| {
        plugin.connect(&[])?;
        let clean = setup.boundaries.is_empty() && setup.particles.is_empty() && setup.report.bodies.is_empty();
        let outputs = plugin.advance(&parts::step(&scene.clock, 0), &Inputs::default(), &mut Steady)?;
        Ok(clean && outputs.boundaries.is_empty() && outputs.impulses.is_empty() && finite_outputs(&outputs))
    });
    match played {
        Ok(clean) => verdict.must(clean, EmptyScene, || "it shows bodies or numbers that are none".into()),
        Err(why) => verdict.add(EmptyScene, why.to_string()),
    }
}

/// Scenes that each ask for one thing not declared: what, the names one of which must be in the refusal, the scene.
fn unsupported(d: &Descriptor, base: &SolverScene) -> Vec<(String, Vec<String>, SolverScene)> {
    let mut scenes = Vec::new();
    let body = base.bodies[0].name.clone();
    let mut ask = |what: &str, names: &[&str], change: &dyn Fn(&mut SolverScene)| {
        let mut scene = base.clone();
        change(&mut scene);
        scenes.push((what.to_owned(), names.iter().map(|n| n.to_lowercase()).collect::<Vec<_>>(), scene));
    };
    if !d.has_feature("slab") {
        ask("a slab", &["slab", "two-dimensional", "2-d"], &|s| {
            s.space = Space::Slab { normal: 1, thickness_m: 0.1 };
        });
    }
    if !d.has_feature("joints") {
        let joint = Joint {
            name: "odd-joint".into(),
            kind: JointKind::Ball,
            a: body.clone(),
            b: None,
            anchor_m: [0.0; 3],
            axis: [0.0, 0.0, 1.0],
            stiffness: 0.0,
            damping: 0.0,
        };
        ask("a joint", &["odd-joint", "joint"], &|s| s.joints.push(joint.clone()));
    }
    if !d.has_feature("links") {
        let link = parts::spring(&body, None, 1.0, [0.0; 3], [0.0; 3]);
        ask("a link to the world", &["link"], &|s| s.links.push(link.clone()));
    }
    if !d.has_feature("prescribed") {
        let motion = Motion::Oscillation { amplitude_m: [0.1, 0.0, 0.0], frequency_hz: 1.0 };
        ask("a prescribed motion", &["prescribed"], &|s| s.bodies[0].prescribed = Some(motion));
    }
    for (feature, kind) in action_kinds() {
        if !d.has_feature(feature) {
            let words = feature.replace('-', " ");
            ask(&format!("the action {feature}"), &[feature, &words], &|s| {
                s.actions.push(parts::action(kind, 0.0, None));
            });
        }
    }
    let strange = [
        Material::Smoke { density_kg_m3: 1.0, viscosity: 0.1 },
        Material::PointMass,
        Material::Rigid { density_kg_m3: 1000.0, friction: 0.5 },
    ];
    if let Some(material) = strange.into_iter().find(|m| !d.materials.iter().any(|known| known == m.name())) {
        ask(&format!("the material {}", material.name()), &[material.name()], &|s| s.bodies[0].material = material);
    }
    let sources = [
        ("cloud", Source::Cloud { count: 3, size_m: [1.0; 3] }),
        ("plane", Source::Plane { size_m: None }),
        ("points", Source::Points { positions_m: vec![[0.0; 3]] }),
    ];
    if let Some((kind, source)) = sources.into_iter().find(|(kind, _)| !d.body_kinds.iter().any(|known| known == kind))
    {
        ask(&format!("a body from {kind}"), &[kind, &body], &|s| s.bodies[0].source = source.clone());
    }
    scenes
}

fn action_kinds() -> [(&'static str, ActionKind); 5] {
    let wind = ActionKind::Wind { velocity_m_s: [1.0, 0.0, 0.0], air_density_kg_m3: 1.2, drag_coefficient: 1.0 };
    [
        ("wind", wind),
        ("gravity", ActionKind::Gravity { acceleration_m_s2: [0.0, 0.0, -1.0] }),
        ("point-force", ActionKind::PointForce { force_n: [1.0, 0.0, 0.0], at_m: None }),
        ("impulse", ActionKind::Impulse { impulse_n_s: [1.0, 0.0, 0.0], at_m: None }),
        ("reverse", ActionKind::Reverse),
    ]
}
