//! STL, binary and text: triangles without shared vertices.
//!
//! Binary files whose 80 bytes of free text begin with `solid` exist; the length of a binary file follows from its
//! count, and is asked first. A text may hold several solids; they are merged. Normals are left out: the order of the
//! corners says the same.

use cosplat_core::asset::TriangleMesh;
use cosplat_core::boundary::Vec3;

use super::{Beside, Decoded, Format, short, u32_at};
use crate::error::{Fault, MeshError};

/// The registry entry.
pub(super) const FORMAT: Format =
    Format { name: "stl", endings: &["stl"], up: None, recognise: |bytes| is_binary(bytes) || is_text(bytes), read };

/// Free text, then the number of triangles.
const HEADER: usize = 84;
/// Normal, three corners, two bytes without a meaning.
const TRIANGLE: usize = 50;
const AGAIN: &str = "copy or download the file again";
const EXPORT: &str = "export the mesh again, as binary STL";

fn is_binary(bytes: &[u8]) -> bool {
    let length = |count: u32| HEADER as u64 + u64::from(count) * TRIANGLE as u64;
    u32_at(bytes, HEADER - 4).is_some_and(|count| count > 0 && length(count) == bytes.len() as u64)
}

fn is_text(bytes: &[u8]) -> bool {
    let begins = bytes.get(..5).is_some_and(|word| word.eq_ignore_ascii_case(b"solid"));
    begins && bytes.get(5).is_none_or(u8::is_ascii_whitespace)
}

fn read(bytes: &[u8], _: Beside<'_>) -> Result<Decoded, MeshError> {
    let mesh = if is_binary(bytes) || !is_text(bytes) { read_binary(bytes)? } else { read_text(bytes)? };
    Ok(Decoded { mesh, ..Decoded::default() })
}

fn read_binary(bytes: &[u8]) -> Result<TriangleMesh, MeshError> {
    let truncated = |place: &str, needs: u64| {
        let what = format!("{needs} bytes are promised and {} are there", bytes.len());
        MeshError::new(Fault::Truncated, place, what, AGAIN)
    };
    let count = u32_at(bytes, HEADER - 4).ok_or_else(|| truncated("header", HEADER as u64))?;
    let needs = HEADER as u64 + u64::from(count) * TRIANGLE as u64;
    if needs > bytes.len() as u64 {
        return Err(truncated("triangles", needs));
    }
    if needs < bytes.len() as u64 {
        let what = format!("{count} triangles need {needs} bytes and {} are there", bytes.len());
        return Err(MeshError::new(Fault::Header, "header", what, EXPORT));
    }
    let mut mesh = with_room(count as usize);
    for (number, row) in bytes[HEADER..].as_chunks::<TRIANGLE>().0.iter().enumerate() {
        let float = |k: usize| f32::from_le_bytes([row[4 * k], row[4 * k + 1], row[4 * k + 2], row[4 * k + 3]]);
        let corner = |k: usize| [0, 1, 2].map(|axis| f64::from(float(3 + 3 * k + axis)));
        let corners = [corner(0), corner(1), corner(2)];
        if let Some(wild) = corners.iter().flatten().find(|v| !v.is_finite()) {
            let what = format!("a coordinate is {wild}");
            return Err(MeshError::new(Fault::Value, format!("triangle {}", number + 1), what, EXPORT));
        }
        push(&mut mesh, corners);
    }
    Ok(mesh)
}

fn read_text(bytes: &[u8]) -> Result<TriangleMesh, MeshError> {
    let mut mesh = TriangleMesh::default();
    let mut corners: Vec<Vec3> = Vec::new();
    let (mut line_number, mut is_open) = (0, false);
    for (number, line) in bytes.split(|b| *b == b'\n').enumerate() {
        line_number = number + 1;
        let wrong = |fault, what: String, advice| MeshError::new(fault, format!("line {}", number + 1), what, advice);
        let text = String::from_utf8_lossy(line).to_ascii_lowercase();
        let mut words = text.split_ascii_whitespace();
        match words.next() {
            None | Some("facet" | "outer" | "endfacet") => {}
            Some("solid") => is_open = true,
            Some("endsolid") => is_open = false,
            Some("vertex") if corners.len() < 3 => corners.push(corner(words, wrong)?),
            Some("vertex") => {
                return Err(wrong(Fault::Syntax, "a facet has a fourth vertex".to_owned(), EXPORT));
            }
            Some("endloop") => {
                let found = <[Vec3; 3]>::try_from(std::mem::take(&mut corners)).map_err(|found| {
                    wrong(Fault::Syntax, format!("a facet has {} vertices, not 3", found.len()), EXPORT)
                })?;
                push(&mut mesh, found);
            }
            Some(word) => {
                return Err(wrong(Fault::Syntax, format!("`{}` is no word of an STL text", short(word)), EXPORT));
            }
        }
    }
    if is_open || !corners.is_empty() {
        let place = format!("line {line_number}");
        return Err(MeshError::new(Fault::Truncated, place, "the text ends before its `endsolid`", AGAIN));
    }
    Ok(mesh)
}

fn corner<'a>(
    mut words: impl Iterator<Item = &'a str>,
    wrong: impl Fn(Fault, String, &'static str) -> MeshError,
) -> Result<Vec3, MeshError> {
    let mut out = [0.0; 3];
    for value in &mut out {
        let word = words.next().ok_or_else(|| {
            wrong(Fault::Syntax, "a vertex has fewer than three coordinates".to_owned(), "write `vertex x y z`")
        })?;
        *value = word.parse().ok().filter(|v: &f64| v.is_finite()).ok_or_else(|| {
            let what = format!("`{}` is no finite number", short(word));
            wrong(Fault::Value, what, "write coordinates as decimal numbers")
        })?;
    }
    Ok(out)
}

fn with_room(triangles: usize) -> TriangleMesh {
    TriangleMesh { vertices_m: Vec::with_capacity(3 * triangles), triangles: Vec::with_capacity(triangles) }
}

fn push(mesh: &mut TriangleMesh, corners: [Vec3; 3]) {
    let first = mesh.vertices_m.len() as u32;
    mesh.vertices_m.extend(corners);
    mesh.triangles.push([first, first + 1, first + 2]);
}
