//! Bytes that are not what they say: refused with a reason, without a panic, without memory they do not fill.

use cosplat_core::plan::{BoundaryForm, Content};
use cosplat_core::wire::{CHUNK_BYTES, HEADER_BYTES, Header, HeaderError, Message, PayloadError, payload_bytes};
use proptest::collection::vec;
use proptest::prelude::*;
use xxhash_rust::xxh3::xxh3_64;

use crate::sample::{Value, contents, decode, frame, payload};

/// Counts that lie, with those at which a product with the width of an element wraps around.
const COUNTS: [usize; 13] = [
    0,
    1,
    2,
    u16::MAX as usize,
    u32::MAX as usize,
    i32::MAX as usize,
    usize::MAX / 36,
    usize::MAX / 24,
    usize::MAX / 16,
    usize::MAX / 12,
    usize::MAX / 8 + 1,
    usize::MAX - 1,
    usize::MAX,
];

fn any_content() -> impl Strategy<Value = Content> {
    prop::sample::select(contents().into_iter().map(|(_, content, _)| content).collect::<Vec<Content>>())
}

fn any_count() -> impl Strategy<Value = usize> {
    prop_oneof![0..64_usize, any::<usize>(), prop::sample::select(COUNTS.to_vec())]
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(256) })]

    #[test]
    fn random_bytes_are_no_frame_and_no_panic(bytes in vec(any::<u8>(), 0..400)) {
        prop_assert!(Header::read(&bytes).and_then(|header| header.verify(&bytes)).is_err());
    }

    #[test]
    fn a_random_header_with_a_good_beginning_is_no_panic(mut bytes in vec(any::<u8>(), HEADER_BYTES..400), lie in any::<[u32; 2]>()) {
        let whole = { let (_, content, value) = contents().swap_remove(0); frame(&content, &value) };
        bytes[..8].copy_from_slice(&whole[..8]);
        // Some chunk numbers in the range where they nearly fit.
        if lie[0] % 2 == 0 {
            bytes[64..68].copy_from_slice(&(lie[0] % 5).to_le_bytes());
            bytes[68..72].copy_from_slice(&(lie[1] % 5).to_le_bytes());
            bytes[72..80].copy_from_slice(&(u64::from(lie[1] % 5) * CHUNK_BYTES as u64).to_le_bytes());
        }
        let header = Header::read(&bytes).expect("a good beginning");
        prop_assert_eq!(header.verify(&bytes), Err(HeaderError::Hash));
        if let Some(mut message) = Message::begin(&header) {
            message.take(&header, bytes.into(), 0, true);
            prop_assert!(!message.is_complete() || message.content().is_none());
        }
    }

    #[test]
    fn random_payloads_are_no_panic(content in any_content(), count in any_count(), bytes in vec(any::<u8>(), 0..400)) {
        if let Err(PayloadError::Length { expected, found }) = decode(&content, count, &bytes) {
            prop_assert_ne!(expected, found);
        }
    }

    #[test]
    fn random_payloads_of_the_right_length_are_no_panic(content in any_content(), count in 0..20_usize, seed in vec(any::<u8>(), 2000)) {
        let bytes = &seed[..payload_bytes(&content, count)];
        let wrong_length = matches!(decode(&content, count, bytes), Err(PayloadError::Length { .. }));
        prop_assert!(!wrong_length);
    }
}

#[test]
fn a_payload_cut_short_or_drawn_out_is_refused() {
    for (name, content, value) in contents() {
        let (count, bytes) = payload(&content, &value);
        let length_is_refused = |bytes: &[u8]| matches!(decode(&content, count, bytes), Err(PayloadError::Length { found, .. }) if found == bytes.len());
        for length in 0..bytes.len() {
            assert!(length_is_refused(&bytes[..length]), "`{name}` cut to {length} bytes");
        }
        assert!(length_is_refused(&[bytes.as_slice(), &[0; 16]].concat()), "`{name}` with 16 bytes more");
    }
}

