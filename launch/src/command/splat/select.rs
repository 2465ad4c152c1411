//! `cosplat splat clean` and `cosplat splat select`: a part of a file, its bits untouched, and why the rest is not there.

use std::path::PathBuf;

use clap::{ArgGroup, Args};
use cosplat_splat::Splats;
use cosplat_splat::clean::{Box3, Report, Rules, clean as kept_by};
use cosplat_splat::components::{components, needle};
use cosplat_splat::format::ending_of;
use serde::Serialize;

use super::label::{Label, having, label, marked, name_of};
use super::look::vector;
use super::mask::shares;
use super::output::{Output, free, write};
use super::read_some;
use crate::cli::Format;
use crate::exit::{Code, Error, Problem};
use crate::hint::count;
use crate::render::{Paint, json, print, printable};

/// What can be seen in a picture of eight bits.
const FAINTEST: f64 = 1.0 / 255.0;

/// `cosplat splat clean`.
#[derive(Clone, Debug, Args)]
pub(crate) struct CleanArgs {
    /// Splat file to read
    #[arg(value_name = "IN")]
    pub(crate) input: PathBuf,
    /// Splat file to write: .ply, .spz or .glb
    #[arg(value_name = "OUT")]
    pub(crate) output: PathBuf,
    /// Leave out what is more transparent
    #[arg(long, value_name = "OPACITY", default_value_t = FAINTEST)]
    pub(crate) min_opacity: f64,
    /// Leave out what has a larger standard deviation, in units of the file
    #[arg(long, value_name = "SIGMA")]
    pub(crate) max_sigma: Option<f64>,
    /// Leave out what is this many times longer than it is wide
    #[arg(long, value_name = "TIMES")]
    pub(crate) needles: Option<f64>,
    /// Leave out pieces that hang together of fewer Gaussians than this
    #[arg(long, value_name = "COUNT")]
    pub(crate) floaters: Option<usize>,
    /// Gap between pieces, in units of the file [default: twice the typical distance of Gaussians]
    #[arg(long, value_name = "LENGTH")]
    pub(crate) gap: Option<f64>,
    /// Replace OUT if it exists
    #[arg(long)]
    pub(crate) force: bool,
    /// Form of the answer on standard output
    #[arg(long, value_enum, default_value_t)]
    pub(crate) format: Format,
}

/// `cosplat splat select`.
#[derive(Clone, Debug, Args)]
#[command(group(ArgGroup::new("what").required(true).multiple(true).args(["low", "largest", "mask", "label"])))]
pub(crate) struct SelectArgs {
    /// Splat file to read
    #[arg(value_name = "IN")]
    pub(crate) input: PathBuf,
    /// Splat file to write: .ply, .spz or .glb
    #[arg(value_name = "OUT")]
    pub(crate) output: PathBuf,
    /// Lower corner of a box in units and axes of the file; only what has its centre in it stays
    #[arg(long, value_name = "X,Y,Z", value_parser = vector, allow_hyphen_values = true, requires = "high")]
    pub(crate) low: Option<[f64; 3]>,
    /// Upper corner of the box
    #[arg(long, value_name = "X,Y,Z", value_parser = vector, allow_hyphen_values = true, requires = "low")]
    pub(crate) high: Option<[f64; 3]>,
    /// Of what hangs together, keep the piece with the most Gaussians; after the box
    #[arg(long)]
    pub(crate) largest: bool,
    /// Keep what is seen within this picture's white part, a PNG file; may be given for several views
    #[arg(long, value_name = "MASK.png", requires = "camera")]
    pub(crate) mask: Vec<PathBuf>,
    /// Camera of each mask, JSON: `eye`, `target`, `up` and `fov_y_deg` in axes and units of the file, or the
    /// `cameras.json` of the training, of which that of the mask's name is taken
    #[arg(long, value_name = "CAMERA.json", requires = "mask")]
    pub(crate) camera: Vec<PathBuf>,
    /// Part of what is seen of a Gaussian that must be within the masks, as a mean over the views that see it
    #[arg(long, value_name = "PART", default_value_t = 0.5)]
    pub(crate) share: f64,
    /// Keep what has this label, a property of a .ply; several must all be had
    #[arg(long, value_name = "NAME=VALUE", value_parser = label)]
    pub(crate) label: Vec<Label>,
    /// Leave nothing out: write a label of this name, 1 for what would stay and 0 for the rest; OUT is a .ply
    #[arg(long, value_name = "NAME", value_parser = name_of)]
    pub(crate) mark: Option<String>,
    /// Gap between pieces, in units of the file [default: twice the typical distance of Gaussians]
    #[arg(long, value_name = "LENGTH")]
    pub(crate) gap: Option<f64>,
    /// Replace OUT if it exists
    #[arg(long)]
    pub(crate) force: bool,
    /// Form of the answer on standard output
    #[arg(long, value_enum, default_value_t)]
    pub(crate) format: Format,
}

