//! Bytes of a stored point: what it is first, then postcard, the checksum of all of it last.

use serde::{Deserialize, Serialize};
use xxhash_rust::xxh3::xxh3_128;

use super::CheckpointError;

/// First bytes.
const MAGIC: [u8; 4] = *b"CSCP";
/// Version of the content.
pub(super) const VERSION: u16 = 1;
/// Bytes before the content: magic, version, kind.
const HEAD_BYTES: usize = 8;

/// What is stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    Snapshot = 1,
    Checkpoint = 2,
}

/// Bytes of `content`.
pub(super) fn seal<T: Serialize>(kind: Kind, content: &T) -> Vec<u8> {
    let mut bytes = Vec::with_capacity(HEAD_BYTES);
    bytes.extend_from_slice(&MAGIC);
    bytes.extend_from_slice(&VERSION.to_le_bytes());
    bytes.extend_from_slice(&(kind as u16).to_le_bytes());
    // Serialising plain data into a growing vector cannot fail; what is empty would be refused by `open`.
    let mut bytes = postcard::to_extend(content, bytes).unwrap_or_default();
    let sum = xxh3_128(&bytes);
    bytes.extend_from_slice(&sum.to_le_bytes());
    bytes
}

/// Reads what [`seal`] wrote. No list is allocated before the bytes show that they can hold it.
pub(super) fn open<T: for<'a> Deserialize<'a>>(kind: Kind, bytes: &[u8]) -> Result<T, CheckpointError> {
    if bytes.get(..MAGIC.len()) != Some(&MAGIC) {
        return Err(CheckpointError::Foreign);
    }
    let (body, sum) = bytes.split_last_chunk::<16>().ok_or(CheckpointError::Checksum)?;
    let &[_, _, _, _, v0, v1, k0, k1] = body.first_chunk::<HEAD_BYTES>().ok_or(CheckpointError::Checksum)?;
    let found = u16::from_le_bytes([v0, v1]);
    if found != VERSION {
        return Err(CheckpointError::Version { found });
    }
    if xxh3_128(body) != u128::from_le_bytes(*sum) {
        return Err(CheckpointError::Checksum);
    }
    if u16::from_le_bytes([k0, k1]) != kind as u16 {
        return Err(CheckpointError::Malformed(format!("it is no {kind:?}").to_lowercase()));
    }
    match postcard::take_from_bytes(&body[HEAD_BYTES..]) {
        Ok((content, [])) => Ok(content),
        Ok((_, left)) => Err(CheckpointError::Malformed(format!("{} bytes are left over", left.len()))),
        Err(error) => Err(CheckpointError::Malformed(error.to_string())),
    }
}
