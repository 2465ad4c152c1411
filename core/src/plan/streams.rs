//! What must be sent for the interfaces of a plan.

use std::collections::BTreeMap;

use super::{
    BoundaryForm, Content, Interface, InterfaceKind, LeftOut, Participant, ParticipantId, Side, Stream, StreamId,
};
use crate::plugin::Descriptor;
use crate::scene::{Scene, Scheme, Source};
use crate::visual::VisualForm;

/// Streams of all interfaces; fills in the stream numbers of each.
pub(super) fn of(
    participants: &[Participant],
    descriptors: &BTreeMap<String, Descriptor>,
    interfaces: &mut [Interface],
) -> Vec<Stream> {
    let mut made = Streams { participants, descriptors, places: BTreeMap::new(), list: Vec::new() };
    for (index, interface) in interfaces.iter_mut().enumerate() {
        let (a, b) = (interface.a.clone(), interface.b.clone());
        let contact = interface.kind == InterfaceKind::Contact;
        let centred = !contact && interface.scheme == Scheme::Centred;
        interface.from_b = made.boundary(&b, a.participant, centred);
        if contact {
            made.statics(&b, a.participant);
        }
        if contact || centred {
            interface.impulses = Some(made.impulses(&a, &b, index as u16));
        } else {
            interface.from_a = Some(made.boundary(&a, b.participant, false));
        }
    }
    made.list
}

/// Streams of all bodies that are drawn, and what cannot be.
pub(super) fn of_visuals(
    scene: &Scene,
    participants: &[Participant],
    descriptors: &BTreeMap<String, Descriptor>,
    recorder: ParticipantId,
    left_out: &mut Vec<LeftOut>,
) -> Vec<Stream> {
    let mut found = Vec::new();
    for (owner, participant) in (0..).zip(participants) {
        let offered = descriptors.get(&participant.plugin).and_then(|d| d.visual);
        for body in scene.bodies.iter().filter(|b| participant.bodies.contains(&b.name)) {
            let Some(form) = offered.map(|form| visual_form(form, &body.source)) else {
                left_out.push(LeftOut {
                    what: format!("pictures of body `{}`", body.name),
                    why: format!("plugin `{}` shows nothing of its bodies", participant.plugin),
                    indicator: None,
                    limit: None,
                    saved: "not measured".to_owned(),
                });
                continue;
            };
            let key = format!("out/{}/{}", participant.name, body.name);
            let content = Content::Visual { body: body.name.clone(), form };
            found.push(Stream { key, from: owner, to: vec![recorder], content });
        }
    }
    found
}

/// Deformation gradients travel only where Gaussians ride on them.
fn visual_form(offered: VisualForm, source: &Source) -> VisualForm {
    match offered {
        VisualForm::Particles { gradients } => {
            VisualForm::Particles { gradients: gradients && matches!(source, Source::Splat { .. }) }
        }
        VisualForm::Pose => VisualForm::Pose,
    }
}

struct Streams<'p> {
    participants: &'p [Participant],
    descriptors: &'p BTreeMap<String, Descriptor>,
    places: BTreeMap<String, usize>,
    list: Vec<Stream>,
}

impl Streams<'_> {
    fn form(&self, side: &Side) -> BoundaryForm {
        let plugin = &self.participants[usize::from(side.participant)].plugin;
        self.descriptors.get(plugin).map_or(BoundaryForm::SamplesF64 { normals: false }, |d| d.boundary)
    }

    fn name(&self, id: ParticipantId) -> &str {
        &self.participants[usize::from(id)].name
    }

    fn boundary(&mut self, side: &Side, reader: ParticipantId, middle: bool) -> StreamId {
        let (body, form) = (side.body.clone(), self.form(side));
        let letter = if middle { 'm' } else { 'b' };
        let key = format!("{letter}/{}/{body}", self.name(side.participant));
        let content = if middle { Content::MidBoundary { body, form } } else { Content::Boundary { body, form } };
        self.add(key, side.participant, reader, content)
    }

    fn statics(&mut self, side: &Side, reader: ParticipantId) {
        if self.form(side) != BoundaryForm::Proxy {
            let key = format!("s/{}/{}", self.name(side.participant), side.body);
            self.add(key, side.participant, reader, Content::Statics { body: side.body.clone() });
        }
    }

    fn impulses(&mut self, a: &Side, b: &Side, interface: u16) -> StreamId {
        let key = format!("imp/{}/{}/{interface}", self.name(a.participant), self.name(b.participant));
        self.add(key, a.participant, b.participant, Content::Impulses { interface, form: self.form(b) })
    }

    /// One stream per key, with all its readers.
    fn add(&mut self, key: String, from: ParticipantId, reader: ParticipantId, content: Content) -> StreamId {
        let next = self.list.len();
        let at = *self.places.entry(key.clone()).or_insert(next);
        if at == next {
            self.list.push(Stream { key, from, to: Vec::new(), content });
        }
        let readers = &mut self.list[at].to;
        if !readers.contains(&reader) {
            readers.push(reader);
        }
        at as StreamId
    }
}
