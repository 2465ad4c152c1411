//! What a participant has published and may be asked for again.

use std::collections::{BTreeMap, BTreeSet};

use super::Frame;
use crate::boundary::{BoundaryState, Impulses, SampleStatics, Vec3};
use crate::checkpoint::KeptMessage;
use crate::control::RunId;
use crate::plan::schedule::MessageId;
use crate::plan::{BoundaryForm, Content, Interface, Plan, StreamId};
use crate::plugin::Outputs;
use crate::visual::VisualState;
use crate::wire::{self, Origin, PayloadError};

/// Encodes and keeps messages until they are settled.
#[derive(Debug)]
pub struct Outbox {
    run: RunId,
    epoch: u32,
    sender: u16,
    seq: u64,
    kept: BTreeMap<MessageId, Vec<Frame>>,
}

/// A solver's answer that cannot be sent.
#[derive(Debug, PartialEq, Eq, thiserror::Error)]
pub enum OutputError {
    /// The plan promises it and the plugin did not give it.
    #[error("the plugin gave no {what} on `{key}`")]
    Missing {
        /// What.
        what: &'static str,
        /// Stream.
        key: String,
    },
    /// A number is NaN or infinite.
    #[error("what the plugin gave on `{key}` has blown up: {error}")]
    NotFinite {
        /// Stream.
        key: String,
        /// Which number.
        error: PayloadError,
    },
}

impl Outbox {
    /// An empty outbox of participant `sender`.
    pub fn new(run: RunId, epoch: u32, sender: u16) -> Self {
        Self { run, epoch, sender, seq: 0, kept: BTreeMap::new() }
    }

    /// A probe on a stream.
    pub fn probe(&mut self, plan: &Plan, stream: StreamId) -> Frame {
        let origin = self.origin(plan, MessageId { stream, index: 0 });
        wire::probe(&origin, &mut self.seq)
    }

    /// Encodes statics.
    pub fn statics(&mut self, plan: &Plan, id: MessageId, statics: &SampleStatics) -> u64 {
        let (count, chunks) = wire::encode_statics(statics);
        self.keep(plan, id, count, chunks)
    }

    /// Encodes a boundary.
    pub fn boundary(&mut self, plan: &Plan, id: MessageId, form: BoundaryForm, state: &BoundaryState) -> u64 {
        let (count, chunks) = match state {
            BoundaryState::Proxy(record) => {
                let share = share_of(plan, id.stream);
                wire::encode_boundary(form, &BoundaryState::Proxy(crate::boundary::ProxyRecord { share, ..*record }))
            }
            BoundaryState::Samples(_) => wire::encode_boundary(form, state),
        };
        self.keep(plan, id, count, chunks)
    }

