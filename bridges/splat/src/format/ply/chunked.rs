//! `.compressed.ply`: rows of four packed integers, relative to chunks of 256 Gaussians.
//!
//! Layout as published by `PlayCanvas` (MIT). An element `chunk` holds the bounds of positions, log scales and, in newer
//! files, colours; `vertex` the place between them in 11, 10, 11 bits; an optional element `sh` the higher bands in
//! bytes. Axes are those of the `.ply` the file was made from.

use super::columns::{KEPT, rest_per_channel};
use super::header::{Element, Encoding, Header, Kind, parse};
use super::rows::{comments, double, skip_binary};
use crate::error::{Fault, SplatError};
use crate::format::Decoded;
use crate::splats::{Splats, coefficients, dc_of_colour, logit_of_opacity};

/// Gaussians of one chunk.
const CHUNK: usize = 256;
/// Columns of bounds: three lower, three upper.
type Bounds = [Column; 6];

const POSITIONS: [&str; 6] = ["min_x", "min_y", "min_z", "max_x", "max_y", "max_z"];
const SCALES: [&str; 6] = ["min_scale_x", "min_scale_y", "min_scale_z", "max_scale_x", "max_scale_y", "max_scale_z"];
const COLOURS: [&str; 6] = ["min_r", "min_g", "min_b", "max_r", "max_g", "max_b"];
const PACKED: [&str; 4] = ["packed_position", "packed_rotation", "packed_scale", "packed_color"];

/// Whether the first bytes are the header of such a file.
pub(super) fn recognise(bytes: &[u8]) -> bool {
    // The name stands in the first kilobytes of every header; a comment of that length is no known writer's.
    let head = &bytes[..bytes.len().min(1 << 14)];
    super::is_ply(bytes) && head.windows(PACKED[0].len()).any(|w| w == PACKED[0].as_bytes())
}

fn fault(what: impl Into<String>) -> SplatError {
    SplatError::new(Fault::Header, "header", what, "write the file again with the tool it came from")
}

/// A number of each row of a table.
#[derive(Clone, Copy, Debug)]
struct Column {
    offset: usize,
    kind: Kind,
}

/// An element with its rows, all there.
#[derive(Clone, Copy)]
struct Table<'a> {
    element: &'a Element,
    rows: &'a [u8],
    stride: usize,
    big: bool,
}

impl<'a> Table<'a> {
    /// The rows of an element that begin here.
    fn at(body: &'a [u8], element: &'a Element, big: bool) -> Result<Table<'a>, SplatError> {
        let stride = element.stride().filter(|stride| *stride > 0);
        let stride = stride.ok_or_else(|| fault(format!("element `{}` holds a list or nothing", element.name)))?;
        let rest = skip_binary(body, element, big)?;
        Ok(Table { element, rows: &body[..body.len() - rest.len()], stride, big })
    }

    fn len(&self) -> usize {
        self.rows.len() / self.stride
    }

    fn find(&self, name: &str) -> Option<Column> {
        let at = self.element.properties.iter().position(|p| p.name == name)?;
        let offset = self.element.properties[..at].iter().map(|p| p.kind.size()).sum();
        Some(Column { offset, kind: self.element.properties[at].kind })
    }

    fn column(&self, name: &str) -> Result<Column, SplatError> {
        self.find(name).ok_or_else(|| fault(format!("there is no property `{name}` of `{}`", self.element.name)))
    }

    fn columns<const N: usize>(&self, names: [&str; N]) -> Result<[Column; N], SplatError> {
        let mut columns = [Column { offset: 0, kind: Kind::U8 }; N];
        for (column, name) in columns.iter_mut().zip(names) {
            *column = self.column(name)?;
        }
        Ok(columns)
    }

    /// A number; the row is known to be there.
    fn value(&self, row: usize, column: Column) -> f64 {
        let at = row * self.stride + column.offset;
        double(&self.rows[at..at + column.kind.size()], column.kind, self.big)
    }

    /// Lower and upper bounds of one row.
    fn bounds(&self, row: usize, columns: &Bounds) -> [[f64; 3]; 2] {
        let of = |first: usize| [0, 1, 2].map(|k| self.value(row, columns[first + k]));
        [of(0), of(3)]
    }
}

/// Decodes a file.
pub(super) fn read(bytes: &[u8]) -> Result<Decoded, SplatError> {
    let header = parse(bytes)?;
    if header.encoding == Encoding::Ascii {
        return Err(fault("a chunked PLY is never text"));
    }
    let [chunks, vertices, bands] = tables(bytes, &header)?;
    let (Some(chunks), Some(vertices)) = (chunks, vertices) else {
        return Err(fault("one of the elements `chunk` and `vertex` is missing"));
    };
    let count = vertices.len();
    if chunks.len() < count.div_ceil(CHUNK) {
        return Err(fault(format!("{} chunks of {CHUNK} cannot hold {count} Gaussians", chunks.len())));
    }
    let mut notes = comments(&header);
    let mut splats = Splats::with_capacity(count, 0);
    unpack(chunks, vertices, &mut splats)?;
    if let Some(bands) = bands {
        if bands.len() != count {
            return Err(fault(format!("element `sh` has {} rows for {count} Gaussians", bands.len())));
        }
        let left_out = higher_bands(bands, &mut splats)?;
        notes.extend(left_out.then(|| "bands above 3 of degree 4 are left out".to_owned()));
    }
    Ok(Decoded { splats, notes })
}

