//! Damaged and malicious meshes in STL, PLY and OBJ, each by its name.

mod common;
#[path = "common/refused.rs"]
mod refused;

use common::{brick, files};
use cosplat_mesh::Fault;
use cosplat_mesh::format::Beside;
use refused::{check, cut, put, turn};

/// A text with words replaced by others.
fn replaced(bytes: &[u8], from: &str, to: &str) -> Vec<u8> {
    let text = str::from_utf8(bytes).expect("it is text");
    assert!(text.contains(from), "{from}");
    text.replacen(from, to, 1).into_bytes()
}

fn replaced_bytes(bytes: &[u8], from: &[u8], to: &[u8]) -> Vec<u8> {
    let at = bytes.windows(from.len()).position(|w| w == from).expect("it is there");
    [&bytes[..at], to, &bytes[at + from.len()..]].concat()
}

#[test]
fn stl_by_name() {
    let turn = turn();
    let mesh = brick([0.0; 3], [1.0; 3]);
    let (binary, text) = (|| files::stl_binary(&mesh, "a thing"), || files::stl_text(&mesh));
    let nan = f32::NAN.to_le_bytes();
    check(
        &turn,
        vec![
            ("cut inside a triangle", "stl", cut(binary(), 7), Fault::Truncated, "triangles: 684 bytes are promised"),
            ("cut inside the header", "stl", cut(binary(), 620), Fault::Truncated, "header: 84 bytes"),
            ("the largest count", "stl", put(binary(), 80, &[255; 4]), Fault::Truncated, "214748364834 bytes"),
            ("a count too small", "stl", put(binary(), 80, &[1, 0, 0, 0]), Fault::Header, "1 triangles need 134 bytes"),
            ("no triangles", "stl", binary()[..84].iter().map(|_| 0).collect(), Fault::Empty, "no faces"),
            (
                "a corner that is no number",
                "stl",
                put(binary(), 96, &nan),
                Fault::Value,
                "triangle 1: a coordinate is NaN",
            ),
            ("an infinite corner", "stl", put(binary(), 146, &[0, 0, 0x80, 0x7f]), Fault::Value, "triangle 2"),
            ("a text without an end", "stl", cut(text(), 17), Fault::Truncated, "before its `endsolid`"),
            (
                "a facet of two",
                "stl",
                replaced(&text(), "  vertex 0 0 0\n", ""),
                Fault::Syntax,
                "line 6: a facet has 2",
            ),
            (
                "a facet of four",
                "stl",
                replaced(&text(), " endloop", " vertex 0 0 0\nendloop"),
                Fault::Syntax,
                "line 7",
            ),
            (
                "a text with nan",
                "stl",
                replaced(&text(), "vertex 0 0 0", "vertex 0 nan 0"),
                Fault::Value,
                "line 4: `nan`",
            ),
            (
                "half a vertex",
                "stl",
                replaced(&text(), "vertex 0 0 0", "vertex 0 0"),
                Fault::Syntax,
                "fewer than three",
            ),
            ("an unknown word", "stl", replaced(&text(), "outer", "inner"), Fault::Syntax, "line 3: `inner`"),
        ],
        Beside::Nothing,
    );
}