    /// Encodes what a step gives on one stream; answers the content hash and, for impulses, the impulses.
    ///
    /// # Errors
    /// [`OutputError`] when the plugin left it out or it has blown up.
    pub fn give<'o>(
        &mut self,
        plan: &Plan,
        id: MessageId,
        outputs: &'o Outputs,
    ) -> Result<(u64, Option<&'o Impulses>), OutputError> {
        let stream = &plan.streams[usize::from(id.stream)];
        let missing = |what| OutputError::Missing { what, key: stream.key.clone() };
        let blown = |error| OutputError::NotFinite { key: stream.key.clone(), error };
        match &stream.content {
            Content::Statics { .. } | Content::Visual { .. } => Err(missing("constants")),
            Content::Boundary { body, form } | Content::MidBoundary { body, form } => {
                let found = outputs.boundaries.iter().find(|b| &b.body == body);
                let state = &found.ok_or_else(|| missing("boundary"))?.state;
                fits(*form, state).then_some(()).ok_or_else(|| missing("boundary of the declared form"))?;
                if let BoundaryState::Samples(samples) = state {
                    wire::check_samples(samples).map_err(blown)?;
                }
                Ok((self.boundary(plan, id, *form, state), None))
            }
            Content::Impulses { interface, .. } => {
                let found = outputs.impulses.iter().find(|(i, _)| i == interface);
                let (_, impulses) = found.ok_or_else(|| missing("impulses"))?;
                wire::check_impulses(impulses).map_err(blown)?;
                let (count, chunks) = wire::encode_impulses(impulses);
                Ok((self.keep(plan, id, count, chunks), Some(impulses)))
            }
        }
    }

    /// Encodes a body that is drawn.
    ///
    /// # Errors
    /// [`OutputError`] when the plugin left it out, showed it in another form, or it has blown up.
    pub fn visual(
        &mut self,
        plan: &Plan,
        id: MessageId,
        visuals: &[(String, VisualState)],
    ) -> Result<u64, OutputError> {
        let stream = &plan.streams[usize::from(id.stream)];
        let missing = || OutputError::Missing { what: "visual state of the declared form", key: stream.key.clone() };
        let Content::Visual { body, form } = &stream.content else { return Err(missing()) };
        let found = visuals.iter().find(|(name, state)| name == body && state.has_form(*form));
        let (_, state) = found.ok_or_else(missing)?;
        wire::check_visual(state).map_err(|error| OutputError::NotFinite { key: stream.key.clone(), error })?;
        let (count, chunks) = wire::encode_visual(state);
        Ok(self.keep(plan, id, count, chunks))
    }

    /// Takes over a message that was published in an earlier life of the run.
    pub fn take_over(&mut self, plan: &Plan, message: &KeptMessage) -> u64 {
        let id = MessageId { stream: message.stream, index: message.index };
        self.keep(plan, id, message.count, wire::cut(&message.payload))
    }

    /// Count and payload of a message, if it is still kept.
    pub fn payload(&self, id: MessageId) -> Option<(u32, Vec<u8>)> {
        let frames = self.kept.get(&id)?;
        let count = wire::Header::read(frames.first()?).ok()?.count;
        let chunks: Vec<&[u8]> = frames.iter().map(|f| &f[wire::HEADER_BYTES..]).collect();
        Some((count, chunks.concat()))
    }

    /// Frames of a message, if it is still kept.
    pub fn frames(&self, id: MessageId) -> &[Frame] {
        self.kept.get(&id).map_or(&[], Vec::as_slice)
    }

    /// Centre of mass in a kept proxy record of this participant.
    pub fn centre(&self, id: MessageId) -> Option<Vec3> {
        wire::place(BoundaryForm::Proxy, &self.chunks(id)?, 0)
    }

    /// Payload of a kept message, in its chunks.
    pub(super) fn chunks(&self, id: MessageId) -> Option<Vec<&[u8]>> {
        self.kept.get(&id)?.iter().map(|f| f.get(wire::HEADER_BYTES..)).collect()
    }

    /// Forgets messages that nobody can need any more: everything two windows behind the settled one, statics apart.
    pub fn settle(&mut self, plan: &Plan, committed: u64) {
        self.kept.retain(|id, _| {
            let statics = matches!(plan.streams[usize::from(id.stream)].content, Content::Statics { .. });
            (statics && committed == 0) || id.index + 1 >= committed
        });
    }

    /// Forgets everything at once: a hand-made bug for the simulation.
    pub fn forget_all(&mut self) {
        self.kept.clear();
    }

    /// Messages kept.
    pub fn held(&self) -> usize {
        self.kept.len()
    }

    fn keep(&mut self, plan: &Plan, id: MessageId, count: u32, chunks: Vec<Vec<u8>>) -> u64 {
        let origin = self.origin(plan, id);
        let (frames, content) = wire::frames(&origin, count, chunks, &mut self.seq);
        self.kept.insert(id, frames);
        content
    }

    fn origin(&self, plan: &Plan, id: MessageId) -> Origin {
        let content = &plan.streams[usize::from(id.stream)].content;
        Origin {
            run: self.run,
            epoch: self.epoch,
            sender: self.sender,
            stream: id.stream,
            schema: wire::schema_hash(content),
            index: id.index,
        }
    }
}

/// Whether a boundary has the declared form.
pub(super) fn fits(form: BoundaryForm, state: &BoundaryState) -> bool {
    match (form, state) {
        (BoundaryForm::Proxy, BoundaryState::Proxy(_)) => true,
        (BoundaryForm::SamplesF32 { normals } | BoundaryForm::SamplesF64 { normals }, BoundaryState::Samples(s)) => {
            s.velocity.len() == s.position.len() && (!normals || s.normal.len() == s.position.len())
        }
        _ => false,
    }
}

/// Part of a rigid body that each resolver may count on: several resolvers together must not count it twice.
fn share_of(plan: &Plan, stream: StreamId) -> f64 {
    let shown = |i: &&Interface| i.carries_impulses() && i.from_b == stream;
    let resolvers: BTreeSet<_> = plan.interfaces.iter().filter(shown).map(|i| i.a.participant).collect();
    1.0 / resolvers.len().max(1) as f64
}
