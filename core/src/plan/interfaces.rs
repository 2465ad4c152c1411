//! Which bodies of different solvers meet, and who resolves.

use std::cmp::Ordering;
use std::collections::BTreeMap;

use super::{BoundaryForm, Interface, InterfaceKind, LeftOut, Participant, ParticipantId, Refusal, Side};
use crate::plugin::{Descriptor, InterfaceRole};
use crate::scene::{Body, Lame, Material, PairSpec, Scene};

/// Context of a search for interfaces.
struct Search<'s> {
    scene: &'s Scene,
    participants: &'s [Participant],
    descriptors: &'s BTreeMap<String, Descriptor>,
}

/// A body and who owns it.
#[derive(Clone)]
struct Owned<'s> {
    side: Side,
    body: &'s Body,
    solver: &'s str,
    descriptor: &'s Descriptor,
}

impl<'s> Search<'s> {
    /// A body with its owner; none where the plugin is not known, which has been refused already.
    fn owned(&self, name: &str) -> Option<Owned<'s>> {
        let body = self.scene.bodies.iter().find(|b| b.name == name)?;
        let owner = self.participants.iter().position(|p| p.name == body.solver)?;
        Some(Owned {
            side: Side { participant: owner as ParticipantId, body: body.name.clone() },
            body,
            solver: &body.solver,
            descriptor: self.descriptors.get(&self.participants[owner].plugin)?,
        })
    }
}

/// Whether `a` can compute contact with `b` and `b` can take it.
fn can_resolve(a: &Owned, b: &Owned) -> bool {
    let wanted = match b.descriptor.boundary {
        BoundaryForm::Proxy => InterfaceRole::ResolveProxy,
        BoundaryForm::SamplesF32 { .. } | BoundaryForm::SamplesF64 { .. } => InterfaceRole::ResolveSamples,
    };
    a.descriptor.roles.contains(&wanted) && b.descriptor.roles.contains(&InterfaceRole::Respond)
}

/// All interfaces of a scene.
pub(super) fn find(
    scene: &Scene,
    participants: &[Participant],
    descriptors: &BTreeMap<String, Descriptor>,
    left_out: &mut Vec<LeftOut>,
    refusals: &mut Vec<Refusal>,
) -> Vec<Interface> {
    let search = Search { scene, participants, descriptors };
    let mut found = links(&search, refusals);
    let contacts = contacts(&search, left_out, refusals);
    // Two bodies that are joined and may touch have two interfaces, and these two names.
    for link in &mut found {
        if contacts.iter().any(|contact| joins(contact, &link.a, &link.b)) {
            link.name.push_str("/link");
        }
    }
    found.extend(contacts);
    found
}

/// Whether an interface lies between these two, in either order.
fn joins(interface: &Interface, a: &Side, b: &Side) -> bool {
    interface.a == *a && interface.b == *b || interface.a == *b && interface.b == *a
}

/// Links between bodies of different solvers, those of the same two bodies together.
fn links(search: &Search, refusals: &mut Vec<Refusal>) -> Vec<Interface> {
    let mut found: Vec<Interface> = Vec::new();
    let scene = search.scene;
    for (index, link) in scene.links.iter().enumerate() {
        let ends = (search.owned(&link.a), link.b.as_deref().and_then(|b| search.owned(b)));
        let (Some(mut a), Some(mut b)) = ends else { continue };
        if a.side.participant == b.side.participant {
            continue;
        }
        if link.first.as_ref() == Some(&b.side.body) {
            std::mem::swap(&mut a, &mut b);
        }
        for end in [&a, &b].into_iter().filter(|end| !end.descriptor.roles.contains(&InterfaceRole::Link)) {
            let plugin = &search.participants[usize::from(end.side.participant)].plugin;
            let why = format!("plugin `{plugin}` of body `{}` takes no links to other solvers", end.side.body);
            refusals.push(Refusal::new(format!("link `{}`", link.name), why));
        }
        let (a, b) = (a.side, b.side);
        let Some(known) = found.iter_mut().find(|i| joins(i, &a, &b)) else {
            found.push(interface(scene, InterfaceKind::Link, a, b, vec![index]));
            continue;
        };
        // The first link that says who goes first decides; another may not say otherwise.
        let wish = |l: &usize| scene.links.get(*l).and_then(|l| Some((&l.name, l.first.as_ref()?)));
        match (known.links.iter().find_map(wish), &link.first) {
            (Some((earlier, said)), Some(first)) if said != first => {
                let why = format!("it lets `{first}` go first and link `{earlier}` of the same bodies `{said}`");
                refusals.push(Refusal::new(format!("link `{}`", link.name), why));
            }
            (None, Some(_)) => {
                known.name = format!("{}~{}", a.body, b.body);
                (known.a, known.b) = (a, b);
            }
            _ => {}
        }
        known.links.push(index);
    }
    found
}

