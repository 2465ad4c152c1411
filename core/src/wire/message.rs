//! Cutting a payload into frames and putting it together again.

use std::sync::Arc;

use xxhash_rust::xxh3::xxh3_64;

use super::arrays::Writer;
use super::header::{HEADER_BYTES, Header, Kind, MAGIC, VERSION};
use crate::control::RunId;
use crate::participant::Frame;

/// Largest payload of a frame. Small enough that the parts of a large message overlap on their way.
pub const CHUNK_BYTES: usize = 256 * 1024;

/// Everything in a header that does not depend on the content.
#[derive(Clone, Copy, Debug)]
pub struct Origin {
    /// Run.
    pub run: RunId,
    /// Incarnation of the coordinator.
    pub epoch: u32,
    /// Sender.
    pub sender: u16,
    /// Stream.
    pub stream: u16,
    /// Hash of the payload's layout.
    pub schema: u64,
    /// Index on the stream.
    pub index: u64,
}

impl Origin {
    fn header(&self, kind: Kind, seq: u64) -> Header {
        Header {
            magic: MAGIC,
            version: VERSION,
            kind: kind as u16,
            run: self.run,
            schema: self.schema,
            epoch: self.epoch,
            sender: self.sender,
            stream: self.stream,
            index: self.index,
            iteration: 0,
            count: 0,
            seq,
            chunk: 0,
            chunks: 1,
            length: 0,
            content: 0,
            hash: 0,
        }
    }
}

/// Frames of one message and its content hash. Each of `chunks` holds [`HEADER_BYTES`] free bytes, then its part of the
/// payload, and becomes a frame without a copy. `seq` counts the sender's frames and is advanced.
pub fn frames(origin: &Origin, count: u32, mut chunks: Vec<Vec<u8>>, seq: &mut u64) -> (Vec<Frame>, u64) {
    let hashes: Vec<u64> = chunks.iter().map(|chunk| xxh3_64(&chunk[HEADER_BYTES..])).collect();
    let length: usize = chunks.iter().map(|chunk| chunk.len() - HEADER_BYTES).sum();
    let content = xxh3_64(bytemuck::cast_slice(&hashes));
    for ((chunk, hash), number) in chunks.iter_mut().zip(&hashes).zip(0..) {
        let header = Header {
            count,
            chunk: number,
            chunks: hashes.len() as u32,
            length: length as u64,
            content,
            ..origin.header(Kind::Data, *seq)
        };
        chunk[..HEADER_BYTES].copy_from_slice(bytemuck::bytes_of(&header.sealed(*hash)));
        *seq += 1;
    }
    (chunks.into_iter().map(Arc::new).collect(), content)
}

/// A payload in chunks, each behind room for a header; an empty payload is one empty chunk.
pub fn cut(payload: &[u8]) -> Vec<Vec<u8>> {
    let mut out = Writer::new(payload.len());
    out.bytes(payload);
    out.finish()
}

/// A frame that shows a stream works.
pub fn probe(origin: &Origin, seq: &mut u64) -> Frame {
    let header = origin.header(Kind::Probe, *seq).sealed(xxh3_64(&[]));
    *seq += 1;
    Arc::new(bytemuck::bytes_of(&header).to_vec())
}

/// A message that is arriving or has arrived.
#[derive(Clone, Debug)]
pub struct Message {
    header: Header,
    chunks: Vec<Option<(Frame, u64)>>,
    received: usize,
}

impl Message {
    /// Most chunks a message may have: 1 GiB of payload.
    const MOST_CHUNKS: u32 = 4096;

    /// A message of which one frame has come, or nothing if the header's numbers do not fit each other.
    ///
    /// Nothing is allocated for the payload here, only a slot for each chunk: 96 KiB for the longest message.
    pub fn begin(header: &Header) -> Option<Self> {
        let needed = header.length.div_ceil(CHUNK_BYTES as u64).max(1);
        let fits = header.chunks <= Self::MOST_CHUNKS && u64::from(header.chunks) == needed;
        if !fits || header.chunk >= header.chunks {
            return None;
        }
        Some(Self { header: *header, chunks: vec![None; header.chunks as usize], received: 0 })
    }

    /// Takes a verified frame. Answers false if it does not belong or, with `once`, if that chunk is there already.
    pub fn take(&mut self, header: &Header, frame: Frame, chunk_hash: u64, once: bool) -> bool {
        let same = header.length == self.header.length
            && header.count == self.header.count
            && header.content == self.header.content
            && header.chunks == self.header.chunks;
        let at = header.chunk as usize;
        let last = at + 1 == self.chunks.len();
        let size = if last { self.last_chunk_bytes() } else { CHUNK_BYTES };
        let Some(slot) = self.chunks.get_mut(at) else { return false };
        if !same || frame.len().checked_sub(HEADER_BYTES) != Some(size) || (slot.is_some() && once) {
            return false;
        }
        *slot = Some((frame, chunk_hash));
        self.received += 1;
        true
    }

    fn last_chunk_bytes(&self) -> usize {
        self.header.length as usize - (self.chunks.len() - 1) * CHUNK_BYTES
    }

    /// Whether nothing has been taken yet.
    pub fn is_empty(&self) -> bool {
        self.received == 0
    }

    /// Whether all chunks are there.
    pub fn is_complete(&self) -> bool {
        self.received >= self.chunks.len()
    }

    /// Content hash, recomputed from the chunks; `None` if a chunk is missing or the sender's differs.
    pub fn content(&self) -> Option<u64> {
        let hashes: Option<Vec<u64>> = self.chunks.iter().map(|c| c.as_ref().map(|(_, hash)| *hash)).collect();
        let content = xxh3_64(bytemuck::cast_slice(&hashes?));
        (content == self.header.content).then_some(content)
    }

    /// Elements in the message, as the sender says.
    pub fn count(&self) -> usize {
        self.header.count as usize
    }

    /// The payload, chunk by chunk, as far as it is there.
    pub fn chunks(&self) -> Vec<&[u8]> {
        self.chunks.iter().flatten().map(|(frame, _)| &frame[HEADER_BYTES..]).collect()
    }
}
