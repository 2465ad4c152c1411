//! One attribute of all Gaussians that changed.

use crate::error::{Fault, SplatError};
use crate::splats::Splats;

/// Units in which logarithms of standard deviations are counted: half of one is 0.05 %.
const SCALE: f64 = 1024.0;
/// The same for colours and bands: half of one is 3 · 10⁻⁵ of the range of a colour.
const COLOUR: f64 = 4096.0;
/// Steps of a component of a quaternion from −√½ to √½.
const STEPS: f64 = 32_767.0;

/// An attribute: how many bytes a Gaussian has of it, and how a Gaussian is written and read.
pub(super) struct Column {
    name: &'static str,
    width: usize,
    same: fn(&Splats, &Splats, usize) -> bool,
    write: fn(&Splats, usize, &mut Vec<u8>),
    read: fn(&mut Splats, usize, &[u8]),
}

/// The attributes, in the order of the file.
pub(super) fn columns(first: &Splats) -> Vec<Column> {
    vec![
        Column {
            name: "position",
            width: 12,
            same: |a, b, i| bits(&a.positions[i]) == bits(&b.positions[i]),
            write: |s, i, out| out.extend(s.positions[i].iter().flat_map(|v| v.to_le_bytes())),
            read: |s, i, row| {
                for (v, b) in s.positions[i].iter_mut().zip(row.as_chunks::<4>().0) {
                    *v = f32::from_le_bytes(*b);
                }
            },
        },
        Column {
            name: "rotation",
            width: 6,
            same: |a, b, i| bits(&a.rotations[i]) == bits(&b.rotations[i]),
            write: |s, i, out| out.extend(&pack_quaternion(s.rotations[i]).to_le_bytes()[..6]),
            read: |s, i, row| {
                let mut bytes = [0; 8];
                bytes[..6].copy_from_slice(row);
                s.rotations[i] = quaternion(u64::from_le_bytes(bytes));
            },
        },
        Column {
            name: "scale",
            width: 6,
            same: |a, b, i| bits(&a.log_scales[i]) == bits(&b.log_scales[i]),
            write: |s, i, out| put(&[s.log_scales[i]], SCALE, out),
            read: |s, i, row| take(&mut s.log_scales[i..=i], SCALE, row),
        },
        Column {
            name: "colour",
            width: 6,
            same: |a, b, i| bits(&a.sh_dc[i]) == bits(&b.sh_dc[i]),
            write: |s, i, out| put(&[s.sh_dc[i]], COLOUR, out),
            read: |s, i, row| take(&mut s.sh_dc[i..=i], COLOUR, row),
        },
        Column {
            name: "bands",
            width: 6 * first.coefficients(),
            same: |a, b, i| a.rest(i).iter().map(bits).eq(b.rest(i).iter().map(bits)),
            write: |s, i, out| put(s.rest(i), COLOUR, out),
            read: |s, i, row| {
                let k = s.coefficients();
                take(&mut s.sh_rest[i * k..(i + 1) * k], COLOUR, row);
            },
        },
    ]
}

impl Column {
    /// Bytes at most for so many Gaussians.
    pub(super) fn most(&self, count: usize) -> u64 {
        4 + count.div_ceil(8) as u64 + count as u64 * self.width as u64
    }

    /// The section of this attribute.
    pub(super) fn changed(&self, first: &Splats, now: &Splats) -> Vec<u8> {
        let own: Vec<usize> = (0..now.len()).filter(|&i| !(self.same)(first, now, i)).collect();
        let mut out = (own.len() as u32).to_le_bytes().to_vec();
        if own.is_empty() {
            return out;
        }
        if own.len() < now.len() {
            let mut mask = vec![0_u8; now.len().div_ceil(8)];
            for i in &own {
                mask[i / 8] |= 1 << (i % 8);
            }
            out.extend(mask);
        }
        let mut rows = Vec::with_capacity(own.len() * self.width);
        for &i in &own {
            (self.write)(now, i, &mut rows);
        }
        out.extend((0..self.width).flat_map(|k| rows.iter().skip(k).step_by(self.width)));
        out
    }

