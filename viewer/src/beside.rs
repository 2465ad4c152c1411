//! What a tile gathers beside its colours: nothing, depths, or all by-products.

use crate::blend::{GROUPS, LANES, Plane, at};
use crate::camera::View;
use crate::gaussians::Gaussians;
use crate::layers::{NO_OBJECT, Pixel};
use crate::project::{Ellipse, in_picture, rotation};
use crate::tiles::TILE;

const ZERO: Plane = [[0.0; LANES]; TILE * GROUPS];

/// A Gaussian of one of the sets.
pub(crate) struct Origin<'a> {
    /// Place of its set.
    pub(crate) object: u32,
    pub(crate) set: &'a Gaussians<'a>,
    /// Place in its set.
    pub(crate) index: usize,
    pub(crate) view: &'a View,
    /// Where its set is at the next moment, and from where it is seen then.
    pub(crate) next: Option<(&'a [[f32; 3]], &'a View)>,
    /// Nearest distance along the optical axis that is drawn.
    pub(crate) near: f64,
}

/// Sums over the ellipses of a tile, with the weights of their colours.
pub(crate) trait Beside {
    /// What must be known of each Gaussian.
    type Feature: Copy + Default + Send + Sync;
    /// What comes out for each pixel.
    type Pixel: Copy + Send;
    /// Of a pixel in which nothing is seen.
    const NOTHING: Self::Pixel;

    /// Nothing yet.
    fn new() -> Self;
    /// What must be known of a Gaussian.
    fn feature(origin: &Origin<'_>) -> Self::Feature;
    /// Adds an ellipse to a group of pixels.
    fn add(&mut self, group: usize, weight: [f32; LANES], ellipse: &Ellipse, feature: &Self::Feature);
    /// The result of a pixel, through which so much still comes.
    fn pixel(&self, column: usize, row: usize, through: f32) -> Self::Pixel;
}

/// Colours alone.
pub(crate) struct Nothing;

impl Beside for Nothing {
    type Feature = ();
    type Pixel = ();
    const NOTHING: () = ();

    fn new() -> Nothing {
        Nothing
    }

    fn feature(_: &Origin<'_>) {}

    fn add(&mut self, _: usize, _: [f32; LANES], _: &Ellipse, (): &()) {}

    fn pixel(&self, _: usize, _: usize, _: f32) {}
}

/// Expected depths.
pub(crate) struct Depths(Plane);

impl Beside for Depths {
    type Feature = ();
    type Pixel = f32;
    const NOTHING: f32 = f32::INFINITY;

    fn new() -> Depths {
        Depths(ZERO)
    }

    fn feature(_: &Origin<'_>) {}

    #[inline]
    fn add(&mut self, group: usize, weight: [f32; LANES], ellipse: &Ellipse, (): &()) {
        add(&mut self.0[group], weight, ellipse.depth);
    }

    fn pixel(&self, column: usize, row: usize, through: f32) -> f32 {
        let hidden = 1.0 - through;
        if hidden > 0.0 { at(&self.0, column, row) / hidden } else { f32::INFINITY }
    }
}

/// All by-products of one Gaussian.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Feature {
    /// Shortest axis, turned to the camera.
    normal: [f32; 3],
    /// Motion of the projected centre \[pixels\], and 1 where there is one.
    motion: [f32; 3],
    object: u32,
}

/// All by-products.
pub(crate) struct Everything {
    depth: Plane,
    normal: [Plane; 3],
    motion: [Plane; 3],
    /// Largest weight so far, and whose it is.
    most: Plane,
    object: [[u32; LANES]; TILE * GROUPS],
}

impl Beside for Everything {
    type Feature = Feature;
    type Pixel = Pixel;
    const NOTHING: Pixel = Pixel::NOTHING;

    fn new() -> Everything {
        let object = [[NO_OBJECT; LANES]; TILE * GROUPS];
        Everything { depth: ZERO, normal: [ZERO; 3], motion: [ZERO; 3], most: ZERO, object }
    }

    fn feature(origin: &Origin<'_>) -> Feature {
        Feature { normal: normal(origin), motion: motion(origin), object: origin.object }
    }

    #[inline]
    fn add(&mut self, group: usize, weight: [f32; LANES], ellipse: &Ellipse, feature: &Feature) {
        add(&mut self.depth[group], weight, ellipse.depth);
        for (plane, value) in self.normal.iter_mut().zip(feature.normal) {
            add(&mut plane[group], weight, value);
        }
        for (plane, value) in self.motion.iter_mut().zip(feature.motion) {
            add(&mut plane[group], weight, value);
        }
        let (most, object) = (&mut self.most[group], &mut self.object[group]);
        for k in 0..LANES {
            let is_more = weight[k] > most[k];
            object[k] = if is_more { feature.object } else { object[k] };
            most[k] = if is_more { weight[k] } else { most[k] };
        }
    }

    fn pixel(&self, column: usize, row: usize, through: f32) -> Pixel {
        let sum = |plane: &Plane| at(plane, column, row);
        let object = self.object[row * GROUPS + column / LANES][column % LANES];
        let (normal, motion) = (self.normal.each_ref().map(sum), self.motion.each_ref().map(sum));
        Pixel::of_sums(1.0 - through, sum(&self.depth), normal, object, motion)
    }
}

/// Σ weight · value.
#[inline]
fn add(sums: &mut [f32; LANES], weight: [f32; LANES], value: f32) {
    for (sum, w) in sums.iter_mut().zip(weight) {
        *sum += w * value;
    }
}

/// The shortest axis of a Gaussian, on the side that the camera sees.
fn normal(origin: &Origin<'_>) -> [f32; 3] {
    let Origin { set, index, view, .. } = *origin;
    let scales = set.log_scales[index];
    let shortest = (1..3).fold(0, |least, k| if scales[k] < scales[least] { k } else { least });
    let turn = rotation(set.rotations[index]);
    let axis = [0, 1, 2].map(|k| turn[k][shortest]);
    let from_camera = [0, 1, 2].map(|k| f64::from(set.positions[index][k]) - view.eye[k]);
    let away: f64 = axis.iter().zip(from_camera).map(|(a, d)| a * d).sum();
    axis.map(|a| if away > 0.0 { -a } else { a } as f32)
}

/// How far the projected centre moves until the next moment, right and down \[pixels\], and whether it does.
fn motion(origin: &Origin<'_>) -> [f32; 3] {
    let Some((positions, next_view)) = origin.next else { return [0.0; 3] };
    let now = origin.view.in_camera(origin.set.positions[origin.index]);
    let next = next_view.in_camera(positions[origin.index]);
    let ([x, y], [next_x, next_y]) = (in_picture(origin.view, now), in_picture(next_view, next));
    let (along, down) = ((next_x - x) as f32, (next_y - y) as f32);
    if next[2] > origin.near && along.is_finite() && down.is_finite() { [along, down, 1.0] } else { [0.0; 3] }
}
