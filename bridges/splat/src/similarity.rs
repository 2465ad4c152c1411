//! From the units and axes of a file to those of a scene, and back.

use nalgebra::{Matrix3, Vector3};
use rayon::prelude::*;
use thiserror::Error;

use crate::bind::Frame;
use crate::linalg::{polar_rotation, quaternion_of, rotation_of, wide};
use crate::sh::ShRotation;
use crate::splats::{Axes, Splats};

/// A map x → scale · R x + translation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Similarity {
    /// Scene units (metres) for one unit of the file.
    pub scale: f64,
    /// Proper rotation R.
    pub rotation: Matrix3<f64>,
    /// In scene units.
    pub translation: Vector3<f64>,
}

/// A similarity that is none.
#[derive(Clone, Copy, Debug, Error, PartialEq, Eq)]
pub enum SimilarityError {
    /// Scale zero, negative or not finite.
    #[error("metres per unit must be a positive number")]
    Scale,
    /// The up axis has no direction.
    #[error("the up axis must be a finite vector other than zero")]
    Up,
}

impl Similarity {
    /// The identity.
    pub fn identity() -> Similarity {
        Similarity { scale: 1.0, rotation: Matrix3::identity(), translation: Vector3::zeros() }
    }

    /// The shortest turn that brings `up` of the file to +z, and a scale; half turns are about x.
    ///
    /// # Errors
    /// Scale or up axis are no numbers to work with.
    pub fn upright(up: [f64; 3], metres_per_unit: f64) -> Result<Similarity, SimilarityError> {
        if !(metres_per_unit.is_finite() && metres_per_unit > 0.0) {
            return Err(SimilarityError::Scale);
        }
        let length = Vector3::from(up).norm();
        if !(length.is_finite() && length > 0.0) {
            return Err(SimilarityError::Up);
        }
        let u = Vector3::from(up) / length;
        let rotation = if u.z <= -1.0 + 1e-12 {
            Matrix3::from_diagonal(&Vector3::new(1.0, -1.0, -1.0))
        } else {
            // Rodrigues: I + [v]ₓ + [v]ₓ² / (1 + c), v = u × z, c = u · z.
            let v = u.cross(&Vector3::z()).cross_matrix();
            let turn = Matrix3::identity() + v + v * v / (1.0 + u.z);
            if is_axis(&u) { turn } else { polar_rotation(&turn) }
        };
        Ok(Similarity { scale: metres_per_unit, rotation, translation: Vector3::zeros() })
    }

    /// The map back.
    #[must_use]
    pub fn inverse(&self) -> Similarity {
        let (scale, rotation) = (1.0 / self.scale, self.rotation.transpose());
        Similarity { scale, rotation, translation: -(rotation * self.translation * scale) }
    }

    /// This map after another.
    #[must_use]
    pub fn after(&self, first: &Similarity) -> Similarity {
        Similarity {
            scale: self.scale * first.scale,
            rotation: self.rotation * first.rotation,
            translation: self.point(first.translation),
        }
    }

    /// The image of a point.
    pub fn point(&self, p: Vector3<f64>) -> Vector3<f64> {
        self.rotation * p * self.scale + self.translation
    }

    /// Maps positions, scales (log scale + ln s), rotations (R · q) and the bands of the colour. What the map leaves
    /// alone keeps its bits: a pure translation touches positions only.
    ///
    /// `axes` says which way the result points.
    pub fn apply(&self, splats: &mut Splats, axes: Axes) {
        splats.axes = axes;
        if *self == Similarity::identity() {
            return;
        }
        splats.positions.par_iter_mut().for_each(|p| *p = self.point(wide(*p)).map(|v| v as f32).into());
        let growth = self.scale.ln();
        if growth != 0.0 {
            splats.log_scales.par_iter_mut().for_each(|s| *s = s.map(|v| (f64::from(v) + growth) as f32));
        }
        if self.rotation == Matrix3::identity() {
            return;
        }
        let turn = |q: &mut [f32; 4]| *q = quaternion_of(&(self.rotation * rotation_of(*q)), *q);
        splats.rotations.par_iter_mut().for_each(turn);
        let sh = ShRotation::new(&self.rotation, splats.sh_degree);
        let k = splats.coefficients();
        if k > 0 {
            splats.sh_rest.par_chunks_mut(k).for_each(|rest| sh.apply(rest));
        }
    }
}

impl From<Frame> for Similarity {
    fn from(frame: Frame) -> Similarity {
        Similarity { scale: 1.0, rotation: frame.rotation, translation: frame.translation }
    }
}

/// Whether a unit vector lies along an axis: its turn then has entries 0 and ±1 and nothing to clean up.
fn is_axis(u: &Vector3<f64>) -> bool {
    u.iter().filter(|v| **v == 0.0).count() == 2
}
