//! Damaged and malicious glTF, each by its name, and what documents may name beside them.

mod common;
#[path = "common/refused.rs"]
mod refused;

use common::{brick, files};
use cosplat_mesh::Fault;
use cosplat_mesh::format::Beside;
use refused::{Case, check, cut, put, turn};
use serde_json::{Value, json};

/// A document with one thing changed.
fn changed(pointer: &str, value: Value) -> Vec<u8> {
    let mesh = brick([0.0; 3], [1.0; 3]);
    let mut document = files::document(&mesh);
    let (parent, key) = pointer.rsplit_once('/').expect("a pointer");
    let parent = document.pointer_mut(parent).expect("it is there");
    match key.parse::<usize>() {
        Ok(k) => parent[k] = value,
        Err(_) => parent[key] = value,
    }
    files::glb(&document, &files::buffer(&mesh))
}

#[expect(clippy::too_many_lines, reason = "it is a table")]
#[test]
fn gltf_by_name() {
    let turn = turn();
    let mesh = brick([0.0; 3], [1.0; 3]);
    let glb = || files::glb(&files::document(&mesh), &files::buffer(&mesh));
    let copies = |n: usize| json!((0..n).map(|_| json!({"mesh": 0})).collect::<Vec<_>>());
    let mut bomb = files::document(&mesh);
    bomb["nodes"] = copies(40_000);
    bomb["scenes"] = json!([{"nodes": (0..40_000).collect::<Vec<_>>()}]);
    // Every node hangs twice below the one before: 2⁴⁰ ways to the last.
    let twice =
        json!((0..40).map(|k| json!({"children": [k + 1, k + 1]})).chain([json!({"mesh": 0})]).collect::<Vec<_>>());
    let deep = [b"[".repeat(100_000), b"]".repeat(100_000)].concat();
    let word = |at, value: u32| put(glb(), at, &value.to_le_bytes());
    let no_number = put(files::buffer(&mesh), 4, &f32::NAN.to_le_bytes());
    check(
        &turn,
        vec![
            ("a length beyond the end", "glb", word(8, u32::MAX), Fault::Truncated, "4294967295 bytes"),
            ("a length of nothing", "glb", word(8, 0), Fault::Header, "first chunk"),
            ("a chunk beyond the end", "glb", word(12, u32::MAX), Fault::Header, "first chunk"),
            ("a chunk of another kind", "glb", word(16, 7), Fault::Header, "first chunk"),
            ("the container of version 1", "glb", word(4, 1), Fault::Unsupported, "version 1"),
            ("cut inside the header", "glb", glb()[..11].to_vec(), Fault::Truncated, "20 bytes"),
            ("cut inside the buffer", "glb", cut(glb(), 9), Fault::Truncated, "header"),
            ("glTF of version 1", "glb", changed("/asset/version", json!("1.0")), Fault::Unsupported, "1.0"),
            ("no JSON", "gltf", b"{\"asset\":".to_vec(), Fault::Syntax, "JSON, line 1, column 9"),
            ("JSON without an end of lists", "gltf", deep, Fault::Syntax, "JSON"),
            (
                "a required extension",
                "glb",
                changed("/extensionsRequired", json!(["KHR_draco_mesh_compression"])),
                Fault::Unsupported,
                "KHR_draco",
            ),
            ("no scene of that number", "glb", changed("/scene", json!(1)), Fault::Header, "scene"),
            (
                "no node of that number",
                "glb",
                changed("/scenes/0/nodes", json!([1])),
                Fault::Header,
                "node: number 1 of 1",
            ),
            (
                "a node below itself",
                "glb",
                changed("/nodes/0", json!({"children": [0]})),
                Fault::Header,
                "below itself",
            ),
            (
                "nodes below two others",
                "glb",
                changed("/nodes", twice),
                Fault::Header,
                "it hangs below itself or below two",
            ),
            ("a mesh shown 40000 times", "glb", files::glb(&bomb, &files::buffer(&mesh)), Fault::TooLarge, "mesh 0"),
            (
                "a rotation of zero",
                "glb",
                changed("/nodes/0", json!({"mesh": 0, "rotation": [0, 0, 0, 0]})),
                Fault::Value,
                "node 0: its rotation is zero",
            ),
            (
                "an infinite place",
                "glb",
                changed("/nodes/0", json!({"mesh": 0, "scale": [1e308, 1e308, 1e308], "matrix": vec![1e308; 16]})),
                Fault::Value,
                "no finite position",
            ),
            ("no mesh of that number", "glb", changed("/nodes/0/mesh", json!(3)), Fault::Header, "mesh: number 3"),
            ("a negative number", "glb", changed("/nodes/0/mesh", json!(-1)), Fault::Syntax, "invalid value"),
            (
                "no accessor of that number",
                "glb",
                changed("/meshes/0/primitives/0/indices", json!(9)),
                Fault::Header,
                "accessor: number 9",
            ),
            ("an unknown mode", "glb", changed("/meshes/0/primitives/0/mode", json!(7)), Fault::Header, "7 is no mode"),
            ("the largest count", "glb", changed("/accessors/0/count", json!(u64::MAX)), Fault::TooLarge, "vertices"),
            (
                "a count beyond the view",
                "glb",
                changed("/accessors/0/count", json!(25)),
                Fault::Truncated,
                "accessor 0: 300 bytes",
            ),
            (
                "the largest offset",
                "glb",
                changed("/accessors/1/byteOffset", json!(u64::MAX)),
                Fault::Truncated,
                "accessor 1",
            ),
            (
                "positions of bytes",
                "glb",
                changed("/accessors/0/componentType", json!(5121)),
                Fault::Header,
                "accessor 0",
            ),
            (
                "indices of fractions",
                "glb",
                changed("/accessors/1/componentType", json!(5126)),
                Fault::Header,
                "indices are SCALAR",
            ),
            ("sparse numbers", "glb", changed("/accessors/0/sparse", json!({"count": 1})), Fault::Header, "sparse"),
            ("no view", "glb", changed("/accessors/0/bufferView", Value::Null), Fault::Header, "no buffer view"),
            (
                "a view beyond the buffer",
                "glb",
                changed("/bufferViews/1/byteLength", json!(u64::MAX)),
                Fault::Truncated,
                "accessor 1",
            ),
            (
                "the largest stride",
                "glb",
                changed("/bufferViews/0/byteStride", json!(u64::MAX)),
                Fault::Truncated,
                "accessor 0",
            ),
            ("a stride of one", "glb", changed("/bufferViews/0/byteStride", json!(1)), Fault::Header, "1 bytes apart"),
            (
                "no buffer of that number",
                "glb",
                changed("/bufferViews/0/buffer", json!(1)),
                Fault::Header,
                "buffer: number 1",
            ),
            (
                "a buffer longer than the chunk",
                "glb",
                changed("/buffers/0/byteLength", json!(10_000)),
                Fault::Truncated,
                "buffer 0: 10000",
            ),
            (
                "the largest buffer",
                "glb",
                changed("/buffers/0/byteLength", json!(u64::MAX)),
                Fault::TooLarge,
                "buffers",
            ),
            (
                "text without a buffer",
                "gltf",
                files::document(&mesh).to_string().into_bytes(),
                Fault::Header,
                "no binary chunk",
            ),
            ("a buffer that is no base64", "gltf", with_uri("data:;base64,!!!!"), Fault::Header, "no base64"),
            (
                "a position that is no number",
                "glb",
                files::glb(&files::document(&mesh), &no_number),
                Fault::Value,
                "position 0 is 0, NaN, 0",
            ),
            ("an index beyond", "glb", changed("/accessors/0/count", json!(23)), Fault::Index, "vertex 23 of 23"),
            ("a file where there are none", "gltf", with_uri("a.bin"), Fault::Io, "no files beside it"),
        ],
        Beside::Nothing,
    );
}

