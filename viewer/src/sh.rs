//! Colour of a Gaussian seen from a direction.

const C0: f64 = 0.282_094_791_773_878_14;
const C1: f64 = 0.488_602_511_902_919_9;
const C2: [f64; 3] = [1.092_548_430_592_079_2, 0.315_391_565_252_520_05, 0.546_274_215_296_039_6];
const C3: [f64; 5] = [
    0.590_043_589_926_643_5,
    2.890_611_442_640_554,
    0.457_045_799_464_465_8,
    0.373_176_332_590_115_4,
    1.445_305_721_320_277,
];

/// Real spherical harmonics above the base band, with the signs and the order of 3D Gaussian splatting (Kerbl et al.
/// 2023), at a unit vector.
pub(crate) fn basis(d: [f64; 3]) -> [f64; 15] {
    let [x, y, z] = d;
    let (xx, yy, zz) = (x * x, y * y, z * z);
    [
        -C1 * y,
        C1 * z,
        -C1 * x,
        C2[0] * x * y,
        -C2[0] * y * z,
        C2[1] * (2.0 * zz - xx - yy),
        -C2[0] * x * z,
        C2[2] * (xx - yy),
        -C3[0] * y * (3.0 * xx - yy),
        C3[1] * x * y * z,
        -C3[2] * y * (4.0 * zz - xx - yy),
        C3[3] * z * (2.0 * zz - 3.0 * xx - 3.0 * yy),
        -C3[2] * x * (4.0 * zz - xx - yy),
        C3[4] * z * (xx - yy),
        -C3[0] * x * (xx - 3.0 * yy),
    ]
}

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
