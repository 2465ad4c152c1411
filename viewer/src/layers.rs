//! What is known about each pixel beside its colour.

use crate::camera::View;
use crate::gaussians::{Gaussians, LengthError};
use crate::picture::Picture;

/// Object of a pixel in which nothing is seen.
pub const NO_OBJECT: u32 = u32::MAX;

/// A picture and its by-products, row by row from the top.
///
/// Each of them is made with the weights w = αᵢ Tᵢ that the colours of the Gaussians have in the same pixel.
#[derive(Clone, Debug, PartialEq)]
pub struct Layers {
    /// Colours, opacity and expected depth.
    pub picture: Picture,
    /// Σ w n made of length one, in the axes of the scene; zero where nothing is seen. The normal n of a Gaussian is its
    /// shortest axis, turned to the camera; of a round one it is arbitrary.
    pub normal: Vec<[f32; 3]>,
    /// Place in the sets of the one whose Gaussian has the largest weight, or [`NO_OBJECT`]. Haze counts too: who wants a
    /// hard edge looks at the opacity as well.
    pub object: Vec<u32>,
    /// Σ w (m′ − m) / Σ w in pixels, right and down, with m and m′ the projected centres now and at the next moment; NaN
    /// where nothing is seen that is in front of the next camera. Empty without a next moment.
    pub flow: Vec<[f32; 2]>,
}

/// Where the same Gaussians are at the next moment, and from where they are seen then.
#[derive(Clone, Debug)]
pub struct Next<'a> {
    /// Centres, a slice for each set and in its order.
    pub positions: Vec<&'a [[f32; 3]]>,
    /// The view at the next moment.
    pub view: View,
}

impl Next<'_> {
    /// Whether there is a next place for every Gaussian.
    ///
    /// # Errors
    /// The first set for which there are more or fewer.
    pub fn check(&self, sets: &[Gaussians<'_>]) -> Result<(), LengthError> {
        if self.positions.len() != sets.len() {
            return Err(LengthError::new("next positions, in sets,", self.positions.len(), sets.len(), sets.len()));
        }
        let pairs = self.positions.iter().zip(sets).map(|(next, set)| (next.len(), set.positions.len()));
        match pairs.into_iter().find(|(has, needs)| has != needs) {
            Some((has, needs)) => Err(LengthError::new("next positions", has, needs, needs)),
            None => Ok(()),
        }
    }
}

/// By-products of one pixel.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Pixel {
    pub(crate) depth: f32,
    pub(crate) normal: [f32; 3],
    pub(crate) object: u32,
    pub(crate) flow: [f32; 2],
}

impl Pixel {
    /// Of a pixel in which nothing is seen.
    pub(crate) const NOTHING: Pixel =
        Pixel { depth: f32::INFINITY, normal: [0.0; 3], object: NO_OBJECT, flow: [f32::NAN; 2] };

    /// From the sums over all Gaussians of a pixel: of weights, of weights times depths, normals and motions, and of the
    /// weights of those that have a motion.
    pub(crate) fn of_sums(hidden: f32, depth: f32, normal: [f32; 3], object: u32, motion: [f32; 3]) -> Pixel {
        if hidden <= 0.0 {
            return Pixel::NOTHING;
        }
        let [along, down, moving] = motion;
        let length = normal.iter().map(|n| n * n).sum::<f32>().sqrt();
        Pixel {
            depth: depth / hidden,
            normal: if length > 0.0 { normal.map(|n| n / length) } else { [0.0; 3] },
            object,
            flow: if moving > 0.0 { [along / moving, down / moving] } else { [f32::NAN; 2] },
        }
    }
}

impl Layers {
    /// From pixels.
    pub(crate) fn new(view: &View, rgba: Vec<[f32; 4]>, pixels: &[Pixel], has_next: bool) -> Layers {
        let depth = pixels.iter().map(|p| p.depth).collect();
        Layers {
            picture: Picture { width: view.width, height: view.height, rgba, depth },
            normal: pixels.iter().map(|p| p.normal).collect(),
            object: pixels.iter().map(|p| p.object).collect(),
            flow: if has_next { pixels.iter().map(|p| p.flow).collect() } else { Vec::new() },
        }
    }
}
