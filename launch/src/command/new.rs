//! `cosplat new`: a scene to begin with.

use std::fs::OpenOptions;
use std::io::{self, Write as _};
use std::path::{Path, PathBuf};

use clap::Args;
use serde::Serialize;

use super::splat::read_some;
use super::splat::statistics::Extent;
use crate::cli::Format;
use crate::exit::{Code, Error, Problem};
use crate::render::{Paint, json, print};
use crate::scene_source::{Source, parse};

const EXAMPLES: &str = "\
Examples:
  cosplat new first                             a ball falls on a soft block
  cosplat new plant --splat plant.spz --length 0.46
  cosplat check first.toml && cosplat run first.toml";

/// Particles along the longest side of a capture.
const ALONG: f64 = 40.0;

/// `cosplat new`.
#[derive(Clone, Debug, Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct NewArgs {
    /// Name of the scene; it is written to `NAME.toml`, which must not exist
    #[arg(value_name = "NAME")]
    pub(crate) name: String,
    /// Make a body of this capture and let a ball hit it
    #[arg(long, value_name = "FILE")]
    pub(crate) splat: Option<PathBuf>,
    /// Longest side of the capture in metres [default: one unit of the file is one metre]
    #[arg(long, value_name = "METRES", value_parser = length, allow_negative_numbers = true, requires = "splat")]
    pub(crate) length: Option<f64>,
    /// Form of the answer on standard output
    #[arg(long, value_enum, default_value_t)]
    pub(crate) format: Format,
}

/// What was written.
#[derive(Debug, Serialize)]
struct Written {
    status: &'static str,
    file: String,
}

/// Writes a scene.
///
/// # Errors
/// The name is none, the file exists or cannot be written, or the capture cannot be used.
pub(crate) fn new(args: &NewArgs) -> Result<Code, Error> {
    let file = write(args, Path::new(""))?;
    let file = file.display().to_string();
    match args.format {
        Format::Json => print(&json(&Written { status: "ok", file })?)?,
        Format::Human => {
            let paint = Paint::stdout();
            let next = paint.cyan(&format!("cosplat check {file}"));
            print(&format!("{}: change it, and see what a run would do: {next}\n", paint.bold(&file)))?;
        }
    }
    Ok(Code::Ok)
}

/// Writes the scene into a folder.
fn write(args: &NewArgs, folder: &Path) -> Result<PathBuf, Error> {
    let is_plain = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '_' || c == '-';
    if args.name.is_empty() || !args.name.chars().all(is_plain) {
        let problem = Problem::new(format!("`{}` cannot be the name of a scene", args.name));
        let problem = problem.because("names are made of `a` to `z`, `0` to `9`, `_` and `-`");
        return Err(Error::new(Code::Usage, problem.hint("the name alone: the file is `NAME.toml` in this folder")));
    }
    let text = match &args.splat {
        None => block(&args.name),
        Some(file) => capture(&args.name, file, args.length)?,
    };
    let path = folder.join(format!("{}.toml", args.name));
    // What is written must be a scene: one that is not says where and why.
    let source = Source { shown: path.display().to_string(), file: Some(path.clone()), text };
    parse(&source, &[], Paint::stderr())?;
    let made = OpenOptions::new().write(true).create_new(true).open(&path);
    made.and_then(|mut file| file.write_all(source.text.as_bytes())).map_err(|error| {
        let problem = Problem::new(format!("`{}` is not written", path.display())).at(&path);
        if error.kind() == io::ErrorKind::AlreadyExists {
            Error::new(Code::Usage, problem.because("it exists").hint("give another name, or remove it yourself"))
        } else {
            let hint = "go to a folder that you may write to";
            Error::new(Code::Environment, problem.because(error).hint(hint))
        }
    })?;
    Ok(path)
}

fn length(text: &str) -> Result<f64, String> {
    let number = text.trim().parse().ok().filter(|v: &f64| v.is_finite() && *v > 0.0);
    number.ok_or_else(|| "expected a positive number of metres, as in `0.45`".to_owned())
}

