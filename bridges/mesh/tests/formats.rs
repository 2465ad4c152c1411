//! One shape in every format is the same shape.

mod common;

use common::{brick, files};
use cosplat_mesh::format::{Beside, of, read};
use cosplat_mesh::{Fault, Prepared, Recipe};
use proptest::prelude::*;
use serde_json::json;

const PLAIN: Recipe = Recipe { metres_per_unit: 1.0, up: [0.0, 0.0, 1.0] };

#[test]
fn a_brick_is_the_same_in_every_format() {
    let mesh = brick([0.5, -1.0, 2.0], [1.0, 2.0, 4.0]);
    for (ending, bytes) in files::all(&mesh) {
        let found = Prepared::from_bytes(&bytes, Some(ending), Beside::Nothing, &PLAIN).unwrap();
        let solid = found.report.solid.unwrap();
        // Every number is exact in single precision, so what is left is the rounding of sums of a dozen of them.
        assert!((solid.volume_m3 - 8.0).abs() < 1e-13, "{ending}: {}", solid.volume_m3);
        assert_eq!((found.report.triangles_read, found.mesh.vertices_m.len()), (12, 8), "{ending}");
        assert_eq!(found.report.box_m, [[0.5, -1.0, 2.0], [1.5, 1.0, 6.0]], "{ending}");
    }
}

#[test]
fn formats_are_known_by_their_content() {
    let mesh = brick([0.0; 3], [1.0; 3]);
    for (ending, bytes) in files::all(&mesh) {
        let has_header = !["obj", "gltf"].contains(&ending);
        assert_eq!(of(&bytes, None).is_ok_and(|f| f.name == ending), has_header, "{ending}");
        assert_eq!(of(&bytes, Some(&ending.to_uppercase())).unwrap().name, ending);
    }
    // The free text of a binary file may be anything, and its length says that it is one.
    let bytes = files::stl_binary(&mesh, "solid but binary");
    assert_eq!(read(&bytes, Some("stl"), Beside::Nothing).unwrap().mesh.triangles.len(), 12);
    let error = of(b"nothing known", Some("fbx")).map(|f| f.name).unwrap_err();
    assert_eq!(error.fault, Fault::UnknownFormat);
    assert!(error.advice.contains("`.glb`, `.gltf`, `.ply`, `.stl`, `.obj`"), "{error}");
    for (ending, up) in [("glb", Some("+y")), ("gltf", Some("+y")), ("stl", None), ("ply", None), ("obj", None)] {
        assert_eq!(of(b"", Some(ending)).unwrap().up, up, "{ending}");
    }
}

#[test]
fn several_solids_of_one_text_are_one_mesh() {
    let two = [files::stl_text(&brick([0.0; 3], [1.0; 3])), files::stl_text(&brick([3.0; 3], [1.0; 3]))].concat();
    let found = Prepared::from_bytes(&two, None, Beside::Nothing, &PLAIN).unwrap();
    assert!((found.report.solid.unwrap().volume_m3 - 2.0).abs() < 1e-13);
}

#[test]
fn polygons_of_a_ply_are_cut() {
    let text = "ply\nformat ascii 1.0\nelement face 1\nproperty list uchar uint vertex_index\nelement vertex 4\n\
                property int x\nproperty int y\nproperty int z\nend_header\n4 0 1 2 3\n0 0 0\n2 0 0\n2 3 0\n0 3 0";
    for end in ["", "\n", "\r\n\n"] {
        let found = Prepared::from_bytes((text.to_owned() + end).as_bytes(), None, Beside::Nothing, &PLAIN).unwrap();
        assert_eq!((found.report.triangles_read, found.report.area_m2), (2, 6.0));
    }
}

/// Nodes below nodes, a mirror, a quarter turn, a scale, and one mesh shown twice.
#[test]
fn nodes_place_the_meshes_of_a_document() {
    let mesh = brick([0.0; 3], [1.0, 2.0, 4.0]);
    let mut document = files::document(&mesh);
    let half = std::f64::consts::FRAC_1_SQRT_2;
    document["scenes"] = json!([{"nodes": [0]}]);
    document["nodes"] = json!([
        {"children": [1, 2], "translation": [10, 0, 0]},
        {"mesh": 0, "rotation": [0, 0, half, half], "scale": [1, 1, 2]},
        {"mesh": 0, "matrix": [-1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 5, 0, 1]},
    ]);
    let bytes = files::glb(&document, &files::buffer(&mesh));
    let found = Prepared::from_bytes(&bytes, None, Beside::Nothing, &PLAIN).unwrap();
    assert_eq!(found.report.triangles_read, 24);
    // Turned by 90° about z: x from −2 to 0, y from 0 to 1, z up to 8; mirrored: x from −1 to 0, y from 5 to 7.
    let [low, high] = found.report.box_m;
    let gap = |a: [f64; 3], b: [f64; 3]| (0..3).map(|k| (a[k] - b[k]).abs()).fold(0.0, f64::max);
    assert!(gap(low, [8.0, 0.0, 0.0]) < 1e-14 && gap(high, [10.0, 7.0, 8.0]) < 1e-14, "{low:?} {high:?}");
    // The mirrored one would count negative if its triangles had not been turned.
    assert!((found.report.solid.unwrap().volume_m3 - 24.0).abs() < 1e-12);
}

