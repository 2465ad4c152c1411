//! Damaged and malicious splat files, each by its name: one clear error, soon, and without much memory.

mod common;
#[path = "common/refusal.rs"]
mod refusal;

use std::io::Write;

use common::packed::{chunked_ply, ksplat};
use common::{Member, sog, sog_with, some_attributes, some_splats, spz_gzip, spz_header, spz_streams};
use cosplat_splat::Fault;
use cosplat_splat::format::{encode, read};
use flate2::Compression;
use flate2::write::{DeflateEncoder, GzEncoder};
use refusal::{Allowed, Turn, turn};
use serde_json::{Value, json};

/// Memory for a refused file: what it may unpack to, 32 MiB and 64 times its size, once packed and once as Gaussians,
/// and the window of a decoder of zstd.
const ALLOWED: Allowed = Allowed { free: 72 << 20, each: 128 };

type Case = refusal::Case<Fault>;

fn check(turn: &Turn, cases: Vec<Case>) {
    refusal::check(turn, cases, ALLOWED, |bytes, ending| {
        read(bytes, Some(ending)).map(|_| ()).map_err(|error| {
            assert!(!error.place.is_empty() && !error.what.is_empty() && !error.advice.is_empty(), "{error:?}");
            (error.fault, error.to_string())
        })
    });
}

fn put(mut bytes: Vec<u8>, at: usize, new: &[u8]) -> Vec<u8> {
    bytes[at..at + new.len()].copy_from_slice(new);
    bytes
}

fn cut(mut bytes: Vec<u8>, off: usize) -> Vec<u8> {
    bytes.truncate(bytes.len() - off);
    bytes
}

/// Words of a header replaced by others.
fn replaced(bytes: &[u8], from: &str, to: &str) -> Vec<u8> {
    let at = bytes.windows(from.len()).position(|w| w == from.as_bytes()).expect("it is there");
    [&bytes[..at], to.as_bytes(), &bytes[at + from.len()..]].concat()
}

#[test]
fn ply_by_name() {
    let turn = turn();
    let good = || encode(&some_splats(2, 1, 7), Some("ply")).expect("`.ply` is written");
    let names = "x y z opacity scale_0 scale_1 scale_2 rot_0 rot_1 rot_2 rot_3 f_dc_0 f_dc_1 f_dc_2";
    let header = names.split(' ').map(|name| ["property float ", name, "\n"].concat()).collect::<String>();
    let text = |rows: &str| format!("ply\nformat ascii 1.0\nelement vertex 2\n{header}end_header\n{rows}").into_bytes();
    let row = "1 2 3 4 5 6 7 8 9 10 11 12 13 14\n";
    let start = good().windows(11).position(|w| w == b"end_header\n").unwrap();
    check(
        &turn,
        vec![
            ("no end of the header", "ply", good()[..start].to_vec(), Fault::Header, "no `end_header`"),
            ("a header without lines", "ply", [&b"ply\n"[..], &[b'x'; 1 << 20]].concat(), Fault::Header, "line 2"),
            (
                "no format",
                "ply",
                replaced(&good(), "format binary_little_endian 1.0\n", ""),
                Fault::Header,
                "no `format`",
            ),
            ("format 2.0", "ply", replaced(&good(), "endian 1.0", "endian 2.0"), Fault::Header, "line 2"),
            (
                "the largest count",
                "ply",
                replaced(&good(), "vertex 2", "vertex 18446744073709551615"),
                Fault::Truncated,
                "`vertex`",
            ),
            (
                "a count beyond",
                "ply",
                replaced(&good(), "vertex 2", "vertex 18446744073709551616"),
                Fault::Header,
                "line 4",
            ),
            (
                "a negative count",
                "ply",
                replaced(&good(), "vertex 2", "vertex -2"),
                Fault::Header,
                "`-2` is not a number of rows",
            ),
            (
                "no vertices",
                "ply",
                replaced(&good(), "element vertex", "element point"),
                Fault::Header,
                "no element `vertex`",
            ),
            ("a property of nothing", "ply", b"ply\nproperty float x\n".to_vec(), Fault::Header, "before any element"),
            ("a property twice", "ply", replaced(&good(), "float nx", "float x"), Fault::Header, "`x` is there twice"),
            ("an unknown type", "ply", replaced(&good(), "float x", "quad x"), Fault::Header, "`quad` is not a type"),
            (
                "a list of positions",
                "ply",
                replaced(&good(), "float x", "list uchar float x"),
                Fault::Header,
                "holds a list",
            ),
            ("a cloud of points", "ply", replaced(&good(), "scale_0", "radius"), Fault::Header, "point cloud"),
            ("flat Gaussians", "ply", replaced(&good(), "scale_2", "other"), Fault::Header, "2D Gaussians"),
            ("a gap in the bands", "ply", replaced(&good(), "f_rest_3", "f_rest_9"), Fault::Header, "`f_rest_*`"),
            ("cut inside a row", "ply", cut(good(), 1), Fault::Truncated, "rows of `vertex`"),
            ("a text of one row", "ply", text(row), Fault::Truncated, "`vertex`"),
            (
                "a word for a number",
                "ply",
                text(&row.repeat(2).replace("14\n1 2", "14\n1 two")),
                Fault::Value,
                "row 2: `two`",
            ),
            ("bytes for a text", "ply", [text(row), vec![0xff; 80]].concat(), Fault::Value, "not text"),
        ],
    );
}

