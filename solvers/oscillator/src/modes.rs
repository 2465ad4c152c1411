//! Normal modes of the masses of one solver, and their exact motion over a stretch of time.

use nalgebra::{DMatrix, SymmetricEigen};

use crate::V3;
use crate::stumpff::stumpff;

/// Polynomial in τ: coefficients of `1, τ, τ², τ³`.
pub(crate) type Cubic = [V3; 4];

/// `k!` for the degrees of a path.
const FACTORIAL: [f64; 4] = [1.0, 1.0, 2.0, 6.0];

/// Sweeps of the eigenvalue iteration per row before it counts as failed; it needs two or three.
const SWEEPS_PER_ROW: usize = 100;

/// Modes of `M x'' = -K x`, with `K` the same along each axis.
///
/// `K_s = M^-1/2 K M^-1/2 = U Λ Uᵀ`; a displacement is `d = M^-1/2 U q` and each mode obeys `q'' + λ q = p(τ)`.
#[derive(Clone, Debug)]
pub(crate) struct Modes {
    /// Squared angular frequencies λ \[1/s²\].
    lambda: Vec<f64>,
    /// `M^-1/2 U` \[kg^-1/2\].
    shape: DMatrix<f64>,
    /// `M^1/2` \[kg^1/2\].
    root_mass: Vec<f64>,
}

/// How one body moves over a stretch of time, from its place at the start of it.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Motion {
    /// Displacement at the end \[m\].
    pub(crate) displacement: V3,
    /// Velocity at the end \[m/s\].
    pub(crate) velocity: V3,
    /// `∫ τ^k d(τ) dτ`, k = 0..=3 \[m s^(k+1)\].
    pub(crate) moments: Cubic,
}

impl Modes {
    /// Diagonalises; `stiffness` \[N/m\] must be symmetric and positive semidefinite. `None` if the iteration fails.
    pub(crate) fn new(mass: &[f64], stiffness: &DMatrix<f64>) -> Option<Self> {
        let root_mass: Vec<f64> = mass.iter().map(|m| m.sqrt()).collect();
        let n = mass.len();
        if n == 0 {
            return Some(Self { lambda: Vec::new(), shape: DMatrix::zeros(0, 0), root_mass });
        }
        let scaled = DMatrix::from_fn(n, n, |i, j| stiffness[(i, j)] / (root_mass[i] * root_mass[j]));
        let eigen = SymmetricEigen::try_new(scaled, f64::EPSILON, SWEEPS_PER_ROW * n)?;
        // Springs only pull back: a negative value is the rounding of a zero.
        let lambda = eigen.eigenvalues.iter().map(|&l| l.max(0.0)).collect();
        let shape = DMatrix::from_fn(n, n, |i, j| eigen.eigenvectors[(i, j)] / root_mass[i]);
        Some(Self { lambda, shape, root_mass })
    }

    /// Largest angular frequency \[rad/s\].
    #[cfg(test)]
    pub(crate) fn fastest(&self) -> f64 {
        self.lambda.iter().copied().fold(0.0, f64::max).sqrt()
    }

    /// Motion of every body over `length` \[s\], from its velocities and the forces on it if nothing moved.
    ///
    /// `force[i][k]` is the coefficient of `τ^k` of the force on body `i` \[N/s^k\], springs at their length of the start
    /// included: only differences of positions enter, so that a system far from the origin loses no digits. With
    /// `q(0) = 0`, `q'(0) = s` and forcing `Σ p_k τ^k`: `q = s S_1 + Σ k! p_k S_{k+2}`.
    pub(crate) fn motion(&self, velocity: &[V3], force: &[Cubic], length: f64) -> Vec<Motion> {
        let n = self.lambda.len();
        let mut out = vec![Motion::default(); n];
        for (mode, &lambda) in self.lambda.iter().enumerate() {
            let mut speed = V3::zeros();
            let mut forcing = [V3::zeros(); 4];
            for i in 0..n {
                let shape = self.shape[(i, mode)];
                speed += velocity[i] * (shape * self.root_mass[i] * self.root_mass[i]);
                for k in 0..4 {
                    forcing[k] += force[i][k] * (shape * FACTORIAL[k]);
                }
            }
            let s = stumpff(lambda, length);
            let combine = |of: &dyn Fn(usize) -> f64| (0..4).fold(speed * of(1), |sum, k| sum + forcing[k] * of(k + 2));
            let displacement = combine(&|n| s[n]);
            let rate = combine(&|n| s[n - 1]);
            let moments = [0, 1, 2, 3].map(|k| combine(&|n| moment(&s, k, n, length)));
            for (i, motion) in out.iter_mut().enumerate() {
                let shape = self.shape[(i, mode)];
                motion.displacement += displacement * shape;
                motion.velocity += rate * shape;
                for (sum, part) in motion.moments.iter_mut().zip(moments) {
                    *sum += part * shape;
                }
            }
        }
        out
    }
}

