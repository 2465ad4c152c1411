//! Planar arrays, each starting at a multiple of 16 bytes.

use super::header::HEADER_BYTES;
use crate::boundary::{Vec3, add, sub};

/// Bytes up to the start of the next array; [`usize::MAX`] where there is no such number.
pub(super) fn aligned(bytes: usize) -> usize {
    bytes.checked_next_multiple_of(16).unwrap_or(usize::MAX)
}

/// Writes arrays behind the room for a header.
pub(super) struct Writer(pub(super) Vec<u8>);

impl Writer {
    pub(super) fn new(payload: usize) -> Self {
        let mut bytes = Vec::with_capacity(HEADER_BYTES + payload);
        bytes.resize(HEADER_BYTES, 0);
        Self(bytes)
    }

    pub(super) fn raw(&mut self, bytes: &[u8]) {
        self.0.extend_from_slice(bytes);
        self.align();
    }

    fn align(&mut self) {
        let payload = self.0.len() - HEADER_BYTES;
        self.0.resize(HEADER_BYTES + aligned(payload), 0);
    }

    /// Single precision relative to `origin`, through a block that stays in the first cache.
    pub(super) fn narrow(&mut self, values: &[Vec3], origin: Vec3) {
        let mut block = [[0f32; 3]; 256];
        for part in values.chunks(block.len()) {
            for (to, &from) in block.iter_mut().zip(part) {
                *to = sub(from, origin).map(|v| v as f32);
            }
            self.0.extend_from_slice(bytemuck::cast_slice(&block[..part.len()]));
        }
        self.align();
    }
}

/// Reads arrays in the order they were written, from bytes whose length has been checked.
pub(super) struct Reader<'a>(pub(super) &'a [u8]);

impl<'a> Reader<'a> {
    fn take(&mut self, bytes: usize) -> &'a [u8] {
        let (head, tail) = self.0.split_at(aligned(bytes).min(self.0.len()));
        self.0 = tail;
        &head[..bytes.min(head.len())]
    }

    pub(super) fn list<T: bytemuck::Pod>(&mut self, count: usize) -> Vec<T> {
        bytemuck::pod_collect_to_vec(self.take(count * size_of::<T>()))
    }

    pub(super) fn widened(&mut self, count: usize, origin: Vec3) -> Vec<Vec3> {
        let narrow = self.take(count * 12);
        narrow
            .chunks_exact(12)
            .map(|c| add(bytemuck::pod_read_unaligned::<[f32; 3]>(c).map(f64::from), origin))
            .collect()
    }
}
