//! Which particles or frame every Gaussian follows.
//!
//! A binding answers one question for each Gaussian: where its centre goes and what the map is around it
//! ([`Local`]). [`crate::skin::skin`] does the rest.

mod affine;
mod mean;
mod triangles;

use nalgebra::{Matrix3, Quaternion, UnitQuaternion, Vector3};
use rayon::prelude::*;
use thiserror::Error;

use crate::grid::Grid;
use crate::linalg::wide;
use crate::splats::Splats;

pub use affine::Affine;
pub use mean::Mean;
pub use triangles::Triangles;

/// The map around one Gaussian.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Local {
    /// How far the centre moves.
    pub displacement: Vector3<f64>,
    /// Total deformation gradient F: a small step dX becomes F dX.
    pub gradient: Matrix3<f64>,
}

impl Local {
    /// Nothing moves.
    pub fn still() -> Local {
        Local { displacement: Vector3::zeros(), gradient: Matrix3::identity() }
    }
}

/// Where the particles are.
#[derive(Clone, Copy, Debug)]
pub struct Particles<'a> {
    /// Positions at which Gaussians were bound.
    pub rest: &'a [[f32; 3]],
    /// Positions now.
    pub now: &'a [[f32; 3]],
    /// Total deformation gradients now, row by row, if the solver knows them.
    pub gradients: Option<&'a [[f32; 9]]>,
}

/// A rigid frame: x → R x + t.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frame {
    /// Rotation R.
    pub rotation: Matrix3<f64>,
    /// Translation t, in scene units.
    pub translation: Vector3<f64>,
}

/// A binding that cannot be made or used.
#[derive(Clone, Copy, Debug, Error, PartialEq, Eq)]
pub enum BindError {
    /// Nothing to follow.
    #[error("there is no particle to bind {0} Gaussians to")]
    NoParticles(usize),
    /// A coordinate is not finite.
    #[error("the position of {0} {1} is not finite; clean the splats and check the particles before they are bound")]
    NonFinite(&'static str, usize),
    /// Arrays of another length than at binding.
    #[error("{0} {1} were bound and {2} are given")]
    Length(&'static str, usize, usize),
    /// A Gaussian or a triangle names a particle that is not there.
    #[error("number {0} follows particle {1}, and there are {2}")]
    Index(usize, u32, usize),
    /// A pose that is none.
    #[error("a pose needs a finite position and a quaternion other than zero")]
    Pose,
}

/// What the Gaussians of a body follow.
#[derive(Clone, Debug, PartialEq)]
pub enum Binding {
    /// Gaussian i follows particle `[i]`, at its distance from it.
    OneToOne(Vec<u32>),
    /// The nearest particles, so that any affine motion is followed exactly.
    Affine(Affine),
    /// The mean of the nearest particles, without turning.
    Mean(Mean),
    /// The nearest triangle of a mesh whose vertices are the particles.
    Triangles(Triangles),
}

impl Binding {
    /// Follows the nearest particle and its gradient: x → p' + F (x − p).
    ///
    /// # Errors
    /// There is no particle, or a position is not finite.
    pub fn nearest(splats: &Splats, particles: &[[f32; 3]]) -> Result<Binding, BindError> {
        if particles.is_empty() {
            return Err(BindError::NoParticles(splats.len()));
        }
        finite(&[("particle", particles), ("Gaussian", &splats.positions)])?;
        let grid = Grid::new(particles);
        let one = |found: &mut Vec<(f64, u32)>, p: &[f32; 3]| {
            grid.nearest(wide(*p), 1, found);
            found.first().map_or(0, |n| n.1)
        };
        Ok(Binding::OneToOne(splats.positions.par_iter().map_init(Vec::new, one).collect()))
    }

    /// Follows the `k` nearest particles (12 is the default of this project).
    ///
    /// # Errors
    /// There is no particle, or a position is not finite.
    pub fn affine(splats: &Splats, particles: &[[f32; 3]], k: usize) -> Result<Binding, BindError> {
        Affine::new(&splats.positions, particles, k).map(Binding::Affine)
    }

    /// Follows the mean of the `k` nearest particles (10 in `WonderPlay`).
    ///
    /// # Errors
    /// There is no particle, or a position is not finite.
    pub fn mean(splats: &Splats, particles: &[[f32; 3]], k: usize) -> Result<Binding, BindError> {
        Mean::new(&splats.positions, particles, k).map(Binding::Mean)
    }

    /// Follows the nearest triangle of a mesh; its vertices are the particles.
    ///
    /// # Errors
    /// There is no triangle, one names a vertex that is not there, or a position is not finite.
    pub fn triangles(splats: &Splats, vertices: &[[f32; 3]], triangles: &[[u32; 3]]) -> Result<Binding, BindError> {
        Triangles::new(&splats.positions, vertices, triangles).map(Binding::Triangles)
    }

    /// The map around each Gaussian.
    ///
    /// # Errors
    /// Arrays of other lengths than at binding.
    pub fn locals<'a>(
        &'a self,
        splats: &'a Splats,
        particles: &'a Particles<'a>,
    ) -> Result<Box<dyn Fn(usize) -> Local + Sync + 'a>, BindError> {
        let count = particles.rest.len();
        let gradients = particles.gradients.map_or(count, <[_]>::len);
        for (what, has) in [("particles", particles.now.len()), ("gradients", gradients)] {
            if has != count {
                return Err(BindError::Length(what, count, has));
            }
        }
        match self {
            Binding::OneToOne(indices) => {
                if indices.len() != splats.len() {
                    return Err(BindError::Length("Gaussians", indices.len(), splats.len()));
                }
                if let Some((i, &p)) = indices.iter().enumerate().find(|(_, p)| **p as usize >= count) {
                    return Err(BindError::Index(i, p, count));
                }
                Ok(Box::new(move |i| follow(splats, particles, i, indices[i] as usize)))
            }
            Binding::Affine(affine) => {
                affine.check(splats.len(), count)?;
                Ok(Box::new(move |i| affine.local(i, particles)))
            }
            Binding::Mean(mean) => {
                mean.check(splats.len(), count)?;
                Ok(Box::new(move |i| mean.local(i, particles)))
            }
            Binding::Triangles(triangles) => {
                triangles.check(splats.len(), count)?;
                Ok(Box::new(move |i| triangles.local(i, particles)))
            }
        }
    }
}

