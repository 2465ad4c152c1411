//! Bytes of the protocol as files: today's encoder writes them, today's decoder reads them.
//!
//! Where the protocol is meant to change, raise its version and write the files anew:
//!
//! ```text
//! COSPLAT_BLESS=1 cargo test -p cosplat-core --test wire -- --ignored bless
//! ```

use std::collections::BTreeMap;
use std::fs;
use std::path::PathBuf;

use cosplat_core::boundary::Wrench;
use cosplat_core::control::{self, Done, Down, Envelope, Moment, PROTOCOL, Save, Times, Up};
use cosplat_core::plan::Content;
use cosplat_core::plugin::{BodyState, Energy, InterfaceReport, Report};
use cosplat_core::wire::{self, HEADER_BYTES, Header, Message};

use crate::sample::{self, Value, contents, frame, origin};

fn path(name: &str) -> PathBuf {
    PathBuf::from(std::env::var("CARGO_MANIFEST_DIR").expect("cargo runs the tests"))
        .join("tests/fixtures")
        .join(format!("{name}.bin"))
}

fn envelope<M>(body: M) -> Envelope<M> {
    Envelope { protocol: PROTOCOL, run: sample::RUN, epoch: 2, instance: 0x0123_4567_89ab_cdef, body }
}

fn hello() -> Envelope<Up> {
    envelope(Up::Hello {
        name: "left".to_owned(),
        pid: 4321,
        protocol: [PROTOCOL, PROTOCOL],
        descriptor: r#"{"name":"oscillator"}"#.to_owned(),
    })
}

/// A report in which no two fields are alike.
fn done() -> Envelope<Up> {
    let body = BodyState {
        mass_kg: 1.5,
        position_m: [0.1, 0.2, 0.3],
        orientation: [0.0, 0.6, 0.0, 0.8],
        linear_velocity_m_s: [-0.0, 1e-300, 1e300],
        angular_velocity_rad_s: [4.0, 5.0, 6.0],
        momentum: Wrench { linear: [0.7, 0.8, 0.9], angular: [1.1, 1.2, 1.3] },
        gross_momentum: 1.4,
        max_displacement_m: 0.01,
    };
    let interface = InterfaceReport {
        interface: 2,
        received: Wrench { linear: [2.1, 2.2, 2.3], angular: [2.4, 2.5, 2.6] },
        gross: 2.7,
        work_j: -2.8,
        residual: 0.029,
    };
    let report = Report {
        substeps: 20,
        substep_bound_by: "wave of `mud`".to_owned(),
        bodies: vec![body],
        external: Wrench { linear: [0.0, 0.0, -9.81], angular: [3.1, 3.2, 3.3] },
        supplied_j: 0.75,
        energy: Energy { kinetic_j: 4.1, potential_j: -4.2, dissipated_j: 4.3 },
        interfaces: vec![interface],
        counters: BTreeMap::from([("clamped".to_owned(), 3), ("overflow".to_owned(), u64::MAX)]),
        probes: BTreeMap::from([("gauge".to_owned(), 5.1)]),
    };
    envelope(Up::Done(Box::new(Done {
        window: 300,
        iteration: 1,
        consumed: vec![(1, 300, 0xdead_beef), (65_535, 301, 1)],
        produced: vec![(2, 301, u64::MAX)],
        state_hash: 0x0011_2233_4455_6677_8899_aabb_ccdd_eeff,
        sent: vec![(2, [0.1, 0.2, -0.3], 0.4)],
        applied: vec![(3, [-0.0, 1e-310, 5.0], 6.0)],
        moments: vec![Moment {
            interface: 3,
            given: [1.5, -2.5, 0.0],
            given_reach: 0.0,
            applied: [1.5, -2.25, -0.0],
            applied_reach: 1e-3,
        }],
        report,
        times: Times { start_s: 10.0, end_s: 10.5, compute_s: 0.25, wait_s: 0.125, transfer_s: 0.0625 },
    })))
}

fn grant() -> Envelope<Down> {
    envelope(Down::Grant { until: 302, committed: 300, save: Some(Save { at: 310, keep: Some(290) }) })
}

fn probe() -> Vec<u8> {
    wire::probe(&origin(&Content::Statics { body: String::new() }), &mut 40).to_vec()
}

/// Every fixture by name, as today's encoder writes it.
fn fixtures() -> Vec<(String, Vec<u8>)> {
    let data = contents().into_iter().map(|(name, content, value)| (name, frame(&content, &value).to_vec()));
    let control = [
        ("probe", probe()),
        ("up-hello", control::encode(&hello())),
        ("up-done", control::encode(&done())),
        ("down-grant", control::encode(&grant())),
    ];
    data.chain(control.map(|(name, bytes)| (name.to_owned(), bytes))).collect()
}

fn read(name: &str) -> Vec<u8> {
    fs::read(path(name))
        .unwrap_or_else(|e| panic!("{}: {e}; the top of this file says how it is made", path(name).display()))
}

#[test]
fn the_encoder_writes_the_golden_bytes() {
    for (name, bytes) in fixtures() {
        assert_eq!(read(&name), bytes, "`{name}` changed: every plugin built before would be refused or misread");
    }
}

#[test]
fn every_golden_file_has_a_test() {
    let known: Vec<PathBuf> = fixtures().iter().map(|(name, _)| path(name)).collect();
    let folder = path("x").with_file_name("");
    for entry in fs::read_dir(folder).expect("the folder of the fixtures") {
        let found = entry.expect("an entry of the folder").path();
        assert!(known.contains(&found), "nothing reads {}", found.display());
    }
}

