//! From a decoded capture to a body: Gaussians in metres, particles that a solver moves, and what ties the two.
//!
//! The body's frame is the file's, turned upright and scaled: its origin is the file's origin, nothing is recentred.
//! [`Report`] says where in it the object lies, so that a scene can place it; a solver gets the particles alone.

mod cloud;
mod islands;
mod kernels;
mod share;
mod shown;

use std::path::Path;

use cosplat_core::asset::ParticleCloud;
use cosplat_core::scene::{BindingKind, BindingSpec, Fill};
use nalgebra::Vector3;
use thiserror::Error;

use crate::bind::{BindError, Binding};
use crate::clean::{self, Box3, Rules, clean};
use crate::error::SplatError;
use crate::fill::{self, FillError};
use crate::format::{self, Decoded};
use crate::grid::Grid;
use crate::linalg::wide;
use crate::merge::MergeError;
use crate::similarity::{Similarity, SimilarityError};
use crate::splats::{Axes, Splats};

pub use cloud::CloudReport;
pub use shown::Shown;

/// Gaussians from this opacity on are what a viewer sees of an object; boxes and shares are about them.
pub const VISIBLE: f64 = 0.1;
/// A Gaussian farther than this many spacings from every particle is not bound.
const BOUND: f64 = 6.0;

/// How a capture becomes a body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Recipe {
    /// Length of one unit of the file \[m\].
    pub metres_per_unit: f64,
    /// Direction of the file that points up; it becomes +z of the body.
    pub up: [f64; 3],
    /// Gaussians more transparent than this are dropped, 0 to 1.
    pub min_opacity: f64,
    /// Only Gaussians with their centre in this box stay: lower and upper corner, in units and axes of the file.
    pub keep_box: Option<[[f64; 3]; 2]>,
    /// How the inside is filled.
    pub method: Fill,
    /// How [`Fill::Winding`] does it; lengths \[m\]. Its spacing is that of the particles, whatever the method.
    pub fill: fill::Settings,
    /// Densities from which [`Fill::Physgaussian`] takes a cell as shell, and as a wall for its rays.
    pub thresholds: [f32; 2],
    /// What the Gaussians are tied to; one of the bindings of captures.
    pub binding: BindingSpec,
}

impl Recipe {
    /// Everything is kept but what is fainter than 0.02, and follows 12 particles; the body stands on the ground.
    pub fn new(metres_per_unit: f64, up: [f64; 3], spacing_m: f64) -> Recipe {
        Recipe {
            metres_per_unit,
            up,
            min_opacity: 0.02,
            keep_box: None,
            method: Fill::default(),
            fill: fill::Settings { on_ground: true, ..fill::Settings::new(spacing_m) },
            thresholds: [5.0, 3.0],
            binding: BindingSpec::default(),
        }
    }
}

impl Recipe {
    /// Which Gaussians stay.
    pub fn rules(&self) -> Rules {
        Rules {
            opacity: self.min_opacity,
            inside: self.keep_box.map(|[lower, upper]| Box3::from_corners(lower, upper)),
            largest_sigma: None,
        }
    }
}