/// Whether all coordinates are finite.
fn finite(all: &[(&'static str, &[[f32; 3]])]) -> Result<(), BindError> {
    let wild = |points: &[[f32; 3]]| points.iter().position(|p| p.iter().any(|v| !v.is_finite()));
    all.iter().try_for_each(|(what, points)| wild(points).map_or(Ok(()), |i| Err(BindError::NonFinite(what, i))))
}

/// Whether there are as many Gaussians and particles as were bound.
fn same_lengths(bound: usize, gaussians: usize, to: usize, particles: usize) -> Result<(), BindError> {
    if bound != gaussians {
        return Err(BindError::Length("Gaussians", bound, gaussians));
    }
    if to == particles { Ok(()) } else { Err(BindError::Length("particles", to, particles)) }
}

/// x → p' + F (x − p).
fn follow(splats: &Splats, particles: &Particles<'_>, gaussian: usize, particle: usize) -> Local {
    let gradient = particles.gradients.map_or_else(Matrix3::identity, |f| matrix(f[particle]));
    let rest = wide(particles.rest[particle]);
    let offset = wide(splats.positions[gaussian]) - rest;
    let displacement = wide(particles.now[particle]) - rest + (gradient - Matrix3::identity()) * offset;
    Local { displacement, gradient }
}

/// A matrix from its rows.
pub(crate) fn matrix(rows: [f32; 9]) -> Matrix3<f64> {
    Matrix3::from_row_slice(&rows.map(f64::from))
}

impl Frame {
    /// No motion.
    pub fn identity() -> Frame {
        Frame { rotation: Matrix3::identity(), translation: Vector3::zeros() }
    }

    /// A pose: position \[m\] and quaternion `[x, y, z, w]` of any length but zero, with which it is divided. The
    /// quaternion of no rotation gives exactly the identity.
    ///
    /// # Errors
    /// A number is not finite, or the quaternion is zero.
    pub fn of_pose(position: [f64; 3], orientation: [f64; 4]) -> Result<Frame, BindError> {
        let [x, y, z, w] = orientation;
        let q = Quaternion::new(w, x, y, z);
        let length = q.norm();
        if !(length > 0.0 && length.is_finite() && position.iter().all(|v| v.is_finite())) {
            return Err(BindError::Pose);
        }
        let rotation = UnitQuaternion::new_unchecked(q / length).to_rotation_matrix().into_inner();
        Ok(Frame { rotation, translation: position.into() })
    }

    /// The image of a point.
    pub fn point(&self, p: Vector3<f64>) -> Vector3<f64> {
        self.rotation * p + self.translation
    }

    /// The map around a Gaussian of a rigid body.
    pub fn local(&self, position: [f32; 3]) -> Local {
        let x = wide(position);
        let displacement = (self.rotation - Matrix3::identity()) * x + self.translation;
        Local { displacement, gradient: self.rotation }
    }
}
