//! What several tests share.

#![allow(dead_code, reason = "every test file is a program of its own and uses a part")]

pub(crate) mod damage;
pub(crate) mod packed;

use std::io::Write;

use cosplat_splat::{Axes, Extra, Splats, coefficients};
use nalgebra::{Matrix3, Vector3};

/// Random numbers that are the same everywhere.
pub(crate) struct Random(u64);

impl Random {
    pub(crate) fn new(seed: u64) -> Random {
        Random(seed.wrapping_mul(2).wrapping_add(1))
    }

    /// 0 to 1.
    pub(crate) fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        let mixed = (self.0 ^ (self.0 >> 32)).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        (mixed >> 11) as f64 / (1_u64 << 53) as f64
    }

    pub(crate) fn between(&mut self, lower: f64, upper: f64) -> f64 {
        lower + (upper - lower) * self.unit()
    }

    pub(crate) fn single(&mut self, lower: f64, upper: f64) -> f32 {
        self.between(lower, upper) as f32
    }
}

/// Gaussians in a cube of side 2.
pub(crate) fn some_splats(count: usize, degree: u8, seed: u64) -> Splats {
    let mut r = Random::new(seed);
    let k = coefficients(degree);
    Splats {
        positions: (0..count).map(|_| [0; 3].map(|_| r.single(-1.0, 1.0))).collect(),
        rotations: (0..count).map(|_| [0; 4].map(|_| r.single(-1.0, 1.0))).collect(),
        log_scales: (0..count).map(|_| [0; 3].map(|_| r.single(-6.0, -2.0))).collect(),
        opacity_logits: (0..count).map(|_| r.single(-4.0, 6.0)).collect(),
        sh_dc: (0..count).map(|_| [0; 3].map(|_| r.single(-1.5, 1.5))).collect(),
        sh_rest: (0..count * k).map(|_| [0; 3].map(|_| r.single(-0.3, 0.3))).collect(),
        sh_degree: degree,
        extras: vec![
            Extra { name: "label".to_owned(), kind: "uchar", values: (0..count).map(|i| (i % 256) as f64).collect() },
            Extra { name: "weight".to_owned(), kind: "float", values: (0..count).map(|i| i as f64 * 0.25).collect() },
        ],
        axes: Axes::Rdf,
        antialiased: false,
    }
}

/// The attributes of an `.spz`, in order.
pub(crate) type Attributes = [Vec<u8>; 6];

/// Random attributes of that many Gaussians.
pub(crate) fn some_attributes(count: usize, degree: u8, version: u32, seed: u64) -> Attributes {
    let mut r = Random::new(seed);
    let (position, rotation) = (if version >= 2 { 9 } else { 6 }, if version >= 3 { 4 } else { 3 });
    [position, 1, 3, 3, rotation, 3 * coefficients(degree)]
        .map(|n| (0..n * count).map(|_| (r.unit() * 256.0) as u8).collect())
}

/// The 16 bytes every version begins with.
pub(crate) fn spz_header(version: u32, count: u32, degree: u8, bits: u8, flags: u8, streams: u8) -> Vec<u8> {
    let mut out = 0x5053_474e_u32.to_le_bytes().to_vec();
    out.extend(version.to_le_bytes());
    out.extend(count.to_le_bytes());
    out.extend([degree, bits, flags, streams]);
    out
}

/// Version 1, 2 or 3.
pub(crate) fn spz_gzip(version: u32, count: u32, degree: u8, attributes: &Attributes) -> Vec<u8> {
    let mut out = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::fast());
    out.write_all(&spz_header(version, count, degree, 12, 0, 0)).expect("memory takes it");
    for a in attributes {
        out.write_all(a).expect("memory takes it");
    }
    out.finish().expect("memory takes it")
}

/// Version 4, in zstd frames of raw blocks.
pub(crate) fn spz_streams(count: u32, degree: u8, attributes: &Attributes) -> Vec<u8> {
    let streams: Vec<&Vec<u8>> = attributes.iter().take(if degree == 0 { 5 } else { 6 }).collect();
    let packed: Vec<Vec<u8>> = streams.iter().map(|a| zstd_raw(a)).collect();
    let mut out = spz_header(4, count, degree, 12, 0, streams.len() as u8);
    out.extend(32_u32.to_le_bytes());
    out.extend([0; 12]);
    for (p, a) in packed.iter().zip(&streams) {
        out.extend((p.len() as u64).to_le_bytes());
        out.extend((a.len() as u64).to_le_bytes());
    }
    out.extend(packed.concat());
    out
}

/// A zstd frame of raw blocks: a single segment with its length in eight bytes.
fn zstd_raw(bytes: &[u8]) -> Vec<u8> {
    let mut out = 0xfd2f_b528_u32.to_le_bytes().to_vec();
    out.push(0b1110_0000);
    out.extend((bytes.len() as u64).to_le_bytes());
    let chunks: Vec<&[u8]> = if bytes.is_empty() { vec![&[]] } else { bytes.chunks(60_000).collect() };
    for (i, chunk) in chunks.iter().enumerate() {
        let last = u32::from(i + 1 == chunks.len());
        out.extend(&(((chunk.len() as u32) << 3) | last).to_le_bytes()[..3]);
        out.extend(*chunk);
    }
    out
}

