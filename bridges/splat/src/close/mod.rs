//! Closing the holes of a captured environment: Algorithm 1 of the first seed paper.
//!
//! 1. P, the centres of the opaque Gaussians; normals from their neighbours, and [`reconstruct`] makes a surface M that
//!    passes them and closes what no camera saw (screened Poisson). M is cropped to the box of P.
//! 2. The caller covers M with samples, evenly (`poisson_disks` of the mesh bridge).
//! 3. [`Closed::choose`] keeps those near P (the rest of M is invented), more of them where P is thin, and none where P
//!    is dense already.
//! 4. [`transparent`] makes Gaussians of them that nobody sees.
//!
//! Normals are turned by what is seen from above, so environments are those that lie open to the sky: in a room the ceiling
//! would be taken for the ground of what is above it.
//!
//! P counts as a whole in step 3. For M, points are taken together in cells of its grid: the finest is the longest side
//! of P over 2^depth, coarser where P is not that dense or the grid would have more than 2²⁵ nodes. Details smaller
//! than two cells are lost, and sheets nearer than two cells become one.

mod choose;
pub(crate) mod nets;
mod normals;
mod poisson;

use cosplat_core::asset::TriangleMesh;
use nalgebra::Vector3;
use thiserror::Error;

use crate::grid::Grid;
use crate::linalg::wide;
use crate::splats::{Extra, Splats, logit_of_opacity};
pub(crate) use poisson::Field;

/// Name of the property that tells transparent Gaussians from captured ones: 1 for those that close holes.
pub const LABEL: &str = "closing";
/// Nodes of the grid at most: 20 bytes each.
const MOST: f64 = 33_554_432.0;
/// Cells grow by this until the grid fits.
const COARSER: f64 = 1.05;
/// Points that make a surface at least.
const LEAST: usize = 16;
/// Neighbours by which density is judged.
const NEIGHBOURS: usize = 8;
/// Standard deviation of a transparent Gaussian, in units of the spacing.
const SIGMA: f64 = 0.5;

/// Where samples are thinned: kept with probability p = max(`least`, min(1, (d / `full`)^`power`)).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Thinning {
    /// Distance d from which all are kept, r₀.
    pub full: f64,
    /// Exponent γ.
    pub power: f64,
    /// Least probability, `p_min`.
    pub least: f64,
}

/// Where samples are left out because Gaussians are there already.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Pruning {
    /// Nowhere.
    None,
    /// Nearer than this to one, δ.
    Nearest(f64),
    /// In voxels that hold so many.
    Occupancy {
        /// Edge of the voxels, v.
        edge: f64,
        /// Fewest Gaussians that leave no room, m.
        most: usize,
    },
}

/// How an environment is closed. Lengths are in units of the splats.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// Distance h of the samples.
    pub spacing: f64,
    /// Gaussians more transparent than this are no surface.
    pub opacity: f64,
    /// Towards the sky; any length but zero.
    pub up: [f64; 3],
    /// The longest side has 2^depth cells at most.
    pub depth: u32,
    /// Weight λ of the points against the normals, in units of 1/cell; 4 in the paper of 2013.
    pub screening: f64,
    /// This part of M, where P is thinnest, is cut away before the crop.
    pub thinnest: f64,
    /// Empty-space guard τ: samples farther from P are left out.
    pub reach: f64,
    /// Adaptive thinning.
    pub thinning: Option<Thinning>,
    /// Pruning of dense regions.
    pub pruning: Pruning,
    /// Of the thinning.
    pub seed: u64,
}

impl Settings {
    /// Starting values for a spacing h, because the paper prints none: guard 10 h, all samples from 2 h on and in
    /// proportion below, none nearer than h/2, cells of a 256th of the longest side.
    pub fn new(spacing: f64, up: [f64; 3]) -> Settings {
        Settings {
            spacing,
            opacity: 0.1,
            up,
            depth: 8,
            screening: 4.0,
            thinnest: 0.0,
            reach: 10.0 * spacing,
            thinning: Some(Thinning { full: 2.0 * spacing, power: 1.0, least: 0.05 }),
            pruning: Pruning::Nearest(0.5 * spacing),
            seed: 1,
        }
    }
}

/// An environment that cannot be closed.
#[derive(Clone, Copy, Debug, Error, PartialEq)]
pub enum CloseError {
    /// No distance to work with.
    #[error("the spacing, the guard and the screening must be positive numbers, and the depth 3 to 10")]
    Settings,
    /// No direction.
    #[error("the up axis must be a finite vector other than zero")]
    Up,
    /// Nothing to close.
    #[error("{0} Gaussians are opaque enough to be a surface and {LEAST} are needed; lower the least opacity")]
    NoSurface(usize),
    /// All of it was cut away.
    #[error("nothing is left of the surface; cut less of its thin parts away")]
    NothingLeft,
}

/// The closed surface and what it was made from.
#[derive(Clone, Debug)]
pub struct Closed {
    /// M, cropped to the box of P, which is wider by half a cell for a ground without thickness. Lengths are in units of
    /// the splats.
    pub mesh: TriangleMesh,
    /// Edge of the cells of its grid.
    pub cell: f64,
    /// P: centres of the opaque Gaussians.
    pub points: Vec<[f32; 3]>,
    /// Points that stand for them in the reconstruction.
    pub representatives: usize,
}

/// Samples that were chosen, and why the others were not.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Chosen {
    /// Samples of M.
    pub samples: usize,
    /// Farther from P than the guard allows.
    pub beyond: usize,
    /// Left out by chance, by the adaptive thinning.
    pub thinned: usize,
    /// Where P is dense.
    pub dense: usize,
    /// D: the rest.
    pub places: Vec<[f32; 3]>,
}

