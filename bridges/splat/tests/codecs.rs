//! Files: what is written is read, and what is packed is read within its steps.

#![allow(clippy::float_cmp, reason = "these numbers are read, not computed")]

mod common;

use common::packed::gap;
use common::{data, some_attributes, some_splats, spz_gzip, spz_streams};
use cosplat_splat::format::{self, read, read_file};
use cosplat_splat::{Axes, Fault, Splats};
use proptest::prelude::*;

fn ply_writer() -> fn(&Splats) -> Vec<u8> {
    format::FORMATS.iter().find(|f| f.name == "ply").and_then(|f| f.write).expect("`.ply` is written")
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(256) })]

    #[test]
    fn ply_comes_back_bit_for_bit(count in 0_usize..40, degree in 0_u8..=3, seed in any::<u64>()) {
        let splats = some_splats(count, degree, seed);
        let back = read(&ply_writer()(&splats), None).unwrap();
        prop_assert_eq!(back.splats, splats);
    }

    #[test]
    fn spz_versions_agree(count in 0_usize..40, degree in 0_u8..=3, seed in any::<u64>()) {
        let attributes = some_attributes(count, degree, 3, seed);
        let old = read(&spz_gzip(3, count as u32, degree, &attributes), None).unwrap();
        let new = read(&spz_streams(count as u32, degree, &attributes), None).unwrap();
        prop_assert_eq!(&old.splats, &new.splats);
        prop_assert!(old.splats.is_consistent() && old.splats.axes == Axes::Rub);
        for q in &old.splats.rotations {
            let length: f32 = q.iter().map(|v| v * v).sum();
            prop_assert!(length > 0.999, "{q:?}");
        }
    }

    /// Versions 1 and 2 differ in their positions alone.
    #[test]
    fn the_first_spz_has_positions_in_half_precision(count in 1_usize..40, seed in any::<u64>()) {
        let mut attributes = some_attributes(count, 1, 2, seed);
        let second = read(&spz_gzip(2, count as u32, 1, &attributes), None).unwrap().splats;
        // −1.5, 2⁻¹⁴ and 65504: half precision of a usual, the smallest normal and the largest number.
        attributes[0] = [0xbe00_u16, 0x0400, 0x7bff].map(u16::to_le_bytes).concat().repeat(count);
        let first = read(&spz_gzip(1, count as u32, 1, &attributes), None).unwrap().splats;
        prop_assert_eq!(&first.positions, &vec![[-1.5, 1.0 / 16384.0, 65504.0]; count]);
        prop_assert_eq!(Splats { positions: second.positions.clone(), ..first }, second);
    }

    #[test]
    fn other_axes_and_back_are_the_same_bits(degree in 0_u8..=3, seed in any::<u64>()) {
        let splats = some_splats(5, degree, seed);
        let turned = splats.clone().to_axes(Axes::Rub);
        prop_assert!(turned != splats);
        prop_assert_eq!(turned.to_axes(Axes::Rdf), splats);
    }

    #[test]
    fn ply_bits_of_any_kind_survive(bits in prop::collection::vec(any::<u32>(), 14)) {
        let f = |i: usize| f32::from_bits(bits[i]);
        let splats = Splats {
            positions: vec![[f(0), f(1), f(2)]],
            rotations: vec![[f(3), f(4), f(5), f(6)]],
            log_scales: vec![[f(7), f(8), f(9)]],
            opacity_logits: vec![f(10)],
            sh_dc: vec![[f(11), f(12), f(13)]],
            ..Splats::default()
        };
        let once = ply_writer()(&splats);
        prop_assert_eq!(&ply_writer()(&read(&once, None).unwrap().splats), &once);
    }
}

