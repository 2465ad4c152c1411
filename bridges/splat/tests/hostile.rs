//! Damaged and malicious files give an error or a result, never a panic, and never much memory.

mod common;

use std::time::{Duration, Instant};

use common::packed::{chunked_ply, ksplat};
use common::{Random, some_attributes, some_splats, spz_gzip, spz_header, spz_streams};
use cosplat_splat::format::{encode, read};
use cosplat_splat::{Fault, clean};

fn ply(count: usize) -> Vec<u8> {
    encode(&some_splats(count, 1, 7), Some("ply")).expect("`.ply` is written")
}

/// Small valid files of every format.
fn files() -> Vec<(&'static str, Vec<u8>)> {
    let three = some_attributes(3, 1, 3, 5);
    let two = some_attributes(3, 1, 2, 5);
    let mut raw = spz_header(2, 3, 1, 12, 0, 0);
    raw.extend(two.concat());
    let mut text = b"ply\nformat ascii 1.0\nelement vertex 2\n".to_vec();
    for name in "x y z opacity scale_0 scale_1 scale_2 rot_0 rot_1 rot_2 rot_3 f_dc_0 f_dc_1 f_dc_2".split(' ') {
        text.extend(format!("property float {name}\n").into_bytes());
    }
    text.extend(b"end_header\n");
    text.extend(b"1 2 3 4 5 6 7 8 9 10 11 12 13 14\n".repeat(2));
    vec![
        ("ply", ply(3)),
        ("ply", text),
        ("glb", encode(&some_splats(3, 1, 7), Some("glb")).expect("`.glb` is written")),
        ("spz", spz_gzip(2, 3, 1, &two)),
        ("spz", spz_gzip(3, 3, 1, &three)),
        ("spz", spz_streams(3, 1, &three)),
        ("spz", raw),
        ("splat", (0..96).collect()),
        ("sog", common::sog(3, 5)),
        ("compressed.ply", chunked_ply(3, 1, true, 5)),
        ("compressed.ply", chunked_ply(3, 0, false, 5)),
        ("ksplat", ksplat(0, &[(2, 1, 2, vec![])], 5)),
        ("ksplat", ksplat(1, &[(4, 1, 2, vec![1, 1]), (2, 0, 2, vec![])], 5)),
        ("ksplat", ksplat(2, &[(3, 2, 2, vec![1])], 5)),
    ]
}

/// Decodes; a result must be usable by what comes next.
fn survives(bytes: &[u8], ending: &str) -> bool {
    let start = Instant::now();
    let result = read(bytes, Some(ending));
    assert!(start.elapsed() < Duration::from_secs(1), "{} bytes took {:?}", bytes.len(), start.elapsed());
    match result {
        Ok(decoded) => {
            assert!(decoded.splats.is_consistent());
            let (kept, report) = clean::clean(&decoded.splats, &clean::Rules::default());
            assert_eq!(kept.len(), report.kept);
            assert!(decoded.splats.select(&kept).is_consistent());
            true
        }
        Err(error) => {
            assert!(!error.what.is_empty() && !error.advice.is_empty() && !error.place.is_empty());
            false
        }
    }
}

#[test]
fn every_truncation_is_an_error() {
    for (ending, bytes) in files() {
        assert!(survives(&bytes, ending), "{ending}");
        for n in 0..bytes.len() {
            let fine = survives(&bytes[..n], ending);
            // The last row's end of line is no data, and a file without a header may end after any row.
            let may = (ending == "ply" && n + 1 == bytes.len())
                || (ending == "sog" && n + 8 >= bytes.len())
                || (ending == "splat" && n % 32 == 0);
            // The check sum behind gzip data is not needed to have it all.
            let trailer = bytes.starts_with(&[0x1f, 0x8b]) && n + 10 >= bytes.len();
            assert!(!fine || may || trailer || bytes[..n].starts_with(b"ply") && n + 2 >= bytes.len(), "{ending} {n}");
        }
    }
}

#[test]
fn every_byte_may_be_anything() {
    for (ending, bytes) in files() {
        // The headers of a `.ksplat` are mostly empty and not read there.
        let empty = |at: usize| ending == "ksplat" && (64..4096).contains(&at);
        for at in (0..bytes.len()).filter(|&at| !empty(at)) {
            for value in [0, 1, 0x20, 0x7f, 0x80, 0xff, bytes[at] ^ 1, bytes[at].wrapping_add(1)] {
                let mut changed = bytes.clone();
                changed[at] = value;
                survives(&changed, ending);
            }
        }
    }
}

