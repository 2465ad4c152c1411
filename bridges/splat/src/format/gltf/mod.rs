//! `.glb` with the extension `KHR_gaussian_splatting`, as it was ratified in 2026 (release candidate of 2026-04-15).
//!
//! Gaussians are the points of a mesh primitive: linear scales, opacities from 0 to 1, unit quaternions x, y, z, w, and
//! the coefficients of the colour as the `.ply` has them, for the same signs of the harmonics. Axes are those of glTF, y
//! up. Binary, in one file; nodes may not turn or move what they show.

mod read;
mod write;

use super::Format;
use crate::splats::Axes;

/// The registry entry.
pub(super) const FORMAT: Format = Format {
    name: "glb",
    endings: &["glb"],
    axes: Axes::Rub,
    recognise: |bytes| bytes.starts_with(MAGIC),
    read: read::read,
    write: Some(write::write),
};

const MAGIC: &[u8] = b"glTF";
const EXTENSION: &str = "KHR_gaussian_splatting";
/// Kinds of chunks.
const JSON: u32 = 0x4e4f_534a;
const BIN: u32 = 0x004e_4942;
/// Kinds of numbers of accessors.
const BYTE: u32 = 5120;
const UNSIGNED_BYTE: u32 = 5121;
const SHORT: u32 = 5122;
const UNSIGNED_SHORT: u32 = 5123;
const FLOAT: u32 = 5126;

/// The attribute of a coefficient of the colour, by its number from 0 in the order of degrees.
fn coefficient(number: usize) -> String {
    let degree = number.isqrt();
    format!("{EXTENSION}:SH_DEGREE_{degree}_COEF_{}", number - degree * degree)
}

/// The attribute of a property that only splats have.
fn attribute(name: &str) -> String {
    format!("{EXTENSION}:{name}")
}