/// Makes the surface M.
///
/// # Errors
/// [`CloseError`].
pub fn reconstruct(splats: &Splats, settings: &Settings) -> Result<Closed, CloseError> {
    let Settings { spacing, reach, screening, depth, .. } = *settings;
    let positive = [spacing, reach, screening].iter().all(|v| v.is_finite() && *v > 0.0);
    if !positive || !(3..=10).contains(&depth) {
        return Err(CloseError::Settings);
    }
    let up = Vector3::from(settings.up).try_normalize(0.0).filter(|u| u.iter().all(|v| v.is_finite()));
    let up = up.ok_or(CloseError::Up)?;
    let points = normals::opaque(splats, settings.opacity);
    let (lower, upper) = bounds(&points);
    let longest = (upper - lower).max();
    if points.len() < LEAST || !(longest > 0.0 && longest.is_finite()) {
        return Err(CloseError::NoSurface(points.len()));
    }
    let mut finest = longest / f64::from(1_u32 << depth);
    while poisson::nodes(lower, upper, finest) > MOST {
        finest *= COARSER;
    }
    let (some, cell) = normals::representatives(&points, finest);
    let oriented = normals::oriented(&some, up, cell);
    let field = poisson::solve(&oriented, lower, upper, cell, screening);
    let mut mesh = nets::surface(&field);
    drop(field);
    if settings.thinnest > 0.0 {
        without_thin_parts(&mut mesh, &some, settings.thinnest);
    }
    let room = Vector3::repeat(cell / 2.0);
    let inside = |v: &[f64; 3]| {
        let p = Vector3::from(*v);
        p >= lower - room && p <= upper + room
    };
    let stays: Vec<bool> = mesh.vertices_m.iter().map(inside).collect();
    keep(&mut mesh, &stays);
    if mesh.triangles.is_empty() {
        return Err(CloseError::NothingLeft);
    }
    Ok(Closed { mesh, cell, points, representatives: some.len() })
}

impl Closed {
    /// Which samples of M are kept: guard, adaptive thinning, pruning.
    pub fn choose(&self, samples: &[[f64; 3]], settings: &Settings) -> Chosen {
        choose::choose(samples, &self.points, settings)
    }
}

/// Gaussians of opacity zero behind those of a capture, in whose frame the places are; [`LABEL`] is 1 for them.
pub fn transparent(splats: &Splats, places: &[[f32; 3]], spacing: f64) -> Splats {
    let (mut out, n) = (splats.clone(), places.len());
    let sigma = (SIGMA * spacing).max(f64::MIN_POSITIVE).ln() as f32;
    out.positions.extend(places);
    out.rotations.resize(out.positions.len(), [1.0, 0.0, 0.0, 0.0]);
    out.log_scales.resize(out.positions.len(), [sigma; 3]);
    out.opacity_logits.resize(out.positions.len(), logit_of_opacity(0.0));
    out.sh_dc.resize(out.positions.len(), [0.0; 3]);
    out.sh_rest.resize(out.positions.len() * out.coefficients(), [0.0; 3]);
    if !out.extras.iter().any(|e| e.name == LABEL) {
        out.extras.push(Extra { name: LABEL.to_owned(), kind: "uchar", values: vec![0.0; splats.len()] });
    }
    for extra in &mut out.extras {
        extra.values.resize(splats.len() + n, f64::from(u8::from(extra.name == LABEL)));
    }
    out
}

fn bounds(points: &[[f32; 3]]) -> (Vector3<f64>, Vector3<f64>) {
    let ends = (Vector3::repeat(f64::INFINITY), Vector3::repeat(f64::NEG_INFINITY));
    points.iter().fold(ends, |(lower, upper), p| (lower.inf(&wide(*p)), upper.sup(&wide(*p))))
}

/// Cuts away the part of the vertices whose eighth neighbour among the points is farthest.
fn without_thin_parts(mesh: &mut TriangleMesh, points: &[[f32; 3]], part: f64) {
    let (grid, mut found) = (Grid::new(points), Vec::new());
    let distance = |v: &[f64; 3]| {
        grid.nearest(Vector3::from(*v), NEIGHBOURS, &mut found);
        found.last().map_or(f64::INFINITY, |n| n.0)
    };
    let distances: Vec<f64> = mesh.vertices_m.iter().map(distance).collect();
    let mut sorted = distances.clone();
    sorted.sort_by(f64::total_cmp);
    let last = ((1.0 - part.min(1.0)) * sorted.len() as f64) as usize;
    let Some(limit) = sorted.get(last.min(sorted.len().saturating_sub(1))).copied() else { return };
    let stays: Vec<bool> = distances.iter().map(|d| *d < limit).collect();
    keep(mesh, &stays);
}

/// The triangles all of whose vertices stay, and these vertices.
fn keep(mesh: &mut TriangleMesh, stays: &[bool]) {
    mesh.triangles.retain(|t| t.iter().all(|&i| stays[i as usize]));
    let mut place = vec![u32::MAX; mesh.vertices_m.len()];
    let mut kept = Vec::new();
    for i in mesh.triangles.iter_mut().flatten() {
        let at = &mut place[*i as usize];
        if *at == u32::MAX {
            *at = kept.len() as u32;
            kept.push(mesh.vertices_m[*i as usize]);
        }
        *i = *at;
    }
    mesh.vertices_m = kept;
}
