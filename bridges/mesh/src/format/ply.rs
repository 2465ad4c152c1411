//! PLY meshes, as text or binary in either order of bytes: elements `vertex` and `face`.
//!
//! Rows are decoded by `serde-ply`; how many there can be is checked here before.

use std::cell::Cell;
use std::fmt;
use std::io::{BufRead, ErrorKind, Read};
use std::marker::PhantomData;

use cosplat_core::asset::TriangleMesh;
use serde::Deserialize;
use serde::de::{DeserializeSeed, Deserializer, MapAccess, SeqAccess, Visitor};
use serde_ply::{ElementDef, PlyFormat, PlyReader, PropertyType, ScalarType};

use super::polygons::{Cutter, Wrong};
use super::{Beside, Decoded, Format, linear_of_display};
use crate::error::{Fault, MeshError};

/// The registry entry.
pub(super) const FORMAT: Format =
    Format { name: "ply", endings: &["ply"], up: None, recognise: |bytes| bytes.starts_with(b"ply"), read };

const AGAIN: &str = "copy or download the file again";
const EXPORT: &str = "export the mesh again, as binary PLY";

#[derive(Deserialize)]
struct Vertex {
    x: f64,
    y: f64,
    z: f64,
    /// Display values: whole numbers to 255, or parts of one.
    #[serde(default)]
    red: Option<f64>,
    #[serde(default)]
    green: Option<f64>,
    #[serde(default)]
    blue: Option<f64>,
}

/// A row of an element that says nothing about the shape.
#[derive(Deserialize)]
struct Other {}

#[derive(Deserialize)]
struct Face {
    #[serde(alias = "vertex_index")]
    vertex_indices: Vec<u32>,
}

fn read(bytes: &[u8], _: Beside<'_>) -> Result<Decoded, MeshError> {
    let header_fault = |what: String| MeshError::new(Fault::Header, "header", what, EXPORT);
    let open = |tail| PlyReader::from_reader(bytes.chain(tail)).map_err(|error| header_fault(error.0.to_string()));
    let mut reader = open(&b""[..])?;
    let header = reader.header();
    check_header(header.format, &header.elem_defs, bytes.len() as u64)?;
    let largest = colour_scale(&header.elem_defs);
    let names: Vec<String> = header.elem_defs.iter().map(|element| element.name.clone()).collect();
    if header.format == PlyFormat::Ascii {
        // The reader wants a space behind the last number; files end without.
        reader = open(b"\n")?;
    }
    if let Some(name) = ["vertex", "face"].iter().find(|name| !names.iter().any(|known| known == *name)) {
        let what = format!("there is no element `{name}`");
        let advice = "give a mesh; a cloud of points or Gaussians has no surface (`splat = ...` takes Gaussians)";
        return Err(MeshError::new(Fault::Header, "header", what, advice));
    }
    // Faces may stand before the vertices they name.
    let (mut mesh, mut corners, mut ends) = (TriangleMesh::default(), Vec::new(), Vec::new());
    let mut colours = Vec::new();
    for name in &names {
        match name.as_str() {
            "vertex" => rows(&mut reader, name, |v: Vertex| {
                let finite = [v.x, v.y, v.z].iter().all(|x| x.is_finite());
                mesh.vertices_m.push([v.x, v.y, v.z]);
                if let (Some(red), Some(green), Some(blue)) = (v.red, v.green, v.blue) {
                    colours.push([red, green, blue].map(|c| linear_of_display((c / largest) as f32)));
                }
                if finite { Ok(()) } else { Err(format!("its position is {}, {}, {}", v.x, v.y, v.z)) }
            })?,
            "face" => rows(&mut reader, name, |f: Face| {
                corners.extend(f.vertex_indices);
                ends.push(corners.len());
                Ok(())
            })?,
            _ => rows(&mut reader, name, |_: Other| Ok(()))?,
        }
    }
    let (count, mut cutter, mut start) = (mesh.vertices_m.len(), Cutter::new(), 0);
    for (number, end) in ends.into_iter().enumerate() {
        let wrong =
            |(fault, what, advice): Wrong| MeshError::new(fault, format!("row {} of `face`", number + 1), what, advice);
        let face = &corners[start..end];
        if let Some(wild) = face.iter().find(|i| **i as usize >= count) {
            return Err(wrong((Fault::Index, format!("vertex {wild} of {count} is named"), "number vertices from 0")));
        }
        cutter.add(&mut mesh, face).map_err(wrong)?;
        start = end;
    }
    Ok(Decoded { mesh, colours, notes: Vec::new() })
}

