//! Header and decompression, with every length checked before anything is allocated.

use std::io::Read;

use flate2::read::MultiGzDecoder;
use ruzstd::decoding::StreamingDecoder;

use crate::error::{Fault, SplatError};
use crate::format::Limits;
use crate::splats::coefficients;

/// `NGSP`.
pub(super) const MAGIC: u32 = 0x5053_474e;
const OLD_HEADER: usize = 16;
const NEW_HEADER: usize = 32;
/// A zstd window is this at least, because encoders choose it before they know the length.
const ZSTD_WINDOW: u64 = 8 << 20;
const DAMAGED: &str = "copy or download the file again";

/// What the header says.
#[derive(Clone, Copy, Debug)]
pub(super) struct Header {
    pub(super) version: u32,
    pub(super) count: u32,
    pub(super) degree: u8,
    pub(super) fractional_bits: u8,
    pub(super) flags: u8,
}

impl Header {
    /// Bytes of the six attributes: positions, alphas, colours, scales, rotations, higher bands.
    fn lengths(&self) -> [u64; 6] {
        let n = u64::from(self.count);
        let rotation = if self.version >= 3 { 4 } else { 3 };
        let position = if self.version >= 2 { 9 } else { 6 };
        [position * n, n, 3 * n, 3 * n, rotation * n, 3 * coefficients(self.degree) as u64 * n]
    }
}

/// The unpacked attributes.
pub(super) struct Packed {
    pub(super) header: Header,
    /// All of them, one behind the other.
    bytes: Vec<u8>,
}

impl Packed {
    /// The six attributes, each of its length.
    pub(super) fn attributes(&self) -> Result<[&[u8]; 6], SplatError> {
        let mut rest = &self.bytes[..];
        let mut parts = [&[][..]; 6];
        for (part, length) in parts.iter_mut().zip(self.header.lengths()) {
            let split = rest.split_at_checked(length as usize);
            (*part, rest) = split.ok_or_else(|| SplatError::truncated("attributes", length, rest.len() as u64))?;
        }
        Ok(parts)
    }
}

fn header_fault(what: impl Into<String>) -> SplatError {
    SplatError::new(Fault::Header, "header", what, "write the file again with the tool it came from")
}

fn u32_at(bytes: &[u8], at: usize) -> Option<u32> {
    Some(u32::from_le_bytes(*bytes.get(at..)?.first_chunk()?))
}

fn u64_at(bytes: &[u8], at: usize) -> Option<u64> {
    Some(u64::from_le_bytes(*bytes.get(at..)?.first_chunk()?))
}

/// The first 16 bytes, the same in every version.
fn header(bytes: &[u8]) -> Result<Header, SplatError> {
    let early = || SplatError::truncated("header", OLD_HEADER as u64, bytes.len() as u64);
    let magic = u32_at(bytes, 0).ok_or_else(early)?;
    let version = u32_at(bytes, 4).ok_or_else(early)?;
    let count = u32_at(bytes, 8).ok_or_else(early)?;
    let &[degree, fractional_bits, flags, _] = bytes.get(12..16).and_then(|b| b.first_chunk()).ok_or_else(early)?;
    if magic != MAGIC {
        return Err(header_fault("the unpacked data does not begin with `NGSP`"));
    }
    if !(1..=4).contains(&version) {
        let what = format!("version {version} is not 1, 2, 3 or 4");
        return Err(SplatError::new(Fault::Unsupported, "header", what, "write the file again as version 3 or 4"));
    }
    if degree > 4 {
        return Err(header_fault(format!("degree {degree} of the spherical harmonics is not 0 to 4")));
    }
    if fractional_bits > 24 {
        return Err(header_fault(format!("{fractional_bits} fractional bits do not fit a number of 24 bits")));
    }
    Ok(Header { version, count, degree, fractional_bits, flags })
}

/// Unpacks a file of any version.
pub(super) fn open(bytes: &[u8], limits: Limits) -> Result<Packed, SplatError> {
    if bytes.starts_with(&[0x1f, 0x8b]) {
        return open_gzip(bytes, limits);
    }
    let header = header(bytes)?;
    if header.version >= 4 {
        return open_streams(bytes, header, limits);
    }
    // The same layout without compression: some tools write it.
    let total: u64 = header.lengths().iter().sum();
    let body = &bytes[OLD_HEADER..];
    if total > body.len() as u64 {
        return Err(SplatError::truncated("attributes", total, body.len() as u64));
    }
    Ok(Packed { header, bytes: body[..total as usize].to_vec() })
}

