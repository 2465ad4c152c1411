//! Time to read 500 000 Gaussians of every format: least, and median of several times.
//!
//! Gaussians are random ones of degree 1, and with `COSPLAT_DATA` also those of a capture. What bounds it: the file is
//! read once and the numbers are written once, 59 or 23 single-precision numbers a Gaussian, so some 30 ms by memory; gzip
//! unpacks about 300 MB/s on one core, a lossless WebP picture some 20 Mpixel/s.
//!
//! Run with `cargo bench -p cosplat-splat`.

#[path = "../tests/common/mod.rs"]
mod common;

use std::time::Instant;

use common::packed::{chunked_ply, ksplat};
use common::{some_attributes, some_splats, spz_gzip, spz_streams};
use cosplat_splat::Splats;
use cosplat_splat::format::{encode, read, read_file};

const COUNT: usize = 500_000;
const TIMES: usize = 5;

fn time(name: &str, bytes: &[u8], ending: &str) {
    let mut times: Vec<f64> = (0..TIMES)
        .map(|_| {
            let start = Instant::now();
            let decoded = read(bytes, Some(ending));
            let time = start.elapsed().as_secs_f64();
            assert_eq!(decoded.map(|d| d.splats.len()).ok(), Some(COUNT), "{name}");
            time
        })
        .collect();
    times.sort_by(f64::total_cmp);
    let (least, median) = (1e3 * times[0], 1e3 * times[TIMES / 2]);
    println!("{name:<28} {:>7.1} MB {least:>7.0} ms {median:>7.0} ms", bytes.len() as f64 / 1e6);
}

fn written(name: &str, splats: &Splats) {
    for ending in ["ply", "spz"] {
        let bytes = encode(splats, Some(ending)).unwrap_or_default();
        time(&format!("{name}, .{ending}"), &bytes, ending);
    }
}

/// `.splat` has no writer here: rows of 32 bytes.
fn antimatter() -> Vec<u8> {
    let row = |k: usize| [1.0, 2.0, k as f32, 0.01, 0.02, 0.03].map(f32::to_le_bytes).concat();
    (0..COUNT).flat_map(|k| [row(k), [k as u8; 8].to_vec()].concat()).collect()
}

/// A text of the same Gaussians as a small binary file, without higher bands.
fn text() -> Vec<u8> {
    let names = "x y z f_dc_0 f_dc_1 f_dc_2 opacity scale_0 scale_1 scale_2 rot_0 rot_1 rot_2 rot_3";
    let mut out = format!("ply\nformat ascii 1.0\nelement vertex {COUNT}\n");
    out.extend(names.split(' ').map(|name| format!("property float {name}\n")));
    out.push_str("end_header\n");
    let splats = some_splats(COUNT, 0, 1);
    for i in 0..COUNT {
        let numbers = [&splats.positions[i][..], &splats.sh_dc[i], &[splats.opacity_logits[i]], &splats.log_scales[i]];
        let numbers = numbers.concat().into_iter().chain(splats.rotations[i]);
        out.extend(numbers.map(|v| format!("{v} ")));
        out.push('\n');
    }
    out.into_bytes()
}

fn main() {
    println!("{:<28} {:>10} {:>10} {:>10}", "500 000 Gaussians", "file", "least", "median");
    written("random", &Splats { extras: Vec::new(), ..some_splats(COUNT, 1, 1) });
    time("text, .ply", &text(), "ply");
    let old = spz_gzip(2, COUNT as u32, 1, &some_attributes(COUNT, 1, 2, 1));
    time("random, .spz version 2", &old, "spz");
    time("random, .spz version 4", &spz_streams(COUNT as u32, 1, &some_attributes(COUNT, 1, 3, 1)), "spz");
    time("random, .compressed.ply", &chunked_ply(COUNT, 1, true, 1), "compressed.ply");
    for level in 0..3 {
        let file = ksplat(level, &[(COUNT as u32, 1, 256, vec![32])], 1);
        time(&format!("random, .ksplat level {level}"), &file, "ksplat");
    }
    time("random, .splat", &antimatter(), "splat");
    let Some(folder) = common::data() else { return };
    let path = folder.join("splats/playbot_500k.sog");
    let (Ok(bytes), Ok(decoded)) = (std::fs::read(&path), read_file(&path)) else { return };
    time("capture, .sog", &bytes, "sog");
    written("capture", &decoded.splats);
}