/// A square of two triangles, as a list, as a strip and as a fan, without indices.
#[test]
fn strips_and_fans_are_triangles() {
    let [a, b, c, d] = [[0.0; 3], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
    for (mode, corners) in [(4, vec![a, b, c, a, c, d]), (5, vec![a, b, d, c]), (6, vec![a, b, c, d])] {
        let mesh = cosplat_core::asset::TriangleMesh { vertices_m: corners, triangles: Vec::new() };
        let mut document = files::document(&mesh);
        document["meshes"][0]["primitives"] = json!([
            {"attributes": {"POSITION": 0}, "mode": mode},
            {"attributes": {"POSITION": 0}, "mode": 1},
        ]);
        let bytes = files::glb(&document, &files::buffer(&mesh));
        let found = Prepared::from_bytes(&bytes, None, Beside::Nothing, &PLAIN).unwrap();
        assert_eq!((found.report.triangles_read, found.report.area_m2), (2, 1.0), "mode {mode}");
        let up = |t: &[u32; 3]| {
            let [p, q, r] = found.mesh.corners(*t);
            (q - p).cross(&(r - p)).z > 0.0
        };
        assert!(found.mesh.triangles.iter().all(up), "mode {mode}: all are turned the same way");
        assert_eq!(found.report.notes, ["1 parts are points or lines and left out"]);
    }
}

#[test]
fn a_document_finds_its_buffer_beside_it() {
    let mesh = brick([0.0; 3], [1.0; 3]);
    let folder = tempfile::tempdir().unwrap();
    std::fs::create_dir(folder.path().join("parts of it")).unwrap();
    std::fs::write(folder.path().join("parts of it/a.bin"), files::buffer(&mesh)).unwrap();
    let mut document = files::document(&mesh);
    document["buffers"][0]["uri"] = json!("parts%20of%20it/a.bin");
    let path = folder.path().join("a.gltf");
    std::fs::write(&path, document.to_string()).unwrap();
    assert_eq!(Prepared::from_file(&path, &PLAIN).unwrap().report.triangles_read, 12);
}

/// All points but one in one place: what was compared with each other before would take an hour.
#[test]
fn many_points_in_one_place_are_welded_quickly() {
    let n = 200_000;
    let mut mesh = cosplat_core::asset::TriangleMesh {
        vertices_m: (0..n).map(|i| [f64::from(i % 1000) * 1e-9, 0.0, 0.0]).collect(),
        triangles: (0..n).step_by(3).map(|i| [i, i / 2, n]).collect(),
    };
    mesh.vertices_m.extend([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]);
    mesh.triangles.push([0, n, n + 1]);
    let start = std::time::Instant::now();
    let found = Prepared::from_mesh(mesh).unwrap();
    assert_eq!((found.mesh.vertices_m.len(), found.mesh.triangles.len()), (3, 1));
    assert!(start.elapsed().as_secs() < 1, "{:?}", start.elapsed());
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(128) })]

    /// Whatever single precision holds comes back from each format as it was.
    #[test]
    fn what_is_written_is_read(numbers in prop::collection::vec(-1e6_f32..1e6, 9..90)) {
        let vertices_m: Vec<[f64; 3]> = numbers.as_chunks::<3>().0.iter().map(|c| c.map(f64::from)).collect();
        let n = vertices_m.len() as u32;
        let mesh = cosplat_core::asset::TriangleMesh { vertices_m, triangles: (0..n - 2).map(|i| [i, i + 1, i + 2]).collect() };
        let corners = |m: &cosplat_core::asset::TriangleMesh| {
            m.triangles.iter().flatten().map(|i| m.vertices_m[*i as usize]).collect::<Vec<_>>()
        };
        for (ending, bytes) in files::all(&mesh) {
            let back = read(&bytes, Some(ending), Beside::Nothing).unwrap();
            prop_assert_eq!(corners(&back.mesh), corners(&mesh), "{}", ending);
        }
    }
}