    /// Reads the section at the start of `bytes` into `out`, and gives what is behind it.
    pub(super) fn restore<'a>(&self, out: &mut Splats, bytes: &'a [u8]) -> Result<&'a [u8], SplatError> {
        let early = |needs: usize| SplatError::truncated(self.name, needs as u64, bytes.len() as u64);
        let (head, rest) = bytes.split_first_chunk().ok_or_else(|| early(4))?;
        let (changed, count) = (u32::from_le_bytes(*head) as usize, out.len());
        if changed == 0 {
            return Ok(rest);
        }
        let masked = if changed < count { count.div_ceil(8) } else { 0 };
        let (mask, rest) = rest.split_at_checked(masked).ok_or_else(|| early(4 + masked))?;
        let own: Vec<usize> = (0..count).filter(|i| masked == 0 || mask[i / 8] >> (i % 8) & 1 == 1).collect();
        if own.len() != changed {
            let what = format!("{changed} Gaussians changed, and {} of {count} are named", own.len());
            return Err(SplatError::new(Fault::Header, self.name, what, super::AGAIN));
        }
        let length = changed * self.width;
        let (columns, rest) = rest.split_at_checked(length).ok_or_else(|| early(4 + masked + length))?;
        let mut row = vec![0; self.width];
        for (n, &i) in own.iter().enumerate() {
            for (k, byte) in row.iter_mut().enumerate() {
                *byte = columns[k * changed + n];
            }
            (self.read)(out, i, &row);
        }
        Ok(rest)
    }
}

fn bits<const N: usize>(numbers: &[f32; N]) -> [u32; N] {
    numbers.map(f32::to_bits)
}

/// Numbers in 16 bits; what is beyond the range is cut to it.
fn put(numbers: &[[f32; 3]], unit: f64, out: &mut Vec<u8>) {
    let one = |v: &f32| ((f64::from(*v) * unit).round() as i16).to_le_bytes();
    out.extend(numbers.iter().flatten().flat_map(one));
}

fn take(numbers: &mut [[f32; 3]], unit: f64, row: &[u8]) {
    for (v, b) in numbers.iter_mut().flatten().zip(row.as_chunks::<2>().0) {
        *v = (f64::from(i16::from_le_bytes(*b)) / unit) as f32;
    }
}

/// Number of the largest component, and the three others.
fn pack_quaternion(q: [f32; 4]) -> u64 {
    let q = q.map(f64::from);
    let length = q.iter().map(|v| v * v).sum::<f64>().sqrt();
    let unit = if length > 0.0 && length.is_finite() { q.map(|v| v / length) } else { [1.0, 0.0, 0.0, 0.0] };
    let largest = (1..4).fold(0, |best, i| if unit[i].abs() > unit[best].abs() { i } else { best });
    // q and −q are the same rotation: the component that is left out is taken as positive.
    let sign = unit[largest].signum();
    (0..4).filter(|&i| i != largest).fold(largest as u64, |packed, i| {
        let part = f64::midpoint(sign * unit[i] * std::f64::consts::SQRT_2, 1.0);
        packed << 15 | (part * STEPS).round().clamp(0.0, STEPS) as u64
    })
}

fn quaternion(mut packed: u64) -> [f32; 4] {
    let largest = (packed >> 45 & 3) as usize;
    let mut q = [0.0_f64; 4];
    for i in (0..4).rev().filter(|&i| i != largest) {
        q[i] = ((packed & 0x7fff) as f64 / STEPS * 2.0 - 1.0) * std::f64::consts::FRAC_1_SQRT_2;
        packed >>= 15;
    }
    q[largest] = (1.0 - q.iter().map(|v| v * v).sum::<f64>()).max(0.0).sqrt();
    q.map(|v| v as f32)
}