/// `∫ τ^k S_n(τ) dτ = Σ_j (-1)^j k!/(k-j)! W^(k-j) S_{n+1+j}(W)`, by parts.
fn moment(s: &[f64], k: usize, n: usize, length: f64) -> f64 {
    let mut factor: f64 = (0..k).map(|_| length).product();
    let mut sum = 0.0;
    for j in 0..=k {
        sum += factor * s[n + 1 + j];
        factor *= -((k - j) as f64) / length;
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Classical Runge-Kutta with many steps: an independent way to the same motion.
    fn by_steps(mass: &[f64], k: &DMatrix<f64>, v0: &[V3], force: &[Cubic], length: f64) -> Vec<Motion> {
        let n = mass.len();
        let steps = 4000;
        let h = length / f64::from(steps);
        let mut state: Vec<Motion> = v0.iter().map(|&velocity| Motion { velocity, ..Motion::default() }).collect();
        let rate = |state: &[Motion], t: f64| -> Vec<Motion> {
            (0..n)
                .map(|i| {
                    let poly = force[i].iter().rev().fold(V3::zeros(), |sum, c| sum * t + c);
                    let springs = (0..n).fold(V3::zeros(), |sum, j| sum + state[j].displacement * k[(i, j)]);
                    Motion {
                        displacement: state[i].velocity,
                        velocity: (poly - springs) / mass[i],
                        moments: [0, 1, 2, 3].map(|p| state[i].displacement * t.powi(p)),
                    }
                })
                .collect()
        };
        let moved = |state: &[Motion], rate: &[Motion], h: f64| -> Vec<Motion> {
            state
                .iter()
                .zip(rate)
                .map(|(s, r)| Motion {
                    displacement: s.displacement + r.displacement * h,
                    velocity: s.velocity + r.velocity * h,
                    moments: [0, 1, 2, 3].map(|p| s.moments[p] + r.moments[p] * h),
                })
                .collect()
        };
        for step in 0..steps {
            let t = f64::from(step) * h;
            let a = rate(&state, t);
            let b = rate(&moved(&state, &a, h / 2.0), t + h / 2.0);
            let c = rate(&moved(&state, &b, h / 2.0), t + h / 2.0);
            let d = rate(&moved(&state, &c, h), t + h);
            for (r, w) in [(a, 1.0), (b, 2.0), (c, 2.0), (d, 1.0)] {
                state = moved(&state, &r, w * h / 6.0);
            }
        }
        state
    }

    #[test]
    fn three_masses_under_cubic_forces_move_as_runge_kutta_says() {
        let mass = [1.0, 2.5, 0.4];
        // Springs 1-2 and 2-3 and none to the world: one mode is free.
        let (p, q) = (30.0, 70.0);
        let k = DMatrix::from_row_slice(3, 3, &[p, -p, 0.0, -p, p + q, -q, 0.0, -q, q]);
        let modes = Modes::new(&mass, &k).unwrap();
        assert!(modes.fastest() > 10.0);
        let v0 = [V3::new(0.3, -1.0, 2.0), V3::new(0.0, 0.5, -0.2), V3::new(-1.0, 0.1, 0.0)];
        let force: Vec<Cubic> = (0..3)
            .map(|i| [0, 1, 2, 3].map(|p| V3::new(f64::from(i) + 1.0, f64::from(p) - 1.0, 0.7 * f64::from(i * p))))
            .collect();
        let exact = modes.motion(&v0, &force, 0.8);
        let stepped = by_steps(&mass, &k, &v0, &force, 0.8);
        for (e, s) in exact.iter().zip(&stepped) {
            // Runge-Kutta of order 4 at ω h = 0.003 is good to (ω h)^4 ≈ 1e-10.
            assert!((e.displacement - s.displacement).norm() < 1e-10);
            assert!((e.velocity - s.velocity).norm() < 1e-9);
            for p in 0..4 {
                assert!((e.moments[p] - s.moments[p]).norm() < 1e-10, "moment {p}");
            }
        }
    }

    #[test]
    fn a_mass_without_spring_flies_on_a_parabola() {
        let modes = Modes::new(&[2.0], &DMatrix::zeros(1, 1)).unwrap();
        let weight = V3::new(0.0, 0.0, -19.62);
        let motion = modes.motion(&[V3::new(3.0, 0.0, 4.0)], &[[weight, V3::zeros(), V3::zeros(), V3::zeros()]], 0.8);
        // Two roundings of numbers of order one.
        assert!((motion[0].displacement - V3::new(2.4, 0.0, 3.2 - 0.5 * 9.81 * 0.64)).norm() < 1e-14);
        assert!((motion[0].velocity - V3::new(3.0, 0.0, 4.0 - 9.81 * 0.8)).norm() < 1e-14);
    }
}
