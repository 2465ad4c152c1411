//! `cosplat splat flow`: how the picture moves from one splat file to the next.

use std::path::PathBuf;

use clap::Args;
use cosplat_splat::{SH_C0, Splats};
use cosplat_viewer::{Layers, Next, Plane};
use serde::Serialize;

use super::look::{LookArgs, borrowed, camera, finite, options, unusable, vector};
use super::planes::Wanted;
use super::read_some;
use super::renderer::{RendererName, cannot};
use super::statistics::Extent;
use crate::cli::Format;
use crate::exit::{Code, Error, Problem};
use crate::render::{Paint, json, print, printable};

/// Difference of a colour or an opacity, both 0 to 1, that no format makes: five steps of 255.
const SHADES: f64 = 0.02;
/// Logarithm of the factor by which the volume of a Gaussian changes in no step: 8, twice along each axis.
const STRETCH: f64 = 2.08;
/// Part of the Gaussians that may be unlike themselves before their order is doubted.
const DOUBT: f64 = 0.1;

/// `cosplat splat flow`.
#[derive(Clone, Debug, Args)]
pub(crate) struct FlowArgs {
    /// Splat file of the moment that is drawn
    #[arg(value_name = "FILE")]
    pub(crate) file: PathBuf,
    /// Splat file of the next moment: the same Gaussians in the same order
    #[arg(value_name = "NEXT")]
    pub(crate) next: PathBuf,
    /// Flow to write: a .flo, a .npy or a .png as in KITTI; one that exists is replaced
    #[arg(value_name = "OUT")]
    pub(crate) output: PathBuf,
    /// Camera
    #[command(flatten)]
    pub(crate) look: LookArgs,
    /// Where the camera stands at the next moment [default: where it stood]
    #[arg(long, value_name = "X,Y,Z", value_parser = vector, allow_hyphen_values = true)]
    pub(crate) next_eye: Option<[f64; 3]>,
    /// Where it looks at the next moment [default: where it looked]
    #[arg(long, value_name = "X,Y,Z", value_parser = vector, allow_hyphen_values = true)]
    pub(crate) next_target: Option<[f64; 3]>,
    /// Who draws
    #[arg(long, value_enum, default_value_t)]
    pub(crate) renderer: RendererName,
    /// Form of the answer on standard output
    #[arg(long, value_enum, default_value_t)]
    pub(crate) format: Format,
}

/// The flow that was made.
#[derive(Debug, Serialize)]
struct Flowed {
    status: &'static str,
    output: String,
    size_px: [usize; 2],
    gaussians: usize,
    /// Part of the pixels that have a flow.
    seen: f64,
    /// Of the pixels that have one: mean, 95 of 100, largest.
    mean_px: f64,
    p95_px: f64,
    largest_px: f64,
    /// Gaussians of another colour, opacity or size in the second file.
    unlike: usize,
    renderer: &'static str,
    drawn_by: String,
}

/// Writes the flow between two splat files.
///
/// # Errors
/// A file cannot be used, they do not hold the same Gaussians, or the flow cannot be written.
pub(super) fn flow(args: &FlowArgs) -> Result<Code, Error> {
    let flowed = flowed(args)?;
    match args.format {
        Format::Json => print(&json(&flowed)?)?,
        Format::Human => print(&flowed.human(Paint::stdout()))?,
    }
    Ok(Code::Ok)
}

