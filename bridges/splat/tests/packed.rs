//! The packed formats: what is decoded is what their layouts say, and what is written comes back within its steps.

#![allow(clippy::float_cmp, reason = "these numbers are read, not computed")]

mod common;

use std::path::Path;

use common::packed::{chunked_ply, gap, ksplat};
use common::{data, some_splats};
use cosplat_splat::format::{self, encode, ending_of, read, read_file};
use cosplat_splat::{Axes, Fault, Splats, coefficients};
use proptest::prelude::*;

/// Steps of `.spz`: half a step of eight bits for opacity, base band, log scale; half of 1/128 for higher bands.
const OPACITY: f64 = 0.5 / 255.0;
const BASE: f64 = 0.5 / 255.0 / 0.15;
const LOG_SCALE: f64 = 0.5 / 16.0;
const BAND: f64 = 0.5 / 128.0;
/// Single precision of numbers near one.
const ROUNDING: f64 = 1e-6;
/// sin of half the angle between a rotation and its packed form: three components are off by δ = √½/511/2 at most, and
/// the largest, w ≥ ½, by Σ|q|δ/w ≤ 3δ, so the quaternion by √(3 + 9) δ; one per cent more for the second order.
const TURN: f64 = 1.01 * 3.464_101_615_137_754_4 * std::f64::consts::FRAC_1_SQRT_2 / 511.0 / 2.0;

fn decode(splats: &Splats) -> Splats {
    let bytes = encode(splats, Some("spz")).expect("`.spz` is written");
    read(&bytes, None).expect("what is written is read").splats
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(128) })]

    #[test]
    fn spz_comes_back_within_its_steps(
        count in 1_usize..60, degree in 0_u8..=3, seed in any::<u64>(), exponent in -4_i32..=10
    ) {
        let mut splats = some_splats(count, degree, seed);
        let size = f64::from(exponent).exp2();
        for v in splats.positions.iter_mut().flatten() {
            *v *= size as f32;
        }
        let back = decode(&splats);
        prop_assert_eq!(back.axes, Axes::Rub);
        let g = gap(&splats, &back.to_axes(Axes::Rdf));
        // At least 17 bits finer than the largest coordinate, at least 12 bits behind the point, at most 22.
        let largest = splats.positions.iter().flatten().fold(0.0_f64, |m, v| m.max(f64::from(v.abs())));
        let step = (2.0 * largest / f64::from(1 << 17)).min(1.0 / 4096.0).max(1.0 / f64::from(1 << 22));
        prop_assert!(g.position <= 0.5 * step + ROUNDING * size, "{} {step}", g.position);
        prop_assert!(g.opacity <= OPACITY + ROUNDING, "{}", g.opacity);
        prop_assert!(g.dc <= BASE + ROUNDING, "{}", g.dc);
        prop_assert!(g.log_scale <= LOG_SCALE + ROUNDING, "{}", g.log_scale);
        prop_assert!(g.rest <= BAND + ROUNDING, "{}", g.rest);
        prop_assert!(g.rotation <= TURN, "{} {TURN}", g.rotation);
    }

    /// What one `.spz` holds, another holds without loss: packing twice is packing once.
    #[test]
    fn spz_is_written_without_loss_from_spz(count in 1_usize..60, degree in 0_u8..=3, seed in any::<u64>()) {
        let once = decode(&some_splats(count, degree, seed));
        let twice = decode(&once);
        prop_assert_eq!(&twice.positions, &once.positions);
        prop_assert_eq!(&twice.log_scales, &once.log_scales);
        prop_assert_eq!(&twice.opacity_logits, &once.opacity_logits);
        prop_assert_eq!(&twice.sh_dc, &once.sh_dc);
        prop_assert_eq!(&twice.sh_rest, &once.sh_rest);
        // Two components of the same size may change places as the largest.
        prop_assert!(gap(&once, &twice).rotation <= TURN);
    }
}

