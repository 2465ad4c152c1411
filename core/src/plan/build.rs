//! From a scene and the descriptors of its plugins to a plan, or to every reason why not.

use std::collections::BTreeMap;

use super::features::{meets_statics, own_actions, own_links};
use super::{
    BoundaryForm, Interface, Participant, ParticipantId, Plan, Recorder, Side, features, interfaces, streams, turns,
    window,
};
use crate::plugin::{Descriptor, InterfaceView, SolverScene, ViewRole};
use crate::scene::{Body, Material, Scene, Scheme};

/// Something the plan cannot do, by name.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{what}: {why}")]
pub struct Refusal {
    /// Body, link, pair or solver concerned.
    pub what: String,
    /// Why, and what would help.
    pub why: String,
}

impl Refusal {
    pub(super) fn new(what: impl Into<String>, why: impl Into<String>) -> Self {
        Self { what: what.into(), why: why.into() }
    }
}

/// Plugin of a solver process: named by the scene, or the process's own name.
pub fn plugin_of<'s>(scene: &'s Scene, solver: &'s str) -> &'s str {
    scene.solvers.get(solver).and_then(|s| s.plugin.as_deref()).unwrap_or(solver)
}

/// Makes the plan and each participant's part of the scene, in participant order. `descriptors` is by plugin name.
///
/// # Errors
/// Every reason why this scene cannot run with these plugins, by name.
pub fn build(
    scene: &Scene,
    descriptors: &BTreeMap<String, Descriptor>,
    cores: usize,
) -> Result<(Plan, Vec<SolverScene>), Vec<Refusal>> {
    let mut refusals = Vec::new();
    let mut participants = participants(scene);
    for participant in &participants {
        match descriptors.get(&participant.plugin) {
            None => refusals.push(Refusal::new(
                format!("solver `{}`", participant.name),
                format!("there is no plugin `{}`; `cosplat plugins` lists what is found", participant.plugin),
            )),
            Some(descriptor) => features::check(scene, participant, descriptor, &mut refusals),
        }
    }
    if participants.is_empty() {
        refusals.push(Refusal::new("scene", "it has no body, so there is nothing to simulate"));
    }
    if matches!(scene.clock.contact_scheme, Scheme::Alternating | Scheme::Centred) {
        refusals
            .push(Refusal::new("contact scheme", "this scheme is for links only; contacts take serial or parallel"));
    }
    features::check_whole(scene, &participants, descriptors, &mut refusals);
    let mut left_out = Vec::new();
    let mut found = interfaces::find(scene, &participants, descriptors, &mut left_out, &mut refusals);
    let mut streams = streams::of(&participants, descriptors, &mut found);
    let recorder = participants.len() as ParticipantId;
    let drawn = if scene.output.draws() {
        streams::of_visuals(scene, &participants, descriptors, recorder, &mut left_out)
    } else {
        Vec::new()
    };
    let records = !drawn.is_empty();
    streams.extend(drawn);
    check_numbers(found.len().max(streams.len()).max(participants.len()), &mut refusals);
    turns::check(&found, &participants, &mut refusals);
    let chosen = window::choose(scene, &found).map_err(|why| refusals.push(Refusal::new("clock", why)));
    if records {
        participants.push(recording_participant(&participants, &mut refusals));
    }
    let (Ok((clock, window_bound_by)), []) = (chosen, refusals.as_slice()) else { return Err(refusals) };
    left_out.extend(interfaces::unused(scene, &participants));
    left_out.extend(features::unmet_statics(scene, &participants, descriptors));
    let mut plan = Plan {
        clock,
        window_bound_by,
        participants,
        interfaces: found,
        streams,
        left_out,
        recorder: scene.clock.frames_per_second.filter(|_| records).map(|fps| Recorder {
            participant: recorder,
            // The clock tiles frames exactly, so that this is a whole number but for its rounding.
            windows_per_frame: ((1.0 / (fps * clock.window_s())).round() as u64).max(1),
        }),
        break_with: scene.run.break_with,
    };
    let threads = turns::threads(&plan, scene.run.threads.unwrap_or(cores));
    plan.participants.iter_mut().zip(threads).for_each(|(participant, threads)| participant.threads = threads);
    let scenes = plan.participants.iter().map(|p| part(scene, &plan, p, descriptors)).collect();
    Ok((plan, scenes))
}

/// Name of the participant that draws and writes frames.
pub const RECORDER: &str = "recorder";

/// The participant that draws and writes frames; it comes last.
fn recording_participant(solvers: &[Participant], refusals: &mut Vec<Refusal>) -> Participant {
    if solvers.iter().any(|p| p.name == RECORDER) {
        let why = "this name belongs to what writes the frames of a run; choose another for the solver";
        refusals.push(Refusal::new(format!("solver `{RECORDER}`"), why));
    }
    Participant { name: RECORDER.to_owned(), plugin: RECORDER.to_owned(), bodies: Vec::new(), threads: 1 }
}