fn flowed(args: &FlowArgs) -> Result<Flowed, Error> {
    let wanted = Wanted::new(Plane::Flow, &args.output)?;
    let (now, then) = pair(args)?;
    let Some(extent) = Extent::visible(&now) else {
        let problem = Problem::new(format!("There is nothing to draw in `{}`", args.file.display())).at(&args.file);
        return Err(Error::new(Code::Scene, problem.because("no Gaussian has a finite place in both files")));
    };
    let camera = camera(&args.look, &now, &extent);
    let later = cosplat_viewer::Camera {
        eye: args.next_eye.unwrap_or(camera.eye),
        target: args.next_target.unwrap_or(camera.target),
        ..camera
    };
    let [view, next_view] = [camera.view().map_err(|e| unusable(&e))?, later.view().map_err(|e| unusable(&e))?];
    let next = Next { positions: vec![&then.positions], view: next_view };
    let mut renderer = args.renderer.open()?;
    let layers = renderer.render_layers(&[borrowed(&now)], &view, &options(&camera, [0.0; 3]), Some(&next));
    let layers = layers.map_err(|e| cannot(&e))?;
    wanted.write(&layers)?;
    let [mean_px, p95_px, largest_px, seen] = figures(&layers);
    Ok(Flowed {
        status: "ok",
        output: args.output.display().to_string(),
        size_px: args.look.size,
        gaussians: now.len(),
        seen,
        mean_px,
        p95_px,
        largest_px,
        unlike: unlike(&now, &then),
        renderer: renderer.name(),
        drawn_by: renderer.why().to_owned(),
    })
}

/// The Gaussians that are finite in both files, in the axes of the first.
fn pair(args: &FlowArgs) -> Result<(Splats, Splats), Error> {
    let now = read_some(&args.file)?.decoded.splats;
    let then = read_some(&args.next)?.decoded.splats.to_axes(now.axes);
    if now.len() != then.len() {
        let counts = format!("the first has {} Gaussians and the second {}", now.len(), then.len());
        let problem = Problem::new("There is no flow between these files").at(&args.next).because(counts);
        let hint = "give two frames of one run, or files with the same Gaussians in the same order";
        return Err(Error::new(Code::Scene, problem.hint(hint)));
    }
    let here = finite(&now);
    let there: std::collections::BTreeSet<u32> = finite(&then).into_iter().collect();
    let both: Vec<u32> = here.into_iter().filter(|i| there.contains(i)).collect();
    Ok((now.select(&both), then.select(&both)))
}

/// Gaussians of another colour, opacity or size in the second file, beyond what formats round and a step stretches.
fn unlike(now: &Splats, then: &Splats) -> usize {
    let shade = |s: &Splats, i: usize| s.sh_dc[i].map(|c| SH_C0 * f64::from(c));
    let volume = |s: &Splats, i: usize| s.log_scales[i].iter().map(|v| f64::from(*v)).sum::<f64>();
    let other = |i: &usize| {
        let colours = shade(now, *i).into_iter().zip(shade(then, *i));
        colours.fold(0.0, |most: f64, (a, b)| most.max((a - b).abs())) > SHADES
            || (now.opacity(*i) - then.opacity(*i)).abs() > SHADES
            || (volume(now, *i) - volume(then, *i)).abs() > STRETCH
    };
    (0..now.len()).filter(other).count()
}

/// Mean, 95 of 100 and largest length, and the part of the pixels that have a flow.
fn figures(layers: &Layers) -> [f64; 4] {
    let flows = layers.flow.iter().filter(|f| !f[0].is_nan());
    let mut lengths: Vec<f64> = flows.map(|[u, v]| f64::from(*u).hypot(f64::from(*v))).collect();
    lengths.sort_by(f64::total_cmp);
    let Some(&largest) = lengths.last() else { return [0.0; 4] };
    let mean = lengths.iter().sum::<f64>() / lengths.len() as f64;
    // By nearest rank.
    let p95 = lengths[(lengths.len() * 95).div_ceil(100) - 1];
    [mean, p95, largest, lengths.len() as f64 / layers.flow.len() as f64]
}