#[test]
fn spz_takes_any_number() {
    let mut splats = some_splats(8, 1, 3);
    splats.positions[0] = [f32::NAN, 0.0, 0.0];
    splats.log_scales[1] = [f32::INFINITY; 3];
    splats.opacity_logits[2] = f32::INFINITY;
    splats.opacity_logits[3] = f32::NEG_INFINITY;
    splats.rotations[4] = [0.0; 4];
    splats.sh_dc[5] = [1e30, -1e30, 0.0];
    splats.log_scales[6] = [50.0, -50.0, 0.0];
    splats.antialiased = true;
    let back = decode(&splats);
    assert_eq!((back.len(), back.antialiased), (6, true), "two have numbers that are none");
    assert!(back.opacity(0) > 0.999 && back.opacity(1) < 0.001);
    assert_eq!(back.rotations[2].map(f32::abs), [1.0, 0.0, 0.0, 0.0]);
    assert_eq!(back.log_scales[4], [5.9375, -10.0, 0.0]);
    assert!(decode(&Splats::default()).is_empty());
    let mut far = some_splats(2, 0, 3);
    far.positions[0] = [f32::MAX, 0.0, 0.0];
    assert_eq!(decode(&far).positions[0][0], 8_388_607.0, "the largest number that 24 bits hold");
    far.positions[0] = [2047.0, 0.0, 0.0];
    assert_eq!(decode(&far).positions[0][0], 2047.0);
}

#[test]
fn endings_of_two_words_are_known() {
    let of = |name: &str| ending_of(Path::new(name)).map(str::to_owned);
    assert_eq!(of("a/b.compressed.ply").as_deref(), Some("compressed.ply"));
    assert_eq!(of("a/b.Compressed.PLY").as_deref(), Some("Compressed.PLY"));
    assert_eq!(of("a/compressed.ply").as_deref(), Some("ply"));
    assert_eq!(of("a/b.v3.spz").as_deref(), Some("spz"));
    assert_eq!((of("a/b.txt").as_deref(), of("a/b"), of(".ply").as_deref()), (Some("txt"), None, Some("ply")));
    let error = encode(&Splats::default(), Some("compressed.ply")).unwrap_err();
    assert_eq!(error.fault, Fault::Unsupported);
    assert_eq!(error.advice, "use one of `.ply`, `.spz`, `.glb`");
    assert_eq!(format::of(&chunked_ply(1, 0, true, 1), Some("ply")).unwrap().name, "compressed ply");
}

/// Numbers worked out by hand from the published layout.
#[test]
fn chunked_ply_is_read_as_published() {
    let mut file = chunked_ply(257, 1, true, 4);
    let end = file.len() - 257 * 25;
    // First Gaussian: all bits of x, none of y, the middle bit of z; w largest, others none, a half, all.
    let words = [0xffe0_0400_u32, 512 << 10 | 1023, 0x0000_07ff, 0xff00_80ff];
    file[end..end + 16].copy_from_slice(&words.map(u32::to_le_bytes).concat());
    let bands = file.len() - 257 * 9;
    file[bands..bands + 9].copy_from_slice(&[0, 255, 127, 128, 1, 254, 64, 192, 0]);
    let s = read(&file, None).unwrap().splats;
    assert_eq!((s.len(), s.sh_degree, s.axes), (257, 1, Axes::Rdf));
    assert_eq!(s.positions[0], [1.0, -1.0, (2.0 * 1024.0 / 2047.0 - 1.0_f64) as f32]);
    assert_eq!(s.log_scales[0], [-6.0, -6.0, -2.0]);
    let q = [-0.5, 512.0 / 1023.0 - 0.5, 0.5_f64].map(|v| v * std::f64::consts::SQRT_2);
    assert_eq!(s.rotations[0][1..], q.map(|v| v as f32));
    assert!(s.rotations[0][0] < 0.05, "{:?}", s.rotations[0]);
    let colour = s.sh_dc[0].map(|v| 0.5 + cosplat_splat::SH_C0 * f64::from(v));
    let expected = [0.75, 0.25, 0.25 + 0.5 * 128.0 / 255.0];
    assert!(colour.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-7), "{colour:?}");
    assert!(s.opacity(0) > 0.99999);
    let of = |b: f32| ((b + 0.5) / 256.0 - 0.5) * 8.0;
    assert_eq!(s.rest(0), [[-4.0, of(128.0), of(64.0)], [4.0, of(1.0), of(192.0)], [of(127.0), of(254.0), -4.0]]);
}