/// A file with every property somewhere else, of other types, with lists and elements around it, in all encodings.
#[test]
fn ply_properties_are_found_by_name() {
    let names = "rot_3 opacity z x y scale_2 scale_0 scale_1 f_dc_2 f_dc_0 f_dc_1 rot_0 rot_1 rot_2 mass";
    let header = |encoding: &str| {
        let mut h = format!("ply\nformat {encoding} 1.0\ncomment Vertical axis: y\nelement face 2\n");
        h += "property list uchar int vertex_indices\nelement vertex 2\n";
        for name in names.split(' ') {
            h.push_str(&["property ", if name == "mass" { "short " } else { "double " }, name, "\n"].concat());
        }
        (h + "element other 3\nproperty float v\nend_header\n").into_bytes()
    };
    let rows = [1, 2].map(|r| (0..15).map(|i| f64::from(i * r) - 3.0).collect::<Vec<_>>());
    let mut text = header("ascii");
    text.extend(b"3 0 1 2\n0\n");
    for row in &rows {
        text.extend(row.iter().map(f64::to_string).collect::<Vec<_>>().join(" ").into_bytes());
        text.push(b'\n');
    }
    let binary = |big: bool| {
        let mut out = header(if big { "binary_big_endian" } else { "binary_little_endian" });
        let int = |v: i32| if big { v.to_be_bytes() } else { v.to_le_bytes() };
        out.push(3);
        out.extend([0, 1, 2].map(int).concat());
        out.push(0);
        for row in &rows {
            out.extend(row[..14].iter().flat_map(|v| if big { v.to_be_bytes() } else { v.to_le_bytes() }));
            let mass = row[14] as i16;
            out.extend(if big { mass.to_be_bytes() } else { mass.to_le_bytes() });
        }
        out
    };
    let first = read(&text, None).unwrap();
    assert_eq!(first.splats.positions, [[0.0, 1.0, -1.0], [3.0, 5.0, 1.0]]);
    assert_eq!(first.splats.rotations[0], [8.0, 9.0, 10.0, -3.0]);
    assert_eq!(first.splats.log_scales[0], [3.0, 4.0, 2.0]);
    assert_eq!(first.splats.sh_dc[0], [6.0, 7.0, 5.0]);
    assert_eq!((first.splats.extras[0].name.as_str(), &first.splats.extras[0].values[..]), ("mass", &[11.0, 25.0][..]));
    assert_eq!(first.notes, ["comment: Vertical axis: y"]);
    for big in [false, true] {
        assert_eq!(read(&binary(big), None).unwrap(), first, "big endian: {big}");
    }
}

#[test]
fn colours_of_bytes_replace_a_missing_base_band() {
    let mut text = "ply\nformat ascii 1.0\nelement vertex 1\n".to_owned();
    for name in "x y z opacity scale_0 scale_1 scale_2 rot_0 rot_1 rot_2 rot_3".split(' ') {
        text.push_str(&["property float ", name, "\n"].concat());
    }
    text += "property uchar red\nproperty uchar green\nproperty uchar blue\nend_header\n";
    text += "0 0 0 1 0 0 0 1 0 0 0 0 255 51\n";
    let dc = read(text.as_bytes(), None).unwrap().splats.sh_dc[0];
    let colours = dc.map(|v| 0.5 + cosplat_splat::SH_C0 * f64::from(v));
    assert!(colours.iter().zip([0.0, 1.0, 0.2]).all(|(a, b)| (a - b).abs() < 1e-7), "{colours:?}");
}

#[test]
fn faults_say_what_to_do() {
    let cloud = b"ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty float z\nend_header\n0 0 0\n";
    let error = read(cloud, None).unwrap_err();
    assert_eq!(error.fault, Fault::Header);
    assert!(error.to_string().contains("scale_0") && error.advice.contains("point cloud"), "{error}");
    let missing = read_file(std::path::Path::new("no/such/file.ply")).unwrap_err();
    assert!(missing.fault == Fault::Io && missing.file == "no/such/file.ply", "{missing}");
    assert_eq!(read(b"solid cube", Some("stl")).unwrap_err().fault, Fault::UnknownFormat);
    assert_eq!(read(&common::spz_header(5, 0, 0, 12, 0, 0), None).unwrap_err().fault, Fault::Unsupported);
}

