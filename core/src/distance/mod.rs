//! Signed distances of shapes: negative inside, with the outward normal. For solvers that compute contact.

mod mesh;

use std::sync::Arc;

use crate::asset::{Asset, AssetError, TriangleMesh};
use crate::boundary::{dot, norm, scale, sub};
use crate::scene::{Pose, Source};
use nalgebra::{Quaternion, UnitQuaternion, Vector3};

pub use mesh::{HeightField, MeshSolid};

/// Distance to a surface \[m\] and the unit normal of its nearest point.
pub type Distance = (f64, [f64; 3]);

/// A thing that knows how far away it is.
pub trait SignedDistance {
    /// Distance \[m\], negative inside, and outward unit normal at a point of its frame.
    fn distance(&self, x: [f64; 3]) -> (f64, [f64; 3]);
}

/// A shape in its own frame.
#[derive(Clone, Debug)]
pub enum Shape {
    /// Half space below z = 0, or below a rectangle of half extents.
    Plane(Option<[f64; 2]>),
    /// Half edge lengths.
    Box([f64; 3]),
    /// Radius.
    Sphere(f64),
    /// Radius and half height along z.
    Cylinder(f64, f64),
    /// Closed triangle mesh.
    Mesh(Arc<MeshSolid>),
    /// Terrain.
    HeightField(Arc<HeightField>),
}

impl Shape {
    /// Shape of a source that is a formula.
    pub fn of(source: &Source) -> Option<Self> {
        Some(match *source {
            Source::Plane { size_m } => Self::Plane(size_m.map(|s| s.map(|s| 0.5 * s))),
            Source::Box { size_m } => Self::Box(scale(size_m, 0.5)),
            Source::Sphere { radius_m } => Self::Sphere(radius_m),
            Source::Cylinder { radius_m, height_m } => Self::Cylinder(radius_m, 0.5 * height_m),
            _ => return None,
        })
    }

    /// Shape of a source that is a formula, or of the mesh that was prepared for it, for contact on cells of size `dx`
    /// \[m\]. Its frame is that of the source, or lies at the centre of volume with the same axes (`about_centre`), as a
    /// rigid partner's does.
    ///
    /// # Errors
    /// [`ShapeError`]: without a mesh, or with one that cannot be what the source says.
    pub fn prepared(source: &Source, asset: Option<&Asset>, about_centre: bool, dx: f64) -> Result<Self, ShapeError> {
        Self::made(source, asset, about_centre, |mesh, origin| MeshSolid::new(mesh, origin, dx))
    }

    /// The same without a cache near the surface: for those who ask once, and also far from it.
    ///
    /// # Errors
    /// As [`Shape::prepared`].
    pub fn exact(source: &Source, asset: Option<&Asset>, about_centre: bool) -> Result<Self, ShapeError> {
        Self::made(source, asset, about_centre, MeshSolid::exact)
    }

    fn made(
        source: &Source,
        asset: Option<&Asset>,
        about_centre: bool,
        solid: impl Fn(&TriangleMesh, [f64; 3]) -> Result<MeshSolid, AssetError>,
    ) -> Result<Self, ShapeError> {
        if let Some(shape) = Self::of(source) {
            return Ok(shape);
        }
        let Some(asset @ Asset::Mesh(mesh)) = asset else { return Err(ShapeError::NoMesh) };
        asset.check()?;
        if let Source::HeightField { .. } = source {
            return Ok(Self::HeightField(Arc::new(HeightField::new(mesh)?)));
        }
        let origin = if about_centre { mesh.solid()?.centroid_m } else { [0.0; 3] };
        Ok(Self::Mesh(Arc::new(solid(mesh, origin)?)))
    }
}

/// Why a source has no signed distance.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ShapeError {
    /// Points, captures, meshes that were not prepared.
    #[error("only planes, boxes, spheres, cylinders, closed triangle meshes and height fields have a signed distance")]
    NoMesh,
    /// A hole.
    #[error(
        "{0}; close its holes and merge vertices at the same place, use a box, sphere, cylinder or plane, or, for a \
         terrain, `height_field` in place of `mesh`"
    )]
    Open(AssetError),
    /// Anything else about a mesh.
    #[error(transparent)]
    Mesh(AssetError),
}

impl From<AssetError> for ShapeError {
    fn from(wrong: AssetError) -> Self {
        if matches!(wrong, AssetError::Open(_)) { Self::Open(wrong) } else { Self::Mesh(wrong) }
    }
}

