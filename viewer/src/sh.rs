//! Colour of a Gaussian seen from a direction.

use cosplat_splat::sh::basis;

/// Y₀, the base band of spherical harmonics: 1 / (2 √π).
const C0: f64 = 0.282_094_791_773_878_14;

/// max(0, ½ + Y₀ dc + Σ Yⱼ(d) cⱼ), d from the camera to the Gaussian.
pub(crate) fn colour(dc: [f32; 3], rest: &[[f32; 3]], from_camera: [f64; 3]) -> [f32; 3] {
    let mut sum = dc.map(|c| 0.5 + C0 * f64::from(c));
    if !rest.is_empty() {
        let length = from_camera.iter().map(|v| v * v).sum::<f64>().sqrt();
        let basis = basis(from_camera.map(|v| v / length));
        for (y, c) in basis.iter().zip(rest) {
            for (s, &v) in sum.iter_mut().zip(c) {
                *s += y * f64::from(v);
            }
        }
    }
    sum.map(|s| s.max(0.0) as f32)
}
