//! Bytes of the data plane: a fixed header, then aligned planar arrays, little-endian.
//!
//! A message is cut into chunks of at most [`CHUNK_BYTES`]; a frame is a header and one chunk. Every bit of a frame is
//! covered by its hash, and the content hash of a message follows from the hashes of its chunks, so that both are
//! computed in one pass.

mod arrays;
mod header;
mod message;
mod payload;
mod visual;

pub use header::{HEADER_BYTES, Header, HeaderError, Kind, MAGIC, VERSION};
pub use message::{CHUNK_BYTES, Message, Origin, cut, frames, probe};
pub use payload::{
    PayloadError, check_impulses, check_samples, decode_boundary, decode_impulses, decode_statics, encode_boundary,
    encode_impulses, encode_statics, payload_bytes, place, schema_hash, schema_text,
};
pub use visual::{check_visual, decode_visual, encode_visual};
