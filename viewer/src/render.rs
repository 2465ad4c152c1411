//! The picture of a set of Gaussians.

use rayon::prelude::*;

use crate::beside::{Beside, Depths, Everything, Nothing};
use crate::blend::{Tile, at};
use crate::camera::View;
use crate::gaussians::{Gaussians, LengthError};
use crate::layers::{Layers, Next};
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
    if options.depth {
        let (rgba, depth) = draw::<Depths>(sets, view, options, None);
        Picture { width, height, rgba, depth }
    } else {
        Picture { width, height, rgba: draw::<Nothing>(sets, view, options, None).0, depth: Vec::new() }
    }
}

/// Draws all sets as [`render`] does, and all that is known about each pixel beside its colour; the flow to a next
/// moment, if there is one. Depths are made whatever the options say.
///
/// # Errors
/// The next moment is not one of these sets.
///
/// # Panics
/// A set for which [`Gaussians::check`] fails.
pub fn render_layers(
    sets: &[Gaussians<'_>],
    view: &View,
    options: &Options,
    next: Option<&Next<'_>>,
) -> Result<Layers, LengthError> {
    if let Some(next) = next {
        next.check(sets)?;
    }
    let (rgba, pixels) = draw::<Everything>(sets, view, options, next);
    Ok(Layers::new(view, rgba, &pixels, next.is_some()))
}

/// Colours, and what is gathered beside them.
fn draw<B: Beside>(
    sets: &[Gaussians<'_>],
    view: &View,
    options: &Options,
    next: Option<&Next<'_>>,
) -> (Vec<[f32; 4]>, Vec<B::Pixel>) {
    let (width, height) = (view.width, view.height);
    let (visible, features) = project::<B>(sets, view, options, next);
    let tiles = Tiles::new(&visible, &features, width, height);
    let mut rgba = vec![[0.0; 4]; width * height];
    let mut beside = vec![B::NOTHING; width * height];
    let band = width * TILE;
    let bands = rgba.par_chunks_mut(band).zip(beside.par_chunks_mut(band)).enumerate();
    bands.for_each(|(row, (rgba, beside))| draw_band::<B>(&tiles, row, width, options, rgba, beside));
    (rgba, beside)
}

/// One row of tiles.
fn draw_band<B: Beside>(
    tiles: &Tiles<B::Feature>,
    row: usize,
    width: usize,
    options: &Options,
    rgba: &mut [[f32; 4]],
    beside: &mut [B::Pixel],
) {
    let lines = rgba.len() / width;
    let [red, green, blue] = options.background;
    for column in 0..width.div_ceil(TILE) {
        let mut tile = Tile::<B>::new();
        let left = column * TILE;
        tile.add(tiles.of(column, row), tiles, left, row * TILE, options.kernel_floor as f32);
        for y in 0..lines {
            for x in 0..TILE.min(width - left) {
                let through = at(&tile.through, x, y);
                let place = y * width + left + x;
                rgba[place] = [
                    at(&tile.red, x, y) + through * red,
                    at(&tile.green, x, y) + through * green,
                    at(&tile.blue, x, y) + through * blue,
                    1.0 - through,
                ];
                beside[place] = tile.beside.pixel(x, y, through);
            }
        }
    }
}