fn block(name: &str) -> String {
    let body = r#"
# A soft solid, made of particles. Its shape could also be a `sphere`, a `cylinder`, a `mesh = "FILE.obj"` or a capture,
# `splat = { file = "FILE.ply", metres_per_unit = 1.0, up = "-y", min_opacity = 0.02 }`: see `cosplat splat info FILE.ply`.
[[body]]
name = "block"
solver = "mpm"                        # `cosplat plugins` lists the others
material = { kind = "elastic", density = 400.0, youngs_modulus = 5.0e4, poissons_ratio = 0.3 } # kg/m³, Pa
box = [0.3, 0.3, 0.2]                 # edges
position = [0.0, 0.0, 0.1]            # of its middle
spacing = 0.02                        # of its particles: half of it costs sixteen times the time

[[body]]
name = "ball"
solver = "rigid"
material = "rigid"
sphere = 0.06                         # radius
mass = 0.5
position = [0.0, 0.0, 0.36]
velocity = [0.0, 0.0, -1.0]
"#;
    scene(name, "A rigid ball falls on a soft block", 0.6, body, "block")
}

/// A capture that stands on the floor, its longest side of that length, and a ball that comes from the right.
fn capture(name: &str, file: &Path, length_m: Option<f64>) -> Result<String, Error> {
    let read = read_some(file)?;
    let splats = &read.decoded.splats;
    let unusable = || {
        let problem = Problem::new(format!("There is nothing to see in `{}`", file.display())).at(file);
        let hint = "see what it holds with `cosplat splat info`";
        Error::new(Code::Scene, problem.because("its Gaussians are all at one place").hint(hint))
    };
    let extent = Extent::visible(splats).filter(|e| e.longest() > 0.0).ok_or_else(unusable)?;
    let metres_per_unit = length_m.map_or(1.0, |length_m| length_m / extent.longest());
    let up = splats.axes.up().unwrap_or("+z");
    let (axis, sign) = (usize::from(up.as_bytes()[1] - b'x'), if up.starts_with('-') { -1.0 } else { 1.0 });
    // The lowest point along `up`, and how far everything must be lifted for it to touch the floor.
    let lowest = if sign > 0.0 { extent.low[axis] } else { -extent.high[axis] };
    let (size, height) = (extent.longest() * metres_per_unit, extent.size()[axis] * metres_per_unit);
    let shown = toml::Value::String(file.display().to_string()).to_string();
    let [lift, spacing, scale] = [-lowest * metres_per_unit, size / ALONG, metres_per_unit].map(digits);
    let [radius, from, above] = [0.1 * size, size, 0.6 * height].map(digits);
    let mass = digits(2500.0 * 4.0 / 3.0 * std::f64::consts::PI * (0.1 * size).powi(3));
    let assumed = if length_m.is_some() { "" } else { " Assumed: say how long a unit of the file is." };
    let gaussians = splats.len();
    let size = digits(size);
    let position =
        remark(&format!("position = [0.0, 0.0, {lift}]"), "of the origin of the file: its underside is on the floor");
    let spacing = remark(&format!("spacing = {spacing}"), "of its particles: half of it costs sixteen times the time");
    let sphere = remark(&format!("sphere = {radius}"), "radius");
    let body = format!(
        r#"
# A capture of {gaussians} Gaussians. Its longest visible side is {size} m.{assumed}
[[body]]
name = "capture"
solver = "mpm"                        # soft solids as particles; `cosplat plugins` lists the others
splat = {{ file = {shown}, metres_per_unit = {scale}, up = "{up}", min_opacity = 0.02 }}
{position}
{spacing}
material = {{ kind = "elastic", density = 300.0, youngs_modulus = 5.0e5, poissons_ratio = 0.3 }} # kg/m³, Pa

[[body]]
name = "ball"
solver = "rigid"
material = "rigid"
{sphere}
mass = {mass}
position = [{from}, 0.0, {above}]
velocity = [-4.0, 0.0, 0.4]
"#
    );
    Ok(scene(name, "A captured object is hit by a ball", 1.0, &body, "capture"))
}

/// A line with a remark where the others have theirs.
fn remark(line: &str, remark: &str) -> String {
    format!("{line:<37} # {remark}")
}

/// Three digits that count, as a TOML number with a point.
fn digits(value: f64) -> String {
    let rounded = format!("{value:.2e}").parse().unwrap_or(value);
    format!("{rounded:?}")
}

