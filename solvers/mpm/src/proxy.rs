//! A rigid partner's stand-in over one window.
//!
//! It has a share of the body's mass and inertia and its free motion, takes every contact impulse of every substep at
//! once, and moves by the result (`settle`). What crosses back is the sum of the impulses, not its motion: without a
//! stand-in, contact would diverge as soon as the touching mass exceeds the body's.

use cosplat_core::boundary::{ProxyRecord, Wrench, add, cross, scale, sub};
use cosplat_core::plan::InterfaceId;
use nalgebra::{Matrix3, Quaternion, UnitQuaternion, Vector3, Vector6};

use crate::tally::Tally;
use crate::touch::Moved;
use crate::walls::Surface;
use cosplat_core::distance::{Placed, Shape};

/// What never changes about a rigid partner.
#[derive(Clone, Debug)]
pub(crate) struct Partner {
    /// Body.
    pub(crate) name: String,
    /// Shape about its centre of mass.
    pub(crate) shape: Shape,
    /// Interface and surface for each own body.
    pub(crate) pairs: Vec<Option<(InterfaceId, Surface)>>,
}

/// The stand-in.
#[derive(Clone, Debug)]
pub(crate) struct Proxy {
    /// Index of the partner.
    pub(crate) partner: usize,
    /// Share of the mass \[kg\] and of the inertia \[kg m²\] about the centre, in the frame at the start.
    mass: f64,
    inertia: Matrix3<f64>,
    /// Since the start of the window.
    turned: UnitQuaternion<f64>,
    start: ProxyRecord,
    center: [f64; 3],
    twist: Vector6<f64>,
    background: Vector6<f64>,
    /// Of the share, world axes as they are in this substep; 0 for a scripted body.
    inverse_mass: f64,
    inverse_inertia: Matrix3<f64>,
    /// Impulse and moment of this substep that the twist does not have yet.
    owed: Vector6<f64>,
    /// Effect on own bodies.
    pub(crate) on_own: Vec<Tally>,
    /// Impulse on the partner by own body, about its centre at the start of the window.
    pub(crate) on_partner: Vec<Wrench>,
}

/// Motion of a stand-in while impulses are sought.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Free {
    linear: Vector3<f64>,
    angular: Vector3<f64>,
}

