//! Mesh files that are to be refused.

#![allow(dead_code, reason = "every test file is a program of its own and uses a part")]

#[path = "../../../splat/tests/common/refusal.rs"]
mod refusal;

use cosplat_mesh::format::{Beside, read};
use cosplat_mesh::{Fault, MeshError};
use refusal::Turn;
pub(crate) use refusal::turn;

/// Memory for 2²⁰ vertices and indices, which documents may show by their nodes, and for each byte of a file: `{},` in a
/// list of a document becomes a node of 400 bytes.
const ALLOWED: refusal::Allowed = refusal::Allowed { free: 48 << 20, each: 200 };

pub(crate) type Case = refusal::Case<Fault>;

/// Every case is refused for the right reason.
pub(crate) fn check(turn: &Turn, cases: Vec<Case>, beside: Beside<'_>) {
    refusal::check(turn, cases, ALLOWED, |bytes, ending| {
        decode(bytes, ending, beside).map_err(|e| (e.fault, e.to_string()))
    });
}

/// Reads within bounds; whether there was an error is for the caller.
pub(crate) fn survive(bytes: &[u8], ending: &str, beside: Beside<'_>) -> Result<(), MeshError> {
    let result = refusal::bounded(&turn(), bytes.len(), ALLOWED, || decode(bytes, ending, beside));
    result.inspect_err(|error| refusal::assert_plain(&error.to_string()))
}

/// Reads; what comes of it can be used.
fn decode(bytes: &[u8], ending: &str, beside: Beside<'_>) -> Result<(), MeshError> {
    let decoded = read(bytes, Some(ending), beside).inspect_err(|e| {
        assert!(!e.place.is_empty() && !e.what.is_empty() && !e.advice.is_empty(), "{e:?}");
    })?;
    let n = decoded.mesh.vertices_m.len();
    assert!(decoded.mesh.triangles.iter().flatten().all(|i| (*i as usize) < n));
    assert!(decoded.mesh.vertices_m.iter().flatten().all(|v| v.is_finite()));
    Ok(())
}

/// Other bytes at a place.
pub(crate) fn put(mut bytes: Vec<u8>, at: usize, new: &[u8]) -> Vec<u8> {
    bytes[at..at + new.len()].copy_from_slice(new);
    bytes
}

/// Without its last bytes.
pub(crate) fn cut(mut bytes: Vec<u8>, off: usize) -> Vec<u8> {
    bytes.truncate(bytes.len() - off);
    bytes
}
