//! Colours of vertices: read from every format that has them, and kept by their vertices.

mod common;

use common::{brick, files};
use cosplat_mesh::format::Beside;
use cosplat_mesh::{Fault, Prepared, Recipe};
use serde_json::json;

const PLAIN: Recipe = Recipe { metres_per_unit: 1.0, up: [0.0, 0.0, 1.0] };

fn read(bytes: &[u8], ending: &str) -> Prepared {
    Prepared::from_bytes(bytes, Some(ending), Beside::Nothing, &PLAIN).expect("a mesh")
}

/// The linear value of the display value 0.5, IEC 61966-2-1: ((0.5 + 0.055) / 1.055)^2.4.
const HALF: f32 = 0.214_041_14;

#[track_caller]
fn same(found: &[[f32; 3]], wanted: &[[f32; 3]]) {
    assert_eq!(found.len(), wanted.len());
    for (p, q) in found.iter().flatten().zip(wanted.iter().flatten()) {
        // A few units of single precision.
        assert!((p - q).abs() < 1e-6, "{found:?} {wanted:?}");
    }
}

/// A line for each place with its colour.
fn lines(head: &str, places: &[&str], colours: &[&str]) -> String {
    let lines: Vec<String> = places.iter().zip(colours).map(|(p, c)| format!("{head}{p} {c}\n")).collect();
    lines.concat()
}

/// Two triangles that share an edge, its vertices written twice; the first of two keeps its colour.
#[test]
fn display_values_of_obj_and_ply_become_linear_and_are_welded_with_their_vertices() {
    let wanted = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [HALF; 3]];
    let places = ["0 0 0", "1 0 0", "0 1 0", "1 0 0", "1 1 0", "0 1 0"];
    let display = ["1 0 0", "0 1 0", "0 0 1", "0.1 0.2 0.3", "0.5 0.5 0.5", "0.3 0.2 0.1"];
    let obj = lines("v ", &places, &display);
    let found = read((obj.clone() + "f 1 2 3\nf 4 5 6\n").as_bytes(), "obj");
    assert_eq!(found.mesh.vertices_m.len(), 4);
    same(&found.colours, &wanted);
    let head = |kind: &str| {
        format!(
            "ply\nformat ascii 1.0\nelement vertex 6\nproperty float x\nproperty float y\nproperty float z\n\
             property {kind} red\nproperty {kind} green\nproperty {kind} blue\nelement face 2\n\
             property list uchar int vertex_indices\nend_header\n"
        )
    };
    let faces = "3 0 1 2\n3 3 4 5\n";
    let parts = lines("", &places, &display);
    same(&read((head("float") + &parts + faces).as_bytes(), "ply").colours, &wanted);
    let bytes = ["255 0 0", "0 255 0", "0 0 255", "1 2 3", "0 255 128", "9 9 9"];
    let parts = lines("", &places, &bytes);
    let found = read((head("uchar") + &parts + faces).as_bytes(), "ply");
    // ((128/255 + 0.055) / 1.055)^2.4.
    same(&found.colours, &[wanted[0], wanted[1], wanted[2], [0.0, 1.0, 0.215_860_5]]);
    // Some vertices with a colour and some without: nobody knows what was meant.
    let some = obj.replacen("v 0 0 0 1 0 0", "v 0 0 0", 1) + "f 1 2 3\nf 4 5 6\n";
    let found = read(some.as_bytes(), "obj");
    assert!(found.colours.is_empty() && found.report.notes[0].contains("5 of 6 vertices have a colour"));
    // One number behind a place is a weight.
    assert!(read(b"v 0 0 0 1\nv 1 0 0 1\nv 0 1 0 1\nf 1 2 3\n", "obj").colours.is_empty());
}

#[test]
fn colours_of_gltf_are_linear_in_each_of_their_types() {
    let mesh = brick([0.0; 3], [1.0; 3]);
    let n = mesh.vertices_m.len();
    let kinds: [(&str, u32, Vec<u8>); 4] = [
        ("VEC3", 5126, [0.25_f32, 0.5, 7.0].map(f32::to_le_bytes).concat()),
        ("VEC4", 5126, [0.25_f32, 0.5, 1.0, 0.5].map(f32::to_le_bytes).concat()),
        ("VEC4", 5121, vec![51, 102, 255, 0]),
        ("VEC4", 5123, [13_107_u16, 26_214, 65_535, 0].map(u16::to_le_bytes).concat()),
    ];
    for (shape, kind, one) in kinds {
        let mut document = files::document(&mesh);
        let mut buffer = files::buffer(&mesh);
        let at = buffer.len().next_multiple_of(4);
        buffer.resize(at, 0);
        buffer.extend(one.repeat(n));
        document["buffers"][0]["byteLength"] = json!(buffer.len());
        let view = json!({"buffer": 0, "byteOffset": at, "byteLength": n * one.len()});
        document["bufferViews"].as_array_mut().unwrap().push(view);
        let accessor =
            json!({"bufferView": 2, "componentType": kind, "normalized": kind != 5126, "count": n, "type": shape});
        document["accessors"].as_array_mut().unwrap().push(accessor);
        document["meshes"][0]["primitives"][0]["attributes"]["COLOR_0"] = json!(2);
        // A second part without colours is white.
        document["nodes"] = json!([{"mesh": 0}, {"mesh": 1, "translation": [5, 0, 0]}]);
        document["scenes"] = json!([{"nodes": [0, 1]}]);
        let plain = json!({"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]});
        document["meshes"].as_array_mut().unwrap().push(plain);
        let found = read(&files::glb(&document, &buffer), "glb");
        let first = if kind == 5126 { [0.25, 0.5, 1.0] } else { [0.2, 0.4, 1.0] };
        // Eight corners, whose copies at each face are welded.
        same(&found.colours, &[vec![first; 8], vec![[1.0; 3]; 8]].concat());
        // Damage: fewer colours than vertices, and a type that is none.
        for (key, value, fault) in
            [("count", json!(n - 1), Fault::Header), ("componentType", json!(5125), Fault::Header)]
        {
            let mut wrong = document.clone();
            wrong["accessors"][2][key] = value;
            let bytes = files::glb(&wrong, &buffer);
            let error = Prepared::from_bytes(&bytes, None, Beside::Nothing, &PLAIN).unwrap_err();
            assert_eq!(error.fault, fault, "{error}");
        }
    }
    let plain = files::glb(&files::document(&mesh), &files::buffer(&mesh));
    assert!(read(&plain, "glb").colours.is_empty());
}
