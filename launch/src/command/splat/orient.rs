//! `cosplat splat orient`: which way is up, where the ground is, and how long a metre is.

use std::path::PathBuf;

use clap::Args;
use cosplat_splat::ground::{Ground, GroundError, Settings, ground};
use cosplat_splat::{Axes, Similarity, SimilarityError, Splats};
use nalgebra::{Matrix3, Rotation3, UnitQuaternion, Vector3};
use serde::Serialize;

use super::look::vector;
use super::output::{Output, axes_of, free, write};
use super::read_some;
use super::statistics::{Extent, VISIBLE};
use crate::cli::Format;
use crate::exit::{Code, Error, Problem};
use crate::geometry::axis;
use crate::render::{Paint, json, print, printable};

/// Up axes as scenes name them.
const AXES: [&str; 6] = ["+x", "-x", "+y", "-y", "+z", "-z"];
/// The height of an object is that which this part of its visible Gaussians does not exceed: some float.
const TOP: f64 = 0.999;

/// `cosplat splat orient`.
#[derive(Clone, Debug, Args)]
pub(crate) struct OrientArgs {
    /// Splat file to read
    #[arg(value_name = "IN")]
    pub(crate) input: PathBuf,
    /// Splat file to write: .ply, .spz or .glb; upright by the convention of its format, on its ground, in metres
    #[arg(value_name = "OUT")]
    pub(crate) output: Option<PathBuf>,
    /// Known: the longest side of what is visible, in metres
    #[arg(long, value_name = "METRES", group = "known")]
    pub(crate) length: Option<f64>,
    /// Known: the height of what stands on the ground, in metres
    #[arg(long, value_name = "METRES", group = "known")]
    pub(crate) height: Option<f64>,
    /// Known: the distance between `--from` and `--to`, in metres
    #[arg(long, value_name = "METRES", group = "known", requires_all = ["from", "to"])]
    pub(crate) distance: Option<f64>,
    /// Known: a unit of the file, in metres
    #[arg(long, value_name = "METRES", group = "known")]
    pub(crate) metres_per_unit: Option<f64>,
    /// A place in units and axes of the file
    #[arg(long, value_name = "X,Y,Z", value_parser = vector, allow_hyphen_values = true, requires = "distance")]
    pub(crate) from: Option<[f64; 3]>,
    /// Another place
    #[arg(long, value_name = "X,Y,Z", value_parser = vector, allow_hyphen_values = true, requires = "distance")]
    pub(crate) to: Option<[f64; 3]>,
    /// Direction of the file that roughly points up, as `0,-1,0`; exactly, where there is no ground [default: the side of
    /// the ground on which more lies]
    #[arg(long, value_name = "X,Y,Z", value_parser = vector, allow_hyphen_values = true)]
    pub(crate) up: Option<[f64; 3]>,
    /// How far the ground may be tilted against `--up`, in degrees
    #[arg(long, value_name = "DEGREES", default_value_t = 30.0)]
    pub(crate) tilt: f64,
    /// What is nearer to the ground than this part of the diagonal belongs to it
    #[arg(long, value_name = "PART", default_value_t = 0.01)]
    pub(crate) tolerance: f64,
    /// Gaussians more transparent than this are no ground
    #[arg(long, value_name = "OPACITY", default_value_t = 0.3)]
    pub(crate) min_opacity: f64,
    /// Replace OUT if it exists
    #[arg(long)]
    pub(crate) force: bool,
    /// Form of the answer on standard output
    #[arg(long, value_enum, default_value_t)]
    pub(crate) format: Format,
}

/// What was found out about a file.
#[derive(Debug, Serialize)]
struct Oriented {
    status: &'static str,
    input: String,
    #[serde(skip_serializing_if = "Option::is_none")]
    output: Option<String>,
    /// Up in the axes of the file, a unit vector.
    up: [f64; 3],
    /// The axis of the file that is nearest to it, and the angle between the two \[°\].
    up_axis: &'static str,
    tilt_deg: f64,
    /// Why there is no ground, where `--up` alone says how it stands.
    #[serde(skip_serializing_if = "Option::is_none")]
    no_ground: Option<String>,
    /// Part of the surface that lies in the ground, and part of the rest that lies above it.
    ground_share: f64,
    above_share: f64,
    roughness_m: f64,
    metres_per_unit: f64,
    /// Whether a length was given; without one a unit is taken as a metre.
    scale_known: bool,
    height_m: f64,
    /// From the file to a scene: x becomes scale · rotation x + translation \[m\], rows of the rotation.
    rotation: [[f64; 3]; 3],
    translation_m: [f64; 3],
    /// Lines for a body of a scene.
    scene: String,
}