#[test]
fn the_decoder_reads_the_golden_bytes_of_every_content() {
    for (name, content, value) in contents() {
        let bytes = read(&name);
        let header = Header::read(&bytes).unwrap_or_else(|e| panic!("`{name}`: {e}"));
        let chunk_hash = header.verify(&bytes).unwrap_or_else(|e| panic!("`{name}`: {e}"));
        let mut message = Message::begin(&header).expect("numbers that fit each other");
        assert!(message.take(&header, bytes.into(), chunk_hash, true) && message.is_complete(), "`{name}`");
        assert_eq!(message.content(), Some(header.content), "`{name}`");
        let found = sample::decode(&content, message.count(), &message.chunks().concat());
        match (found.unwrap_or_else(|e| panic!("`{name}`: {e}")), &value) {
            // Single precision: the positions were not representable. The bound is that of `round_trip`.
            (Value::Boundary(found), Value::Boundary(wanted)) if name.contains("f32") => {
                crate::round_trip::near(&found, wanted).unwrap_or_else(|e| panic!("`{name}`: {e}"));
            }
            (found, wanted) => assert_eq!(found, *wanted, "`{name}`"),
        }
    }
}

#[test]
fn the_decoder_reads_the_golden_control_messages() {
    assert_eq!(control::decode::<Up>(&read("up-hello")), Ok(hello()));
    assert_eq!(control::decode::<Up>(&read("up-done")), Ok(done()));
    assert_eq!(control::decode::<Down>(&read("down-grant")), Ok(grant()));
    let probe = read("probe");
    let header = Header::read(&probe).expect("a header");
    assert!(header.is_probe() && header.verify(&probe).is_ok());
}

#[test]
fn header_fields_stand_where_the_table_says() {
    let bytes = read("boundary-f64-normals");
    let header = Header::read(&bytes).expect("a header");
    let number = |at: usize, width: usize| {
        let mut wide = [0; 8];
        wide[..width].copy_from_slice(&bytes[at..at + width]);
        u64::from_le_bytes(wide)
    };
    assert_eq!(&bytes[..4], b"CSPL");
    assert_eq!((number(4, 2), number(6, 2)), (u64::from(wire::VERSION), 0));
    assert_eq!(bytes[8..24], sample::RUN);
    assert_eq!(number(24, 8), header.schema);
    assert_eq!((number(32, 4), number(36, 2), number(38, 2)), (2, 5, 11));
    assert_eq!((number(40, 8), number(48, 4), number(52, 4)), (1_000_000_007, 0, 3));
    assert_eq!((number(56, 8), number(64, 4), number(68, 4)), (41, 0, 1));
    assert_eq!(number(72, 8), (bytes.len() - HEADER_BYTES) as u64);
    assert_eq!((number(80, 8), number(88, 8)), (header.content, header.hash));
    assert_eq!(HEADER_BYTES, 96);
    // Three vectors are 72 bytes; the next array starts at a multiple of 16.
    let first = |array: usize| number(96 + 80 * array, 8);
    assert_eq!([first(0), first(1)], [100.0, -3.0].map(f64::to_bits));
    assert_eq!(number(96 + 2 * 80 + 8, 8), 0.6_f64.to_bits());
}

#[test]
fn schema_hashes_are_pinned() {
    let pinned: [(&str, u64); 8] = [
        ("statics", 0xf1df_fb8c_41ce_d875),
        ("boundary-f32", 0xd46c_ab83_6844_2970),
        ("boundary-f32-normals", 0x9fab_cd13_65a2_3e57),
        ("boundary-f64", 0xf79e_05b5_61f1_2a45),
        ("boundary-f64-normals", 0x27d3_2e92_1efc_9f3f),
        ("boundary-proxy", 0xaeab_a6e8_de0d_26a0),
        ("impulses-f64", 0x7e63_1e49_b4ca_3043),
        ("impulses-proxy", 0xcd81_fa63_6986_1958),
    ];
    let all = contents();
    let hash = |name: &str| all.iter().find(|(n, ..)| n == name).map(|(_, content, _)| wire::schema_hash(content));
    let found = pinned.map(|(name, _)| (name, hash(name).expect("a content of that name")));
    assert_eq!(found, pinned, "{found:#x?}");
    assert_eq!(hash("impulses-f32"), hash("impulses-f64"), "impulses are double precision for every form");
    for (_, word) in sample::FORMS {
        assert_eq!(hash(&format!("mid-boundary-{word}")), hash(&format!("boundary-{word}")));
    }
}

#[test]
fn the_hashes_of_a_message_of_three_chunks_are_pinned() {
    let payload: Vec<u8> = (0..2 * wire::CHUNK_BYTES + 1000).map(|i| (i % 251) as u8).collect();
    let origin = origin(&Content::Statics { body: String::new() });
    let (frames, content) = wire::frames(&origin, 9, wire::cut(&payload), &mut 0);
    let hashes: Vec<u64> = frames.iter().map(|f| Header::read(f).expect("a header").hash).collect();
    assert_eq!(
        (content, hashes),
        (0x9c11_6ac7_33fc_a143, vec![0x6254_8a0a_d8b1_bc08, 0xba72_5645_f837_defa, 0x9d5b_4da5_643f_5781])
    );
}

#[test]
#[ignore = "writes the fixtures anew; only with COSPLAT_BLESS=1"]
fn bless() {
    assert_eq!(std::env::var("COSPLAT_BLESS").as_deref(), Ok("1"), "set COSPLAT_BLESS=1 to write the fixtures anew");
    for (name, bytes) in fixtures() {
        fs::write(path(&name), bytes).expect("a fixture is written");
    }
}