impl Proxy {
    /// Stand-in for a partner from its record, for so many own bodies.
    pub(crate) fn new(partner: usize, record: &ProxyRecord, bodies: usize) -> Self {
        let [xx, yy, zz, xy, xz, yz] = record.inertia;
        let six = |a: [f64; 3], b: [f64; 3]| Vector6::new(a[0], a[1], a[2], b[0], b[1], b[2]);
        Self {
            partner,
            mass: record.mass * record.share,
            inertia: Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz) * record.share,
            turned: UnitQuaternion::identity(),
            start: *record,
            center: record.position,
            twist: six(record.linear_velocity, record.angular_velocity),
            background: six(record.background_linear, record.background_angular),
            inverse_mass: 0.0,
            inverse_inertia: Matrix3::zeros(),
            owed: Vector6::zeros(),
            on_own: vec![Tally::default(); bodies],
            on_partner: vec![Wrench::default(); bodies],
        }
    }

    /// Whether every number of a record is one; the mass of a scripted body may be infinite.
    pub(crate) fn is_sound(record: &ProxyRecord) -> bool {
        let r = record;
        let vectors = [r.position, r.linear_velocity, r.angular_velocity, r.background_linear, r.background_angular];
        let mut numbers = vectors.iter().flatten().chain(&r.orientation).chain([&r.share]);
        let inertia = r.mass.is_infinite() || r.inertia.iter().all(|i| i.is_finite());
        numbers.all(|x| x.is_finite()) && inertia && r.mass > 0.0
    }

    /// Velocity and angular velocity now.
    pub(crate) fn twist(&self) -> ([f64; 3], [f64; 3]) {
        let t = &self.twist;
        ([t[0], t[1], t[2]], [t[3], t[4], t[5]])
    }

    /// Free motion over `dt`; contact comes after it.
    pub(crate) fn push(&mut self, dt: f64) {
        self.twist += self.background * dt;
    }

    /// Moves by its twist.
    pub(crate) fn drift(&mut self, dt: f64) {
        let (v, w) = self.twist();
        self.center = add(self.center, scale(v, dt));
        self.turned = UnitQuaternion::from_scaled_axis(Vector3::from(w) * dt) * self.turned;
    }

    /// Its shape where it is now, with the surfaces of its pairs.
    pub(crate) fn moved(&self, partner: &Partner) -> Moved {
        let [x, y, z, w] = self.start.orientation;
        let q = self.turned * UnitQuaternion::from_quaternion(Quaternion::new(w, x, y, z));
        let shape = Placed::new(partner.shape.clone(), self.center, [q.i, q.j, q.k, q.w]);
        Moved { shape, surface: partner.pairs.iter().map(|p| p.map(|(_, surface)| surface)).collect() }
    }

    /// Its motion before the contact of a substep.
    pub(crate) fn free(&mut self) -> Free {
        let rotation = self.turned.to_rotation_matrix();
        let inertia = rotation.matrix() * self.inertia * rotation.matrix().transpose();
        let bound = !self.mass.is_finite();
        self.inverse_mass = if bound { 0.0 } else { 1.0 / self.mass };
        let inverse = inertia.try_inverse().filter(|_| !bound);
        self.inverse_inertia = inverse.unwrap_or_else(Matrix3::zeros);
        let (v, w) = self.twist();
        Free { linear: v.into(), angular: w.into() }
    }

    fn lever(&self, x: [f64; 3]) -> Vector3<f64> {
        Vector3::from(sub(x, self.center))
    }

    /// Velocity per impulse at `x`, with the inverse mass \[1/kg\] of the other side: `k 1 + 1/M - [r]× I⁻¹ [r]×`.
    pub(crate) fn mobility(&self, x: [f64; 3], other: f64) -> Matrix3<f64> {
        let r = self.lever(x).cross_matrix();
        Matrix3::identity() * (other + self.inverse_mass) - r * self.inverse_inertia * r
    }

    /// A node of an own body went from one velocity to another: the stand-in owes it the opposite.
    pub(crate) fn answer(&mut self, body: usize, mass: f64, x: [f64; 3], before: [f64; 3], after: [f64; 3]) {
        self.on_own[body].change(mass, x, before, after);
        let j = scale(sub(after, before), mass);
        let about = cross(sub(x, self.start.position), j);
        self.on_partner[body] = self.on_partner[body].minus(Wrench { linear: j, angular: about });
        let turn = cross(sub(x, self.center), j);
        self.owed -= Vector6::new(j[0], j[1], j[2], turn[0], turn[1], turn[2]);
    }

    /// Takes what it owes.
    pub(crate) fn take(&mut self) {
        let owed = std::mem::take(&mut self.owed);
        let linear = owed.fixed_rows::<3>(0) * self.inverse_mass;
        let angular = self.inverse_inertia * owed.fixed_rows::<3>(3);
        self.twist += Vector6::new(linear[0], linear[1], linear[2], angular[0], angular[1], angular[2]);
    }
}

impl Free {
    /// Velocity of the point at `x` \[m/s\].
    pub(crate) fn at(&self, proxy: &Proxy, x: [f64; 3]) -> [f64; 3] {
        (self.linear + self.angular.cross(&proxy.lever(x))).into()
    }

    /// Takes an impulse \[N s\] at `x`.
    pub(crate) fn take(&mut self, proxy: &Proxy, x: [f64; 3], impulse: [f64; 3]) {
        let impulse = Vector3::from(impulse);
        self.linear += impulse * proxy.inverse_mass;
        self.angular += proxy.inverse_inertia * proxy.lever(x).cross(&impulse);
    }
}
