//! One Gaussian's bytes.

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

/// Version 2: x, y, z as b / 127.5 − 1; w ≥ 0 completes the unit quaternion. Returns w, x, y, z.
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
