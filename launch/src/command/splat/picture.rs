//! `cosplat splat render`: a picture of a file.

use std::path::PathBuf;

use clap::Args;
use cosplat_splat::clean::{Rules, clean};
use cosplat_splat::{Axes, Splats};
use cosplat_viewer::{Camera, Gaussians, Options, Preview, PreviewOptions, Shot, Travel, png, render as draw};
use nalgebra::Vector3;
use serde::Serialize;

use super::statistics::Extent;
use super::{put, read};
use crate::cli::Format;
use crate::exit::{Code, Error, Problem};
use crate::render::{Paint, json, print, printable};

const FIELD_OF_VIEW_DEG: f64 = 40.0;
/// Largest side of a picture: one of this size takes a gigabyte while it is drawn.
const LARGEST_PX: usize = 8192;
/// Room around what is drawn.
const MARGIN: f64 = 1.1;
/// Nearest distance that is drawn, as a part of the distance to the target.
const NEAR: f64 = 0.01;

/// Pictures of an orbit at most.
const MOST_PICTURES: i64 = 720;
/// An orbit is played at this rate \[1/s\].
const PER_SECOND: u16 = 25;

/// `cosplat splat render`.
#[derive(Clone, Debug, Args)]
pub(crate) struct RenderArgs {
    /// Splat file to draw
    #[arg(value_name = "FILE")]
    pub(crate) file: PathBuf,
    /// Picture to write, a .png; one that exists is replaced
    #[arg(value_name = "OUT.png", value_parser = picture_name)]
    pub(crate) output: PathBuf,
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
    /// Colour behind everything, red, green and blue in display values from 0 to 1
    #[arg(long, value_name = "R,G,B", value_parser = vector, default_value = "1,1,1")]
    pub(crate) background: [f64; 3],
    /// Take this many pictures on a circle around the target and about what is up, as an animated PNG
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(2..=MOST_PICTURES))]
    pub(crate) orbit: Option<u16>,
    /// Form of the answer on standard output
    #[arg(long, value_enum, default_value_t)]
    pub(crate) format: Format,
}

impl RenderArgs {
    /// From the front, over everything that is visible.
    pub(super) fn of_size(size: [usize; 2]) -> Self {
        Self {
            file: PathBuf::new(),
            output: PathBuf::new(),
            eye: None,
            target: None,
            up: None,
            fov: FIELD_OF_VIEW_DEG,
            size,
            background: [1.0; 3],
            orbit: None,
            format: Format::default(),
        }
    }
}

/// The picture that was made.
#[derive(Debug, Serialize)]
struct Drawn {
    status: &'static str,
    output: String,
    size_px: [usize; 2],
    eye: [f64; 3],
    target: [f64; 3],
    up: [f64; 3],
    field_of_view_deg: f64,
    gaussians: usize,
    pictures: u16,
}

/// Draws a splat file.
///
/// # Errors
/// The file cannot be used, the camera sees nothing, or the picture cannot be written.
pub(super) fn render(args: &RenderArgs) -> Result<Code, Error> {
    let drawn = drawn(args)?;
    match args.format {
        Format::Json => print(&json(&drawn)?)?,
        Format::Human => print(&drawn.human(Paint::stdout()))?,
    }
    Ok(Code::Ok)
}

/// Draws and writes the picture.
fn drawn(args: &RenderArgs) -> Result<Drawn, Error> {
    let splats = read(&args.file)?.decoded.splats;
    let kept = clean(&splats, &Rules { opacity: 0.0, inside: None, largest_sigma: None }).0;
    let splats = if kept.len() < splats.len() { splats.select(&kept) } else { splats };
    let Some(extent) = Extent::visible(&splats) else {
        let problem = Problem::new(format!("There is nothing to draw in `{}`", args.file.display())).at(&args.file);
        return Err(Error::new(Code::Scene, problem.because("no Gaussian has a finite place")));
    };
    let camera = camera(args, &splats, &extent);
    let unusable = |error: &dyn std::fmt::Display| {
        let problem = Problem::new("This camera cannot take a picture").because(error);
        Error::new(Code::Usage, problem.hint("change `--eye`, `--target`, `--up`, `--fov` or `--size`"))
    };
    camera.view().map_err(|e| unusable(&e))?;
    let away: f64 = (0..3).map(|k| (camera.target[k] - camera.eye[k]).powi(2)).sum::<f64>().sqrt();
    let near = (NEAR * away).min(Options::default().near);
    let background = args.background.map(|v| v.clamp(0.0, 1.0) as f32);
    let options = Options { background, near, ..Options::default() };
    let count = args.orbit.unwrap_or(1);
    // A full turn, of which the last picture is the first again and left out.
    let turn = Travel::Orbit { degrees: 360.0, duration_s: f64::from(count) };
    let shot = Shot { camera, travel: turn };
    let mut preview = Preview::new(PreviewOptions {
        pictures_per_second: PER_SECOND,
        largest_px: LARGEST_PX,
        frames: usize::from(count),
        bytes: usize::MAX,
        ..PreviewOptions::default()
    });
    let mut bytes = std::io::Cursor::new(Vec::new());
    for number in 0..count {
        let view = shot.at(f64::from(number)).view().map_err(|e| unusable(&e))?;
        let picture = draw(&[borrowed(&splats)], &view, &options);
        match args.orbit {
            None => png::encode(&mut bytes, &picture).map_err(|e| unusable(&e))?,
            Some(_) => preview.push(&picture).map_err(|e| unusable(&e))?,
        }
    }
    if args.orbit.is_some() {
        bytes = std::io::Cursor::new(preview.encode().map_err(|e| unusable(&e))?);
    }
    put(&args.output, bytes.get_ref())?;
    Ok(Drawn {
        status: "ok",
        output: args.output.display().to_string(),
        size_px: args.size,
        eye: camera.eye,
        target: camera.target,
        up: camera.up,
        field_of_view_deg: camera.fov_y_deg,
        gaussians: splats.len(),
        pictures: count,
    })
}

