//! Five seconds of random damage to files of every format. The damage depends on a seed alone; how much of it is tried
//! depends on the machine, and a failure prints the file.

mod common;

use std::time::{Duration, Instant};

use common::packed::{chunked_ply, ksplat};
use common::{Random, sog, some_attributes, some_splats, spz_gzip, spz_streams};
use cosplat_splat::format::{encode, read};

/// Files with more than one of everything, so that damage can mix things up.
fn seeds() -> Vec<(&'static str, Vec<u8>)> {
    let three = some_attributes(20, 2, 3, 9);
    let ply = encode(&some_splats(20, 2, 9), Some("ply")).expect("`.ply` is written");
    let spz = encode(&some_splats(20, 2, 9), Some("spz")).expect("`.spz` is written");
    vec![
        ("ply", ply),
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

/// One change: a byte, a number, a piece cut, doubled or moved, or the end gone.
fn damage(bytes: &mut Vec<u8>, random: &mut Random) {
    let mut below = |n: usize| (random.unit() * n as f64) as usize;
    if bytes.is_empty() {
        return;
    }
    // Damage near the beginning, where the headers are, is tried as often as all the rest.
    let reach = if below(2) == 0 { bytes.len() } else { bytes.len().min(256) };
    let at = below(reach);
    let length = below(64).min(bytes.len() - at);
    match below(7) {
        0 => bytes[at] = below(256) as u8,
        1 => bytes[at] ^= 1 << below(8),
        2 => {
            let extremes = [0, 1, 0x7fff_ffff, 0x8000_0000, u64::from(u32::MAX), u64::MAX, 0x7fc0_0000, 0x7f80_0000];
            let (value, width) = (extremes[below(extremes.len())], [2, 4, 8][below(3)].min(bytes.len() - at));
            bytes[at..at + width].copy_from_slice(&value.to_le_bytes()[..width]);
        }
        3 => drop(bytes.drain(at..at + length)),
        4 => {
            let piece = bytes[at..at + length].to_vec();
            let to = below(bytes.len());
            bytes.splice(to..to, piece);
        }
        5 => {
            let to = below(bytes.len() - length + 1);
            bytes.copy_within(at..at + length, to);
        }
        _ => bytes.truncate(at),
    }
}

#[test]
fn no_damage_makes_a_reader_panic_or_hang() {
    let seeds = seeds();
    for (ending, bytes) in &seeds {
        assert!(read(bytes, Some(ending)).is_ok(), "{ending}");
    }
    let mut random = Random::new(11);
    let start = Instant::now();
    let (mut tried, mut fine) = (0_u64, 0_u64);
    while start.elapsed() < Duration::from_secs(5) {
        let (ending, bytes) = &seeds[(random.unit() * seeds.len() as f64) as usize];
        let mut changed = bytes.clone();
        for _ in 0..=(random.unit() * 6.0) as usize {
            damage(&mut changed, &mut random);
        }
        let before = Instant::now();
        let result = std::panic::catch_unwind(|| read(&changed, Some(ending)));
        let Ok(result) = result else { panic!("a panic on a `.{ending}` of {} bytes: {changed:02x?}", changed.len()) };
        assert!(before.elapsed() < Duration::from_secs(1), "a hang on a `.{ending}`: {changed:02x?}");
        if let Ok(decoded) = result {
            assert!(decoded.splats.is_consistent());
            // A row of the densest format has ten bytes for a Gaussian, after a compression of at most the allowed limit.
            assert!(decoded.splats.len() <= 64 * changed.len() + (32 << 20) / 10);
            fine += 1;
        }
        tried += 1;
    }
    println!("{tried} damaged files, {fine} of them still decode");
    assert!(tried > 1000, "{tried} files in five seconds");
}
