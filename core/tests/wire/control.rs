//! Control messages: what is not whole is refused.

use cosplat_core::control::{
    AssetInfo, ControlError, Done, Down, Envelope, PROTOCOL, Progress, Resend, Save, Up, decode, encode, protocol_of,
};
use proptest::collection::vec;
use proptest::prelude::*;
use xxhash_rust::xxh3::xxh3_64;

use crate::sample::RUN;

fn envelope<M>(body: M) -> Envelope<M> {
    Envelope { protocol: PROTOCOL, run: RUN, epoch: 1, instance: 99, body }
}

/// Bytes with a right checksum.
fn sealed(body: &[u8]) -> Vec<u8> {
    [body, &xxh3_64(body).to_le_bytes()].concat()
}

fn any_done() -> impl Strategy<Value = Done> {
    let messages = || vec((any::<u16>(), any::<u64>(), any::<u64>()), 0..5);
    let sums = || vec((any::<u16>(), any::<[f64; 3]>(), any::<f64>()), 0..3);
    (any::<[u64; 2]>(), messages(), messages(), sums(), sums()).prop_map(|(n, consumed, produced, sent, applied)| {
        Done {
            window: n[0],
            iteration: n[1] as u32,
            consumed,
            produced,
            state_hash: u128::from(n[0]) << 64 | u128::from(n[1]),
            sent,
            applied,
            ..Done::default()
        }
    })
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(256) })]

    #[test]
    fn reports_survive(done in any_done()) {
        let sent = encode(&envelope(Up::Done(Box::new(done))));
        let found = decode::<Up>(&sent);
        // Compared as bytes: NaN differs from itself, and -0 equals 0.
        prop_assert_eq!(found.map(|envelope| encode(&envelope)), Ok(sent));
    }

    #[test]
    fn random_bytes_are_no_message(bytes in vec(any::<u8>(), 0..300)) {
        prop_assert_eq!(decode::<Up>(&bytes), Err(ControlError::Checksum));
        prop_assert_eq!(decode::<Down>(&bytes), Err(ControlError::Checksum));
        prop_assert_eq!(protocol_of(&bytes), None);
    }

    #[test]
    fn random_bytes_with_a_right_checksum_are_no_panic(bytes in vec(any::<u8>(), 0..300), tag in 0..10_u8) {
        // As they are, and behind the beginning of a message of every kind.
        let head = &encode(&envelope(()))[..];
        let head = &head[..head.len() - 8];
        for body in [bytes.clone(), [head, &[tag], &bytes].concat()] {
            let whole = sealed(&body);
            let _ = (decode::<Up>(&whole), decode::<Down>(&whole), decode::<Resend>(&whole), protocol_of(&whole));
        }
    }

    #[test]
    fn a_message_that_is_not_whole_is_refused(done in any_done()) {
        let bytes = encode(&envelope(Up::Done(Box::new(done))));
        for length in 0..bytes.len() {
            prop_assert!(decode::<Up>(&bytes[..length]).is_err(), "cut to {} bytes", length);
        }
    }
}

/// One message of every kind.
fn messages() -> Vec<Vec<u8>> {
    let text = || "in words".to_owned();
    let up = [
        Up::Hello { name: text(), pid: 7, protocol: [1, 1], descriptor: "{}".to_owned() },
        Up::Fetch { asset: 3, chunk: 70_000 },
        Up::Ready(Box::default()),
        Up::Probed { streams: vec![1, 2, 300], restored: Some(u128::MAX) },
        Up::Saved { window: 70_000, problem: Some(text()) },
        Up::Done(Box::default()),
        Up::Heartbeat(Progress { window: 9, substep: 1, substeps: 20, waiting_for: Some(4) }),
        Up::Failed { kind: cosplat_core::control::FailureKind::Physics, message: text() },
        Up::Bye,
    ];
    let down = [
        Down::Welcome {
            id: 1,
            plan: "{}".to_owned(),
            scene: "{}".to_owned(),
            assets: vec![AssetInfo { name: text(), bytes: 1 << 40, hash: u64::MAX }],
            from: 9,
        },
        Down::Chunk { asset: 3, chunk: 70_000, bytes: vec![0, 255, 7] },
        Down::Refused { reason: text() },
        Down::Probe,
        Down::Start,
        Down::Grant { until: 3, committed: 1, save: Some(Save { at: 300, keep: Some(7) }) },
        Down::Finish,
        Down::Abort { reason: text() },
    ];
    let up = up.into_iter().map(|m| encode(&envelope(m)));
    up.chain(down.into_iter().map(|m| encode(&envelope(m)))).collect()
}

#[test]
fn a_message_with_any_one_bit_flipped_is_refused() {
    for mut bytes in messages() {
        for bit in 0..bytes.len() * 8 {
            bytes[bit / 8] ^= 1 << (bit % 8);
            assert!(decode::<Up>(&bytes).is_err() && decode::<Down>(&bytes).is_err(), "bit {bit} of {bytes:?}");
            assert_eq!(protocol_of(&bytes), None, "bit {bit} passes for another version");
            bytes[bit / 8] ^= 1 << (bit % 8);
        }
    }
}

#[test]
fn a_message_that_goes_on_is_refused() {
    let bytes = encode(&envelope(Down::Start));
    let body = &bytes[..bytes.len() - 8];
    assert!(decode::<Down>(&sealed(body)).is_ok());
    assert_eq!(decode::<Down>(&sealed(&[body, &[0]].concat())), Err(ControlError::Malformed));
}

#[test]
fn a_list_that_claims_to_be_huge_is_refused() {
    let empty = encode(&envelope(Up::Probed { streams: Vec::new(), restored: None }));
    // Without the length of the list, what follows it, and the checksum.
    let head = &empty[..empty.len() - 10];
    for length in [1_u64, 1000, u64::from(u32::MAX), u64::MAX / 2, u64::MAX] {
        let mut body = head.to_vec();
        let mut left = length;
        // A number as postcard writes it: seven bits a byte, lowest first, the highest bit says that more follow.
        while left > 0x7f {
            body.push(left as u8 | 0x80);
            left >>= 7;
        }
        body.push(left as u8);
        assert_eq!(decode::<Up>(&sealed(&body)), Err(ControlError::Malformed), "{length} streams in no bytes");
    }
}

#[test]
fn the_version_of_a_message_of_another_version_can_be_read() {
    let other = Envelope { protocol: 300, ..envelope(Down::Start) };
    assert_eq!(protocol_of(&encode(&other)), Some(300));
    // What follows the version may be anything in other versions.
    let mut body = encode(&other);
    body.truncate(2);
    assert_eq!(protocol_of(&sealed(&[body.as_slice(), b"something new"].concat())), Some(300));
}
