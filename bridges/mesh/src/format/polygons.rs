//! Faces of any number of corners, cut into triangles.

use cosplat_core::asset::TriangleMesh;
use cosplat_core::boundary::Vec3;

use crate::error::Fault;
use crate::triangulate::triangulate;

/// Corners of a face at most.
const CORNERS: usize = 4096;
/// Tests of a point against an ear that one file may cost, about a tenth of a second of work. A concave face of n corners
/// takes some n² of them, a hostile one n³; faces of three and four corners and convex ones take none.
const TESTS: u64 = 60_000_000;

/// What is wrong with a face: kind, words, and what to do.
pub(super) type Wrong = (Fault, String, &'static str);

/// Adds faces to a mesh.
pub(super) struct Cutter {
    tests: u64,
}

impl Cutter {
    /// For one file.
    pub(super) fn new() -> Cutter {
        Cutter { tests: TESTS }
    }

    /// Adds a face whose corners are vertices that exist.
    pub(super) fn add(&mut self, mesh: &mut TriangleMesh, corners: &[u32]) -> Result<(), Wrong> {
        if !(3..=CORNERS).contains(&corners.len()) {
            let what = format!("a face has {} corners", corners.len());
            return Err((Fault::Syntax, what, "give each face 3 to 4096 corners"));
        }
        if let [a, b, c] = *corners {
            mesh.triangles.push([a, b, c]);
            return Ok(());
        }
        let points: Vec<Vec3> = corners.iter().map(|&i| mesh.vertices_m[i as usize]).collect();
        let triangles = triangulate(&points, &mut self.tests).ok_or_else(|| {
            let what = format!("faces up to this one of {} corners are too entangled to be cut", corners.len());
            (Fault::TooLarge, what, "triangulate the mesh in the program it comes from")
        })?;
        mesh.triangles.extend(triangles.into_iter().map(|t| t.map(|k| corners[k])));
        Ok(())
    }
}
