//! The text before the rows.

use crate::error::{Fault, SplatError};

/// No header of a splat file comes near this many bytes.
const LONGEST: usize = 1 << 20;

/// How numbers are written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Encoding {
    /// Decimal text.
    Ascii,
    /// Binary, least significant byte first.
    Little,
    /// Binary, most significant byte first.
    Big,
}

/// Type of a number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    F16,
    F32,
    F64,
}

impl Kind {
    fn parse(name: &str) -> Option<Kind> {
        Some(match name {
            "char" | "int8" => Kind::I8,
            "uchar" | "uint8" => Kind::U8,
            "short" | "int16" => Kind::I16,
            "ushort" | "uint16" => Kind::U16,
            "int" | "int32" => Kind::I32,
            "uint" | "uint32" => Kind::U32,
            "half" | "float16" => Kind::F16,
            "float" | "float32" => Kind::F32,
            "double" | "float64" => Kind::F64,
            _ => return None,
        })
    }

    /// Name to write. Half precision is written as single: nobody reads it.
    pub(super) fn name(self) -> &'static str {
        match self {
            Kind::I8 => "char",
            Kind::U8 => "uchar",
            Kind::I16 => "short",
            Kind::U16 => "ushort",
            Kind::I32 => "int",
            Kind::U32 => "uint",
            Kind::F16 | Kind::F32 => "float",
            Kind::F64 => "double",
        }
    }

    /// Bytes of one number.
    pub(super) fn size(self) -> usize {
        match self {
            Kind::I8 | Kind::U8 => 1,
            Kind::I16 | Kind::U16 | Kind::F16 => 2,
            Kind::I32 | Kind::U32 | Kind::F32 => 4,
            Kind::F64 => 8,
        }
    }
}

/// A named column; a list has the type of its counts too.
#[derive(Clone, Debug)]
pub(super) struct Property {
    pub(super) name: String,
    pub(super) kind: Kind,
    pub(super) list: Option<Kind>,
}

/// A table.
#[derive(Clone, Debug)]
pub(super) struct Element {
    pub(super) name: String,
    pub(super) count: u64,
    pub(super) properties: Vec<Property>,
}

impl Element {
    /// Bytes of one binary row, if all rows have the same.
    pub(super) fn stride(&self) -> Option<usize> {
        self.properties
            .iter()
            .try_fold(0_usize, |sum, p| if p.list.is_some() { None } else { Some(sum + p.kind.size()) })
    }
}

/// What the header says.
#[derive(Clone, Debug)]
pub(super) struct Header {
    pub(super) encoding: Encoding,
    pub(super) elements: Vec<Element>,
    pub(super) comments: Vec<String>,
    /// Byte at which the rows begin.
    pub(super) body: usize,
}

fn fault(line: usize, what: impl Into<String>) -> SplatError {
    let advice = "write the file again with the tool it came from, or convert it to an INRIA `.ply`";
    SplatError::new(Fault::Header, format!("header line {line}"), what, advice)
}

/// Parses the header.
pub(super) fn parse(bytes: &[u8]) -> Result<Header, SplatError> {
    let mut encoding = None;
    let mut elements: Vec<Element> = Vec::new();
    let mut comments = Vec::new();
    let mut at = 0;
    for number in 1.. {
        let window = &bytes[at..bytes.len().min(LONGEST)];
        let Some(length) = window.iter().position(|&b| b == b'\n') else {
            return Err(fault(number, "there is no `end_header`"));
        };
        let Ok(line) = str::from_utf8(&window[..length]) else {
            return Err(fault(number, "the header is not text"));
        };
        at += length + 1;
        let words: Vec<&str> = line.split_ascii_whitespace().collect();
        match words[..] {
            ["ply"] if number == 1 => {}
            _ if number == 1 => return Err(fault(1, "the first line is not `ply`")),
            [] => {}
            ["format", name, "1.0"] => encoding = Some(parse_encoding(name, number)?),
            ["comment" | "obj_info", ..] => comments.push(words[1..].join(" ")),
            ["element", name, count] => elements.push(parse_element(name, count, number)?),
            ["property", ref rest @ ..] => {
                let Some(element) = elements.last_mut() else {
                    return Err(fault(number, "a property stands before any element"));
                };
                let property = parse_property(rest, number)?;
                if element.properties.iter().any(|p| p.name == property.name) {
                    return Err(fault(number, format!("property `{}` is there twice", property.name)));
                }
                element.properties.push(property);
            }
            ["end_header"] => {
                let encoding = encoding.ok_or_else(|| fault(number, "there is no `format` line"))?;
                return Ok(Header { encoding, elements, comments, body: at });
            }
            _ => return Err(fault(number, format!("`{}` is not a line of a PLY 1.0 header", line.trim_end()))),
        }
    }
    Err(fault(0, "there is no `end_header`"))
}

fn parse_encoding(name: &str, line: usize) -> Result<Encoding, SplatError> {
    match name {
        "ascii" => Ok(Encoding::Ascii),
        "binary_little_endian" => Ok(Encoding::Little),
        "binary_big_endian" => Ok(Encoding::Big),
        _ => Err(fault(line, format!("`{name}` is not an encoding of PLY"))),
    }
}

fn parse_element(name: &str, count: &str, line: usize) -> Result<Element, SplatError> {
    let Ok(count) = count.parse() else {
        return Err(fault(line, format!("`{count}` is not a number of rows")));
    };
    Ok(Element { name: name.to_owned(), count, properties: Vec::new() })
}

fn parse_property(words: &[&str], line: usize) -> Result<Property, SplatError> {
    let kind = |name: &str| Kind::parse(name).ok_or_else(|| fault(line, format!("`{name}` is not a type of PLY")));
    match *words {
        ["list", count, item, name] => {
            Ok(Property { name: name.to_owned(), kind: kind(item)?, list: Some(kind(count)?) })
        }
        [item, name] => Ok(Property { name: name.to_owned(), kind: kind(item)?, list: None }),
        _ => Err(fault(line, "a property needs a type and a name")),
    }
}
