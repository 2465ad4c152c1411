//! Planar arrays, each starting at a multiple of 16 bytes.

use super::header::HEADER_BYTES;
use super::message::CHUNK_BYTES;
use crate::boundary::{Vec3, add, sub};

/// Elements that are converted at once.
const BLOCK: usize = 256;

/// Bytes up to the start of the next array; [`usize::MAX`] where there is no such number.
pub(super) fn aligned(bytes: usize) -> usize {
    bytes.checked_next_multiple_of(16).unwrap_or(usize::MAX)
}

/// Writes arrays into chunks, each behind room for a header, so that a frame needs no copy of them.
pub(super) struct Writer {
    chunks: Vec<Vec<u8>>,
    written: usize,
    /// Bytes for which there should be room without growing.
    expected: usize,
}

impl Writer {
    pub(super) fn new(expected: usize) -> Self {
        let mut writer = Self { chunks: Vec::with_capacity(expected.div_ceil(CHUNK_BYTES)), written: 0, expected };
        writer.begin_chunk();
        writer
    }

    /// The chunks: all full but the last, and at least one.
    pub(super) fn finish(self) -> Vec<Vec<u8>> {
        self.chunks
    }

    fn begin_chunk(&mut self) {
        let room = self.expected.saturating_sub(self.written).min(CHUNK_BYTES);
        let mut chunk = Vec::with_capacity(HEADER_BYTES + room);
        chunk.resize(HEADER_BYTES, 0);
        self.chunks.push(chunk);
    }

    /// Appends bytes and no padding.
    pub(super) fn bytes(&mut self, mut bytes: &[u8]) {
        while !bytes.is_empty() {
            if self.chunks.last().is_none_or(|chunk| chunk.len() == HEADER_BYTES + CHUNK_BYTES) {
                self.begin_chunk();
            }
            let Some(chunk) = self.chunks.last_mut() else { return };
            let (now, later) = bytes.split_at(bytes.len().min(HEADER_BYTES + CHUNK_BYTES - chunk.len()));
            chunk.extend_from_slice(now);
            self.written += now.len();
            bytes = later;
        }
    }

    pub(super) fn raw(&mut self, bytes: &[u8]) {
        self.bytes(bytes);
        self.align();
    }

    fn align(&mut self) {
        let padding = aligned(self.written) - self.written;
        self.bytes(&[0; 16][..padding]);
    }

    /// Single precision relative to `origin`, through a block that stays in the first cache.
    pub(super) fn narrow(&mut self, values: &[Vec3], origin: Vec3) {
        let mut block = [[0f32; 3]; BLOCK];
        for part in values.chunks(block.len()) {
            for (to, &from) in block.iter_mut().zip(part) {
                *to = sub(from, origin).map(|v| v as f32);
            }
            self.bytes(bytemuck::cast_slice(&block[..part.len()]));
        }
        self.align();
    }
}

/// Reads arrays in the order they were written, from chunks whose length has been checked.
pub(super) struct Reader<'a> {
    chunks: std::slice::Iter<'a, &'a [u8]>,
    /// What is left of the chunk at hand.
    rest: &'a [u8],
}

impl<'a> Reader<'a> {
    pub(super) fn new(chunks: &'a [&'a [u8]]) -> Self {
        Self { chunks: chunks.iter(), rest: &[] }
    }

    /// The next bytes, across the borders of chunks. What is not there leaves `into` as it is.
    fn fill(&mut self, mut into: &mut [u8]) {
        while !into.is_empty() {
            if self.rest.is_empty() {
                let Some(next) = self.chunks.next() else { return };
                self.rest = next;
                continue;
            }
            let (now, later) = self.rest.split_at(into.len().min(self.rest.len()));
            let (filled, left) = into.split_at_mut(now.len());
            filled.copy_from_slice(now);
            (self.rest, into) = (later, left);
        }
    }

    /// Hands on an array in blocks that stay in the first cache.
    fn blocks<T: bytemuck::Pod>(&mut self, count: usize, mut each: impl FnMut(&[T])) {
        let mut block = [T::zeroed(); BLOCK];
        let mut left = count;
        while left > 0 {
            let part = &mut block[..left.min(BLOCK)];
            self.fill(bytemuck::cast_slice_mut(part));
            each(part);
            left -= part.len();
        }
        let bytes = count * size_of::<T>();
        self.fill(&mut [0; 16][..aligned(bytes) - bytes]);
    }

    pub(super) fn list<T: bytemuck::Pod>(&mut self, count: usize) -> Vec<T> {
        let mut list = Vec::with_capacity(count);
        self.blocks(count, |block: &[T]| list.extend_from_slice(block));
        list
    }

    pub(super) fn widened(&mut self, count: usize, origin: Vec3) -> Vec<Vec3> {
        let mut list = Vec::with_capacity(count);
        self.blocks(count, |block: &[[f32; 3]]| list.extend(block.iter().map(|v| add(v.map(f64::from), origin))));
        list
    }
}
