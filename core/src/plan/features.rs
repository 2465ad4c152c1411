//! What a scene asks of each plugin, and whether the plugin lists it.

use std::collections::BTreeMap;

use super::{LeftOut, Participant, Refusal};
use crate::plugin::Descriptor;
use crate::scene::{Action, Body, Link, Material, PairSpec, ProbeQuantity, Scene, Source, Space};

/// Feature of a plugin whose bodies can touch static colliders.
const STATICS: &str = "statics";
/// Feature of a plugin among whose static colliders may be terrain.
const HEIGHT_FIELDS: &str = "height-fields";

/// Feature of a plugin whose bodies may have regions of another material.
pub(crate) const REGIONS: &str = "regions";

/// Key of a body's source in scenes and descriptors.
pub fn source_kind(source: &Source) -> &'static str {
    match source {
        Source::Splat { .. } => "splat",
        Source::Mesh { .. } => "mesh",
        Source::HeightField { .. } => "height-field",
        Source::Box { .. } => "box",
        Source::Sphere { .. } => "sphere",
        Source::Cylinder { .. } => "cylinder",
        Source::Plane { .. } => "plane",
        Source::Points { .. } => "points",
        Source::Cloud { .. } => "cloud",
    }
}

fn quantity_name(quantity: ProbeQuantity) -> &'static str {
    match quantity {
        ProbeQuantity::Position => "position",
        ProbeQuantity::Orientation => "orientation",
        ProbeQuantity::Velocity => "velocity",
        ProbeQuantity::Momentum => "momentum",
        ProbeQuantity::Pressure => "pressure",
        ProbeQuantity::Force => "force",
        ProbeQuantity::VolumeFraction => "volume-fraction",
        ProbeQuantity::Strain => "strain",
        ProbeQuantity::Reach => "reach",
    }
}

/// Whether a probe can be answered from what every solver reports: the state of a body, and what crosses its interfaces.
pub fn is_body_probe(quantity: ProbeQuantity) -> bool {
    use ProbeQuantity::{Force, Momentum, Orientation, Position, Velocity};
    matches!(quantity, Position | Orientation | Velocity | Momentum | Force)
}

/// Refuses by name whatever the plugin does not list.
pub(super) fn check(scene: &Scene, participant: &Participant, plugin: &Descriptor, refusals: &mut Vec<Refusal>) {
    let name = &plugin.name;
    let mut refuse = |what: String, lack: &str| {
        refusals.push(Refusal::new(what, format!("plugin `{name}` has no {lack}; `cosplat plugins` lists who has")));
    };
    let own: Vec<&Body> = scene.bodies.iter().filter(|b| participant.bodies.contains(&b.name)).collect();
    for body in &own {
        let kind = source_kind(&body.source);
        if !plugin.body_kinds.iter().any(|k| k == kind) {
            refuse(format!("body `{}`", body.name), &format!("bodies from `{kind}`"));
        }
        for material in body.materials().map(Material::name) {
            if !plugin.materials.iter().any(|m| m == material) {
                refuse(format!("body `{}`", body.name), &format!("material `{material}`"));
            }
        }
        if !body.regions.is_empty() && !plugin.has_feature(REGIONS) {
            refuse(format!("body `{}`", body.name), "regions of another material");
        }
        if body.prescribed.is_some() && !plugin.has_feature("prescribed") {
            refuse(format!("body `{}`", body.name), "prescribed motion");
        }
        for wall in said_walls(scene, body).filter(|_| !plugin.has_feature(STATICS)) {
            refuse(format!("pair `{}~{wall}`", body.name), "static colliders");
        }
    }
    let terrain = scene.statics.iter().find(|s| matches!(s.source, Source::HeightField { .. }));
    if let Some(terrain) = terrain.filter(|_| plugin.has_feature(STATICS) && !plugin.has_feature(HEIGHT_FIELDS)) {
        refuse(format!("static `{}`", terrain.name), "terrain from `height_field`");
    }
    if scene.space != Space::Full && !plugin.has_feature("slab") {
        refuse("space".to_owned(), "two-dimensional slabs");
    }
    for joint in scene.joints.iter().filter(|j| own.iter().any(|b| b.name == j.a || Some(&b.name) == j.b.as_ref())) {
        if !plugin.has_feature("joints") {
            refuse(format!("joint `{}`", joint.name), "joints");
        }
    }
    for link in own_links(scene, participant) {
        if !plugin.has_feature("links") {
            refuse(format!("link `{}`", link.name), "links inside the solver or to the world");
        }
    }
    for action in own_actions(scene, participant) {
        let kind = action.kind.name();
        if !plugin.has_feature(kind) {
            refuse(format!("action `{kind}`"), &format!("action `{kind}`"));
        }
    }
    for probe in &scene.probes {
        let ours = probe.body.as_ref().is_some_and(|b| participant.bodies.contains(b));
        if ours && !is_body_probe(probe.quantity) && !plugin.probes.contains(&probe.quantity) {
            refuse(format!("probe `{}`", probe.name), &format!("probe `{}`", quantity_name(probe.quantity)));
        }
    }
}

