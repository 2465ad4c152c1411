//! A staged body at a moment of the run, in the frame of a picture or a file.

use cosplat_core::boundary::Vec3;
use nalgebra::{Matrix3, Vector3};

use super::{Staged, single};
use crate::bind::{BindError, Binding, Frame, Local, Particles, matrix};
use crate::output::OutputFrame;
use crate::similarity::Similarity;
use crate::skin::{self, Limits, skin};
use crate::splats::Splats;

/// A body as it stands at t = 0, ready to be moved.
#[derive(Clone, Debug)]
pub struct Shown<'a> {
    body: &'a Staged,
    pose: Frame,
    frame: OutputFrame,
    /// From the body's frame at t = 0 to the shown one.
    from_body: Similarity,
    /// The Gaussians at t = 0, in the shown frame.
    rest: Splats,
    /// Particles in the body's frame.
    particles: Vec<[f32; 3]>,
    /// Particles in the world at t = 0.
    initial: Vec<Vec3>,
}

impl Staged {
    /// The body at `pose` at t = 0, shown in `frame`.
    ///
    /// `initial` are the particles in the world at t = 0 as their solver says, against which motion is measured, so that
    /// the solver's rounding of the pose moves nothing; without it they are the posed cloud.
    ///
    /// # Errors
    /// `initial` has another length than the cloud.
    pub fn shown(&self, pose: &Frame, frame: &OutputFrame, initial: Option<&[Vec3]>) -> Result<Shown<'_>, BindError> {
        let count = self.cloud.position_m.len();
        if let Some(has) = initial.map(<[_]>::len).filter(|n| *n != count) {
            return Err(BindError::Length("particles", count, has));
        }
        let posed = || self.cloud.position_m.iter().map(|p| pose.point(Vector3::from(*p)).into()).collect();
        let of_file = *frame == OutputFrame::of_file(self, pose);
        let from_body =
            if of_file { self.similarity.inverse() } else { frame.from_world.after(&Similarity::from(*pose)) };
        let rest = if of_file {
            self.source.clone()
        } else {
            let mut splats = self.splats.clone();
            from_body.apply(&mut splats, frame.axes);
            splats
        };
        Ok(Shown {
            body: self,
            pose: *pose,
            frame: *frame,
            from_body,
            rest,
            particles: single(&self.cloud.position_m),
            initial: initial.map_or_else(posed, <[_]>::to_vec),
        })
    }
}

impl Shown<'_> {
    /// The Gaussians at t = 0.
    pub fn rest(&self) -> &Splats {
        &self.rest
    }

    /// The Gaussians where the particles took them: positions \[m\] and total deformation gradients (rows, world axes)
    /// in the order of the cloud; without gradients they follow from the positions. `out` is used again from frame to
    /// frame. What did not move has the bits of [`Shown::rest`].
    ///
    /// # Errors
    /// Lists of another length than the cloud.
    pub fn deformed(
        &self,
        now: &[Vec3],
        gradients: Option<&[[f32; 9]]>,
        limits: Limits,
        out: &mut Splats,
    ) -> Result<skin::Report, BindError> {
        if now.len() != self.initial.len() {
            return Err(BindError::Length("particles", self.initial.len(), now.len()));
        }
        // Into the body's frame, in which the binding was made. The subtraction comes first: a particle at rest has
        // moved by exactly zero.
        let back = self.pose.rotation.transpose();
        let in_body = |((rest, from), to): ((&Vec3, &Vec3), &Vec3)| {
            (Vector3::from(*rest) + back * (Vector3::from(*to) - Vector3::from(*from))).map(|v| v as f32).into()
        };
        let moved: Vec<[f32; 3]> = self.body.cloud.position_m.iter().zip(&self.initial).zip(now).map(in_body).collect();
        let own = gradients.and_then(|all| self.in_body(all));
        let particles = Particles { rest: &self.particles, now: &moved, gradients: own.as_deref().or(gradients) };
        let local = self.body.binding.locals(&self.body.splats, &particles)?;
        let in_world = gradients.is_some() && own.is_none();
        let turn = if in_world { self.frame.from_world.rotation } else { self.from_body.rotation };
        let of = |i: usize| {
            if self.body.unbound.binary_search(&(i as u32)).is_ok() {
                return Local::still();
            }
            let Local { displacement, gradient } = local(i);
            Local {
                displacement: self.from_body.rotation * displacement * self.from_body.scale,
                gradient: turned(&turn, gradient),
            }
        };
        Ok(skin(&self.rest, of, limits, out))
    }

    /// Gradients in the body's axes, Rᵀ F R, where the binding lets them turn offsets, which are in these axes; nothing
    /// where it does not, or where the axes are those of the world.
    fn in_body(&self, gradients: &[[f32; 9]]) -> Option<Vec<[f32; 9]>> {
        let turn = self.pose.rotation;
        if !matches!(self.body.binding, Binding::OneToOne(_)) || turn == Matrix3::identity() {
            return None;
        }
        let one = |rows: &[f32; 9]| {
            let own = turn.transpose() * matrix(*rows) * turn;
            std::array::from_fn(|k| own[(k / 3, k % 3)] as f32)
        };
        Some(gradients.iter().map(one).collect())
    }

    /// The Gaussians of a rigid body at another pose; at that of t = 0 with the bits of [`Shown::rest`].
    pub fn posed(&self, now: &Frame, out: &mut Splats) {
        out.clone_from(&self.rest);
        if *now == self.pose {
            return;
        }
        // W M W⁻¹ with M from the first pose to this one and W from the world to the shown frame.
        let world = &self.frame.from_world;
        let motion = now.rotation * self.pose.rotation.transpose();
        let shift = now.translation - motion * self.pose.translation;
        let rotation = world.rotation * motion * world.rotation.transpose();
        let translation = world.rotation * shift * world.scale + world.translation - rotation * world.translation;
        Similarity { scale: 1.0, rotation, translation }.apply(out, self.frame.axes);
    }
}

/// R F Rᵀ; the identity stays what it is.
fn turned(turn: &Matrix3<f64>, gradient: Matrix3<f64>) -> Matrix3<f64> {
    if gradient == Matrix3::identity() { gradient } else { turn * gradient * turn.transpose() }
}
