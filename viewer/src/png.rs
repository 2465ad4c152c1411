//! PNG files: 8 bits, red, green, blue.

use std::fs::File;
use std::io::{BufRead, BufReader, BufWriter, Seek, Write};
use std::path::Path;

use thiserror::Error;

use crate::picture::Picture;
use crate::preview::PreviewError;

/// Bytes that a file may unpack to.
const LARGEST: usize = 1 << 30;

/// A PNG file that cannot be written or read.
#[derive(Debug, Error)]
pub enum PngError {
    /// It cannot be opened.
    #[error("{0}: {1}; check the path and its permissions")]
    Open(String, std::io::Error),
    /// It cannot be written.
    #[error("{0}: {1}; check that there is room")]
    Write(String, png::EncodingError),
    /// The pictures make no preview.
    #[error("{0}: {1}")]
    Preview(String, PreviewError),
    /// It is damaged or of a kind that is not read.
    #[error("{0}: {1}; only 8-bit PNG files in colour are read")]
    Read(String, png::DecodingError),
    /// It is grey, indexed or of 16 bits.
    #[error("{0}: is no 8-bit PNG file in colour; convert it")]
    Kind(String),
}

/// Writes a picture.
///
/// # Errors
/// The file cannot be written.
pub fn write(path: &Path, picture: &Picture) -> Result<(), PngError> {
    let name = || path.display().to_string();
    let file = File::create(path).map_err(|error| PngError::Open(name(), error))?;
    encode(BufWriter::new(file), picture).map_err(|error| PngError::Write(name(), error))
}

/// Encodes a picture.
///
/// # Errors
/// What the sink says.
pub fn encode(sink: impl Write, picture: &Picture) -> Result<(), png::EncodingError> {
    let mut encoder = png::Encoder::new(sink, picture.width as u32, picture.height as u32);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
    let mut writer = encoder.write_header()?;
    writer.write_image_data(&picture.to_srgb8())?;
    writer.finish()
}

/// Encodes numbers of 16 bits, one a pixel, or red, green and blue.
pub(crate) fn encode_words(size: [u32; 2], is_colour: bool, words: &[u16]) -> Result<Vec<u8>, png::EncodingError> {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, size[0], size[1]);
    encoder.set_color(if is_colour { png::ColorType::Rgb } else { png::ColorType::Grayscale });
    encoder.set_depth(png::BitDepth::Sixteen);
    let mut writer = encoder.write_header()?;
    let data: Vec<u8> = words.iter().flat_map(|w| w.to_be_bytes()).collect();
    writer.write_image_data(&data)?;
    writer.finish()?;
    Ok(bytes)
}

/// Reads a picture: width, height, and red, green, blue from 0 to 1. An opacity is dropped.
///
/// # Errors
/// The file cannot be read or is of another kind.
pub fn read(path: &Path) -> Result<(usize, usize, Vec<f32>), PngError> {
    let name = path.display().to_string();
    let file = File::open(path).map_err(|error| PngError::Open(name.clone(), error))?;
    decode(BufReader::new(file), &name)
}

/// Reads a mask of any kind of PNG: width, height, and which pixels are light, from half of white on in any channel, and
/// not transparent, row by row.
///
/// # Errors
/// The file cannot be read, or is damaged or too large.
pub fn read_mask(path: &Path) -> Result<(usize, usize, Vec<bool>), PngError> {
    let name = path.display().to_string();
    let file = File::open(path).map_err(|error| PngError::Open(name.clone(), error))?;
    let damaged = |error| PngError::Read(name.clone(), error);
    let mut decoder = png::Decoder::new_with_limits(BufReader::new(file), png::Limits { bytes: LARGEST });
    decoder.set_transformations(png::Transformations::normalize_to_color8());
    let mut reader = decoder.read_info().map_err(damaged)?;
    let size = reader.output_buffer_size().filter(|&n| n <= LARGEST).ok_or_else(|| PngError::Kind(name.clone()))?;
    let mut bytes = vec![0; size];
    let info = reader.next_frame(&mut bytes).map_err(damaged)?;
    let (channels, has_alpha) = match info.color_type {
        png::ColorType::Grayscale | png::ColorType::Indexed => (1, false),
        png::ColorType::GrayscaleAlpha => (2, true),
        png::ColorType::Rgb => (3, false),
        png::ColorType::Rgba => (4, true),
    };
    let is_light = |pixel: &[u8]| {
        let (colour, alpha) = pixel.split_at(channels - usize::from(has_alpha));
        colour.iter().any(|v| *v >= 128) && alpha.iter().all(|v| *v >= 128)
    };
    let pixels = bytes[..info.buffer_size()].chunks_exact(channels).map(is_light).collect();
    Ok((info.width as usize, info.height as usize, pixels))
}

fn decode(source: impl BufRead + Seek, name: &str) -> Result<(usize, usize, Vec<f32>), PngError> {
    let damaged = |error| PngError::Read(name.to_owned(), error);
    let kind = || PngError::Kind(name.to_owned());
    let mut decoder = png::Decoder::new_with_limits(source, png::Limits { bytes: LARGEST });
    decoder.set_transformations(png::Transformations::IDENTITY);
    let mut reader = decoder.read_info().map_err(damaged)?;
    let size = reader.output_buffer_size().filter(|&n| n <= LARGEST).ok_or_else(kind)?;
    let mut bytes = vec![0; size];
    let info = reader.next_frame(&mut bytes).map_err(damaged)?;
    let channels = match (info.color_type, info.bit_depth) {
        (png::ColorType::Rgb, png::BitDepth::Eight) => 3,
        (png::ColorType::Rgba, png::BitDepth::Eight) => 4,
        _ => return Err(kind()),
    };
    let unit = |&b: &u8| f32::from(b) / 255.0;
    let values =
        bytes[..info.buffer_size()].chunks(channels).flat_map(|pixel| pixel.iter().take(3).map(unit)).collect();
    Ok((info.width as usize, info.height as usize, values))
}