/// A document with its buffer in that file.
fn with_uri(uri: &str) -> Vec<u8> {
    let mut document = files::document(&brick([0.0; 3], [1.0; 3]));
    document["buffers"][0]["uri"] = json!(uri);
    document.to_string().into_bytes()
}

#[test]
fn no_document_reads_what_is_not_beside_it() {
    let turn = turn();
    let folder = tempfile::tempdir().unwrap();
    let (inside, secret) = (folder.path().join("inside"), folder.path().join("secret.bin"));
    std::fs::create_dir(&inside).unwrap();
    std::fs::write(&secret, files::buffer(&brick([0.0; 3], [1.0; 3]))).unwrap();
    std::fs::write(inside.join("short.bin"), [0; 10]).unwrap();
    std::fs::create_dir(inside.join("folder.bin")).unwrap();
    let absolute = secret.display().to_string();
    let downwards = "no path to a file beside or below it";
    let mut cases: Vec<Case> = vec![
        ("the folder above", "gltf", with_uri("../secret.bin"), Fault::Io, downwards),
        ("down and up again", "gltf", with_uri("folder.bin/../../secret.bin"), Fault::Io, downwards),
        ("dots that are escaped", "gltf", with_uri("%2e%2e/secret.bin"), Fault::Io, downwards),
        ("an absolute path", "gltf", with_uri(&absolute), Fault::Io, downwards),
        ("a URL of a file", "gltf", with_uri(&format!("file://{absolute}")), Fault::Io, downwards),
        ("a URL", "gltf", with_uri("http://localhost/a.bin"), Fault::Io, downwards),
        ("slashes of another system", "gltf", with_uri("..\\secret.bin"), Fault::Io, downwards),
        ("no name", "gltf", with_uri(""), Fault::Io, downwards),
        ("a file that is not there", "gltf", with_uri("none.bin"), Fault::Io, "cannot read `none.bin`"),
        ("a file that is too short", "gltf", with_uri("short.bin"), Fault::Io, "no file of at least 360 bytes"),
        ("a folder", "gltf", with_uri("folder.bin"), Fault::Io, "no file of at least"),
    ];
    #[cfg(unix)]
    {
        std::os::unix::fs::symlink(&secret, inside.join("link.bin")).unwrap();
        cases.push(("a link to elsewhere", "gltf", with_uri("link.bin"), Fault::Io, "a link to a file elsewhere"));
    }
    check(&turn, cases, Beside::Folder(&inside));
}
