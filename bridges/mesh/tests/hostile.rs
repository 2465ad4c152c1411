//! Meshes with every end, every byte and every number changed: an error or a mesh, soon, and without much memory.

mod common;
#[path = "common/refused.rs"]
mod refused;

use common::{brick, files};
use cosplat_mesh::format::{Beside, FORMATS};
use refused::{put, survive};
use serde_json::Value;

/// Every end of a file but those that hold all of the shape already.
#[test]
fn every_truncation_is_an_error() {
    for (ending, bytes) in files::all(&brick([0.0; 3], [1.0; 3])) {
        assert!(survive(&bytes, ending, Beside::Nothing).is_ok());
        let is_text = bytes.starts_with(b"solid") || bytes.starts_with(b"ply\nformat ascii");
        for n in 0..bytes.len() {
            let result = survive(&bytes[..n], ending, Beside::Nothing);
            // The end of the last line, the name behind `endsolid`, and any line of an `.obj` or digit of a number.
            let may = ending == "obj" || is_text && n + 9 >= bytes.len();
            assert!(result.is_err() || may, "{ending} {n} of {}", bytes.len());
        }
    }
}

#[test]
fn every_byte_and_every_integer_may_be_anything() {
    for (ending, bytes) in files::all(&brick([0.0; 3], [1.0; 3])) {
        for at in 0..bytes.len() {
            for value in [0, 1, 0x20, 0x7f, 0x80, 0xff, bytes[at] ^ 1, bytes[at].wrapping_add(1)] {
                let _ = survive(&put(bytes.clone(), at, &[value]), ending, Beside::Nothing);
            }
            for value in [0, 1, i32::MAX as u32, 1 << 31, u32::MAX] {
                let width = 4.min(bytes.len() - at);
                let _ = survive(&put(bytes.clone(), at, &value.to_le_bytes()[..width]), ending, Beside::Nothing);
            }
        }
    }
}

/// Every number of a document may be 0, 1, the largest, negative or a fraction.
#[test]
fn every_number_of_a_document_may_be_anything() {
    let mesh = brick([0.0; 3], [1.0; 3]);
    let (text, buffer) = (files::document(&mesh).to_string(), files::buffer(&mesh));
    let is_digit = |at: usize| text.as_bytes().get(at).is_some_and(u8::is_ascii_digit);
    let mut tried = 0;
    for start in (0..text.len()).filter(|&at| is_digit(at) && !is_digit(at - 1)) {
        let length = text[start..].bytes().take_while(u8::is_ascii_digit).count();
        for new in ["0", "1", "-1", "4294967295", "18446744073709551615", "1e300", "0.5", "null", "\"1\""] {
            let changed = [&text[..start], new, &text[start + length..]].concat();
            let Ok(document) = serde_json::from_str::<Value>(&changed) else { continue };
            let _ = survive(&files::glb(&document, &buffer), "glb", Beside::Nothing);
            tried += 1;
        }
    }
    assert!(tried > 150, "{tried}");
}

#[test]
fn every_format_is_tried_here() {
    let tried = files::all(&brick([0.0; 3], [1.0; 3]));
    assert!(FORMATS.iter().all(|f| tried.iter().any(|(ending, _)| *ending == f.name)));
}
