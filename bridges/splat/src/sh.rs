//! Spherical harmonics in the convention of 3D Gaussian splatting, and their rotation band by band.

use std::f64::consts::PI;

use nalgebra::Matrix3;

const C1: f64 = 0.488_602_511_902_919_9;
const C2: [f64; 3] = [1.092_548_430_592_079_2, 0.315_391_565_252_520_05, 0.546_274_215_296_039_6];
const C3: [f64; 5] = [
    0.590_043_589_926_643_5,
    2.890_611_442_640_554,
    0.457_045_799_464_465_8,
    0.373_176_332_590_115_4,
    1.445_305_721_320_277,
];

/// Real spherical harmonics of bands 1 to 3 at a unit vector, with the signs and the order of Kerbl et al. (2023).
/// They are orthonormal on the unit sphere.
pub fn basis(d: [f64; 3]) -> [f64; 15] {
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

/// One half of the 26-point rule of Lebedev (1976), exact to degree 7; the other half is opposite, and products of two
/// functions of one band are the same there. Directions before normalisation, and weights that sum to ½.
const RULE: [([f64; 3], f64); 13] = {
    const AXIS: f64 = 1.0 / 21.0;
    const EDGE: f64 = 4.0 / 105.0;
    const CORNER: f64 = 9.0 / 280.0;
    [
        ([1.0, 0.0, 0.0], AXIS),
        ([0.0, 1.0, 0.0], AXIS),
        ([0.0, 0.0, 1.0], AXIS),
        ([1.0, 1.0, 0.0], EDGE),
        ([1.0, -1.0, 0.0], EDGE),
        ([1.0, 0.0, 1.0], EDGE),
        ([1.0, 0.0, -1.0], EDGE),
        ([0.0, 1.0, 1.0], EDGE),
        ([0.0, 1.0, -1.0], EDGE),
        ([1.0, 1.0, 1.0], CORNER),
        ([1.0, 1.0, -1.0], CORNER),
        ([1.0, -1.0, 1.0], CORNER),
        ([1.0, -1.0, -1.0], CORNER),
    ]
};

/// First coefficient and number of coefficients of bands 1 to 3.
const BANDS: [(usize, usize); 3] = [(0, 3), (3, 5), (8, 7)];

/// A rotation of coefficients: f′(d) = f(Rᵀ d).
#[derive(Clone, Debug)]
pub struct ShRotation {
    /// Block matrix, one block a band: rotated = matrix · coefficients.
    matrix: [[f64; 15]; 15],
    degree: u8,
}

impl ShRotation {
    /// The rotation by an orthogonal matrix R, for bands up to `degree` (at most 3).
    ///
    /// Entry (i, j) is ∫ Yᵢ(d) Yⱼ(Rᵀ d) dω, which the rule above gives exactly.
    pub fn new(rotation: &Matrix3<f64>, degree: u8) -> ShRotation {
        let mut matrix = [[0.0; 15]; 15];
        let back = rotation.transpose();
        let bands = &BANDS[..usize::from(degree.min(3))];
        for (direction, weight) in RULE {
            let d = nalgebra::Vector3::from(direction).normalize();
            let (here, there) = (basis(d.into()), basis((back * d).into()));
            for &(first, count) in bands {
                for i in first..first + count {
                    let scaled = 8.0 * PI * weight * here[i];
                    for j in first..first + count {
                        matrix[i][j] += scaled * there[j];
                    }
                }
            }
        }
        ShRotation { matrix, degree: degree.min(3) }
    }

    /// Rotates the higher-band coefficients of one Gaussian, all three channels.
    pub fn apply(&self, rest: &mut [[f32; 3]]) {
        for &(first, count) in &BANDS[..usize::from(self.degree)] {
            let Some(band) = rest.get_mut(first..first + count) else { return };
            let mut old = [[0.0_f64; 3]; 7];
            for (o, c) in old.iter_mut().zip(band.iter()) {
                *o = c.map(f64::from);
            }
            for (i, c) in band.iter_mut().enumerate() {
                let row = &self.matrix[first + i][first..first + count];
                *c = [0, 1, 2].map(|channel| row.iter().zip(&old).map(|(m, o)| m * o[channel]).sum::<f64>() as f32);
            }
        }
    }

    /// Rotates coefficients of one channel in double precision, as many as the bands have.
    pub fn apply_wide(&self, coefficients: &[f64; 15]) -> [f64; 15] {
        let mut out = [0.0; 15];
        for (o, row) in out.iter_mut().zip(&self.matrix) {
            *o = row.iter().zip(coefficients).map(|(m, c)| m * c).sum();
        }
        out
    }
}
