//! Random damage to splat files of every format.

mod common;

use std::ops::Range;

use common::damage::fuzz;
use common::packed::{chunked_ply, ksplat};
use common::{sog, some_attributes, some_splats, spz_gzip, spz_streams};
use cosplat_splat::format::{encode, read};

/// Damaged files of one test: some thirteen seconds.
const FILES: u64 = 2_200_000;

/// Files with more than one of everything, so that damage can mix things up.
fn files() -> Vec<(&'static str, Vec<u8>)> {
    let three = some_attributes(20, 2, 3, 9);
    let ply = encode(&some_splats(20, 2, 9), Some("ply")).expect("`.ply` is written");
    let spz = encode(&some_splats(20, 2, 9), Some("spz")).expect("`.spz` is written");
    let glb = encode(&some_splats(20, 2, 9), Some("glb")).expect("`.glb` is written");
    vec![
        ("ply", ply),
        ("glb", glb),
        ("compressed.ply", chunked_ply(300, 1, true, 9)),
        ("spz", spz),
        ("spz", spz_gzip(2, 20, 2, &some_attributes(20, 2, 2, 9))),
        ("spz", spz_streams(20, 2, &three)),
        ("sog", sog(20, 9)),
        ("ksplat", ksplat(1, &[(20, 1, 4, vec![3, 1]), (7, 2, 7, vec![])], 9)),
        ("ksplat", ksplat(2, &[(20, 2, 4, vec![3, 1])], 9)),
        ("splat", (0..=255).cycle().take(20 * 32).collect()),
    ]
}

#[test]
fn no_damage_makes_a_reader_panic_or_hang() {
    survive(0..FILES);
}

#[test]
fn no_other_damage_makes_a_reader_panic_or_hang() {
    survive(FILES..2 * FILES);
}

fn survive(numbers: Range<u64>) {
    let files = files();
    for (ending, bytes) in &files {
        assert!(read(bytes, Some(ending)).is_ok(), "{ending}");
    }
    fuzz(&files, numbers, |ending, bytes| {
        let Ok(decoded) = read(bytes, Some(ending)) else { return false };
        assert!(decoded.splats.is_consistent());
        // A row of the densest format has ten bytes for a Gaussian, after a compression of at most the allowed limit.
        assert!(decoded.splats.len() <= 64 * bytes.len() + (32 << 20) / 10);
        true
    });
}
