//! Bodies as particles: lattices that fill a shape, listed points and prepared clouds.

use cosplat_core::asset::Asset;
use cosplat_core::boundary::Vec3;
use cosplat_core::distance::{Shape, SignedDistance};
use cosplat_core::plugin::SolverScene;
use cosplat_core::scene::{Body, Source};

use crate::frame::bounds;

/// Particles across the smallest extent of a body without a spacing.
const ACROSS: f64 = 10.0;

/// Distance at which a body is sampled \[m\]; `Err` in words.
pub(crate) fn spacing(scene: &SolverScene, body: &Body) -> Result<f64, String> {
    if let Some(Asset::Particles(cloud)) = scene.assets.get(&body.name).map(AsRef::as_ref) {
        return Ok(cloud.spacing_m);
    }
    let half = Shape::of(&body.source).and_then(|s| bounds(&s)).map(|[_, half]| half);
    let chosen = half.map(|h| 2.0 * h.iter().copied().fold(f64::INFINITY, f64::min) / ACROSS);
    let found = body.spacing_m.or(chosen).filter(|s| s.is_finite() && *s > 0.0);
    found.ok_or_else(|| format!("bodies without a positive `spacing` (body `{}`)", body.name))
}

/// Places in the body's frame and volumes \[m, m³\]; `Err` in words.
pub(crate) fn fill(scene: &SolverScene, body: &Body, spacing: f64) -> Result<(Vec<Vec3>, Vec<f64>), String> {
    let whole = spacing * spacing * spacing;
    if let Some(asset) = scene.assets.get(&body.name) {
        asset.check().map_err(|why| format!("the geometry of body `{}`: {why}", body.name))?;
        if let Asset::Particles(cloud) = asset.as_ref() {
            if cloud.volume_m3.iter().any(|v| *v <= 0.0) {
                return Err(format!("particles without volume (body `{}`)", body.name));
            }
            return Ok((cloud.position_m.clone(), cloud.volume_m3.clone()));
        }
    }
    if let Source::Points { positions_m } = &body.source {
        return Ok((positions_m.clone(), vec![whole; positions_m.len()]));
    }
    let shape = Shape::of(&body.source);
    let Some((shape, half)) = shape.and_then(|s| bounds(&s).map(|[_, half]| (s, half))) else {
        return Err(format!("bodies from a source that was not prepared as particles (body `{}`)", body.name));
    };
    let count = half.map(|h| (2.0 * h / spacing).round().max(1.0) as usize);
    let step = [0, 1, 2].map(|k| 2.0 * half[k] / count[k] as f64);
    let at = |k: usize, i: usize| (i as f64 + 0.5) * step[k] - half[k];
    let mut points = Vec::new();
    for i in 0..count[0] {
        for j in 0..count[1] {
            points.extend((0..count[2]).map(|k| [at(0, i), at(1, j), at(2, k)]));
        }
    }
    points.retain(|&x| shape.distance(x).0 <= 1e-9 * spacing);
    if points.is_empty() {
        points.push([0.0; 3]);
    }
    // Cells of the lattice are the particles' own: the liquid starts at its density at rest.
    let volumes = vec![step.iter().product(); points.len()];
    Ok((points, volumes))
}