/// A capture that cannot become a body.
#[derive(Clone, Debug, Error)]
pub enum StageError {
    /// The file cannot be read.
    #[error(transparent)]
    File(#[from] SplatError),
    /// Scale or up axis.
    #[error(transparent)]
    Similarity(#[from] SimilarityError),
    /// Nothing is left.
    #[error("no Gaussian is left: {report}; {remedy}", report = .0, remedy = remedy(.0))]
    Empty(clean::Report),
    /// No inside and no surface, or too fine a lattice.
    #[error(transparent)]
    Fill(#[from] FillError),
    /// What was put inside does not go with the Gaussians.
    #[error(transparent)]
    Merge(#[from] MergeError),
    /// The Gaussians cannot be tied to particles.
    #[error(transparent)]
    Bind(#[from] BindError),
}

/// What to do where no Gaussian is left.
fn remedy(report: &clean::Report) -> &'static str {
    if report.non_finite == report.total {
        "write the file again with the tool it came from"
    } else {
        "lower `min_opacity` or widen `keep_box`"
    }
}

/// What was made of a capture.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Report {
    /// Gaussians read, kept, and dropped with the reason.
    pub clean: clean::Report,
    /// Remarks of the decoder.
    pub notes: Vec<String>,
    /// Particles.
    pub cloud: CloudReport,
    /// Kept Gaussians that follow particles.
    pub bound: usize,
    /// Kept Gaussians of opacity [`VISIBLE`] or more.
    pub visible: usize,
    /// Those of them that follow no particle.
    pub visible_unbound: usize,
    /// Corners of the box of the centres of all visible Gaussians, in the body's frame \[m\].
    pub box_m: [[f64; 3]; 2],
    /// From the underside of the particles to the highest visible Gaussian \[m\].
    pub height_m: f64,
}

/// A body made from a capture.
#[derive(Clone, Debug)]
pub struct Staged {
    /// The Gaussians that were kept, with the bits they were decoded with, in units and axes of the file; behind them,
    /// with [`Fill::Physgaussian`], those that were put inside.
    pub source: Splats,
    /// The same Gaussians in the body's frame \[m\].
    pub splats: Splats,
    /// From the file to the body's frame.
    pub similarity: Similarity,
    /// The particles, in the body's frame.
    pub cloud: ParticleCloud,
    /// Which particles each Gaussian follows.
    pub binding: Binding,
    /// Gaussians too far from every particle to follow one; they stay where they are. Ascending.
    pub unbound: Vec<u32>,
    /// What was made of the capture.
    pub report: Report,
}

impl Staged {
    /// Reads a file and makes a body of it.
    ///
    /// # Errors
    /// [`StageError`].
    pub fn from_file(path: &Path, recipe: &Recipe) -> Result<Staged, StageError> {
        Staged::new(format::read_file(path)?, recipe)
    }

    /// Makes a body of what was decoded.
    ///
    /// # Errors
    /// [`StageError`].
    pub fn new(decoded: Decoded, recipe: &Recipe) -> Result<Staged, StageError> {
        let similarity = Similarity::upright(recipe.up, recipe.metres_per_unit)?;
        let (kept, counted) = clean(&decoded.splats, &recipe.rules());
        if kept.is_empty() {
            return Err(StageError::Empty(counted));
        }
        let mut source = if kept.len() == decoded.splats.len() { decoded.splats } else { decoded.splats.select(&kept) };
        let mut splats = source.clone();
        similarity.apply(&mut splats, Axes::Scene);
        let (cloud, of_cloud, binding) = if recipe.method == Fill::Physgaussian {
            let filled = kernels::kernels(&splats, recipe.fill.spacing, recipe.thresholds)?;
            source = filled.appended(&source, &similarity.inverse())?;
            splats = filled.appended(&splats, &Similarity::identity())?;
            (filled.cloud, filled.report, Binding::OneToOne((0..splats.len() as u32).collect()))
        } else {
            let (cloud, of_cloud) = cloud::cloud(&splats, &recipe.fill, recipe.method == Fill::Winding)?;
            let binding = bound(&splats, &single(&cloud.position_m), recipe.binding)?;
            (cloud, of_cloud, binding)
        };
        let particles = single(&cloud.position_m);
        let mut report = Report { clean: counted, notes: decoded.notes, cloud: of_cloud, ..Report::default() };
        let unbound = report.measure(&splats, &particles, recipe.fill.spacing);
        Ok(Staged { source, splats, similarity, cloud, binding, unbound, report })
    }
}

/// Gaussians of a capture, tied to particles; what is for meshes is taken as the default.
fn bound(splats: &Splats, particles: &[[f32; 3]], spec: BindingSpec) -> Result<Binding, BindError> {
    match spec.kind {
        BindingKind::Mean => Binding::mean(splats, particles, spec.neighbours),
        BindingKind::Particle => Binding::nearest(splats, particles),
        BindingKind::Affine | BindingKind::Vertices | BindingKind::Triangles => {
            Binding::affine(splats, particles, spec.neighbours)
        }
    }
}

impl Report {
    /// Counts what is bound and visible, and says which Gaussians are not bound.
    fn measure(&mut self, splats: &Splats, particles: &[[f32; 3]], spacing: f64) -> Vec<u32> {
        let grid = Grid::new(particles);
        let (mut found, mut unbound) = (Vec::new(), Vec::new());
        let (mut lower, mut upper) = (Vector3::repeat(f64::INFINITY), Vector3::repeat(f64::NEG_INFINITY));
        for i in 0..splats.len() {
            let p = wide(splats.positions[i]);
            grid.nearest(p, 1, &mut found);
            let bound = found.first().is_some_and(|n| n.0 <= (BOUND * spacing).powi(2));
            if bound {
                self.bound += 1;
            } else {
                unbound.push(i as u32);
            }
            if splats.opacity(i) >= VISIBLE {
                self.visible += 1;
                self.visible_unbound += usize::from(!bound);
                (lower, upper) = (lower.inf(&p), upper.sup(&p));
            }
        }
        self.box_m = [lower.into(), upper.into()];
        self.height_m = upper.z - self.cloud.base_m;
        unbound
    }
}

/// Positions as Gaussians have them.
pub(crate) fn single(positions: &[[f64; 3]]) -> Vec<[f32; 3]> {
    positions.iter().map(|p| p.map(|v| v as f32)).collect()
}
