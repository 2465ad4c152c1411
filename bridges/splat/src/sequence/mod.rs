//! A frame of a sequence as what has changed since its first one: the compact sequence.
//!
//! The first frame is a whole splat file. What never changes (opacity, labels, degree) is there once; a later frame has
//! position, orientation and standard deviations of the Gaussians of which they changed, and their colours where light or
//! a turn changed them too. What did not change keeps its bits.
//!
//! Layout, little-endian: `CGSQ`, then three numbers of 32 bits: version 1, count of Gaussians, CRC-32 of all bytes of the
//! first frame's file. Behind them a zlib stream with five sections in this order: position, rotation, scale, colour,
//! higher bands. A section is the number n of Gaussians that changed (32 bits); where 0 < n < count a mask of
//! ⌈count / 8⌉ bytes, lowest bit first; then the rows of these Gaussians, stored by columns: all first bytes of the
//! rows, then all second ones. Rows: position three numbers of single precision, as they are; rotation 48 bits, the
//! number (w, x, y, z from 0) of the largest component above the other three in their order, each v of −√½ to √½ as
//! (v √2 + 1) / 2 · 32767 in 15 bits, the last one lowest; scale three logarithms in 16 bits signed, in units of 1/1024;
//! colour and bands 16 bits a number, in units of 1/4096.

mod pack;

use std::io::{Read, Write};

use flate2::Compression;
use flate2::Crc;
use flate2::read::ZlibDecoder;
use flate2::write::ZlibEncoder;

use self::pack::{Column, columns};
use crate::error::{Fault, SplatError};
use crate::splats::Splats;

/// Ending of the file of a later frame.
pub const ENDING: &str = "cgs";
const MAGIC: &[u8; 4] = b"CGSQ";
const VERSION: u32 = 1;
const HEADER: usize = 16;
const AGAIN: &str = "copy or download the file again";

/// The first frame of a sequence.
#[derive(Clone, Debug)]
pub struct First {
    splats: Splats,
    checksum: u32,
}

impl First {
    /// From what was decoded of the file of the first frame, and all bytes of that file.
    pub fn new(splats: Splats, file: &[u8]) -> First {
        let mut crc = Crc::new();
        crc.update(file);
        First { splats, checksum: crc.sum() }
    }

    /// Its Gaussians.
    pub fn splats(&self) -> &Splats {
        &self.splats
    }

    /// A later frame in the same axes as bytes; nothing where it has other Gaussians: another number, opacity or label.
    pub fn encode(&self, now: &Splats) -> Option<Vec<u8>> {
        let first = &self.splats;
        let same = now.is_consistent()
            && (now.len(), now.sh_degree, now.antialiased) == (first.len(), first.sh_degree, first.antialiased)
            && now.opacity_logits.iter().zip(&first.opacity_logits).all(|(a, b)| a.to_bits() == b.to_bits())
            && now.extras == first.extras;
        if !same {
            return None;
        }
        let mut out = MAGIC.to_vec();
        for number in [VERSION, now.len() as u32, self.checksum] {
            out.extend(number.to_le_bytes());
        }
        let mut zlib = ZlibEncoder::new(out, Compression::default());
        for column in columns(first) {
            // Writing to memory does not fail.
            let _ = zlib.write_all(&column.changed(first, now));
        }
        zlib.finish().ok()
    }

    /// The frame that was encoded.
    ///
    /// # Errors
    /// The bytes are no such frame, damaged, or of another sequence.
    pub fn decode(&self, bytes: &[u8]) -> Result<Splats, SplatError> {
        let header_fault = |what: String, advice: &str| SplatError::new(Fault::Header, "header", what, advice);
        if !is_frame(bytes) {
            return Err(SplatError::new(Fault::UnknownFormat, "header", "it does not begin with `CGSQ`", AGAIN));
        }
        let word = |at: usize| bytes.get(at..).and_then(|b| b.first_chunk()).map(|b| u32::from_le_bytes(*b));
        let early = || SplatError::truncated("header", HEADER as u64, bytes.len() as u64);
        let [version, count, checksum] = [4, 8, 12].map(|at| word(at).ok_or_else(early));
        let (version, count, checksum) = (version?, count?, checksum?);
        if version != VERSION {
            let what = format!("version {version} is not 1");
            return Err(SplatError::new(Fault::Unsupported, "header", what, "update cosplat"));
        }
        if (checksum, count as usize) != (self.checksum, self.splats.len()) {
            let what = format!("it is of another sequence: the first frame has {} Gaussians", self.splats.len());
            return Err(header_fault(what, "put the first frame of the same run beside it"));
        }
        let all: Vec<Column> = columns(&self.splats);
        let most: u64 = all.iter().map(|c| c.most(self.splats.len())).sum();
        let mut unpacked = Vec::new();
        // One more, so that what is too long is seen.
        let read = ZlibDecoder::new(&bytes[HEADER..]).take(most + 1).read_to_end(&mut unpacked);
        read.map_err(|e| SplatError::new(Fault::Compression, "zlib stream", e.to_string(), AGAIN))?;
        let mut rest = unpacked.as_slice();
        let mut out = self.splats.clone();
        for column in all {
            rest = column.restore(&mut out, rest)?;
        }
        if rest.is_empty() {
            return Ok(out);
        }
        Err(header_fault(format!("{} bytes are left over", rest.len()), AGAIN))
    }
}

/// Whether bytes begin as a frame of a compact sequence does.
pub fn is_frame(bytes: &[u8]) -> bool {
    bytes.starts_with(MAGIC)
}