/// The number that stands for a full colour: one where they are stored as fractions.
fn colour_scale(elements: &[ElementDef]) -> f64 {
    let red = elements.iter().filter(|e| e.name == "vertex").flat_map(|e| &e.properties).find(|p| p.name == "red");
    match red.map(|p| p.property_type.clone()) {
        Some(PropertyType::Scalar(ScalarType::F32 | ScalarType::F64)) => 1.0,
        Some(PropertyType::Scalar(ScalarType::I16 | ScalarType::U16)) => 65_535.0,
        _ => 255.0,
    }
}

/// Refuses what the bytes cannot hold. Without it, rows without columns would be counted to the end of time.
fn check_header(format: PlyFormat, elements: &[ElementDef], length: u64) -> Result<(), MeshError> {
    let smallest = |kind: ScalarType| match kind {
        // A digit and what separates it from the next number.
        _ if format == PlyFormat::Ascii => 2,
        ScalarType::I8 | ScalarType::U8 => 1,
        ScalarType::I16 | ScalarType::U16 => 2,
        ScalarType::I32 | ScalarType::U32 | ScalarType::F32 => 4,
        ScalarType::F64 => 8,
    };
    let mut needs = 0_u128;
    for element in elements {
        let row: u128 = element
            .properties
            .iter()
            .map(|property| match property.property_type {
                PropertyType::Scalar(kind) | PropertyType::List { count_type: kind, .. } => smallest(kind),
            })
            .sum();
        if row == 0 && element.count > 0 {
            let what = format!("element `{}` has rows and no properties", element.name);
            return Err(MeshError::new(Fault::Header, "header", what, EXPORT));
        }
        needs += row * element.count as u128;
    }
    // The last number of a text needs no space behind it.
    if needs > u128::from(length) + 1 {
        let what = format!("{needs} bytes are promised at least and the whole file has {length}");
        return Err(MeshError::new(Fault::Truncated, "header", what, AGAIN));
    }
    Ok(())
}

/// Reads the next element row by row, so that a fault has its row.
fn rows<'a, T: Deserialize<'a>>(
    mut reader: &mut PlyReader<impl BufRead>,
    name: &str,
    each: impl FnMut(T) -> Result<(), String>,
) -> Result<(), MeshError> {
    let done = Cell::new(0);
    reader.next_value_seed(Rows { each, done: &done, row: PhantomData }).map_err(|error| {
        let place = format!("row {} of `{name}`", done.get() + 1);
        if error.0.kind() == ErrorKind::UnexpectedEof {
            return MeshError::new(Fault::Truncated, place, "the file ends here", AGAIN);
        }
        MeshError::new(Fault::Value, place, error.0.to_string(), EXPORT)
    })
}

/// Gives each row of an element away, and counts them.
struct Rows<'a, F, T> {
    each: F,
    done: &'a Cell<usize>,
    row: PhantomData<T>,
}

impl<'de, F: FnMut(T) -> Result<(), String>, T: Deserialize<'de>> DeserializeSeed<'de> for Rows<'_, F, T> {
    type Value = ();

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<(), D::Error> {
        deserializer.deserialize_seq(self)
    }
}

impl<'de, F: FnMut(T) -> Result<(), String>, T: Deserialize<'de>> Visitor<'de> for Rows<'_, F, T> {
    type Value = ();

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("rows")
    }

    fn visit_seq<A: SeqAccess<'de>>(mut self, mut rows: A) -> Result<(), A::Error> {
        while let Some(row) = rows.next_element()? {
            (self.each)(row).map_err(serde::de::Error::custom)?;
            self.done.set(self.done.get() + 1);
        }
        Ok(())
    }
}
