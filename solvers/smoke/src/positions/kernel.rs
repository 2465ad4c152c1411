//! What a neighbour adds to the density, as a share of the density at rest.

use std::f64::consts::PI;

/// Reach of the kernel, in spacings: on the lattice 26 neighbours.
const REACH: f64 = 2.0;

/// The kernel `w(r) = (1 - r/H)³` (Desbrun and Gascuel 1996, "spiky"), for densities and for their gradients, over its
/// sum on the lattice on which bodies begin: there the density is that at rest.
///
/// Position-based fluids take another one for densities (Müller 2003, "poly6"), whose multipliers then do not belong to
/// their constraints.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Kernel {
    /// H \[m\].
    pub(crate) reach: f64,
    /// Sum of the squares of the gradient's terms on the lattice \[1/m²\].
    pub(crate) stiffness: f64,
    /// Share of all neighbours on the lattice.
    pub(crate) others: f64,
    /// One over the sum of the kernel on the lattice.
    unit: f64,
    /// Share of a wall, over that of a continuum behind it.
    wall: f64,
}

impl Kernel {
    /// For particles on a lattice with that spacing \[m\].
    pub(crate) fn new(spacing: f64) -> Self {
        let reach = REACH * spacing;
        let bare = Self { reach, stiffness: 0.0, others: 0.0, unit: 1.0, wall: 1.0 };
        let (mut sum, mut squares, mut behind) = (0.0, 0.0, 0.0);
        for (x, y, z) in (-2..=2).flat_map(|z| (-2..=2).flat_map(move |y| (-2..=2).map(move |x| (x, y, z)))) {
            let r = spacing * f64::from(x * x + y * y + z * z).sqrt();
            sum += bare.share(r);
            if r > 0.0 {
                squares += bare.slope(r) * bare.slope(r);
            }
            if z < 0 {
                behind += bare.share(r);
            }
        }
        let unit = 1.0 / sum;
        let wall = behind / bare.behind(0.5 * spacing).0;
        Self { reach, stiffness: squares * unit * unit, others: 1.0 - unit, unit, wall }
    }

    /// Share of a neighbour at distance `r` \[m\].
    #[inline]
    pub(crate) fn share(&self, r: f64) -> f64 {
        let left = (1.0 - r / self.reach).max(0.0);
        self.unit * left * left * left
    }

    /// Its derivative \[1/m\].
    #[inline]
    pub(crate) fn slope(&self, r: f64) -> f64 {
        let left = (1.0 - r / self.reach).max(0.0);
        -3.0 * self.unit / self.reach * left * left
    }

    /// Part of the neighbours whose places are behind a plane wall at distance `d` \[m\].
    pub(crate) fn covered(&self, d: f64) -> f64 {
        self.behind(d).0 / self.others
    }

    /// Share of a plane wall at distance `d` \[m\] and its derivative \[1/m\]: that of a continuum behind it, but such
    /// that a lattice that ends half a spacing before a wall is at rest.
    pub(crate) fn behind(&self, d: f64) -> (f64, f64) {
        let left = (1.0 - d.max(0.0) / self.reach).max(0.0);
        // ∫ (1 - s)³ s ds from q to 1 is (1-q)⁴/4 - (1-q)⁵/5, a disc; discs add up to (1-q)⁵/20 - (1-q)⁶/30.
        let [four, five] = [left.powi(4), left.powi(5)];
        let by = 2.0 * PI * (REACH * REACH * REACH) * self.unit * self.wall;
        (by * (five / 20.0 - five * left / 30.0), -by / self.reach * (four / 4.0 - five / 5.0))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slopes_are_derivatives_and_a_wall_completes_the_lattice() {
        let kernel = Kernel::new(0.1);
        let eps = 1e-6;
        for r in [0.03, 0.1, 0.17] {
            let slope = (kernel.share(r + eps) - kernel.share(r - eps)) / (2.0 * eps);
            let wall = (kernel.behind(r + eps).0 - kernel.behind(r - eps).0) / (2.0 * eps);
            // Of second order in a thousandth of the reach, of numbers of order ten.
            assert!((slope - kernel.slope(r)).abs() < 1e-7 && (wall - kernel.behind(r).1).abs() < 1e-7, "{slope}");
        }
        let near = |z: i32| {
            let all = (-2..=2).flat_map(|y| (-2..=2).map(move |x| f64::from(x * x + y * y + z * z)));
            all.map(|s: f64| kernel.share(0.1 * s.sqrt())).sum::<f64>()
        };
        // To rounding.
        assert!((near(0) + 2.0 * near(1) + 2.0 * near(2) - 1.0).abs() < 1e-14);
        assert!((near(0) + near(1) + near(2) + kernel.behind(0.05).0 - 1.0).abs() < 1e-14);
        assert!(kernel.behind(0.2).0 < 1e-15 && kernel.share(0.2) < 1e-15);
    }
}
