//! What a particle meets of a layer of samples.
//!
//! Samples near the particle count, the nearest most. Their surface goes through their weighted middle `m`, across the
//! direction from there to the particle less what of it lies within the layer: `n ∝ (C + ε)⁻¹ (x - m)`, with the covariance
//! C of their places. A layer is met as a plane, its rim as an edge and a single sample as a ball, from either side; what
//! normals samples show is not needed, which at an edge are those of neither face.
//!
//! Contact acts at `m`, with the samples' shares: `Σ s_i x_i = m`, so that momentum and its moment are exact.

use cosplat_core::boundary::{SampleStatics, Vec3, add, dot, scale, sub};
use nalgebra::{Matrix3, Vector3};

/// Width of a sample that has neither a volume nor an area \[m\].
const NO_WIDTH: f64 = 1e-3;
/// Samples act on a particle up to this far aside, in widths of the larger of the two: more than half the diagonal of a
/// square lattice, so that none falls through between them, and little more, so that an edge is where it is.
const ASIDE: f64 = 1.2;
/// Unevenness of a layer of samples that is no tilt, as a variance in squares of their width.
const FLAT: f64 = 4e-3;

/// What never changes about a partner's samples.
#[derive(Clone, Debug, Default)]
pub(crate) struct Marks {
    /// Distance of the surface from the middle of each \[m\].
    half: Vec<f64>,
    /// 1 / mass \[1/kg\].
    inverse: Vec<f64>,
    /// Greatest width \[m\].
    width: f64,
}

/// What a particle meets of a layer of samples.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Patch {
    /// From the particle to the middle of the samples, as their shares have it \[m\].
    pub(crate) way: Vec3,
    /// Towards the particle.
    pub(crate) normal: Vec3,
    /// Distance of the particle's middle from their surface \[m\].
    pub(crate) distance: f64,
    /// Samples and their shares, whose sum is 1.
    pub(crate) shares: Vec<(u32, f64)>,
}

impl Marks {
    /// From what a partner said; nothing where a sample has no mass.
    pub(crate) fn new(statics: &SampleStatics) -> Option<Self> {
        let count = statics.len();
        let columns = [statics.area_m2.len(), statics.volume_m3.len(), statics.mass_kg.len()];
        if columns != [count; 3] || !statics.mass_kg.iter().all(|m| m.is_finite() && *m > 0.0) {
            return None;
        }
        let half: Vec<f64> = statics.volume_m3.iter().map(|&v| 0.5 * libm::cbrt(v.max(0.0))).collect();
        let thickest = 2.0 * half.iter().copied().fold(0.0, f64::max);
        let across = || statics.area_m2.iter().map(|a| a.max(0.0).sqrt()).fold(0.0, f64::max);
        let width = if thickest > 0.0 { thickest } else { across() };
        let inverse = statics.mass_kg.iter().map(|m| 1.0 / m).collect();
        Some(Self { half, inverse, width: if width > 0.0 { width } else { NO_WIDTH } })
    }

    /// Number of samples.
    pub(crate) fn len(&self) -> usize {
        self.half.len()
    }

    /// Distance up to which samples act on a particle as wide as twice `half` \[m\].
    pub(crate) fn reach(&self, half: f64) -> f64 {
        (half + 0.5 * self.width).hypot(ASIDE * self.width.max(2.0 * half))
    }

    /// Velocity per impulse of a patch \[1/kg\].
    pub(crate) fn gives(&self, shares: &[(u32, f64)]) -> f64 {
        shares.iter().map(|&(i, share)| share * share * self.inverse[i as usize]).sum()
    }

    /// 1 / mass of a sample \[1/kg\].
    pub(crate) fn inverse(&self, sample: usize) -> f64 {
        self.inverse[sample]
    }

