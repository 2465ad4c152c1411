//! Small matrices, robust for every finite input.

use nalgebra::{Matrix3, Rotation3, UnitQuaternion, Vector3};

/// Sweeps after which the columns are taken as they are; convergence is quadratic and needs fewer than ten.
const SWEEPS: usize = 40;
/// Cosine of the angle between two columns that counts as none.
const PERPENDICULAR: f64 = 1e-15;

/// m = u · diag(s) · vᵀ, u and v orthogonal, s ≥ 0 in the order of the columns of m.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Svd {
    pub(crate) u: Matrix3<f64>,
    pub(crate) s: [f64; 3],
    pub(crate) v: Matrix3<f64>,
}

/// One-sided Jacobi: columns of m are rotated until they are perpendicular (Hestenes 1958).
///
/// Small singular values come out with full relative accuracy, and columns that are perpendicular stay as they are, so
/// the axes of a Gaussian that is only rotated are not mixed. Every entry must be finite.
pub(crate) fn svd(m: &Matrix3<f64>) -> Svd {
    let largest = m.amax();
    if largest == 0.0 {
        return Svd { u: Matrix3::identity(), s: [0.0; 3], v: Matrix3::identity() };
    }
    let (mut a, mut v) = (m / largest, Matrix3::identity());
    for _ in 0..SWEEPS {
        let mut turned = false;
        for (p, q) in [(0, 1), (0, 2), (1, 2)] {
            let (alpha, beta) = (a.column(p).norm_squared(), a.column(q).norm_squared());
            let gamma = a.column(p).dot(&a.column(q));
            if gamma.abs() <= PERPENDICULAR * alpha.sqrt() * beta.sqrt() {
                continue;
            }
            turned = true;
            let zeta = (beta - alpha) / (2.0 * gamma);
            let t = zeta.signum() / (zeta.abs() + (1.0 + zeta * zeta).sqrt());
            let c = 1.0 / (1.0 + t * t).sqrt();
            turn(&mut a, p, q, c, c * t);
            turn(&mut v, p, q, c, c * t);
        }
        if !turned {
            break;
        }
    }
    let s = [0, 1, 2].map(|k| a.column(k).norm());
    let u = orthonormal(&a, s);
    Svd { u, s: s.map(|v| v * largest), v }
}

/// Columns p and q turned in their plane.
fn turn(m: &mut Matrix3<f64>, p: usize, q: usize, c: f64, s: f64) {
    for row in 0..3 {
        let (x, y) = (m[(row, p)], m[(row, q)]);
        m[(row, p)] = c * x - s * y;
        m[(row, q)] = s * x + c * y;
    }
}

/// Columns divided by their lengths; columns without a length are completed to a right-handed basis.
fn orthonormal(a: &Matrix3<f64>, lengths: [f64; 3]) -> Matrix3<f64> {
    let mut u = Matrix3::zeros();
    let there: Vec<usize> = (0..3).filter(|&k| lengths[k] > 1e-150).collect();
    for &k in &there {
        u.set_column(k, &(a.column(k) / lengths[k]));
    }
    match there[..] {
        [k] => {
            let first = u.column(k).into_owned();
            let second = perpendicular(&first);
            u.set_column((k + 1) % 3, &second);
            u.set_column((k + 2) % 3, &first.cross(&second));
        }
        [j, k] => {
            let missing = 3 - j - k;
            let (p, q) = ((missing + 1) % 3, (missing + 2) % 3);
            let third = u.column(p).cross(&u.column(q));
            u.set_column(missing, &third);
        }
        _ => {}
    }
    u
}

/// A unit vector perpendicular to a unit vector.
pub(crate) fn perpendicular(v: &Vector3<f64>) -> Vector3<f64> {
    let axis = Vector3::ith(v.iamin(), 1.0);
    v.cross(&axis).normalize()
}

/// The rotation nearest to m: u vᵀ, the column of the smallest singular value turned round where that is a reflection.
pub(crate) fn polar_rotation(m: &Matrix3<f64>) -> Matrix3<f64> {
    let Svd { mut u, s, v } = svd(m);
    if (u * v.transpose()).determinant() < 0.0 {
        let smallest = Vector3::from(s).imin();
        let turned = -u.column(smallest);
        u.set_column(smallest, &turned);
    }
    u * v.transpose()
}

/// Rotation matrix of a quaternion w, x, y, z of any length; zero and non-finite ones are the identity.
pub(crate) fn rotation_of(q: [f32; 4]) -> Matrix3<f64> {
    let [w, x, y, z] = q.map(f64::from);
    let norm = (w * w + x * x + y * y + z * z).sqrt();
    if norm <= 0.0 || !norm.is_finite() {
        return Matrix3::identity();
    }
    let q = nalgebra::Quaternion::new(w / norm, x / norm, y / norm, z / norm);
    UnitQuaternion::new_unchecked(q).to_rotation_matrix().into_inner()
}

/// Quaternion w, x, y, z of a rotation matrix, of the two signs the one nearer to `near`.
pub(crate) fn quaternion_of(m: &Matrix3<f64>, near: [f32; 4]) -> [f32; 4] {
    let q = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(*m)).into_inner();
    let q = [q.w, q.i, q.j, q.k];
    let along: f64 = q.iter().zip(near).map(|(a, b)| a * f64::from(b)).sum();
    q.map(|v| if along < 0.0 { -v } else { v } as f32)
}

/// A point of single precision in double precision.
pub(crate) fn wide(p: [f32; 3]) -> Vector3<f64> {
    Vector3::from(p.map(f64::from))
}

/// Whether every entry is finite.
pub(crate) fn finite(m: &Matrix3<f64>) -> bool {
    m.iter().all(|v| v.is_finite())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn check(m: Matrix3<f64>) {
        let Svd { u, s, v } = svd(&m);
        let scale = m.amax().max(1e-300);
        let back = u * Matrix3::from_diagonal(&Vector3::from(s)) * v.transpose();
        assert!((back - m).amax() <= 4e-15 * scale, "{m} {back}");
        for q in [u, v, polar_rotation(&m)] {
            assert!((q.transpose() * q - Matrix3::identity()).amax() < 1e-14, "{q}");
        }
        assert!(polar_rotation(&m).determinant() > 0.0);
    }

    #[test]
    fn any_matrix_is_taken_apart_and_put_together() {
        let r = Rotation3::from_euler_angles(0.3, -1.2, 2.5).into_inner();
        let l = Rotation3::from_euler_angles(-2.3, 0.2, 0.5).into_inner();
        let diagonals =
            [[1.0, 2.0, 3.0], [1.0, 1.0, 1.0], [1e-12, 1.0, 1e12], [0.0, 1.0, 2.0], [0.0, 0.0, 5.0], [0.0; 3]];
        for d in diagonals {
            let d = Matrix3::from_diagonal(&Vector3::from(d));
            for m in [d, l * d, l * d * r, -(l * d * r)] {
                check(m);
            }
        }
        check(Matrix3::new(1.0, 2.0, 3.0, 2.0, 4.0, 6.0, 1.0, 2.0, 3.0));
        check(Matrix3::identity() * 1e-300);
    }

    #[test]
    fn polar_rotation_of_a_stretched_rotation() {
        let r = Rotation3::from_euler_angles(0.3, -1.2, 2.5).into_inner();
        let stretch = Matrix3::new(2.0, 0.3, 0.1, 0.3, 1.0, -0.2, 0.1, -0.2, 0.5);
        assert!((polar_rotation(&(r * stretch)) - r).amax() < 1e-14);
    }
}
