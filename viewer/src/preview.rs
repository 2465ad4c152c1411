//! Animated previews: APNG files made of the pictures of a run.
//!
//! An APNG is a PNG that browsers play and that everything else shows as its first frame. Pictures are shrunk, and each
//! frame holds only the rectangle that changed, with a transparent pixel where nothing did, so that a still scene costs
//! nothing. The same pictures give the same bytes.

use std::fs::File;
use std::io::Write as _;
use std::path::Path;

use png::{BitDepth, BlendOp, ColorType, Encoder, EncodingError, SrgbRenderingIntent};
use thiserror::Error;

use crate::picture::Picture;
use crate::png::PngError;

/// Bounds of a preview.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PreviewOptions {
    /// Pictures per second of playing.
    pub pictures_per_second: u16,
    /// Largest width and height of a frame \[px\]; pictures are shrunk by the smallest whole number that reaches it.
    pub largest_px: usize,
    /// Frames that are kept at most; when more come, every second one is dropped and the others are shown twice as
    /// long.
    pub frames: usize,
    /// Largest size of the file \[byte\], reached by dropping frames in the same way; at least one frame is written.
    pub bytes: usize,
    /// How often the preview is played; 0 is without end.
    pub plays: u32,
}

impl Default for PreviewOptions {
    fn default() -> PreviewOptions {
        PreviewOptions { pictures_per_second: 25, largest_px: 480, frames: 150, bytes: 6 << 20, plays: 0 }
    }
}

/// Pictures that make no preview.
#[derive(Debug, Error)]
pub enum PreviewError {
    /// Pictures of different sizes.
    #[error("a picture of {0} x {1} pixels cannot follow pictures of {2} x {3}; draw all with the same camera size")]
    Size(usize, usize, usize, usize),
    /// Nothing to show.
    #[error("a preview needs at least one picture")]
    Empty,
    /// What the encoder says.
    #[error(transparent)]
    Encoding(#[from] EncodingError),
}

/// Gathers the pictures of a run in bounded memory and writes them as one file.
#[derive(Clone, Debug)]
pub struct Preview {
    options: PreviewOptions,
    /// Size of the pictures, and the frame's pixel in pixels of a picture.
    size: Option<(usize, usize, usize)>,
    /// Pictures given so far.
    given: usize,
    /// Pictures per kept frame.
    stride: usize,
    /// Red, green, blue.
    frames: Vec<Vec<u8>>,
}

impl Preview {
    /// Begins with nothing.
    pub fn new(options: PreviewOptions) -> Preview {
        Preview { options, size: None, given: 0, stride: 1, frames: Vec::new() }
    }

    /// Takes the next picture.
    ///
    /// # Errors
    /// It has another size than those before it.
    pub fn push(&mut self, picture: &Picture) -> Result<(), PreviewError> {
        let (width, height) = (picture.width, picture.height);
        let reduce = width.max(height).div_ceil(self.options.largest_px.max(1)).max(1);
        let size = *self.size.get_or_insert((width, height, reduce));
        if (size.0, size.1) != (width, height) {
            return Err(PreviewError::Size(width, height, size.0, size.1));
        }
        if self.given.is_multiple_of(self.stride) {
            if self.frames.len() >= self.options.frames.max(1) {
                thin(&mut self.frames);
                self.stride *= 2;
            }
            // After thinning this picture may lie between two kept ones.
            if self.given.is_multiple_of(self.stride) {
                self.frames.push(shrink(picture, reduce));
            }
        }
        self.given += 1;
        Ok(())
    }

    /// Frames that are kept now.
    pub fn frames(&self) -> usize {
        self.frames.len()
    }

    /// The file as bytes.
    ///
    /// # Errors
    /// There is no picture, or what the encoder says.
    pub fn encode(&self) -> Result<Vec<u8>, PreviewError> {
        let (width, height, reduce) = self.size.ok_or(PreviewError::Empty)?;
        let size = (width.div_ceil(reduce), height.div_ceil(reduce));
        let (mut frames, mut stride) = (self.frames.clone(), self.stride);
        loop {
            let bytes = encode(&frames, size, stride, &self.options)?;
            if bytes.len() <= self.options.bytes || frames.len() < 2 {
                return Ok(bytes);
            }
            thin(&mut frames);
            stride *= 2;
        }
    }