#[test]
fn chunked_ply_by_name() {
    let turn = turn();
    let good = || chunked_ply(300, 1, true, 3);
    check(
        &turn,
        vec![
            (
                "too few chunks",
                "compressed.ply",
                replaced(&good(), "chunk 2", "chunk 1"),
                Fault::Header,
                "1 chunks of 256",
            ),
            (
                "the largest count of chunks",
                "compressed.ply",
                replaced(&good(), "chunk 2", "chunk 18446744073709551615"),
                Fault::Truncated,
                "`chunk`",
            ),
            (
                "the largest count",
                "compressed.ply",
                replaced(&good(), "vertex 300", "vertex 4294967295"),
                Fault::Truncated,
                "`vertex`",
            ),
            ("text", "compressed.ply", replaced(&good(), "binary_little_endian", "ascii"), Fault::Header, "never text"),
            (
                "no chunks",
                "compressed.ply",
                replaced(&good(), "element chunk", "element piece"),
                Fault::Header,
                "is missing",
            ),
            (
                "no colours",
                "compressed.ply",
                replaced(&good(), "packed_color", "packed_other"),
                Fault::Header,
                "`packed_color`",
            ),
            ("no upper bound", "compressed.ply", replaced(&good(), "max_z", "most_z"), Fault::Header, "`max_z`"),
            (
                "fewer bands than Gaussians",
                "compressed.ply",
                replaced(&good(), "sh 300", "sh 299"),
                Fault::Header,
                "299 rows for 300",
            ),
            ("cut inside the bands", "compressed.ply", cut(good(), 1), Fault::Truncated, "`sh`"),
        ],
    );
}

/// Packed as gzip.
fn gzip(parts: &[&[u8]]) -> Vec<u8> {
    let mut out = GzEncoder::new(Vec::new(), Compression::best());
    out.write_all(&parts.concat()).expect("memory takes it");
    out.finish().expect("memory takes it")
}