/// What every scene has around its bodies; one of them is watched.
fn scene(name: &str, title: &str, duration_s: f64, bodies: &str, watched: &str) -> String {
    format!(
        r#"# {title}.
#
# Metres, kilograms, seconds; z is up. `cosplat check {name}.toml` says what a run would do, `cosplat run {name}.toml` runs
# it and leaves the result in `out/{name}`.

format = 1
name = "{name}"
title = "{title}"

[clock]
duration = {duration_s:?}
fps = 24                              # pictures, splat files and a recording; without it, numbers alone
# window = 0.001                      # longest time between two exchanges; the plan may choose a shorter one

# [output.camera]                     # without it, the camera sees all bodies
# eye = [0.5, -1.2, 0.5]
# target = [0.0, 0.0, 0.2]
# field_of_view = 40.0                # degrees
{bodies}
[[static]]
name = "floor"
plane = "infinite"                    # z = 0
wall = {{ static_friction = 0.6, kinetic_friction = 0.5 }}

[[action]]
kind = "gravity"
acceleration = [0.0, 0.0, -9.81]

[[probe]]                             # a column of probes.csv
name = "{watched}"
quantity = "position"
body = "{watched}"
"#
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use cosplat_core::scene::Source as Shape;
    use cosplat_splat::Splats;
    use cosplat_splat::format::encode;

    fn args(name: &str) -> NewArgs {
        NewArgs { name: name.to_owned(), splat: None, length: None, format: Format::Json }
    }

    fn written(path: &Path) -> cosplat_core::scene::Scene {
        let source = crate::scene_source::load(&path.to_string_lossy()).unwrap();
        let (scene, warnings) = parse(&source, &[], Paint::off()).unwrap();
        assert_eq!(warnings, []);
        scene
    }

    #[test]
    fn a_new_scene_is_a_scene_and_none_is_replaced() {
        let place = tempfile::tempdir().unwrap();
        let path = write(&args("first"), place.path()).unwrap();
        let scene = written(&path);
        assert_eq!((scene.name.as_str(), scene.bodies.len(), scene.statics.len()), ("first", 2, 1));
        let again = write(&args("first"), place.path()).unwrap_err();
        assert_eq!((again.code, again.problems[0].details[0].as_str()), (Code::Usage, "it exists"));
        let all: String = std::iter::repeat_n('a', 200).collect();
        for bad in ["", "a/b", "../a", "A", "a.toml", "a\n", &all] {
            assert!(write(&args(bad), place.path()).is_err(), "{bad}");
        }
        assert_eq!(std::fs::read_dir(place.path()).unwrap().count(), 1);
    }

    #[test]
    fn a_capture_stands_on_the_floor() {
        let place = tempfile::tempdir().unwrap();
        let splats = Splats {
            positions: vec![[0.0, -3.0, 0.0], [0.5, 1.0, 0.5]],
            rotations: vec![[1.0, 0.0, 0.0, 0.0]; 2],
            log_scales: vec![[-3.0; 3]; 2],
            opacity_logits: vec![3.0; 2],
            sh_dc: vec![[0.0; 3]; 2],
            ..Splats::default()
        };
        // −y is up in a `.ply`, +y in a `.spz`: the lowest point is one unit below the origin in both.
        for (ending, axis) in [("ply", "-y"), ("spz", "+y")] {
            let file = place.path().join(format!("it's \"quoted\".{ending}"));
            std::fs::write(&file, encode(&splats, Some(ending)).unwrap()).unwrap();
            let of = NewArgs { splat: Some(file), length: Some(0.5), ..args(&["of-", ending].concat()) };
            let scene = written(&write(&of, place.path()).unwrap());
            let Shape::Splat { metres_per_unit, up, .. } = &scene.bodies[0].source else { panic!("no capture") };
            assert_eq!((up.as_str(), *metres_per_unit), (axis, 0.125));
            assert!((scene.bodies[0].pose.position_m[2] - 0.125).abs() < 1e-9, "{:?}", scene.bodies[0].pose);
            assert_eq!(scene.bodies[0].spacing_m, Some(0.0125));
        }
        let lost = NewArgs { splat: Some(place.path().join("none.ply")), ..args("lost") };
        assert_eq!(write(&lost, place.path()).unwrap_err().code, Code::Scene);
    }
}
