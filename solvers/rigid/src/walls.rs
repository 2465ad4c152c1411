//! Static colliders: floors, walls, terrain, at rest or moving as told.

use cosplat_core::asset::Asset;
use cosplat_core::scene::{Motion, Source, StaticCollider, Wall};
use rapier3d::geometry::{SharedShape, TriMeshFlags};

use crate::model::{Twist, told};
use crate::shape::Part;
use crate::single::vector;
use crate::{Turn, V3, turn};

/// A static collider, read.
#[derive(Clone)]
pub(crate) struct StaticWall {
    pub(crate) wall: Wall,
    /// Of its frame at t = 0 \[m\].
    pub(crate) position: V3,
    /// Of its frame at t = 0.
    pub(crate) turn: Turn,
    /// Place of the collider in its frame \[m\].
    pub(crate) offset: V3,
    pub(crate) part: Part,
    pub(crate) motion: Option<Motion>,
}

impl StaticWall {
    /// Reads one; `thickness` \[m\] is what a plane of limited size gets, away from its normal.
    pub(crate) fn new(collider: &StaticCollider, asset: Option<&Asset>, thickness: f64) -> Result<Self, String> {
        let name = &collider.name;
        let sizes = match &collider.source {
            Source::Plane { size_m: Some(sizes) } => sizes.to_vec(),
            Source::Box { size_m } => size_m.to_vec(),
            Source::Sphere { radius_m } => vec![*radius_m],
            Source::Cylinder { radius_m, height_m } => vec![*radius_m, *height_m],
            _ => Vec::new(),
        };
        if !sizes.iter().all(|s| s.is_finite() && *s > 0.0) {
            return Err(format!("static colliders without volume (`{name}`)"));
        }
        let (part, offset) = match &collider.source {
            Source::Plane { size_m: None } => (Part::plain(SharedShape::halfspace(vector(V3::z()))), V3::zeros()),
            Source::Plane { size_m: Some([x, y]) } => {
                (Part::cuboid(V3::new(*x, *y, thickness)), V3::z() * (-0.5 * thickness))
            }
            Source::Box { size_m } => (Part::cuboid(V3::from(*size_m)), V3::zeros()),
            Source::Sphere { radius_m } => (Part::plain(SharedShape::ball(*radius_m as f32)), V3::zeros()),
            Source::Cylinder { radius_m, height_m } => (Part::cylinder(*radius_m, *height_m), V3::zeros()),
            Source::Mesh { .. } | Source::HeightField { .. } | Source::Splat { .. } => {
                (Self::mesh(name, asset)?, V3::zeros())
            }
            Source::Points { .. } | Source::Cloud { .. } => {
                return Err(format!("static colliders from points (`{name}`)"));
            }
        };
        Ok(Self {
            wall: collider.wall,
            position: collider.pose.position_m.into(),
            turn: turn(collider.pose.orientation),
            offset,
            part,
            motion: collider.motion,
        })
    }

    fn mesh(name: &str, asset: Option<&Asset>) -> Result<Part, String> {
        let Some(Asset::Mesh(mesh)) = asset else {
            return Err(format!("static colliders without a prepared mesh (`{name}`)"));
        };
        asset.map_or(Ok(()), Asset::check).map_err(|why| format!("the mesh of static collider `{name}`: {why}"))?;
        let vertices = mesh.vertices_m.iter().map(|&v| vector(V3::from(v))).collect();
        // Without this a body that slides over an edge between two coplanar triangles stumbles.
        let flags = TriMeshFlags::FIX_INTERNAL_EDGES;
        let shape = SharedShape::trimesh_with_flags(vertices, mesh.triangles.clone(), flags);
        shape.map(Part::plain).map_err(|why| format!("the mesh of static collider `{name}`: {why}"))
    }

    /// Place \[m\], orientation and velocities of its frame at time `t` \[s\].
    pub(crate) fn at(&self, t: f64) -> (V3, Turn, Twist) {
        match &self.motion {
            Some(motion) => told(motion, self.position, &self.turn, t),
            None => (self.position, self.turn, Twist::default()),
        }
    }
}
