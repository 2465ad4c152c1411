//! Geometry that was prepared for a body before the run: what its solver is given instead of a file.
//!
//! Everything is in the body's own frame, in metres: the body's pose places it in the world. A solver therefore runs
//! where none of the files are.

use nalgebra::{Matrix3, Vector3};
use serde::{Deserialize, Serialize};

use crate::boundary::Vec3;

/// Geometry of one body or static collider.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Asset {
    /// Points that stand for a volume of material: a filled capture.
    Particles(ParticleCloud),
    /// A triangle mesh.
    Mesh(TriangleMesh),
}

/// Points that stand for a volume of material. Both lists have the same length.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ParticleCloud {
    /// Distance at which they were placed \[m\].
    pub spacing_m: f64,
    /// Positions \[m\].
    pub position_m: Vec<Vec3>,
    /// Volume of each \[m³\].
    pub volume_m3: Vec<f64>,
}

/// Triangles over shared vertices; counter-clockwise seen from outside.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct TriangleMesh {
    /// Vertices \[m\].
    pub vertices_m: Vec<Vec3>,
    /// Three vertices each.
    pub triangles: Vec<[u32; 3]>,
}

/// Volume, centre and inertia of a homogeneous solid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Solid {
    /// Volume \[m³\].
    pub volume_m3: f64,
    /// Centre of volume \[m\].
    pub centroid_m: Vec3,
    /// Second moments about the centre, ∫ (r·r 1 − r rᵀ) dV \[m⁵\]: times density, the inertia.
    pub inertia_m5: Matrix3<f64>,
}

/// Why geometry cannot be used.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum AssetError {
    /// Lists of different lengths, or an index without a vertex.
    #[error("the geometry contradicts itself: {0}")]
    Inconsistent(String),
    /// NaN or infinity.
    #[error("number {0} of the geometry is not finite")]
    NotFinite(usize),
    /// A mesh with a boundary encloses no volume.
    #[error("the mesh is open: {0} of its edges have one triangle only or disagree about what is outside")]
    Open(usize),
    /// Inside out or flat.
    #[error("the mesh encloses {0} m³: its triangles must be counter-clockwise seen from outside")]
    NoVolume(f64),
    /// A height field whose triangles all stand upright.
    #[error("seen from above (local +z) the height field has no area; its `up` axis may be another one")]
    NoArea,
    /// A line along local z that passes a height field twice.
    #[error(
        "the height field has two heights above x = {0} m, y = {1} m of its frame, an overhang or a second layer: cut it \
         away, choose another `up` axis, or take a closed `mesh`"
    )]
    Overhang(f64, f64),
}

impl Asset {
    /// Whether lengths agree and all numbers are finite.
    ///
    /// # Errors
    /// [`AssetError::Inconsistent`] or [`AssetError::NotFinite`].
    pub fn check(&self) -> Result<(), AssetError> {
        let (points, others): (&[Vec3], &[f64]) = match self {
            Self::Particles(cloud) => (&cloud.position_m, &cloud.volume_m3),
            Self::Mesh(mesh) => (&mesh.vertices_m, &[]),
        };
        if let Self::Particles(cloud) = self
            && cloud.position_m.len() != cloud.volume_m3.len()
        {
            let (n, m) = (cloud.position_m.len(), cloud.volume_m3.len());
            return Err(AssetError::Inconsistent(format!("{n} points have {m} volumes")));
        }
        if let Self::Mesh(mesh) = self
            && let Some(wild) = mesh.triangles.iter().flatten().find(|&&i| i as usize >= mesh.vertices_m.len())
        {
            let n = mesh.vertices_m.len();
            return Err(AssetError::Inconsistent(format!("a triangle names vertex {wild} of {n}")));
        }
        let mut numbers = points.iter().flatten().chain(others);
        numbers.position(|x| !x.is_finite()).map_or(Ok(()), |i| Err(AssetError::NotFinite(i)))
    }
}

impl TriangleMesh {
    /// Corners of a triangle.
    pub fn corners(&self, triangle: [u32; 3]) -> [Vector3<f64>; 3] {
        triangle.map(|i| Vector3::from(self.vertices_m[i as usize]))
    }

