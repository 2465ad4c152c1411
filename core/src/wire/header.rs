//! The frame header: 96 bytes, checked cheapest first.

use bytemuck::{Pod, Zeroable};
use xxhash_rust::xxh3::{xxh3_64, xxh3_64_with_seed};

use crate::control::RunId;

/// First four bytes of every frame.
pub const MAGIC: u32 = u32::from_le_bytes(*b"CSPL");
/// Version of the header and of the payload layouts.
pub const VERSION: u16 = 1;
/// Size of a header.
pub const HEADER_BYTES: usize = size_of::<Header>();

/// Kind of a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Part of a message.
    Data = 0,
    /// Shows that the stream works; no payload.
    Probe = 1,
}

/// The header, as it is on the wire. Offsets are in `ARCHITECTURE.md` and in the golden fixtures.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Pod, Zeroable)]
#[repr(C)]
pub struct Header {
    /// [`MAGIC`].
    pub magic: u32,
    /// [`VERSION`].
    pub version: u16,
    /// [`Kind`].
    pub kind: u16,
    /// Identity of the run.
    pub run: RunId,
    /// Hash of the payload's layout.
    pub schema: u64,
    /// Incarnation of the coordinator.
    pub epoch: u32,
    /// Sender's place in the plan.
    pub sender: u16,
    /// Stream's place in the plan.
    pub stream: u16,
    /// Index of the message on its stream: the window it belongs to.
    pub index: u64,
    /// Iteration of the window.
    pub iteration: u32,
    /// Elements in the message.
    pub count: u32,
    /// Frames made by this sender before this one.
    pub seq: u64,
    /// Number of this chunk.
    pub chunk: u32,
    /// Chunks of the message.
    pub chunks: u32,
    /// Bytes of the whole payload.
    pub length: u64,
    /// xxh3-64 over the chunks' hashes: identity of the content.
    pub content: u64,
    /// xxh3-64 of this header with this field zero, seeded with the hash of the chunk.
    pub hash: u64,
}

/// Bytes that are no frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, thiserror::Error)]
pub enum HeaderError {
    /// Shorter than a header.
    #[error("shorter than a header")]
    Short,
    /// Not one of ours.
    #[error("wrong magic number")]
    Magic,
    /// Another version.
    #[error("wrong version")]
    Version,
    /// Unknown kind.
    #[error("unknown kind")]
    Kind,
    /// A bit is wrong somewhere.
    #[error("hash does not match")]
    Hash,
}

impl Header {
    /// Reads the header of a frame; the hash is checked apart, by [`Self::verify`].
    ///
    /// # Errors
    /// [`HeaderError`].
    pub fn read(frame: &[u8]) -> Result<Self, HeaderError> {
        let bytes = frame.get(..HEADER_BYTES).ok_or(HeaderError::Short)?;
        let header: Self = bytemuck::pod_read_unaligned(bytes);
        if header.magic != MAGIC {
            return Err(HeaderError::Magic);
        }
        if header.version != VERSION {
            return Err(HeaderError::Version);
        }
        if header.kind > Kind::Probe as u16 {
            return Err(HeaderError::Kind);
        }
        Ok(header)
    }

    /// Checks every bit of the frame; answers the hash of its chunk.
    ///
    /// # Errors
    /// [`HeaderError::Hash`]; [`HeaderError::Short`] for a frame without a header.
    pub fn verify(&self, frame: &[u8]) -> Result<u64, HeaderError> {
        let chunk_hash = xxh3_64(frame.get(HEADER_BYTES..).ok_or(HeaderError::Short)?);
        if self.sealed(chunk_hash).hash == self.hash { Ok(chunk_hash) } else { Err(HeaderError::Hash) }
    }

    /// The same header with its hash filled in.
    #[must_use]
    pub fn sealed(mut self, chunk_hash: u64) -> Self {
        self.hash = 0;
        self.hash = xxh3_64_with_seed(bytemuck::bytes_of(&self), chunk_hash);
        self
    }

    /// Whether this is a probe.
    pub fn is_probe(&self) -> bool {
        self.kind == Kind::Probe as u16
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn header_has_no_padding_and_a_fixed_size() {
        assert_eq!(HEADER_BYTES, 96);
    }
}
