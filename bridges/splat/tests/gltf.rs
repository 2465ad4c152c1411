//! `.glb` files with `KHR_gaussian_splatting`: what is written is read, and what is not as it must be is refused by name.

mod common;
#[path = "common/refusal.rs"]
mod refusal;

use common::{data, some_splats};
use cosplat_splat::format::{encode, read, read_file};
use cosplat_splat::{Axes, Fault, Splats};
use refusal::Allowed;
use serde_json::{Value, json};

/// The document of 64 KiB at most becomes up to 250 bytes a byte, beside the Gaussians.
const ALLOWED: Allowed = Allowed { free: 20 << 20, each: 16 };

fn glb(splats: &Splats) -> Vec<u8> {
    encode(splats, Some("glb")).expect("`.glb` is written")
}

/// The two chunks of a file.
fn parts(bytes: &[u8]) -> (Value, Vec<u8>) {
    let json = u32::from_le_bytes([bytes[12], bytes[13], bytes[14], bytes[15]]) as usize;
    (serde_json::from_slice(&bytes[20..20 + json]).expect("a document"), bytes[28 + json..].to_vec())
}

fn joined(document: &Value, bin: &[u8]) -> Vec<u8> {
    let mut text = document.to_string().into_bytes();
    text.resize(text.len().next_multiple_of(4), b' ');
    let mut out = b"glTF".to_vec();
    let length = (28 + text.len() + bin.len()) as u32;
    out.extend([2, length, text.len() as u32, 0x4e4f_534a].into_iter().flat_map(u32::to_le_bytes));
    out.extend(text);
    out.extend([bin.len() as u32, 0x004e_4942].into_iter().flat_map(u32::to_le_bytes));
    out.extend(bin);
    out
}

/// A change of the document of a good file.
fn changed(change: impl FnOnce(&mut Value)) -> Vec<u8> {
    let (mut document, bin) = parts(&glb(&some_splats(3, 1, 7)));
    change(&mut document);
    joined(&document, &bin)
}

#[test]
fn what_is_written_is_read() {
    for degree in 0..=3 {
        let splats = some_splats(30, degree, 11);
        let back = read(&glb(&splats), None).unwrap().splats;
        assert_eq!((back.axes, back.sh_degree, back.len()), (Axes::Rub, degree, 30));
        let back = back.to_axes(Axes::Rdf);
        assert_eq!((&back.positions, &back.sh_dc, &back.sh_rest), (&splats.positions, &splats.sh_dc, &splats.sh_rest));
        for i in 0..30 {
            // Linear scales and opacities of 24 bits: half a unit of the last place, near 1 of α and of its rest.
            let scale = [0, 1, 2].map(|k| (back.log_scales[i][k] - splats.log_scales[i][k]).abs());
            assert!(scale.iter().all(|d| *d < 1e-6), "{scale:?}");
            assert!((back.opacity(i) - splats.opacity(i)).abs() < 1e-6);
            let length = splats.rotations[i].iter().map(|v| v * v).sum::<f32>().sqrt();
            assert!((0..4).all(|k| (back.rotations[i][k] - splats.rotations[i][k] / length).abs() < 1e-6));
        }
    }
    assert_eq!(read(&glb(&Splats::default()), None).unwrap().splats.len(), 0);
    let mut wild = some_splats(4, 0, 3);
    wild.positions[2] = [f32::NAN, 0.0, 0.0];
    wild.rotations[0] = [0.0; 4];
    let back = read(&glb(&wild), None).unwrap().splats;
    assert_eq!((back.len(), back.rotations[0]), (3, [1.0, 0.0, 0.0, 0.0]), "glTF has neither");
}

#[test]
fn the_document_is_what_the_extension_asks_for() {
    let splats = some_splats(5, 3, 2);
    let (document, bin) = parts(&glb(&splats));
    let primitive = &document["meshes"][0]["primitives"][0];
    assert_eq!(document["extensionsUsed"], json!(["KHR_gaussian_splatting"]));
    let extension = &primitive["extensions"]["KHR_gaussian_splatting"];
    assert_eq!((&extension["kernel"], &extension["colorSpace"]), (&json!("ellipse"), &json!("srgb_rec709_display")));
    assert_eq!((&primitive["mode"], primitive["attributes"].as_object().unwrap().len()), (&json!(0), 4 + 16));
    for (name, kind) in [("ROTATION", "VEC4"), ("SCALE", "VEC3"), ("OPACITY", "SCALAR"), ("SH_DEGREE_3_COEF_6", "VEC3")]
    {
        let number = primitive["attributes"][format!("KHR_gaussian_splatting:{name}")].as_u64().unwrap() as usize;
        let accessor = &document["accessors"][number];
        assert_eq!((&accessor["type"], &accessor["componentType"]), (&json!(kind), &json!(5126)));
    }
    // Bounds of places are demanded; y and z point the other way than in a `.ply`.
    let least = splats.positions.iter().map(|p| -p[1]).fold(f32::INFINITY, f32::min);
    assert_eq!(document["accessors"][0]["min"][1], json!(least));
    let views = document["bufferViews"].as_array().unwrap();
    assert!(views.iter().all(|v| v["byteOffset"].as_u64().unwrap() % 4 == 0));
    assert_eq!(document["buffers"][0]["byteLength"], json!(bin.len()));
}

