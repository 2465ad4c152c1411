//! `.splat`: rows of 32 bytes without a header.
//!
//! f32 ×3 position, f32 ×3 linear scale, u8 ×4 colour ½ + Y₀ dc and opacity, u8 ×4 quaternion w, x, y, z as
//! q · 128 + 128. No higher bands.

use super::{Decoded, Format};
use crate::error::SplatError;
use crate::splats::{Axes, Splats, dc_of_colour, logit_of_opacity};

/// The registry entry.
pub(super) const FORMAT: Format =
    Format { name: "splat", endings: &["splat"], axes: Axes::Rdf, recognise: |_| false, read, write: None };

const ROW: usize = 32;

fn read(bytes: &[u8]) -> Result<Decoded, SplatError> {
    let (rows, rest) = bytes.as_chunks::<ROW>();
    if !rest.is_empty() {
        let needs = (rows.len() as u64 + 1) * ROW as u64;
        return Err(SplatError::truncated("last row of 32 bytes", needs, bytes.len() as u64));
    }
    let mut splats = Splats::with_capacity(rows.len(), 0);
    for row in rows {
        let float = |k: usize| f32::from_le_bytes([row[4 * k], row[4 * k + 1], row[4 * k + 2], row[4 * k + 3]]);
        let unit = |k: usize| f64::from(row[24 + k]) / 255.0;
        let turn = |k: usize| (f32::from(row[28 + k]) - 128.0) / 128.0;
        splats.positions.push([float(0), float(1), float(2)]);
        splats.log_scales.push([3, 4, 5].map(|k| f64::from(float(k)).ln() as f32));
        splats.sh_dc.push([0, 1, 2].map(|k| dc_of_colour(unit(k))));
        splats.opacity_logits.push(logit_of_opacity(unit(3)));
        splats.rotations.push([0, 1, 2, 3].map(turn));
    }
    Ok(Decoded { splats, notes: Vec::new() })
}