#[test]
fn spz_by_name() {
    let turn = turn();
    let (two, three) = (some_attributes(3, 1, 2, 5), some_attributes(3, 1, 3, 5));
    let packed = || spz_gzip(2, 3, 1, &two);
    let streams = || spz_streams(3, 1, &three);
    let raw = || [spz_header(2, 3, 1, 12, 0, 0), two.concat()].concat();
    let zeros = vec![0; 400_000_000];
    check(
        &turn,
        vec![
            (
                "a gzip bomb",
                "spz",
                gzip(&[&spz_header(3, 20_000_000, 0, 12, 0, 0), &zeros]),
                Fault::TooLarge,
                "would unpack",
            ),
            (
                "half of 2³² Gaussians, unpacked",
                "spz",
                put(raw(), 8, &[255, 255, 255, 127]),
                Fault::Truncated,
                "bytes are promised",
            ),
            (
                "half of 2³² Gaussians in streams",
                "spz",
                put(streams(), 8, &[255, 255, 255, 127]),
                Fault::TooLarge,
                "would unpack",
            ),
            ("version 0", "spz", put(raw(), 4, &[0]), Fault::Unsupported, "version 0"),
            ("the largest version", "spz", put(raw(), 4, &[255; 4]), Fault::Unsupported, "version 4294967295"),
            ("degree 5", "spz", put(raw(), 12, &[5]), Fault::Header, "degree 5"),
            ("25 fractional bits", "spz", put(raw(), 13, &[25]), Fault::Header, "25 fractional bits"),
            ("cut inside the header", "spz", raw()[..10].to_vec(), Fault::Truncated, "header"),
            ("cut inside the attributes", "spz", cut(raw(), 1), Fault::Truncated, "attributes"),
            ("cut inside gzip", "spz", cut(packed(), 20), Fault::Compression, "gzip data"),
            ("damaged gzip", "spz", put(packed(), 10, &[0xff; 8]), Fault::Compression, "gzip data"),
            ("gzip of something else", "spz", gzip(&[&[b'x'; 100]]), Fault::Header, "`NGSP`"),
            ("gzip of nothing", "spz", gzip(&[]), Fault::Truncated, "header"),
            ("gzip that ends early", "spz", gzip(&[&raw()[..50]]), Fault::Truncated, "unpacked attributes"),
            ("version 4 in gzip", "spz", gzip(&[&streams()]), Fault::Header, "never inside gzip"),
            ("a table inside the header", "spz", put(streams(), 16, &[31]), Fault::Header, "at byte 31"),
            ("a table beyond the end", "spz", put(streams(), 16, &[255; 4]), Fault::Truncated, "table of streams"),
            ("too few streams", "spz", put(streams(), 15, &[5]), Fault::Header, "5 streams are there and 6"),
            ("the longest stream", "spz", put(streams(), 32, &[255; 8]), Fault::Truncated, "stream 0"),
            ("a stream that lies", "spz", put(streams(), 40, &[255; 8]), Fault::Header, "stream 0: it unpacks to"),
            ("a stream that is none", "spz", put(streams(), 32 + 96, &[0; 4]), Fault::Compression, "stream 0"),
        ],
    );
}

/// A member of an archive that unpacks to zeros.
fn deflate_bomb(name: &str, length: usize) -> Member {
    let mut out = DeflateEncoder::new(Vec::new(), Compression::best());
    out.write_all(&vec![0; length]).expect("memory takes it");
    (name.to_owned(), 8, length as u32, out.finish().expect("memory takes it"))
}