/// Finds the ground of a capture.
///
/// # Errors
/// The file cannot be used or has no ground, or OUT cannot be written.
pub(super) fn orient(args: &OrientArgs) -> Result<Code, Error> {
    let oriented = oriented(args)?;
    match args.format {
        Format::Json => print(&json(&oriented)?)?,
        Format::Human => print(&oriented.human(Paint::stdout()))?,
    }
    Ok(Code::Ok)
}

fn oriented(args: &OrientArgs) -> Result<Oriented, Error> {
    if let Some(out) = &args.output {
        free(&Output { from: &args.input, to: out, force: args.force })?;
    }
    let splats = read_some(&args.input)?.decoded.splats;
    let unusable = |why: &dyn std::fmt::Display| {
        let problem = Problem::new(format!("Cannot orient `{}`", args.input.display())).at(&args.input).because(why);
        Error::new(Code::Scene, problem.hint("state `--up`, or change `--tilt`, `--tolerance` or `--min-opacity`"))
    };
    let settings = Settings {
        opacity: args.min_opacity,
        tolerance: args.tolerance,
        up: args.up,
        tilt_deg: args.tilt,
        ..Settings::default()
    };
    let (found, missing) = match (ground(&splats, &settings), args.up) {
        (Ok(found), _) => (found, None),
        (Err(why @ (GroundError::None(..) | GroundError::TooFew(_))), Some(up)) => {
            (standing(&splats, up), Some(why.to_string()))
        }
        (Err(why), _) => return Err(unusable(&why)),
    };
    let height = heights(&splats, &found, TOP);
    let scale = args.scale(&splats, height).map_err(|why| unusable(&why))?;
    let to_scene = to_scene(&found, scale).map_err(|e| unusable(&e))?;
    let up_axis = nearest_axis(found.normal);
    if let Some(out) = &args.output {
        let axes = axes_of(out);
        let upright = by_convention(axes, &to_scene).map_err(|e| unusable(&e))?;
        let mut turned = splats;
        upright.apply(&mut turned, axes);
        write(out, &turned)?;
    }
    let tilt = Vector3::from(found.normal).dot(&Vector3::from(axis(up_axis))).clamp(-1.0, 1.0).acos().to_degrees();
    let row = |k: usize| to_scene.rotation.row(k).transpose().into();
    Ok(Oriented {
        status: "ok",
        input: args.input.display().to_string(),
        output: args.output.as_ref().map(|p| p.display().to_string()),
        up: found.normal,
        up_axis,
        tilt_deg: tilt,
        no_ground: missing,
        ground_share: found.share,
        above_share: found.above,
        roughness_m: scale * found.roughness,
        metres_per_unit: scale,
        scale_known: args.length.or(args.height).or(args.distance).or(args.metres_per_unit).is_some(),
        height_m: scale * height,
        rotation: [row(0), row(1), row(2)],
        translation_m: to_scene.translation.into(),
        scene: args.lines(up_axis, &to_scene),
    })
}

/// A ground below an object without one: at its lowest visible Gaussians.
fn standing(splats: &Splats, up: [f64; 3]) -> Ground {
    let normal = Vector3::from(up).normalize().into();
    let flat = Ground { normal, height: 0.0, share: 0.0, above: 1.0, roughness: 0.0 };
    Ground { height: heights(splats, &flat, 1.0 - TOP), ..flat }
}

/// Height above the ground below which that part of what is visible lies, in units of the file.
fn heights(splats: &Splats, ground: &Ground, part: f64) -> f64 {
    let normal = Vector3::from(ground.normal);
    let above = |i: usize| normal.dot(&Vector3::from(splats.positions[i].map(f64::from))) - ground.height;
    let visible = (0..splats.len()).filter(|&i| splats.opacity(i) >= VISIBLE);
    let mut heights: Vec<f64> = visible.map(above).filter(|h| h.is_finite()).collect();
    heights.sort_by(f64::total_cmp);
    let last = (part * heights.len().saturating_sub(1) as f64).round() as usize;
    heights.get(last).copied().unwrap_or(0.0)
}

/// Up becomes +z by the shortest turn, and the ground z = 0.
fn to_scene(ground: &Ground, scale: f64) -> Result<Similarity, SimilarityError> {
    let turned = Similarity::upright(ground.normal, scale)?;
    Ok(Similarity { translation: Vector3::new(0.0, 0.0, -scale * ground.height), ..turned })
}

/// The same in axes in which up is what a format has by convention; they become those of a scene when it is read.
fn by_convention(axes: Axes, to_scene: &Similarity) -> Result<Similarity, SimilarityError> {
    let up = axes.up().map_or([0.0, 0.0, 1.0], axis);
    Ok(Similarity::upright(up, 1.0)?.inverse().after(to_scene))
}

