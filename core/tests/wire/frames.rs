//! Cutting, mixing up and putting together; and that a frame with one wrong bit is no frame.

use cosplat_core::participant::Frame;
use cosplat_core::plan::Content;
use cosplat_core::wire::{self, CHUNK_BYTES, Header, Message};
use proptest::prelude::*;

use crate::sample::{contents, frame, origin};

fn statics() -> Content {
    Content::Statics { body: "body".to_owned() }
}

/// A payload of that length that differs everywhere and with every `seed`.
fn filled(length: usize, seed: u64) -> Vec<u8> {
    let mut state = seed;
    let words = std::iter::repeat_with(|| {
        // A Weyl sequence: cheap without optimisation, and no two words of a payload are alike.
        state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
        state.to_le_bytes()
    });
    words.take(length.div_ceil(8)).flatten().take(length).collect()
}

fn cut(payload: &[u8], count: u32) -> (Vec<Frame>, u64) {
    wire::frames(&origin(&statics()), count, wire::cut(payload), &mut 0)
}

/// Puts frames together; what is there twice counts once.
fn assemble(frames: &[Frame]) -> Message {
    let verified = |frame: &Frame| {
        let header = Header::read(frame).expect("a header");
        (header, header.verify(frame).expect("an intact frame"))
    };
    let mut message = Message::begin(&verified(&frames[0]).0).expect("numbers that fit each other");
    let mut seen = Vec::new();
    for frame in frames {
        let (header, chunk_hash) = verified(frame);
        let new = !seen.contains(&header.chunk);
        assert_eq!(message.take(&header, frame.clone(), chunk_hash, true), new, "chunk {}", header.chunk);
        seen.push(header.chunk);
    }
    message
}

/// Lengths around the borders of chunks, few of them long: hashing is slow without optimisation.
fn length() -> impl Strategy<Value = usize> {
    prop_oneof![
        20 => 0..2000_usize,
        1 => Just(CHUNK_BYTES - 1),
        1 => Just(CHUNK_BYTES),
        1 => Just(CHUNK_BYTES + 1),
        1 => 2 * CHUNK_BYTES..3 * CHUNK_BYTES,
    ]
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(256) })]

    #[test]
    fn chunks_in_any_order_and_any_number_give_the_payload(
        length in length(),
        seed in any::<u64>(),
        count in any::<u32>(),
        again in prop::collection::vec(any::<prop::sample::Index>(), 0..4),
        order in any::<u64>(),
    ) {
        let payload = filled(length, seed);
        let (frames, content) = cut(&payload, count);
        prop_assert_eq!(frames.len(), length.div_ceil(CHUNK_BYTES).max(1));
        let mut arriving = frames.clone();
        arriving.extend(again.iter().map(|i| frames[i.index(frames.len())].clone()));
        // Any order: sorted by a mixed number.
        let mut places: Vec<(u64, Frame)> = arriving
            .into_iter()
            .enumerate()
            .map(|(i, frame)| ((i as u64 ^ order).wrapping_mul(0x9e37_79b9_7f4a_7c15), frame))
            .collect();
        places.sort_by_key(|(key, _)| *key);
        let arriving: Vec<Frame> = places.into_iter().map(|(_, frame)| frame).collect();
        let message = assemble(&arriving);
        prop_assert!(message.is_complete());
        prop_assert_eq!(message.content(), Some(content));
        prop_assert_eq!(message.count(), count as usize);
        prop_assert!(message.chunks().concat() == *payload);
    }

    #[test]
    fn another_payload_has_another_content_hash(length in 1..2000_usize, seed in any::<u64>(), bit in any::<prop::sample::Index>()) {
        let mut payload = filled(length, seed);
        let (_, content) = cut(&payload, 1);
        let bit = bit.index(length * 8);
        payload[bit / 8] ^= 1 << (bit % 8);
        prop_assert_ne!(cut(&payload, 1).1, content);
    }
}

#[test]
fn an_incomplete_message_has_no_content() {
    let (frames, content) = cut(&filled(3 * CHUNK_BYTES, 1), 1);
    let message = assemble(&frames[1..]);
    assert!(!message.is_complete());
    assert_eq!(message.content(), None);
    assert_eq!(assemble(&frames).content(), Some(content));
}

#[test]
fn a_chunk_of_another_message_is_not_taken() {
    let (one, _) = cut(&filled(2 * CHUNK_BYTES, 1), 1);
    let (other, _) = cut(&filled(2 * CHUNK_BYTES, 2), 1);
    let mut message = assemble(&one[..1]);
    let header = Header::read(&other[1]).expect("a header");
    let chunk_hash = header.verify(&other[1]).expect("an intact frame");
    assert!(!message.take(&header, other[1].clone(), chunk_hash, true), "two contents were mixed");
}

#[test]
fn frames_are_numbered_through() {
    let mut seq = 7;
    let buffer = |length: usize| wire::cut(&vec![0; length]);
    let (first, _) = wire::frames(&origin(&statics()), 1, buffer(CHUNK_BYTES + 1), &mut seq);
    let (second, _) = wire::frames(&origin(&statics()), 1, buffer(0), &mut seq);
    let probe = wire::probe(&origin(&statics()), &mut seq);
    let numbers = first.iter().chain(&second).chain([&probe]).map(|f| Header::read(f).expect("a header").seq);
    assert_eq!(numbers.collect::<Vec<u64>>(), [7, 8, 9, 10]);
    assert_eq!(seq, 11);
}

/// Whether every check on the way from bytes to a payload lets these through.
fn accepted(bytes: &[u8]) -> bool {
    Header::read(bytes).is_ok_and(|header| header.verify(bytes).is_ok())
}

#[test]
fn a_frame_with_any_one_bit_flipped_is_refused() {
    for (name, content, value) in contents() {
        let mut bytes = frame(&content, &value).to_vec();
        assert!(accepted(&bytes));
        for bit in 0..bytes.len() * 8 {
            bytes[bit / 8] ^= 1 << (bit % 8);
            assert!(!accepted(&bytes), "`{name}` with bit {bit} flipped");
            bytes[bit / 8] ^= 1 << (bit % 8);
        }
    }
}

#[test]
fn a_probe_with_any_one_bit_flipped_is_refused() {
    let mut bytes = wire::probe(&origin(&statics()), &mut 3).to_vec();
    for bit in 0..bytes.len() * 8 {
        bytes[bit / 8] ^= 1 << (bit % 8);
        assert!(!accepted(&bytes), "bit {bit}");
        bytes[bit / 8] ^= 1 << (bit % 8);
    }
}

#[test]
fn a_frame_cut_short_or_drawn_out_is_refused() {
    for (name, content, value) in contents() {
        let bytes = frame(&content, &value).to_vec();
        for length in 0..bytes.len() {
            assert!(!accepted(&bytes[..length]), "`{name}` cut to {length} bytes");
        }
        assert!(!accepted(&[bytes.as_slice(), &[0]].concat()), "`{name}` with a byte more");
    }
}
