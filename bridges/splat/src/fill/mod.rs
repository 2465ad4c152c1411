//! Simulation proxies inside a captured surface.
//!
//! A capture is a shell: its Gaussians lie on the surface. [`fill`] puts proxies on a lattice inside it. Proxies are
//! particles of the simulation and are never drawn, so the appearance is unchanged by construction.
//!
//! [`physgaussian`] is another way, for comparison.
//!
//! 1. Opaque Gaussians are thinned to one surface point a cell of h/2; normals come from the covariance of neighbours,
//!    areas from their distance.
//! 2. A flood from outside over a voxel grid says where outside is; it orients the normals. Voxels that hold points are
//!    widened by one, which closes small holes; of a few voxel sizes the one that encloses most is taken.
//! 3. A lattice point is inside where the winding number of the oriented points, w(x) = Σ a n·(p − x) / (4π |p − x|³)
//!    (Barill et al. 2018), is above ½, the flood did not reach it, and the surface is farther than the margin.

mod ground;
pub mod physgaussian;
mod surface;
mod voxels;
mod winding;

use nalgebra::Vector3;
use rayon::prelude::*;
use thiserror::Error;

use crate::grid::Grid;
use crate::splats::Splats;

use surface::Surface;
pub(crate) use surface::plane;
use voxels::Voxels;
use winding::Winding;

/// Lattice points and voxels at most.
const MOST: f64 = 2e8;
/// Sizes of voxels that are tried, in units of the spacing.
const PITCHES: [f64; 4] = [1.0, 1.5, 2.25, 3.4];

/// Surface points that say how deep a lattice point lies: in a crease the nearest alone may face the wrong way.
const AROUND: usize = 5;

type Points = Vec<[f32; 3]>;

/// How a body is filled.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// Distance h of the lattice, in units of the splats.
    pub spacing: f64,
    /// Gaussians more transparent than this are no surface.
    pub opacity: f64,
    /// Smallest distance of a proxy from the surface, in units of h.
    pub margin: f64,
    /// Largest standard deviation at the surface points nearest to a proxy, times this, is a margin too.
    pub sigmas: f64,
    /// The margin from standard deviations ends here, in units of h: haze has blobs of any size.
    pub largest_margin: f64,
    /// The body stands on the ground, down is −z, and its underside was not captured: it is closed there.
    pub on_ground: bool,
}

impl Settings {
    /// Margin h/2 or three standard deviations, at most 2 h; surface from an opacity of 0.1, because captures
    /// build walls of many faint Gaussians; all sides captured.
    pub fn new(spacing: f64) -> Settings {
        Settings { spacing, opacity: 0.1, margin: 0.5, sigmas: 3.0, largest_margin: 2.0, on_ground: false }
    }
}

/// Proxies and how they came about.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Filling {
    /// Proxies, on the lattice (k + ½) h, by z, then y, then x.
    pub proxies: Vec<[f32; 3]>,
    /// Volume of one proxy: h³.
    pub volume_each: f64,
    /// All lattice points inside, those nearer to the surface than the margin among them, in the same order.
    pub interior: Vec<[f32; 3]>,
    /// Surface points after thinning.
    pub surface_points: usize,
    /// Surface points with outside on both sides or on none: they count little for the winding number.
    pub two_sided: usize,
    /// Area of the underside that was put where the body stands on the ground.
    pub closed_area: f64,
    /// Voxel size at which the flood was stopped by the surface.
    pub pitch: f64,
}

impl Filling {
    /// Volume inside the surface, its skin included.
    pub fn inside_volume(&self) -> f64 {
        self.interior.len() as f64 * self.volume_each
    }
}

/// A body that cannot be filled.
#[derive(Clone, Copy, Debug, Error, PartialEq)]
pub enum FillError {
    /// No distance to work with.
    #[error("the spacing of the filling must be a positive number")]
    Spacing,
    /// Too many lattice points.
    #[error("a spacing of {0} would need {1:.1e} lattice points; use a larger one or crop the splats")]
    TooFine(f64, f64),
    /// Nothing to be inside of.
    #[error("{0} Gaussians are opaque enough to be a surface and four are needed; lower `opacity`")]
    NoSurface(usize),
}

/// Fills the inside.
///
/// # Errors
/// The spacing does not fit, or there is no surface.
pub fn fill(splats: &Splats, settings: &Settings) -> Result<Filling, FillError> {
    let h = settings.spacing;
    if !(h.is_finite() && h > 0.0) {
        return Err(FillError::Spacing);
    }
    let surface = Surface::thinned(splats, settings.opacity, h / 2.0, settings.on_ground);
    if surface.points.len() < 4 {
        return Err(FillError::NoSurface(surface.points.len()));
    }
    let closed_area = surface.closed as f64 * (h / 2.0).powi(2);
    let (lower, upper) = surface.bounds();
    let wanted = ((upper - lower) / h).add_scalar(9.0).product();
    if wanted > MOST {
        return Err(FillError::TooFine(h, wanted));
    }
    let tried = PITCHES.map(|p| Voxels::new(&surface.points, lower, upper, p * h));
    // The first of equals, so that the finest wins.
    let best = tried
        .iter()
        .enumerate()
        .fold(0, |best, (i, v)| if v.enclosed_volume() > tried[best].enclosed_volume() * 1.01 { i } else { best });
    let voxels = &tried[best];
    let surface = surface.without_buried(voxels).oriented(voxels);
    let grid = Grid::new(&surface.points);
    let winding = Winding::new(&surface, 4.0 * h);

    let first = (lower / h).map(f64::floor);
    let size = ((upper / h).map(f64::floor) - first).map(|n| n as usize + 1);
    let at = |x: usize, y: usize, z: usize| (first + Vector3::new(x as f64, y as f64, z as f64)).add_scalar(0.5) * h;
    let plane = |z: usize| {
        let (mut inside, mut proxies, mut found) = (Vec::new(), Vec::new(), Vec::new());
        for y in 0..size.y {
            for x in 0..size.x {
                let p = at(x, y, z);
                if voxels.is_outside(p) || winding.at(p) <= 0.5 {
                    continue;
                }
                let place: [f32; 3] = p.map(|v| v as f32).into();
                inside.push(place);
                grid.nearest(p, AROUND, &mut found);
                let spread = found.iter().map(|n| surface.sigmas[n.1 as usize]).fold(0.0, f64::max);
                let spread = (settings.sigmas * spread).min(settings.largest_margin * h);
                if surface.depth(&found, p) >= spread.max(settings.margin * h) {
                    proxies.push(place);
                }
            }
        }
        (inside, proxies)
    };
    let planes: Vec<(Points, Points)> = (0..size.z).into_par_iter().map(plane).collect();
    Ok(Filling {
        interior: planes.iter().flat_map(|p| p.0.iter().copied()).collect(),
        proxies: planes.into_iter().flat_map(|p| p.1).collect(),
        volume_each: h * h * h,
        surface_points: surface.points.len(),
        two_sided: surface.confidence.iter().filter(|c| **c < 0.5).count(),
        closed_area,
        pitch: voxels.pitch,
    })
}
