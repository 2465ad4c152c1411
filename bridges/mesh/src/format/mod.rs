//! Mesh files: one file or folder a format, one registry.

mod beside;
mod gltf;
mod obj;
mod ply;
mod polygons;
mod stl;

use cosplat_core::asset::TriangleMesh;

pub use self::beside::Beside;
use crate::error::{Fault, MeshError};

/// What was decoded, in units and axes of the file, and what the user should know about it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Decoded {
    /// The surface: polygons cut, placed by the nodes of the file, all parts in one.
    pub mesh: TriangleMesh,
    /// Of each vertex: linear red, green, blue from 0 to 1. Empty where the file gives none.
    pub colours: Vec<[f32; 3]>,
    /// Remarks: what was left out or assumed.
    pub notes: Vec<String>,
}

/// A format: how it is recognised and read.
pub struct Format {
    /// Name for messages.
    pub name: &'static str,
    /// Endings of file names, without the dot.
    pub endings: &'static [&'static str],
    /// The up axis that the format itself demands, as scenes name it; most leave it open.
    pub up: Option<&'static str>,
    /// Whether the bytes say that it is this format; never for formats without a header.
    pub recognise: fn(&[u8]) -> bool,
    /// The decoder; hostile bytes give an error, never a panic.
    pub read: fn(&[u8], Beside<'_>) -> Result<Decoded, MeshError>,
}

/// Every known format, in the order in which they are asked.
pub const FORMATS: [Format; 5] = [gltf::BINARY, gltf::TEXT, ply::FORMAT, stl::FORMAT, obj::FORMAT];

/// Decodes bytes: the format is recognised from them, or taken from the ending of the file name. `beside` is where the
/// files lie that a `.gltf` names.
///
/// # Errors
/// The bytes are no known format, or damaged.
pub fn read(bytes: &[u8], ending: Option<&str>, beside: Beside<'_>) -> Result<Decoded, MeshError> {
    let decoded = (of(bytes, ending)?.read)(bytes, beside)?;
    if decoded.mesh.triangles.is_empty() {
        let what = format!("{} vertices and no faces were found", decoded.mesh.vertices_m.len());
        return Err(MeshError::new(Fault::Empty, "whole file", what, "export a surface made of faces"));
    }
    Ok(decoded)
}

/// The format of a file: by its bytes, or by the ending of its name.
///
/// # Errors
/// Neither belongs to a known format.
pub fn of(bytes: &[u8], ending: Option<&str>) -> Result<&'static Format, MeshError> {
    let named = |format: &&Format| {
        ending.is_some_and(|ending| format.endings.iter().any(|known| known.eq_ignore_ascii_case(ending)))
    };
    let found = FORMATS.iter().find(|format| (format.recognise)(bytes)).or_else(|| FORMATS.iter().find(named));
    found.ok_or_else(|| {
        let known: Vec<String> = FORMATS.iter().flat_map(|f| f.endings).map(|e| format!("`.{e}`")).collect();
        let what = "neither its first bytes nor its ending belong to a known mesh format";
        MeshError::new(Fault::UnknownFormat, "first bytes", what, format!("known are {}", known.join(", ")))
    })
}

/// A number of 32 bits, if it is there.
fn u32_at(bytes: &[u8], at: usize) -> Option<u32> {
    Some(u32::from_le_bytes(*bytes.get(at..)?.first_chunk()?))
}

/// The linear value of one that is stored for a display, 0 to 1, IEC 61966-2-1.
fn linear_of_display(display: f32) -> f32 {
    let c = display.clamp(0.0, 1.0);
    if c <= 0.040_45 { c / 12.92 } else { ((c + 0.055) / 1.055).powf(2.4) }
}

/// The beginning of a word, for a message.
fn short(word: &str) -> String {
    word.chars().take(24).collect()
}