    /// Volume, centre and inertia of the solid that the mesh encloses, by the divergence theorem over its triangles
    /// (Eberly, "Polyhedral Mass Properties (Revisited)", with each tetrahedron from the origin in closed form).
    ///
    /// # Errors
    /// [`AssetError`] where it is no closed surface with its outside outside.
    pub fn solid(&self) -> Result<Solid, AssetError> {
        let open = self.open_edges();
        if open > 0 {
            return Err(AssetError::Open(open));
        }
        // Seen from the middle of the vertices, so that a mesh far from its origin loses no digits.
        let middle = self.vertices_m.iter().fold(Vector3::zeros(), |s, &v| s + Vector3::from(v))
            / self.vertices_m.len().max(1) as f64;
        let (mut volume, mut first, mut second) = (0.0, Vector3::zeros(), Matrix3::zeros());
        for &triangle in &self.triangles {
            let [a, b, c] = self.corners(triangle).map(|p| p - middle);
            // Tetrahedron of the triangle and the origin: det/6; ∫x = det/24 Σp; ∫xxᵀ = det/120 (Σ ppᵀ + (Σp)(Σp)ᵀ).
            let det = a.dot(&b.cross(&c));
            let sum = a + b + c;
            volume += det / 6.0;
            first += sum * (det / 24.0);
            second +=
                (a * a.transpose() + b * b.transpose() + c * c.transpose() + sum * sum.transpose()) * (det / 120.0);
        }
        if !(volume > 0.0 && volume.is_finite()) {
            return Err(AssetError::NoVolume(volume));
        }
        let centroid = first / volume;
        let about = second - centroid * centroid.transpose() * volume;
        Ok(Solid {
            volume_m3: volume,
            centroid_m: (centroid + middle).into(),
            inertia_m5: Matrix3::identity() * about.trace() - about,
        })
    }

    /// Directed edges without exactly one opposite: 0 for a closed, consistently oriented surface.
    pub fn open_edges(&self) -> usize {
        let mut edges: Vec<(u32, u32)> =
            self.triangles.iter().flat_map(|&[a, b, c]| [(a, b), (b, c), (c, a)]).collect();
        edges.sort_unstable();
        let count = |edge: (u32, u32)| {
            let from = edges.partition_point(|e| *e < edge);
            edges[from..].iter().take_while(|e| **e == edge).count()
        };
        edges.iter().filter(|&&(a, b)| count((a, b)) != 1 || count((b, a)) != 1).count()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A box with its corner at `at`.
    fn brick(at: Vec3, size: Vec3) -> TriangleMesh {
        let corner = |i: usize| [0, 1, 2].map(|k| at[k] + if i >> k & 1 == 1 { size[k] } else { 0.0 });
        let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
        TriangleMesh {
            vertices_m: (0..8).map(corner).collect(),
            triangles: quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect(),
        }
    }

    #[test]
    fn a_brick_has_the_textbook_s_volume_centre_and_inertia() {
        let [x, y, z] = [0.2, 0.3, 0.5];
        let solid = brick([10.0, -4.0, 1.0], [x, y, z]).solid().unwrap();
        let volume = x * y * z;
        // Cancellation: coordinates of 10 m against edges of 0.2 m leave 13 of 16 digits.
        assert!((solid.volume_m3 / volume - 1.0).abs() < 1e-12);
        let centre = Vector3::from(solid.centroid_m) - Vector3::new(10.1, -3.85, 1.25);
        assert!(centre.norm() < 1e-12);
        let expected =
            Matrix3::from_diagonal(&(Vector3::new(y * y + z * z, x * x + z * z, x * x + y * y) * volume / 12.0));
        assert!((solid.inertia_m5 - expected).norm() < 1e-12 * expected.norm());
    }

    #[test]
    fn a_hole_and_a_mesh_inside_out_are_refused() {
        let mut open = brick([0.0; 3], [1.0; 3]);
        open.triangles.pop();
        assert_eq!(open.solid(), Err(AssetError::Open(3)));
        let mut inverted = brick([0.0; 3], [1.0; 3]);
        inverted.triangles.iter_mut().for_each(|t| t.swap(0, 1));
        assert!(matches!(inverted.solid(), Err(AssetError::NoVolume(v)) if (v + 1.0).abs() < 1e-12));
    }

    #[test]
    fn contradictions_are_found_before_they_are_used() {
        let wild = TriangleMesh { vertices_m: vec![[0.0; 3]; 3], triangles: vec![[0, 1, 3]] };
        assert!(matches!(Asset::Mesh(wild).check(), Err(AssetError::Inconsistent(_))));
        let nan = ParticleCloud { spacing_m: 1.0, position_m: vec![[0.0, f64::NAN, 0.0]], volume_m3: vec![1.0] };
        assert_eq!(Asset::Particles(nan.clone()).check(), Err(AssetError::NotFinite(1)));
        let short = ParticleCloud { volume_m3: Vec::new(), ..nan };
        assert!(matches!(Asset::Particles(short).check(), Err(AssetError::Inconsistent(_))));
    }
}