    /// What a particle at `x`, twice `half` wide, meets of those `near` among samples at `places` \[m\].
    pub(crate) fn patch(&self, places: &[Vec3], near: &[u32], x: Vec3, half: f64) -> Option<Patch> {
        let reach = self.reach(half);
        let (mut shares, mut middle, mut thickness, mut total) = (Vec::new(), [0.0; 3], 0.0, 0.0);
        for &i in near {
            let from = sub(places[i as usize], x);
            let far = dot(from, from) / (reach * reach);
            if far < 1.0 {
                let weight = (1.0 - far) * (1.0 - far);
                shares.push((i, weight));
                middle = add(middle, scale(from, weight));
                thickness += weight * self.half[i as usize];
                total += weight;
            }
        }
        if total <= 0.0 {
            return None;
        }
        let way = scale(middle, 1.0 / total);
        let mut spread = Matrix3::identity() * (FLAT * self.width * self.width);
        for (i, share) in &mut shares {
            *share /= total;
            let from = Vector3::from(sub(sub(places[*i as usize], x), way));
            spread += from * from.transpose() * *share;
        }
        let normal = spread.cholesky()?.solve(&-Vector3::from(way)).try_normalize(0.0)?;
        let distance = -normal.dot(&Vector3::from(way)) - thickness / total;
        Some(Patch { way, normal: normal.into(), distance, shares })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use cosplat_core::boundary::norm;

    /// Distance of samples \[m\].
    const D: f64 = 0.1;

    fn marks(count: usize) -> Marks {
        let all = |x: f64| vec![x; count];
        let id = (0..count as u64).collect();
        Marks::new(&SampleStatics { id, area_m2: all(D * D), volume_m3: all(D * D * D), mass_kg: all(2.0) })
            .expect("they have masses")
    }

    fn patch(places: &[Vec3], x: Vec3) -> Option<Patch> {
        let near: Vec<u32> = (0..places.len() as u32).collect();
        marks(places.len()).patch(places, &near, x, 0.5 * D)
    }

    /// A square layer of samples in the plane z = 0 from the origin on, and three more below its rim x = 0.
    fn block() -> Vec<Vec3> {
        let top = (0..64).map(|i| [f64::from(i / 8) * D, f64::from(i % 8) * D, 0.0]);
        let side = (0..24).map(|i| [0.0, f64::from(i % 8) * D, -D - f64::from(i / 8) * D]);
        top.chain(side).collect()
    }

    #[test]
    fn a_layer_is_a_plane_from_above_and_from_below() {
        let all: Vec<Vec3> = block().into_iter().take(64).collect();
        for (x, y) in [(0.3, 0.3), (0.35, 0.35), (0.31, 0.38), (0.33, 0.5)] {
            for z in [0.09, -0.11] {
                let found = patch(&all, [x, y, z]).expect("samples are near");
                // The middle of the samples that count is up to 0.02 D aside; less than 4e-3/0.14 of that is a tilt.
                assert!(found.normal[2] * z.signum() > 1.0 - 1e-5, "{x} {y} {z}: {found:?}");
                assert!((found.distance - (z.abs() - 0.05)).abs() < 1e-4, "{x} {y} {z}: {found:?}");
                let at = found.shares.iter().fold([0.0; 3], |sum, &(i, s)| add(sum, scale(all[i as usize], s)));
                assert!(norm(sub(at, add([x, y, z], found.way))) < 1e-15, "shares act in their middle");
            }
        }
    }

    #[test]
    fn a_rim_is_where_it_is() {
        // Above the rim the layer is flat, whatever stands below it.
        let above = patch(&block(), [0.0, 0.35, D]).expect("the rim is near");
        assert!(above.normal[2] > 0.999 && (above.distance - 0.05).abs() < 1e-3, "{above:?}");
        // Beside it, it is as round as its samples: the nearest is half a width farther than it would be below.
        let beside = patch(&block(), [-0.05, 0.3, D]).expect("the rim is near");
        assert!(beside.normal[0] < -0.3 && beside.distance > 0.055, "{beside:?}");
        assert_eq!(patch(&block(), [-0.13, 0.35, D]), None, "one and a half widths aside nothing is left");
    }

    #[test]
    fn a_single_sample_is_a_ball() {
        let found = patch(&[[0.0; 3]], [0.06, 0.0, 0.08]).expect("it is near");
        assert!((found.distance - 0.05).abs() < 1e-15 && norm(sub(found.normal, [0.6, 0.0, 0.8])) < 1e-15, "{found:?}");
        assert!((marks(1).gives(&found.shares) - 0.5).abs() < 1e-15, "its mass is 2 kg");
        assert_eq!(patch(&[[0.0; 3]], [0.0; 3]), None, "in its middle there is no direction");
    }

    #[test]
    fn samples_without_a_mass_are_refused() {
        let statics = |mass_kg| SampleStatics { mass_kg, ..SampleStatics::equal(2, 1.0) };
        assert!(Marks::new(&statics(vec![1.0, 0.0])).is_none() && Marks::new(&statics(vec![1.0])).is_none());
        assert_eq!(Marks::new(&statics(vec![1.0, 2.0])).map(|m| m.len()), Some(2));
    }
}