#[expect(clippy::too_many_lines, reason = "it is a table")]
#[test]
fn sog_by_name() {
    let turn = turn();
    let meta = |pointer: &'static str, value: Value| {
        sog_with(3, 5, move |meta, _| *meta.pointer_mut(pointer).expect("it is there") = value)
    };
    let members = |change: fn(&mut Vec<Member>)| sog_with(3, 5, |_, members| change(members));
    let book = |n: usize| json!(vec![0.0; n]);
    // A lossless WebP says its size in 28 bits behind its mark, and in the extended header, where it has one.
    let largest = |members: &mut Vec<Member>| {
        let picture = &mut members[2].3;
        let mark = picture.windows(4).position(|w| w == b"VP8L").expect("it is lossless");
        picture[mark + 9..mark + 13].copy_from_slice(&0x1fff_bffe_u32.to_le_bytes());
        if mark > 12 {
            picture[24..30].copy_from_slice(&[0xfe, 0x3f, 0, 0xfe, 0x3f, 0]);
        }
    };
    // One picture in the place of another.
    let instead = |place: usize, other: usize| {
        sog_with(3, 5, |_, members| {
            let (length, bytes) = (members[other].2, members[other].3.clone());
            (members[place].2, members[place].3) = (length, bytes);
        })
    };
    check(
        &turn,
        vec![
            ("no directory", "sog", cut(sog(3, 5), 22), Fault::Header, "directory of the archive is missing"),
            (
                "a directory beyond the end",
                "sog",
                {
                    let n = sog(3, 5).len();
                    put(sog(3, 5), n - 6, &[255; 4])
                },
                Fault::Header,
                "cut off",
            ),
            (
                "more members than there are",
                "sog",
                {
                    let n = sog(3, 5).len();
                    put(sog(3, 5), n - 12, &[255; 2])
                },
                Fault::Header,
                "cut off",
            ),
            (
                "meta.json is no JSON",
                "sog",
                replaced(&sog(3, 5), "{\"count\"", "<\"count\""),
                Fault::Header,
                "meta.json",
            ),
            ("version 1", "sog", meta("/version", json!(1)), Fault::Unsupported, "version 1 is not 2"),
            ("the largest count", "sog", meta("/count", json!(u64::MAX)), Fault::TooLarge, "would unpack"),
            ("a negative count", "sog", meta("/count", json!(-3)), Fault::Header, "meta.json"),
            ("a count beyond the pictures", "sog", meta("/count", json!(4)), Fault::Header, "3 pixels for 4 Gaussians"),
            ("four bands", "sog", meta("/shN/bands", json!(4)), Fault::Header, "4 bands"),
            ("no bands", "sog", meta("/shN/bands", json!(0)), Fault::Header, "0 bands"),
            (
                "a codebook of 255",
                "sog",
                meta("/scales/codebook", book(255)),
                Fault::Header,
                "`scales` has 255 entries",
            ),
            ("a list of no files", "sog", meta("/means/files", json!([])), Fault::Header, "too short"),
            (
                "a file above",
                "sog",
                meta("/quats/files", json!(["../../etc/passwd"])),
                Fault::Header,
                "`../../etc/passwd` is missing",
            ),
            (
                "an absolute file",
                "sog",
                meta("/quats/files", json!(["/etc/passwd"])),
                Fault::Header,
                "`/etc/passwd` is missing",
            ),
            (
                "no meta.json",
                "sog",
                common::zip(&[("a".to_owned(), 0, 0, Vec::new())]),
                Fault::Header,
                "`meta.json` is missing",
            ),
            (
                "a zip bomb for meta.json",
                "sog",
                {
                    let all = [deflate_bomb("meta.json", 400_000_000)];
                    common::zip(&all)
                },
                Fault::TooLarge,
                "would unpack",
            ),
            (
                "a zip bomb for a picture",
                "sog",
                members(|m| m[2] = deflate_bomb("s", 400_000_000)),
                Fault::TooLarge,
                "would unpack",
            ),
            ("a member that is longer than said", "sog", members(|m| m[2].2 += 1), Fault::Header, "method 0"),
            ("an unknown compression", "sog", members(|m| m[2].1 = 14), Fault::Header, "method 14"),
            ("a picture that is none", "sog", members(|m| m[2].3[0] = b'x'), Fault::Compression, "s: "),
            ("the largest picture", "sog", members(largest), Fault::TooLarge, "16383 x 16383"),
            ("a quaternion without a mark", "sog", instead(3, 4), Fault::Value, "mark 200"),
            ("a label beyond the palette", "sog", instead(6, 1), Fault::Value, "label"),
        ],
    );
}

#[test]
fn ksplat_and_splat_by_name() {
    let turn = turn();
    let good = || ksplat(1, &[(4, 1, 2, vec![1, 1])], 5);
    let section = |at: usize, new: &[u8]| put(good(), 4096 + at, new);
    check(
        &turn,
        vec![
            ("version 1.0", "ksplat", put(good(), 0, &[1, 0]), Fault::Unsupported, "version 1.0"),
            ("level 3", "ksplat", put(good(), 20, &[3]), Fault::Header, "level 3"),
            ("the most sections", "ksplat", put(good(), 4, &[255; 4]), Fault::Truncated, "headers of sections"),
            ("cut inside the header", "ksplat", good()[..4000].to_vec(), Fault::Truncated, "header"),
            ("degree 4", "ksplat", section(40, &[4]), Fault::Header, "section 0: degree 4"),
            ("more Gaussians than fit", "ksplat", section(0, &[255; 4]), Fault::Header, "section 0"),
            ("more Gaussians than bytes", "ksplat", section(0, &[255; 8]), Fault::Truncated, "section 0"),
            ("the most buckets", "ksplat", section(12, &[255; 4]), Fault::Truncated, "section 0"),
            ("centres of four bytes", "ksplat", section(20, &[4, 0]), Fault::Header, "4 bytes, not 12"),
            ("a Gaussian in no bucket", "ksplat", section(32, &[0, 0, 0, 0]), Fault::Value, "lies in no bucket"),
            ("the largest partly filled bucket", "ksplat", section(36, &[255; 4]), Fault::Truncated, "section 0"),
            ("cut inside a row", "ksplat", cut(good(), 1), Fault::Truncated, "section 0"),
            ("half a row", "splat", vec![7; 48], Fault::Truncated, "last row of 32 bytes"),
            ("nothing", "", Vec::new(), Fault::UnknownFormat, "first bytes"),
            ("a picture", "png", b"\x89PNG\r\n\x1a\n".to_vec(), Fault::UnknownFormat, "known splat format"),
        ],
    );
}