/// The elements `chunk`, `vertex` and `sh`, where they are.
fn tables<'a>(bytes: &'a [u8], header: &'a Header) -> Result<[Option<Table<'a>>; 3], SplatError> {
    let big = header.encoding == Encoding::Big;
    let mut body = &bytes[header.body..];
    let mut found = [None; 3];
    for element in &header.elements {
        if let Some(k) = ["chunk", "vertex", "sh"].iter().position(|name| *name == element.name) {
            found[k] = Some(Table::at(body, element, big)?);
        }
        body = skip_binary(body, element, big)?;
    }
    Ok(found)
}

/// The lowest `count` bits above `shift`, 0 to 1.
fn part(packed: u32, shift: u32, count: u32) -> f64 {
    let largest = (1_u32 << count) - 1;
    f64::from((packed >> shift) & largest) / f64::from(largest)
}

/// Three places between bounds, in 11, 10 and 11 bits, the first one highest.
fn between([lower, upper]: [[f64; 3]; 2], packed: u32) -> [f32; 3] {
    let t = [part(packed, 21, 11), part(packed, 11, 10), part(packed, 0, 11)];
    [0, 1, 2].map(|k| (lower[k] * (1.0 - t[k]) + upper[k] * t[k]) as f32)
}

/// The two upper bits say which of w, x, y, z is left out because it is largest; the others follow in order as
/// (v / 1023 − ½) √2.
fn rotation(packed: u32) -> [f32; 4] {
    let largest = (packed >> 30) as usize;
    let small = [20, 10, 0].map(|shift| (part(packed, shift, 10) - 0.5) * std::f64::consts::SQRT_2);
    let left = (1.0 - small.iter().map(|v| v * v).sum::<f64>()).max(0.0).sqrt();
    let mut q = [left as f32; 4];
    for (at, v) in (0..4).filter(|&at| at != largest).zip(small) {
        q[at] = v as f32;
    }
    q
}

/// Everything but the higher bands.
fn unpack(chunks: Table<'_>, vertices: Table<'_>, splats: &mut Splats) -> Result<(), SplatError> {
    let (positions, scales) = (chunks.columns(POSITIONS)?, chunks.columns(SCALES)?);
    // Older files hold colours from 0 to 1 without bounds.
    let colours = chunks.find(COLOURS[0]).map(|_| chunks.columns(COLOURS)).transpose()?;
    let packed = vertices.columns(PACKED)?;
    for i in 0..vertices.len() {
        let chunk = i / CHUNK;
        let [position, turn, scale, colour] = packed.map(|column| vertices.value(i, column) as u32);
        let [lower, upper] = colours.as_ref().map_or([[0.0; 3], [1.0; 3]], |c| chunks.bounds(chunk, c));
        let rgb = [24, 16, 8].map(|shift| part(colour, shift, 8));
        splats.positions.push(between(chunks.bounds(chunk, &positions), position));
        splats.log_scales.push(between(chunks.bounds(chunk, &scales), scale));
        splats.rotations.push(rotation(turn));
        splats.sh_dc.push([0, 1, 2].map(|k| dc_of_colour(lower[k] * (1.0 - rgb[k]) + upper[k] * rgb[k])));
        splats.opacity_logits.push(logit_of_opacity(part(colour, 0, 8)));
    }
    Ok(())
}

/// Reads the higher bands, channel-major; says whether some were left out.
fn higher_bands(bands: Table<'_>, splats: &mut Splats) -> Result<bool, SplatError> {
    let per_channel = rest_per_channel(bands.element)?;
    let kept = per_channel.min(KEPT);
    let mut columns = Vec::new();
    for i in 0..3 * per_channel {
        columns.push(bands.column(&format!("f_rest_{i}"))?);
    }
    splats.sh_degree = (1..=3).find(|&d| coefficients(d) == kept).unwrap_or(0);
    splats.sh_rest.reserve_exact(bands.len() * kept);
    for row in 0..bands.len() {
        let at = |channel: usize, j: usize| coefficient(bands.value(row, columns[channel * per_channel + j]));
        splats.sh_rest.extend((0..kept).map(|j| [at(0, j), at(1, j), at(2, j)]));
    }
    Ok(per_channel > kept)
}

/// −4 to 4 in 256 steps, the value in the middle of its step but for the two ends, which are exact.
fn coefficient(byte: f64) -> f32 {
    let unit = match byte {
        0.0 => 0.0,
        255.0 => 1.0,
        b => (b + 0.5) / 256.0,
    };
    ((unit - 0.5) * 8.0) as f32
}
