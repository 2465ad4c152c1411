//! From a file to a mesh in metres that stands upright.

use std::fmt;
use std::fs;
use std::path::Path;

use cosplat_core::asset::{Asset, AssetError, Solid, TriangleMesh};
use cosplat_core::boundary::Vec3;
use nalgebra::{Matrix3, Vector3};

use crate::error::{Fault, MeshError};
use crate::format::{self, Beside};
use crate::weld::weld;

/// How a file becomes a mesh.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Recipe {
    /// Length of one unit of the file \[m\].
    pub metres_per_unit: f64,
    /// Direction of the file that points up; it becomes +z of the body by the shortest turn, half turns about x.
    pub up: Vec3,
}

/// What was made of a file.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Report {
    /// Vertices of the file.
    pub vertices_read: usize,
    /// Triangles of the file, its polygons cut.
    pub triangles_read: usize,
    /// Vertices that fell together with another or that nothing uses.
    pub welded: usize,
    /// Triangles without area that went with them.
    pub degenerate: usize,
    /// Edges without exactly one neighbour; 0 for a closed surface.
    pub open_edges: usize,
    /// Area of the surface \[m²\].
    pub area_m2: f64,
    /// Lower and upper corner of the box around it, in the body's frame \[m\].
    pub box_m: [Vec3; 2],
    /// Volume, centre and inertia, where the surface is closed.
    pub solid: Option<Solid>,
    /// What was left out of the file or assumed.
    pub notes: Vec<String>,
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let size = [0, 1, 2].map(|k| self.box_m[1][k] - self.box_m[0][k]);
        write!(
            f,
            "{} triangles, {:.4} x {:.4} x {:.4} m, ",
            self.triangles_read - self.degenerate,
            size[0],
            size[1],
            size[2]
        )?;
        match &self.solid {
            Some(solid) => write!(f, "closed, {:.4e} m3", solid.volume_m3)?,
            None => write!(f, "open: {} edges", self.open_edges)?,
        }
        write!(f, "; {} vertices welded, {} triangles without area removed", self.welded, self.degenerate)
    }
}

/// A mesh in its body's frame, in metres.
///
/// The frame is the file's, turned upright and scaled: its origin is the file's origin, nothing is recentred.
#[derive(Clone, Debug, PartialEq)]
pub struct Prepared {
    /// The surface.
    pub mesh: TriangleMesh,
    /// Of each vertex: linear red, green, blue from 0 to 1. Empty where the file gives none.
    pub colours: Vec<[f32; 3]>,
    /// What was made of the file.
    pub report: Report,
}

impl Prepared {
    /// Reads a file of any known format.
    ///
    /// # Errors
    /// The file cannot be read, is of no known format or damaged, or the recipe has no scale or no up axis.
    pub fn from_file(path: &Path, recipe: &Recipe) -> Result<Prepared, MeshError> {
        let name = path.display().to_string();
        let io = |error: std::io::Error| {
            MeshError::new(Fault::Io, "whole file", error.to_string(), "check the path and its permissions")
        };
        let bytes = fs::read(path).map_err(|error| io(error).in_file(&name))?;
        let ending = path.extension().and_then(|ending| ending.to_str());
        let beside = Beside::of(path);
        Prepared::from_bytes(&bytes, ending, beside, recipe).map_err(|error| error.in_file(&name))
    }

    /// Reads the bytes of a file; see [`format::read`].
    ///
    /// # Errors
    /// As for [`Prepared::from_file`].
    pub fn from_bytes(
        bytes: &[u8],
        ending: Option<&str>,
        beside: Beside<'_>,
        recipe: &Recipe,
    ) -> Result<Prepared, MeshError> {
        let scale = recipe.metres_per_unit;
        if !(scale.is_finite() && scale > 0.0) {
            let what = format!("one unit of the file is {scale} m");
            return Err(MeshError::whole(Fault::Value, what, "give `metres_per_unit` a positive number"));
        }
        let turn = upright(recipe.up)?;
        let format::Decoded { mut mesh, colours, notes } = format::read(bytes, ending, beside)?;
        for v in &mut mesh.vertices_m {
            *v = (turn * Vector3::from(*v) * scale).into();
        }
        let mut prepared = Prepared::from_coloured(mesh, colours)?;
        prepared.report.notes = notes;
        Ok(prepared)
    }

