//! What the document promises is compared with the bytes that are there before anything is made of it.

use std::collections::BTreeMap;

use serde::Deserialize;
use serde::de::IgnoredAny;

use super::{BIN, BYTE, EXTENSION, FLOAT, JSON, MAGIC, SHORT, UNSIGNED_BYTE, UNSIGNED_SHORT, attribute, coefficient};
use crate::error::{Fault, SplatError};
use crate::format::Decoded;
use crate::merge::merge;
use crate::splats::{Axes, Splats, logit_of_opacity};

/// Bytes of the document at most: that of a capture has some thousand, and each may become 250 in memory.
const LONGEST: usize = 1 << 16;
/// Bytes of a place, the least that a Gaussian has.
const PLACE: usize = 12;
const AGAIN: &str = "copy or download the file again";
const EXPORT: &str = "export it again as one binary glTF 2.0 without compression, or as `.ply`";

#[derive(Deserialize)]
struct Document {
    #[serde(default)]
    nodes: Vec<Node>,
    #[serde(default)]
    meshes: Vec<Mesh>,
    #[serde(default)]
    accessors: Vec<Accessor>,
    #[serde(default, rename = "bufferViews")]
    views: Vec<View>,
    #[serde(default)]
    buffers: Vec<Buffer>,
}

#[derive(Deserialize)]
struct Node {
    matrix: Option<[f64; 16]>,
    translation: Option<[f64; 3]>,
    rotation: Option<[f64; 4]>,
    scale: Option<[f64; 3]>,
}

#[derive(Deserialize)]
struct Mesh {
    primitives: Vec<Primitive>,
}

#[derive(Deserialize)]
struct Primitive {
    attributes: BTreeMap<String, usize>,
    #[serde(default)]
    extensions: BTreeMap<String, Extension>,
}

