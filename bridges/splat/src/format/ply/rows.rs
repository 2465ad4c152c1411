//! The rows behind the header.

use super::columns::{Plan, ROW, Target};
use super::header::{Element, Encoding, Header, Kind, parse};
use crate::error::{Fault, SplatError};
use crate::format::Decoded;
use crate::format::half::half_to_f32;
use crate::splats::Splats;

/// Decodes a file.
pub(super) fn read(bytes: &[u8]) -> Result<Decoded, SplatError> {
    let header = parse(bytes)?;
    let Some(index) = header.elements.iter().position(|e| e.name == "vertex") else {
        let advice = "convert the file to an INRIA `.ply`";
        return Err(SplatError::new(Fault::Header, "header", "there is no element `vertex`", advice));
    };
    let vertex = &header.elements[index];
    if vertex.stride().is_none() {
        let what = "element `vertex` holds a list, which no splat file does";
        return Err(SplatError::new(Fault::Header, "header", what, "convert the file to an INRIA `.ply`"));
    }
    let plan = Plan::new(vertex)?;
    let mut notes = comments(&header);
    if plan.file_degree > plan.degree {
        notes.push(format!("bands above {} of degree {} are left out", plan.degree, plan.file_degree));
    }
    let splats = if header.encoding == Encoding::Ascii {
        read_text(bytes, &header, index, plan)?
    } else {
        read_binary(bytes, &header, index, plan)?
    };
    Ok(Decoded { splats, notes })
}

/// Comments of the file as notes.
pub(super) fn comments(header: &Header) -> Vec<String> {
    header.comments.iter().map(|c| format!("comment: {c}")).collect()
}

/// Room for the rows of `vertex`; called after it is known that the file can hold them.
fn room(vertex: &Element, plan: &mut Plan) -> Splats {
    let count = vertex.count as usize;
    for extra in &mut plan.extras {
        extra.values.reserve_exact(count);
    }
    Splats::with_capacity(count, plan.degree)
}

fn read_binary(bytes: &[u8], header: &Header, index: usize, mut plan: Plan) -> Result<Splats, SplatError> {
    let big = header.encoding == Encoding::Big;
    let mut body = &bytes[header.body..];
    for element in &header.elements[..index] {
        body = skip_binary(body, element, big)?;
    }
    let vertex = &header.elements[index];
    let stride = vertex.stride().unwrap_or(0);
    let needs = u128::from(vertex.count) * stride as u128;
    if needs > body.len() as u128 {
        return Err(SplatError::truncated(
            "rows of `vertex`",
            u64::try_from(needs).unwrap_or(u64::MAX),
            body.len() as u64,
        ));
    }
    let mut splats = room(vertex, &mut plan);
    let mut row = [0_f32; ROW];
    for raw in body.chunks_exact(stride).take(vertex.count as usize) {
        for column in &plan.columns {
            let cell = &raw[column.offset..column.offset + column.kind.size()];
            match column.target {
                Target::Slot(slot) => row[slot] = single(cell, column.kind, big),
                Target::Extra(extra) => plan.extras[extra].values.push(double(cell, column.kind, big)),
                Target::Nowhere => {}
            }
        }
        plan.push(&row, &mut splats);
    }
    splats.extras = plan.extras;
    Ok(splats)
}

/// What follows the rows of an element.
pub(super) fn skip_binary<'a>(body: &'a [u8], element: &Element, big: bool) -> Result<&'a [u8], SplatError> {
    let place = || format!("rows of `{}`", element.name);
    if let Some(stride) = element.stride() {
        let needs = u128::from(element.count) * stride as u128;
        let enough = usize::try_from(needs).ok().and_then(|n| body.get(n..));
        return enough.ok_or_else(|| {
            SplatError::truncated(place(), u64::try_from(needs).unwrap_or(u64::MAX), body.len() as u64)
        });
    }
    let mut at = 0_usize;
    for _ in 0..element.count {
        for property in &element.properties {
            let mut items = 1.0;
            if let Some(kind) = property.list {
                let cell = body.get(at..at + kind.size());
                let cell = cell.ok_or_else(|| SplatError::truncated(place(), at as u64 + 1, body.len() as u64))?;
                items = double(cell, kind, big).clamp(0.0, 1e15);
                at += kind.size();
            }
            // Saturates for absurd counts, and is then beyond the end.
            at = at.saturating_add((items * property.kind.size() as f64) as usize);
            if at > body.len() {
                return Err(SplatError::truncated(place(), at as u64, body.len() as u64));
            }
        }
    }
    Ok(&body[at..])
}

