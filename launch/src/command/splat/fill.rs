//! `cosplat splat fill`: what a capture becomes in three ways, in numbers and in a picture.

use std::path::PathBuf;

use clap::Args;
use cosplat_core::scene::Fill;
use cosplat_splat::fill;
use cosplat_splat::format::Decoded;
use cosplat_splat::stage::{Recipe, Staged};
use cosplat_viewer::{Options, Picture, png, psnr, render as draw};
use serde::Serialize;

use super::cut::particles;
use super::drop::{Conditions, Fall, drop};
use super::fallen::page;
use super::look::{LookArgs, borrowed, camera, vector};
use super::output::{Output, free};
use super::picture::picture_name;
use super::statistics::Extent;
use super::{put, read_some};
use crate::cli::Format;
use crate::exit::{Code, Error, Problem};
use crate::geometry::axis;
use crate::render::{Paint, json, print, printable, table};

/// Particles along the longest side where no spacing is given.
const ALONG: f64 = 40.0;
/// Side of one of the six pictures.
const SIDE_PX: usize = 480;
/// `cosplat splat fill`.
#[derive(Clone, Debug, Args)]
pub(crate) struct FillArgs {
    /// Splat file to fill
    #[arg(value_name = "FILE")]
    pub(crate) file: PathBuf,
    /// Picture to write: three columns, filled by winding numbers, as `PhysGaussian` does, and not at all; the outside
    /// above, a cut with the particles below
    #[arg(long, value_name = "OUT.png", value_parser = picture_name)]
    pub(crate) compare: Option<PathBuf>,
    /// Page to write: all three are dropped on the ground, elastic; their heights and shapes as curves, with pictures
    #[arg(long, value_name = "OUT.html", value_parser = page_name)]
    pub(crate) drop: Option<PathBuf>,
    /// Height from which they are dropped, in metres [default: half of the longest side]
    #[arg(long, value_name = "METRES", requires = "drop")]
    pub(crate) height: Option<f64>,
    /// Density of what is dropped, in kg/m³
    #[arg(long, value_name = "KG/M3", default_value_t = 300.0)]
    pub(crate) mass_density: f64,
    /// Young's modulus of what is dropped, in Pa
    #[arg(long, value_name = "PA", default_value_t = 2e4)]
    pub(crate) youngs_modulus: f64,
    /// Distance of particles in metres [default: a fortieth of the longest side]
    #[arg(long, value_name = "METRES")]
    pub(crate) spacing: Option<f64>,
    /// Length of a unit of the file in metres
    #[arg(long, value_name = "METRES", default_value_t = 1.0)]
    pub(crate) metres_per_unit: f64,
    /// Direction of the file that points up, as `0,-1,0` [default: by the convention of the format]
    #[arg(long, value_name = "X,Y,Z", value_parser = vector, allow_hyphen_values = true)]
    pub(crate) up: Option<[f64; 3]>,
    /// Gaussians more transparent than this are left out
    #[arg(long, value_name = "OPACITY", default_value_t = 0.02)]
    pub(crate) min_opacity: f64,
    /// `PhysGaussian`: density from which a cell is shell
    #[arg(long, value_name = "DENSITY", default_value_t = 5.0)]
    pub(crate) density: f32,
    /// `PhysGaussian`: density that stops a ray
    #[arg(long, value_name = "DENSITY", default_value_t = 3.0)]
    pub(crate) search: f32,
    /// The underside was captured too, and is not closed
    #[arg(long)]
    pub(crate) all_sides: bool,
    /// Replace OUT.png if it exists
    #[arg(long)]
    pub(crate) force: bool,
    /// Form of the answer on standard output
    #[arg(long, value_enum, default_value_t)]
    pub(crate) format: Format,
}

/// One way.
#[derive(Debug, Serialize)]
struct Way {
    fill: Fill,
    particles: usize,
    inside: usize,
    on_surface: usize,
    volume_m3: f64,
    inside_volume_m3: f64,
    gaussians_drawn: usize,
    /// Against the picture of the capture itself; absent where no bit differs, or nothing was drawn.
    #[serde(skip_serializing_if = "Option::is_none")]
    outside_psnr_db: Option<f64>,
    /// Shapes while it is dropped.
    #[serde(skip_serializing_if = "Option::is_none")]
    fall: Option<Fall>,
}

#[derive(Debug, Serialize)]
struct Dropped {
    #[serde(flatten)]
    conditions: Conditions,
    page: String,
}

#[derive(Debug, Serialize)]
struct Filled {
    status: &'static str,
    file: String,
    spacing_m: f64,
    ways: Vec<Way>,
    #[serde(skip_serializing_if = "Option::is_none")]
    picture: Option<String>,
    /// How they were dropped, and the page about it.
    #[serde(skip_serializing_if = "Option::is_none")]
    dropped: Option<Dropped>,
}