/// Refuses what concerns no single solver: joints between two of them, and probes at a point that none answers.
pub(super) fn check_whole(
    scene: &Scene,
    participants: &[Participant],
    descriptors: &BTreeMap<String, Descriptor>,
    refusals: &mut Vec<Refusal>,
) {
    let owner = |body: &String| participants.iter().find(|p| p.bodies.contains(body)).map(|p| &p.name);
    for joint in &scene.joints {
        if let (Some(a), Some(b)) = (owner(&joint.a), joint.b.as_ref().and_then(owner))
            && a != b
        {
            let why =
                format!("it joins bodies of the solvers `{a}` and `{b}`; put both into one solver, or use a link");
            refusals.push(Refusal::new(format!("joint `{}`", joint.name), why));
        }
    }
    let known: Vec<&Descriptor> = participants.iter().filter_map(|p| descriptors.get(&p.plugin)).collect();
    for probe in scene.probes.iter().filter(|p| p.body.is_none()) {
        if known.len() == participants.len() && !known.iter().any(|d| d.probes.contains(&probe.quantity)) {
            let what = format!("probe `{}`", probe.name);
            let why = format!("no plugin of this scene measures `{}` at a point", quantity_name(probe.quantity));
            refusals.push(Refusal::new(what, why));
        }
    }
}

/// Static colliders for which the scene says how they touch a body.
fn said_walls<'s>(scene: &'s Scene, body: &'s Body) -> impl Iterator<Item = &'s str> {
    let other = |pair: &'s PairSpec| match (&pair.a, &pair.b) {
        (a, b) if *a == body.name => Some(b),
        (a, b) if *b == body.name => Some(a),
        _ => None,
    };
    let walls = scene.pairs.iter().filter(|p| p.enabled).filter_map(other);
    walls.filter(|name| scene.statics.iter().any(|s| s.name == **name)).map(String::as_str)
}

/// Whether a participant is told about the scene's static colliders.
pub(super) fn meets_statics(participant: &Participant, descriptors: &BTreeMap<String, Descriptor>) -> bool {
    descriptors.get(&participant.plugin).is_some_and(|d| d.has_feature(STATICS))
}

/// Static colliders that the bodies of a solver pass through, because its plugin takes none.
pub(super) fn unmet_statics(
    scene: &Scene,
    participants: &[Participant],
    descriptors: &BTreeMap<String, Descriptor>,
) -> Vec<LeftOut> {
    // Who owns no body has nothing that could meet one.
    let blind = participants.iter().filter(|p| !p.bodies.is_empty() && !meets_statics(p, descriptors));
    let unmet = blind.flat_map(|p| scene.statics.iter().map(move |s| (p, s)));
    unmet
        .map(|(participant, wall)| LeftOut {
            what: format!("static collider `{}` for solver `{}`", wall.name, participant.name),
            why: format!("plugin `{}` takes no static colliders", participant.plugin),
            indicator: None,
            limit: None,
            saved: "not measured".to_owned(),
        })
        .collect()
}

/// Links inside a solver or from it to the world.
pub(super) fn own_links(scene: &Scene, participant: &Participant) -> Vec<Link> {
    let ours = |name: &String| participant.bodies.contains(name);
    scene.links.iter().filter(|l| ours(&l.a) && l.b.as_ref().is_none_or(ours)).cloned().collect()
}

/// Actions on a solver's bodies.
pub(super) fn own_actions(scene: &Scene, participant: &Participant) -> Vec<Action> {
    let hits = |a: &&Action| a.bodies.is_empty() || a.bodies.iter().any(|b| participant.bodies.contains(b));
    scene.actions.iter().filter(hits).cloned().collect()
}