/// Older files have no bounds of colours.
#[test]
fn a_chunked_ply_without_bounds_of_colours_holds_them_from_0_to_1() {
    let mut file = chunked_ply(1, 0, false, 4);
    let end = file.len();
    file[end - 4..].copy_from_slice(&0x00ff_3380_u32.to_le_bytes());
    let s = read(&file, None).unwrap().splats;
    let colour = s.sh_dc[0].map(|v| 0.5 + cosplat_splat::SH_C0 * f64::from(v));
    assert!(colour.iter().zip([0.0, 1.0, 0.2]).all(|(a, b)| (a - b).abs() < 1e-7), "{colour:?}");
    assert!((s.opacity(0) - 128.0 / 255.0).abs() < 1e-6);
}

#[test]
fn ksplat_is_read_as_published() {
    for level in 0..=2 {
        let (full, partial) = (2, vec![1, 2]);
        let file = ksplat(level, &[(7, 1, full, partial), (2, 2, 2, vec![])], 8);
        let decoded = read(&file, Some("ksplat")).unwrap();
        let s = decoded.splats;
        assert_eq!((s.len(), s.sh_degree, s.rest(8).len()), (9, 2, coefficients(2)), "level {level}");
        assert_eq!(decoded.notes, Vec::<String>::new());
        assert_eq!(s.rest(0)[3..], [[0.0; 3]; 5], "a section of a lower degree has no second band");
        assert!(s.scales(3).iter().all(|v| (0.5..=1.0).contains(v)), "{:?}", s.scales(3));
        assert!(s.rotations.iter().flatten().all(|v| (0.5..=1.0).contains(v)));
        if level > 0 {
            // The centres of buckets lie at 0, 1, 2, 3 and half an edge is 2.
            for (i, bucket) in [0, 0, 1, 1, 2, 3, 3].into_iter().enumerate() {
                let x = s.positions[i][0] - bucket as f32;
                assert!(x.abs() <= 2.0 + 1e-3, "level {level}: {i} is {x} from its centre");
            }
        }
    }
    // One Gaussian by hand, level 2, degree 1: position 32767 is the centre, bands are channel-major.
    let mut file = ksplat(2, &[(1, 1, 1, vec![])], 8);
    let row = file.len() - 33;
    file[row..row + 6].copy_from_slice(&[0xff, 0x7f, 0xfe, 0xff, 0, 0]);
    file[row + 24..].copy_from_slice(&[0, 255, 51, 102, 153, 204, 0, 0, 0]);
    let s = read(&file, Some("ksplat")).unwrap().splats;
    assert_eq!(s.positions[0], [0.0, 2.0, -2.0]);
    let v = |b: f32| -1.5 + b / 255.0 * 3.0;
    assert_eq!(s.rest(0), [[v(0.0), v(102.0), v(0.0)], [v(255.0), v(153.0), v(0.0)], [v(51.0), v(204.0), v(0.0)]]);
    let error = read(&ksplat(1, &[(3, 0, 4, vec![1])], 8), Some("ksplat")).unwrap_err();
    assert_eq!((error.fault, error.place.as_str()), (Fault::Value, "section 0"), "{error}");
}

/// Four Gaussians of an independent writer (splat-transform, MIT).
#[test]
fn a_ksplat_of_another_writer() {
    let Some(folder) = data() else { return };
    let load = |name: &str| read_file(&folder.join("fixtures").join(name)).unwrap().splats;
    let (ksplat, splat) = (load("minimal.ksplat"), load("minimal.splat"));
    let g = gap(&ksplat, &splat);
    assert!(g.position + g.log_scale + g.opacity + g.dc < 1e-6, "both formats hold these exactly");
}

