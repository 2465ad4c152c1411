//! glTF 2.0: `.glb`, and `.gltf` with its buffers beside it or inside it. Units are metres and up is +y, by the format.
//!
//! The scene's nodes place the meshes; all of them become one. Only what says where triangles are is read. Numbers that
//! a hostile document may choose are compared with the bytes that are there before anything is made of them: the
//! accessors of the `gltf` crate compute with them unchecked, so its schema is written again here.

mod data;
mod place;
mod schema;

use cosplat_core::asset::TriangleMesh;
use nalgebra::{Matrix4, Point3};

use self::data::Data;
use self::schema::{Document, Primitive};
use super::{Beside, Decoded, Format, u32_at};
use crate::error::{Fault, MeshError};

/// The registry entry of one file for all.
pub(super) const BINARY: Format =
    Format { name: "glb", endings: &["glb"], up: Some("+y"), recognise: |bytes| bytes.starts_with(b"glTF"), read };

/// The registry entry of the text, which begins like any other JSON.
pub(super) const TEXT: Format = Format { name: "gltf", endings: &["gltf"], up: Some("+y"), recognise: |_| false, read };

/// Vertices and indices that meshes may take, when they are shown more often than once, beyond one for each byte.
const FREE: u64 = 1 << 20;
const AGAIN: &str = "copy or download the file again";
const EXPORT: &str = "export the mesh again as glTF 2.0, without compression";

fn fault(place: impl Into<String>, what: impl Into<String>) -> MeshError {
    MeshError::new(Fault::Header, place, what, EXPORT)
}

/// An item of a list of the document.
fn item<'a, T>(list: &'a [T], number: usize, name: &str) -> Result<&'a T, MeshError> {
    list.get(number).ok_or_else(|| fault(name, format!("number {number} of {} is named", list.len())))
}

fn read(bytes: &[u8], beside: Beside<'_>) -> Result<Decoded, MeshError> {
    let (json, chunk) = if bytes.starts_with(b"glTF") { chunks(bytes)? } else { (bytes, None) };
    let document: Document = serde_json::from_slice(json).map_err(|error| {
        let place = format!("JSON, line {}, column {}", error.line(), error.column());
        MeshError::new(Fault::Syntax, place, error.to_string(), EXPORT)
    })?;
    if !document.asset.version.starts_with("2.") {
        let what = format!("version {} of glTF is not 2", super::short(&document.asset.version));
        return Err(MeshError::new(Fault::Unsupported, "asset", what, EXPORT));
    }
    if let Some(name) = document.extensions_required.first() {
        let what = format!("it requires the extension `{}`", super::short(name));
        return Err(MeshError::new(Fault::Unsupported, "extensionsRequired", what, EXPORT));
    }
    let data = Data::new(&document, chunk, beside)?;
    let nodes = place::nodes(&document)?;
    check_room(&nodes, &data, FREE + bytes.len() as u64 + data.bytes())?;
    let mut builder = Builder { data, out: Decoded::default(), left_out: 0, skinned: false };
    for (node, placed) in &nodes {
        builder.show(*node, placed)?;
    }
    Ok(builder.finish())
}

/// Refuses a document that shows its meshes so often that what comes of it has more vertices and indices than `room`.
fn check_room(nodes: &[(usize, Matrix4<f64>)], data: &Data<'_>, room: u64) -> Result<(), MeshError> {
    let mut left = room;
    for (number, _) in nodes {
        let Some(mesh) = item(&data.document.nodes, *number, "node")?.mesh else { continue };
        for Primitive { attributes, indices, .. } in &item(&data.document.meshes, mesh, "mesh")?.primitives {
            for accessor in [attributes.position, *indices].into_iter().flatten() {
                left = left.checked_sub(data.count(accessor)?).ok_or_else(|| {
                    let what =
                        format!("more than {room} vertices and indices are shown, by node {number} at the latest");
                    let advice = "export the mesh with fewer copies";
                    MeshError::new(Fault::TooLarge, format!("mesh {mesh}"), what, advice)
                })?;
            }
        }
    }
    Ok(())
}

/// JSON and binary chunk of a `.glb`.
fn chunks(bytes: &[u8]) -> Result<(&[u8], Option<&[u8]>), MeshError> {
    let early = |needs: u64| {
        let what = format!("{needs} bytes are promised and {} are there", bytes.len());
        MeshError::new(Fault::Truncated, "header", what, AGAIN)
    };
    let [version, length] = [4, 8].map(|at| u32_at(bytes, at));
    let (Some(version), Some(length)) = (version, length) else { return Err(early(20)) };
    if version != 2 {
        let what = format!("version {version} of the container is not 2");
        return Err(MeshError::new(Fault::Unsupported, "header", what, EXPORT));
    }
    let all = bytes.get(..length as usize).ok_or_else(|| early(u64::from(length)))?;
    let chunk = |at: usize, kind: &[u8; 4]| {
        let size = u32_at(all, at)? as usize;
        let is_kind = all.get(at + 4..at + 8)? == kind;
        all.get(at + 8..)?.get(..size).filter(|_| is_kind)
    };
    let json = chunk(12, b"JSON").ok_or_else(|| fault("first chunk", "it is cut off or no JSON"))?;
    // Chunks begin at multiples of four; what follows the binary one has no meaning yet.
    let next = 20 + json.len().next_multiple_of(4);
    if next >= all.len() {
        return Ok((json, None));
    }
    let binary = chunk(next, b"BIN\0").ok_or_else(|| fault("second chunk", "it is cut off or not binary"))?;
    Ok((json, Some(binary)))
}