#[test]
fn every_header_integer_may_be_extreme() {
    for (ending, bytes) in files().into_iter().filter(|(e, _)| ["spz", "sog", "ksplat"].contains(e)) {
        // The headers of a `.ksplat` are 4096 and 1024 bytes long and mostly empty.
        let of_section = |at: usize| at >= 4096 && (at - 4096) % 1024 < 48;
        for at in (0..bytes.len() - 8).filter(|&at| at < 160 || at + 600 > bytes.len() || of_section(at)) {
            for value in [0, 1, u64::MAX, u64::MAX - 1, i64::MAX as u64, 1 << 63, u64::from(u32::MAX), 1 << 31] {
                for width in [4, 8] {
                    let mut changed = bytes.clone();
                    changed[at..at + width].copy_from_slice(&value.to_le_bytes()[..width]);
                    survives(&changed, ending);
                }
            }
        }
    }
    let file = chunked_ply(1, 1, true, 5);
    let end = file.windows(11).position(|w| w == b"end_header\n").unwrap() + 11;
    let header = String::from_utf8_lossy(&file[..end]).into_owned();
    for element in ["chunk", "vertex", "sh"] {
        for count in ["0", "1", "2", "4294967295", "18446744073709551615", "18446744073709551616", "-1", "1e9", ""] {
            let from = [element, " 1\n"].concat();
            let mut bytes = header.replace(&from, &[element, " ", count, "\n"].concat()).into_bytes();
            bytes.extend(&file[end..]);
            survives(&bytes, "ply");
        }
    }
    let text = String::from_utf8_lossy(&ply(1)).into_owned();
    let header = &text[..text.find("end_header").unwrap()];
    for count in ["0", "1", "4294967295", "18446744073709551615", "18446744073709551616", "-1", "1e9", ""] {
        let changed = header.replace("vertex 1", &format!("vertex {count}")) + "end_header\n";
        let mut bytes = changed.into_bytes();
        bytes.extend([0; 1024]);
        survives(&bytes, "ply");
    }
}

#[test]
fn promises_are_not_believed() {
    let huge = "ply\nformat binary_little_endian 1.0\nelement face 18446744073709551615\nproperty list uint double v\n";
    let huge = format!("{huge}element vertex 4294967295\nproperty float x\nend_header\n");
    let mut bytes = huge.into_bytes();
    bytes.extend([0xff; 64]);
    assert!(!survives(&bytes, "ply"));
    // Half of 2³² Gaussians in 40 bytes, in every container.
    let header = |version, streams| spz_header(version, u32::MAX / 2, 3, 12, 0, streams);
    let mut streams = header(4, 6);
    streams.extend(32_u32.to_le_bytes());
    streams.extend([0; 12 + 96]);
    let mut gzip = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::fast());
    std::io::Write::write_all(&mut gzip, &header(3, 0)).unwrap();
    for (bytes, fault) in
        [(header(2, 0), Fault::Truncated), (gzip.finish().unwrap(), Fault::TooLarge), (streams, Fault::TooLarge)]
    {
        assert_eq!(read(&bytes, None).unwrap_err().fault, fault);
    }
    // A gzip bomb: 400 MB of zeros that the header asks for.
    let count = 400_000_000 / 20;
    let mut bomb = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::best());
    std::io::Write::write_all(&mut bomb, &spz_header(3, count, 0, 12, 0, 0)).unwrap();
    for _ in 0..400 {
        std::io::Write::write_all(&mut bomb, &vec![0; 1_000_000]).unwrap();
    }
    let bomb = bomb.finish().unwrap();
    assert!(bomb.len() < 2_000_000);
    assert_eq!(read(&bomb, None).unwrap_err().fault, Fault::TooLarge);
}

#[test]
fn random_bytes_behind_a_good_start() {
    let mut random = Random::new(3);
    for (ending, bytes) in files() {
        for _ in 0..2000 {
            let mut changed = bytes.clone();
            for _ in 0..=(random.unit() * 8.0) as usize {
                let at = (random.unit() * changed.len() as f64) as usize;
                changed[at] = (random.unit() * 256.0) as u8;
            }
            survives(&changed, ending);
        }
    }
}

#[test]
fn numbers_that_are_none_are_removed_and_counted() {
    let mut splats = some_splats(10, 1, 1);
    splats.opacity_logits = vec![2.0; 10];
    splats.positions[0][1] = f32::NAN;
    splats.log_scales[1][0] = f32::INFINITY;
    splats.rotations[2][3] = f32::NEG_INFINITY;
    splats.sh_rest[3 * 3][2] = f32::NAN;
    splats.opacity_logits[4] = f32::NAN;
    splats.opacity_logits[5] = -7.0;
    splats.rotations[6] = [0.0; 4];
    splats.positions[7] = [5.0, 0.0, 0.0];
    splats.log_scales[8] = [0.0; 3];
    splats.opacity_logits[9] = f32::INFINITY;
    let rules = clean::Rules {
        inside: Some(clean::Box3::from_corners([-1.0; 3], [1.0; 3])),
        largest_sigma: Some(0.5),
        ..clean::Rules::default()
    };
    let (kept, report) = clean::clean(&splats, &rules);
    assert_eq!(kept, [6, 9]);
    assert_eq!((report.non_finite, report.faint, report.outside, report.large, report.zero_rotation), (5, 1, 1, 1, 1));
    assert!(report.to_string().starts_with("2 of 10 Gaussians kept"), "{report}");
}
