//! Compact sequences: what comes back, how large it is, and that damage is refused.

mod common;

use common::{Random, some_splats};
use cosplat_splat::bind::Local;
use cosplat_splat::format::encode;
use cosplat_splat::sequence::First;
use cosplat_splat::skin::{Limits, skin};
use cosplat_splat::{Fault, Splats};
use nalgebra::{Matrix3, Rotation3, Vector3};
use proptest::prelude::*;

fn first(count: usize, degree: u8, seed: u64) -> First {
    let splats = some_splats(count, degree, seed);
    let bytes = encode(&splats, Some("ply")).expect("it is a format");
    First::new(splats, &bytes)
}

/// A turn and a stretch of every `each`-th Gaussian.
fn moved(rest: &Splats, each: usize, seed: u64) -> Splats {
    let mut r = Random::new(seed);
    let turn = Rotation3::from_euler_angles(r.between(-3.0, 3.0), r.between(-1.0, 1.0), r.between(-3.0, 3.0));
    let gradient = turn.into_inner() * Matrix3::from_diagonal(&Vector3::new(1.2, 0.8, 1.0));
    let shift = Vector3::new(r.between(-1.0, 1.0), 0.25, r.between(-1.0, 1.0));
    let local =
        |i: usize| if i.is_multiple_of(each) { Local { displacement: shift, gradient } } else { Local::still() };
    let mut out = Splats::default();
    skin(rest, local, Limits::default(), &mut out);
    out
}

/// Angle between two orientations; q and −q are the same \[rad\].
fn angle(p: [f32; 4], q: [f32; 4]) -> f64 {
    let unit = |v: [f32; 4]| {
        let v = v.map(f64::from);
        let length = v.iter().map(|c| c * c).sum::<f64>().sqrt();
        v.map(|c| c / length)
    };
    let (p, q) = (unit(p), unit(q));
    let chord = |s: f64| p.iter().zip(&q).map(|(x, y)| (x + s * y).powi(2)).sum::<f64>().sqrt();
    4.0 * (chord(1.0).min(chord(-1.0)) / 2.0).asin()
}

#[track_caller]
fn close(found: &Splats, wanted: &Splats, rest: &Splats) {
    assert_eq!(found.positions, wanted.positions, "positions keep their bits");
    assert_eq!((&found.opacity_logits, &found.extras), (&rest.opacity_logits, &rest.extras));
    let gap = |a: &[f32; 3], b: &[f32; 3]| (0..3).map(|k| (a[k] - b[k]).abs()).fold(0.0, f32::max);
    for i in 0..wanted.len() {
        let own = |s: &Splats| (s.rotations[i].map(f32::to_bits), s.log_scales[i].map(f32::to_bits));
        let still = own(wanted) == own(rest);
        if still {
            assert_eq!((found.rotations[i], found.log_scales[i]), (rest.rotations[i], rest.log_scales[i]));
            assert_eq!(found.rest(i), rest.rest(i));
            continue;
        }
        // Three components each off by half a step of √2/32767, the fourth by at most their sum: 1.5e-4 rad.
        assert!(angle(found.rotations[i], wanted.rotations[i]) < 1.6e-4);
        // Half a step of 1/1024, and of 1/4096, with the rounding of single precision.
        assert!(gap(&found.log_scales[i], &wanted.log_scales[i]) < 0.000_49);
        let bands = found.rest(i).iter().zip(wanted.rest(i)).map(|(a, b)| gap(a, b)).fold(0.0, f32::max);
        assert!(bands.max(gap(&found.sh_dc[i], &wanted.sh_dc[i])) < 0.000_123);
    }
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(64) })]

    #[test]
    fn what_is_written_is_read(count in 1_usize..300, degree in 0_u8..4, each in 1_usize..12, seed in any::<u32>()) {
        let first = first(count, degree, u64::from(seed));
        let mut now = moved(first.splats(), each, u64::from(seed) + 1);
        if seed % 2 == 0 {
            now.sh_dc[count / 2] = [0.1, -1.5, 3.0];
        }
        let bytes = first.encode(&now).unwrap();
        let back = first.decode(&bytes).unwrap();
        close(&back, &now, first.splats());
        // What comes back is written as the same bytes: nothing drifts from copy to copy.
        let again = first.encode(&back).unwrap();
        close(&first.decode(&again).unwrap(), &back, first.splats());
    }

    /// No bytes make it panic, and none take more memory than the first frame has.
    #[test]
    fn damage_is_refused_or_gives_a_frame(at in 0_usize..4000, value in any::<u8>(), cut in 0_usize..4000) {
        let first = first(100, 1, 5);
        let mut bytes = first.encode(&moved(first.splats(), 3, 6)).unwrap();
        let end = cut.min(bytes.len());
        if let Some(byte) = bytes.get_mut(at) {
            *byte ^= value;
        }
        for part in [&bytes[..], &bytes[..end]] {
            if let Ok(frame) = first.decode(part) {
                prop_assert!(frame.is_consistent() && frame.len() == 100);
            }
        }
    }
}

#[test]
fn a_frame_without_motion_is_a_few_bytes_and_the_same_bits() {
    let first = first(5000, 3, 1);
    let bytes = first.encode(first.splats()).unwrap();
    assert!(bytes.len() < 64, "{}", bytes.len());
    assert_eq!(&first.decode(&bytes).unwrap(), first.splats());
}

#[test]
fn a_frame_in_which_all_move_is_smaller_than_a_whole_file() {
    for (degree, most) in [(0, 0.45), (3, 0.45)] {
        let first = first(20_000, degree, 2);
        let now = moved(first.splats(), 1, 3);
        let (own, ply) = (first.encode(&now).unwrap().len(), encode(&now, Some("ply")).unwrap().len());
        // Random numbers hardly pack: 24 bytes of 61 with two labels, and with 45 numbers of bands 114 of 241.
        println!("degree {degree}: {own} bytes of {ply}");
        assert!((own as f64) < most * ply as f64 * 1.1, "{own} {ply}");
    }
}

#[test]
fn frames_of_another_sequence_and_other_gaussians_are_refused() {
    let (first, other) = (first(50, 0, 1), first(50, 0, 2));
    let bytes = first.encode(&moved(first.splats(), 1, 1)).unwrap();
    let fault = |bytes: &[u8]| first.decode(bytes).unwrap_err().fault;
    assert!(other.decode(&bytes).unwrap_err().what.contains("another sequence"));
    assert_eq!(fault(b"CGSQ"), Fault::Truncated);
    assert_eq!(fault(b"NGSP"), Fault::UnknownFormat);
    let mut newer = bytes.clone();
    newer[4] = 2;
    assert_eq!(fault(&newer), Fault::Unsupported);
    assert!(matches!(fault(&bytes[..bytes.len() - 9]), Fault::Compression | Fault::Truncated));
    let mut faded = first.splats().clone();
    faded.opacity_logits[3] = -2.0;
    assert_eq!(first.encode(&faded), None);
    assert_eq!(first.encode(&some_splats(49, 0, 1)), None);
}
