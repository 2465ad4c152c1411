//! The picture of a set of Gaussians.

use rayon::prelude::*;

use crate::blend::Tile;
use crate::camera::View;
use crate::gaussians::Gaussians;
use crate::picture::Picture;
use crate::project::project;
use crate::tiles::{TILE, Tiles};

/// How a picture is drawn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Options {
    /// Colour behind everything, in display values.
    pub background: [f32; 3],
    /// What is nearer along the optical axis is not drawn, in scene units.
    pub near: f64,
    /// Added to both variances of an ellipse, in pixels².
    pub dilation: f64,
    /// Subtracted from the kernel e^(−q/2) before it is multiplied by the opacity. Zero is the reference recipe; some
    /// renderers use e^−4.5 to end the kernel at three standard deviations.
    pub kernel_floor: f64,
    /// Whether the plane of expected depths is made.
    pub depth: bool,
}

impl Default for Options {
    fn default() -> Options {
        Options { background: [0.0; 3], near: 0.2, dilation: 0.3, kernel_floor: 0.0, depth: false }
    }
}

impl Options {
    /// With a background given in linear light, red, green, blue from 0 to 1, by the curve of sRGB (IEC 61966-2-1).
    #[must_use]
    pub fn with_linear_background(self, linear: [f64; 3]) -> Options {
        let display = |v: f64| {
            let v = v.clamp(0.0, 1.0);
            (if v <= 0.003_130_8 { 12.92 * v } else { 1.055 * v.powf(1.0 / 2.4) - 0.055 }) as f32
        };
        Options { background: linear.map(display), ..self }
    }
}

/// Draws all sets as one.
///
/// Colours are blended as they are, in display values, as 3D Gaussian splatting is trained. Every tile is worked on by
/// one thread in the order of depth, ties in the order of the Gaussians, so the picture does not depend on threads.
///
/// # Panics
/// A set for which [`Gaussians::check`] fails.
pub fn render(sets: &[Gaussians<'_>], view: &View, options: &Options) -> Picture {
    let (width, height) = (view.width, view.height);
    let visible = project(sets, view, options);
    let tiles = Tiles::new(&visible, width, height);
    let mut picture = Picture::new(width, height, options.depth);
    let band = width * TILE;
    if options.depth {
        let bands = picture.rgba.par_chunks_mut(band).zip(picture.depth.par_chunks_mut(band)).enumerate();
        bands.for_each(|(row, (rgba, depth))| draw_band::<true>(&tiles, row, width, options, rgba, depth));
    } else {
        let bands = picture.rgba.par_chunks_mut(band).enumerate();
        bands.for_each(|(row, rgba)| draw_band::<false>(&tiles, row, width, options, rgba, &mut []));
    }
    picture
}

/// One row of tiles.
fn draw_band<const DEPTH: bool>(
    tiles: &Tiles,
    row: usize,
    width: usize,
    options: &Options,
    rgba: &mut [[f32; 4]],
    depth: &mut [f32],
) {
    let lines = rgba.len() / width;
    let [red, green, blue] = options.background;
    for column in 0..width.div_ceil(TILE) {
        let mut tile = Tile::new();
        let left = column * TILE;
        tile.add::<DEPTH>(tiles.of(column, row), &tiles.ellipses, left, row * TILE, options.kernel_floor as f32);
        for y in 0..lines {
            for x in 0..TILE.min(width - left) {
                let through = Tile::at(&tile.through, x, y);
                let at = y * width + left + x;
                rgba[at] = [
                    Tile::at(&tile.red, x, y) + through * red,
                    Tile::at(&tile.green, x, y) + through * green,
                    Tile::at(&tile.blue, x, y) + through * blue,
                    1.0 - through,
                ];
                if DEPTH {
                    let hidden = 1.0 - through;
                    let sum = Tile::at(&tile.depth, x, y);
                    depth[at] = if hidden > 0.0 { sum / hidden } else { f32::INFINITY };
                }
            }
        }
    }
}
