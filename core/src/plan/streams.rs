//! What must be sent for the interfaces of a plan.

use std::collections::BTreeMap;

use super::{BoundaryForm, Content, Interface, InterfaceKind, Participant, ParticipantId, Side, Stream, StreamId};
use crate::plugin::Descriptor;
use crate::scene::Scheme;

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