    /// Writes the file.
    ///
    /// # Errors
    /// There is no picture, or the file cannot be written.
    pub fn write(&self, path: &Path) -> Result<(), PngError> {
        let name = || path.display().to_string();
        let bytes = self.encode().map_err(|error| PngError::Preview(name(), error))?;
        let mut file = File::create(path).map_err(|error| PngError::Open(name(), error))?;
        file.write_all(&bytes).map_err(|error| PngError::Write(name(), error.into()))
    }
}

/// Keeps the first frame and every second one after it.
fn thin(frames: &mut Vec<Vec<u8>>) {
    let mut keep = false;
    frames.retain(|_| {
        keep = !keep;
        keep
    });
}

/// Mean of squares of `reduce` × `reduce` pixels, in display values.
fn shrink(picture: &Picture, reduce: usize) -> Vec<u8> {
    let bytes = picture.to_srgb8();
    if reduce == 1 {
        return bytes;
    }
    let (width, height) = (picture.width, picture.height);
    let mut small = Vec::with_capacity(width.div_ceil(reduce) * height.div_ceil(reduce) * 3);
    for top in (0..height).step_by(reduce) {
        for left in (0..width).step_by(reduce) {
            // Squares at the right and lower edge may be cut.
            let (right, bottom) = (width.min(left + reduce), height.min(top + reduce));
            let count = (right - left) * (bottom - top);
            for channel in 0..3 {
                let value = |x: usize, y: usize| usize::from(bytes[(y * width + x) * 3 + channel]);
                let sum: usize = (top..bottom).flat_map(|y| (left..right).map(move |x| value(x, y))).sum();
                small.push(((sum + count / 2) / count) as u8);
            }
        }
    }
    small
}

fn encode(
    frames: &[Vec<u8>],
    size: (usize, usize),
    stride: usize,
    options: &PreviewOptions,
) -> Result<Vec<u8>, EncodingError> {
    let mut bytes = Vec::new();
    let mut encoder = Encoder::new(&mut bytes, size.0 as u32, size.1 as u32);
    encoder.set_color(ColorType::Rgba);
    encoder.set_depth(BitDepth::Eight);
    encoder.set_source_srgb(SrgbRenderingIntent::Perceptual);
    encoder.set_animated(frames.len() as u32, options.plays)?;
    let delay = stride.min(usize::from(u16::MAX)) as u16;
    encoder.set_frame_delay(delay, options.pictures_per_second.max(1))?;
    let mut writer = encoder.write_header()?;
    for (i, frame) in frames.iter().enumerate() {
        let Some(before) = i.checked_sub(1).map(|i| &frames[i]) else {
            writer.write_image_data(&opaque(frame))?;
            continue;
        };
        let area = changed(before, frame, size.0);
        writer.set_frame_position(0, 0)?;
        writer.set_frame_dimension(area.width as u32, area.height as u32)?;
        writer.set_frame_position(area.left as u32, area.top as u32)?;
        writer.set_blend_op(BlendOp::Over)?;
        writer.write_image_data(&difference(before, frame, size.0, &area))?;
    }
    writer.finish()?;
    Ok(bytes)
}

fn opaque(frame: &[u8]) -> Vec<u8> {
    frame.chunks_exact(3).flat_map(|p| [p[0], p[1], p[2], 255]).collect()
}

/// A rectangle of pixels.
struct Area {
    left: usize,
    top: usize,
    width: usize,
    height: usize,
}

/// The smallest rectangle that holds every pixel that changed; one pixel where none did, as a frame cannot be empty.
fn changed(before: &[u8], now: &[u8], width: usize) -> Area {
    let pixels = before.chunks_exact(3).zip(now.chunks_exact(3)).enumerate();
    let mut bounds: Option<[usize; 4]> = None;
    for (at, _) in pixels.filter(|(_, (a, b))| a != b) {
        let (x, y) = (at % width, at / width);
        let [left, top, right, bottom] = bounds.unwrap_or([x, y, x, y]);
        bounds = Some([left.min(x), top.min(y), right.max(x), bottom.max(y)]);
    }
    let [left, top, right, bottom] = bounds.unwrap_or_default();
    Area { left, top, width: right - left + 1, height: bottom - top + 1 }
}

/// The pixels of a rectangle, transparent where nothing changed.
fn difference(before: &[u8], now: &[u8], width: usize, area: &Area) -> Vec<u8> {
    let mut out = Vec::with_capacity(area.width * area.height * 4);
    for y in area.top..area.top + area.height {
        for x in area.left..area.left + area.width {
            let at = (y * width + x) * 3;
            let (old, new) = (&before[at..at + 3], &now[at..at + 3]);
            let pixel = if old == new { [0; 4] } else { [new[0], new[1], new[2], 255] };
            out.extend_from_slice(&pixel);
        }
    }
    out
}