/// Participants, interfaces and streams have numbers of 16 bits on the bus.
fn check_numbers(most: usize, refusals: &mut Vec<Refusal>) {
    if most > usize::from(u16::MAX) {
        let why = format!(
            "its bodies make {most} exchanges between solvers, at most {} are possible; put bodies that touch into one \
             solver, or switch pairs off that never meet",
            u16::MAX
        );
        refusals.push(Refusal::new("scene", why));
    }
}

fn participants(scene: &Scene) -> Vec<Participant> {
    let mut by_name: BTreeMap<&str, Vec<String>> = BTreeMap::new();
    for body in &scene.bodies {
        by_name.entry(&body.solver).or_default().push(body.name.clone());
    }
    by_name
        .into_iter()
        .map(|(name, bodies)| Participant {
            name: name.to_owned(),
            plugin: plugin_of(scene, name).to_owned(),
            bodies,
            threads: 1,
        })
        .collect()
}

/// A participant's part of the scene.
fn part(
    scene: &Scene,
    plan: &Plan,
    participant: &Participant,
    descriptors: &BTreeMap<String, Descriptor>,
) -> SolverScene {
    let ours = |name: &String| participant.bodies.contains(name);
    let id = plan.participant(&participant.name).unwrap_or_default();
    let foreign = |name: &String| !ours(name) && scene.bodies.iter().any(|b| b.name == *name);
    let touches = |a: &String, b: &String| (ours(a) || ours(b)) && !foreign(a) && !foreign(b);
    SolverScene {
        participant: participant.name.clone(),
        threads: participant.threads,
        clock: plan.clock,
        space: scene.space,
        bodies: scene.bodies.iter().filter(|b| ours(&b.name)).cloned().collect(),
        statics: if meets_statics(participant, descriptors) { scene.statics.clone() } else { Vec::new() },
        links: own_links(scene, participant),
        joints: scene.joints.iter().filter(|j| ours(&j.a)).cloned().collect(),
        actions: own_actions(scene, participant),
        pairs: scene.pairs.iter().filter(|p| touches(&p.a, &p.b)).cloned().collect(),
        probes: scene.probes.iter().filter(|p| p.body.as_ref().is_none_or(ours)).cloned().collect(),
        interfaces: plan
            .interfaces
            .iter()
            .enumerate()
            .flat_map(|(i, interface)| views(scene, plan, id, i as u16, interface, descriptors))
            .collect(),
        params: scene.solvers.get(&participant.name).map(|s| s.params.clone()).unwrap_or_default(),
        assets: BTreeMap::new(),
    }
}

/// Whether a body fills its source at t = 0: a cloth is its surface, and what it encloses may be another body's.
fn fills(body: &Body) -> bool {
    !matches!(body.material, Material::PointMass | Material::Cloth { .. } | Material::Smoke { .. })
}

/// Views of an interface from the sides that `who` owns.
fn views(
    scene: &Scene,
    plan: &Plan,
    who: u16,
    id: u16,
    interface: &Interface,
    descriptors: &BTreeMap<String, Descriptor>,
) -> Vec<InterfaceView> {
    use super::InterfaceKind::{Contact, Link as LinkKind};
    let (first, second) = match (interface.kind, interface.carries_impulses()) {
        (Contact, _) => (ViewRole::ContactResolver, ViewRole::ContactResponder),
        (LinkKind, true) => (ViewRole::LinkResolver, ViewRole::LinkResponder),
        (LinkKind, false) => (ViewRole::LinkSide, ViewRole::LinkSide),
    };
    let view = |own: &Side, partner: &Side, role: ViewRole| {
        let plugin = &plan.participants[usize::from(partner.participant)].plugin;
        let partner_form = descriptors.get(plugin)?.boundary;
        let body =
            scene.bodies.iter().find(|b| b.name == partner.body && (partner_form == BoundaryForm::Proxy || fills(b)));
        Some(InterfaceView {
            id,
            role,
            own: own.body.clone(),
            partner: partner.body.clone(),
            partner_form,
            partner_source: body.map(|b| b.source.clone()),
            partner_pose: body.map(|b| b.pose),
            rule: interface.rule,
            pair: (interface.kind == Contact).then(|| scene.pair(&own.body, &partner.body)),
            links: interface.links.iter().filter_map(|&l| scene.links.get(l).cloned()).collect(),
        })
    };
    let (a, b) = (&interface.a, &interface.b);
    let mut seen = Vec::new();
    if a.participant == who {
        seen.extend(view(a, b, first));
    }
    if b.participant == who {
        seen.extend(view(b, a, second));
    }
    seen
}
