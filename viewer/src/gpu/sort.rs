//! Sums before each element, and sorting by keys.

use wgpu::{Buffer, CommandEncoder};

use super::device::{Gpu, GpuError};
use super::kernels::{groups, record};

/// Elements that a work group sums.
const SUMMED: u64 = 1024;
/// Elements that a work group sorts.
const SORTED: u64 = 1024;
/// Bits a pass sorts by.
const DIGIT_BITS: u32 = 4;
const DIGITS: u64 = 1 << DIGIT_BITS;

/// Keys with a value each.
pub(super) struct Pairs {
    pub(super) keys: Buffer,
    pub(super) values: Buffer,
}

impl Gpu {
    /// Replaces each of the first `count` numbers by the sum of those before it.
    pub(super) fn sum_before(
        &self,
        encoder: &mut CommandEncoder,
        numbers: &Buffer,
        count: u64,
    ) -> Result<(), GpuError> {
        let blocks = count.div_ceil(SUMMED);
        let about = self.filled("counts", bytemuck::cast_slice(&[count as u32, 0, 0, 0]))?;
        let sums = self.zeros("sums", blocks)?;
        let buffers = [(0, &about), (1, numbers), (2, &sums)];
        record(&self.device, encoder, &self.kernels.scan_blocks, &buffers, groups(count, SUMMED));
        if blocks > 1 {
            self.sum_before(encoder, &sums, blocks)?;
            record(&self.device, encoder, &self.kernels.add_sums, &buffers, groups(count, SUMMED));
        }
        Ok(())
    }

    /// Sorts pairs by the lower `bits` of their keys; equal keys keep their order.
    pub(super) fn sort(
        &self,
        encoder: &mut CommandEncoder,
        mut pairs: Pairs,
        count: u64,
        bits: u32,
    ) -> Result<Pairs, GpuError> {
        let blocks = count.div_ceil(SORTED).max(1);
        let mut other = Pairs { keys: self.zeros("keys", count)?, values: self.zeros("values", count)? };
        let places = self.zeros("places", DIGITS * blocks)?;
        for shift in (0..bits).step_by(DIGIT_BITS as usize) {
            let numbers = [count as u32, shift, blocks as u32, 0];
            let pass = self.filled("pass", bytemuck::cast_slice(&numbers))?;
            let size = groups(count, SORTED);
            let counted = [(0, &pass), (1, &pairs.keys), (2, &places)];
            record(&self.device, encoder, &self.kernels.count_digits, &counted, size);
            self.sum_before(encoder, &places, DIGITS * blocks)?;
            let moved =
                [(0, &pass), (1, &pairs.keys), (2, &places), (3, &pairs.values), (4, &other.keys), (5, &other.values)];
            record(&self.device, encoder, &self.kernels.scatter, &moved, size);
            std::mem::swap(&mut pairs, &mut other);
        }
        Ok(pairs)
    }
}