#[derive(Deserialize)]
struct Extension {
    extensions: Option<IgnoredAny>,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
struct Accessor {
    buffer_view: Option<usize>,
    #[serde(default)]
    byte_offset: usize,
    component_type: u32,
    #[serde(default)]
    normalized: bool,
    count: usize,
    r#type: String,
    sparse: Option<IgnoredAny>,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
struct View {
    buffer: usize,
    #[serde(default)]
    byte_offset: usize,
    byte_length: usize,
    byte_stride: Option<usize>,
}

#[derive(Deserialize)]
struct Buffer {
    uri: Option<IgnoredAny>,
}

fn header(place: impl Into<String>, what: impl Into<String>) -> SplatError {
    SplatError::new(Fault::Header, place, what, EXPORT)
}

fn unsupported(place: impl Into<String>, what: impl Into<String>) -> SplatError {
    SplatError::new(Fault::Unsupported, place, what, EXPORT)
}

/// Decodes all Gaussians of a file, mesh after mesh.
pub(super) fn read(bytes: &[u8]) -> Result<Decoded, SplatError> {
    let (json, bin) = chunks(bytes)?;
    if json.len() > LONGEST {
        let what = format!("its document has {} bytes, and {LONGEST} are read", json.len());
        return Err(SplatError::new(Fault::TooLarge, "JSON", what, EXPORT));
    }
    let document: Document =
        serde_json::from_slice(json).map_err(|e| header(format!("JSON, line {}", e.line()), e.to_string()))?;
    if document.nodes.iter().any(Node::moves) {
        return Err(unsupported("nodes", "a node moves, turns or scales what it shows"));
    }
    let file = File { document: &document, bin };
    let primitives = document.meshes.iter().flat_map(|m| &m.primitives);
    let splats: Vec<&Primitive> = primitives.filter(|p| p.extensions.contains_key(EXTENSION)).collect();
    if splats.is_empty() {
        let what = format!("no primitive has the extension `{EXTENSION}`");
        return Err(SplatError::new(
            Fault::Unsupported,
            "meshes",
            what,
            "as a surface it is read where a mesh is wanted",
        ));
    }
    let mut room = bin.len() / PLACE;
    let mut sets = Vec::new();
    for primitive in splats {
        sets.push(file.splats(primitive, &mut room)?);
    }
    let sets: Vec<&Splats> = sets.iter().collect();
    let splats = merge(&sets).map_err(|e| header("meshes", e.to_string()))?;
    Ok(Decoded { splats, notes: Vec::new() })
}

/// The document and the buffer.
fn chunks(bytes: &[u8]) -> Result<(&[u8], &[u8]), SplatError> {
    let number = |at: usize| Some(u32::from_le_bytes(*bytes.get(at..)?.first_chunk()?));
    let (Some(version), Some(length)) = (number(4), number(8)) else {
        return Err(SplatError::truncated("header", 12, bytes.len() as u64));
    };
    if !bytes.starts_with(MAGIC) || version != 2 {
        return Err(unsupported("header", format!("version {version} of the container is not 2")));
    }
    if (length as usize) > bytes.len() {
        return Err(SplatError::truncated("header", u64::from(length), bytes.len() as u64));
    }
    let chunk = |at: usize, wanted: u32| {
        let (length, kind) = (number(at)? as usize, number(at + 4)?);
        (kind == wanted).then(|| bytes.get(at + 8..)?.get(..length)).flatten()
    };
    let broken = |what: &str| SplatError::new(Fault::Header, "chunks", what, AGAIN);
    let json = chunk(12, JSON).ok_or_else(|| broken("the first chunk is no document, or cut off"))?;
    let bin = chunk(20 + json.len(), BIN).ok_or_else(|| broken("the second chunk is no buffer, or cut off"))?;
    Ok((json, bin))
}

impl Node {
    fn moves(&self) -> bool {
        let one = |at: usize| if at == 0 { 1.0 } else { 0.0 };
        let differs = |values: Option<&[f64]>, usual: &dyn Fn(usize) -> f64| {
            values.is_some_and(|v| v.iter().enumerate().any(|(i, v)| (v - usual(i)).abs() > 0.0))
        };
        differs(self.matrix.as_ref().map(<[_; 16]>::as_slice), &|i| one(i % 5))
            || differs(self.translation.as_ref().map(<[_; 3]>::as_slice), &|_| 0.0)
            || differs(self.rotation.as_ref().map(<[_; 4]>::as_slice), &|i| one(3 - i))
            || differs(self.scale.as_ref().map(<[_; 3]>::as_slice), &|_| 1.0)
    }
}

struct File<'a> {
    document: &'a Document,
    bin: &'a [u8],
}

impl File<'_> {
    fn splats(&self, primitive: &Primitive, room: &mut usize) -> Result<Splats, SplatError> {
        if primitive.extensions.get(EXTENSION).is_some_and(|e| e.extensions.is_some()) {
            return Err(unsupported(
                "primitive",
                format!("`{EXTENSION}` has an extension of its own, as for compression"),
            ));
        }
        let count = self.count(primitive, "POSITION")?;
        *room = room.checked_sub(count).ok_or_else(|| {
            let what = format!("more Gaussians are shown than {} bytes of places hold", self.bin.len());
            SplatError::new(Fault::TooLarge, "primitives", what, EXPORT)
        })?;
        let named = |name: &str| self.values::<3>(primitive, name, count);
        let has = |degree: usize| primitive.attributes.contains_key(&coefficient(degree * degree));
        let sh_degree = (1..=3).take_while(|d| has(*d)).count() as u8;
        let mut splats = Splats { sh_degree, axes: Axes::Rub, ..Splats::default() };
        splats.positions = named("POSITION")?;
        splats.log_scales = named(&attribute("SCALE"))?;
        splats.log_scales.iter_mut().flatten().for_each(|s| *s = f64::from(*s).ln() as f32);
        splats.sh_dc = named(&coefficient(0))?;
        let rotations = self.values::<4>(primitive, &attribute("ROTATION"), count)?;
        splats.rotations = rotations.into_iter().map(|[x, y, z, w]| [w, x, y, z]).collect();
        let opacities = self.values::<1>(primitive, &attribute("OPACITY"), count)?;
        splats.opacity_logits = opacities.into_iter().map(|[o]| logit_of_opacity(f64::from(o))).collect();
        let k = splats.coefficients();
        splats.sh_rest = vec![[0.0; 3]; count * k];
        for j in 0..k {
            for (i, value) in named(&coefficient(j + 1))?.into_iter().enumerate() {
                splats.sh_rest[i * k + j] = value;
            }
        }
        Ok(splats)
    }