#[expect(clippy::too_many_lines, reason = "it is a table")]
#[test]
fn ply_by_name() {
    let turn = turn();
    let mesh = brick([0.0; 3], [1.0; 3]);
    let (text, little) = (|| files::ply(&mesh, "ascii"), || files::ply(&mesh, "binary_little_endian"));
    let big = || files::ply(&mesh, "binary_big_endian");
    let header = |body: &str| format!("ply\nformat ascii 1.0\n{body}end_header\n").into_bytes();
    let body = little().windows(11).position(|w| w == b"end_header\n").unwrap() + 11;
    let faces = little().len() - 12 * 13;
    check(
        &turn,
        vec![
            ("no end of the header", "ply", text()[..100].to_vec(), Fault::Header, "header"),
            (
                "the largest count",
                "ply",
                replaced(&text(), "vertex 24", "vertex 18446744073709551615"),
                Fault::Truncated,
                "header",
            ),
            (
                "a count beyond",
                "ply",
                replaced(&text(), "vertex 24", "vertex 18446744073709551616"),
                Fault::Header,
                "count",
            ),
            ("a negative count", "ply", replaced(&text(), "face 12", "face -1"), Fault::Header, "-1"),
            (
                "rows without columns",
                "ply",
                header("element void 4000000000\nelement vertex 0\nelement face 0\n"),
                Fault::Header,
                "no properties",
            ),
            (
                "an unknown type",
                "ply",
                replaced(&text(), "property double z", "property quad z"),
                Fault::Header,
                "quad",
            ),
            (
                "a cloud of points",
                "ply",
                header("element vertex 1\nproperty float x\n"),
                Fault::Header,
                "no element `face`",
            ),
            (
                "no z",
                "ply",
                replaced(&text(), "double z", "double w"),
                Fault::Value,
                "row 1 of `vertex`: missing field `z`",
            ),
            (
                "a list of fractions",
                "ply",
                replaced(&text(), "uchar int vertex", "uchar float vertex"),
                Fault::Value,
                "row 1 of `face`",
            ),
            (
                "a fractional count",
                "ply",
                replaced(&text(), "uchar int vertex", "float int vertex"),
                Fault::Value,
                "cannot be a float",
            ),
            (
                "a negative vertex",
                "ply",
                replaced(&text(), "\n3 0 2 3\n", "\n3 0 -2 3\n"),
                Fault::Value,
                "row 2 of `face`",
            ),
            (
                "a vertex beyond",
                "ply",
                replaced(&text(), "\n3 0 2 3\n", "\n3 0 24 3\n"),
                Fault::Index,
                "vertex 24 of 24",
            ),
            (
                "a face of two",
                "ply",
                replaced(&text(), "\n3 0 2 3\n", "\n2 0 2\n"),
                Fault::Syntax,
                "a face has 2 corners",
            ),
            (
                "a word for a number",
                "ply",
                replaced(&text(), "\n3 0 2 3\n", "\n3 0 two 3\n"),
                Fault::Value,
                "row 2 of `face`",
            ),
            (
                "an infinite word",
                "ply",
                replaced(&text(), "\n0 0 255 0\n", "\n0 inf 255 0\n"),
                Fault::Value,
                "0, inf, 0",
            ),
            (
                "a position that is no number",
                "ply",
                put(little(), body, &[0, 0, 0xc0, 0x7f]),
                Fault::Value,
                "row 1 of `vertex`: its position is NaN",
            ),
            (
                "more corners than bytes",
                "ply",
                put(little(), faces, &[255]),
                Fault::Truncated,
                "row 1 of `face`: the file ends here",
            ),
            (
                "the other order of bytes",
                "ply",
                replaced_bytes(&little(), b"little", b"big"),
                Fault::Index,
                "of `face`",
            ),
            ("cut inside a face", "ply", cut(big(), 5), Fault::Truncated, "row 12 of `face`"),
        ],
        Beside::Nothing,
    );
}

#[test]
fn obj_by_name() {
    let turn = turn();
    // A spiral of many turns, and a comb whose teeth cross: the cutter finds no ear for long.
    let comb = |n: usize, times: usize| {
        let corner = |k: usize| format!("v {} {} 0\n", k * 7919 % n, k * 6007 % n);
        let face = (1..=n).map(|k| [" ", &k.to_string()].concat()).collect::<String>();
        let vertices: String = (0..n).map(corner).collect();
        (vertices + &format!("f{face}\n").repeat(times)).into_bytes()
    };
    let text = |t: &str| t.as_bytes().to_vec();
    check(
        &turn,
        vec![
            ("a coordinate that is no number", "obj", text("v 0 0 nan\n"), Fault::Value, "line 1: `nan`"),
            ("an infinite coordinate", "obj", text("v 0 1e999 0\n"), Fault::Value, "line 1: `1e999`"),
            ("half a vertex", "obj", text("\nv 0 0"), Fault::Syntax, "line 2"),
            ("vertex zero", "obj", text("v 0 0 0\nf 0 1 1\n"), Fault::Index, "line 2: vertex 0"),
            ("a vertex beyond", "obj", text("v 0 0 0\nf 1 2 1\n"), Fault::Index, "vertex 2 of 1"),
            ("a vertex before the first", "obj", text("v 0 0 0\nf -2 1 1\n"), Fault::Index, "vertex -2"),
            (
                "the largest vertex",
                "obj",
                text("v 0 0 0\nf 18446744073709551616 1 1\n"),
                Fault::Syntax,
                "names no vertex",
            ),
            (
                "a face of 5000 corners",
                "obj",
                text(&format!("v 0 0 0\nf{}\n", " 1".repeat(5000))),
                Fault::Syntax,
                "5000 corners",
            ),
            ("entangled faces", "obj", comb(4093, 40), Fault::TooLarge, "too entangled"),
            ("a last line that goes on", "obj", text("v 0 0 0\nf 1 1 1 \\"), Fault::Truncated, "last line"),
            (
                "a line that goes on",
                "obj",
                [b"v 0 0 0 \\\n".repeat(9), b"f 1 1".to_vec()].concat(),
                Fault::Empty,
                "no faces",
            ),
            ("no text at all", "obj", (0..=255).collect(), Fault::Empty, "0 vertices"),
        ],
        Beside::Nothing,
    );
}
