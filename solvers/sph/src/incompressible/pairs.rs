//! Pairs stored in single precision for the many passes of a solution: gradient \[1/m⁴\] and weight \[1/m³\] of each, 16 bytes
//! beside the 4 of its list. What is exact, the impulses of the pressures found, is computed anew from the places.

use wide::{f32x4, f64x4};

/// Pairs of a chunk, in the order of its lists.
#[derive(Clone, Debug, Default)]
pub(crate) struct Pairs(Vec<f32x4>);

/// What is left of them.
pub(crate) struct Rest<'a>(&'a [f32x4]);

impl Pairs {
    /// Forgets all, with room for `count`.
    pub(crate) fn clear(&mut self, count: usize) {
        self.0.clear();
        self.0.reserve_exact(count);
    }

    /// Adds four, of which `gradient` has the components.
    #[inline]
    pub(crate) fn push(&mut self, gradient: [f64x4; 3], weight: f64x4) {
        let [x, y, z, w] = [gradient[0], gradient[1], gradient[2], weight].map(f64x4::to_array);
        self.0.extend([0, 1, 2, 3].map(|l| f32x4::new([x[l] as f32, y[l] as f32, z[l] as f32, w[l] as f32])));
    }

    /// From the first on.
    pub(crate) fn rest(&self) -> Rest<'_> {
        Rest(&self.0)
    }
}

impl<'a> Rest<'a> {
    /// Those of the next row, which has `count`.
    #[inline]
    pub(crate) fn row(&mut self, count: usize) -> &'a [f32x4] {
        let (row, rest) = self.0.split_at_checked(count).unwrap_or_default();
        self.0 = rest;
        row
    }
}

/// `Σ u_j (∇W_ij, W_ij)`.
#[inline]
pub(crate) fn along(list: &[u32], row: &[f32x4], u: &[f32]) -> [f64; 4] {
    let (mut even, mut odd) = (f32x4::ZERO, f32x4::ZERO);
    for (j, g) in list.chunks_exact(2).zip(row.chunks_exact(2)) {
        even += g[0] * f32x4::splat(u[j[0] as usize]);
        odd += g[1] * f32x4::splat(u[j[1] as usize]);
    }
    (even + odd).to_array().map(f64::from)
}

/// `Σ m_j·∇W_ij` over the first three components of `m`, and `Σ m_j W_ij` with the fourth.
#[inline]
pub(crate) fn across(list: &[u32], row: &[f32x4], m: &[f32x4]) -> [f64; 2] {
    let (mut even, mut odd) = (f32x4::ZERO, f32x4::ZERO);
    for (j, g) in list.chunks_exact(2).zip(row.chunks_exact(2)) {
        even += g[0] * m[j[0] as usize];
        odd += g[1] * m[j[1] as usize];
    }
    let [x, y, z, w] = (even + odd).to_array().map(f64::from);
    [x + y + z, w]
}
