//! Smoke at t = 0 as particles: lattices that fill a shape, listed points and prepared clouds.

use cosplat_core::asset::Asset;
use cosplat_core::boundary::{Vec3, scale};
use cosplat_core::distance::{Shape, SignedDistance};
use cosplat_core::plugin::SolverScene;
use cosplat_core::scene::{Body, Source};

/// Particles across the smallest extent of a body without a spacing.
const ACROSS: f64 = 20.0;
/// Particles above which a spacing is refused as too fine.
const MOST: f64 = 2e7;

/// Half the edges of the box around a shape \[m\]; none for what is no body of smoke by a formula.
fn half(shape: &Shape) -> Option<Vec3> {
    match shape {
        Shape::Box(half) => Some(*half),
        Shape::Sphere(r) => Some([*r; 3]),
        Shape::Cylinder(r, half) => Some([*r, *r, *half]),
        Shape::Plane(_) | Shape::HeightField(_) | Shape::Mesh(_) => None,
    }
}

/// Distance of particles \[m\], their places in the body's frame \[m\] and the volume of each \[m³\]; `Err` in words.
pub(crate) fn fill(scene: &SolverScene, body: &Body) -> Result<(f64, Vec<Vec3>, f64), String> {
    let name = &body.name;
    if let Some(asset) = scene.assets.get(name) {
        asset.check().map_err(|why| format!("the geometry of body `{name}`: {why}"))?;
        if let Asset::Particles(cloud) = asset.as_ref() {
            let count = cloud.volume_m3.len().max(1) as f64;
            return Ok((cloud.spacing_m, cloud.position_m.clone(), cloud.volume_m3.iter().sum::<f64>() / count));
        }
    }
    let shape = Shape::of(&body.source);
    let box_half = shape.as_ref().and_then(half);
    let chosen = box_half.map(|h| 2.0 * h.iter().copied().fold(f64::INFINITY, f64::min) / ACROSS);
    let spacing = body.spacing_m.or(chosen).filter(|s| s.is_finite() && *s > 0.0);
    let Some(spacing) = spacing else { return Err(format!("bodies without a positive `spacing` (body `{name}`)")) };
    if let Source::Points { positions_m } = &body.source {
        return Ok((spacing, positions_m.clone(), spacing * spacing * spacing));
    }
    let (Some(shape), Some(half)) = (shape, box_half) else {
        return Err(format!("bodies from a source that was not prepared as particles (body `{name}`)"));
    };
    let count = half.map(|h| (2.0 * h / spacing).round().max(1.0));
    if count.iter().product::<f64>() > MOST {
        return Err(format!("more than {MOST:.0} particles at a spacing of {spacing} m (body `{name}`)"));
    }
    let step = [0, 1, 2].map(|k| 2.0 * half[k] / count[k]);
    let count = count.map(|c| c as usize);
    let at = |k: usize, i: usize| (i as f64 + 0.5) * step[k] - half[k];
    let mut points = Vec::new();
    for i in 0..count[0] {
        for j in 0..count[1] {
            points.extend((0..count[2]).map(|k| [at(0, i), at(1, j), at(2, k)]));
        }
    }
    points.retain(|&x| shape.distance(x).0 <= 1e-9 * spacing);
    if points.is_empty() {
        points.push(scale(half, 0.0));
    }
    Ok((spacing, points, step.iter().product()))
}
