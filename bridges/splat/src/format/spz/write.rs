//! Version 3: gzip, quaternions as their three smaller components.
//!
//! Higher bands are written with all eight bits a coefficient has; other writers keep five for the first band and four
//! above, which packs better and shows.

use std::io::Write;

use flate2::Compression;
use flate2::write::GzEncoder;

use super::container::MAGIC;
use super::{ANTIALIASED, attributes};
use crate::clean::{Rules, clean};
use crate::splats::Splats;

/// Fractional bits of positions wherever the largest coordinate leaves room for them; what other writers use.
const USUAL_BITS: i32 = 12;
/// Fractional bits are at most this many: a reader may hold a position in 24 bits.
const MOST_BITS: i32 = 22;
/// Positions are at least this many bits finer than the largest coordinate, if `MOST_BITS` allows.
const RELATIVE_BITS: i32 = 17;
/// Largest magnitude of a signed number of 24 bits.
const LARGEST: f64 = 8_388_607.0;

/// Encodes the Gaussians whose numbers are all finite; [`crate::format::encode`] turns the axes first.
pub(super) fn write(splats: &Splats) -> Vec<u8> {
    let (finite, report) = clean(splats, &Rules { opacity: 0.0, inside: None, largest_sigma: None });
    let selected = (report.kept < report.total).then(|| splats.select(&finite));
    let splats = selected.as_ref().unwrap_or(splats);
    let bits = fractional_bits(&splats.positions);
    let mut raw = Vec::with_capacity(16 + splats.len() * (20 + 3 * splats.coefficients()));
    raw.extend(MAGIC.to_le_bytes());
    raw.extend(3_u32.to_le_bytes());
    raw.extend((splats.len() as u32).to_le_bytes());
    raw.extend([splats.sh_degree, bits, if splats.antialiased { ANTIALIASED } else { 0 }, 0]);
    let step = f64::from(bits).exp2();
    raw.extend(splats.positions.iter().flatten().flat_map(|v| {
        let [a, b, c, _] = ((f64::from(*v) * step).round().clamp(-LARGEST, LARGEST) as i32).to_le_bytes();
        [a, b, c]
    }));
    raw.extend((0..splats.len()).map(|i| byte(255.0 * splats.opacity(i))));
    raw.extend(splats.sh_dc.iter().flatten().map(|v| byte(255.0 * (0.15 * f64::from(*v) + 0.5))));
    raw.extend(splats.log_scales.iter().flatten().map(|v| byte(16.0 * (f64::from(*v) + 10.0))));
    raw.extend(splats.rotations.iter().flat_map(|q| attributes::pack_smallest_three(*q).to_le_bytes()));
    raw.extend(splats.sh_rest.iter().flatten().map(|v| byte(128.0 * f64::from(*v) + 128.0)));
    pack(&raw)
}

/// The nearest number of eight bits.
fn byte(value: f64) -> u8 {
    value.round().clamp(0.0, 255.0) as u8
}

/// As many fractional bits as the largest coordinate allows, and no more than are of use.
fn fractional_bits(positions: &[[f32; 3]]) -> u8 {
    let largest = positions.iter().flatten().fold(0.0_f64, |most, v| most.max(f64::from(*v).abs()));
    if largest == 0.0 {
        return USUAL_BITS as u8;
    }
    let fine = (RELATIVE_BITS - largest.log2().ceil() as i32).clamp(USUAL_BITS, MOST_BITS);
    let fits = (LARGEST / largest).log2().floor() as i32;
    fine.min(fits).max(0) as u8
}

fn pack(raw: &[u8]) -> Vec<u8> {
    let mut gzip = GzEncoder::new(Vec::with_capacity(raw.len() / 2), Compression::default());
    // Writing to memory does not fail.
    let _ = gzip.write_all(raw);
    gzip.finish().unwrap_or_default()
}