/// A binary number in double precision: exact for every kind.
pub(super) fn double(cell: &[u8], kind: Kind, big: bool) -> f64 {
    let mut raw = [0_u8; 8];
    raw[..cell.len()].copy_from_slice(cell);
    if big {
        raw[..cell.len()].reverse();
    }
    let bits = u64::from_le_bytes(raw);
    match kind {
        Kind::I8 => f64::from((bits as u8).cast_signed()),
        Kind::U8 => f64::from(bits as u8),
        Kind::I16 => f64::from((bits as u16).cast_signed()),
        Kind::U16 => f64::from(bits as u16),
        Kind::I32 => f64::from((bits as u32).cast_signed()),
        Kind::U32 => f64::from(bits as u32),
        Kind::F16 => f64::from(half_to_f32(bits as u16)),
        Kind::F32 => f64::from(f32::from_bits(bits as u32)),
        Kind::F64 => f64::from_bits(bits),
    }
}

/// A binary number in single precision; bits of a `float` are kept.
fn single(cell: &[u8], kind: Kind, big: bool) -> f32 {
    match (kind, cell) {
        (Kind::F32, &[a, b, c, d]) if big => f32::from_be_bytes([a, b, c, d]),
        (Kind::F32, &[a, b, c, d]) => f32::from_le_bytes([a, b, c, d]),
        _ => double(cell, kind, big) as f32,
    }
}

fn read_text(bytes: &[u8], header: &Header, index: usize, mut plan: Plan) -> Result<Splats, SplatError> {
    let body = &bytes[header.body..];
    let advice = "write the file again as binary";
    let Ok(text) = str::from_utf8(body) else {
        return Err(SplatError::new(Fault::Value, "rows", "an ascii PLY holds bytes that are not text", advice));
    };
    let mut words = text.split_ascii_whitespace();
    for element in &header.elements[..index] {
        skip_text(&mut words, element)?;
    }
    let vertex = &header.elements[index];
    // A number and the space behind it are at least two bytes.
    let needs = u128::from(vertex.count) * plan.columns.len() as u128 * 2;
    if needs > body.len() as u128 + 1 {
        return Err(SplatError::truncated(
            "rows of `vertex`",
            u64::try_from(needs).unwrap_or(u64::MAX),
            body.len() as u64,
        ));
    }
    let mut splats = room(vertex, &mut plan);
    let mut row = [0_f32; ROW];
    for number in 1..=vertex.count {
        for column in &plan.columns {
            let word = words.next().ok_or_else(|| {
                let what = "the text ends before its last row";
                SplatError::new(Fault::Truncated, format!("row {number}"), what, "copy or download the file again")
            })?;
            let bad = || {
                let what = format!("`{word}` is not a number");
                SplatError::new(Fault::Value, format!("row {number}"), what, advice)
            };
            match column.target {
                Target::Slot(slot) => row[slot] = word.parse().map_err(|_| bad())?,
                Target::Extra(extra) => plan.extras[extra].values.push(word.parse().map_err(|_| bad())?),
                Target::Nowhere => {}
            }
        }
        plan.push(&row, &mut splats);
    }
    splats.extras = plan.extras;
    Ok(splats)
}

fn skip_text<'a>(words: &mut impl Iterator<Item = &'a str>, element: &Element) -> Result<(), SplatError> {
    let ended = || {
        let what = "the text ends before its last row";
        SplatError::new(
            Fault::Truncated,
            format!("rows of `{}`", element.name),
            what,
            "copy or download the file again",
        )
    };
    if element.properties.is_empty() {
        return Ok(());
    }
    for _ in 0..element.count {
        for property in &element.properties {
            let first = words.next().ok_or_else(ended)?;
            if property.list.is_some() {
                let items: u64 = first.parse().map_err(|_| ended())?;
                for _ in 0..items {
                    words.next().ok_or_else(ended)?;
                }
            }
        }
    }
    Ok(())
}