/// Fills a capture in three ways.
///
/// # Errors
/// The file cannot be used or filled, or the picture cannot be written.
pub(super) fn fill(args: &FillArgs) -> Result<Code, Error> {
    let filled = filled(args)?;
    match args.format {
        Format::Json => print(&json(&filled)?)?,
        Format::Human => print(&filled.human(Paint::stdout()))?,
    }
    Ok(Code::Ok)
}

fn filled(args: &FillArgs) -> Result<Filled, Error> {
    for out in [&args.compare, &args.drop].into_iter().flatten() {
        free(&Output { from: &args.file, to: out, force: args.force })?;
    }
    let decoded = read_some(&args.file)?.decoded;
    let unusable = |why: &dyn std::fmt::Display| {
        let problem = Problem::new(format!("Cannot fill `{}`", args.file.display())).at(&args.file).because(why);
        Error::new(Code::Scene, problem.hint("change `--spacing`, `--min-opacity`, `--up` or `--metres-per-unit`"))
    };
    let extent = Extent::visible(&decoded.splats).ok_or_else(|| unusable(&"no Gaussian has a finite place"))?;
    let spacing = args.spacing.unwrap_or(extent.longest() * args.metres_per_unit / ALONG);
    let up = args.up.unwrap_or_else(|| decoded.splats.axes.up().map_or([0.0, 0.0, 1.0], axis));
    let recipe = Recipe { min_opacity: args.min_opacity, ..Recipe::new(args.metres_per_unit, up, spacing) };
    let on_ground = !args.all_sides;
    let thresholds = [args.density, args.search];
    let recipe = Recipe { fill: fill::Settings { on_ground, ..recipe.fill }, thresholds, ..recipe };
    let made = |method| {
        let decoded = Decoded { splats: decoded.splats.clone(), notes: Vec::new() };
        Staged::new(decoded, &Recipe { method, ..recipe }).map_err(|e| unusable(&e))
    };
    let bodies = [Fill::Winding, Fill::Physgaussian, Fill::None]
        .map(|method| made(method).map(|body| (method, body)))
        .into_iter()
        .collect::<Result<Vec<_>, _>>()?;
    let pictures = if args.compare.is_some() { drawn(&bodies).map_err(|e| unusable(&e))? } else { Vec::new() };
    if let Some(out) = &args.compare {
        let mut bytes = std::io::Cursor::new(Vec::new());
        png::encode(&mut bytes, &joined(&pictures)).map_err(|e| unusable(&e))?;
        put(out, bytes.get_ref())?;
    }
    let conditions = Conditions {
        height_m: args.height.unwrap_or(extent.longest() * args.metres_per_unit / 2.0),
        density_kg_m3: args.mass_density,
        youngs_modulus_pa: args.youngs_modulus,
    };
    let mut falls = Vec::new();
    if let Some(out) = &args.drop {
        for (method, body) in &bodies {
            falls.push(drop(*method, body, &conditions).map_err(|e| unusable(&e))?);
        }
        put(out, page(&args.file, &conditions, &bodies, &falls).map_err(|e| unusable(&e))?.as_bytes())?;
    }
    let mut falls = falls.into_iter();
    let ways = bodies.iter().enumerate().map(|(i, (method, body))| {
        let cloud = &body.report.cloud;
        let capture = pictures.get(4).map(Picture::rgb);
        let ratio = capture.and_then(|capture| pictures.get(2 * i).map(|p| psnr(&capture, &p.rgb())));
        Way {
            fill: *method,
            particles: body.cloud.position_m.len(),
            inside: cloud.inside,
            on_surface: cloud.sheet,
            volume_m3: cloud.volume_m3,
            inside_volume_m3: cloud.inside_volume_m3,
            gaussians_drawn: body.source.len(),
            outside_psnr_db: ratio.filter(|r| r.is_finite()),
            fall: falls.next(),
        }
    });
    Ok(Filled {
        status: "ok",
        file: args.file.display().to_string(),
        spacing_m: spacing,
        ways: ways.collect(),
        picture: args.compare.as_ref().map(|p| p.display().to_string()),
        dropped: args.drop.as_ref().map(|p| Dropped { conditions, page: p.display().to_string() }),
    })
}

/// Name of a page.
fn page_name(text: &str) -> Result<PathBuf, String> {
    let path = PathBuf::from(text);
    let is_page = path.extension().is_some_and(|e| e.eq_ignore_ascii_case("html"));
    if is_page { Ok(path) } else { Err("expected a file name that ends with `.html`".to_owned()) }
}

/// Of each body the outside and a cut, by the same camera.
fn drawn(bodies: &[(Fill, Staged)]) -> Result<Vec<Picture>, String> {
    let Some((_, first)) = bodies.first() else { return Ok(Vec::new()) };
    let extent = Extent::visible(&first.splats).ok_or("nothing is visible")?;
    let args = LookArgs::of_size([SIDE_PX; 2]);
    let view = camera(&args, &first.splats, &extent).view().map_err(|e| e.to_string())?;
    let options = Options { background: [1.0; 3], near: 1e-6, ..Options::default() };
    let middle = extent.centre()[1];
    let mut pictures = Vec::new();
    for (method, body) in bodies {
        pictures.push(draw(&[borrowed(&body.splats)], &view, &options));
        let cut = particles(*method, body, middle).map_err(|e| e.to_string())?;
        pictures.push(draw(&[borrowed(&cut)], &view, &options));
    }
    Ok(pictures)
}

