//! Gaussians for bodies that are nothing but particles.

use nalgebra::{Matrix3, Vector3};

use crate::bind::{BindError, Local, matrix};
use crate::output::OutputFrame;
use crate::skin::{Limits, skin};
use crate::splats::{Axes, Splats, dc_of_colour, logit_of_opacity};
use crate::surfel::display_of_linear;

/// Standard deviation in units of the spacing: neighbours overlap at half of it, so that no gap is seen.
const SIGMA: f64 = 0.5;
const OPACITY: f64 = 0.95;
/// The same for smoke: a layer of particles one spacing apart takes 2π times the opacity, a fourteenth of what is behind.
const PUFF_SIGMA: f64 = 1.0;
const PUFF_OPACITY: f64 = 0.012;
/// An ellipsoid becomes at most this many times as long as the sphere it was.
const STRETCH: f64 = 3.0;

/// One Gaussian a particle: a sphere, deformed by the total deformation gradients (rows, world axes) where there are any.
/// Positions and spacing \[m\], world; colour linear red, green, blue from 0 to 1.
///
/// # Errors
/// Not as many gradients as positions.
pub fn dots(
    positions_m: &[[f64; 3]],
    gradients: &[[f32; 9]],
    spacing_m: f64,
    linear: [f64; 3],
    frame: &OutputFrame,
) -> Result<Splats, BindError> {
    let count = positions_m.len();
    if !gradients.is_empty() && gradients.len() != count {
        return Err(BindError::Length("gradients", count, gradients.len()));
    }
    let mut splats = Splats::with_capacity(count, 0);
    splats.positions = positions_m.iter().map(|p| p.map(|v| v as f32)).collect();
    splats.rotations = vec![[1.0, 0.0, 0.0, 0.0]; count];
    splats.log_scales = vec![[(SIGMA * spacing_m).max(f64::MIN_POSITIVE).ln() as f32; 3]; count];
    splats.opacity_logits = vec![logit_of_opacity(OPACITY); count];
    splats.sh_dc = vec![linear.map(|c| dc_of_colour(display_of_linear(c))); count];
    splats.axes = Axes::Scene;
    if !gradients.is_empty() {
        let still = splats.clone();
        let of = |i: usize| Local { displacement: Vector3::zeros(), gradient: gradient(&gradients[i]) };
        skin(&still, of, Limits { stretch: Some(STRETCH), ..Limits::default() }, &mut splats);
    }
    frame.from_world.apply(&mut splats, frame.axes);
    Ok(splats)
}

/// One soft Gaussian a particle of smoke: wide beside the spacing, and so thin that only many of them in a row hide what is
/// behind. Positions and spacing \[m\], world; colour linear red, green, blue from 0 to 1.
///
/// # Errors
/// None so far: positions alone always fit.
pub fn puffs(
    positions_m: &[[f64; 3]],
    spacing_m: f64,
    linear: [f64; 3],
    frame: &OutputFrame,
) -> Result<Splats, BindError> {
    let mut splats = dots(positions_m, &[], PUFF_SIGMA / SIGMA * spacing_m, linear, frame)?;
    splats.opacity_logits.fill(logit_of_opacity(PUFF_OPACITY));
    Ok(splats)
}

/// The gradient, or the identity where it is not finite: a particle is drawn as long as it has a position.
fn gradient(rows: &[f32; 9]) -> Matrix3<f64> {
    if rows.iter().all(|v| v.is_finite()) { matrix(*rows) } else { Matrix3::identity() }
}
