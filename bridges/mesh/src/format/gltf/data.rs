//! Numbers behind the accessors of a document.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;

use super::schema::{Accessor, Buffer, Document};
use super::{AGAIN, Beside, EXPORT, fault, item};
use crate::error::{Fault, MeshError};

/// All files beside a document together have at most this many bytes.
const LARGEST_BYTES: u64 = 1 << 30;
const FLOAT: u32 = 5126;

/// A document with its buffers.
pub(super) struct Data<'a> {
    pub(super) document: &'a Document,
    buffers: Vec<Content<'a>>,
}

enum Content<'a> {
    /// In the file itself.
    Chunk(&'a [u8]),
    /// Beside it, or as text in it.
    Own(Vec<u8>),
}

/// The rows of an accessor, all there.
struct Rows<'a> {
    bytes: &'a [u8],
    stride: usize,
    count: usize,
    width: usize,
}

impl<'a> Rows<'a> {
    fn iter(&self) -> impl Iterator<Item = &'a [u8]> {
        let (bytes, stride, width) = (self.bytes, self.stride, self.width);
        (0..self.count).map(move |row| &bytes[row * stride..row * stride + width])
    }
}

impl<'a> Data<'a> {
    /// Fetches every buffer.
    pub(super) fn new(document: &'a Document, chunk: Option<&'a [u8]>, beside: Beside<'_>) -> Result<Self, MeshError> {
        let total = document.buffers.iter().fold(0_u64, |sum, buffer| sum.saturating_add(buffer.byte_length));
        if total > LARGEST_BYTES {
            let what = format!("buffers of {total} bytes are more than the allowed {LARGEST_BYTES}");
            return Err(MeshError::new(Fault::TooLarge, "buffers", what, "simplify the mesh"));
        }
        let content = |(number, buffer)| content(number, buffer, chunk, beside);
        let buffers = document.buffers.iter().enumerate().map(content).collect::<Result<_, _>>()?;
        Ok(Data { document, buffers })
    }

    /// Bytes of all buffers.
    pub(super) fn bytes(&self) -> u64 {
        self.document.buffers.iter().map(|buffer| buffer.byte_length).sum()
    }

    /// Rows of an accessor.
    pub(super) fn count(&self, number: usize) -> Result<u64, MeshError> {
        item(&self.document.accessors, number, "accessor").map(|accessor| accessor.count)
    }

    /// Positions, in units of the node that shows them.
    pub(super) fn positions(&self, number: usize) -> Result<Vec<[f64; 3]>, MeshError> {
        let accessor = item(&self.document.accessors, number, "accessor")?;
        if (accessor.component_type, accessor.shape.as_str()) != (FLOAT, "VEC3") {
            let what = format!("positions are {} of type {}", accessor.shape, accessor.component_type);
            return Err(fault(place(number), what + ", and only three numbers of single precision are read"));
        }
        let rows = self.rows(accessor, number, 12)?;
        let position =
            |row: &[u8]| row.as_chunks::<4>().0.iter().map(|b| f64::from(f32::from_le_bytes(*b))).collect::<Vec<f64>>();
        let positions = rows.iter().enumerate().map(|(k, row)| {
            let p = <[f64; 3]>::try_from(position(row)).unwrap_or([f64::NAN; 3]);
            if p.iter().all(|v| v.is_finite()) {
                return Ok(p);
            }
            let what = format!("position {k} is {}, {}, {}", p[0], p[1], p[2]);
            Err(MeshError::new(Fault::Value, place(number), what, EXPORT))
        });
        positions.collect()
    }

    /// Colours of vertices, linear red, green, blue from 0 to 1; what they let through is left out.
    pub(super) fn colours(&self, number: usize) -> Result<Vec<[f32; 3]>, MeshError> {
        let accessor = item(&self.document.accessors, number, "accessor")?;
        let channels = match accessor.shape.as_str() {
            "VEC3" => 3,
            "VEC4" => 4,
            shape => return Err(fault(place(number), format!("colours are {shape}, not VEC3 or VEC4"))),
        };
        let whole = accessor.normalized;
        let (width, value): (usize, fn(&[u8]) -> f32) = match accessor.component_type {
            FLOAT => (4, |b| b.first_chunk().map_or(0.0, |b| f32::from_le_bytes(*b))),
            5121 if whole => (1, |b| b.first().map_or(0.0, |b| f32::from(*b) / 255.0)),
            5123 if whole => (2, |b| b.first_chunk().map_or(0.0, |b| f32::from(u16::from_le_bytes(*b)) / 65_535.0)),
            kind => return Err(fault(place(number), format!("colours are of type {kind}, normalized: {whole}"))),
        };
        let rows = self.rows(accessor, number, width * channels)?;
        let colour = |row: &[u8]| [0, 1, 2].map(|k| value(&row[k * width..]));
        // A number that is none, or beyond the range, is cut to it.
        Ok(rows.iter().map(|row| colour(row).map(|c| if c > 0.0 { c.min(1.0) } else { 0.0 })).collect())
    }