impl SignedDistance for Shape {
    fn distance(&self, x: [f64; 3]) -> Distance {
        match self {
            Self::Plane(half) => {
                let beside = half.is_some_and(|h| x[0].abs() > h[0] || x[1].abs() > h[1]);
                (if beside { f64::INFINITY } else { x[2] }, [0.0, 0.0, 1.0])
            }
            Self::Sphere(radius) => {
                let r = norm(x);
                (r - radius, if r > 0.0 { scale(x, 1.0 / r) } else { [0.0, 0.0, 1.0] })
            }
            Self::Box(half) => in_box(x, *half),
            Self::Cylinder(radius, half) => {
                // A rectangle in the half plane of (distance from the axis, height).
                let r = x[0].hypot(x[1]);
                let (d, n) = in_box([r, x[2], 0.0], [*radius, *half, f64::INFINITY]);
                let out = if r > 0.0 { [x[0] / r, x[1] / r] } else { [1.0, 0.0] };
                (d, [n[0] * out[0], n[0] * out[1], n[1]])
            }
            Self::Mesh(mesh) => mesh.distance(x),
            Self::HeightField(field) => field.distance(x),
        }
    }
}

fn in_box(x: [f64; 3], half: [f64; 3]) -> Distance {
    let d = [0, 1, 2].map(|k| x[k].abs() - half[k]);
    let side = |k: usize| if x[k] < 0.0 { -1.0 } else { 1.0 };
    if d.iter().all(|&d| d <= 0.0) {
        let nearest = (1..3).fold(0, |a, k| if d[k] > d[a] { k } else { a });
        let mut normal = [0.0; 3];
        normal[nearest] = side(nearest);
        return (d[nearest], normal);
    }
    let out = [0, 1, 2].map(|k| side(k) * d[k].max(0.0));
    let distance = norm(out);
    (distance, scale(out, 1.0 / distance))
}

/// A shape somewhere.
#[derive(Clone, Debug)]
pub struct Placed {
    shape: Shape,
    center: [f64; 3],
    rotation: UnitQuaternion<f64>,
}

impl Placed {
    /// At a place with an orientation `[x, y, z, w]`.
    pub fn new(shape: Shape, center: [f64; 3], [x, y, z, w]: [f64; 4]) -> Self {
        Self { shape, center, rotation: UnitQuaternion::from_quaternion(Quaternion::new(w, x, y, z)) }
    }

    /// At a pose.
    pub fn at(shape: Shape, pose: &Pose) -> Self {
        Self::new(shape, pose.position_m, pose.orientation)
    }

    /// Lower bound of the distance of anything within `radius` of `x`.
    pub fn at_least(&self, x: [f64; 3], radius: f64) -> f64 {
        let from_center = norm(sub(x, self.center));
        let of_center = match &self.shape {
            Shape::Plane(_) => {
                let normal: [f64; 3] = (self.rotation * Vector3::z()).into();
                dot(normal, sub(x, self.center))
            }
            Shape::Box(half) => from_center - norm(*half),
            Shape::Sphere(radius) => from_center - radius,
            Shape::Cylinder(radius, half) => from_center - radius.hypot(*half),
            // The box is worth a look only near it.
            Shape::Mesh(mesh) if from_center - mesh.radius() > radius => from_center - mesh.radius(),
            Shape::Mesh(mesh) => mesh.box_distance(self.local(x)),
            Shape::HeightField(field) => field.at_least(self.local(x)),
        };
        of_center - radius
    }

    fn local(&self, x: [f64; 3]) -> [f64; 3] {
        (self.rotation.inverse() * Vector3::from(sub(x, self.center))).into()
    }
}

impl SignedDistance for Placed {
    fn distance(&self, x: [f64; 3]) -> Distance {
        let (d, n) = self.shape.distance(self.local(x));
        (d, (self.rotation * Vector3::from(n)).into())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn normals_are_gradients() {
        let shapes = [Shape::Box([0.3, 0.2, 0.5]), Shape::Sphere(0.4), Shape::Cylinder(0.3, 0.2), Shape::Plane(None)];
        for shape in shapes {
            let placed = Placed::new(shape.clone(), [0.1, -0.2, 0.05], [0.1, 0.5, -0.1, 0.854_400_374_531_753]);
            for i in 0..40 {
                let t = f64::from(i) * 0.7;
                let x = [0.6 * t.sin(), 0.5 * (1.3 * t).cos(), 0.7 * (0.37 * t).sin()];
                let (d, n) = placed.distance(x);
                let along = |s: f64| placed.distance([x[0] + s * n[0], x[1] + s * n[1], x[2] + s * n[2]]).0;
                assert!((along(1e-6) - d - 1e-6).abs() < 1e-9, "{shape:?} at {x:?}");
                assert!((norm(n) - 1.0).abs() < 1e-12);
            }
        }
    }
}