/// One scene from every format agrees within the steps of each.
#[test]
fn a_captured_scene_agrees_between_all_formats() {
    let Some(folder) = data() else { return };
    let load = |name: &str| read_file(&folder.join("splats").join(name)).unwrap().splats.to_axes(Axes::Rdf);
    let ply = load("playbot_31k.ply");
    let chunked = load("playbot_31k.compressed.ply");
    assert_eq!((chunked.len(), chunked.sh_degree), (ply.len(), ply.sh_degree));
    let partner = partners(&chunked, &ply);
    let mut used = partner.clone();
    used.sort_unstable();
    assert!(used.iter().enumerate().all(|(i, p)| *p == i as u32), "every Gaussian is found once");
    let ply = ply.select(&partner);
    // Chunk by chunk, because each has bounds of its own: half a step of 11, 10, 11 bits; colours 8 bits.
    let mut worst = [0.0_f64; 3];
    for first in (0..ply.len()).step_by(256) {
        let chunk = first..ply.len().min(first + 256);
        for k in 0..3 {
            let steps = if k == 1 { 1023.0 } else { 2047.0 };
            let parts = [
                (&ply.positions, &chunked.positions, steps),
                (&ply.log_scales, &chunked.log_scales, steps),
                (&ply.sh_dc, &chunked.sh_dc, 255.0),
            ];
            for (w, (a, b, steps)) in worst.iter_mut().zip(parts) {
                let column = |v: &[[f32; 3]]| chunk.clone().map(|i| f64::from(v[i][k])).collect::<Vec<_>>();
                let (a, b) = (column(a), column(b));
                let range =
                    a.iter().fold(f64::NEG_INFINITY, |m, v| m.max(*v)) - a.iter().fold(f64::INFINITY, |m, v| m.min(*v));
                let gap = a.iter().zip(&b).fold(0.0_f64, |m, (x, y)| m.max((x - y).abs()));
                *w = w.max(gap / (range / steps).max(1e-9));
            }
        }
    }
    let g = gap(&ply, &chunked);
    println!(
        "chunked: worst in steps {worst:.3?}, opacity {:.2e} rotation {:.2e} rest {:.2e}",
        g.opacity, g.rotation, g.rest
    );
    assert!(worst.iter().all(|w| *w <= 0.5 + 0.01), "{worst:?}");
    assert!(g.opacity <= OPACITY + ROUNDING, "{}", g.opacity);
    // Ten bits for −½√2 to ½√2 are finer than the nine bits and a sign of `.spz`, by a thousandth.
    assert!(g.rotation <= TURN, "{}", g.rotation);
    // A byte for −4 to 4; the value is cut, not rounded, and the middle of the step taken: half a step of 8/256.
    assert!(g.rest <= 0.5 * 8.0 / 256.0 + ROUNDING, "{}", g.rest);

    // Our own `.spz` of the scene, against the one of another writer, which keeps fewer bits of the higher bands.
    let (own, other) = (decode(&ply).to_axes(Axes::Rdf), load("playbot_31k.v3.spz"));
    let g = gap(&ply, &own);
    println!(
        "own spz: position {:.2e} log scale {:.2e} opacity {:.2e} rotation {:.2e}",
        g.position, g.log_scale, g.opacity, g.rotation
    );
    assert!(g.position <= 0.5 / f64::from(1 << 16) + ROUNDING && g.log_scale <= LOG_SCALE + ROUNDING);
    assert!(g.opacity <= OPACITY + ROUNDING && g.rotation <= TURN);
    let again = decode(&other).to_axes(Axes::Rdf);
    let g = gap(&other, &again);
    assert!(
        g.position + g.log_scale + g.opacity + g.dc + g.rest == 0.0,
        "bytes of another writer come back as they are"
    );
    assert!(g.rotation <= TURN);
}

/// For each Gaussian of `a`, the one of `b` that is most like it among those near it.
fn partners(a: &Splats, b: &Splats) -> Vec<u32> {
    let mut order: Vec<u32> = (0..b.len() as u32).collect();
    order.sort_by(|i, j| b.positions[*i as usize][0].total_cmp(&b.positions[*j as usize][0]));
    let xs: Vec<f32> = order.iter().map(|i| b.positions[*i as usize][0]).collect();
    let unlike = |i: usize, j: usize| {
        let three = |p: &[f32; 3], q: &[f32; 3]| (0..3).map(|k| f64::from(p[k] - q[k]).powi(2)).sum::<f64>();
        1e4 * three(&a.positions[i], &b.positions[j])
            + three(&a.log_scales[i], &b.log_scales[j])
            + three(&a.sh_dc[i], &b.sh_dc[j])
    };
    let near = |i: usize| {
        // No chunk is wider than 4 units, so no step is longer than 4/2047.
        let x = a.positions[i][0];
        let from = xs.partition_point(|v| *v < x - 0.002);
        let until = xs.partition_point(|v| *v <= x + 0.002);
        let best = order[from..until].iter().min_by(|p, q| unlike(i, **p as usize).total_cmp(&unlike(i, **q as usize)));
        *best.expect("it lies near some")
    };
    (0..a.len()).map(near).collect()
}
