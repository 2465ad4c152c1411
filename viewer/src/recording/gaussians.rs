//! Gaussians in the numbers of the recording: standard deviations, quaternions x, y, z, w, colours of 8 bits.

use rerun::components::SphericalHarmonics3Rgb;
use rerun::{Color, GaussianSplats3D, Quaternion};

use crate::gaussians::Gaussians;

/// Base band of the spherical harmonics, 1 / (2 √π).
const C0: f32 = 0.282_094_8;
/// Coefficients above the base band that a recording holds for each Gaussian.
const BANDS: usize = 15;

/// Standard deviations are written again when more than [`SHARE`] of them differ by more than this from those that are
/// written, in units of themselves.
const STRETCHED: f32 = 0.05;
/// The same for the cosine of half an angle: one degree.
const TURNED: f32 = 0.999_961_9;
/// Share of the Gaussians of an entity that may differ by more.
const SHARE: usize = 100;

/// What a recording says of the Gaussians of an entity by now.
#[derive(Debug)]
pub(super) struct Written {
    log_scales: Vec<[f32; 3]>,
    rotations: Vec<[f32; 4]>,
    sh_dc: Vec<[f32; 3]>,
    opacity_logits: Vec<f32>,
}

impl Written {
    pub(super) fn new(g: &Gaussians<'_>) -> Written {
        Written {
            log_scales: g.log_scales.to_vec(),
            rotations: g.rotations.to_vec(),
            sh_dc: g.sh_dc.to_vec(),
            opacity_logits: g.opacity_logits.to_vec(),
        }
    }

    /// What has to be said again: where they are always, how they lie and how long they are where that differs visibly,
    /// their colours where they differ at all.
    pub(super) fn news(&mut self, g: &Gaussians<'_>) -> GaussianSplats3D {
        let mut splats = centers(g);
        if differ(&self.log_scales, g.log_scales, |a, b| (0..3).any(|k| (a[k] - b[k]).abs() > STRETCHED)) {
            splats = splats.with_scales(scales(g));
            self.log_scales = g.log_scales.to_vec();
        }
        if differ(&self.rotations, g.rotations, |a, b| half_cosine(a, b) < TURNED) {
            splats = splats.with_quaternions(g.rotations.iter().map(|&q| quaternion(q)));
            self.rotations = g.rotations.to_vec();
        }
        if self.sh_dc != g.sh_dc || self.opacity_logits != g.opacity_logits {
            splats = splats.with_colors(colours(g));
            self.sh_dc = g.sh_dc.to_vec();
            self.opacity_logits = g.opacity_logits.to_vec();
        }
        splats
    }
}

/// Whether more than a share differs.
fn differ<T>(written: &[T], now: &[T], differs: impl Fn(&T, &T) -> bool) -> bool {
    let count = written.iter().zip(now).filter(|(a, b)| differs(a, b)).count();
    written.len() != now.len() || count * SHARE > now.len()
}

/// Cosine of half the angle between two orientations; what is no number differs from nothing.
fn half_cosine(a: &[f32; 4], b: &[f32; 4]) -> f32 {
    let dot = |a: &[f32; 4], b: &[f32; 4]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f32>();
    dot(a, b).abs() / (dot(a, a) * dot(b, b)).sqrt()
}

/// All of them.
pub(super) fn whole(g: &Gaussians<'_>) -> GaussianSplats3D {
    let quaternions = g.rotations.iter().map(|&q| quaternion(q));
    centers(g).with_scales(scales(g)).with_quaternions(quaternions).with_colors(colours(g))
}

fn centers(g: &Gaussians<'_>) -> GaussianSplats3D {
    GaussianSplats3D::update_fields().with_centers(g.positions.iter().copied())
}

fn scales(g: &Gaussians<'_>) -> impl Iterator<Item = [f32; 3]> {
    g.log_scales.iter().map(|s| s.map(f32::exp))
}

fn colours(g: &Gaussians<'_>) -> impl Iterator<Item = Color> {
    g.sh_dc.iter().zip(g.opacity_logits).map(|(dc, logit)| {
        let [red, green, blue] = dc.map(|c| byte(0.5 + C0 * c));
        Color::from_unmultiplied_rgba(red, green, blue, byte(1.0 / (1.0 + (-logit).exp())))
    })
}

/// How their colours depend on the direction of view.
pub(super) fn bands(g: &Gaussians<'_>) -> GaussianSplats3D {
    let splats = GaussianSplats3D::update_fields().with_spherical_harmonics_degree(u32::from(g.sh_degree));
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