/// Four Gaussians of an independent writer (splat-transform, MIT), in every container.
#[test]
fn fixtures_of_another_writer() {
    let Some(folder) = data() else { return };
    for name in ["minimal-v2.spz", "minimal-v3.spz", "minimal-v4.spz", "minimal-raw.spz", "minimal.splat"] {
        let s = read_file(&folder.join("fixtures").join(name)).unwrap().splats;
        assert_eq!(s.len(), 4, "{name}");
        for i in 0..4 {
            let p = s.positions[i].map(f32::abs);
            assert!(p.iter().all(|v| *v == 0.0 || *v == 1.0), "{name} {p:?}");
            assert!(s.scales(i).iter().all(|v| (v - 0.1).abs() < 2e-3), "{name} {:?}", s.scales(i));
            assert!((s.opacity(i) - 0.902).abs() < 1e-3, "{name}");
        }
    }
}

/// The pictures of a `.sog` hold the same scene as the `.ply` that was made from it.
#[test]
fn sog_is_the_scene_it_was_made_from() {
    let small = read(&common::sog(5, 1), None).unwrap().splats;
    assert_eq!((small.len(), small.sh_degree, small.rest(4).len()), (5, 1, 3));
    let Some(folder) = data() else { return };
    let load = |name: &str| read_file(&folder.join("splats").join(name)).unwrap().splats;
    let g = gap(&load("playbot_31k.sog"), &load("playbot_31k.ply"));
    assert!(
        g.position < 1e-6 && g.log_scale < 1e-6 && g.opacity < 1e-6 && g.dc < 1e-6 && g.rest < 1e-6,
        "{:.1e}",
        g.position
    );
    assert!(g.rotation < 1e-3, "{}", g.rotation);
}

/// One scene, decoded from `.ply` and from two versions of `.spz`, agrees within the steps of the coding.
#[test]
fn a_captured_scene_agrees_between_formats() {
    let Some(folder) = data() else { return };
    let load = |name: &str| read_file(&folder.join("splats").join(name)).unwrap().splats.to_axes(Axes::Rdf);
    let ply = load("playbot_31k.ply");
    let (v3, v4) = (load("playbot_31k.v3.spz"), load("playbot_31k.v4.spz"));
    assert_eq!((ply.len(), ply.sh_degree, ply.sh_rest.len()), (31_000, 2, 31_000 * 8));
    // Writers may order Gaussians along a curve: pair them by place.
    let mut order: Vec<u32> = (0..31_000).collect();
    let by_place = |s: &Splats| {
        let key = |i: u32| s.positions[i as usize].map(|v| (f64::from(v) * 4096.0).round() as i64);
        let mut all = order.clone();
        all.sort_by_key(|&i| key(i));
        all
    };
    let same_order = gap(&ply, &v4).position < 1e-3;
    // A byte holds a base band of ±½ / 0.15 and higher bands of −1 to 127/128; the scene has some beyond.
    let mut ply = ply;
    for c in ply.sh_dc.iter_mut().flatten() {
        *c = c.clamp(-0.5 / 0.15, 0.5 / 0.15);
    }
    for c in ply.sh_rest.iter_mut().flatten() {
        *c = c.clamp(-1.0, 127.0 / 128.0);
    }
    let (mut p, mut q, mut r) = (ply.clone(), v3.clone(), v4.clone());
    if !same_order {
        (p, q, r) = (ply.select(&by_place(&ply)), v3.select(&by_place(&v3)), v4.select(&by_place(&v4)));
    }
    order.clear();
    for (name, s) in [("v3", &q), ("v4", &r)] {
        let g = gap(&p, s);
        println!(
            "{name}: position {:.2e} log scale {:.2e} opacity {:.2e} rotation {:.2e} dc {:.2e} rest {:.2e}",
            g.position, g.log_scale, g.opacity, g.rotation, g.dc, g.rest
        );
        assert!(g.position <= 0.5 / 4096.0 + 1e-6, "{name}");
        assert!(g.log_scale <= 0.5 / 16.0 + 1e-4, "{name}");
        assert!(g.opacity <= 0.5 / 255.0 + 1e-4, "{name}");
        assert!(g.rotation <= 3e-3, "{name}");
        assert!(g.dc <= 0.5 / 255.0 / 0.15 + 1e-4, "{name}");
        assert!(g.rest <= 8.5 / 128.0, "{name}");
    }
    let g = gap(&q, &r);
    assert!(g.position + g.log_scale + g.opacity + g.dc + g.rest < 1e-9, "the two versions hold the same bytes");
}
