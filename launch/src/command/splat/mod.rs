//! `cosplat splat`: what a splat file holds, the same in another format, a picture of it.

mod compare;
mod convert;
pub(crate) mod cut;
mod densify;
mod drop;
mod fallen;
mod fill;
mod flow;
mod guess;
mod info;
mod label;
pub(crate) mod look;
mod mask;
mod orient;
mod output;
mod picture;
mod planes;
mod renderer;
mod select;
mod sequence;
mod ssim;
pub(crate) mod statistics;

use std::ffi::OsString;
use std::fs;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use clap::{Args, Subcommand};
use cosplat_splat::SplatError;
use cosplat_splat::format::{self, Decoded, ending_of};
use cosplat_splat::sequence::is_frame;

use self::look::finite;
use crate::cli::Format;
use crate::exit::{Code, Error, Problem};

const EXAMPLES: &str = "\
Examples:
  cosplat splat info capture.ply                is it what it should be? which way is up? how large?
  cosplat splat convert capture.sog capture.ply
  cosplat splat convert capture.spz capture.glb   glTF with KHR_gaussian_splatting
  cosplat splat render capture.spz capture.png --eye 0,0.4,2 --size 1280x720
  cosplat splat render capture.spz around.png --orbit 36 --size 480x360
  cosplat splat clean capture.ply clean.ply --needles 30 --floaters 20
  cosplat splat select capture.ply object.ply --largest
  cosplat splat select capture.ply marked.ply --largest --mark object    and `--label object=1` finds it again
  cosplat splat select capture.ply object.ply --mask mask.png --camera camera.json
  cosplat splat fill capture.spz --compare fill.png --metres-per-unit 0.465
  cosplat splat orient capture.spz upright.ply --up 0,1,0 --height 0.465
  cosplat splat densify capture.ply closed.ply --mesh ground.obj --depth 5
  cosplat splat flow out/NAME/splats/frame_0010.ply out/NAME/splats/frame_0011.ply flow.flo
  cosplat splat compare capture.ply capture.spz";

/// Largest file that is read: larger captures do not fit into memory with what is made of them.
const LARGEST_BYTES: u64 = 4 << 30;

/// `cosplat splat`.
#[derive(Clone, Debug, Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct SplatArgs {
    /// What to do with the file
    #[command(subcommand)]
    pub(crate) command: SplatCommand,
}

/// Commands about splat files.
#[derive(Clone, Debug, Subcommand)]
pub(crate) enum SplatCommand {
    /// Say what a splat file holds, and what looks wrong about it
    Info(info::InfoArgs),
    /// Write a splat file in the format of another ending, and say what that loses
    Convert(convert::ConvertArgs),
    /// Draw a splat file as PNG
    Render(picture::RenderArgs),
    /// Leave out what is faint, too large, a needle or a floater, and say how many of each
    Clean(select::CleanArgs),
    /// Keep what is in a box, or what hangs together and is largest
    Select(select::SelectArgs),
    /// Fill a capture with particles in three ways, and say and draw how they differ
    Fill(fill::FillArgs),
    /// Find the ground, which way is up and how long a metre is, and write the capture upright
    Orient(orient::OrientArgs),
    /// Close the holes of a captured environment with transparent Gaussians, and write its surface as a mesh
    Densify(densify::DensifyArgs),
    /// Say and write how far each pixel moves from one splat file to the next
    Flow(flow::FlowArgs),
    /// Say how two splat files differ, or a splat file and a picture
    Compare(compare::CompareArgs),
}

impl SplatArgs {
    /// Form of the answer on standard output.
    pub(crate) fn format(&self) -> Format {
        match &self.command {
            SplatCommand::Info(args) => args.format,
            SplatCommand::Convert(args) => args.format,
            SplatCommand::Render(args) => args.format,
            SplatCommand::Clean(args) => args.format,
            SplatCommand::Select(args) => args.format,
            SplatCommand::Fill(args) => args.format,
            SplatCommand::Densify(args) => args.format,
            SplatCommand::Orient(args) => args.format,
            SplatCommand::Flow(args) => args.format,
            SplatCommand::Compare(args) => args.format,
        }
    }
}

