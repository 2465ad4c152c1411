//! Joints, solved directly in double precision after forces and contacts.
//!
//! rapier has the same joints, so that its contacts know of them; its joint impulses, in single precision and in a basis
//! of its own, are not used. A row is one number that a joint wants to be zero at the end of the substep, and its
//! impulse acts in the direction that the row has at the start: the scheme SHAKE of Ryckaert, Ciccotti and Berendsen,
//! J. Comput. Phys. 23 (1977), symplectic and of second order. All rows are solved at once, by Newton's method with the
//! matrix `J M⁻¹ Jᵀ` of the start. Springs are rows with a compliance instead: the impulse `λ = -h (k (q + h v) + c v)`
//! of an implicit Euler step; source: Catto, "Soft Constraints", GDC 2011. The impulses of a row act at one point of the
//! world on both sides, so that momentum and angular momentum are kept to rounding.

use cosplat_core::scene::JointKind;
use nalgebra::{DMatrix, DVector, Matrix3};

use crate::model::Twist;
use crate::{Turn, V3};

/// Share of the largest diagonal entry that is added to every row, so that joints that say the same thing twice can be
/// solved; a row then leaves that share of its velocity.
const REDUNDANT: f64 = 1e-12;
/// Iterations of Newton's method: the matrix of the start is off by the angle of a substep, so that each gains two
/// digits or more.
const NEWTON: usize = 6;

/// A joint between body `a` and another, or the world.
#[derive(Clone, Debug)]
pub(crate) struct Joint {
    pub(crate) kind: JointKind,
    pub(crate) a: usize,
    pub(crate) b: Option<usize>,
    /// Joint point in the principal frame of `a` \[m\].
    pub(crate) arm_a: V3,
    /// Joint point in the principal frame of `b`, or in the world \[m\].
    pub(crate) arm_b: V3,
    /// Orientation of `a` seen from `b` at t = 0.
    pub(crate) seen: Turn,
    /// Axis in the principal frame of `b`, or in the world; unit.
    pub(crate) axis: V3,
    /// \[N/m\] or \[N m/rad\].
    pub(crate) stiffness: f64,
    /// \[N s/m\] or \[N m s/rad\].
    pub(crate) damping: f64,
}

/// What a joint needs to know of one of its sides.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Side {
    pub(crate) position: V3,
    pub(crate) turn: Turn,
    pub(crate) twist: Twist,
    /// 0 for what is driven \[1/kg\].
    pub(crate) inverse_mass: f64,
    /// World axes; 0 for what is driven \[1/(kg m²)\].
    pub(crate) inverse_inertia: Matrix3<f64>,
}

impl Side {
    /// The world: it never moves.
    pub(crate) fn world() -> Self {
        Self {
            position: V3::zeros(),
            turn: Turn::identity(),
            twist: Twist::default(),
            inverse_mass: 0.0,
            inverse_inertia: Matrix3::zeros(),
        }
    }
}

/// An impulse at a point of the world, and a couple, on thing `a`; the opposite on thing `b`, or on the world.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Push {
    pub(crate) a: usize,
    pub(crate) b: Option<usize>,
    /// \[N s\].
    pub(crate) impulse: V3,
    /// \[m\].
    pub(crate) point: V3,
    /// \[N m s\].
    pub(crate) couple: V3,
}

/// One number that a joint wants of the relative velocity.
struct Row {
    joint: usize,
    /// Direction of the impulse on `a`, or zero.
    linear: V3,
    /// Direction of the couple on `a`, or zero.
    couple: V3,
    /// What turns each side.
    turning: [V3; 2],
    /// Spring, or nothing for a row that must be zero.
    spring: Option<Spring>,
}

#[derive(Clone, Copy)]
struct Spring {
    bias: f64,
    compliance: f64,
}

impl Joint {
    /// Places of its point on both sides \[m\].
    fn points(&self, a: &Side, b: &Side) -> [V3; 2] {
        [a.position + a.turn * self.arm_a, b.position + b.turn * self.arm_b]
    }

