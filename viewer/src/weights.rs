//! How much of each Gaussian is seen, and how much of that within a mask.

use rayon::prelude::*;

use crate::beside::{Beside, Origin};
use crate::blend::{GROUPS, LANES, Plane, Tile};
use crate::camera::View;
use crate::gaussians::{Gaussians, LengthError};
use crate::project::{Ellipse, project};
use crate::render::Options;
use crate::tiles::{TILE, Tiles};

const ZERO: Plane = [[0.0; LANES]; TILE * GROUPS];

/// What is seen of one Gaussian: sums of its weights αᵢ Tᵢ over pixels, those of its colour in a picture.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Seen {
    /// Over all pixels.
    pub all: f64,
    /// Over those of the mask.
    pub masked: f64,
}

/// Weights by Gaussian.
struct Weights {
    /// 1 for pixels of the picture, which may end inside a tile, and for those of the mask.
    inside: Plane,
    mask: Plane,
    /// Of each ellipse so far, front to back: whose it is.
    found: Vec<(Owner, Seen)>,
}

/// Set and place in it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Owner(u32, u32);

impl Beside for Weights {
    type Feature = Owner;
    type Pixel = ();
    const NOTHING: () = ();

    fn new() -> Weights {
        Weights { inside: ZERO, mask: ZERO, found: Vec::new() }
    }

    fn feature(origin: &Origin<'_>) -> Owner {
        Owner(origin.object, origin.index as u32)
    }

    fn add(&mut self, group: usize, weight: [f32; LANES], _: &Ellipse, owner: &Owner) {
        let sum = |plane: &Plane| -> f64 { weight.iter().zip(plane[group]).map(|(w, p)| f64::from(w * p)).sum() };
        let (all, masked) = (sum(&self.inside), sum(&self.mask));
        match self.found.last_mut() {
            Some((known, seen)) if known == owner => {
                seen.all += all;
                seen.masked += masked;
            }
            _ => self.found.push((*owner, Seen { all, masked })),
        }
    }

    fn pixel(&self, _: usize, _: usize, _: f32) {}
}

/// How much of each Gaussian is seen in a view, and how much of it within a mask, row by row from the top: what tells
/// which Gaussians a marked part of a picture is made of. In the order of the sets and of the Gaussians in them; the same
/// bits on any number of threads.
///
/// # Errors
/// The mask has another size than the picture.
///
/// # Panics
/// A set for which [`Gaussians::check`] fails.
pub fn weights(
    sets: &[Gaussians<'_>],
    view: &View,
    options: &Options,
    mask: &[bool],
) -> Result<Vec<Vec<Seen>>, LengthError> {
    let (width, height) = (view.width, view.height);
    if mask.len() != width * height {
        return Err(LengthError::new("mask, in pixels,", mask.len(), width * height, width * height));
    }
    let (visible, features) = project::<Weights>(sets, view, options, None);
    let tiles = Tiles::new(&visible, &features, width, height);
    let floor = options.kernel_floor as f32;
    let (across, down) = (width.div_ceil(TILE), height.div_ceil(TILE));
    let of_tile = |number: usize| {
        let (column, row) = (number % across, number / across);
        let (left, top) = (column * TILE, row * TILE);
        let mut tile = Tile::<Weights>::new();
        for (y, x) in (0..TILE.min(height - top)).flat_map(|y| (0..TILE.min(width - left)).map(move |x| (y, x))) {
            let (group, lane) = (y * GROUPS + x / LANES, x % LANES);
            tile.beside.inside[group][lane] = 1.0;
            tile.beside.mask[group][lane] = f32::from(u8::from(mask[(top + y) * width + left + x]));
        }
        tile.add(tiles.of(column, row), &tiles, left, top, floor);
        tile.beside.found
    };
    let found: Vec<Vec<(Owner, Seen)>> = (0..across * down).into_par_iter().map(of_tile).collect();
    let mut sums: Vec<Vec<Seen>> = sets.iter().map(|set| vec![Seen::default(); set.positions.len()]).collect();
    for (Owner(set, index), seen) in found.into_iter().flatten() {
        let sum = &mut sums[set as usize][index as usize];
        sum.all += seen.all;
        sum.masked += seen.masked;
    }
    Ok(sums)
}