/// Pictures of one size, two a column.
fn joined(pictures: &[Picture]) -> Picture {
    let columns = pictures.len().div_ceil(2);
    let mut rgba = vec![[1.0; 4]; columns * SIDE_PX * 2 * SIDE_PX];
    for (i, picture) in pictures.iter().enumerate() {
        for (y, row) in picture.rgba.chunks(SIDE_PX).enumerate() {
            let at = ((i % 2) * SIDE_PX + y) * columns * SIDE_PX + i / 2 * SIDE_PX;
            rgba[at..at + row.len()].copy_from_slice(row);
        }
    }
    Picture { width: columns * SIDE_PX, height: 2 * SIDE_PX, rgba, depth: Vec::new() }
}

fn name(fill: Fill) -> &'static str {
    match fill {
        Fill::Winding => "winding",
        Fill::Physgaussian => "physgaussian",
        Fill::None => "none",
    }
}

impl Filled {
    fn human(&self, paint: Paint) -> String {
        let head = ["fill", "particles", "inside", "surface", "volume", "inside", "drawn", "outside looks"];
        let mut rows = vec![head.map(str::to_owned).to_vec()];
        for way in &self.ways {
            let name = name(way.fill);
            let looks = match (way.outside_psnr_db, &self.picture) {
                (Some(db), _) => format!("changed, {db:.1} dB"),
                (None, Some(_)) => "the same, to the bit".to_owned(),
                (None, None) => String::new(),
            };
            rows.push(vec![
                name.to_owned(),
                way.particles.to_string(),
                way.inside.to_string(),
                way.on_surface.to_string(),
                format!("{:.4e} m³", way.volume_m3),
                format!("{:.4e} m³", way.inside_volume_m3),
                way.gaussians_drawn.to_string(),
                looks,
            ]);
        }
        let picture = self.picture.as_ref().map(|p| {
            format!(
                "{}: the outside above, a cut with particles on the surface (blue) and inside (orange) below\n",
                printable(p)
            )
        });
        let fallen = self.ways.iter().filter_map(|way| {
            let [least, last] = way.fall.as_ref()?.squashed().map(|part| 100.0 * part);
            Some(format!(
                "{}, dropped: squashed to {least:.0} % of its height, {last:.0} % at the end\n",
                name(way.fill)
            ))
        });
        let page = self.dropped.iter().map(|d| {
            let Conditions { height_m, density_kg_m3, youngs_modulus_pa } = d.conditions;
            let of = format!("{density_kg_m3} kg/m³ and {youngs_modulus_pa:.1e} Pa");
            format!("{}: dropped from {height_m:.3} m, of {of}\n", printable(&d.page))
        });
        let dropped: String = fallen.chain(page).collect();
        let open = self.ways.iter().any(|way| matches!(way.fill, Fill::Physgaussian) && way.inside == 0);
        let why = "physgaussian fills nothing: no place is shut in on all six sides by cells of that density; lower `--density` \
                   and `--search`\n";
        format!(
            "{}: spacing {:.4e} m\n{}{}{}{dropped}",
            paint.bold(&printable(&self.file)),
            self.spacing_m,
            table(paint, &rows),
            if open { why } else { "" },
            picture.unwrap_or_default()
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_shipped_plant_is_filled_in_three_ways() {
        let place = tempfile::tempdir().unwrap();
        let file = PathBuf::from(std::env::var("CARGO_MANIFEST_DIR").expect("cargo runs the tests"))
            .join("scenes/assets/plant.v4.spz");
        let compare = Some(place.path().join("fill.png"));
        let args = FillArgs {
            file,
            compare,
            drop: None,
            height: None,
            mass_density: 300.0,
            youngs_modulus: 2e4,
            spacing: Some(0.015),
            metres_per_unit: 0.465,
            up: None,
            min_opacity: 0.02,
            density: 1.0,
            search: 0.5,
            all_sides: false,
            force: false,
            format: Format::Json,
        };
        let done = filled(&args).unwrap();
        let [winding, physgaussian, none] = &done.ways[..] else { panic!("{done:?}") };
        assert_eq!((winding.outside_psnr_db, none.outside_psnr_db), (None, None), "proxies are never drawn");
        assert_eq!(physgaussian.particles, physgaussian.gaussians_drawn, "there every particle is drawn");
        assert!(winding.inside > 100 && none.inside == 0 && physgaussian.particles > winding.particles);
        assert_eq!(png::read(args.compare.as_ref().unwrap()).map(|p| (p.0, p.1)).ok(), Some((1440, 960)));
        assert_eq!(filled(&args).unwrap_err().code, Code::Usage, "it exists");
        let fine = FillArgs { spacing: Some(1e-9), compare: None, ..args };
        assert_eq!(filled(&fine).unwrap_err().code, Code::Scene);
    }
}
