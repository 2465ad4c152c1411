//! From where a splat file is looked at.

use clap::Args;
use cosplat_splat::clean::{Rules, clean};
use cosplat_splat::{Axes, Splats};
use cosplat_viewer::{Camera, Options};
use nalgebra::Vector3;

use super::statistics::Extent;
use crate::exit::{Code, Error, Problem};
pub(super) use crate::frames::borrowed;

const FIELD_OF_VIEW_DEG: f64 = 40.0;
/// Largest side of a picture: one of this size takes a gigabyte while it is drawn.
pub(super) const LARGEST_PX: usize = 8192;
/// Room around what is drawn.
const MARGIN: f64 = 1.1;
/// Nearest distance that is drawn, as a part of the distance to the target.
const NEAR: f64 = 0.01;

/// Where a camera stands and looks.
#[derive(Clone, Debug, Args)]
pub(crate) struct LookArgs {
    /// Where the camera stands, in axes and units of the file [default: in front, seeing all that is visible]
    #[arg(long, value_name = "X,Y,Z", value_parser = vector, allow_hyphen_values = true)]
    pub(crate) eye: Option<[f64; 3]>,
    /// Where it looks [default: the middle of what is visible]
    #[arg(long, value_name = "X,Y,Z", value_parser = vector, allow_hyphen_values = true)]
    pub(crate) target: Option<[f64; 3]>,
    /// What is up in the picture [default: by the convention of the format]
    #[arg(long, value_name = "X,Y,Z", value_parser = vector, allow_hyphen_values = true)]
    pub(crate) up: Option<[f64; 3]>,
    /// Vertical field of view in degrees
    #[arg(long, value_name = "DEGREES", default_value_t = FIELD_OF_VIEW_DEG)]
    pub(crate) fov: f64,
    /// Width and height in pixels
    #[arg(long, value_name = "WIDTHxHEIGHT", value_parser = size, default_value = "960x720")]
    pub(crate) size: [usize; 2],
}

impl LookArgs {
    /// From the front, over everything that is visible.
    pub(crate) fn of_size(size: [usize; 2]) -> Self {
        Self { eye: None, target: None, up: None, fov: FIELD_OF_VIEW_DEG, size }
    }
}

/// What a camera without a picture means on the command line.
pub(super) fn unusable(error: &dyn std::fmt::Display) -> Error {
    let problem = Problem::new("This camera cannot take a picture").because(error);
    Error::new(Code::Usage, problem.hint("change `--eye`, `--target`, `--up`, `--fov` or `--size`"))
}

/// How a camera draws: in front of it from a hundredth of the way to what it looks at.
pub(super) fn options(camera: &Camera, background: [f64; 3]) -> Options {
    let away: f64 = (0..3).map(|k| (camera.target[k] - camera.eye[k]).powi(2)).sum::<f64>().sqrt();
    let near = (NEAR * away).min(Options::default().near);
    Options { background: background.map(|v| v.clamp(0.0, 1.0) as f32), near, ..Options::default() }
}

/// Places of the Gaussians all of whose numbers are finite.
pub(super) fn finite(splats: &Splats) -> Vec<u32> {
    clean(splats, &Rules { opacity: 0.0, inside: None, largest_sigma: None }).0
}

/// The camera asked for; what was not said looks from the front at all that is visible.
pub(crate) fn camera(args: &LookArgs, splats: &Splats, extent: &Extent) -> Camera {
    let [width, height] = args.size;
    // From the front, a little to the right and above: +z of the first and −z of the second point into the picture.
    let (up, from) = match splats.axes {
        Axes::Rdf => ([0.0, -1.0, 0.0], [0.3, -0.25, -1.0]),
        Axes::Rub => ([0.0, 1.0, 0.0], [0.3, 0.25, 1.0]),
        Axes::Scene => ([0.0, 0.0, 1.0], [0.3, -1.0, 0.25]),
    };
    let up = args.up.unwrap_or(up);
    let target = args.target.unwrap_or_else(|| extent.centre());
    let tangent = (args.fov.to_radians() / 2.0).tan();
    let tangents = [tangent * width as f64 / height as f64, tangent];
    let back = Vector3::from(from).normalize();
    let eye = args.eye.unwrap_or_else(|| {
        let distance = distance(extent, target, back, Vector3::from(up), tangents);
        (Vector3::from(target) + back * distance).into()
    });
    Camera { eye, target, up, fov_y_deg: args.fov, width, height }
}

/// How far back a camera must stand so that all corners of a box are in its picture: a corner that is u to the side and w
/// nearer than the target is inside if u ≤ tangent · (distance − w).
fn distance(extent: &Extent, target: [f64; 3], back: Vector3<f64>, up: Vector3<f64>, tangents: [f64; 2]) -> f64 {
    let right = up.cross(&back).try_normalize(0.0).unwrap_or_else(Vector3::zeros);
    let above = back.cross(&right);
    let mut distance = 0.0_f64;
    for corner in 0..8_usize {
        let at = [0, 1, 2].map(|k| if corner >> k & 1 == 0 { extent.low[k] } else { extent.high[k] });
        let at = Vector3::from(at) - Vector3::from(target);
        let sides = [right, above].map(|axis| MARGIN * at.dot(&axis).abs());
        for (side, tangent) in sides.into_iter().zip(tangents) {
            distance = distance.max(at.dot(&back) + side / tangent);
        }
    }
    if distance > 0.0 { distance } else { 1.0 }
}

/// Three numbers with commas between.
pub(super) fn vector(text: &str) -> Result<[f64; 3], String> {
    let numbers: Option<Vec<f64>> =
        text.split(',').map(|word| word.trim().parse().ok().filter(|v: &f64| v.is_finite())).collect();
    let three = numbers.and_then(|numbers| <[f64; 3]>::try_from(numbers).ok());
    three.ok_or_else(|| "expected three numbers with commas between, as in `0,0.5,2`".to_owned())
}

/// Width, `x` and height.
fn size(text: &str) -> Result<[usize; 2], String> {
    let side = |word: &str| word.trim().parse().ok().filter(|v| (1..=LARGEST_PX).contains(v));
    let sides = text.split_once(['x', 'X']).and_then(|(width, height)| Some([side(width)?, side(height)?]));
    sides.ok_or_else(|| format!("expected width, `x` and height from 1 to {LARGEST_PX}, as in `960x720`"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_become_numbers() {
        assert_eq!(vector("1, -2.5,3e-1"), Ok([1.0, -2.5, 0.3]));
        assert!(["", "1,2", "1,2,3,4", "1,2,inf", "a,b,c"].iter().all(|t| vector(t).is_err()));
        assert_eq!(size("960x720"), Ok([960, 720]));
        assert!(["0x5", "5", "x", "9000x1", "-1x4"].iter().all(|t| size(t).is_err()));
    }
}
