//! A rigid partner's stand-in over one window.
//!
//! It has a share of the body's mass and inertia and its free motion, takes every contact impulse at once and moves by
//! the result. What crosses back is the sum of the impulses, not its motion.

use cosplat_core::boundary::{ProxyRecord, Vec3, Wrench, add, cross, scale, sub};
use nalgebra::{Matrix3, Quaternion, UnitQuaternion, Vector3};

use crate::tally::Tally;
use cosplat_core::distance::{Placed, Shape};

/// The stand-in.
#[derive(Clone, Debug)]
pub(crate) struct Proxy {
    start: ProxyRecord,
    /// Since the start of the window.
    turned: UnitQuaternion<f64>,
    center: Vec3,
    linear: Vec3,
    angular: Vec3,
    /// Of the share; 0 for a scripted body.
    inverse_mass: f64,
    /// Of the share, world axes at the start of the window and now.
    inverse_start: Matrix3<f64>,
    inverse_inertia: Matrix3<f64>,
    /// Effect on each own body.
    pub(crate) on_own: Vec<Tally>,
    /// Impulse on the partner by own body, about its centre at the start of the window.
    pub(crate) on_partner: Vec<Wrench>,
}

impl Proxy {
    /// Stand-in for a partner from its record, for so many own bodies.
    pub(crate) fn new(record: &ProxyRecord, bodies: usize) -> Self {
        let [xx, yy, zz, xy, xz, yz] = record.inertia;
        let inertia = Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz) * record.share;
        let bound = !record.mass.is_finite();
        let inverse_start = inertia.try_inverse().filter(|_| !bound).unwrap_or_else(Matrix3::zeros);
        Self {
            start: *record,
            turned: UnitQuaternion::identity(),
            center: record.position,
            linear: record.linear_velocity,
            angular: record.angular_velocity,
            inverse_mass: if bound { 0.0 } else { 1.0 / (record.mass * record.share) },
            inverse_start,
            inverse_inertia: inverse_start,
            on_own: vec![Tally::default(); bodies],
            on_partner: vec![Wrench::default(); bodies],
        }
    }

    /// Whether every number of a record is one; the mass of a scripted body may be infinite.
    pub(crate) fn is_sound(record: &ProxyRecord) -> bool {
        let r = record;
        let vectors = [r.position, r.linear_velocity, r.angular_velocity, r.background_linear, r.background_angular];
        let mut numbers = vectors.iter().flatten().chain(&r.orientation);
        let inertia = r.mass.is_infinite() || r.inertia.iter().all(|i| i.is_finite());
        numbers.all(|x| x.is_finite()) && inertia && r.mass > 0.0 && r.share.is_finite() && r.share > 0.0
    }

    /// Velocity and angular velocity now.
    pub(crate) fn twist(&self) -> [Vec3; 2] {
        [self.linear, self.angular]
    }

    /// Free motion over `h` \[s\]; contact comes after it.
    pub(crate) fn push(&mut self, h: f64) {
        self.linear = add(self.linear, scale(self.start.background_linear, h));
        self.angular = add(self.angular, scale(self.start.background_angular, h));
        let turn = self.turned.to_rotation_matrix();
        self.inverse_inertia = turn.matrix() * self.inverse_start * turn.matrix().transpose();
    }

    /// Moves by its twist.
    pub(crate) fn drift(&mut self, h: f64) {
        self.center = add(self.center, scale(self.linear, h));
        self.turned = UnitQuaternion::from_scaled_axis(Vector3::from(self.angular) * h) * self.turned;
    }

    /// The partner's shape where it is now.
    pub(crate) fn placed(&self, shape: &Shape) -> Placed {
        let q = self.attitude();
        Placed::new(shape.clone(), self.center, [q.i, q.j, q.k, q.w])
    }

    /// The point of the body at `x`, in its own frame \[m\].
    pub(crate) fn local(&self, x: Vec3) -> Vec3 {
        self.attitude().inverse_transform_vector(&Vector3::from(sub(x, self.center))).into()
    }

    /// Where a point of its own frame is now \[m\].
    pub(crate) fn world(&self, local: Vec3) -> Vec3 {
        add(self.center, (self.attitude() * Vector3::from(local)).into())
    }

    fn attitude(&self) -> UnitQuaternion<f64> {
        let [x, y, z, w] = self.start.orientation;
        self.turned * UnitQuaternion::from_quaternion(Quaternion::new(w, x, y, z))
    }

    /// Velocity of its point at `x` \[m/s\].
    pub(crate) fn velocity(&self, x: Vec3) -> Vec3 {
        add(self.linear, cross(self.angular, sub(x, self.center)))
    }

    /// Velocity per impulse at `x` \[1/kg\]: `1/M - [r]× I⁻¹ [r]×`.
    pub(crate) fn mobility(&self, x: Vec3) -> Matrix3<f64> {
        let r = Vector3::from(sub(x, self.center)).cross_matrix();
        Matrix3::identity() * self.inverse_mass - r * self.inverse_inertia * r
    }

    /// Takes an impulse \[N s\] of own body `body` at `x`.
    pub(crate) fn take(&mut self, body: usize, x: Vec3, impulse: Vec3) {
        self.linear = add(self.linear, scale(impulse, self.inverse_mass));
        let turn = self.inverse_inertia * Vector3::from(cross(sub(x, self.center), impulse));
        self.angular = add(self.angular, turn.into());
        let about = cross(sub(x, self.start.position), impulse);
        self.on_partner[body] = self.on_partner[body].plus(Wrench { linear: impulse, angular: about });
    }
}