impl Flowed {
    fn human(&self, paint: Paint) -> String {
        let [width, height] = self.size_px;
        let doubt = if self.unlike as f64 > DOUBT * self.gaussians as f64 {
            let text = "have another colour, opacity or size in the second file: if its Gaussians are in another order, this \
                        flow means nothing";
            format!("{} {} of {} {text}\n", paint.warn("suspicious:"), self.unlike, self.gaussians)
        } else {
            String::new()
        };
        format!(
            "{}: {width} x {height}, {} Gaussians, {:.1} % of the pixels see one\n  moves by {:.3} pixels in the mean, \
             {:.3} at most in 95 of 100, {:.3} at most\n  drawn by {}\n{doubt}",
            paint.bold(&printable(&self.output)),
            self.gaussians,
            100.0 * self.seen,
            self.mean_px,
            self.p95_px,
            self.largest_px,
            printable(&self.drawn_by)
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use cosplat_splat::format::encode;

    fn args(folder: &std::path::Path, output: &str) -> FlowArgs {
        FlowArgs {
            file: folder.join("a.ply"),
            next: folder.join("b.ply"),
            output: folder.join(output),
            look: LookArgs { eye: Some([0.0, 0.0, -2.0]), target: Some([0.0; 3]), ..LookArgs::of_size([64, 48]) },
            next_eye: None,
            next_target: None,
            renderer: RendererName::Cpu,
            format: Format::Json,
        }
    }

    #[test]
    fn a_step_to_the_side_is_seen_in_every_form() {
        let place = tempfile::tempdir().unwrap();
        let one = Splats {
            positions: vec![[0.0, 0.0, 0.0], [f32::NAN, 0.0, 0.0]],
            rotations: vec![[1.0, 0.0, 0.0, 0.0]; 2],
            log_scales: vec![[-2.0; 3]; 2],
            opacity_logits: vec![4.0; 2],
            sh_dc: vec![[0.0; 3]; 2],
            ..Splats::default()
        };
        let two = Splats { positions: vec![[0.1, 0.05, 0.0]; 2], ..one.clone() };
        for (name, splats) in [("a.ply", &one), ("b.ply", &two), ("c.ply", &one.select(&[0]))] {
            std::fs::write(place.path().join(name), encode(splats, Some("ply")).unwrap()).unwrap();
        }
        // The focal length of 48 pixels at 40 degrees is 65.94, and the distance 2.
        let focal = 24.0 / 20.0_f64.to_radians().tan();
        let exact = focal * 0.1_f64.hypot(0.05) / 2.0;
        for output in ["flow.flo", "flow.npy", "flow.png"] {
            let flowed = flowed(&args(place.path(), output)).unwrap();
            assert_eq!(flowed.gaussians, 1);
            assert!((flowed.mean_px - exact).abs() < 1e-4 && (flowed.largest_px - exact).abs() < 1e-4, "{flowed:?}");
            assert!(flowed.seen > 0.05 && flowed.seen < 0.95);
        }
        let flo = std::fs::read(place.path().join("flow.flo")).unwrap();
        assert_eq!((&flo[..4], flo.len()), (&b"PIEH"[..], 12 + 8 * 64 * 48));
        let other = FlowArgs { next: place.path().join("c.ply"), ..args(place.path(), "flow.flo") };
        assert_eq!(flowed(&other).unwrap_err().code, Code::Scene);
        assert_eq!(flowed(&args(place.path(), "flow.jpg")).unwrap_err().code, Code::Usage);
        // Two captures that are alike in number alone.
        assert_eq!(unlike(&one, &two), 0);
        let shuffled = Splats { log_scales: vec![[-3.0; 3]; 2], ..one.clone() };
        assert_eq!(unlike(&one, &shuffled), 2);
        // A camera that follows sees nothing move: +x of the file is to the right seen along +z, with y down.
        let along = FlowArgs {
            next_eye: Some([0.1, 0.05, -2.0]),
            next_target: Some([0.1, 0.05, 0.0]),
            ..args(place.path(), "flow.npy")
        };
        assert!(flowed(&along).unwrap().largest_px < 1e-4);
    }
}
