//! The smoothing kernel.

/// Smoothing length over particle spacing.
pub(crate) const SMOOTHING: f64 = 1.2;

/// Wendland's C2 kernel in three dimensions, `W = α (1 - q/2)⁴ (1 + 2q)`, `q = r/h ≤ 2`, `α = 21/(16 π h³)`.
///
/// Source: Wendland, "Piecewise polynomial, positive definite and compactly supported radial functions of minimal degree"
/// (1995); it does not pair particles up (Dehnen and Aly 2012).
#[derive(Clone, Copy, Debug)]
pub(crate) struct Kernel {
    /// Smoothing length h \[m\].
    pub(crate) h: f64,
    /// Radius of the support, 2h \[m\].
    pub(crate) reach: f64,
    pub(crate) half_inverse: f64,
    pub(crate) alpha: f64,
    pub(crate) slope: f64,
    /// Sum over a cubic lattice, times the volume of its cells.
    lattice_sum: f64,
}

impl Kernel {
    /// For particles that far apart \[m\].
    pub(crate) fn new(spacing: f64) -> Self {
        let h = SMOOTHING * spacing;
        let alpha = 21.0 / (16.0 * std::f64::consts::PI * h * h * h);
        let slope = -5.0 * alpha / (h * h);
        let mut kernel = Self { h, reach: 2.0 * h, half_inverse: 0.5 / h, alpha, slope, lattice_sum: 0.0 };
        for (i, j, k) in (-2..=2).flat_map(|i| (-2..=2).flat_map(move |j| (-2..=2).map(move |k| (i, j, k)))) {
            kernel.lattice_sum += kernel.weight(f64::from(i * i + j * j + k * k).sqrt() * spacing);
        }
        kernel.lattice_sum *= spacing * spacing * spacing;
        kernel
    }

    /// The same, scaled so that its sum over a cubic lattice is exactly one.
    pub(crate) fn scaled(&self) -> Self {
        let one = 1.0 / self.lattice_sum;
        Self { alpha: self.alpha * one, slope: self.slope * one, ..*self }
    }

    /// What a lattice below a plane fills of the kernel around a place half a spacing above it, scaled as above: what the own
    /// layer of a full lattice leaves to both sides.
    pub(crate) fn half_space(&self, spacing: f64) -> f64 {
        let layer = (-2..=2).flat_map(|i| (-2..=2).map(move |j| f64::from(i * i + j * j).sqrt() * spacing));
        let filled = layer.map(|r| self.weight(r)).sum::<f64>() * spacing * spacing * spacing;
        0.5 * (1.0 - filled / self.lattice_sum)
    }

    /// `W(r)` \[1/m³\].
    #[inline]
    pub(crate) fn weight(&self, r: f64) -> f64 {
        let t = (1.0 - r * self.half_inverse).max(0.0);
        let square = t * t;
        self.alpha * square * square * (5.0 - 4.0 * t)
    }

    /// `W'(r)/r` \[1/m⁵\]: times `x_i - x_j` it is the gradient at `x_i`. Not positive.
    #[inline]
    pub(crate) fn slope(&self, r: f64) -> f64 {
        let t = (1.0 - r * self.half_inverse).max(0.0);
        self.slope * t * t * t
    }

    /// How much more volume one layer of boundary particles must have to press as a full wall does: the first moment of
    /// the gradient over all pairs of layers on both sides of a plane, over that of the pairs with the first layer.
    pub(crate) fn single_layer(&self, spacing: f64) -> f64 {
        let pull = |z: f64| {
            let mut sum = 0.0;
            for (i, j) in (-3..=3).flat_map(|i| (-3..=3).map(move |j| (f64::from(i), f64::from(j)))) {
                let r = (i * i + j * j).mul_add(spacing * spacing, z * z).sqrt();
                sum += self.slope(r) * z;
            }
            sum
        };
        let near = pull(spacing) + pull(2.0 * spacing);
        (near + pull(2.0 * spacing)) / near
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_kernel_is_one_on_a_lattice_and_its_slope_is_its_derivative() {
        let (d, kernel) = (0.01, Kernel::new(0.01));
        let (mut sum, mut first) = (0.0, 0.0);
        for (i, j, k) in (-3..=3).flat_map(|i| (-3..=3).flat_map(move |j| (-3..=3).map(move |k| (i, j, k)))) {
            let [x, y, z] = [i, j, k].map(|n| f64::from(n) * d);
            let r = (x * x + y * y + z * z).sqrt();
            sum += kernel.weight(r) * d * d * d;
            first -= kernel.slope(r) * x * x * d * d * d;
        }
        println!("sum {sum}, first moment of the gradient {first}, single layer {}", kernel.single_layer(d));
        // Quadrature with 1.2 points per smoothing length: 1.75 % and 1.5 %, which a larger ratio would lower.
        assert!((sum - 1.0).abs() < 0.02 && (first - 1.0).abs() < 0.02, "{sum} {first}");
        for r in [0.002, 0.011, 0.023] {
            let by_difference = (kernel.weight(r + 1e-8) - kernel.weight(r - 1e-8)) / 2e-8;
            // Central difference: roundings of 1e-16 W over 2e-8 m.
            assert!((kernel.slope(r) * r / by_difference - 1.0).abs() < 1e-6);
        }
        assert!(kernel.weight(0.0241).abs() < 1e-300 && kernel.slope(0.0241).abs() < 1e-300);
    }
}
