//! `cosplat splat render`: a picture of a file.

use std::path::PathBuf;

use clap::Args;
use cosplat_viewer::{Preview, PreviewOptions, Shot, Travel, png};
use serde::Serialize;

use super::look::{LARGEST_PX, LookArgs, borrowed, camera, finite, options, unusable, vector};
use super::planes::PlaneArgs;
use super::renderer::{RendererName, cannot};
use super::statistics::Extent;
use super::{put, read_some};
use crate::cli::Format;
use crate::exit::{Code, Error, Problem};
use crate::render::{Paint, json, print, printable};

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
    /// Camera
    #[command(flatten)]
    pub(crate) look: LookArgs,
    /// Colour behind everything, red, green and blue in display values from 0 to 1
    #[arg(long, value_name = "R,G,B", value_parser = vector, default_value = "1,1,1")]
    pub(crate) background: [f64; 3],
    /// Take this many pictures on a circle around the target and about what is up, as an animated PNG
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(2..=MOST_PICTURES))]
    pub(crate) orbit: Option<u16>,
    /// Beside it
    #[command(flatten)]
    pub(crate) planes: PlaneArgs,
    /// Who draws
    #[arg(long, value_enum, default_value_t)]
    pub(crate) renderer: RendererName,
    /// Form of the answer on standard output
    #[arg(long, value_enum, default_value_t)]
    pub(crate) format: Format,
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
    planes: Vec<String>,
    renderer: &'static str,
    #[serde(rename = "drawn_by")]
    by: String,
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
    let planes = args.planes.wanted()?;
    let splats = read_some(&args.file)?.decoded.splats;
    let kept = finite(&splats);
    let splats = if kept.len() < splats.len() { splats.select(&kept) } else { splats };
    let Some(extent) = Extent::visible(&splats) else {
        let problem = Problem::new(format!("There is nothing to draw in `{}`", args.file.display())).at(&args.file);
        return Err(Error::new(Code::Scene, problem.because("no Gaussian has a finite place")));
    };
    let camera = camera(&args.look, &splats, &extent);
    camera.view().map_err(|e| unusable(&e))?;
    let options = options(&camera, args.background);
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
    let mut renderer = args.renderer.open()?;
    for number in 0..count {
        let view = shot.at(f64::from(number)).view().map_err(|e| unusable(&e))?;
        let sets = [borrowed(&splats)];
        let picture = if planes.is_empty() {
            renderer.render(&sets, &view, &options).map_err(|e| cannot(&e))?
        } else {
            let layers = renderer.render_layers(&sets, &view, &options, None).map_err(|e| cannot(&e))?;
            planes.iter().try_for_each(|plane| plane.write(&layers))?;
            layers.picture
        };
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
        size_px: args.look.size,
        eye: camera.eye,
        target: camera.target,
        up: camera.up,
        field_of_view_deg: camera.fov_y_deg,
        gaussians: splats.len(),
        pictures: count,
        planes: planes.iter().map(|plane| plane.path.display().to_string()).collect(),
        renderer: renderer.name(),
        by: renderer.why().to_owned(),
    })
}

impl Drawn {
    fn human(&self, paint: Paint) -> String {
        let [width, height] = self.size_px;
        let vector = |v: [f64; 3]| v.map(|c| format!("{c:.4}")).join(",");
        format!(
            "{}: {width} x {height}, {} Gaussians\n  --eye {} --target {} --up {} --fov {}\n  drawn by {}\n",
            paint.bold(&printable(&self.output)),
            self.gaussians,
            vector(self.eye),
            vector(self.target),
            vector(self.up),
            self.field_of_view_deg,
            printable(&self.by)
        )
    }
}

pub(super) fn picture_name(text: &str) -> Result<PathBuf, String> {
    let path = PathBuf::from(text);
    let is_png = path.extension().is_some_and(|e| e.eq_ignore_ascii_case("png"));
    if is_png { Ok(path) } else { Err("expected a file name that ends with `.png`".to_owned()) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use cosplat_splat::Splats;
    use cosplat_splat::format::encode;

    fn args(folder: &std::path::Path) -> RenderArgs {
        RenderArgs {
            file: folder.join("a.spz"),
            output: folder.join("a.png"),
            look: LookArgs::of_size([64, 48]),
            background: [0.0; 3],
            orbit: None,
            planes: PlaneArgs::default(),
            renderer: RendererName::default(),
            format: Format::Json,
        }
    }

    fn two() -> Splats {
        Splats {
            positions: vec![[5.0, 5.0, 5.0], [6.0, 5.5, 7.0]],
            rotations: vec![[1.0, 0.0, 0.0, 0.0]; 2],
            log_scales: vec![[-3.0; 3]; 2],
            opacity_logits: vec![5.0; 2],
            sh_dc: vec![[1.5, 0.0, -1.5]; 2],
            ..Splats::default()
        }
    }

    #[test]
    fn by_products_are_written_beside_the_picture() {
        let place = tempfile::tempdir().unwrap();
        let file = |name: &str| Some(place.path().join(name));
        let planes = PlaneArgs { alpha: file("alpha.png"), depth: file("depth.npy"), normal: file("normal.png") };
        let args = RenderArgs { planes, ..args(place.path()) };
        std::fs::write(&args.file, encode(&two(), Some("spz")).unwrap()).unwrap();
        assert_eq!(drawn(&args).unwrap().planes.len(), 3);
        let depth = std::fs::read(place.path().join("depth.npy")).unwrap();
        // A header of a multiple of 64 bytes, and four bytes a pixel.
        assert!(depth.starts_with(b"\x93NUMPY") && (depth.len() - 4 * 64 * 48).is_multiple_of(64));
        let flo = PlaneArgs { depth: file("depth.flo"), ..PlaneArgs::default() };
        assert_eq!(drawn(&RenderArgs { planes: flo, ..args }).unwrap_err().code, Code::Usage);
    }

    #[test]
    fn the_first_camera_sees_everything() {
        let place = tempfile::tempdir().unwrap();
        let args = args(place.path());
        std::fs::write(&args.file, encode(&two(), Some("spz")).unwrap()).unwrap();
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
        let look = LookArgs { up: Some([0.0; 3]), ..args.look.clone() };
        let blind = RenderArgs { look, ..args };
        assert_eq!(drawn(&blind).unwrap_err().code, Code::Usage);
    }
}
