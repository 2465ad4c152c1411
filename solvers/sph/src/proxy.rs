//! A rigid partner's stand-in over one window.
//!
//! It has a share of the body's mass and inertia and its free motion, takes the liquid's impulses in every substep and
//! moves by them. What crosses back is the sum of the impulses, not the motion.

use cosplat_core::boundary::{ProxyRecord, Vec3, add, cross, norm, scale, sub};
use nalgebra::{Matrix3, UnitQuaternion, Vector3};

use crate::frame::Frame;
use crate::shell::Piece;

/// The stand-in.
#[derive(Clone, Debug)]
pub(crate) struct Proxy {
    /// Number of the solid.
    pub(crate) solid: usize,
    /// Centre of mass and orientation.
    pub(crate) frame: Frame,
    /// Velocity \[m/s\] and angular velocity \[rad/s\].
    pub(crate) velocity: Vec3,
    pub(crate) spin: Vec3,
    /// Centre of mass at the start of the window \[m\].
    pub(crate) start: Vec3,
    /// Radius about the centre that holds its boundary particles \[m\].
    radius: f64,
    record: ProxyRecord,
    initial: UnitQuaternion<f64>,
}

impl Proxy {
    /// Stand-in for a partner from its record.
    pub(crate) fn new(solid: usize, record: &ProxyRecord, pieces: &[Piece]) -> Self {
        let frame = Frame::new(record.position, record.orientation);
        Self {
            solid,
            frame,
            velocity: record.linear_velocity,
            spin: record.angular_velocity,
            start: record.position,
            radius: pieces.iter().map(|p| norm(p.0)).fold(0.0, f64::max),
            record: *record,
            initial: frame.turn,
        }
    }

    /// Whether every number of a record is one; the mass of a scripted body may be infinite.
    pub(crate) fn is_sound(r: &ProxyRecord) -> bool {
        let vectors = [r.position, r.linear_velocity, r.angular_velocity, r.background_linear, r.background_angular];
        let mut numbers = vectors.iter().flatten().chain(&r.orientation).chain([&r.share]);
        let inertia = r.mass.is_infinite() || r.inertia.iter().all(|i| i.is_finite());
        numbers.all(|x| x.is_finite()) && inertia && r.mass > 0.0 && r.share > 0.0
    }

    /// Velocity of its point at `x` \[m/s\].
    pub(crate) fn at(&self, x: Vec3) -> Vec3 {
        add(self.velocity, cross(self.spin, sub(x, self.frame.origin)))
    }

    /// Largest speed of any of its points \[m/s\].
    pub(crate) fn speed(&self) -> f64 {
        norm(self.velocity) + norm(self.spin) * self.radius
    }

    /// One over its mass \[1/kg\], and its inverse inertia now \[1/(kg m²)\]; zero for a scripted body, and a body without
    /// inertia does not turn.
    pub(crate) fn mobility(&self) -> (f64, Matrix3<f64>) {
        let r = &self.record;
        if !r.mass.is_finite() {
            return (0.0, Matrix3::zeros());
        }
        let [xx, yy, zz, xy, xz, yz] = r.inertia;
        let turned = (self.frame.turn * self.initial.inverse()).to_rotation_matrix();
        let inertia = Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz) * r.share;
        let now = turned.matrix() * inertia * turned.matrix().transpose();
        (1.0 / (r.mass * r.share), now.try_inverse().unwrap_or_else(Matrix3::zeros))
    }

    /// One over its frequency on a bed of that stiffness by area \[Pa/m\] under its circumscribed circle \[s\].
    pub(crate) fn swing(&self, stiff: f64) -> f64 {
        (self.record.mass * self.record.share / (stiff * std::f64::consts::PI * self.radius * self.radius)).sqrt()
    }

    /// Accelerations of its free motion \[m/s², rad/s²\].
    pub(crate) fn background(&self) -> [Vec3; 2] {
        [self.record.background_linear, self.record.background_angular]
    }

    /// Takes an impulse \[N s\] and its moment about the centre \[N m s\], beside its free motion over `dt` \[s\].
    pub(crate) fn take(&mut self, impulse: Vec3, moment: Vec3, dt: f64) {
        let [linear, angular] = self.background();
        let (light, nimble) = self.mobility();
        let turned: Vec3 = (nimble * Vector3::from(moment)).into();
        self.velocity = add(add(self.velocity, scale(linear, dt)), scale(impulse, light));
        self.spin = add(add(self.spin, scale(angular, dt)), turned);
    }

    /// Moves by its velocity.
    pub(crate) fn drift(&mut self, dt: f64) {
        self.frame.origin = add(self.frame.origin, scale(self.velocity, dt));
        self.frame.turn = UnitQuaternion::from_scaled_axis(Vector3::from(scale(self.spin, dt))) * self.frame.turn;
    }
}
