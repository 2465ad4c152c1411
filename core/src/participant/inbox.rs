//! What has arrived for a participant: checked, put together, each message once.

use std::collections::BTreeMap;

use super::Frame;
use crate::checks::{Check, Checks};
use crate::control::RunId;
use crate::plan::schedule::MessageId;
use crate::plan::{Plan, StreamId};
use crate::wire::{Header, HeaderError, Message, schema_hash};

/// Why a frame was not taken. Counted, never an error: what matters is asked for again.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Reject {
    /// Not a frame.
    Header(HeaderError),
    /// Of another run.
    Run,
    /// Of another incarnation.
    Epoch,
    /// Of a stream that this participant does not read.
    Stream,
    /// Not from the stream's sender.
    Sender,
    /// Another layout.
    Schema,
    /// Of an iteration that no scheme has.
    Iteration,
    /// Too early or too late.
    Fence,
    /// Already there.
    Duplicate,
    /// Its numbers contradict each other.
    Shape,
}

/// What a taken frame meant.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Taken {
    /// A probe on that stream.
    Probe(StreamId),
    /// Part of a message.
    Part,
    /// The last part of a message.
    Whole(MessageId),
}

/// Messages on all streams that a participant reads.
#[derive(Debug)]
pub struct Inbox {
    run: RunId,
    epoch: u32,
    streams: BTreeMap<StreamId, Incoming>,
    rejected: BTreeMap<Reject, u64>,
}

#[derive(Debug)]
struct Incoming {
    sender: u16,
    schema: u64,
    /// Lowest index still of use; set when a window is left behind.
    low: u64,
    messages: BTreeMap<u64, Message>,
    heard: bool,
}

/// Windows ahead of the lowest useful index that are kept. More than any participant can run ahead.
const FENCE: u64 = 8;

impl Inbox {
    /// An empty inbox for the streams that `who` reads.
    pub fn new(run: RunId, epoch: u32, plan: &Plan, who: u16) -> Self {
        let streams = plan.read_by(who).map(|(id, stream)| {
            let schema = schema_hash(&stream.content);
            (id, Incoming { sender: stream.from, schema, low: 0, messages: BTreeMap::new(), heard: false })
        });
        Self { run, epoch, streams: streams.collect(), rejected: BTreeMap::new() }
    }

    /// Takes a frame, or counts why not.
    pub fn take(&mut self, frame: Frame, checks: &impl Checks) -> Option<Taken> {
        match self.try_take(frame, checks) {
            Ok(taken) => Some(taken),
            Err(reject) => {
                *self.rejected.entry(reject).or_default() += 1;
                None
            }
        }
    }

    /// Cheapest checks first; the hash reads every byte and comes last.
    fn try_take(&mut self, frame: Frame, checks: &impl Checks) -> Result<Taken, Reject> {
        let header = Header::read(&frame).map_err(Reject::Header)?;
        if checks.on(Check::DataRun) && header.run != self.run {
            return Err(Reject::Run);
        }
        if checks.on(Check::DataEpoch) && header.epoch != self.epoch {
            return Err(Reject::Epoch);
        }
        let incoming = self.streams.get_mut(&header.stream).ok_or(Reject::Stream)?;
        if checks.on(Check::DataSender) && header.sender != incoming.sender {
            return Err(Reject::Sender);
        }
        if header.schema != incoming.schema {
            return Err(Reject::Schema);
        }
        // Explicit schemes compute each window once.
        if header.iteration != 0 {
            return Err(Reject::Iteration);
        }
        let fenced = header.index < incoming.low || header.index > incoming.low + FENCE;
        if checks.on(Check::DataFence) && !header.is_probe() && fenced {
            return Err(Reject::Fence);
        }
        let chunk_hash = match header.verify(&frame) {
            Ok(hash) => hash,
            Err(_) if !checks.on(Check::DataHash) => xxhash_rust::xxh3::xxh3_64(&frame[crate::wire::HEADER_BYTES..]),
            Err(error) => return Err(Reject::Header(error)),
        };
        incoming.heard = true;
        if header.is_probe() {
            return Ok(Taken::Probe(header.stream));
        }
        incoming.put(&header, frame, chunk_hash, checks)
    }

    /// The content hash of a message, if all of it is there.
    pub fn content(&self, id: MessageId) -> Option<u64> {
        self.message(id)?.content()
    }

    /// A message, if all of it is there.
    pub fn message(&self, id: MessageId) -> Option<&Message> {
        self.streams.get(&id.stream)?.messages.get(&id.index).filter(|m| m.is_complete())
    }

    /// The newest whole message of a stream.
    pub fn newest(&self, stream: StreamId) -> Option<MessageId> {
        let messages = &self.streams.get(&stream)?.messages;
        messages.iter().rev().find(|(_, m)| m.is_complete()).map(|(&index, _)| MessageId { stream, index })
    }

    /// Forgets what lies below `index` on `stream`.
    pub fn forget_below(&mut self, stream: StreamId, index: u64) {
        if let Some(incoming) = self.streams.get_mut(&stream) {
            incoming.low = incoming.low.max(index);
            let low = incoming.low;
            incoming.messages.retain(|&i, _| i >= low);
        }
    }

    /// Whether something valid has come on every stream.
    pub fn all_heard(&self) -> bool {
        self.streams.values().all(|s| s.heard)
    }

    /// Streams on which something valid has come.
    pub fn heard(&self) -> Vec<StreamId> {
        self.streams.iter().filter(|(_, s)| s.heard).map(|(&id, _)| id).collect()
    }

    /// Frames not taken, by reason.
    pub fn rejected(&self) -> &BTreeMap<Reject, u64> {
        &self.rejected
    }

    /// Messages held, whole or in part.
    pub fn held(&self) -> usize {
        self.streams.values().map(|s| s.messages.len()).sum()
    }
}

impl Incoming {
    fn put(&mut self, header: &Header, frame: Frame, chunk_hash: u64, checks: &impl Checks) -> Result<Taken, Reject> {
        let message = match self.messages.entry(header.index) {
            std::collections::btree_map::Entry::Occupied(there) => there.into_mut(),
            std::collections::btree_map::Entry::Vacant(free) => {
                free.insert(Message::begin(header).ok_or(Reject::Shape)?)
            }
        };
        let once = checks.on(Check::DataOnce);
        if once && message.is_complete() {
            return Err(Reject::Duplicate);
        }
        if !message.take(header, frame, chunk_hash, once) {
            // A first frame that does not even fit itself must not hold the place of the right one.
            if message.is_empty() {
                self.messages.remove(&header.index);
                return Err(Reject::Shape);
            }
            return Err(Reject::Duplicate);
        }
        let id = MessageId { stream: header.stream, index: header.index };
        if !message.is_complete() {
            return Ok(Taken::Part);
        }
        if once && message.content().is_none() {
            // Every part is sound, yet together they are not what was announced: ask for all of it again.
            self.messages.remove(&header.index);
            return Err(Reject::Shape);
        }
        Ok(Taken::Whole(id))
    }
}