    /// Welds a mesh that is in metres already, and measures it.
    ///
    /// # Errors
    /// A number is not finite, an index has no vertex, or nothing is left.
    pub fn from_mesh(mesh: TriangleMesh) -> Result<Prepared, MeshError> {
        Prepared::from_coloured(mesh, Vec::new())
    }

    fn from_coloured(mut mesh: TriangleMesh, mut colours: Vec<[f32; 3]>) -> Result<Prepared, MeshError> {
        let wrong = |e: AssetError| MeshError::whole(Fault::Value, e.to_string(), "check the numbers of the mesh");
        Asset::Mesh(mesh.clone()).check().map_err(wrong)?;
        let (vertices_read, triangles_read) = (mesh.vertices_m.len(), mesh.triangles.len());
        let welded = weld(&mut mesh, &mut colours);
        let area_m2: f64 = mesh.triangles.iter().map(|t| area(&mesh, *t).norm()).sum();
        if !(area_m2 > 0.0 && area_m2.is_finite()) {
            let what = format!("the area of {triangles_read} triangles is zero or too large to be a number");
            return Err(MeshError::whole(Fault::Empty, what, "check the file and `metres_per_unit`"));
        }
        let ends = (Vector3::repeat(f64::INFINITY), Vector3::repeat(f64::NEG_INFINITY));
        let (lower, upper) =
            mesh.vertices_m.iter().fold(ends, |(l, u), v| (l.inf(&Vector3::from(*v)), u.sup(&Vector3::from(*v))));
        let report = Report {
            vertices_read,
            triangles_read,
            welded: welded.vertices,
            degenerate: welded.triangles,
            open_edges: mesh.open_edges(),
            area_m2,
            box_m: [lower.into(), upper.into()],
            solid: mesh.solid().ok(),
            notes: Vec::new(),
        };
        Ok(Prepared { mesh, colours, report })
    }
}

/// Half of the cross product of two edges: outward, as long as the triangle is large.
pub(crate) fn area(mesh: &TriangleMesh, triangle: [u32; 3]) -> Vector3<f64> {
    let [a, b, c] = mesh.corners(triangle);
    (b - a).cross(&(c - a)) / 2.0
}

/// The solid of a mesh, or why it encloses none.
pub(crate) fn solid(mesh: &TriangleMesh) -> Result<Solid, MeshError> {
    let advice = "close the mesh (in Blender: Mesh > Clean Up > Fill Holes, then Recalculate Outside)";
    mesh.solid().map_err(|error| MeshError::whole(Fault::Open, error.to_string(), advice))
}

/// The shortest turn that brings `up` to +z; half turns are about x.
fn upright(up: Vec3) -> Result<Matrix3<f64>, MeshError> {
    let none = || {
        let what = format!("the up axis {up:?} has no direction");
        MeshError::whole(Fault::Value, what, "give a finite vector other than zero")
    };
    let u = Vector3::from(up).try_normalize(0.0).filter(|u| u.iter().all(|v| v.is_finite())).ok_or_else(none)?;
    if u.z <= -1.0 + 1e-12 {
        return Ok(Matrix3::from_diagonal(&Vector3::new(1.0, -1.0, -1.0)));
    }
    // Rodrigues: I + [v]ₓ + [v]ₓ² / (1 + c), v = u × z, c = u · z.
    let v = u.cross(&Vector3::z()).cross_matrix();
    Ok(Matrix3::identity() + v + v * v / (1.0 + u.z))
}