    fn accessor(&self, primitive: &Primitive, name: &str) -> Result<&Accessor, SplatError> {
        let number =
            primitive.attributes.get(name).ok_or_else(|| header("primitive", format!("it has no `{name}`")))?;
        let missing = || header(format!("`{name}`"), format!("there is no accessor {number}"));
        self.document.accessors.get(*number).ok_or_else(missing)
    }

    fn count(&self, primitive: &Primitive, name: &str) -> Result<usize, SplatError> {
        Ok(self.accessor(primitive, name)?.count)
    }

    /// The numbers of an attribute, of which there must be so many.
    fn values<const N: usize>(
        &self,
        primitive: &Primitive,
        name: &str,
        count: usize,
    ) -> Result<Vec<[f32; N]>, SplatError> {
        let place = format!("`{name}`");
        let accessor = self.accessor(primitive, name)?;
        let kind = ["", "SCALAR", "VEC2", "VEC3", "VEC4"][N];
        if accessor.count != count || accessor.r#type != kind {
            let (has, of) = (accessor.count, &accessor.r#type);
            return Err(header(place, format!("{has} `{of}` are there in place of {count} `{kind}`")));
        }
        if accessor.sparse.is_some() {
            return Err(unsupported(place, "it is sparse"));
        }
        let size = match accessor.component_type {
            BYTE | UNSIGNED_BYTE => 1,
            SHORT | UNSIGNED_SHORT => 2,
            FLOAT => 4,
            other => return Err(header(place, format!("{other} is no type of its numbers"))),
        };
        let missing = || header(place.clone(), "it names a buffer view that is not there");
        let view = accessor.buffer_view.and_then(|v| self.document.views.get(v)).ok_or_else(missing)?;
        if view.buffer != 0 || self.document.buffers.first().is_none_or(|b| b.uri.is_some()) {
            return Err(unsupported(place, "it is not in the buffer of this file"));
        }
        let end = view.byte_offset.checked_add(view.byte_length);
        let bytes = end.and_then(|end| self.bin.get(view.byte_offset..end)).and_then(|b| b.get(accessor.byte_offset..));
        let (bytes, stride) = (bytes.unwrap_or_default(), view.byte_stride.unwrap_or(N * size));
        let needs = count.saturating_sub(1).saturating_mul(stride).saturating_add(N * size);
        if count > 0 && (stride < N * size || needs > bytes.len()) {
            return Err(SplatError::truncated(place, needs as u64, bytes.len() as u64));
        }
        let one = |i: usize| std::array::from_fn(|k| number(&bytes[i * stride + k * size..], accessor));
        Ok((0..count).map(one).collect())
    }
}

/// One number; the first bytes are there.
fn number(bytes: &[u8], accessor: &Accessor) -> f32 {
    let two = || [bytes[0], bytes[1]];
    let (value, most) = match accessor.component_type {
        BYTE => (f32::from(bytes[0].cast_signed()), 127.0),
        UNSIGNED_BYTE => (f32::from(bytes[0]), 255.0),
        SHORT => (f32::from(i16::from_le_bytes(two())), 32_767.0),
        UNSIGNED_SHORT => (f32::from(u16::from_le_bytes(two())), 65_535.0),
        _ => return f32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]),
    };
    if accessor.normalized { (value / most).max(-1.0) } else { value }
}
