//! What a partner is like about one of its samples, from where the neighbours are: part of a sheet, of a thread, or
//! neither.
//!
//! Samples of a thin thing, as a leaf or a stem, lie on both of its sides at once, and their normals may be those of
//! neither. The neighbours say how the thing lies, and history (`side`) on which side of it a cloth is. The axis is the
//! eigenvector of the covariance of the neighbours (principal components: Hoppe et al., "Surface reconstruction from
//! unorganized points", 1992).

use cosplat_core::boundary::{Vec3, add, dot, norm, scale, sub};
use nalgebra::{Matrix3, Vector3};

/// Distance of neighbours, in widths: in a square lattice the eight around a sample.
pub(crate) const NEIGHBOURS: f64 = 1.8;
/// Radius of the disc of a sheet, in widths: a little more than the half diagonal of its square, so that between samples
/// a sheet is flat.
const DISC: f64 = 0.75;
/// Half length of a thread's piece, in widths.
const PIECE: f64 = 0.5;
/// A sheet is thin: the least variance is less than this part of the middle one. Two layers a width apart have 0.25 over
/// 0.67.
const THIN: f64 = 0.5;
/// A thread is long: both others are less than this part of the largest variance.
const LONG: f64 = 0.2;

/// A piece of a partner.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) enum Facet {
    /// A disc, with one of its two unit normals.
    Sheet(Vec3),
    /// A straight piece along a unit vector.
    Thread(Vec3),
    /// A point.
    #[default]
    Bead,
}

impl Facet {
    /// From the places of a sample and its neighbours \[m\].
    pub(crate) fn of(points: &[Vec3]) -> Self {
        let count = points.len().max(1) as f64;
        let mean = scale(points.iter().fold([0.0; 3], |sum, &x| add(sum, x)), 1.0 / count);
        let spread = points.iter().map(|&x| Vector3::from(sub(x, mean))).map(|d| d * d.transpose());
        let covariance = spread.fold(Matrix3::zeros(), |sum, one| sum + one);
        let eigen = covariance.symmetric_eigen();
        let mut order = [0, 1, 2];
        order.sort_by(|&a, &b| eigen.eigenvalues[a].total_cmp(&eigen.eigenvalues[b]));
        let value = order.map(|k| eigen.eigenvalues[k]);
        let axis = |k: usize| eigen.eigenvectors.column(order[k]).into_owned().into();
        // A point alone, and what is not finite, have no axes.
        if value[2].is_nan() || value[2] <= 0.0 {
            Self::Bead
        } else if value[1] < LONG * value[2] {
            Self::Thread(axis(2))
        } else if value[0] < THIN * value[1] {
            Self::Sheet(axis(0))
        } else {
            Self::Bead
        }
    }

    /// Way from the nearest point of the piece to a point that is `d` from its middle \[m\].
    pub(crate) fn away(&self, d: Vec3, width: f64) -> Vec3 {
        match *self {
            Self::Sheet(n) => {
                let across = scale(n, dot(n, d));
                let aside = sub(d, across);
                let (length, disc) = (norm(aside), DISC * width);
                if length <= disc { across } else { sub(d, scale(aside, disc / length)) }
            }
            Self::Thread(e) => sub(d, scale(e, dot(e, d).clamp(-PIECE * width, PIECE * width))),
            Self::Bead => d,
        }
    }

    /// The direction across the piece that is nearest to `out`.
    pub(crate) fn facing(&self, out: Vec3) -> Vec3 {
        match *self {
            Self::Sheet(n) if dot(n, out) < 0.0 => scale(n, -1.0),
            Self::Sheet(n) => n,
            Self::Thread(_) | Self::Bead => out,
        }
    }

    /// Whether a neighbour that is `d` away, `|d|` at most a few widths, belongs to the same surface \[m\].
    pub(crate) fn goes_on(&self, d: Vec3) -> bool {
        match *self {
            Self::Sheet(n) => dot(n, d).abs() <= 0.5 * norm(d),
            Self::Thread(_) | Self::Bead => true,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lattice([n, m, l]: [i32; 3]) -> Vec<Vec3> {
        let all = (-n..=n).flat_map(|i| (-m..=m).flat_map(move |j| (-l..=l).map(move |k| [i, j, k])));
        all.map(|x| x.map(f64::from)).filter(|x| norm(*x) < NEIGHBOURS).collect()
    }

    #[test]
    fn a_layer_is_a_sheet_a_row_is_a_thread_and_a_lump_is_neither() {
        let Facet::Sheet(n) = Facet::of(&lattice([2, 2, 0])) else { panic!("a layer") };
        assert!(n[2].abs() > 1.0 - 1e-12);
        let two: Vec<Vec3> = lattice([2, 2, 2]).into_iter().filter(|x| x[2] >= 0.0).collect();
        assert!(matches!(Facet::of(&two), Facet::Sheet(n) if n[2].abs() > 1.0 - 1e-12), "two layers");
        let rim: Vec<Vec3> = lattice([2, 2, 0]).into_iter().filter(|x| x[0] >= 0.0).collect();
        assert!(matches!(Facet::of(&rim), Facet::Sheet(n) if n[2].abs() > 1.0 - 1e-12), "a rim");
        assert!(matches!(Facet::of(&lattice([2, 0, 0])), Facet::Thread(e) if e[0].abs() > 1.0 - 1e-12));
        assert_eq!(Facet::of(&lattice([2, 2, 2])), Facet::Bead);
        assert_eq!(Facet::of(&[[1.0; 3]]), Facet::Bead);
        assert_eq!(Facet::of(&[[f64::NAN; 3]; 3]), Facet::Bead);
    }

    #[test]
    fn a_sheet_is_flat_between_its_samples_and_round_beyond_its_rim() {
        let sheet = Facet::Sheet([0.0, 0.0, 1.0]);
        // Roundings of numbers of order one.
        let same = |a: Vec3, b: Vec3| assert!(norm(sub(a, b)) < 1e-15, "{a:?} {b:?}");
        // Over the middle of four samples.
        same(sheet.away([0.5, 0.5, -0.2], 1.0), [0.0, 0.0, -0.2]);
        same(sheet.away([1.75, 0.0, 0.3], 1.0), [1.0, 0.0, 0.3]);
        same(sheet.facing([0.5, 0.0, -0.1]), [0.0, 0.0, -1.0]);
        assert!(sheet.goes_on([1.0, 0.0, 0.1]) && !sheet.goes_on([0.0, 0.1, -1.0]));
        same(Facet::Thread([1.0, 0.0, 0.0]).away([0.4, 0.3, 0.0], 1.0), [0.0, 0.3, 0.0]);
    }
}
