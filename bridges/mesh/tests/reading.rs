//! OBJ files: what is read, and how what is wrong is said.

mod common;

use common::{brick, data};
use cosplat_mesh::format::{self, Beside};
use cosplat_mesh::{Fault, Prepared, Recipe};
use nalgebra::Vector3;
use proptest::prelude::*;

const PLAIN: Recipe = Recipe { metres_per_unit: 1.0, up: [0.0, 0.0, 1.0] };

/// The unit cube: quads, forward and backward indices, a continued line, normals, groups, comments.
const CUBE: &str = "# a cube\r
o cube\r
v 0 0 0\nv 1 0 0\nv 1 1 0 # comment\nv 0 1 0\n
v 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1 0.5 0.5 0.5
vn 0 0 1\nvt 0 0
f 1 4 3 2
f 5/1 6/1 7/1 8/1\nf 1//1 2//1 6//1 5//1
f -6/1/1 -5/1/1 -1/1/1 \\
  -2/1/1
usemtl x
f 1 5 8 4
f 2 3 7 6
";

#[test]
fn a_cube_is_a_cube() {
    let found = Prepared::from_bytes(CUBE.as_bytes(), Some("obj"), Beside::Nothing, &PLAIN).unwrap();
    let solid = found.report.solid.unwrap();
    assert_eq!((found.report.triangles_read, found.report.open_edges, found.mesh.vertices_m.len()), (12, 0, 8));
    assert!((solid.volume_m3 - 1.0).abs() < 1e-14 && (found.report.area_m2 - 6.0).abs() < 1e-14);
}

#[test]
fn scale_and_up_axis_are_applied() {
    for up in [[0.0, 1.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, -1.0], [1.0, 0.0, 0.0], [0.3, -0.2, 0.4]] {
        let found =
            Prepared::from_bytes(CUBE.as_bytes(), Some("obj"), Beside::Nothing, &Recipe { metres_per_unit: 0.5, up })
                .unwrap();
        let solid = found.report.solid.unwrap();
        assert!((solid.volume_m3 - 0.125).abs() < 1e-14, "{up:?}");
        // The middle of the cube along the up axis is its height.
        let height = Vector3::from(up).normalize().dot(&Vector3::repeat(0.25));
        assert!((solid.centroid_m[2] - height).abs() < 1e-14, "{up:?}");
    }
    for (metres_per_unit, up) in [(0.0, [0.0, 1.0, 0.0]), (f64::NAN, [0.0, 1.0, 0.0]), (1.0, [0.0; 3])] {
        let error =
            Prepared::from_bytes(CUBE.as_bytes(), Some("obj"), Beside::Nothing, &Recipe { metres_per_unit, up })
                .unwrap_err();
        assert_eq!(error.fault, Fault::Value);
    }
}

#[test]
fn vertices_in_one_place_are_welded() {
    let mut mesh = brick([100.0, 0.0, 0.0], [1.0, 2.0, 3.0]);
    // Printed with seven digits, the same corner differs in the last; a triangle without area is left over.
    for (i, v) in mesh.vertices_m.iter_mut().enumerate() {
        v[0] += 1e-7 * (i % 3) as f64;
    }
    mesh.triangles.push([0, 1, 1]);
    mesh.vertices_m.push([50.0; 3]);
    assert!(mesh.open_edges() > 0);
    let found = Prepared::from_mesh(mesh).unwrap();
    assert_eq!((found.mesh.vertices_m.len(), found.report.welded, found.report.degenerate), (8, 17, 1));
    assert_eq!(found.report.open_edges, 0);
    assert!((found.report.solid.unwrap().volume_m3 / 6.0 - 1.0).abs() < 1e-6);
}