#[test]
fn a_count_that_lies_is_refused_before_anything_is_allocated() {
    for (name, content, value) in contents() {
        let (_, bytes) = payload(&content, &value);
        for count in COUNTS {
            // Padding hides a count of the same length in 16-byte blocks: three samples are no worse than four. The
            // header's hash covers the count.
            if payload_bytes(&content, count) != bytes.len() {
                assert!(decode(&content, count, &bytes).is_err(), "`{name}` as {count} elements");
            }
            assert!(count == 0 || count == 1 || decode(&content, count, &[]).is_err(), "`{name}`: {count} of nothing");
        }
    }
}

/// Whether a content has one element whatever its body.
fn is_single(name: &str) -> bool {
    name.contains("proxy") || name == "visual-pose"
}

#[test]
fn a_rigid_body_is_one_element() {
    for (name, content, value) in contents().into_iter().filter(|(name, ..)| is_single(name)) {
        let (count, bytes) = payload(&content, &value);
        assert_eq!(count, 1);
        for found in COUNTS.into_iter().filter(|&c| c != 1) {
            assert_eq!(decode(&content, found, &bytes), Err(PayloadError::Count { found }), "`{name}`");
        }
    }
}

#[test]
fn a_size_that_is_no_number_is_the_largest() {
    for (name, content, _) in contents().into_iter().filter(|(name, ..)| !is_single(name)) {
        let sizes = COUNTS.map(|count| payload_bytes(&content, count));
        assert_eq!(sizes[COUNTS.len() - 1], usize::MAX, "`{name}`");
        let large: Vec<usize> = COUNTS.into_iter().filter(|c| *c >= usize::MAX / 16).collect();
        assert!(large.iter().all(|&count| payload_bytes(&content, count) >= count), "`{name}`: a size wrapped around");
    }
}

#[test]
fn an_empty_set_is_a_message() {
    for (name, content, _) in contents().into_iter().filter(|(name, ..)| !is_single(name)) {
        let bytes = vec![0; payload_bytes(&content, 0)];
        assert!(decode(&content, 0, &bytes).is_ok(), "`{name}`");
    }
}

/// A frame whose header says something else, sealed as its sender would.
fn lying(change: impl FnOnce(&mut Header)) -> (Header, Vec<u8>) {
    let (_, content, value) = contents().swap_remove(0);
    let mut bytes = frame(&content, &value).to_vec();
    let mut header = Header::read(&bytes).expect("a header");
    change(&mut header);
    header = header.sealed(xxh3_64(&bytes[HEADER_BYTES..]));
    bytes[..HEADER_BYTES].copy_from_slice(bytemuck::bytes_of(&header));
    assert!(header.verify(&bytes).is_ok());
    (header, bytes)
}

#[test]
fn a_header_whose_numbers_contradict_each_other_begins_no_message() {
    let payload = lying(|_| {}).0.length;
    let most = 4096 * CHUNK_BYTES as u64;
    let lies: [(u32, u32, u64); 13] = [
        (0, 0, payload),
        (1, 1, payload),
        (1, 0, payload),
        (u32::MAX, 1, payload),
        (0, 2, payload),
        (0, u32::MAX, payload),
        (u32::MAX, u32::MAX, u64::MAX),
        (0, u32::MAX, u64::from(u32::MAX) * CHUNK_BYTES as u64),
        (0, 1, u64::MAX),
        (0, 0, 0),
        (0, 1, CHUNK_BYTES as u64 + 1),
        (0, 4097, most + 1),
        (4096, 4096, most),
    ];
    for (chunk, chunks, length) in lies {
        let (header, _) = lying(|h| (h.chunk, h.chunks, h.length) = (chunk, chunks, length));
        assert!(Message::begin(&header).is_none(), "chunk {chunk} of {chunks}, {length} bytes");
    }
}

#[test]
fn a_frame_of_another_length_than_its_header_says_is_not_taken() {
    for (chunk, chunks, length) in
        [(0, 1, 0), (0, 1, 1), (0, 2, CHUNK_BYTES as u64 + 128), (0, 4096, 4096 * CHUNK_BYTES as u64)]
    {
        let (header, bytes) = lying(|h| (h.chunk, h.chunks, h.length) = (chunk, chunks, length));
        let mut message = Message::begin(&header).expect("numbers that fit each other");
        assert!(!message.take(&header, bytes.into(), 0, true), "{length} bytes in {chunks} chunks");
        assert!(!message.is_complete());
    }
}

