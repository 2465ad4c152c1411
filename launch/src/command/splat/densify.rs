//! `cosplat splat densify`: closes the holes of a captured environment, and gives its surface out as a collider.

use std::path::{Path, PathBuf};
use std::time::Instant;

use clap::Args;
use cosplat_core::asset::TriangleMesh;
use cosplat_mesh::{Amount, MeshError, poisson_disks};
use cosplat_splat::Splats;
use cosplat_splat::close::{Chosen, Closed, Pruning, Settings, Thinning, reconstruct, transparent};
use serde::Serialize;

use super::look::vector;
use super::output::{Output, axes_of, free, write};
use super::statistics::Extent;
use super::{put, read_some};
use crate::cli::Format;
use crate::exit::{Code, Error, Problem};
use crate::geometry::axis;
use crate::hint::count;
use crate::render::{Paint, json, print, printable};

/// Samples along the longest side where no spacing is given.
const ALONG: f64 = 200.0;

/// `cosplat splat densify`. Lengths are in units of the file.
#[derive(Clone, Debug, Args)]
pub(crate) struct DensifyArgs {
    /// Splat file to read: a captured environment
    #[arg(value_name = "IN")]
    pub(crate) input: PathBuf,
    /// Splat file to write: .ply, .spz or .glb; behind what was captured it has transparent Gaussians where something is missing
    #[arg(value_name = "OUT")]
    pub(crate) output: PathBuf,
    /// Surface to write as a mesh, in units and axes of OUT: the collider of the environment
    #[arg(long, value_name = "OUT.obj|OUT.ply")]
    pub(crate) mesh: Option<PathBuf>,
    /// Distance of samples in units of the file [default: a 200th of the longest side]
    #[arg(long, value_name = "LENGTH")]
    pub(crate) spacing: Option<f64>,
    /// Samples by number, so many times those of hexagonal order; 1 or less: by distance, as many as fit
    #[arg(long, value_name = "TIMES", default_value_t = 1.0)]
    pub(crate) oversampling: f64,
    /// Samples farther from every Gaussian are left out [default: 10 spacings]
    #[arg(long, value_name = "LENGTH")]
    pub(crate) reach: Option<f64>,
    /// From this distance on no sample is thinned out [default: 2 spacings]
    #[arg(long, value_name = "LENGTH")]
    pub(crate) full: Option<f64>,
    /// Below it a sample stays with the probability (distance / full)^power
    #[arg(long, value_name = "NUMBER", default_value_t = 1.0)]
    pub(crate) power: f64,
    /// But at least with this one; 1 thins nothing
    #[arg(long, value_name = "PROBABILITY", default_value_t = 0.05)]
    pub(crate) least: f64,
    /// Samples nearer to a Gaussian are left out; 0 leaves none out [default: half a spacing]
    #[arg(long, value_name = "LENGTH", conflicts_with = "voxel")]
    pub(crate) apart: Option<f64>,
    /// In place of that: samples in voxels of this edge with `--most` Gaussians are left out
    #[arg(long, value_name = "LENGTH")]
    pub(crate) voxel: Option<f64>,
    /// Gaussians that fill a voxel
    #[arg(long, value_name = "COUNT", default_value_t = 1, requires = "voxel")]
    pub(crate) most: usize,
    /// Finest cells of the reconstruction: the longest side over two to this power, 3 to 10
    #[arg(long, value_name = "POWER", default_value_t = 8)]
    pub(crate) depth: u32,
    /// Weight of the points against the normals in the reconstruction
    #[arg(long, value_name = "WEIGHT", default_value_t = 4.0)]
    pub(crate) screening: f64,
    /// Cut this part of the surface away, where the capture is thinnest, 0 to 1
    #[arg(long, value_name = "PART", default_value_t = 0.0)]
    pub(crate) thinnest: f64,
    /// Gaussians more transparent than this are no surface
    #[arg(long, value_name = "OPACITY", default_value_t = 0.1)]
    pub(crate) min_opacity: f64,
    /// Direction of the file that points up, as `0,-1,0` [default: by the convention of the format]
    #[arg(long, value_name = "X,Y,Z", value_parser = vector, allow_hyphen_values = true)]
    pub(crate) up: Option<[f64; 3]>,
    /// Another seed gives other samples
    #[arg(long, value_name = "NUMBER", default_value_t = 1)]
    pub(crate) seed: u64,
    /// Replace OUT and the mesh if they exist
    #[arg(long)]
    pub(crate) force: bool,
    /// Form of the answer on standard output
    #[arg(long, value_enum, default_value_t)]
    pub(crate) format: Format,
}

/// What became of a capture. Lengths are in units of the file.
#[derive(Debug, Serialize)]
struct Densified {
    status: &'static str,
    input: String,
    output: String,
    gaussians: usize,
    /// Those opaque enough to be the surface, and the points that stood for them in the reconstruction.
    surface_gaussians: usize,
    representatives: usize,
    cell: f64,
    vertices: usize,
    triangles: usize,
    open_edges: usize,
    #[serde(skip_serializing_if = "Option::is_none")]
    mesh: Option<String>,
    spacing: f64,
    samples: usize,
    beyond_reach: usize,
    thinned: usize,
    dense: usize,
    added: usize,
    seconds: f64,
}

