//! A rigid partner's stand-in over one window: it takes the gas's impulses and its own free motion, where it is.

use cosplat_core::boundary::{ProxyRecord, Vec3, add, cross, norm, scale, sub};
use nalgebra::{Matrix3, Vector3};

/// The stand-in.
#[derive(Clone, Debug)]
pub(crate) struct Proxy {
    pub(crate) record: ProxyRecord,
    /// Velocity \[m/s\] and angular velocity \[rad/s\].
    velocity: Vec3,
    spin: Vec3,
    /// Share of its inverse mass \[1/kg\] and inverse inertia \[1/(kg m²)\]; zero for a scripted body.
    light: f64,
    nimble: Matrix3<f64>,
}

impl Proxy {
    /// From a record; `None` where a number is not one. The mass of a scripted body may be infinite.
    pub(crate) fn new(r: &ProxyRecord) -> Option<Self> {
        let vectors = [r.position, r.linear_velocity, r.angular_velocity, r.background_linear, r.background_angular];
        let mut numbers = vectors.iter().flatten().chain(&r.orientation).chain([&r.share]);
        let inertia = r.mass.is_infinite() || r.inertia.iter().all(|i| i.is_finite());
        if !(numbers.all(|x| x.is_finite()) && inertia && r.mass > 0.0 && r.share > 0.0) {
            return None;
        }
        let (mut light, mut nimble) = (0.0, Matrix3::zeros());
        if r.mass.is_finite() {
            let [xx, yy, zz, xy, xz, yz] = r.inertia;
            let inertia = Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz) * r.share;
            light = 1.0 / (r.mass * r.share);
            nimble = inertia.try_inverse().unwrap_or_else(Matrix3::zeros);
        }
        Some(Self { record: *r, velocity: r.linear_velocity, spin: r.angular_velocity, light, nimble })
    }

    /// Velocity of its point at `x` \[m/s\].
    pub(crate) fn at(&self, x: Vec3) -> Vec3 {
        add(self.velocity, cross(self.spin, sub(x, self.record.position)))
    }

    /// Largest speed of any point within `radius` \[m\] of its centre \[m/s\].
    pub(crate) fn speed(&self, radius: f64) -> f64 {
        norm(self.velocity) + norm(self.spin) * radius
    }

    /// How fast its point at `x` \[m\] gives way along `normal` to an impulse of 1 N s along it \[1/kg\].
    pub(crate) fn yields(&self, x: Vec3, normal: Vec3) -> f64 {
        let lever = Vector3::from(cross(sub(x, self.record.position), normal));
        self.light + lever.dot(&(self.nimble * lever))
    }

    /// Takes an impulse \[N s\] and its moment about the centre \[N m s\], beside its free motion over `dt` \[s\].
    pub(crate) fn take(&mut self, impulse: Vec3, moment: Vec3, dt: f64) {
        let turned: Vec3 = (self.nimble * Vector3::from(moment)).into();
        let linear = add(scale(self.record.background_linear, dt), scale(impulse, self.light));
        self.velocity = add(self.velocity, linear);
        self.spin = add(add(self.spin, scale(self.record.background_angular, dt)), turned);
    }
}