/// The mesh as far as it is made.
struct Builder<'a> {
    data: Data<'a>,
    out: Decoded,
    /// Primitives of points or lines.
    left_out: usize,
    skinned: bool,
}

impl Builder<'_> {
    /// Adds the mesh of a node.
    fn show(&mut self, node: usize, placed: &Matrix4<f64>) -> Result<(), MeshError> {
        let node = item(&self.data.document.nodes, node, "node")?;
        let Some(number) = node.mesh else { return Ok(()) };
        self.skinned |= node.skin.is_some();
        let mesh = item(&self.data.document.meshes, number, "mesh")?;
        for (part, primitive) in mesh.primitives.iter().enumerate() {
            let place = || format!("primitive {part} of mesh {number}");
            self.add(primitive, placed, &place)?;
        }
        Ok(())
    }

    fn add(
        &mut self,
        primitive: &Primitive,
        placed: &Matrix4<f64>,
        place: &dyn Fn() -> String,
    ) -> Result<(), MeshError> {
        let mode = primitive.mode.unwrap_or(4);
        let Some(position) = primitive.attributes.position.filter(|_| mode >= 4) else {
            self.left_out += 1;
            return Ok(());
        };
        if mode > 6 {
            return Err(fault(place(), format!("{mode} is no mode of a primitive")));
        }
        let positions = self.data.positions(position)?;
        let count = positions.len() as u32;
        let colours = primitive.attributes.colour.map(|colour| self.data.colours(colour)).transpose()?;
        if let Some(has) = colours.as_ref().map(Vec::len).filter(|has| *has != positions.len()) {
            return Err(fault(place(), format!("{count} vertices have {has} colours")));
        }
        let corners = match primitive.indices {
            Some(indices) => self.data.indices(indices)?,
            None => (0..count).collect(),
        };
        if let Some(wild) = corners.iter().find(|i| **i >= count) {
            let what = format!("vertex {wild} of {count} is named");
            return Err(MeshError::new(Fault::Index, place(), what, EXPORT));
        }
        let TriangleMesh { vertices_m, triangles } = &mut self.out.mesh;
        let first = vertices_m.len() as u32;
        // Parts without colours are white, by the format, as soon as one has some.
        if colours.is_some() || !self.out.colours.is_empty() {
            self.out.colours.resize(first as usize, [1.0; 3]);
            self.out.colours.extend(colours.unwrap_or_else(|| vec![[1.0; 3]; count as usize]));
        }
        vertices_m.extend(positions.iter().map(|p| <[f64; 3]>::from(placed.transform_point(&Point3::from(*p)).coords)));
        if let Some(wild) = vertices_m[first as usize..].iter().position(|p| !p.iter().all(|v| v.is_finite())) {
            let what = format!("vertex {wild} is placed at no finite position");
            return Err(MeshError::new(Fault::Value, place(), what, EXPORT));
        }
        // A mirror turns the outside in.
        let is_mirrored = placed.fixed_view::<3, 3>(0, 0).determinant() < 0.0;
        triangles.extend(faces(mode, &corners).map(|[a, b, c]| {
            let [b, c] = if is_mirrored { [c, b] } else { [b, c] };
            [a, b, c].map(|i| first + i)
        }));
        Ok(())
    }

    fn finish(self) -> Decoded {
        let mut out = self.out;
        if self.left_out > 0 {
            out.notes.push(format!("{} parts are points or lines and left out", self.left_out));
        }
        if self.skinned {
            out.notes
                .push("a part is bent by a skeleton, which is not read: it is shown as it was modelled".to_owned());
        }
        out
    }
}

/// Triangles of a list of corners: a list, a strip or a fan, as the specification orders them.
fn faces(mode: u32, corners: &[u32]) -> Box<dyn Iterator<Item = [u32; 3]> + '_> {
    match mode {
        5 => Box::new(corners.windows(3).enumerate().map(|(k, w)| {
            let odd = k % 2;
            [w[0], w[1 + odd], w[2 - odd]]
        })),
        6 => Box::new(corners.windows(2).skip(1).map(|w| [w[0], w[1], corners[0]])),
        _ => Box::new(corners.as_chunks::<3>().0.iter().copied()),
    }
}