/// Contacts: every pair of bodies in different solvers, unless the scene leaves it out or nobody can resolve it.
fn contacts(search: &Search, left_out: &mut Vec<LeftOut>, refusals: &mut Vec<Refusal>) -> Vec<Interface> {
    let mut found = Vec::new();
    let bodies: Vec<Owned> = search.scene.bodies.iter().filter_map(|b| search.owned(&b.name)).collect();
    for (i, one) in bodies.iter().enumerate() {
        for other in bodies[i + 1..].iter().filter(|other| other.side.participant != one.side.participant) {
            let said = said_pair(search.scene, &one.side.body, &other.side.body);
            let name = format!("{}~{}", one.side.body, other.side.body);
            if said.is_some_and(|p| !p.enabled) {
                left_out.push(not_coupled(&name, "the scene switches this pair off"));
                continue;
            }
            match resolver(one, other, said) {
                Ok((a, b)) => {
                    let (first, second) = if a == one.side { (one, other) } else { (other, one) };
                    let shows_samples = second.descriptor.boundary != BoundaryForm::Proxy;
                    let at_once = shows_samples && first.descriptor.has_feature("sudden-impulses");
                    let contact = interface(search.scene, InterfaceKind::Contact, a, b, Vec::new());
                    found.push(Interface { at_once, ..contact });
                }
                Err(why) if said.is_some() => refusals.push(Refusal::new(format!("pair `{name}`"), why)),
                Err(why) => left_out.push(not_coupled(&name, &why)),
            }
        }
    }
    found
}

/// An interface whose streams are not known yet.
fn interface(scene: &Scene, kind: InterfaceKind, a: Side, b: Side, links: Vec<usize>) -> Interface {
    Interface {
        name: format!("{}~{}", a.body, b.body),
        kind,
        scheme: match kind {
            InterfaceKind::Contact => scene.clock.contact_scheme,
            InterfaceKind::Link => scene.clock.link_scheme,
        },
        rule: scene.clock.motion_rule,
        at_once: false,
        a,
        b,
        from_a: None,
        from_b: 0,
        impulses: None,
        links,
    }
}

/// Orders two bodies as resolver and responder: as the scene says, else the softer resolves.
fn resolver(one: &Owned, other: &Owned, said: Option<&PairSpec>) -> Result<(Side, Side), String> {
    let sides = |a: &Owned, b: &Owned| Ok((a.side.clone(), b.side.clone()));
    if let Some(wanted) = said.and_then(|p| p.resolver.as_deref()) {
        let (a, b) = match (one.solver == wanted, other.solver == wanted) {
            (true, _) => (one, other),
            (_, true) => (other, one),
            _ => return Err(format!("its resolver `{wanted}` is neither `{}` nor `{}`", one.solver, other.solver)),
        };
        return if can_resolve(a, b) {
            sides(a, b)
        } else {
            Err(format!("solver `{wanted}` cannot compute contact with `{}`", b.side.body))
        };
    }
    let softness = |o: &Owned| (rank(&o.body.material), stiffness(&o.body.material));
    let order = softness(one).partial_cmp(&softness(other)).unwrap_or(Ordering::Equal);
    let one_first = order.then_with(|| one.side.cmp(&other.side)).is_le();
    let (first, second) = if one_first { (one, other) } else { (other, one) };
    match (can_resolve(first, second), can_resolve(second, first)) {
        (true, _) => sides(first, second),
        (false, true) => sides(second, first),
        (false, false) => {
            Err(format!("neither `{}` nor `{}` computes contact with the other", first.solver, second.solver))
        }
    }
}

/// P-wave modulus of a solid \[Pa\], by which the softer of two is told; 0 for what has none.
fn stiffness(material: &Material) -> f64 {
    material.lame().map_or(0.0, Lame::p_wave_modulus_pa)
}

/// Order in which kinds resolve: smoke, liquid, cloth, solid, then rigid, which only responds.
fn rank(material: &Material) -> u8 {
    match material {
        Material::Smoke { .. } => 0,
        Material::SphLiquid { .. } => 1,
        Material::Cloth { .. } => 2,
        Material::MpmLiquid { .. } => 3,
        Material::Granular { .. }
        | Material::Snow { .. }
        | Material::Elastic { .. }
        | Material::Elastoplastic { .. }
        | Material::Viscoplastic { .. } => 4,
        Material::PointMass => 5,
        Material::Rigid { .. } => 6,
    }
}

fn said_pair<'s>(scene: &'s Scene, a: &str, b: &str) -> Option<&'s PairSpec> {
    scene.pairs.iter().find(|p| p.a == a && p.b == b || p.a == b && p.b == a)
}

fn not_coupled(name: &str, why: &str) -> LeftOut {
    LeftOut {
        what: format!("contact `{name}`"),
        why: why.to_owned(),
        indicator: None,
        limit: None,
        saved: "not measured".to_owned(),
    }
}

/// Solver processes that the scene names and no body uses.
pub(super) fn unused(scene: &Scene, participants: &[Participant]) -> Vec<LeftOut> {
    let idle = scene.solvers.keys().filter(|name| !participants.iter().any(|p| &&p.name == name));
    idle.map(|name| LeftOut {
        what: format!("process `{name}`"),
        why: "no body of the scene belongs to it".to_owned(),
        indicator: Some(0.0),
        limit: Some(1.0),
        saved: "one process".to_owned(),
    })
    .collect()
}