/// Looks at, converts or draws a splat file.
///
/// # Errors
/// The file cannot be used, or the result cannot be written.
pub(crate) fn splat(args: &SplatArgs) -> Result<Code, Error> {
    match &args.command {
        SplatCommand::Info(args) => info::info(args),
        SplatCommand::Convert(args) => convert::convert(args),
        SplatCommand::Render(args) => picture::render(args),
        SplatCommand::Clean(args) => select::clean(args),
        SplatCommand::Select(args) => select::select(args),
        SplatCommand::Fill(args) => fill::fill(args),
        SplatCommand::Orient(args) => orient::orient(args),
        SplatCommand::Densify(args) => densify::densify(args),
        SplatCommand::Flow(args) => flow::flow(args),
        SplatCommand::Compare(args) => compare::compare(args),
    }
}

/// A decoded file.
pub(crate) struct Capture {
    /// Name of its format.
    pub(crate) format: &'static str,
    /// Bytes of the file.
    pub(crate) bytes: u64,
    /// Gaussians and remarks.
    pub(crate) decoded: Decoded,
    /// How long reading and decoding took.
    pub(crate) time: Duration,
}

/// Reads a splat file.
///
/// # Errors
/// There is no such file, or it is no splat file, or it is damaged.
pub(crate) fn read(path: &Path) -> Result<Capture, Error> {
    let start = Instant::now();
    let cannot = |why: &dyn std::fmt::Display| {
        let problem = Problem::new(format!("Cannot read `{}`", path.display())).at(path).because(why);
        Error::new(Code::Scene, problem.hint("check the path and its permissions"))
    };
    let about = fs::metadata(path).map_err(|e| cannot(&e))?;
    if about.is_dir() {
        return Err(cannot(&"it is a folder, not a file"));
    }
    if !about.is_file() || about.len() > LARGEST_BYTES {
        return Err(cannot(&format!("it is no file of at most {LARGEST_BYTES} bytes")));
    }
    let bytes = fs::read(path).map_err(|e| cannot(&e))?;
    if bytes.is_empty() {
        let problem = Problem::new(format!("Cannot use the splat file `{}`", path.display())).at(path);
        let hint = "copy or download the file again, or see whether what writes it has ended";
        return Err(Error::new(Code::Scene, problem.because("it is empty: 0 bytes").hint(hint)));
    }
    if is_frame(&bytes) {
        let decoded = sequence::decode(path, &bytes)?;
        return Ok(Capture { format: sequence::NAME, bytes: bytes.len() as u64, decoded, time: start.elapsed() });
    }
    let ending = ending_of(path);
    let known = format::of(&bytes, ending).map_err(|e| refused(path, e))?;
    let decoded = format::read(&bytes, ending).map_err(|e| refused(path, e))?;
    Ok(Capture { format: known.name, bytes: bytes.len() as u64, decoded, time: start.elapsed() })
}

/// Reads a splat file of which something has to be left.
///
/// # Errors
/// As [`read`], or none of its Gaussians is one: there are none, or each has a number that is none.
pub(crate) fn read_some(path: &Path) -> Result<Capture, Error> {
    let capture = read(path)?;
    let splats = &capture.decoded.splats;
    if !finite(splats).is_empty() {
        return Ok(capture);
    }
    let why = if splats.is_empty() {
        "it holds no Gaussian".to_owned()
    } else {
        format!("each of its {} Gaussians has a number that is none", splats.len())
    };
    let problem = Problem::new(format!("There is nothing to use in `{}`", path.display())).at(path).because(why);
    let hint = "see what it holds with `cosplat splat info`, and write it again with the tool it came from";
    Err(Error::new(Code::Scene, problem.hint(hint)))
}

/// What a codec says about a file, as a problem of this program.
fn refused(path: &Path, error: SplatError) -> Error {
    let problem = Problem::new(format!("Cannot use the splat file `{}`", path.display()))
        .at(path)
        .because(format!("{}: {}", error.place, error.what));
    Error::new(Code::Scene, problem.hint(error.advice))
}

/// Puts a whole file in place: readers see the old one or the new one, never a part.
pub(crate) fn put(path: &Path, bytes: &[u8]) -> Result<(), Error> {
    let mut name = OsString::from(".part-");
    name.push(path.file_name().unwrap_or_default());
    let part: PathBuf = path.with_file_name(name);
    fs::write(&part, bytes).and_then(|()| fs::rename(&part, path)).map_err(|error| {
        // What is left of it is of no use; that it cannot be removed is no second problem.
        let _ = fs::remove_file(&part);
        let problem = Problem::new(format!("Cannot write `{}`", path.display())).at(path).because(error);
        Error::new(
            Code::Environment,
            problem.hint("check that the folder exists, that you may write to it and its room"),
        )
    })
}