#[test]
fn a_frame_without_a_whole_header_is_not_taken() {
    let (header, bytes) = lying(|_| {});
    let mut message = Message::begin(&header).expect("numbers that fit each other");
    for length in [0, 1, HEADER_BYTES - 1, HEADER_BYTES] {
        assert!(!message.take(&header, bytes[..length].to_vec().into(), 0, true), "{length} bytes");
    }
    assert_eq!(header.verify(&bytes[..HEADER_BYTES - 1]), Err(HeaderError::Short));
}

#[test]
fn headers_of_others_are_refused_by_their_first_fields() {
    let (_, whole) = lying(|_| {});
    let refused = |at: usize, byte: u8| {
        let mut bytes = whole.clone();
        bytes[at] ^= byte;
        Header::read(&bytes).expect_err("a changed beginning")
    };
    assert_eq!(refused(0, 1), HeaderError::Magic);
    assert_eq!(refused(4, 2), HeaderError::Version);
    assert_eq!(refused(6, 2), HeaderError::Kind);
    assert_eq!(Header::read(&whole[..HEADER_BYTES - 1]), Err(HeaderError::Short));
}

/// Arrays of a payload in order: name, first number, numbers; those that may be infinite are marked.
fn arrays(name: &str) -> Vec<(&'static str, usize, usize, bool)> {
    match name {
        "statics" => vec![("area", 4, 3, false), ("volume", 8, 3, false), ("mass", 12, 3, false)],
        "boundary-f64-normals" => vec![("position", 0, 9, false), ("velocity", 10, 9, false), ("normal", 20, 9, false)],
        "impulses-f64" => vec![("impulse", 0, 9, false)],
        "impulses-proxy" => vec![("impulse", 0, 6, false)],
        "boundary-proxy" => vec![
            ("position", 0, 3, false),
            ("orientation", 3, 4, false),
            ("velocity", 7, 3, false),
            ("angular velocity", 10, 3, false),
            ("mass and inertia", 13, 7, true),
            ("share", 20, 1, false),
            ("background", 21, 3, false),
            ("angular background", 24, 3, false),
        ],
        other => panic!("no table for `{other}`"),
    }
}

#[test]
fn a_number_that_is_none_is_named() {
    for wanted in ["statics", "boundary-f64-normals", "impulses-f64", "impulses-proxy", "boundary-proxy"] {
        let (_, content, value) = contents().into_iter().find(|(n, ..)| n == wanted).expect("a content of that name");
        let (count, good) = payload(&content, &value);
        for (array, first, numbers, may_be_infinite) in arrays(wanted) {
            for index in 0..numbers {
                for bad in [f64::NAN, f64::NEG_INFINITY, f64::INFINITY] {
                    let mut bytes = good.clone();
                    let at = (first + index) * 8;
                    bytes[at..at + 8].copy_from_slice(&bad.to_le_bytes());
                    let found = decode(&content, count, &bytes);
                    if may_be_infinite && bad == f64::INFINITY {
                        assert!(found.is_ok(), "`{wanted}`: a scripted body has infinite mass");
                    } else {
                        assert_eq!(found, Err(PayloadError::NotFinite { array, index }), "`{wanted}`: {bad}");
                    }
                }
            }
        }
    }
}

#[test]
fn a_number_too_large_for_single_precision_is_named_by_the_reader() {
    let form = BoundaryForm::SamplesF32 { normals: true };
    let content = Content::Boundary { body: "body".to_owned(), form };
    let cosplat_core::boundary::BoundaryState::Samples(mut samples) = crate::sample::boundary(form) else {
        panic!("samples were asked for");
    };
    samples.velocity[2][1] = 1e39;
    let value = Value::Boundary(cosplat_core::boundary::BoundaryState::Samples(samples));
    let (count, bytes) = payload(&content, &value);
    assert_eq!(decode(&content, count, &bytes), Err(PayloadError::NotFinite { array: "velocity", index: 7 }));
}