fn nearest_axis(up: [f64; 3]) -> &'static str {
    let along = |name: &str| Vector3::from(axis(name)).dot(&Vector3::from(up));
    AXES.into_iter().fold(AXES[0], |best, name| if along(name) > along(best) { name } else { best })
}

/// Quaternion x, y, z, w.
fn quaternion(rotation: &Matrix3<f64>) -> [f64; 4] {
    let q = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(*rotation));
    [q.i, q.j, q.k, q.w]
}

impl OrientArgs {
    /// Metres per unit.
    fn scale(&self, splats: &Splats, height: f64) -> Result<f64, String> {
        let apart = |(a, b): ([f64; 3], [f64; 3])| (Vector3::from(a) - Vector3::from(b)).norm();
        let longest = || Extent::visible(splats).map_or(0.0, |e| e.longest());
        let (metres, units) = match (self.length, self.height, self.distance) {
            (Some(metres), ..) => (metres, longest()),
            (_, Some(metres), _) => (metres, height),
            (.., Some(metres)) => (metres, self.from.zip(self.to).map_or(0.0, apart)),
            _ => (self.metres_per_unit.unwrap_or(1.0), 1.0),
        };
        let scale = metres / units;
        if scale.is_finite() && scale > 0.0 { Ok(scale) } else { Err(format!("{units} units cannot be {metres} m")) }
    }

    /// What a scene says about a body made from OUT, or else from IN.
    fn lines(&self, up: &str, to_scene: &Similarity) -> String {
        if let Some(out) = &self.output {
            return format!("splat = {{ file = {} }}\n", quoted(out));
        }
        let own = Similarity::upright(axis(up), 1.0).map_or_else(|_| Matrix3::identity(), |s| s.rotation);
        let [position, orientation] =
            [numbers(to_scene.translation.as_slice()), numbers(&quaternion(&(to_scene.rotation * own.transpose())))];
        let (file, scale) = (quoted(&self.input), to_scene.scale);
        format!(
            "splat = {{ file = {file}, metres_per_unit = {scale:?}, up = \"{up}\" }}\nposition = {position}\n\
             orientation = {orientation}\n"
        )
    }
}

/// A path as TOML writes text.
fn quoted(path: &std::path::Path) -> String {
    toml::Value::String(path.display().to_string()).to_string()
}

fn numbers(values: &[f64]) -> String {
    // Adding zero makes −0 zero.
    format!("{:?}", values.iter().map(|v| v + 0.0).collect::<Vec<f64>>())
}

