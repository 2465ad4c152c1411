//! Masks: parts of pictures of a capture, and the cameras that took them, say which Gaussians belong to a thing.

use std::path::{Path, PathBuf};

use cosplat_splat::Splats;
use cosplat_viewer::{Camera, Options, View, png, weights};
use serde::Deserialize;

use super::look::{borrowed, finite};
use crate::exit::{Code, Error, Problem};

/// A Gaussian with a smaller weight over a whole picture is not seen in it: a hundredth of a pixel.
const SEEN: f64 = 0.01;
/// Nothing else is known about the scale of a capture: nearer than this part of the way to its middle is not drawn.
const NEAR: f64 = 0.01;
/// Fields of view along x and y may differ by this part: pixels are square but for calibration.
const SQUARE: f64 = 0.01;

/// A camera as JSON: where it stands and looks, or as 3D Gaussian Splatting writes it to `cameras.json`.
#[derive(Clone, Debug, Deserialize, PartialEq)]
#[serde(untagged)]
enum File {
    /// Axes and units of the file.
    Plain { eye: [f64; 3], target: [f64; 3], up: [f64; 3], fov_y_deg: f64 },
    /// Camera to world: centre and rotation, whose columns point right, down and forward; focal lengths in pixels of a
    /// picture of this size.
    Trained {
        position: [f64; 3],
        rotation: [[f64; 3]; 3],
        width: usize,
        height: usize,
        fx: f64,
        fy: f64,
        img_name: Option<String>,
    },
    /// Several of them; the one of the mask's name is taken.
    List(Vec<File>),
}

/// For each Gaussian the mean, over the views that see it, of its share within the masks; nothing where none sees it.
///
/// # Errors
/// A mask or camera cannot be read, or they do not belong together.
pub(super) fn shares(splats: &Splats, masks: &[PathBuf], cameras: &[PathBuf]) -> Result<Vec<Option<f64>>, Error> {
    if masks.len() != cameras.len() {
        let what = format!("{} masks have {} cameras", masks.len(), cameras.len());
        let problem = Problem::new(what).hint("give a `--camera` for each `--mask`, in the same order");
        return Err(Error::new(Code::Usage, problem));
    }
    // What is not finite is not drawn.
    let drawn = finite(splats);
    let selected = splats.select(&drawn);
    let mut sums = vec![(0.0, 0_u32); splats.len()];
    for (mask, camera) in masks.iter().zip(cameras) {
        let wrong = |e: &dyn std::fmt::Display| {
            let problem = Problem::new(format!("Cannot use the mask `{}`", mask.display())).at(mask).because(e);
            Error::new(Code::Scene, problem.hint("a mask is a PNG file, white where the thing is"))
        };
        let (width, height, inside) = png::read_mask(mask).map_err(|e| wrong(&e))?;
        let view = view(camera, mask, [width, height])?;
        let options = Options { near: near(&selected, &view), ..Options::default() };
        let seen = weights(&[borrowed(&selected)], &view, &options, &inside).map_err(|e| wrong(&e))?;
        for (&i, seen) in drawn.iter().zip(seen.iter().flatten()).filter(|(_, s)| s.all >= SEEN) {
            let (sum, views) = &mut sums[i as usize];
            *sum += seen.masked / seen.all;
            *views += 1;
        }
    }
    Ok(sums.into_iter().map(|(sum, views)| (views > 0).then(|| sum / f64::from(views))).collect())
}

fn near(splats: &Splats, view: &View) -> f64 {
    let n = splats.len().max(1) as f64;
    let middle = [0, 1, 2].map(|k| splats.positions.iter().map(|p| f64::from(p[k])).sum::<f64>() / n);
    let away: f64 = (0..3).map(|k| (middle[k] - view.eye[k]).powi(2)).sum::<f64>().sqrt();
    (NEAR * away).min(Options::default().near)
}