#[test]
fn mistakes_have_their_line_and_a_way_out() {
    let cases = [
        ("v 0 0\n", Fault::Syntax, "line 1", "three coordinates"),
        ("v 0 0 0\nv 1 x 0\n", Fault::Value, "line 2", "`x`"),
        ("v 0 0 nan\n", Fault::Value, "line 1", "nan"),
        ("v 0 0 0\n\nv 1 0 0\nf 1 2 3\n", Fault::Index, "line 4", "vertex 3 of 2"),
        ("v 0 0 0\nf 0 1 1\n", Fault::Index, "line 2", "vertex 0"),
        ("v 0 0 0\nf -2 1 1\n", Fault::Index, "line 2", "vertex -2"),
        ("v 0 0 0\nf 1 1\n", Fault::Syntax, "line 2", "2 corners"),
        ("v 0 0 0\nf a b c\n", Fault::Syntax, "line 2", "`a`"),
        ("v 0 0 0\nf 9223372036854775807 1 1\n", Fault::Index, "line 2", "vertex"),
        ("", Fault::Empty, "whole file", "0 vertices"),
        ("v 0 0 0\nf 1 1 1\n", Fault::Empty, "whole mesh", "zero or too large"),
        ("v 1e300 0 0\nv 0 1e300 0\nv 0 0 1e300\nf 1 2 3\n", Fault::Empty, "whole mesh", "zero or too large"),
    ];
    for (text, fault, place, part) in cases {
        let error = Prepared::from_bytes(text.as_bytes(), Some("obj"), Beside::Nothing, &PLAIN).unwrap_err();
        assert_eq!((error.fault, error.place.as_str()), (fault, place), "{text:?}: {error}");
        assert!(error.what.contains(part) && !error.advice.is_empty(), "{text:?}: {error}");
    }
    let error = Prepared::from_file(std::path::Path::new("no/such.obj"), &PLAIN).unwrap_err();
    assert_eq!((error.fault, error.file.as_str()), (Fault::Io, "no/such.obj"));
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(256) })]

    #[test]
    fn no_bytes_make_the_reader_panic(bytes in prop::collection::vec(any::<u8>(), 0..400)) {
        let _ = Prepared::from_bytes(&bytes, Some("obj"), Beside::Nothing, &PLAIN);
    }

    #[test]
    fn no_words_make_the_reader_panic(words in prop::collection::vec("(v|f|-?[0-9]{1,3}|1e[0-9]{1,3}|/|\n|\\\\\n|#)", 0..80)) {
        let text = words.join(" ");
        if let Ok(format::Decoded { mesh, .. }) = format::read(text.as_bytes(), Some("obj"), Beside::Nothing) {
            prop_assert!(mesh.triangles.iter().flatten().all(|&i| (i as usize) < mesh.vertices_m.len()));
        }
        let _ = Prepared::from_bytes(text.as_bytes(), Some("obj"), Beside::Nothing, &PLAIN);
    }
}

/// Triangles and volumes as an independent script counts them.
#[test]
fn published_meshes_are_read() {
    let Some(folder) = data() else { return };
    let y = [0.0, 1.0, 0.0];
    let z = [0.0, 0.0, 1.0];
    let files = [
        ("chrono_rock1.obj", z, true, 0),
        ("chrono_rock2.obj", z, true, 0),
        ("chrono_rock3.obj", z, true, 0),
        ("chrono_rock4.obj", z, true, 0),
        ("chrono_rock5.obj", z, true, 0),
        ("spot.obj", y, true, 23_062),
        ("spot_low_resolution.obj", y, true, 1654),
        ("penguin.obj", y, true, 6720),
        ("torus.obj", y, true, 0),
        ("genesis_duck.obj", y, true, 31_872),
        ("hammer.obj", z, true, 60_160),
        ("mountain.obj", y, false, 50_562),
        ("genesis_cloth.obj", z, false, 12_482),
    ];
    for (file, up, closed, triangles) in files {
        let start = std::time::Instant::now();
        let found =
            Prepared::from_file(&folder.join("meshes").join(file), &Recipe { metres_per_unit: 1.0, up }).unwrap();
        println!("{file}: {} ({:.0} ms)", found.report, start.elapsed().as_secs_f64() * 1e3);
        assert_eq!(found.report.open_edges == 0, closed, "{file}");
        assert_eq!(found.report.solid.is_some(), closed, "{file}");
        assert!(triangles == 0 || found.report.triangles_read == triangles, "{file}");
    }
}