impl Oriented {
    fn human(&self, paint: Paint) -> String {
        let Self { up_axis, tilt_deg, metres_per_unit, roughness_m, height_m, .. } = self;
        let up = self.up.map(|v| format!("{v:.4}")).join(", ");
        let (share, above) = (100.0 * self.ground_share, 100.0 * self.above_share);
        let ground = match &self.no_ground {
            Some(why) => format!("none, so it stands on its lowest Gaussians as `--up` says: {why}"),
            None => format!(
                "{share:.1} % of the surface lies in it within {roughness_m:.2e} m, {above:.1} % of the rest above"
            ),
        };
        let unit = if self.scale_known { "" } else { ": no length is known, so a unit is taken as a metre" };
        let written = self.output.as_ref().map(|out| {
            format!(
                "{}: upright by the convention of its format, on its ground, in metres\n",
                paint.bold(&printable(out))
            )
        });
        format!(
            "{}\n  up                [{up}], {tilt_deg:.2}° from {up_axis}\n  \
             ground            {ground}\n  \
             metres per unit   {metres_per_unit}{unit}\n  \
             height            {height_m:.4} m\n\nIn a scene:\n{}\n{}",
            paint.bold(&printable(&self.input)),
            self.scene,
            written.unwrap_or_default()
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use cosplat_splat::format::{encode, read_file};

    /// A ground of 40 × 40 on a side of 2 and a tower of height 0.8 on it, up along a vector.
    fn tower(up: [f64; 3]) -> Splats {
        let turn = Similarity::upright(up, 1.0).unwrap().inverse().rotation;
        let ground =
            (0..1600).map(|i| Vector3::new(f64::from(i % 40) / 20.0 - 1.0, f64::from(i / 40) / 20.0 - 1.0, 0.0));
        let tower = (0..800).map(|i| {
            let (s, c) = (f64::from(i) * 2.4).sin_cos();
            Vector3::new(0.2 * c, 0.2 * s, f64::from(i + 1) * 0.001)
        });
        let places = ground.chain(tower).map(|p| turn * p + Vector3::new(0.1, 0.2, 0.3));
        let positions: Vec<[f32; 3]> = places.map(|p| p.map(|v| v as f32).into()).collect();
        let n = positions.len();
        Splats {
            rotations: vec![[1.0, 0.0, 0.0, 0.0]; n],
            log_scales: vec![[-4.0, -4.0, -5.0]; n],
            opacity_logits: vec![3.0; n],
            sh_dc: vec![[0.0; 3]; n],
            positions,
            ..Splats::default()
        }
    }

    fn typed(words: &[String]) -> OrientArgs {
        let line = ["cosplat", "splat", "orient"].map(str::to_owned).into_iter().chain(words.iter().cloned());
        let parsed = <crate::cli::Cli as clap::Parser>::parse_from(line).command;
        let Some(crate::cli::Command::Splat(args)) = parsed else { panic!("{parsed:?}") };
        let super::super::SplatCommand::Orient(args) = args.command else { panic!("{args:?}") };
        args
    }

    #[test]
    fn a_turned_capture_stands_upright_on_its_ground_in_metres() {
        let place = tempfile::tempdir().unwrap();
        let at = |name: &str| place.path().join(name).display().to_string();
        let up = Vector3::new(0.1, -1.0, 0.15).normalize();
        std::fs::write(at("a.ply"), encode(&tower(up.into()), Some("ply")).unwrap()).unwrap();
        for out in ["b.ply", "b.spz", "b.glb"] {
            let done = oriented(&typed(&[at("a.ply"), at(out), "--height".into(), "1.6".into()])).unwrap();
            assert_eq!((done.up_axis, done.scale_known), ("-y", true));
            assert!(Vector3::from(done.up).dot(&up) > 1.0 - 1e-6 && (done.tilt_deg - 10.22).abs() < 0.1, "{done:?}");
            // Of 2400 Gaussians the two highest are left out: 0.798 is 1.6 m.
            assert!((done.metres_per_unit - 1.6 / 0.798).abs() < 0.01, "{done:?}");
            // Read as a scene reads it, it stands on z = 0.
            let mut back = read_file(out_path(&place, out).as_path()).unwrap().splats;
            let read_up = axis(back.axes.up().unwrap());
            Similarity::upright(read_up, 1.0).unwrap().apply(&mut back, Axes::Scene);
            let extent = Extent::visible(&back).unwrap();
            assert!(extent.low[2].abs() < 0.01 && (extent.high[2] - 1.604).abs() < 0.02, "{extent:?}");
        }
        // Without OUT, the lines say the same of the file itself.
        let done = oriented(&typed(&[at("a.ply"), "--metres-per-unit".into(), "2".into()])).unwrap();
        let table: toml::Table = done.scene.parse().unwrap();
        let list = |key: &str| table[key].as_array().unwrap().iter().map(|v| v.as_float().unwrap()).collect::<Vec<_>>();
        let pose = cosplat_splat::bind::Frame::of_pose(
            list("position").try_into().unwrap(),
            list("orientation").try_into().unwrap(),
        );
        let mut body = read_file(out_path(&place, "a.ply").as_path()).unwrap().splats;
        Similarity::upright(axis("-y"), 2.0).unwrap().apply(&mut body, Axes::Scene);
        let scene = Similarity::from(pose.unwrap());
        scene.apply(&mut body, Axes::Scene);
        let extent = Extent::visible(&body).unwrap();
        assert!(extent.low[2].abs() < 0.01 && (extent.high[2] - 1.6).abs() < 0.01, "{extent:?}");
    }

    #[test]
    fn lengths_are_known_in_several_ways_and_what_is_none_is_refused() {
        let place = tempfile::tempdir().unwrap();
        let at = |name: &str| place.path().join(name).display().to_string();
        std::fs::write(at("a.ply"), encode(&tower([0.0, 1.0, 0.0]), Some("ply")).unwrap()).unwrap();
        let scale = |words: &[&str]| {
            let words: Vec<String> = [at("a.ply")].into_iter().chain(words.iter().map(|w| (*w).to_owned())).collect();
            oriented(&typed(&words)).map(|done| (done.metres_per_unit * 1e3).round() / 1e3).map_err(|e| e.code)
        };
        assert_eq!(scale(&[]), Ok(1.0));
        // The ground is 1.95 wide.
        assert_eq!(scale(&["--length", "3.9"]), Ok(2.0));
        assert_eq!(scale(&["--distance", "2", "--from", "0,0,0", "--to", "0,4,3"]), Ok(0.4));
        assert_eq!(scale(&["--distance", "2", "--from", "1,0,0", "--to", "1,0,0"]), Err(Code::Scene));
        assert_eq!(scale(&["--height", "0"]), Err(Code::Scene));
        assert_eq!(scale(&["--up", "0,0,0"]), Err(Code::Scene));
        // No ground is upright to the ground that there is: as stated, it stands on its lowest Gaussians.
        assert_eq!(scale(&["--up", "1,0,0", "--height", "3.9"]), Ok(2.0));
    }

    fn out_path(place: &tempfile::TempDir, name: &str) -> PathBuf {
        place.path().join(name)
    }
}