/// Closes the holes of an environment.
///
/// # Errors
/// The file cannot be used or has no surface, or the results cannot be written.
pub(super) fn densify(args: &DensifyArgs) -> Result<Code, Error> {
    let done = densified(args)?;
    match args.format {
        Format::Json => print(&json(&done)?)?,
        Format::Human => print(&done.human(Paint::stdout()))?,
    }
    Ok(Code::Ok)
}

fn densified(args: &DensifyArgs) -> Result<Densified, Error> {
    let start = Instant::now();
    for out in [&args.output].into_iter().chain(&args.mesh) {
        free(&Output { from: &args.input, to: out, force: args.force })?;
    }
    // Before the work: endings that cannot be written are known at once.
    if let Some(out) = &args.mesh {
        encoded(out, &TriangleMesh::default())?;
    }
    // Turned as OUT will be, so that the mesh lies where its Gaussians lie.
    let splats = read_some(&args.input)?.decoded.splats.to_axes(axes_of(&args.output));
    let unusable = |why: &dyn std::fmt::Display| {
        let problem = Problem::new(format!("Cannot close `{}`", args.input.display())).at(&args.input).because(why);
        Error::new(Code::Scene, problem.hint("change `--spacing`, `--min-opacity`, `--up` or what the message names"))
    };
    let extent = Extent::visible(&splats).ok_or_else(|| unusable(&"no Gaussian has a finite place"))?;
    let settings = args.settings(args.spacing.unwrap_or(extent.longest() / ALONG), &splats);
    let closed = reconstruct(&splats, &settings).map_err(|e| unusable(&e))?;
    let amount = args.amount(&closed.mesh, settings.spacing);
    let samples = poisson_disks(&closed.mesh, amount, args.seed).map_err(|e| unusable(&e))?;
    let chosen = closed.choose(&samples, &settings);
    write(&args.output, &transparent(&splats, &chosen.places, settings.spacing))?;
    if let Some(out) = &args.mesh {
        put(out, &encoded(out, &closed.mesh)?)?;
    }
    Ok(Densified::of(args, &splats, &closed, &chosen, settings.spacing, start.elapsed().as_secs_f64()))
}

fn encoded(path: &Path, mesh: &TriangleMesh) -> Result<Vec<u8>, Error> {
    cosplat_mesh::encode(mesh, path.extension().and_then(|e| e.to_str())).map_err(|error: MeshError| {
        let problem = Problem::new(format!("Cannot write the mesh `{}`", path.display())).at(path);
        Error::new(Code::Scene, problem.because(&error.what).hint(error.advice))
    })
}

impl DensifyArgs {
    fn settings(&self, spacing: f64, splats: &Splats) -> Settings {
        let up = self.up.unwrap_or_else(|| splats.axes.up().map_or([0.0, 0.0, 1.0], axis));
        let usual = Settings::new(spacing, up);
        let pruning = match (self.voxel, self.apart.unwrap_or(0.5 * spacing)) {
            (Some(edge), _) => Pruning::Occupancy { edge, most: self.most },
            (None, apart) if apart > 0.0 => Pruning::Nearest(apart),
            (None, _) => Pruning::None,
        };
        let full = self.full.unwrap_or(2.0 * spacing);
        Settings {
            opacity: self.min_opacity,
            depth: self.depth,
            screening: self.screening,
            thinnest: self.thinnest,
            reach: self.reach.unwrap_or(usual.reach),
            thinning: Some(Thinning { full, power: self.power, least: self.least }),
            pruning,
            seed: self.seed,
            ..usual
        }
    }

    fn amount(&self, mesh: &TriangleMesh, spacing: f64) -> Amount {
        if self.oversampling <= 1.0 {
            return Amount::Spacing(spacing);
        }
        let area = |t: &[u32; 3]| {
            let [a, b, c] = mesh.corners(*t);
            (b - a).cross(&(c - a)).norm() / 2.0
        };
        let total: f64 = mesh.triangles.iter().map(area).sum();
        // In hexagonal order each sample has (√3/2) h² of the area.
        Amount::Count((self.oversampling * total / (0.75_f64.sqrt() * spacing * spacing)) as usize)
    }
}

impl Densified {
    fn of(
        args: &DensifyArgs,
        splats: &Splats,
        closed: &Closed,
        chosen: &Chosen,
        spacing: f64,
        seconds: f64,
    ) -> Densified {
        Densified {
            status: "ok",
            input: args.input.display().to_string(),
            output: args.output.display().to_string(),
            gaussians: splats.len(),
            surface_gaussians: closed.points.len(),
            representatives: closed.representatives,
            cell: closed.cell,
            vertices: closed.mesh.vertices_m.len(),
            triangles: closed.mesh.triangles.len(),
            open_edges: closed.mesh.open_edges(),
            mesh: args.mesh.as_ref().map(|p| p.display().to_string()),
            spacing,
            samples: chosen.samples,
            beyond_reach: chosen.beyond,
            thinned: chosen.thinned,
            dense: chosen.dense,
            added: chosen.places.len(),
            seconds,
        }
    }