/// Other writers pack rotations, scales and opacities into integers.
#[test]
fn packed_attributes_are_read() {
    let (mut document, mut bin) = parts(&glb(&some_splats(1, 0, 7)));
    let start = bin.len();
    bin.extend([0, 0, 0, 127, 51, 0]);
    bin.extend(2_u16.to_le_bytes().repeat(3));
    let view = |from: usize, n: usize| json!({ "buffer": 0, "byteOffset": start + from, "byteLength": n });
    document["bufferViews"].as_array_mut().unwrap().extend([view(0, 4), view(4, 1), view(6, 6)]);
    let accessor = |view: usize, component: u32, normalized: bool, kind: &str| json!({ "bufferView": view, "componentType": component, "normalized": normalized, "count": 1, "type": kind });
    document["accessors"][1] = accessor(5, 5120, true, "VEC4");
    document["accessors"][3] = accessor(6, 5121, true, "SCALAR");
    document["accessors"][2] = accessor(7, 5123, false, "VEC3");
    let back = read(&joined(&document, &bin), None).unwrap().splats;
    assert_eq!(back.rotations, [[1.0, 0.0, 0.0, 0.0]]);
    assert!((back.opacity(0) - 0.2).abs() < 1e-6 && (back.scales(0)[0] - 2.0).abs() < 1e-6);
}

type Case = refusal::Case<Fault>;

/// A case with a change of the document of a good file.
fn case(name: &'static str, fault: Fault, part: &'static str, change: impl FnOnce(&mut Value)) -> Case {
    (name, "glb", changed(change), fault, part)
}

/// Cases in the primitive.
fn in_primitive() -> Vec<Case> {
    let one = |name, fault, part, change: &dyn Fn(&mut Value)| {
        case(name, fault, part, |d| change(&mut d["meshes"][0]["primitives"][0]))
    };
    let inner = |p: &mut Value| p["extensions"]["KHR_gaussian_splatting"]["extensions"] = json!({});
    let bare = |p: &mut Value| p["attributes"] = json!({ "POSITION": 0 });
    vec![
        one("a surface", Fault::Unsupported, "no primitive", &|p| p["extensions"] = json!({})),
        one("compressed", Fault::Unsupported, "compression", &inner),
        one("no scales", Fault::Header, "it has no `KHR_gaussian_splatting:SCALE`", &bare),
        one("no accessor", Fault::Header, "no accessor 99", &|p| p["attributes"]["POSITION"] = json!(99)),
    ]
}

#[test]
fn what_is_wrong_is_said() {
    let turn = refusal::turn();
    let good = glb(&some_splats(3, 1, 7));
    let many = |d: &mut Value| {
        let one = d["meshes"][0]["primitives"][0].clone();
        d["meshes"][0]["primitives"] = Value::Array(vec![one; 60]);
    };
    let most = u64::MAX;
    let mut cases = in_primitive();
    cases.extend([
        ("cut off", "glb", good[..good.len() - 1].to_vec(), Fault::Truncated, "header"),
        ("an old container", "glb", [&b"glTF\x01\0\0\0"[..], &good[8..]].concat(), Fault::Unsupported, "version 1"),
        case("a moved node", Fault::Unsupported, "a node moves", |d| d["nodes"][0]["translation"] = json!([0, 0, 1])),
        case("too many", Fault::TooLarge, "more Gaussians", |d| d["accessors"][0]["count"] = json!(most)),
        case("other numbers", Fault::Header, "in place of 3", |d| d["accessors"][1]["count"] = json!(2)),
        case("sparse", Fault::Unsupported, "sparse", |d| d["accessors"][0]["sparse"] = json!({})),
        case("a wild offset", Fault::Truncated, "POSITION", |d| d["bufferViews"][0]["byteOffset"] = json!(most)),
        case("a wild stride", Fault::Truncated, "POSITION", |d| d["bufferViews"][0]["byteStride"] = json!(most)),
        case("shown again and again", Fault::TooLarge, "more Gaussians", many),
        case("a long document", Fault::TooLarge, "its document", |d| d["extras"] = json!("x".repeat(1 << 16))),
        case("no document", Fault::Header, "JSON", |d| *d = json!([1])),
    ]);
    let one = |bytes: &[u8], ending: &str| read(bytes, Some(ending)).map(|_| ()).map_err(|e| (e.fault, e.to_string()));
    refusal::check(&turn, cases, ALLOWED, one);
    // Much of little is read, and takes no more memory than it may.
    let nodes = changed(|d| d["nodes"] = Value::Array(vec![json!({}); 20_000]));
    assert!(refusal::bounded(&turn, nodes.len(), ALLOWED, || read(&nodes, None)).is_ok());
}

#[test]
fn a_capture_becomes_a_file_of_it() {
    let Some(folder) = data() else { return };
    let splats = read_file(&folder.join("splats/playbot_31k.v4.spz")).unwrap().splats;
    let back = read(&glb(&splats), None).unwrap().splats;
    assert_eq!((back.len(), back.sh_degree, &back.positions), (31_000, 2, &splats.positions));
}
