//! `.spz` versions 1 to 4: whole attributes as byte arrays, packed as gzip (1 to 3) or as zstd streams (4). Version 3 is
//! written. Version 1 has positions in half precision.
//!
//! Axes are right, up, back ([`crate::Axes::Rub`]). Layout as published with the format's own code (MIT).

mod attributes;
mod container;
mod write;

use super::{Decoded, Format, Limits};
use crate::error::SplatError;
use crate::splats::{Axes, Splats, coefficients, logit_of_opacity};

/// The registry entry.
pub(super) const FORMAT: Format = Format {
    name: "spz",
    endings: &["spz"],
    axes: Axes::Rub,
    recognise: |bytes| bytes.starts_with(b"NGSP") || bytes.starts_with(&[0x1f, 0x8b]),
    read: |bytes| read(bytes, Limits::default()),
    write: Some(write::write),
};

/// Flag: trained with the antialiasing filter.
const ANTIALIASED: u8 = 1;
/// Flag of version 4: extension records follow the header.
const EXTENDED: u8 = 2;

/// Decodes a file within limits.
///
/// # Errors
/// The bytes are damaged, of another version, or ask for more than the limits.
pub fn read(bytes: &[u8], limits: Limits) -> Result<Decoded, SplatError> {
    let packed = container::open(bytes, limits)?;
    let header = packed.header;
    let count = header.count as usize;
    let mut notes = Vec::new();
    if header.degree > 3 {
        notes.push(format!("bands above 3 of degree {} are left out", header.degree));
    }
    if header.version >= 4 && header.flags & EXTENDED != 0 {
        notes
            .push("extension records are not read; if one names other axes, state the up axis in the scene".to_owned());
    }
    let per_channel = coefficients(header.degree);
    let degree = header.degree.min(3);
    let kept = coefficients(degree);
    let unit = |b: u8| f64::from(b) / 255.0;
    let [positions, alphas, colours, scales, rotations, sh] = packed.attributes()?;
    let step = 1.0 / f64::from(header.fractional_bits).exp2();
    let mut splats = Splats {
        positions: if header.version >= 2 {
            positions.as_chunks::<9>().0.iter().map(|b| attributes::position(b, step)).collect()
        } else {
            positions.as_chunks::<6>().0.iter().map(|b| attributes::half_position(*b)).collect()
        },
        opacity_logits: alphas.iter().map(|&b| logit_of_opacity(unit(b))).collect(),
        sh_dc: colours.as_chunks::<3>().0.iter().map(|c| c.map(|b| ((unit(b) - 0.5) / 0.15) as f32)).collect(),
        log_scales: scales.as_chunks::<3>().0.iter().map(|s| s.map(|b| f32::from(b) / 16.0 - 10.0)).collect(),
        rotations: if header.version >= 3 {
            rotations.as_chunks::<4>().0.iter().map(|b| attributes::smallest_three(u32::from_le_bytes(*b))).collect()
        } else {
            rotations.as_chunks::<3>().0.iter().map(|b| attributes::first_three(*b)).collect()
        },
        sh_rest: Vec::with_capacity(count * kept),
        sh_degree: degree,
        axes: Axes::Rub,
        antialiased: header.flags & ANTIALIASED != 0,
        ..Splats::default()
    };
    let coefficient = |b: u8| (f32::from(b) - 128.0) / 128.0;
    let triples = sh.as_chunks::<3>().0;
    for gaussian in triples.chunks(per_channel.max(1)) {
        splats.sh_rest.extend(gaussian.iter().take(kept).map(|c| c.map(coefficient)));
    }
    Ok(Decoded { splats, notes })
}