/// What became of a file. A Gaussian counts under the first reason that applies.
#[derive(Debug, Default, PartialEq, Serialize)]
struct Chosen {
    status: &'static str,
    input: String,
    output: String,
    gaussians: usize,
    kept: usize,
    not_finite: usize,
    faint: usize,
    outside: usize,
    /// Without the labels that were asked for.
    unlabelled: usize,
    /// Seen outside the masks, or not at all.
    unmasked: usize,
    large: usize,
    needles: usize,
    floaters: usize,
    /// Label that tells them from the rest, where nothing was left out.
    #[serde(skip_serializing_if = "Option::is_none")]
    mark: Option<String>,
    /// Pieces before floaters or all but the largest were left out.
    #[serde(skip_serializing_if = "Option::is_none")]
    pieces: Option<usize>,
    /// Largest gap within a piece, in units of the file.
    #[serde(skip_serializing_if = "Option::is_none")]
    gap: Option<f64>,
}

/// Leaves out what is no object.
///
/// # Errors
/// The file cannot be used, nothing is left, or the result cannot be written.
pub(super) fn clean(args: &CleanArgs) -> Result<Code, Error> {
    say(&cleaned(args)?, args.format)
}

/// Keeps a part.
///
/// # Errors
/// As [`clean`].
pub(super) fn select(args: &SelectArgs) -> Result<Code, Error> {
    say(&selected(args)?, args.format)
}

fn say(chosen: &Chosen, format: Format) -> Result<Code, Error> {
    match format {
        Format::Json => print(&json(chosen)?)?,
        Format::Human => print(&chosen.human(Paint::stdout()))?,
    }
    Ok(Code::Ok)
}

fn cleaned(args: &CleanArgs) -> Result<Chosen, Error> {
    let place = Output { from: &args.input, to: &args.output, force: args.force };
    let rules = Rules { opacity: args.min_opacity, inside: None, largest_sigma: args.max_sigma };
    let (splats, mut chosen) = opened(&place, &rules)?;
    let slim = |i: &u32| args.needles.is_none_or(|limit| needle(&splats, *i as usize) <= limit);
    let kept: Vec<u32> = (0..splats.len() as u32).filter(slim).collect();
    chosen.needles = splats.len() - kept.len();
    let splats = if chosen.needles > 0 { splats.select(&kept) } else { splats };
    let Some(least) = args.floaters else { return chosen.written(&place, &splats) };
    let found = components(&splats, args.gap);
    let large = found.sets.iter().filter(|set| set.len() >= least);
    let mut stays: Vec<u32> = large.flatten().copied().collect();
    stays.sort_unstable();
    (chosen.pieces, chosen.gap) = (Some(found.sets.len()), Some(found.cell));
    chosen.floaters = splats.len() - stays.len();
    chosen.written(&place, &splats.select(&stays))
}

fn selected(args: &SelectArgs) -> Result<Chosen, Error> {
    let place = Output { from: &args.input, to: &args.output, force: args.force };
    if args.mark.is_some() && ending_of(&args.output).is_none_or(|e| !e.eq_ignore_ascii_case("ply")) {
        let problem = Problem::new(format!("`{}` cannot hold a label", args.output.display())).at(&args.output);
        return Err(Error::new(Code::Usage, problem.hint("give OUT the ending `.ply`, which keeps properties")));
    }
    free(&place)?;
    let inside = args.low.zip(args.high).map(|(low, high)| Box3::from_corners(low, high));
    let splats = read_some(place.from)?.decoded.splats;
    let (kept, report) = kept_by(&splats, &Rules { opacity: 0.0, inside, largest_sigma: None });
    let mut chosen = Chosen::of(&place, &report);
    let before = kept.len();
    let mut kept = having(kept, &splats, &args.label, &args.input)?;
    chosen.unlabelled = before - kept.len();
    if !args.mask.is_empty() {
        let shares = shares(&splats, &args.mask, &args.camera)?;
        let before = kept.len();
        kept.retain(|&i| shares[i as usize].is_some_and(|share| share >= args.share));
        chosen.unmasked = before - kept.len();
    }
    if args.largest {
        let found = components(&splats.select(&kept), args.gap);
        (chosen.pieces, chosen.gap) = (Some(found.sets.len()), Some(found.cell));
        let largest = found.sets.first().map_or(&[][..], Vec::as_slice);
        chosen.floaters = kept.len() - largest.len();
        kept = largest.iter().map(|&i| kept[i as usize]).collect();
    }
    match &args.mark {
        Some(name) if !kept.is_empty() => {
            chosen.kept = kept.len();
            chosen.mark = Some(name.clone());
            write(place.to, &marked(splats, &kept, name))?;
            Ok(chosen)
        }
        _ => chosen.written(&place, &splats.select(&kept)),
    }
}

