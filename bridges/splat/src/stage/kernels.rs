//! A body in which every Gaussian is a particle, as `PhysGaussian` has it (Xie et al. 2024).

use std::collections::BTreeMap;

use cosplat_core::asset::ParticleCloud;
use nalgebra::Vector3;

use super::CloudReport;
use crate::fill::FillError;
use crate::fill::physgaussian::{Filling, Settings, fill};
use crate::linalg::wide;
use crate::merge::{MergeError, merge};
use crate::similarity::Similarity;
use crate::splats::Splats;

/// Cell of the solver's grid, in spacings; that of the filling is a quarter of it.
const GRID: f64 = 2.0;

/// Particles, one a Gaussian, those that were put inside behind the others.
pub(super) struct Kernels {
    pub(super) cloud: ParticleCloud,
    pub(super) report: CloudReport,
    filling: Filling,
}

/// All Gaussians and the filling as particles. The volume of each is that of a cell of the solver's grid divided by how many
/// are in it.
pub(super) fn kernels(splats: &Splats, spacing: f64, [density, search]: [f32; 2]) -> Result<Kernels, FillError> {
    let filling = fill(splats, &Settings { density, search, ..Settings::new(spacing * GRID / 4.0) })?;
    let position_m: Vec<[f64; 3]> =
        splats.positions.iter().chain(&filling.positions).map(|p| p.map(f64::from)).collect();
    let grid = GRID * spacing;
    let cell = |p: &[f64; 3]| p.map(|v| (v / grid).floor() as i64);
    let mut held: BTreeMap<[i64; 3], u32> = BTreeMap::new();
    for p in &position_m {
        *held.entry(cell(p)).or_default() += 1;
    }
    let volume = |p: &[f64; 3]| grid.powi(3) / f64::from(held.get(&cell(p)).copied().unwrap_or(1));
    let volume_m3: Vec<f64> = position_m.iter().map(volume).collect();
    let inside = splats.len() + filling.shell;
    let report = CloudReport {
        inside: position_m.len() - inside,
        sheet: inside,
        volume_m3: volume_m3.iter().sum(),
        inside_volume_m3: volume_m3[inside..].iter().fold(0.0, |sum, v| sum + v),
        base_m: position_m.iter().map(|p| p[2]).fold(f64::INFINITY, f64::min),
        ..CloudReport::default()
    };
    Ok(Kernels { cloud: ParticleCloud { spacing_m: spacing, position_m, volume_m3 }, report, filling })
}

impl Kernels {
    /// The Gaussians with those of the filling behind them, brought there by a map: copies of their kernels elsewhere.
    ///
    /// # Errors
    /// The Gaussians contradict themselves.
    pub(super) fn appended(&self, splats: &Splats, map: &Similarity) -> Result<Splats, MergeError> {
        let mut copies = splats.select(&self.filling.kernels);
        let place = |p: &[f32; 3]| -> [f32; 3] { map.point(Vector3::from(wide(*p))).map(|v| v as f32).into() };
        copies.positions = self.filling.positions.iter().map(place).collect();
        let mut all = merge(&[splats, &copies])?;
        for (extra, copied) in all.extras.iter_mut().zip(&copies.extras) {
            extra.values.truncate(splats.len());
            extra.values.extend(&copied.values);
        }
        Ok(all)
    }
}
