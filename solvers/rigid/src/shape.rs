//! Shapes: mass properties in double precision, and what rapier collides.

use std::f64::consts::PI;

use cosplat_core::asset::Asset;
use cosplat_core::plan::LeftOut;
use cosplat_core::scene::Source;
use nalgebra::{Matrix3, Rotation3, SymmetricEigen};
use rapier3d::geometry::SharedShape;

use crate::hull::collision_parts;
use crate::{Turn, V3};

/// A shape in its source frame, per unit of mass.
pub(crate) struct Shape {
    /// \[m³\].
    pub(crate) volume: f64,
    /// Centre of mass \[m\].
    pub(crate) centre: V3,
    /// Principal moments over mass \[m²\].
    pub(crate) moments: V3,
    /// From the principal frame to the source frame.
    pub(crate) axes: Turn,
    /// Points that move farthest, from the centre of mass, source frame \[m\].
    pub(crate) marks: Vec<V3>,
    /// What it touches with.
    pub(crate) parts: Vec<Part>,
    /// Smallest extent \[m\].
    pub(crate) extent: f64,
    /// How what it touches with differs from it.
    pub(crate) left_out: Option<LeftOut>,
}

/// A convex collider about the centre of mass, turned from its own frame to the source frame.
#[derive(Clone)]
pub(crate) struct Part {
    pub(crate) turn: Turn,
    pub(crate) shape: SharedShape,
}

impl Part {
    pub(crate) fn plain(shape: SharedShape) -> Self {
        Self { turn: Turn::identity(), shape }
    }

    /// A cylinder along z; rapier's lie along y.
    pub(crate) fn cylinder(radius: f64, height: f64) -> Self {
        let shape = SharedShape::cylinder(0.5 * height as f32, radius as f32);
        Self { turn: Turn::from_axis_angle(&V3::x_axis(), 0.5 * PI), shape }
    }

    pub(crate) fn cuboid(size: V3) -> Self {
        Self::plain(SharedShape::cuboid(0.5 * size.x as f32, 0.5 * size.y as f32, 0.5 * size.z as f32))
    }
}

impl Shape {
    fn solid(volume: f64, moments: V3, marks: Vec<V3>, extent: f64, part: Part) -> Self {
        let (centre, axes) = (V3::zeros(), Turn::identity());
        Self { volume, centre, moments, axes, marks, parts: vec![part], extent, left_out: None }
    }

    /// The shape of body `name`, from its source or the mesh prepared for it; in words why there is none.
    pub(crate) fn of(name: &str, source: &Source, asset: Option<&Asset>) -> Result<Self, String> {
        let positive = |sizes: &[f64]| {
            let fit = sizes.iter().all(|s| s.is_finite() && *s > 0.0);
            if fit { Ok(()) } else { Err(format!("shapes without volume (body `{name}`)")) }
        };
        match source {
            Source::Box { size_m } => {
                positive(size_m)?;
                let s = V3::from(*size_m);
                let q = s.component_mul(&s);
                let moments = V3::new(q.y + q.z, q.x + q.z, q.x + q.y) / 12.0;
                Ok(Self::solid(s.product(), moments, corners(s), s.min(), Part::cuboid(s)))
            }
            Source::Sphere { radius_m: r } => {
                positive(&[*r])?;
                let ends = [V3::x(), V3::y(), V3::z()].into_iter().flat_map(|e| [e * *r, e * -*r]).collect();
                let part = Part::plain(SharedShape::ball(*r as f32));
                Ok(Self::solid(4.0 / 3.0 * PI * r.powi(3), V3::repeat(0.4 * r * r), ends, 2.0 * r, part))
            }
            Source::Cylinder { radius_m: r, height_m: h } => {
                positive(&[*r, *h])?;
                let across = (3.0 * r * r + h * h) / 12.0;
                let rim = (0..8).flat_map(|i| {
                    let (sin, cos) = (f64::from(i) * PI / 4.0).sin_cos();
                    [V3::new(r * cos, r * sin, h / 2.0), V3::new(r * cos, r * sin, -h / 2.0)]
                });
                let moments = V3::new(across, across, 0.5 * r * r);
                Ok(Self::solid(PI * r * r * h, moments, rim.collect(), h.min(2.0 * r), Part::cylinder(*r, *h)))
            }
            _ => Self::mesh(name, asset),
        }
    }

    /// The solid that a closed mesh encloses.
    fn mesh(name: &str, asset: Option<&Asset>) -> Result<Self, String> {
        let Some(asset) = asset else { return Err(format!("meshes without prepared geometry (body `{name}`)")) };
        let Asset::Mesh(mesh) = asset else {
            return Err(format!("particles in place of a mesh (body `{name}`)"));
        };
        let refused = |why: &dyn std::fmt::Display| format!("the mesh of body `{name}`: {why}");
        asset.check().map_err(|why| refused(&why))?;
        let solid = mesh.solid().map_err(|why| refused(&why))?;
        let centre = V3::from(solid.centroid_m);
        let (moments, axes) = principal(&(solid.inertia_m5 / solid.volume_m3));
        let points: Vec<V3> = mesh.vertices_m.iter().map(|&v| V3::from(v) - centre).collect();
        let range = |k: usize| {
            let (low, high) = points.iter().fold((f64::MAX, f64::MIN), |(l, h), p| (l.min(p[k]), h.max(p[k])));
            high - low
        };
        let extent = range(0).min(range(1)).min(range(2));
        let (parts, left_out) = collision_parts(name, &points, mesh, solid.volume_m3).map_err(|why| refused(&why))?;
        let marks = farthest(&points);
        Ok(Self { volume: solid.volume_m3, centre, moments, axes, marks, parts, extent, left_out })
    }
}

fn corners(size: V3) -> Vec<V3> {
    (0..8).map(|i| V3::from_fn(|k, _| if i >> k & 1 == 0 { -0.5 } else { 0.5 } * size[k])).collect()
}

/// The farthest points in 26 directions.
fn farthest(points: &[V3]) -> Vec<V3> {
    let one = [-1.0, 0.0, 1.0];
    let directions = one.iter().flat_map(|&x| one.iter().flat_map(move |&y| one.map(|z| V3::new(x, y, z))));
    let support = |d: V3| points.iter().copied().max_by(|a, b| a.dot(&d).total_cmp(&b.dot(&d)));
    directions.filter(|d| d.norm_squared() > 0.0).filter_map(support).collect()
}

/// Principal values and the frame in which a tensor has them; the tensor's own frame where it is diagonal already.
fn principal(tensor: &Matrix3<f64>) -> (V3, Turn) {
    let off = tensor.m12.abs() + tensor.m13.abs() + tensor.m23.abs();
    // Rounding of the sums over triangles.
    if off <= 1e-12 * tensor.trace() {
        return (tensor.diagonal(), Turn::identity());
    }
    let eigen = SymmetricEigen::new(*tensor);
    let mut frame = eigen.eigenvectors;
    if frame.determinant() < 0.0 {
        frame.column_mut(2).neg_mut();
    }
    (eigen.eigenvalues, Turn::from_rotation_matrix(&Rotation3::from_matrix_unchecked(frame)))
}