/// The view of a camera file, for a mask of this size.
fn view(path: &Path, mask: &Path, size: [usize; 2]) -> Result<View, Error> {
    let wrong = |what: String| {
        let problem = Problem::new(format!("Cannot use the camera `{}`", path.display())).at(path).because(what);
        let hint = "write `{\"eye\": [x, y, z], \"target\": [...], \"up\": [...], \"fov_y_deg\": 45}` in axes and units of \
                    the splat file, or take the `cameras.json` of its training";
        Error::new(Code::Scene, problem.hint(hint))
    };
    let text = std::fs::read_to_string(path).map_err(|e| wrong(e.to_string()))?;
    let file: File = serde_json::from_str(&text).map_err(|e| wrong(e.to_string()))?;
    chosen(file, mask).and_then(|file| file.view(size)).map_err(wrong)
}

/// The camera itself, or that of a list which has the mask's name.
fn chosen(file: File, mask: &Path) -> Result<File, String> {
    let File::List(all) = file else { return Ok(file) };
    let stem = mask.file_stem().and_then(|s| s.to_str()).unwrap_or_default();
    let is_of = |f: &File| match f {
        File::Trained { img_name: Some(name), .. } => {
            name == stem || Path::new(name).file_stem().is_some_and(|s| s == stem)
        }
        _ => false,
    };
    let count = all.len();
    let found = if count == 1 { all.into_iter().next() } else { all.into_iter().find(is_of) };
    found.ok_or_else(|| format!("none of its {count} cameras has the `img_name` `{stem}` of the mask"))
}

impl File {
    fn view(self, [width, height]: [usize; 2]) -> Result<View, String> {
        match self {
            Self::Plain { eye, target, up, fov_y_deg } => {
                Camera { eye, target, up, fov_y_deg, width, height }.view().map_err(|e| e.to_string())
            }
            Self::Trained { position, rotation, width: w, height: h, fx, fy, .. } => {
                let numbers = rotation.iter().flatten().chain(&position).chain([&fx, &fy]);
                let are_square = fx > 0.0 && (fx / fy - 1.0).abs() < SQUARE;
                if !(are_square && numbers.into_iter().all(|v| v.is_finite())) {
                    return Err(format!(
                        "its focal lengths {fx} and {fy} are not those of square pixels, or a number is none"
                    ));
                }
                // A smaller copy of the picture has the same camera.
                let [across, down] = [width as f64 / w as f64, height as f64 / h as f64];
                let is_copy = (across / down - 1.0).abs() < SQUARE;
                if !is_copy {
                    return Err(format!("the mask has {width} x {height} pixels and the camera {w} x {h}"));
                }
                let rows = [0, 1, 2].map(|axis| rotation.map(|row| row[axis]));
                Ok(View { eye: position, rows, focal: fy * down, width, height })
            }
            Self::List(_) => Err("it is a list in a list".to_owned()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cameras_of_both_kinds_are_the_same_view() {
        let plain = r#"{"eye": [0, 0, -2], "target": [0, 0, 0], "up": [0, -1, 0], "fov_y_deg": 90}"#;
        let trained = r#"[{"id": 0, "img_name": "b.jpg", "position": [9, 9, 9], "rotation": [[1,0,0],[0,1,0],[0,0,1]],
            "width": 200, "height": 100, "fx": 50, "fy": 50},
            {"id": 1, "img_name": "a", "position": [0, 0, -2], "rotation": [[1,0,0],[0,1,0],[0,0,1]],
            "width": 200, "height": 100, "fx": 50, "fy": 50}]"#;
        let view = |text: &str, size| {
            chosen(serde_json::from_str(text).unwrap(), Path::new("masks/a.png")).and_then(|file| file.view(size))
        };
        let [first, second] = [plain, trained].map(|text| view(text, [100, 50]).unwrap());
        assert_eq!((first.eye, first.rows, first.width), (second.eye, second.rows, second.width));
        // A tangent of 45° that is not quite one.
        assert!((first.focal - 25.0).abs() < 1e-9 && (second.focal - 25.0).abs() < 1e-9);
        assert!(view(trained, [100, 80]).unwrap_err().contains("100 x 80"));
        assert!(view(&trained.replace("\"a\"", "\"c\""), [100, 50]).unwrap_err().contains("none of its 2 cameras"));
        assert!(view(&trained.replace("\"fx\": 50", "\"fx\": 70"), [100, 50]).is_err());
        assert!(serde_json::from_str::<File>("{\"eye\": [0, 0]}").is_err());
    }
}