    /// How far it is from where its spring has no force: along the axis \[m\], or a rotation \[rad\].
    fn stretch(&self, a: &Side, b: &Side) -> V3 {
        match self.kind {
            JointKind::Prismatic => {
                let [pa, pb] = self.points(a, b);
                let axis = b.turn * self.axis;
                axis * axis.dot(&(pa - pb))
            }
            JointKind::Ball => (a.turn * (b.turn * self.seen).inverse()).scaled_axis(),
            JointKind::Fixed => V3::zeros(),
        }
    }

    /// How far its point on one side is from that on the other, but for the way that it leaves free \[m\].
    pub(crate) fn gap(&self, a: &Side, b: &Side) -> f64 {
        let [pa, pb] = self.points(a, b);
        let free = if self.kind == JointKind::Prismatic { self.stretch(a, b) } else { V3::zeros() };
        (pa - pb - free).norm()
    }

    /// Energy in its spring \[J\].
    pub(crate) fn potential(&self, a: &Side, b: &Side) -> f64 {
        0.5 * self.stiffness * self.stretch(a, b).norm_squared()
    }

    /// How far a row is from zero with the sides at `ends`: \[m\] or \[rad\]. Its direction turns with `b`.
    fn error(&self, row: &Row, [_, b]: &[Side; 2], ends: &[Side; 2]) -> f64 {
        let [a_end, b_end] = ends;
        let along = |d: V3| b_end.turn * b.turn.inverse_transform_vector(&d);
        if row.linear == V3::zeros() {
            let off = (a_end.turn * (b_end.turn * self.seen).inverse()).scaled_axis();
            return along(row.couple).dot(&off);
        }
        let [pa, pb] = self.points(a_end, b_end);
        along(row.linear).dot(&(pa - pb))
    }

    fn rows(&self, joint: usize, a: &Side, b: &Side, h: f64, rows: &mut Vec<Row>) {
        let point = self.points(a, b)[0];
        let arms = [point - a.position, point - b.position];
        let linear =
            |d: V3| Row { joint, linear: d, couple: V3::zeros(), turning: arms.map(|r| r.cross(&d)), spring: None };
        let angular = |d: V3| Row { joint, linear: V3::zeros(), couple: d, turning: [d, d], spring: None };
        let axes = [V3::x(), V3::y(), V3::z()];
        let softness = h * (h * self.stiffness + self.damping);
        let stretch = self.stretch(a, b);
        let spring = |row: Row, d: V3| Row {
            spring: Some(Spring {
                bias: self.stiffness * stretch.dot(&d) * h / softness,
                compliance: softness.recip(),
            }),
            ..row
        };
        match self.kind {
            JointKind::Prismatic => {
                let axis = b.turn * self.axis;
                let least = axis.iamin();
                let across = axis.cross(&axes[least]).normalize();
                rows.extend([across, axis.cross(&across)].map(linear));
                rows.extend(axes.map(angular));
                rows.extend((softness > 0.0).then(|| spring(linear(axis), axis)));
            }
            JointKind::Ball => {
                rows.extend(axes.map(linear));
                rows.extend(axes.into_iter().filter(|_| softness > 0.0).map(|d| spring(angular(d), d)));
            }
            JointKind::Fixed => {
                rows.extend(axes.map(linear));
                rows.extend(axes.map(angular));
            }
        }
    }
}

