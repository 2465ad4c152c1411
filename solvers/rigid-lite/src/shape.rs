//! Mass properties of shapes.

use std::f64::consts::PI;

use cosplat_core::scene::Source;
use nalgebra::{Matrix3, Rotation3, SymmetricEigen};

use crate::{Turn, V3};

/// Shares of a principal moment below which an axis counts as having none: rounding of the eigenvalue iteration.
const NO_MOMENT: f64 = 1e-12;

/// A shape in its source frame, per unit of mass.
#[derive(Clone, Debug)]
pub(crate) struct Shape {
    /// \[m³\]; none for points.
    pub(crate) volume: Option<f64>,
    /// Centre of mass \[m\].
    pub(crate) centre: V3,
    /// Principal moments over mass \[m²\]; exactly 0 about an axis that holds all mass.
    pub(crate) moments: V3,
    /// From the principal frame to the source frame.
    pub(crate) axes: Turn,
    /// Points that move farthest, from the centre of mass, source frame \[m\]: corners, points on the rim, all points.
    pub(crate) marks: Vec<V3>,
    /// Points it is made of; 1 for solids.
    pub(crate) particles: u64,
}

impl Shape {
    fn solid(volume: f64, moments: V3, marks: Vec<V3>) -> Self {
        let (centre, axes) = (V3::zeros(), Turn::identity());
        Self { volume: Some(volume), centre, moments, axes, marks, particles: 1 }
    }

    /// Mass properties of a source; `None` for those this solver does not take.
    pub(crate) fn of(source: &Source) -> Option<Self> {
        match source {
            Source::Box { size_m } => {
                let s = V3::from(*size_m);
                let q = s.component_mul(&s);
                let corners = (0..8).map(|i| V3::from_fn(|k, _| if i >> k & 1 == 0 { -0.5 } else { 0.5 } * s[k]));
                Some(Self::solid(s.product(), V3::new(q.y + q.z, q.x + q.z, q.x + q.y) / 12.0, corners.collect()))
            }
            Source::Sphere { radius_m: r } => {
                let ends = [V3::x(), V3::y(), V3::z()].into_iter().flat_map(|e| [e * *r, e * -*r]);
                Some(Self::solid(4.0 / 3.0 * PI * r.powi(3), V3::repeat(0.4 * r * r), ends.collect()))
            }
            Source::Cylinder { radius_m: r, height_m: h } => {
                let across = (3.0 * r * r + h * h) / 12.0;
                let rim = (0..8).flat_map(|i| {
                    let (sin, cos) = (f64::from(i) * PI / 4.0).sin_cos();
                    [V3::new(r * cos, r * sin, h / 2.0), V3::new(r * cos, r * sin, -h / 2.0)]
                });
                Some(Self::solid(PI * r * r * h, V3::new(across, across, 0.5 * r * r), rim.collect()))
            }
            Source::Points { positions_m } if !positions_m.is_empty() => Some(Self::points(positions_m)),
            _ => None,
        }
    }

    /// Equal masses at points.
    fn points(positions: &[[f64; 3]]) -> Self {
        let n = positions.len() as f64;
        let centre = positions.iter().map(|&p| V3::from(p)).sum::<V3>() / n;
        let marks: Vec<V3> = positions.iter().map(|&p| V3::from(p) - centre).collect();
        let tensor: Matrix3<f64> = marks
            .iter()
            .map(|r| Matrix3::from_diagonal_element(r.norm_squared()) - r * r.transpose())
            .sum::<Matrix3<f64>>()
            / n;
        let largest = tensor.trace();
        let rounded = |m: V3| m.map(|v| if v > NO_MOMENT * largest { v } else { 0.0 });
        let off = tensor.m12.abs() + tensor.m13.abs() + tensor.m23.abs();
        let (moments, axes) = if off <= f64::EPSILON * largest {
            (tensor.diagonal(), Turn::identity())
        } else {
            let eigen = SymmetricEigen::new(tensor);
            let mut frame = eigen.eigenvectors;
            if frame.determinant() < 0.0 {
                frame.column_mut(2).neg_mut();
            }
            (eigen.eigenvalues, Turn::from_rotation_matrix(&Rotation3::from_matrix_unchecked(frame)))
        };
        Self { volume: None, centre, moments: rounded(moments), axes, marks, particles: positions.len() as u64 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn eight_corner_points_weigh_like_three_boxes() {
        // Equal masses at the corners of a box have Σ r²: three times the moments of the solid box, about its axes.
        let size = V3::new(0.06, 0.12, 0.20);
        let solid = Shape::of(&Source::Box { size_m: size.into() }).unwrap();
        let turned = Turn::from_euler_angles(0.3, -0.8, 1.1);
        let positions_m = solid.marks.iter().map(|&m| (turned * m + V3::new(1.0, 2.0, 3.0)).into()).collect();
        let points = Shape::of(&Source::Points { positions_m }).unwrap();
        assert!((points.centre - V3::new(1.0, 2.0, 3.0)).norm() < 1e-14);
        let (mut found, mut expected) = (points.moments, solid.moments * 3.0);
        found.as_mut_slice().sort_by(f64::total_cmp);
        expected.as_mut_slice().sort_by(f64::total_cmp);
        assert!((found - expected).norm() < 1e-16, "{found} instead of {expected}");
        // The tensor comes back in the source frame.
        let tensor = |s: &Shape, t: &Turn| {
            let frame = (t * s.axes).to_rotation_matrix().into_inner();
            frame * Matrix3::from_diagonal(&s.moments) * frame.transpose()
        };
        let difference = tensor(&points, &Turn::identity()) - tensor(&solid, &turned) * 3.0;
        assert!(difference.norm() < 1e-16, "{difference}");
    }

    #[test]
    fn a_line_of_points_has_no_moment_about_itself() {
        let positions_m = vec![[0.0, 0.0, 0.0], [1.0, 1.0, 0.0], [2.0, 2.0, 0.0]];
        let shape = Shape::of(&Source::Points { positions_m }).unwrap();
        assert_eq!(shape.moments.iter().filter(|m| **m == 0.0).count(), 1);
    }
}
