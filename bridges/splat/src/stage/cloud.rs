//! Particles on and inside a capture, one in each cell of a lattice that holds material.

use std::collections::{BTreeMap, BTreeSet};

use cosplat_core::asset::ParticleCloud;
use nalgebra::Vector3;

use super::islands::{Cell, join};
use super::share::volumes;
use crate::fill::{FillError, Filling, Settings, fill};
use crate::linalg::wide;
use crate::splats::Splats;

/// Particles of an island that is part of the body; fewer are specks that the capture left in the air.
const SMALLEST_ISLAND: usize = 8;
/// Gap that is bridged, in spacings. The grid of a solver is two spacings wide, so a gap of two is none for it.
const REACH: f64 = 6.0;

/// Cells from the origin at most, so that their numbers and those of their neighbours fit.
const FARTHEST: f64 = 1e9;

/// How the particles came about.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct CloudReport {
    /// Particles inside the surface.
    pub inside: usize,
    /// Particles on the surface, outside what counts as inside: the skin of what is solid, and all of what is thinner
    /// than a spacing, as leaves, stalks and cloth are.
    pub sheet: usize,
    /// Particles outside that are beside inside ones and share their volume.
    pub skin: usize,
    /// Particles put between pieces that the capture saw apart.
    pub bridges: usize,
    /// Cells with Gaussians that are no part of the body: specks, and pieces too far from it.
    pub stray: usize,
    /// Volume of all particles \[m³\]: what is inside, and what is thinner than a spacing, which counts as one thick.
    pub volume_m3: f64,
    /// Volume inside the surface \[m³\], which its skin shares.
    pub inside_volume_m3: f64,
    /// Height of the underside in the body's frame \[m\]: no particle lies below.
    pub base_m: f64,
    /// Area of the underside that no camera saw and that was closed \[m²\].
    pub closed_m2: f64,
    /// Surface points with outside on both sides or on none.
    pub two_sided: usize,
}

/// One particle in each cell of the lattice k h … (k + 1) h that is inside, in its middle, or that holds
/// Gaussians opaque enough to be surface, in the middle of those. Volumes are those of [`volumes`].
///
/// Unless `solid`, nothing counts as inside.
pub(super) fn cloud(
    splats: &Splats,
    settings: &Settings,
    solid: bool,
) -> Result<(ParticleCloud, CloudReport), FillError> {
    let h = settings.spacing;
    let farthest = splats.positions.iter().flatten().fold(0.0_f64, |f, v| f.max(f64::from(v.abs())));
    if farthest / h > FARTHEST {
        return Err(FillError::TooFine(h, farthest / h));
    }
    let filling = if solid { fill(splats, settings)? } else { shell(h)? };
    let cell = |p: &[f32; 3]| [2, 1, 0].map(|k| (f64::from(p[k]) / h).floor() as i32);
    let inside: BTreeSet<Cell> = filling.interior.iter().map(cell).collect();
    let base = if settings.on_ground && solid { lowest_layer(&inside) } else { i32::MIN };
    let inside: BTreeSet<Cell> = inside.into_iter().filter(|c| c[0] >= base).collect();
    let mut sheet: BTreeMap<Cell, (Vector3<f64>, f64)> = BTreeMap::new();
    for i in 0..splats.len() {
        let c = cell(&splats.positions[i]);
        if splats.opacity(i) >= settings.opacity && !inside.contains(&c) && c[0] >= base {
            let sum = sheet.entry(c).or_insert((Vector3::zeros(), 0.0));
            *sum = (sum.0 + wide(splats.positions[i]), sum.1 + 1.0);
        }
    }
    let all: BTreeSet<Cell> = inside.iter().chain(sheet.keys()).copied().collect();
    let joined = join(&all, SMALLEST_ISLAND, REACH);
    let body: BTreeSet<Cell> =
        all.iter().chain(&joined.bridges).filter(|c| !joined.stray.contains(*c)).copied().collect();
    let middle = |c: &Cell| [2, 1, 0].map(|k| (f64::from(c[k]) + 0.5) * h);
    let place = |c: &Cell| sheet.get(c).map_or_else(|| middle(c), |(sum, n)| (sum / *n).into());
    let each = h.powi(3);
    let (shares, skin) = volumes(&body, &inside);
    let volume_m3: Vec<f64> = shares.into_iter().map(|v| v * each).collect();
    let within = body.iter().filter(|c| inside.contains(*c)).count();
    let report = CloudReport {
        inside: within,
        sheet: body.iter().filter(|c| sheet.contains_key(*c)).count(),
        skin,
        bridges: joined.bridges.len(),
        stray: joined.stray.len(),
        volume_m3: volume_m3.iter().sum(),
        inside_volume_m3: within as f64 * each,
        base_m: body.first().map_or(0.0, |c| f64::from(c[0]) * h),
        closed_m2: filling.closed_area,
        two_sided: filling.two_sided,
    };
    let cloud = ParticleCloud { spacing_m: h, position_m: body.iter().map(place).collect(), volume_m3 };
    Ok((cloud, report))
}

/// Nothing inside.
fn shell(spacing: f64) -> Result<Filling, FillError> {
    if spacing.is_finite() && spacing > 0.0 { Ok(Filling::default()) } else { Err(FillError::Spacing) }
}

/// The lowest layer that holds a tenth of what the fullest one holds: stray points below the ground enclose a few cells.
fn lowest_layer(cells: &BTreeSet<Cell>) -> i32 {
    let mut layers: BTreeMap<i32, usize> = BTreeMap::new();
    for c in cells {
        *layers.entry(c[0]).or_default() += 1;
    }
    let fullest = layers.values().copied().max().unwrap_or(0);
    layers.iter().find(|(_, n)| **n * 10 >= fullest).map_or(i32::MIN, |(z, _)| *z)
}
