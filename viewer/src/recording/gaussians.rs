//! Gaussians in the numbers of the recording: standard deviations, quaternions x, y, z, w, colours of 8 bits.

use rerun::components::SphericalHarmonics3Rgb;
use rerun::{Color, GaussianSplats3D, Quaternion};

use crate::gaussians::Gaussians;

/// Base band of the spherical harmonics, 1 / (2 √π).
const C0: f32 = 0.282_094_8;
/// Coefficients above the base band that a recording holds for each Gaussian.
const BANDS: usize = 15;

/// Where they are and how they lie.
pub(super) fn shapes(g: &Gaussians<'_>) -> GaussianSplats3D {
    GaussianSplats3D::update_fields()
        .with_centers(g.positions.iter().copied())
        .with_scales(g.log_scales.iter().map(|s| s.map(f32::exp)))
        .with_quaternions(g.rotations.iter().map(|&q| quaternion(q)))
}

/// How they look.
pub(super) fn colours(g: &Gaussians<'_>) -> GaussianSplats3D {
    let colours = g.sh_dc.iter().zip(g.opacity_logits).map(|(dc, logit)| {
        let [red, green, blue] = dc.map(|c| byte(0.5 + C0 * c));
        Color::from_unmultiplied_rgba(red, green, blue, byte(1.0 / (1.0 + (-logit).exp())))
    });
    let splats = GaussianSplats3D::update_fields().with_colors(colours);
    let splats = splats.with_spherical_harmonics_degree(u32::from(g.sh_degree));
    if g.sh_degree == 0 {
        return splats;
    }
    let bands = g.sh_rest.chunks_exact(g.coefficients()).map(|own| {
        let mut all = [[0.0_f32; 3]; BANDS];
        all[..own.len()].copy_from_slice(own);
        SphericalHarmonics3Rgb::from(all)
    });
    splats.with_sh_coefficients(bands)
}

fn quaternion([w, x, y, z]: [f32; 4]) -> Quaternion {
    let length = (w * w + x * x + y * y + z * z).sqrt();
    if length > 0.0 && length.is_finite() {
        Quaternion::from_xyzw([x, y, z, w].map(|c| c / length))
    } else {
        Quaternion::from_xyzw([0.0, 0.0, 0.0, 1.0])
    }
}

/// A display value as a byte; what is no number is 0.
fn byte(value: f32) -> u8 {
    (value.clamp(0.0, 1.0) * 255.0).round() as u8
}
