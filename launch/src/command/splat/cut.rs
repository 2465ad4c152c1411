//! A cut through a captured body: its particles, those on the surface and those inside.

use cosplat_core::scene::Fill;
use cosplat_splat::stage::Staged;
use cosplat_splat::surfel::dots;
use cosplat_splat::{OutputFrame, Splats, merge};

/// Colours of particles, linear: on the surface, inside, and Gaussians that are particles.
const SURFACE: [f64; 3] = [0.1, 0.35, 0.8];
const INSIDE: [f64; 3] = [0.9, 0.35, 0.05];

/// Particles behind the middle along y \[m\], as dots.
///
/// # Errors
/// In words; none so far.
pub(crate) fn particles(method: Fill, body: &Staged, middle: f64) -> Result<Splats, Box<dyn std::error::Error>> {
    // Those inside come last where every Gaussian is a particle; elsewhere they lie on the lattice.
    let spacing = body.cloud.spacing_m;
    let kernels = body.report.cloud.sheet;
    let size = if method == Fill::Physgaussian { spacing / 2.0 } else { spacing };
    let on_lattice = |p: &[f64; 3]| p.iter().all(|v| ((v / spacing).rem_euclid(1.0) - 0.5).abs() < 1e-9);
    let inside = |i: usize, p: &[f64; 3]| {
        if method == Fill::Physgaussian { i >= kernels } else { method == Fill::Winding && on_lattice(p) }
    };
    let of = |wanted: bool| -> Vec<[f64; 3]> {
        let all = body.cloud.position_m.iter().enumerate();
        all.filter(|(i, p)| p[1] >= middle && inside(*i, p) == wanted).map(|(_, p)| *p).collect()
    };
    let frame = OutputFrame::world();
    let made =
        [(of(false), SURFACE), (of(true), INSIDE)].map(|(places, colour)| dots(&places, &[], size, colour, &frame));
    let [surface, inside] = made;
    Ok(merge(&[&surface?, &inside?])?)
}
