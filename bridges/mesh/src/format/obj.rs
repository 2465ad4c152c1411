//! Wavefront OBJ: the vertices and faces of a file.
//!
//! Colours behind the coordinates of vertices (`v x y z r g b`, display values from 0 to 1, as `MeshLab` and `ZBrush` write
//! them) are taken where every vertex has one. Keywords that say nothing about the shape (texture, normals, groups, materials) are passed over. Everything is read
//! in double precision, and a fault has the number of its line.

use cosplat_core::asset::TriangleMesh;
use cosplat_core::boundary::Vec3;

use super::polygons::{Cutter, Wrong};
use super::{Beside, Decoded, Format, linear_of_display, short};
use crate::error::{Fault, MeshError};

/// The registry entry; the format has no header.
pub(super) const FORMAT: Format = Format { name: "obj", endings: &["obj"], up: None, recognise: |_| false, read };

const NO_VERTEX: &str = "number vertices from 1, or from -1 backwards, and write them before the face";

fn read(bytes: &[u8], _: Beside<'_>) -> Result<Decoded, MeshError> {
    let (mut mesh, mut cutter) = (TriangleMesh::default(), Cutter::new());
    let mut colours = Vec::new();
    let mut joined = String::new();
    for (number, line) in bytes.split(|b| *b == b'\n').enumerate() {
        let text = String::from_utf8_lossy(line);
        let text = text.trim_end_matches('\r');
        if let Some(begun) = text.strip_suffix('\\') {
            joined.push_str(begun);
            joined.push(' ');
            continue;
        }
        joined.push_str(text);
        let code = joined.split('#').next().unwrap_or_default();
        one_line(&mut mesh, &mut colours, &mut cutter, code)
            .map_err(|(fault, what, advice)| MeshError::new(fault, format!("line {}", number + 1), what, advice))?;
        joined.clear();
    }
    if !joined.trim().is_empty() {
        let advice = "copy or download the file again";
        return Err(MeshError::new(Fault::Truncated, "last line", "it goes on behind the end of the file", advice));
    }
    let mut notes = Vec::new();
    if !(colours.is_empty() || colours.len() == mesh.vertices_m.len()) {
        notes.push(format!("{} of {} vertices have a colour: all are left out", colours.len(), mesh.vertices_m.len()));
        colours.clear();
    }
    Ok(Decoded { mesh, colours, notes })
}

fn one_line(
    mesh: &mut TriangleMesh,
    colours: &mut Vec<[f32; 3]>,
    cutter: &mut Cutter,
    code: &str,
) -> Result<(), Wrong> {
    let mut words = code.split_whitespace();
    match words.next() {
        Some("v") => {
            mesh.vertices_m.push(vertex(&mut words)?);
            colours.extend(colour(words));
        }
        Some("f") => {
            let corners = words.map(|w| corner(w, mesh.vertices_m.len())).collect::<Result<Vec<u32>, Wrong>>()?;
            cutter.add(mesh, &corners)?;
        }
        _ => {}
    }
    Ok(())
}

/// Three numbers behind a vertex; fewer are none: one alone is a weight.
fn colour<'a>(words: impl Iterator<Item = &'a str>) -> Option<[f32; 3]> {
    let all: Vec<f32> = words.map_while(|w| w.parse().ok()).filter(|v: &f32| v.is_finite()).collect();
    <[f32; 3]>::try_from(all).ok().map(|c| c.map(linear_of_display))
}

fn vertex<'a>(words: &mut impl Iterator<Item = &'a str>) -> Result<Vec3, Wrong> {
    let mut out = [0.0; 3];
    for value in &mut out {
        let word = words.next().ok_or_else(|| {
            (Fault::Syntax, "a vertex has fewer than three coordinates".to_owned(), "write `v x y z`")
        })?;
        *value = word.parse::<f64>().ok().filter(|v| v.is_finite()).ok_or_else(|| {
            (Fault::Value, format!("`{}` is no finite number", short(word)), "write coordinates as decimal numbers")
        })?;
    }
    Ok(out)
}

/// The vertex of a corner `v`, `v/vt`, `v//vn` or `v/vt/vn`, from 0.
fn corner(word: &str, count: usize) -> Result<u32, Wrong> {
    let name = word.split('/').next().unwrap_or_default();
    let index: i64 = name
        .parse()
        .map_err(|_| (Fault::Syntax, format!("`{}` names no vertex", short(word)), "write corners as `v/vt/vn`"))?;
    let from_zero = if index < 0 { index.checked_add_unsigned(count as u64) } else { index.checked_sub(1) };
    from_zero
        .and_then(|i| usize::try_from(i).ok())
        .filter(|i| *i < count)
        .and_then(|i| u32::try_from(i).ok())
        .ok_or_else(|| (Fault::Index, format!("vertex {index} of {count} so far is named"), NO_VERTEX))
}
