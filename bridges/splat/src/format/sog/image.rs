//! A lossless WebP picture.

use std::io::Cursor;

use image_webp::WebPDecoder;

use crate::error::{Fault, SplatError};

/// Red, green, blue, alpha; alpha is 255 where the file has none.
pub(super) type Pixel = [u8; 4];

/// Unpacked.
pub(super) struct Image {
    width: usize,
    channels: usize,
    bytes: Vec<u8>,
}

impl Image {
    /// Decodes a picture of at most that many pixels.
    pub(super) fn decode(bytes: &[u8], most: usize, name: &str) -> Result<Image, SplatError> {
        let damaged = |what: String| SplatError::new(Fault::Compression, name, what, "copy or download the file again");
        let mut decoder = WebPDecoder::new(Cursor::new(bytes)).map_err(|error| damaged(error.to_string()))?;
        let (width, height) = decoder.dimensions();
        let pixels = u64::from(width) * u64::from(height);
        if pixels > most as u64 {
            let what = format!("a picture of {width} x {height} pixels is larger than the Gaussians need");
            return Err(SplatError::new(
                Fault::TooLarge,
                name,
                what,
                "write the file again with the tool it came from",
            ));
        }
        let size = decoder.output_buffer_size().ok_or_else(|| damaged("its size overflows".to_owned()))?;
        let channels = if decoder.has_alpha() { 4 } else { 3 };
        let mut out = vec![0; size];
        decoder.read_image(&mut out).map_err(|error| damaged(error.to_string()))?;
        Ok(Image { width: width as usize, channels, bytes: out })
    }

    pub(super) fn width(&self) -> usize {
        self.width
    }

    pub(super) fn pixels(&self) -> usize {
        self.bytes.len() / self.channels
    }

    /// A pixel, row by row; it must be there.
    pub(super) fn at(&self, index: usize) -> Pixel {
        let start = index * self.channels;
        match self.bytes[start..start + self.channels] {
            [r, g, b, a] => [r, g, b, a],
            [r, g, b] => [r, g, b, 255],
            _ => [0; 4],
        }
    }
}
