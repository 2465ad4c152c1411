//! `cosplat splat compare`: how two files differ, number by number and as pictures.

use std::path::{Path, PathBuf};

use clap::Args;
use cosplat_splat::Splats;
use cosplat_splat::clean::{Rules, clean};
use cosplat_viewer::{Options, View, png, psnr, render as draw};
use serde::Serialize;

use super::convert::Change;
use super::look::{LookArgs, borrowed, camera, vector};
use super::read_some;
use super::ssim::ssim;
use super::statistics::Extent;
use crate::cli::Format;
use crate::exit::{Code, Error, Problem};
use crate::render::{Paint, json, print, printable};

/// Width and height where the other is no picture.
const SIZE_PX: [usize; 2] = [960, 720];

/// `cosplat splat compare`.
#[derive(Clone, Debug, Args)]
pub(crate) struct CompareArgs {
    /// Splat file
    #[arg(value_name = "FILE")]
    pub(crate) file: PathBuf,
    /// Splat file, or a picture (.png), to compare with
    #[arg(value_name = "OTHER")]
    pub(crate) other: PathBuf,
    /// Where the camera stands, in axes and units of FILE [default: in front, seeing all that is visible]
    #[arg(long, value_name = "X,Y,Z", value_parser = vector, allow_hyphen_values = true)]
    pub(crate) eye: Option<[f64; 3]>,
    /// Where it looks [default: the middle of what is visible]
    #[arg(long, value_name = "X,Y,Z", value_parser = vector, allow_hyphen_values = true)]
    pub(crate) target: Option<[f64; 3]>,
    /// What is up in the picture [default: by the convention of the format]
    #[arg(long, value_name = "X,Y,Z", value_parser = vector, allow_hyphen_values = true)]
    pub(crate) up: Option<[f64; 3]>,
    /// Vertical field of view in degrees
    #[arg(long, value_name = "DEGREES", default_value_t = 40.0)]
    pub(crate) fov: f64,
    /// Colour behind everything, red, green and blue in display values from 0 to 1
    #[arg(long, value_name = "R,G,B", value_parser = vector, default_value = "1,1,1")]
    pub(crate) background: [f64; 3],
    /// Form of the answer on standard output
    #[arg(long, value_enum, default_value_t)]
    pub(crate) format: Format,
}

/// How much two things differ.
#[derive(Debug, Serialize)]
struct Compared {
    status: &'static str,
    file: String,
    other: String,
    gaussians: usize,
    #[serde(skip_serializing_if = "Option::is_none")]
    other_gaussians: Option<usize>,
    /// Of each number; absent where there are not as many Gaussians in both.
    #[serde(skip_serializing_if = "Option::is_none")]
    change: Option<Change>,
    size_px: [usize; 2],
    /// Absent where the pictures are the same.
    #[serde(skip_serializing_if = "Option::is_none")]
    psnr_db: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    ssim: Option<f64>,
    /// Largest difference of a value, 0 to 1.
    largest: f64,
}

/// Says how two files differ.
///
/// # Errors
/// One of them cannot be used, or the camera sees nothing.
pub(super) fn compare(args: &CompareArgs) -> Result<Code, Error> {
    let compared = compared(args)?;
    match args.format {
        Format::Json => print(&json(&compared)?)?,
        Format::Human => print(&compared.human(Paint::stdout()))?,
    }
    Ok(Code::Ok)
}

fn compared(args: &CompareArgs) -> Result<Compared, Error> {
    let first = finite(&read_some(&args.file)?.decoded.splats);
    let is_picture = args.other.extension().is_some_and(|e| e.eq_ignore_ascii_case("png"));
    let unusable = |path: &Path, why: &dyn std::fmt::Display, hint: &str| {
        let problem = Problem::new(format!("Cannot compare with `{}`", path.display())).at(path).because(why);
        Error::new(Code::Scene, problem.hint(hint))
    };
    let picture = if is_picture {
        let read = png::read(&args.other);
        Some(read.map_err(|e| unusable(&args.other, &e, "give a splat file, or a picture that can be read"))?)
    } else {
        None
    };
    let size = picture.as_ref().map_or(SIZE_PX, |(width, height, _)| [*width, *height]);
    let Some(extent) = Extent::visible(&first) else {
        return Err(unusable(&args.file, &"no Gaussian has a finite place", "check it with `cosplat splat info`"));
    };
    let eye = LookArgs { eye: args.eye, target: args.target, up: args.up, fov: args.fov, size };
    let view = camera(&eye, &first, &extent).view().map_err(|e| {
        let problem = Problem::new("This camera cannot take a picture").because(e);
        Error::new(Code::Usage, problem.hint("change `--eye`, `--target`, `--up` or `--fov`"))
    })?;
    let here = drawn(&first, &view, args.background);
    let (there, other_gaussians, change) = if let Some((_, _, rgb)) = picture {
        (rgb, None, None)
    } else {
        let second = finite(&read_some(&args.other)?.decoded.splats).to_axes(first.axes);
        let change = (second.len() == first.len()).then(|| Change::between(&first, &second));
        (drawn(&second, &view, args.background), Some(second.len()), change)
    };
    let gap = |(a, b): (&f32, &f32)| f64::from((a - b).abs());
    Ok(Compared {
        status: "ok",
        file: args.file.display().to_string(),
        other: args.other.display().to_string(),
        gaussians: first.len(),
        other_gaussians,
        change,
        size_px: size,
        psnr_db: Some(psnr(&here, &there)).filter(|v| v.is_finite()),
        ssim: ssim(&here, &there, size[0]),
        largest: here.iter().zip(&there).map(gap).fold(0.0, f64::max),
    })
}