/// Reads a file and applies the rules that look at one Gaussian alone.
fn opened(place: &Output<'_>, rules: &Rules) -> Result<(Splats, Chosen), Error> {
    free(place)?;
    let splats = read_some(place.from)?.decoded.splats;
    let (kept, report) = kept_by(&splats, rules);
    Ok((splats.select(&kept), Chosen::of(place, &report)))
}

impl Chosen {
    /// What the rules that look at one Gaussian alone left out.
    fn of(place: &Output<'_>, report: &Report) -> Self {
        Self {
            status: "ok",
            input: place.from.display().to_string(),
            output: place.to.display().to_string(),
            gaussians: report.total,
            not_finite: report.non_finite,
            faint: report.faint,
            outside: report.outside,
            large: report.large,
            ..Self::default()
        }
    }

    /// Writes what is left.
    fn written(mut self, place: &Output<'_>, splats: &Splats) -> Result<Self, Error> {
        self.kept = splats.len();
        if splats.is_empty() {
            let problem = Problem::new(format!("Nothing of `{}` is left", self.input)).at(place.from);
            return Err(Error::new(Code::Scene, problem.because(self.reasons()).hint("widen what may stay")));
        }
        write(place.to, splats)?;
        Ok(self)
    }

    fn reasons(&self) -> String {
        let Self { not_finite, faint, outside, unlabelled, unmasked, large, needles, floaters, .. } = self;
        let verb = if self.mark.is_some() { "not marked" } else { "left out" };
        format!(
            "{verb}: {not_finite} not finite, {faint} faint, {outside} outside, {unlabelled} without the label, {unmasked} \
             outside the masks, {large} large, {needles} needles, {floaters} apart from the rest"
        )
    }