    fn human(&self, paint: Paint) -> String {
        let Self { samples, beyond_reach, thinned, dense, spacing, cell, triangles, .. } = self;
        let mesh = self.mesh.as_ref().map(|p| format!("{}: the surface as a mesh\n", paint.bold(&printable(p))));
        format!(
            "{}: {}, and {} transparent ones where something is missing\n\
             surface: {triangles} triangles from {} points for {} Gaussians, in cells of {cell:.4e} units\n\
             {samples} samples {spacing:.4e} units apart; left out: {beyond_reach} out of reach, {thinned} thinned, {dense} \
             where it is dense\n{}{:.1} s\n",
            paint.bold(&printable(&self.output)),
            count(self.gaussians, "Gaussian", "Gaussians"),
            self.added,
            self.representatives,
            self.surface_gaussians,
            mesh.unwrap_or_default(),
            self.seconds,
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::command::splat::look::{LookArgs, borrowed, camera};
    use cosplat_mesh::format::{Beside, read as read_mesh};
    use cosplat_splat::format::{encode, read_file};
    use cosplat_viewer::{Options, render};

    /// A sheet of opaque Gaussians with a hole, up by the convention of `.ply`.
    fn sheet() -> Splats {
        let places = (0..6400).map(|i| [(i % 80) as f32 / 80.0 - 0.5, 0.0, (i / 80) as f32 / 80.0 - 0.5]);
        let positions: Vec<[f32; 3]> = places.filter(|p| p[0].hypot(p[2]) > 0.1).collect();
        let n = positions.len();
        Splats {
            rotations: vec![[1.0, 0.0, 0.0, 0.0]; n],
            log_scales: vec![[-4.5, -6.0, -4.5]; n],
            opacity_logits: vec![3.0; n],
            sh_dc: vec![[0.5, 0.2, -0.3]; n],
            positions,
            ..Splats::default()
        }
    }

    #[test]
    fn a_hole_is_closed_and_nothing_looks_different() {
        let place = tempfile::tempdir().unwrap();
        let at = |name: &str| place.path().join(name);
        std::fs::write(at("a.ply"), encode(&sheet(), Some("ply")).unwrap()).unwrap();
        let typed = |words: &[&str]| {
            let line = ["cosplat", "splat", "densify"].into_iter().chain(words.iter().copied());
            match <crate::cli::Cli as clap::Parser>::parse_from(line).command {
                Some(crate::cli::Command::Splat(super::super::SplatArgs {
                    command: super::super::SplatCommand::Densify(args),
                })) => args,
                other => panic!("{other:?}"),
            }
        };
        let paths = ["a.ply", "b.ply", "m.obj"].map(|n| at(n).display().to_string());
        let args = typed(&[&paths[0], &paths[1], "--mesh", &paths[2], "--depth", "6", "--spacing", "0.02"]);
        let done = densified(&args).unwrap();
        // Disks jam at 0.6966 of area over distance². What stays of the hole of radius 0.1 after thinning and pruning is the
        // integral of d / 0.04, at most 1, from d = 0.01 on: 0.0198, which makes 34 with a spread of 4.
        assert!((22..47).contains(&done.added), "{done:?}");
        let mesh = read_mesh(&std::fs::read(at("m.obj")).unwrap(), Some("obj"), Beside::Nothing).unwrap().mesh;
        assert_eq!(mesh.triangles.len(), done.triangles);
        let [a, b, c] = mesh.corners(mesh.triangles[0]);
        assert!((b - a).cross(&(c - a)).y < 0.0, "its free side is up, which is -y here");
        let (before, after) = (read_file(&at("a.ply")).unwrap().splats, read_file(&at("b.ply")).unwrap().splats);
        assert_eq!(after.len(), before.len() + done.added);
        let view = camera(&LookArgs::of_size([160, 120]), &before, &Extent::visible(&before).unwrap()).view().unwrap();
        let [old, new] = [&before, &after].map(|s| render(&[borrowed(s)], &view, &Options::default()).rgba);
        assert!(old == new, "to the bit");
        // The same from a file with other axes, and nothing is replaced unasked.
        assert_eq!(densified(&args).unwrap_err().code, Code::Usage);
        let turned = at("c.spz").display().to_string();
        let args = typed(&[&paths[0], &turned, "--depth", "6", "--spacing", "0.02", "--apart", "0", "--least", "1"]);
        let all = densified(&args).unwrap();
        assert_eq!((all.thinned, all.dense, all.added + all.beyond_reach), (0, 0, all.samples));
        let args = typed(&[&paths[0], &turned, "--force", "--mesh", &at("m.stl").display().to_string()]);
        assert_eq!(densified(&args).unwrap_err().code, Code::Scene);
        let args = typed(&[&paths[0], &turned, "--force", "--min-opacity", "1"]);
        assert_eq!(densified(&args).unwrap_err().code, Code::Scene);
    }
}
