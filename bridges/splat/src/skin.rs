//! Moving Gaussians with what they are bound to.

use nalgebra::{Matrix3, Vector3};
use rayon::prelude::*;

use crate::bind::Local;
use crate::linalg::{finite, polar_rotation, quaternion_of, rotation_of, svd, wide};
use crate::sh::ShRotation;
use crate::splats::Splats;

/// Gaussians a task.
const CHUNK: usize = 1024;
/// Standard deviations do not fall below this, in scene units, so that their logarithm stays a number.
const THINNEST: f64 = 1e-30;

/// How Gaussians are moved.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Limits {
    /// A standard deviation becomes at most this many times the largest one before; without it there is no limit.
    pub stretch: Option<f64>,
    /// Bands of the colour stay as they are, as if nothing had turned: for what turns by less than can be seen.
    pub keep_colours: bool,
}

/// What happened to the Gaussians.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Report {
    /// Moved or deformed.
    pub moved: usize,
    /// Left with the bits they had.
    pub unmoved: usize,
    /// Held back by [`Limits::stretch`]; among the moved.
    pub held: usize,
    /// The map was not finite: left as they were, and drawn where they were.
    pub lost: usize,
}

impl Report {
    fn and(self, other: Report) -> Report {
        Report {
            moved: self.moved + other.moved,
            unmoved: self.unmoved + other.unmoved,
            held: self.held + other.held,
            lost: self.lost + other.lost,
        }
    }
}

/// Arrays of one chunk that a motion changes.
struct Slot<'a> {
    position: &'a mut [[f32; 3]],
    rotation: &'a mut [[f32; 4]],
    scale: &'a mut [[f32; 3]],
    rest: &'a mut [[f32; 3]],
}

/// Moves every Gaussian of `rest` by the map around it, into `out`, which becomes a copy of `rest` first unless it
/// is one already in all that no motion changes.
///
/// Mean x + u; covariance F Σ Fᵀ in product form: with Σ = R S² Rᵀ the singular values and left vectors of F R S are
/// the new scales and axes, positive definite for every F; bands of the colour by the rotation of F's polar
/// decomposition (Xie et al. 2024, `PhysGaussian`). A Gaussian with u = 0 and F = 1 keeps its bits; one with F = 1 keeps
/// all but its position.
///
/// # Panics
/// `local` panics.
pub fn skin(rest: &Splats, local: impl Fn(usize) -> Local + Sync, limits: Limits, out: &mut Splats) -> Report {
    if !is_made_from(out, rest) {
        out.clone_from(rest);
    }
    let k = rest.coefficients();
    let count = rest.len().div_ceil(CHUNK);
    let mut bands: Vec<&mut [[f32; 3]]> = out.sh_rest.chunks_mut((CHUNK * k).max(1)).collect();
    bands.resize_with(count, Default::default);
    let slots: Vec<Slot<'_>> = out
        .positions
        .chunks_mut(CHUNK)
        .zip(out.rotations.chunks_mut(CHUNK))
        .zip(out.log_scales.chunks_mut(CHUNK))
        .zip(bands)
        .map(|(((position, rotation), scale), rest)| Slot { position, rotation, scale, rest })
        .collect();
    let one_chunk = |(chunk, slot): (usize, Slot<'_>)| {
        let mut report = Report::default();
        let mut turn = Turn::default();
        for at in 0..slot.position.len() {
            let i = chunk * CHUNK + at;
            let band = &mut slot.rest[at * k..(at + 1) * k];
            band.copy_from_slice(rest.rest(i));
            let moved = one(rest, i, &local(i), limits, band, &mut turn);
            slot.position[at] = moved.position;
            slot.rotation[at] = moved.rotation;
            slot.scale[at] = moved.scale;
            report = report.and(moved.report);
        }
        report
    };
    slots.into_par_iter().enumerate().map(one_chunk).reduce(Report::default, Report::and)
}

/// Whether what no motion changes is the same, and the arrays of the rest have the right lengths.
fn is_made_from(out: &Splats, rest: &Splats) -> bool {
    out.is_consistent()
        && (out.len(), out.sh_degree, out.axes, out.antialiased)
            == (rest.len(), rest.sh_degree, rest.axes, rest.antialiased)
        && out.opacity_logits == rest.opacity_logits
        && out.sh_dc == rest.sh_dc
        && out.extras == rest.extras
}

/// The last rotation of colour bands: the Gaussians of a rigid body share one.
#[derive(Default)]
struct Turn(Option<(Matrix3<f64>, ShRotation)>);

impl Turn {
    /// That of the polar rotation of a gradient.
    fn of(&mut self, gradient: &Matrix3<f64>, degree: u8) -> &ShRotation {
        let known = self.0.take().filter(|(of, _)| of == gradient);
        let make = || (*gradient, ShRotation::new(&polar_rotation(gradient), degree));
        &self.0.insert(known.unwrap_or_else(make)).1
    }
}

struct Moved {
    position: [f32; 3],
    rotation: [f32; 4],
    scale: [f32; 3],
    report: Report,
}

fn one(rest: &Splats, i: usize, local: &Local, limits: Limits, band: &mut [[f32; 3]], turn: &mut Turn) -> Moved {
    let (position, rotation, scale) = (rest.positions[i], rest.rotations[i], rest.log_scales[i]);
    let same = |report| Moved { position, rotation, scale, report };
    let plain = local.gradient == Matrix3::identity();
    if plain && local.displacement == Vector3::zeros() {
        return same(Report { unmoved: 1, ..Report::default() });
    }
    let lost = Report { lost: 1, ..Report::default() };
    let moved: [f32; 3] = (wide(position) + local.displacement).map(|v| v as f32).into();
    if !finite(&local.gradient) || moved.iter().any(|v| !v.is_finite()) {
        return same(lost);
    }
    let mut report = Report { moved: 1, ..Report::default() };
    if plain {
        return Moved { position: moved, rotation, scale, report };
    }
    let sigma = Vector3::from(scale.map(|s| f64::from(s).exp()));
    let product = local.gradient * rotation_of(rotation) * Matrix3::from_diagonal(&sigma);
    if !finite(&product) {
        return same(lost);
    }
    let parts = svd(&product);
    let mut axes = parts.u;
    if axes.determinant() < 0.0 {
        // A reflected axis spans the same ellipsoid.
        let turned = -axes.column(2);
        axes.set_column(2, &turned);
    }
    let limit = limits.stretch.map_or(f64::INFINITY, |s| s * sigma.max());
    report.held = usize::from(parts.s.iter().any(|&s| s > limit));
    if !band.is_empty() && !limits.keep_colours {
        turn.of(&local.gradient, rest.sh_degree).apply(band);
    }
    Moved {
        position: moved,
        rotation: quaternion_of(&axes, rotation),
        scale: parts.s.map(|s| s.min(limit).max(THINNEST).ln() as f32),
        report,
    }
}
