//! One Gaussian's bytes.

use crate::format::half::half_to_f32;

/// Largest magnitude of the three smaller components of a unit quaternion, √½.
const LARGEST_SMALL: f64 = std::f64::consts::FRAC_1_SQRT_2;

/// Three signed 24-bit fixed point numbers, least significant byte first.
pub(super) fn position(bytes: &[u8; 9], step: f64) -> [f32; 3] {
    [0, 3, 6].map(|at| {
        // Into the upper three bytes and back, so that the sign is extended.
        let wide = i32::from_le_bytes([0, bytes[at], bytes[at + 1], bytes[at + 2]]) >> 8;
        (f64::from(wide) * step) as f32
    })
}

/// Version 1: three numbers of half precision.
pub(super) fn half_position(bytes: [u8; 6]) -> [f32; 3] {
    [0, 2, 4].map(|at| half_to_f32(u16::from_le_bytes([bytes[at], bytes[at + 1]])))
}

/// Versions 1 and 2: x, y, z as b / 127.5 − 1; w ≥ 0 completes the unit quaternion. Returns w, x, y, z.
pub(super) fn first_three(bytes: [u8; 3]) -> [f32; 4] {
    let [x, y, z] = bytes.map(|b| f64::from(b) / 127.5 - 1.0);
    let w = (1.0 - x * x - y * y - z * z).max(0.0).sqrt();
    [w, x, y, z].map(|v| v as f32)
}

/// Versions 3 and 4: the two upper bits say which of x, y, z, w is left out because it is largest; the others follow
/// in order, a sign and nine bits of magnitude / 511 · √½ each, the last one lowest. Returns w, x, y, z.
pub(super) fn smallest_three(mut bits: u32) -> [f32; 4] {
    let largest = (bits >> 30) as usize;
    let mut q = [0.0_f64; 4];
    for i in (0..4).rev().filter(|&i| i != largest) {
        let magnitude = LARGEST_SMALL * f64::from(bits & 511) / 511.0;
        q[i] = if bits & 512 == 0 { magnitude } else { -magnitude };
        bits >>= 10;
    }
    q[largest] = (1.0 - q.iter().map(|v| v * v).sum::<f64>()).max(0.0).sqrt();
    [q[3], q[0], q[1], q[2]].map(|v| v as f32)
}

/// The number that [`smallest_three`] reads; w, x, y, z need not be of length one, zero is the identity.
pub(super) fn pack_smallest_three(q: [f32; 4]) -> u32 {
    let [w, x, y, z] = q.map(f64::from);
    let length = (w * w + x * x + y * y + z * z).sqrt();
    let unit = if length > 0.0 { [x, y, z, w].map(|v| v / length) } else { [0.0, 0.0, 0.0, 1.0] };
    let largest = (1..4).fold(0, |best, i| if unit[i].abs() > unit[best].abs() { i } else { best });
    // q and −q are the same rotation: the component that is left out is taken as positive.
    let sign = unit[largest].signum();
    let mut bits = largest as u32;
    for v in (0..4).filter(|&i| i != largest).map(|i| sign * unit[i]) {
        let magnitude = (511.0 * v.abs() / LARGEST_SMALL).round().min(511.0) as u32;
        bits = (bits << 10) | (u32::from(v < 0.0) << 9) | magnitude;
    }
    bits
}