/// The camera asked for; what was not said looks from the front at all that is visible.
pub(super) fn camera(args: &RenderArgs, splats: &Splats, extent: &Extent) -> Camera {
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

pub(super) fn borrowed(splats: &Splats) -> Gaussians<'_> {
    Gaussians {
        positions: &splats.positions,
        rotations: &splats.rotations,
        log_scales: &splats.log_scales,
        opacity_logits: &splats.opacity_logits,
        sh_dc: &splats.sh_dc,
        sh_rest: &splats.sh_rest,
        sh_degree: splats.sh_degree,
        antialiased: splats.antialiased,
    }
}

impl Drawn {
    fn human(&self, paint: Paint) -> String {
        let [width, height] = self.size_px;
        let vector = |v: [f64; 3]| v.map(|c| format!("{c:.4}")).join(",");
        format!(
            "{}: {width} x {height}, {} Gaussians\n  --eye {} --target {} --up {} --fov {}\n",
            paint.bold(&printable(&self.output)),
            self.gaussians,
            vector(self.eye),
            vector(self.target),
            vector(self.up),
            self.field_of_view_deg
        )
    }
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

pub(super) fn picture_name(text: &str) -> Result<PathBuf, String> {
    let path = PathBuf::from(text);
    let is_png = path.extension().is_some_and(|e| e.eq_ignore_ascii_case("png"));
    if is_png { Ok(path) } else { Err("expected a file name that ends with `.png`".to_owned()) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use cosplat_splat::format::encode;

    fn args(folder: &std::path::Path) -> RenderArgs {
        RenderArgs {
            file: folder.join("a.spz"),
            output: folder.join("a.png"),
            eye: None,
            target: None,
            up: None,
            fov: FIELD_OF_VIEW_DEG,
            size: [64, 48],
            background: [0.0; 3],
            orbit: None,
            format: Format::Json,
        }
    }

    #[test]
    fn words_become_numbers() {
        assert_eq!(vector("1, -2.5,3e-1"), Ok([1.0, -2.5, 0.3]));
        assert!(["", "1,2", "1,2,3,4", "1,2,inf", "a,b,c"].iter().all(|t| vector(t).is_err()));
        assert_eq!(size("960x720"), Ok([960, 720]));
        assert!(["0x5", "5", "x", "9000x1", "-1x4"].iter().all(|t| size(t).is_err()));
        assert!(picture_name("a.PNG").is_ok() && picture_name("a.jpg").is_err());
    }

    #[test]
    fn the_first_camera_sees_everything() {
        let place = tempfile::tempdir().unwrap();
        let args = args(place.path());
        let splats = Splats {
            positions: vec![[5.0, 5.0, 5.0], [6.0, 5.5, 7.0]],
            rotations: vec![[1.0, 0.0, 0.0, 0.0]; 2],
            log_scales: vec![[-3.0; 3]; 2],
            opacity_logits: vec![5.0; 2],
            sh_dc: vec![[1.5, 0.0, -1.5]; 2],
            ..Splats::default()
        };
        std::fs::write(&args.file, encode(&splats, Some("spz")).unwrap()).unwrap();
        assert_eq!(drawn(&args).unwrap().gaussians, 2);
        let (width, height, rgb) = png::read(&args.output).unwrap();
        assert_eq!((width, height), (64, 48));
        let red = |from: usize, to: usize| {
            let columns = (0..width * height).filter(|i| (from..to).contains(&(i % width)));
            columns.map(|i| rgb[3 * i]).fold(0.0, f32::max)
        };
        assert!(red(0, 32) > 0.5 && red(32, 64) > 0.5, "one on either side");
        let edge = (0..width).flat_map(|x| [x, x + width * (height - 1)]).map(|i| rgb[3 * i]).fold(0.0, f32::max);
        assert!(edge < 0.01, "nothing is cut off: {edge}");
        let round = RenderArgs { output: place.path().join("round.png"), orbit: Some(4), ..args.clone() };
        assert_eq!(drawn(&round).unwrap().pictures, 4);
        let first = png::read(&round.output).unwrap();
        assert!(first == png::read(&args.output).unwrap(), "an orbit begins where a picture is taken");
        let animated = std::fs::read(&round.output).unwrap();
        assert_eq!(animated.windows(4).filter(|w| *w == b"fcTL").count(), 4);
        let blind = RenderArgs { up: Some([0.0; 3]), ..args };
        assert_eq!(drawn(&blind).unwrap_err().code, Code::Usage);
    }
}
