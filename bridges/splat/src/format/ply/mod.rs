//! `.ply` as INRIA and nerfstudio write it: one row of named properties a Gaussian.
//!
//! Properties are found by name in any order. `f_rest_i` is channel-major: i = channel · K + coefficient. Normals are
//! zero and unused in every known writer; they are written as zeros and not kept. The chunked layout of `PlayCanvas` is a
//! format of its own.

mod chunked;
mod columns;
mod header;
mod rows;
mod write;

use super::Format;
use crate::splats::Axes;

/// The registry entry.
pub(super) const FORMAT: Format = Format {
    name: "ply",
    endings: &["ply"],
    axes: Axes::Rdf,
    recognise: is_ply,
    read: rows::read,
    write: Some(write::write),
};

/// The registry entry of the chunked layout; it is asked before the other.
pub(super) const CHUNKED: Format = Format {
    name: "compressed ply",
    endings: &["compressed.ply"],
    axes: Axes::Rdf,
    recognise: chunked::recognise,
    read: chunked::read,
    write: None,
};

fn is_ply(bytes: &[u8]) -> bool {
    bytes.starts_with(b"ply\n") || bytes.starts_with(b"ply\r\n")
}
