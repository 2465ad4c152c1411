//! Signed distance from a closed mesh.

use cosplat_core::asset::{Solid, TriangleMesh};
use cosplat_core::boundary::Vec3;
use nalgebra::Vector3;
use parry3d::query::PointQueryWithLocation;
use parry3d::shape::{TriMesh, TriMeshFlags};

use crate::error::{Fault, MeshError};
use crate::prepare::solid;

/// The distance from a closed surface, negative inside.
///
/// Nearest points come from a tree of boxes, the sign from the angle-weighted pseudo-normal of the nearest face, edge or
/// vertex (Bærentzen & Aanæs 2005). Both are single precision in a frame in which the mesh has size 1, so distances are
/// good to about 10⁻⁶ of its size.
pub struct SignedDistance {
    shape: TriMesh,
    solid: Solid,
    middle: Vector3<f64>,
    size: f64,
}

impl SignedDistance {
    /// Prepares a closed mesh.
    ///
    /// # Errors
    /// The mesh is open or inside out.
    pub fn new(mesh: &TriangleMesh) -> Result<SignedDistance, MeshError> {
        let solid = solid(mesh)?;
        let ends = (Vector3::repeat(f64::INFINITY), Vector3::repeat(f64::NEG_INFINITY));
        let (lower, upper) =
            mesh.vertices_m.iter().fold(ends, |(l, u), v| (l.inf(&Vector3::from(*v)), u.sup(&Vector3::from(*v))));
        let (middle, size) = ((lower + upper) / 2.0, (upper - lower).max());
        let vertices = mesh.vertices_m.iter().map(|v| unit(Vector3::from(*v), &middle, size)).collect();
        let shape = TriMesh::with_flags(vertices, mesh.triangles.clone(), TriMeshFlags::ORIENTED)
            .map_err(|error| MeshError::whole(Fault::Open, error.to_string(), "check the faces of the mesh"))?;
        Ok(SignedDistance { shape, solid, middle, size })
    }

    /// Distance of a point from the surface \[m\], negative inside.
    pub fn at(&self, point: Vec3) -> f64 {
        let p = unit(Vector3::from(point), &self.middle, self.size);
        let (nearest, _) = self.shape.project_local_point_and_get_location(p, false);
        let distance = f64::from((nearest.point - p).length()) * self.size;
        if nearest.is_inside { -distance } else { distance }
    }

    /// Volume, centre and inertia of what the surface encloses.
    pub fn solid(&self) -> &Solid {
        &self.solid
    }
}

fn unit(p: Vector3<f64>, middle: &Vector3<f64>, size: f64) -> parry3d::math::Vector {
    let q = (p - middle) / size;
    parry3d::math::Vector::new(q.x as f32, q.y as f32, q.z as f32)
}
