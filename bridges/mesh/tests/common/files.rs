//! Small files of every format, written here by their specifications.

use cosplat_core::asset::TriangleMesh;
use serde_json::{Value, json};

/// Encodings of PLY, as their headers name them.
pub(crate) const PLY: [&str; 3] = ["ascii", "binary_little_endian", "binary_big_endian"];

/// Binary STL.
pub(crate) fn stl_binary(mesh: &TriangleMesh, title: &str) -> Vec<u8> {
    let mut out = format!("{title:<80}").into_bytes();
    out.extend((mesh.triangles.len() as u32).to_le_bytes());
    for triangle in &mesh.triangles {
        out.extend([0; 12]);
        let corners = triangle.iter().flat_map(|i| mesh.vertices_m[*i as usize]);
        out.extend(corners.flat_map(|v| (v as f32).to_le_bytes()));
        out.extend([0; 2]);
    }
    out
}

/// STL as text.
pub(crate) fn stl_text(mesh: &TriangleMesh) -> Vec<u8> {
    let mut out = "solid a thing\n".to_owned();
    for triangle in &mesh.triangles {
        out += "facet normal 0 0 0\n outer loop\n";
        for [x, y, z] in triangle.map(|i| mesh.vertices_m[i as usize]) {
            out.extend(["  vertex ", &x.to_string(), " ", &y.to_string(), " ", &z.to_string(), "\n"]);
        }
        out += " endloop\nendfacet\n";
    }
    (out + "endsolid a thing\n").into_bytes()
}

/// PLY with more than is needed: a column and an element that say nothing about the shape.
pub(crate) fn ply(mesh: &TriangleMesh, encoding: &str) -> Vec<u8> {
    let (v, f) = (mesh.vertices_m.len(), mesh.triangles.len());
    let mut out = format!(
        "ply\nformat {encoding} 1.0\ncomment a thing\nelement vertex {v}\nproperty float x\nproperty float y\n\
         property uchar red\nproperty double z\nelement edge 1\nproperty list uchar short pair\nelement face {f}\n\
         property list uchar int vertex_indices\nend_header\n"
    )
    .into_bytes();
    if encoding == "ascii" {
        let vertices = mesh.vertices_m.iter().map(|[x, y, z]| format!("{x} {y} 255 {z}\n"));
        let faces = mesh.triangles.iter().map(|[a, b, c]| format!("3 {a} {b} {c}\n"));
        out.extend(vertices.chain(["2 0 1\n".to_owned()]).chain(faces).flat_map(String::into_bytes));
        return out;
    }
    let big = encoding == "binary_big_endian";
    let mut put = |bytes: &[u8]| {
        let mut bytes = bytes.to_vec();
        if big {
            bytes.reverse();
        }
        out.extend(bytes);
    };
    for [x, y, z] in &mesh.vertices_m {
        put(&(*x as f32).to_le_bytes());
        put(&(*y as f32).to_le_bytes());
        put(&[255]);
        put(&z.to_le_bytes());
    }
    put(&[2]);
    put(&0_i16.to_le_bytes());
    put(&1_i16.to_le_bytes());
    for triangle in &mesh.triangles {
        put(&[3]);
        for i in triangle {
            put(&i.to_le_bytes());
        }
    }
    out
}

/// OBJ.
pub(crate) fn obj(mesh: &TriangleMesh) -> Vec<u8> {
    let vertices = mesh.vertices_m.iter().map(|[x, y, z]| format!("v {x} {y} {z}\n"));
    let faces = mesh.triangles.iter().map(|t| t.map(|i| i + 1)).map(|[a, b, c]| format!("f {a} {b} {c}\n"));
    vertices.chain(faces).flat_map(String::into_bytes).collect()
}

/// Positions in single precision, then indices of 16 bits: the one buffer of [`document`].
pub(crate) fn buffer(mesh: &TriangleMesh) -> Vec<u8> {
    let positions = mesh.vertices_m.iter().flatten().flat_map(|v| (*v as f32).to_le_bytes());
    let indices = mesh.triangles.iter().flatten().flat_map(|i| (*i as u16).to_le_bytes());
    positions.chain(indices).collect()
}

/// A glTF document with one mesh and one node that shows it.
pub(crate) fn document(mesh: &TriangleMesh) -> Value {
    let (positions, indices) = (12 * mesh.vertices_m.len(), 6 * mesh.triangles.len());
    json!({
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": mesh.vertices_m.len(), "type": "VEC3"},
            {"bufferView": 1, "componentType": 5123, "count": 3 * mesh.triangles.len(), "type": "SCALAR"},
        ],
        "bufferViews": [
            {"buffer": 0, "byteLength": positions},
            {"buffer": 0, "byteOffset": positions, "byteLength": indices},
        ],
        "buffers": [{"byteLength": positions + indices}],
    })
}

/// A document and its buffer in one file.
pub(crate) fn glb(document: &Value, buffer: &[u8]) -> Vec<u8> {
    let pad = |mut bytes: Vec<u8>, with: u8| {
        bytes.resize(bytes.len().next_multiple_of(4), with);
        bytes
    };
    let (json, binary) = (pad(document.to_string().into_bytes(), b' '), pad(buffer.to_vec(), 0));
    let mut out = b"glTF\x02\0\0\0".to_vec();
    out.extend((28 + json.len() as u32 + binary.len() as u32).to_le_bytes());
    for (kind, chunk) in [(b"JSON", json), (b"BIN\0", binary)] {
        out.extend((chunk.len() as u32).to_le_bytes());
        out.extend(kind);
        out.extend(chunk);
    }
    out
}

/// A document that holds its buffer as text.
pub(crate) fn gltf(mut document: Value, buffer: &[u8]) -> Vec<u8> {
    use base64::Engine;
    let text = base64::engine::general_purpose::STANDARD.encode(buffer);
    document["buffers"][0]["uri"] = json!(format!("data:application/octet-stream;base64,{text}"));
    document.to_string().into_bytes()
}

/// The same shape in every format: ending and bytes.
pub(crate) fn all(mesh: &TriangleMesh) -> Vec<(&'static str, Vec<u8>)> {
    let (text, binary) = (document(mesh), buffer(mesh));
    let mut out = vec![
        ("obj", obj(mesh)),
        ("stl", stl_binary(mesh, "a thing")),
        ("stl", stl_text(mesh)),
        ("glb", glb(&text, &binary)),
        ("gltf", gltf(text, &binary)),
    ];
    out.extend(PLY.map(|encoding| ("ply", ply(mesh, encoding))));
    out
}