    fn human(&self, paint: Paint) -> String {
        let pieces = self.pieces.zip(self.gap).map(|(pieces, gap)| {
            format!("{}, of what is less than {gap:.3e} units apart\n", count(pieces, "piece", "pieces"))
        });
        format!(
            "{}: {} of {}\n{}\n{}",
            paint.bold(&printable(&self.output)),
            self.kept,
            count(self.gaussians, "Gaussian", "Gaussians"),
            self.reasons(),
            pieces.unwrap_or_default()
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::command::splat::read;
    use cosplat_splat::format::encode;
    use cosplat_viewer::{Picture, png};

    /// A block of 125, one of 25 elsewhere, a needle and a faint one.
    fn some() -> Splats {
        let block = |at: f32, n: usize| {
            (0..n).map(move |i| [at + (i % 5) as f32 * 0.1, (i / 5 % 5) as f32 * 0.1, (i / 25) as f32 * 0.1])
        };
        let positions: Vec<[f32; 3]> = block(0.0, 125).chain(block(5.0, 25)).chain([[0.1; 3], [0.2; 3]]).collect();
        let n = positions.len();
        let mut splats = Splats {
            rotations: vec![[1.0, 0.0, 0.0, 0.0]; n],
            log_scales: vec![[-4.0; 3]; n],
            opacity_logits: vec![3.0; n],
            sh_dc: vec![[0.0; 3]; n],
            positions,
            ..Splats::default()
        };
        splats.log_scales[150] = [0.0, -6.0, -6.0];
        splats.opacity_logits[151] = -9.0;
        splats
    }

    #[test]
    fn parts_are_written_and_the_rest_is_counted() {
        let place = tempfile::tempdir().unwrap();
        let [input, output] = ["a.ply", "b.ply"].map(|name| place.path().join(name));
        std::fs::write(&input, encode(&some(), Some("ply")).unwrap()).unwrap();
        let clean = CleanArgs {
            input: input.clone(),
            output: output.clone(),
            min_opacity: FAINTEST,
            max_sigma: None,
            needles: Some(30.0),
            floaters: Some(30),
            gap: None,
            force: false,
            format: Format::Json,
        };
        let done = cleaned(&clean).unwrap();
        assert_eq!((done.gaussians, done.kept, done.faint, done.needles, done.floaters), (152, 125, 1, 1, 25));
        let first: Vec<u32> = (0..125).collect();
        assert_eq!(read(&output).unwrap().decoded.splats, some().select(&first), "bit by bit");
        assert_eq!(cleaned(&clean).unwrap_err().code, Code::Usage, "it exists");
        let select = SelectArgs {
            input: input.clone(),
            output,
            low: Some([4.0, -1.0, -1.0]),
            high: Some([6.0, 1.0, 1.0]),
            largest: true,
            label: Vec::new(),
            mask: Vec::new(),
            camera: Vec::new(),
            share: 0.5,
            mark: None,
            gap: None,
            force: true,
            format: Format::Json,
        };
        let done = selected(&select).unwrap();
        assert_eq!((done.kept, done.outside, done.pieces), (25, 127, Some(1)));
        let nowhere = SelectArgs { low: Some([9.0; 3]), high: Some([10.0; 3]), ..select.clone() };
        assert_eq!(selected(&nowhere).unwrap_err().code, Code::Scene);
        // Nothing left out, but told apart; and by that label it is found again.
        let marked = place.path().join("c.ply");
        let mark = SelectArgs { output: marked.clone(), mark: Some("box".to_owned()), ..select.clone() };
        assert_eq!(selected(&mark).unwrap().kept, 25);
        let all = read(&marked).unwrap().decoded.splats;
        assert_eq!((all.len(), all.extras[0].values.iter().sum::<f64>()), (152, 25.0));
        let label = vec![super::label("box=1").unwrap()];
        let found =
            SelectArgs { input: marked.clone(), label, low: None, high: None, largest: false, ..select.clone() };
        let done = selected(&found).unwrap();
        assert_eq!((done.kept, done.unlabelled), (25, 127));
        let none = SelectArgs { label: vec![super::label("other=1").unwrap()], ..found };
        assert_eq!(selected(&none).unwrap_err().code, Code::Scene);
        // The block on the left, by what a camera sees of it: right half of the picture dark, left half white.
        let [white, eye] = ["mask.png", "camera.json"].map(|name| place.path().join(name));
        let half = |i: usize| if i % 320 < 160 { [1.0; 4] } else { [0.0, 0.0, 0.0, 1.0] };
        let picture = Picture { width: 320, height: 240, rgba: (0..320 * 240).map(half).collect(), depth: Vec::new() };
        png::write(&white, &picture).unwrap();
        let camera = r#"{"eye": [2.5, 0.2, -8], "target": [2.5, 0.2, 0], "up": [0, -1, 0], "fov_y_deg": 50}"#;
        std::fs::write(&eye, camera).unwrap();
        let masked = SelectArgs {
            low: None,
            high: None,
            largest: false,
            mask: vec![white],
            camera: vec![eye],
            mark: Some("block".to_owned()),
            output: marked.clone(),
            ..select.clone()
        };
        // All of its front, three pixels from one to the next; nothing of the other block, and not what no picture shows.
        let done = selected(&masked).unwrap();
        let all = read(&marked).unwrap().decoded.splats;
        let values = &all.extras[0].values;
        assert!(
            values[..25].iter().all(|v| *v > 0.5) && values[125..150].iter().all(|v| *v < 0.5) && values[151] < 0.5
        );
        assert_eq!(done.kept + done.unmasked, 152);
        let lonely = SelectArgs { camera: Vec::new(), ..masked };
        assert_eq!(selected(&lonely).unwrap_err().code, Code::Usage);
        let packed = SelectArgs { output: place.path().join("c.spz"), ..mark };
        assert_eq!(selected(&packed).unwrap_err().code, Code::Usage);
        let itself = SelectArgs { output: input, ..select };
        assert_eq!(selected(&itself).unwrap_err().code, Code::Usage);
    }
}
