//! Poisson's equation with a weight on each face: `Σ_f k_f (x - x_neighbour)` in every cell.

use std::ops::{Add, Mul, Sub};

/// A real number, double for what is solved and single for what only guides it.
pub(crate) trait Real:
    Copy + Default + Send + Sync + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self>
{
}

impl Real for f32 {}
impl Real for f64 {}

/// The equation on one level, its arrays padded by one cell on every side.
#[derive(Clone, Debug, Default)]
pub(crate) struct Matrix<T> {
    /// Cells along each axis.
    pub(crate) n: [usize; 3],
    /// Distance in the arrays of neighbours along each axis.
    pub(crate) s: [usize; 3],
    /// Weight of the lower face of each cell along each axis.
    pub(crate) k: [Vec<T>; 3],
}

impl<T: Real> Matrix<T> {
    /// For that many cells, with all weights zero.
    pub(crate) fn new(n: [usize; 3]) -> Self {
        let all = n.map(|n| n + 2);
        let none = vec![T::default(); all.iter().product()];
        Self { n, s: [1, all[0], all[0] * all[1]], k: [none.clone(), none.clone(), none] }
    }

    /// Number of the cell at `c`; -1 and `n` are outside.
    pub(crate) fn at(&self, c: [isize; 3]) -> usize {
        (0..3).map(|k| (c[k] + 1) as usize * self.s[k]).sum()
    }

    /// Length of the arrays.
    pub(crate) fn size(&self) -> usize {
        self.k[0].len()
    }

    /// First cells of the rows of a plane `z` of the padded arrays, in that plane; none in padding.
    pub(crate) fn rows(&self, z: usize) -> impl Iterator<Item = usize> + use<T> {
        let (inside, s, n) = ((1..=self.n[2]).contains(&z), self.s[1], self.n[1]);
        (1..=if inside { n } else { 0 }).map(move |y| y * s + 1)
    }

    /// The equation's left side for `x`, into `out`, in the cells of the row that begins at number `first`.
    pub(crate) fn row(&self, x: &[T], first: usize, out: &mut [T]) {
        let (n, [_, sy, sz]) = (out.len(), self.s);
        let middle = &x[first..first + n];
        let (west, east) = (&x[first - 1..first - 1 + n], &x[first + 1..first + 1 + n]);
        let (south, north) = (&x[first - sy..first - sy + n], &x[first + sy..first + sy + n]);
        let (down, up) = (&x[first - sz..first - sz + n], &x[first + sz..first + sz + n]);
        let [kx, ky, kz] = &self.k;
        let (kw, ke) = (&kx[first..first + n], &kx[first + 1..first + 1 + n]);
        let (ks, kn) = (&ky[first..first + n], &ky[first + sy..first + sy + n]);
        let (kd, ku) = (&kz[first..first + n], &kz[first + sz..first + sz + n]);
        for (i, out) in out.iter_mut().enumerate() {
            let c = middle[i];
            *out = kw[i] * (c - west[i])
                + ke[i] * (c - east[i])
                + ks[i] * (c - south[i])
                + kn[i] * (c - north[i])
                + kd[i] * (c - down[i])
                + ku[i] * (c - up[i]);
        }
    }
}

/// Sum of products, four at a time: a fixed order, and one that the processor can keep up with.
pub(crate) fn dot<B: Copy>(a: &[f64], b: &[B]) -> f64
where
    f64: From<B>,
{
    let mut sums = [0.0; 4];
    for (a, b) in a.chunks(4).zip(b.chunks(4)) {
        for (sum, (a, b)) in sums.iter_mut().zip(a.iter().zip(b)) {
            *sum += a * f64::from(*b);
        }
    }
    sums.iter().sum()
}