fn open_gzip(bytes: &[u8], limits: Limits) -> Result<Packed, SplatError> {
    let damaged = |error: &std::io::Error| SplatError::new(Fault::Compression, "gzip data", error.to_string(), DAMAGED);
    let mut stream = MultiGzDecoder::new(bytes);
    let mut head = Vec::with_capacity(OLD_HEADER);
    stream.by_ref().take(OLD_HEADER as u64).read_to_end(&mut head).map_err(|e| damaged(&e))?;
    let header = header(&head)?;
    if header.version > 3 {
        return Err(header_fault("version 4 is never inside gzip"));
    }
    let total: u64 = header.lengths().iter().sum();
    limits.check(total, bytes.len())?;
    let mut unpacked = Vec::new();
    // Grows with what really comes out, never with what is promised.
    stream.take(total).read_to_end(&mut unpacked).map_err(|e| damaged(&e))?;
    if (unpacked.len() as u64) < total {
        return Err(SplatError::truncated("unpacked attributes", total, unpacked.len() as u64));
    }
    Ok(Packed { header, bytes: unpacked })
}

/// Version 4: a table of (packed, unpacked) lengths at `toc`, then the streams.
fn open_streams(bytes: &[u8], header: Header, limits: Limits) -> Result<Packed, SplatError> {
    let early = || SplatError::truncated("header", NEW_HEADER as u64, bytes.len() as u64);
    let streams = usize::from(*bytes.get(15).ok_or_else(early)?);
    let toc = u32_at(bytes, 16).ok_or_else(early)? as usize;
    if toc < NEW_HEADER {
        return Err(header_fault(format!("the table of streams begins inside the header, at byte {toc}")));
    }
    let lengths = header.lengths();
    let needed = lengths.len() - usize::from(header.degree == 0);
    if streams < needed {
        return Err(header_fault(format!("{streams} streams are there and {needed} are needed")));
    }
    limits.check(lengths.iter().sum(), bytes.len())?;
    let mut at = toc + 16 * streams;
    let mut unpacked = Vec::new();
    for (k, &expected) in lengths.iter().enumerate().take(needed) {
        let place = || format!("stream {k}");
        let row = toc + 16 * k;
        let (Some(packed), Some(promised)) = (u64_at(bytes, row), u64_at(bytes, row + 8)) else {
            return Err(SplatError::truncated("table of streams", (toc + 16 * streams) as u64, bytes.len() as u64));
        };
        if promised != expected {
            let what = format!("it unpacks to {promised} bytes and {} Gaussians need {expected}", header.count);
            return Err(SplatError::new(Fault::Header, place(), what, DAMAGED));
        }
        let end = usize::try_from(packed).ok().and_then(|n| at.checked_add(n));
        let stream = end.and_then(|end| bytes.get(at..end));
        let stream =
            stream.ok_or_else(|| SplatError::truncated(place(), packed, bytes.len().saturating_sub(at) as u64))?;
        unpack(stream, expected, &mut unpacked)
            .map_err(|what| SplatError::new(Fault::Compression, place(), what, DAMAGED))?;
        at += stream.len();
    }
    Ok(Packed { header, bytes: unpacked })
}

/// Appends exactly `expected` bytes of a zstd stream.
fn unpack(stream: &[u8], expected: u64, out: &mut Vec<u8>) -> Result<(), String> {
    if expected == 0 {
        return Ok(());
    }
    let window = ZSTD_WINDOW.max(expected.saturating_mul(2));
    let before = out.len() as u64;
    let decoder = StreamingDecoder::new_with_max_window_size(stream, window).map_err(|error| error.to_string())?;
    decoder.take(expected).read_to_end(out).map_err(|error| error.to_string())?;
    let got = out.len() as u64 - before;
    if got == expected { Ok(()) } else { Err(format!("{got} bytes came out and {expected} are needed")) }
}