fn finite(splats: &Splats) -> Splats {
    splats.select(&clean(splats, &Rules { opacity: 0.0, inside: None, largest_sigma: None }).0)
}

fn drawn(splats: &Splats, view: &View, background: [f64; 3]) -> Vec<f32> {
    let background = background.map(|v| v.clamp(0.0, 1.0) as f32);
    draw(&[borrowed(splats)], view, &Options { background, ..Options::default() }).rgb()
}

impl Compared {
    fn human(&self, paint: Paint) -> String {
        let head = format!("{} and {}\n", paint.bold(&printable(&self.file)), printable(&self.other));
        let change = match (&self.change, self.other_gaussians) {
            (Some(change), _) if change.is_none() => "every number of every Gaussian is the same\n".to_owned(),
            (Some(change), _) => {
                let [most, worst] = [change.line(|s| s.p99), change.line(|s| s.max)];
                format!("99 % of the Gaussians differ by at most: {most}\nno Gaussian differs by more than: {worst}\n")
            }
            (None, Some(other)) => {
                format!("{} and {other} Gaussians: not compared one by one\n", self.gaussians)
            }
            (None, None) => String::new(),
        };
        let [width, height] = self.size_px;
        let looks = match (self.psnr_db, self.ssim) {
            (None, _) => "the same to the bit".to_owned(),
            (Some(db), None) => format!("PSNR {db:.2} dB"),
            (Some(db), Some(s)) => {
                format!("PSNR {db:.2} dB, SSIM {s:.4}, no value differs by more than {:.3}", self.largest)
            }
        };
        format!("{head}{change}pictures of {width} x {height}: {looks}\n")
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use cosplat_splat::format::encode;

    #[test]
    fn a_file_is_itself_and_another_is_measured() {
        let place = tempfile::tempdir().unwrap();
        let [a, b, c] = ["a.ply", "b.spz", "c.png"].map(|name| place.path().join(name));
        let one = Splats {
            positions: vec![[0.0; 3], [0.5, 0.25, 0.5]],
            rotations: vec![[0.9, 0.1, 0.2, -0.3]; 2],
            log_scales: vec![[-2.03, -2.0, -2.1]; 2],
            opacity_logits: vec![1.3; 2],
            sh_dc: vec![[0.4, -0.7, 0.0]; 2],
            ..Splats::default()
        };
        for (path, ending) in [(&a, "ply"), (&b, "spz")] {
            std::fs::write(path, encode(&one, Some(ending)).unwrap()).unwrap();
        }
        let args = |other: &PathBuf| CompareArgs {
            file: a.clone(),
            other: other.clone(),
            eye: None,
            target: None,
            up: None,
            fov: 40.0,
            background: [0.0; 3],
            format: Format::Json,
        };
        let same = compared(&args(&a)).unwrap();
        assert_eq!((same.psnr_db, same.largest), (None, 0.0));
        assert!(same.change.is_some_and(|c| c.is_none()));
        let packed = compared(&args(&b)).unwrap();
        // Steps of 1/255 of an opacity and of some 1/100 of a colour: below a hundredth of full scale nearly everywhere.
        assert!(packed.psnr_db.is_some_and(|db| db > 40.0) && packed.ssim.is_some_and(|s| s > 0.99), "{packed:?}");
        assert_eq!(compared(&args(&c)).unwrap_err().code, Code::Scene, "no such picture");
        let extent = Extent::visible(&one).unwrap();
        let view = camera(&LookArgs::of_size([64, 48]), &one, &extent).view().unwrap();
        png::write(&c, &draw(&[borrowed(&one)], &view, &Options::default())).unwrap();
        // A picture of eight bits: half a step, and its rounding.
        let drawn = compared(&args(&c)).unwrap();
        assert!(drawn.largest < 0.51 / 255.0 && drawn.size_px == [64, 48], "{drawn:?}");
    }
}
