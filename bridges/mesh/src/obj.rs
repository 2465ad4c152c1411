//! Wavefront OBJ: the vertices and faces of a file.
//!
//! Keywords that say nothing about the shape (texture, normals, groups, materials) are passed over. Everything is read
//! in double precision, and a fault has the number of its line.

use cosplat_core::asset::TriangleMesh;
use cosplat_core::boundary::Vec3;

use crate::error::{Fault, MeshError};
use crate::triangulate::triangulate;

/// Corners of a face at most: cutting a polygon into triangles takes the square of their number.
const CORNERS: usize = 4096;
const NO_VERTEX: &str = "number vertices from 1, or from -1 backwards, and write them before the face";

/// Reads the surface, in units and axes of the file; polygons become triangles, turned the same way.
///
/// # Errors
/// The text is no OBJ file, or a line of it is damaged.
pub fn read(bytes: &[u8]) -> Result<TriangleMesh, MeshError> {
    let mut mesh = TriangleMesh::default();
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
        one_line(&mut mesh, code)
            .map_err(|(fault, what, advice)| MeshError::new(fault, format!("line {}", number + 1), what, advice))?;
        joined.clear();
    }
    if mesh.triangles.is_empty() {
        let what = format!("{} vertices and no faces were found", mesh.vertices_m.len());
        return Err(MeshError::new(
            Fault::Empty,
            "whole file",
            what,
            "give a Wavefront OBJ file with `v` and `f` lines",
        ));
    }
    Ok(mesh)
}

type Wrong = (Fault, String, &'static str);

fn one_line(mesh: &mut TriangleMesh, code: &str) -> Result<(), Wrong> {
    let mut words = code.split_whitespace();
    match words.next() {
        Some("v") => mesh.vertices_m.push(vertex(words)?),
        Some("f") => {
            let corners = words.map(|w| corner(w, mesh.vertices_m.len())).collect::<Result<Vec<u32>, Wrong>>()?;
            if !(3..=CORNERS).contains(&corners.len()) {
                let what = format!("a face has {} corners", corners.len());
                return Err((Fault::Syntax, what, "give each face 3 to 4096 corners"));
            }
            let points: Vec<Vec3> = corners.iter().map(|&i| mesh.vertices_m[i as usize]).collect();
            mesh.triangles.extend(triangulate(&points).into_iter().map(|t| t.map(|k| corners[k])));
        }
        _ => {}
    }
    Ok(())
}

fn vertex<'a>(mut words: impl Iterator<Item = &'a str>) -> Result<Vec3, Wrong> {
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

/// The beginning of a word, for a message.
fn short(word: &str) -> String {
    word.chars().take(24).collect()
}