/// A member of an archive: name, method of compression, unpacked length, bytes.
pub(crate) type Member = (String, u16, u32, Vec<u8>);

/// A `.sog` of that many Gaussians, of degree 1, with one row of pixels.
pub(crate) fn sog(count: u32, seed: u64) -> Vec<u8> {
    sog_with(count, seed, |_, _| {})
}

/// The same, with `meta.json` or its pictures changed.
pub(crate) fn sog_with(
    count: u32,
    seed: u64,
    change: impl FnOnce(&mut serde_json::Value, &mut Vec<Member>),
) -> Vec<u8> {
    let mut r = Random::new(seed);
    let mut picture = |width: u32, fourth: u8| {
        let pixels: Vec<u8> = (0..width)
            .flat_map(|_| [0, 1, 2, 3].map(|k| if k == 3 { fourth } else { (r.unit() * 4.0) as u8 }))
            .collect();
        let mut out = Vec::new();
        let encoder = image_webp::WebPEncoder::new(&mut out);
        encoder.encode(&pixels, width, 1, image_webp::ColorType::Rgba8).expect("memory takes it");
        out
    };
    let book: Vec<f64> = (0..256).map(|i| f64::from(i) / 128.0 - 1.0).collect();
    let mut meta = serde_json::json!({
        "version": 2, "count": count,
        "means": {"mins": [-1, -1, -1], "maxs": [1, 1, 1], "files": ["ml", "mu"]},
        "scales": {"codebook": book, "files": ["s"]},
        "quats": {"files": ["q"]},
        "sh0": {"codebook": book, "files": ["c"]},
        "shN": {"bands": 1, "count": 2, "codebook": book, "files": ["k", "l"]},
    });
    let labels = {
        let mut out = Vec::new();
        let pixels = vec![0; 3 * count as usize];
        let encoder = image_webp::WebPEncoder::new(&mut out);
        encoder.encode(&pixels, count, 1, image_webp::ColorType::Rgb8).expect("memory takes it");
        out
    };
    let members = [
        ("ml", picture(count, 255)),
        ("mu", picture(count, 255)),
        ("s", picture(count, 255)),
        ("q", picture(count, 253)),
        ("c", picture(count, 200)),
        ("k", picture(64 * 3, 255)),
        ("l", labels),
    ];
    let stored = |(name, bytes): (&str, Vec<u8>)| (name.to_owned(), 0, bytes.len() as u32, bytes);
    let mut members: Vec<Member> = members.into_iter().map(stored).collect();
    change(&mut meta, &mut members);
    members.insert(0, stored(("meta.json", meta.to_string().into_bytes())));
    zip(&members)
}

/// An archive, check sums left out.
pub(crate) fn zip(members: &[Member]) -> Vec<u8> {
    let (mut out, mut directory) = (Vec::new(), Vec::new());
    for (name, method, unpacked, bytes) in members {
        let offset = out.len() as u32;
        let common = [
            &[20, 0, 0, 0][..],
            &method.to_le_bytes(),
            &[0; 8],
            &(bytes.len() as u32).to_le_bytes(),
            &unpacked.to_le_bytes(),
            &(name.len() as u16).to_le_bytes(),
            &[0; 2],
        ];
        out.extend([&b"PK\x03\x04"[..], &common.concat(), name.as_bytes(), bytes].concat());
        let tail = [&[0; 10][..], &offset.to_le_bytes(), name.as_bytes()];
        directory.extend([&b"PK\x01\x02\x14\0"[..], &common.concat(), &tail.concat()].concat());
    }
    let (start, size, count) = (out.len() as u32, directory.len() as u32, (members.len() as u16).to_le_bytes());
    out.extend(directory);
    out.extend(
        [&b"PK\x05\x06\0\0\0\0"[..], &count, &count, &size.to_le_bytes(), &start.to_le_bytes(), &[0; 2]].concat(),
    );
    out
}

/// Covariance of a Gaussian.
pub(crate) fn covariance(s: &Splats, i: usize) -> Matrix3<f64> {
    let [w, x, y, z] = s.rotations[i].map(f64::from);
    let q = nalgebra::UnitQuaternion::from_quaternion(nalgebra::Quaternion::new(w, x, y, z));
    let m = q.to_rotation_matrix().into_inner() * Matrix3::from_diagonal(&Vector3::from(s.scales(i)));
    m * m.transpose()
}

/// The folder of captured scenes, if there is one.
pub(crate) fn data() -> Option<std::path::PathBuf> {
    let folder = std::env::var_os("COSPLAT_DATA").map(std::path::PathBuf::from);
    if folder.is_none() {
        eprintln!("skipped: COSPLAT_DATA does not name a data folder");
    }
    folder
}
