//! Splat files: one file or folder a format, one registry.

mod antimatter;
mod gltf;
mod half;
mod ksplat;
pub mod ply;
mod sog;
pub mod spz;
mod zip;

use std::fs;
use std::path::Path;

use crate::error::{Fault, SplatError};
use crate::splats::{Axes, Splats};

/// What was decoded, and what the user should know about it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Decoded {
    /// The Gaussians.
    pub splats: Splats,
    /// Remarks: what was left out or assumed. Comments of the file are among them.
    pub notes: Vec<String>,
}

/// A format: how it is recognised, read and written.
pub struct Format {
    /// Name for messages.
    pub name: &'static str,
    /// Endings of file names, without the first dot.
    pub endings: &'static [&'static str],
    /// Axes by convention; a writer turns the Gaussians to them where it knows how.
    pub axes: Axes,
    /// Whether the first bytes say that it is this format; never for formats without a header.
    pub recognise: fn(&[u8]) -> bool,
    /// The decoder; hostile bytes give an error, never a panic.
    pub read: fn(&[u8]) -> Result<Decoded, SplatError>,
    /// The encoder, if there is one.
    pub write: Option<fn(&Splats) -> Vec<u8>>,
}

/// Every known format, in the order in which they are asked.
pub const FORMATS: [Format; 7] =
    [ply::CHUNKED, ply::FORMAT, spz::FORMAT, gltf::FORMAT, sog::FORMAT, ksplat::FORMAT, antimatter::FORMAT];

/// Reads a splat file of any known format.
///
/// # Errors
/// The file cannot be read, is no known format, or is damaged.
pub fn read_file(path: &Path) -> Result<Decoded, SplatError> {
    let name = path.display().to_string();
    let bytes =
        fs::read(path).map_err(|error| io_error(&error, "check the path and its permissions").in_file(&name))?;
    read(&bytes, ending_of(path)).map_err(|error| error.in_file(&name))
}

/// Decodes bytes: the format is recognised from them, or taken from the ending of the file name.
///
/// # Errors
/// The bytes are no known format, or damaged.
pub fn read(bytes: &[u8], ending: Option<&str>) -> Result<Decoded, SplatError> {
    let format = of(bytes, ending)?;
    let decoded = (format.read)(bytes)?;
    debug_assert!(decoded.splats.is_consistent(), "the {} decoder made arrays of different lengths", format.name);
    Ok(decoded)
}

/// The format of a file: by its bytes, or by the ending of its name.
///
/// # Errors
/// Neither belongs to a known format.
pub fn of(bytes: &[u8], ending: Option<&str>) -> Result<&'static Format, SplatError> {
    let by_content = FORMATS.iter().find(|f| (f.recognise)(bytes));
    by_content.or_else(|| ending.and_then(by_ending)).ok_or_else(unknown)
}

/// The ending of a file name that says its format, without the first dot: `spz`, or `compressed.ply`.
pub fn ending_of(path: &Path) -> Option<&str> {
    let name = path.file_name()?.to_str()?;
    let endings = FORMATS.iter().flat_map(|f| f.endings);
    let known = endings.filter(|e| ends_with(name, e)).max_by_key(|e| e.len());
    // The longest known one counts; else whatever stands behind the last dot.
    known.and_then(|e| name.get(name.len() - e.len()..)).or_else(|| path.extension()?.to_str())
}

/// Whether a name ends with a dot and that ending.
fn ends_with(name: &str, ending: &str) -> bool {
    let at = name.len().checked_sub(ending.len() + 1);
    let tail = at.and_then(|at| name.get(at..));
    tail.is_some_and(|tail| tail.starts_with('.') && tail[1..].eq_ignore_ascii_case(ending))
}

/// Writes a splat file; the format follows from the ending, the axes from the format.
///
/// # Errors
/// No encoder has that ending, or the file cannot be written.
pub fn write_file(path: &Path, splats: &Splats) -> Result<(), SplatError> {
    let name = path.display().to_string();
    let bytes = encode(splats, ending_of(path)).map_err(|error| error.in_file(&name))?;
    let advice = "check that the folder exists and that there is room";
    fs::write(path, bytes).map_err(|error| io_error(&error, advice).in_file(&name))
}

/// Encodes Gaussians in the format of an ending, turned to the axes of that format.
///
/// # Errors
/// No encoder has that ending.
pub fn encode(splats: &Splats, ending: Option<&str>) -> Result<Vec<u8>, SplatError> {
    let found = ending.and_then(by_ending).and_then(|f| Some((f, f.write?)));
    let (format, write) = found.ok_or_else(|| {
        let written = endings(|f| f.write.is_some());
        let what = "no format that can be written has this ending";
        SplatError::new(Fault::Unsupported, "file name", what, format!("use one of {written}"))
    })?;
    if splats.axes == format.axes || splats.axes == Axes::Scene {
        Ok(write(splats))
    } else {
        Ok(write(&splats.clone().to_axes(format.axes)))
    }
}

/// How much a file may unpack to: `free + expansion · size` bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Limits {
    /// Bytes that any file may unpack to.
    pub free: u64,
    /// Further bytes for each byte of the file. Captures unpack to 1.5 to 10 times their size.
    pub expansion: u64,
}

impl Default for Limits {
    fn default() -> Limits {
        Limits { free: 32 << 20, expansion: 64 }
    }
}

impl Limits {
    /// Refuses what `packed` bytes cannot justify.
    fn check(self, unpacked: u64, packed: usize) -> Result<(), SplatError> {
        let allowed = self.free.saturating_add(self.expansion.saturating_mul(packed as u64));
        if unpacked <= allowed {
            return Ok(());
        }
        let what = format!("{packed} bytes would unpack to {unpacked}, more than the allowed {allowed}");
        Err(SplatError::new(Fault::TooLarge, "header", what, "if the file is trusted, convert it to `.ply` first"))
    }
}

fn by_ending(ending: &str) -> Option<&'static Format> {
    FORMATS.iter().find(|f| f.endings.iter().any(|e| e.eq_ignore_ascii_case(ending)))
}

fn io_error(error: &std::io::Error, advice: &str) -> SplatError {
    SplatError::new(Fault::Io, "whole file", error.to_string(), advice)
}

/// Endings of some formats, for messages.
fn endings(which: impl Fn(&Format) -> bool) -> String {
    let endings: Vec<String> =
        FORMATS.iter().filter(|f| which(f)).flat_map(|f| f.endings).map(|e| format!("`.{e}`")).collect();
    endings.join(", ")
}

fn unknown() -> SplatError {
    let what = "neither its first bytes nor its ending belong to a known splat format";
    SplatError::new(Fault::UnknownFormat, "first bytes", what, format!("known are {}", endings(|_| true)))
}
