//! The little of ZIP that splat files use: members stored or deflated, found through the directory at the end.

use std::io::Read;

use flate2::read::DeflateDecoder;

use super::Limits;
use crate::error::{Fault, SplatError};

const DAMAGED: &str = "copy or download the file again";

/// An archive in memory.
pub(super) struct Zip<'a> {
    bytes: &'a [u8],
    members: Vec<Member<'a>>,
}

struct Member<'a> {
    name: &'a [u8],
    method: u16,
    packed: usize,
    unpacked: usize,
    offset: usize,
}

fn fault(place: &str, what: impl Into<String>) -> SplatError {
    SplatError::new(Fault::Header, place, what, DAMAGED)
}

fn u16_at(bytes: &[u8], at: usize) -> Option<u16> {
    Some(u16::from_le_bytes(*bytes.get(at..)?.first_chunk()?))
}

fn u32_at(bytes: &[u8], at: usize) -> Option<u32> {
    Some(u32::from_le_bytes(*bytes.get(at..)?.first_chunk()?))
}

impl<'a> Zip<'a> {
    /// Reads the directory.
    pub(super) fn open(bytes: &'a [u8]) -> Result<Zip<'a>, SplatError> {
        let end = bytes.windows(4).rposition(|w| w == b"PK\x05\x06");
        let end = end.ok_or_else(|| fault("end of the archive", "the directory of the archive is missing"))?;
        let members =
            directory(bytes, end).ok_or_else(|| fault("directory of the archive", "it is cut off or damaged"))?;
        Ok(Zip { bytes, members })
    }

    /// The content of a member.
    pub(super) fn member(&self, name: &str, limits: Limits) -> Result<Vec<u8>, SplatError> {
        let member = self.members.iter().find(|m| m.name == name.as_bytes());
        let member = member.ok_or_else(|| fault("directory of the archive", format!("member `{name}` is missing")))?;
        let packed = self.packed(member).ok_or_else(|| fault(name, "the member is cut off"))?;
        match member.method {
            0 if member.packed == member.unpacked => Ok(packed.to_vec()),
            8 => {
                limits.check(member.unpacked as u64, self.bytes.len())?;
                let mut out = Vec::new();
                let read = DeflateDecoder::new(packed).take(member.unpacked as u64).read_to_end(&mut out);
                read.map_err(|error| SplatError::new(Fault::Compression, name, error.to_string(), DAMAGED))?;
                Ok(out)
            }
            method => Err(fault(name, format!("method {method} of compression is not read"))),
        }
    }

    fn packed(&self, member: &Member<'_>) -> Option<&'a [u8]> {
        let local = self.bytes.get(member.offset..)?;
        if !local.starts_with(b"PK\x03\x04") {
            return None;
        }
        let start = 30 + usize::from(u16_at(local, 26)?) + usize::from(u16_at(local, 28)?);
        local.get(start..)?.get(..member.packed)
    }
}

fn directory(bytes: &[u8], end: usize) -> Option<Vec<Member<'_>>> {
    let count = u16_at(bytes, end + 10)?;
    let mut at = u32_at(bytes, end + 16)? as usize;
    let mut members = Vec::new();
    for _ in 0..count {
        let entry = bytes.get(at..)?;
        if !entry.starts_with(b"PK\x01\x02") {
            return None;
        }
        let length = |k: usize| u16_at(entry, k).map(usize::from);
        let name_end = 46 + length(28)?;
        members.push(Member {
            name: entry.get(46..name_end)?,
            method: u16_at(entry, 10)?,
            packed: u32_at(entry, 20)? as usize,
            unpacked: u32_at(entry, 24)? as usize,
            offset: u32_at(entry, 42)? as usize,
        });
        at += name_end + length(30)? + length(32)?;
    }
    Some(members)
}