    /// Indices of vertices.
    pub(super) fn indices(&self, number: usize) -> Result<Vec<u32>, MeshError> {
        let accessor = item(&self.document.accessors, number, "accessor")?;
        let width = match (accessor.component_type, accessor.shape.as_str()) {
            (5121, "SCALAR") => 1,
            (5123, "SCALAR") => 2,
            (5125, "SCALAR") => 4,
            (kind, shape) => return Err(fault(place(number), format!("indices are {shape} of type {kind}"))),
        };
        let rows = self.rows(accessor, number, width)?;
        // Little-endian: what is missing above is zero.
        let index = |row: &[u8]| row.iter().rev().fold(0, |sum, byte| sum << 8 | u32::from(*byte));
        Ok(rows.iter().map(index).collect())
    }

    /// The rows of `width` bytes of an accessor, if its view and its buffer hold them.
    fn rows(&self, accessor: &Accessor, number: usize, width: usize) -> Result<Rows<'_>, MeshError> {
        if accessor.sparse.is_some() {
            return Err(fault(place(number), "sparse numbers are not read".to_owned()));
        }
        let Some(view_number) = accessor.buffer_view else {
            return Err(fault(place(number), "it has no buffer view".to_owned()));
        };
        let view = item(&self.document.buffer_views, view_number, "buffer view")?;
        let buffer = match item(&self.buffers, view.buffer, "buffer")? {
            Content::Chunk(bytes) => bytes,
            Content::Own(bytes) => bytes.as_slice(),
        };
        let part = |bytes: &'_ [u8], at: u64, length: u128| {
            let end = usize::try_from(u128::from(at) + length).ok().filter(|end| *end <= bytes.len());
            end.map(|end| at as usize..end).ok_or_else(|| {
                let what = format!("{length} bytes from byte {at} are named and {} are there", bytes.len());
                MeshError::new(Fault::Truncated, place(number), what, AGAIN)
            })
        };
        let bytes = &buffer[part(buffer, view.byte_offset, u128::from(view.byte_length))?];
        let stride = view.byte_stride.unwrap_or(width as u64);
        if stride < width as u64 {
            return Err(fault(place(number), format!("rows of {width} bytes are {stride} bytes apart")));
        }
        let Some(steps) = accessor.count.checked_sub(1) else {
            return Ok(Rows { bytes: &[], stride: width, count: 0, width });
        };
        let length = u128::from(stride) * u128::from(steps) + width as u128;
        let bytes = &bytes[part(bytes, accessor.byte_offset, length)?];
        Ok(Rows { bytes, stride: stride as usize, count: accessor.count as usize, width })
    }
}

fn place(accessor: usize) -> String {
    format!("accessor {accessor}")
}

/// The bytes of a buffer, as many as it promises.
fn content<'a>(
    number: usize,
    buffer: &Buffer,
    chunk: Option<&'a [u8]>,
    beside: Beside<'_>,
) -> Result<Content<'a>, MeshError> {
    let place = || format!("buffer {number}");
    let enough = |has: usize| {
        let what = format!("{} bytes are promised and {has} are there", buffer.byte_length);
        if has as u64 >= buffer.byte_length {
            Ok(())
        } else {
            Err(MeshError::new(Fault::Truncated, place(), what, AGAIN))
        }
    };
    let Some(uri) = &buffer.uri else {
        let chunk =
            chunk.ok_or_else(|| fault(place(), "it names no file, and the file has no binary chunk".to_owned()))?;
        enough(chunk.len())?;
        return Ok(Content::Chunk(&chunk[..buffer.byte_length as usize]));
    };
    if let Some(data) = uri.strip_prefix("data:") {
        let text = data.split_once(";base64,").map(|(_, text)| text);
        let decoded = text.and_then(|text| STANDARD.decode(text).ok());
        let decoded = decoded.ok_or_else(|| fault(place(), "its `data:` is no base64".to_owned()))?;
        enough(decoded.len())?;
        return Ok(Content::Own(decoded));
    }
    let read = beside.read(uri, buffer.byte_length);
    read.map(Content::Own).map_err(|what| {
        let advice = "put the file there, or export the mesh as one `.glb` file";
        MeshError::new(Fault::Io, place(), what, advice)
    })
}
