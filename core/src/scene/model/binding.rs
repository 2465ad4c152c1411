//! What the Gaussians of a body are tied to.

use serde::{Deserialize, Serialize};

/// How Gaussians follow what their solver moves.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum BindingKind {
    /// Of a capture: moving least squares over the nearest particles; any affine motion is followed exactly.
    #[default]
    Affine,
    /// Of a capture: the mean displacement of the nearest particles, without turning (Li et al. 2025, `WonderPlay`).
    Mean,
    /// Of a capture: the nearest particle and its gradient (Xie et al. 2024, `PhysGaussian`).
    Particle,
    /// Of a mesh: one surfel a vertex, shaped by the triangles around it (Li et al. 2025: topological surfels).
    Vertices,
    /// Of a mesh: samples of its surface, each at fixed barycentric coordinates of its triangle.
    Triangles,
}

impl BindingKind {
    /// Particles that are followed where the scene gives no number.
    pub fn neighbours(self) -> usize {
        match self {
            Self::Mean => 10,
            Self::Particle => 1,
            Self::Affine | Self::Vertices | Self::Triangles => 12,
        }
    }

    /// Whether it is for meshes; the others are for captures.
    pub fn is_of_mesh(self) -> bool {
        matches!(self, Self::Vertices | Self::Triangles)
    }
}

/// A binding with its number.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct BindingSpec {
    /// How.
    pub kind: BindingKind,
    /// Nearest particles that each Gaussian follows, or each vertex of a mesh that is full of particles.
    pub neighbours: usize,
}

/// What a scene says of the Gaussians of a body.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct BodyBinding {
    /// What they are tied to.
    pub spec: BindingSpec,
    /// Of a mesh: a capture whose Gaussians its triangles hold, in the frame of the mesh's file; without it they are
    /// made from the mesh.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub splat: Option<String>,
}

impl From<BindingKind> for BodyBinding {
    fn from(kind: BindingKind) -> Self {
        Self { spec: kind.into(), splat: None }
    }
}

impl From<BindingKind> for BindingSpec {
    fn from(kind: BindingKind) -> Self {
        Self { kind, neighbours: kind.neighbours() }
    }
}

impl Default for BindingSpec {
    fn default() -> Self {
        BindingKind::default().into()
    }
}