/// Impulses of all joints over `h` \[s\]; nothing where they contradict each other.
///
/// `side` tells of a body with the velocities that all but joints leave it; `predict` where it will be and how fast with
/// those impulses of joints.
pub(crate) fn solve(
    joints: &[Joint],
    side: impl Fn(usize) -> Side,
    predict: impl Fn(usize, &Pushed) -> Side,
    h: f64,
) -> Option<Vec<Push>> {
    let sides: Vec<[Side; 2]> = joints.iter().map(|j| [side(j.a), j.b.map_or_else(Side::world, &side)]).collect();
    let mut rows = Vec::new();
    for (i, (joint, [a, b])) in joints.iter().zip(&sides).enumerate() {
        joint.rows(i, a, b, h, &mut rows);
    }
    let matrix = matrix(joints, &sides, &rows).cholesky()?;
    let mut impulses: DVector<f64> = DVector::zeros(rows.len());
    let mut ends = sides.clone();
    for _ in 0..NEWTON {
        let open = rows.iter().enumerate().map(|(i, row)| match row.spring {
            None => -joints[row.joint].error(row, &sides[row.joint], &ends[row.joint]) / h,
            Some(spring) => -(rate(row, &ends[row.joint]) + spring.bias + spring.compliance * impulses[i]),
        });
        impulses += matrix.solve(&DVector::from_iterator(rows.len(), open));
        let pushes = pushes(joints, &sides, &rows, &impulses);
        let end = |i: usize| {
            let mut sum = Pushed::default();
            let own = side(i).position;
            for push in &pushes {
                sum.take(i, own, push);
            }
            predict(i, &sum)
        };
        ends = joints.iter().map(|j| [end(j.a), j.b.map_or_else(Side::world, end)]).collect();
    }
    let finite = impulses.iter().all(|v| v.is_finite());
    finite.then(|| pushes(joints, &sides, &rows, &impulses))
}

/// `J v`.
fn rate(row: &Row, [a, b]: &[Side; 2]) -> f64 {
    row.linear.dot(&(a.twist.linear - b.twist.linear)) + row.turning[0].dot(&a.twist.angular)
        - row.turning[1].dot(&b.twist.angular)
}

/// `J M⁻¹ Jᵀ + C`.
fn matrix(joints: &[Joint], sides: &[[Side; 2]], rows: &[Row]) -> DMatrix<f64> {
    let signed = |row: &Row| [(joints[row.joint].a, 1.0, 0), (joints[row.joint].b.unwrap_or(usize::MAX), -1.0, 1)];
    let mut matrix = DMatrix::zeros(rows.len(), rows.len());
    for (i, row) in rows.iter().enumerate() {
        for (body, sign, which) in signed(row) {
            let own = &sides[row.joint][which];
            // What this row's impulse does to the velocities of that body.
            let (dv, dw) = (row.linear * (sign * own.inverse_mass), own.inverse_inertia * row.turning[which] * sign);
            for (k, other) in rows.iter().enumerate() {
                for (_, sign, which) in signed(other).into_iter().filter(|s| s.0 == body) {
                    matrix[(k, i)] += sign * (other.linear.dot(&dv) + other.turning[which].dot(&dw));
                }
            }
        }
    }
    let most = matrix.diagonal().iter().fold(0.0_f64, |most, d| most.max(*d));
    for (i, row) in rows.iter().enumerate() {
        matrix[(i, i)] += row.spring.map_or(0.0, |s| s.compliance) + REDUNDANT * most;
    }
    matrix
}

fn pushes(joints: &[Joint], sides: &[[Side; 2]], rows: &[Row], impulses: &DVector<f64>) -> Vec<Push> {
    let plain = |(j, [a, b]): (&Joint, &[Side; 2])| {
        let point = j.points(a, b)[0];
        Push { a: j.a, b: j.b, impulse: V3::zeros(), point, couple: V3::zeros() }
    };
    let mut pushes: Vec<Push> = joints.iter().zip(sides).map(plain).collect();
    for (row, impulse) in rows.iter().zip(impulses.iter()) {
        pushes[row.joint].impulse += row.linear * *impulse;
        pushes[row.joint].couple += row.couple * *impulse;
    }
    pushes
}

/// Impulses of contacts and joints on a body over a substep or a step, about its centre of mass.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Pushed {
    /// \[N s\].
    pub(crate) linear: V3,
    /// \[N m s\].
    pub(crate) angular: V3,
}

impl Pushed {
    /// Adds what a push gives thing `i` with its centre of mass at `own` \[m\].
    pub(crate) fn take(&mut self, i: usize, own: V3, push: &Push) {
        for (thing, sign) in [(Some(push.a), 1.0), (push.b, -1.0)] {
            if thing == Some(i) {
                self.linear += push.impulse * sign;
                self.angular += ((push.point - own).cross(&push.impulse) + push.couple) * sign;
            }
        }
    }
}
