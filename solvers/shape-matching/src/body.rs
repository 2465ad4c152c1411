//! A body and its motion.

use cosplat_core::distance::{Placed, Shape};
use cosplat_core::plugin::Moving;

use crate::matching::rotation;
use crate::{M3, V3};

/// What never changes about a body.
#[derive(Clone, Debug)]
pub(crate) struct Body {
    pub(crate) name: String,
    /// \[kg\].
    pub(crate) mass: f64,
    /// Σ m q qᵀ, in its frame \[kg m²\].
    pub(crate) spread: M3,
    /// Inverse of its inertia, in its frame \[1/(kg m²)\].
    pub(crate) inverse: M3,
    /// Centre of mass in the frame of the source \[m\].
    pub(crate) centre: V3,
    /// Shape, with its origin about the centre of mass \[m\].
    pub(crate) shape: Shape,
    pub(crate) origin: V3,
    /// Points that touch, about the centre of mass, each with a radius \[m\].
    pub(crate) points: Vec<(V3, f64)>,
    /// Radius about the centre of mass that holds them \[m\].
    pub(crate) radius: f64,
    pub(crate) particles: u64,
    pub(crate) start: Moving,
    /// Whether a partner sees it.
    pub(crate) coupled: bool,
}

impl Body {
    /// Inverse of the inertia in world axes \[1/(kg m²)\].
    pub(crate) fn inverse_now(&self, moving: &Moving) -> M3 {
        let r = moving.turn.to_rotation_matrix();
        r.matrix() * self.inverse * r.matrix().transpose()
    }

    /// Angular velocity \[rad/s\].
    pub(crate) fn omega(&self, moving: &Moving) -> V3 {
        let own = moving.turn.inverse_transform_vector(&moving.spin);
        moving.turn * (self.inverse * own)
    }

    /// Kinetic energy \[J\].
    pub(crate) fn kinetic(&self, moving: &Moving) -> f64 {
        0.5 * (self.mass * moving.velocity.norm_squared() + moving.spin.dot(&self.omega(moving)))
    }

    /// Gives an impulse \[N s\] at a point of the world; answers its work \[J\].
    pub(crate) fn kick(&self, moving: &mut Moving, impulse: V3, at: V3) -> f64 {
        let arm = at - moving.position;
        self.push(moving, impulse, arm.cross(&impulse))
    }

    /// Gives an impulse \[N s\] at the centre and an angular one \[N m s\]; answers their work \[J\], by the mean of the
    /// velocities before and after.
    pub(crate) fn push(&self, moving: &mut Moving, impulse: V3, angular: V3) -> f64 {
        let before = (moving.velocity, self.omega(moving));
        moving.velocity += impulse / self.mass;
        moving.spin += angular;
        let after = (moving.velocity, self.omega(moving));
        0.5 * (impulse.dot(&(before.0 + after.0)) + angular.dot(&(before.1 + after.1)))
    }

    /// Lets the particles fly for `h` \[s\] and matches the shape to where they are: `Σ m (r + h ω × r) qᵀ`, which is
    /// linear in the particles and so needs their second moments only.
    pub(crate) fn fly(&self, moving: &mut Moving, h: f64) {
        let r = moving.turn.to_rotation_matrix();
        let flown = M3::identity() + self.omega(moving).cross_matrix() * h;
        moving.turn = rotation(&(flown * r.matrix() * self.spread), &moving.turn);
        moving.position += moving.velocity * h;
    }

    /// Its shape where it is.
    pub(crate) fn placed(&self, moving: &Moving) -> Placed {
        let turn = moving.turn;
        let at = moving.position + turn * self.origin;
        Placed::new(self.shape.clone(), at.into(), crate::plain(&turn))
    }
}
