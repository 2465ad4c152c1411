//! rapier's copy of the scene: told the state before each substep, asked for contacts after it.

use rapier3d::dynamics::{
    FrictionModel, GenericJointBuilder, IntegrationParameters, JointAxesMask, JointAxis, MassProperties, MotorModel,
    RigidBody, RigidBodyBuilder, RigidBodyHandle, SpringCoefficients,
};
use rapier3d::geometry::{Collider, ColliderBuilder};
use rapier3d::math::{Pose, Rotation, Vector};
use rapier3d::pipeline::{ActiveHooks, PhysicsWorld};

use cosplat_core::scene::JointKind;

use crate::joints::Joint;
use crate::model::{Body, Model, State};
use crate::pairs::Asked;
use crate::shape::Part;
use crate::single::{double, pose, rotation, turned, vector};
use crate::{Turn, V3};

/// Rotation of a body that single precision cannot tell from none \[rad\]: two ulp of a unit quaternion, doubled.
const SAME_TURN: f64 = 2.5e-7;
/// Share of its way by which a body must be off to have been set aside.
const ASIDE: f64 = 0.01;

/// Natural frequency of a contact times the length of a substep: with the damping ratio below, `h ω / (h ω + 2 ζ)` = 1/5 of
/// a penetration is taken back per substep, whatever its length. A body sinks by `g / ω²` under its own weight, 2 µm at
/// 1/480 s; rapier's own 30 Hz would be a third of a millimetre for each body of a stack.
const SOFTNESS: f32 = 0.8;
/// Damping ratio of a contact: rapier's own.
const DAMPING: f32 = 10.0;

/// rapier's copy of the scene.
pub(crate) struct World {
    pub(crate) inner: PhysicsWorld,
    bodies: Vec<RigidBodyHandle>,
    walls: Vec<Option<RigidBodyHandle>>,
}

/// How rapier moved a body beside what its velocity after the substep says: contact and joints are set right by
/// displacements that carry no momentum.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Shift {
    /// \[m\].
    pub(crate) linear: V3,
    /// Rotation vector, world axes \[rad\].
    pub(crate) angular: V3,
    /// Velocity after the substep \[m/s\].
    pub(crate) velocity: V3,
    /// Whether that is more than rounding. Without an impulse it is a correction whose impulse was taken back, or a body
    /// stopped on its way by continuous collision detection.
    pub(crate) aside: bool,
}

/// Forces on a body over a substep, about its centre of mass.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Load {
    /// \[N\].
    pub(crate) force: V3,
    /// \[N m\].
    pub(crate) torque: V3,
}

impl World {
    /// The scene at t = 0.
    pub(crate) fn new(model: &Model, state: &State) -> Self {
        let mut inner = PhysicsWorld::new();
        inner.gravity = Vector::ZERO;
        inner.integration_parameters = parameters(model);
        let bodies = model.bodies.iter().enumerate().map(|(i, b)| add_body(&mut inner, model, state, i, b)).collect();
        let mut world = Self { inner, bodies, walls: Vec::new() };
        world.add_walls(model);
        world.add_joints(model);
        // A step of no time lets rapier take in what was added, so that this world and a restored one start alike.
        world.inner.integration_parameters.dt = 0.0;
        world.inner.step_with_events(&Asked(&model.pairs), &());
        world
    }

    fn add_walls(&mut self, model: &Model) {
        for (i, wall) in model.walls.iter().enumerate() {
            let thing = model.bodies.len() + i;
            let (position, turn, _) = wall.at(0.0);
            if wall.motion.is_some() {
                let body = RigidBodyBuilder::kinematic_position_based().pose(pose(position - model.origin, &turn));
                let handle = self.inner.insert_body(body);
                self.inner.insert_collider(collider(thing, &wall.part, wall.offset, &Turn::identity()), Some(handle));
                self.walls.push(Some(handle));
            } else {
                let offset = position - model.origin + turn * wall.offset;
                self.inner.insert_collider(collider(thing, &wall.part, offset, &turn), None);
                self.walls.push(None);
            }
        }
    }

    fn add_joints(&mut self, model: &Model) {
        if model.joints.is_empty() {
            return;
        }
        let ground = self.inner.insert_body(RigidBodyBuilder::fixed());
        for joint in &model.joints {
            let (handle_b, frame_b, arm_b) = match joint.b {
                Some(b) => (self.bodies[b], model.bodies[b].start.turn, joint.arm_b),
                None => (ground, Turn::identity(), joint.arm_b - model.origin),
            };
            // Both sides see the same frame of the world at t = 0, with the axis along its x.
            let x = frame_b * joint.axis;
            let frame = Turn::rotation_between(&V3::x(), &x)
                .unwrap_or_else(|| Turn::from_axis_angle(&V3::z_axis(), std::f64::consts::PI));
            let local = |turn: &Turn, arm: V3| pose(arm, &(turn.inverse() * frame));
            let built = springs(joint)
                .local_frame1(local(&model.bodies[joint.a].start.turn, joint.arm_a))
                .local_frame2(local(&frame_b, arm_b));
            self.inner.impulse_joints.insert(self.bodies[joint.a], handle_b, built.build(), false);
        }
    }

    /// Lets rapier make a substep from `start` to `end` \[s\] and answers how it moved each body.
    pub(crate) fn step(&mut self, model: &Model, state: &State, loads: &[Load], start: f64, end: f64) -> Vec<Shift> {
        let dt = (end - start) as f32;
        for (i, body) in model.bodies.iter().enumerate() {
            let moving = &state.bodies[i];
            let Some(own) = self.inner.bodies.get_mut(self.bodies[i]) else { continue };
            if let Some(motion) = &body.motion {
                let [now, next] = [start, end].map(|t| body.driven(motion, t).0);
                place(own, pose(now.position - model.origin, &now.turn));
                own.set_next_kinematic_position(pose(next.position - model.origin, &next.turn));
                continue;
            }
            place(own, pose(moving.position - model.origin, &moving.turn));
            let twist = body.twist(moving);
            own.set_linvel(vector(twist.linear), false);
            own.set_angvel(vector(twist.angular), false);
            own.reset_forces(false);
            own.reset_torques(false);
            own.add_force(vector(loads[i].force), false);
            own.add_torque(vector(loads[i].torque), false);
        }
        for (wall, handle) in model.walls.iter().zip(&self.walls) {
            if let Some(own) = handle.and_then(|h| self.inner.bodies.get_mut(h)) {
                let [now, next] = [start, end].map(|t| wall.at(t));
                place(own, pose(now.0 - model.origin, &now.1));
                own.set_next_kinematic_position(pose(next.0 - model.origin, &next.1));
            }
        }
        let before: Vec<Pose> =
            self.bodies.iter().map(|h| self.inner.bodies.get(*h).map_or(Pose::IDENTITY, |b| *b.position())).collect();
        self.inner.integration_parameters.dt = dt;
        let softness = |share: f32| SpringCoefficients::new(share / dt, DAMPING);
        self.inner.integration_parameters.contact_softness = softness(SOFTNESS);
        self.inner.integration_parameters.static_contact_softness = softness(SOFTNESS);
        self.inner.step_with_events(&Asked(&model.pairs), &());
        let after = self.bodies.iter().zip(before);
        after
            .map(|(h, before)| self.inner.bodies.get(*h).map_or_else(Shift::default, |b| shift(b, &before, dt)))
            .collect()
    }

    /// The first body that rapier had to take out because it was no longer finite.
    pub(crate) fn quarantined(&self) -> Option<usize> {
        let out = self.inner.quarantine().bodies();
        self.bodies.iter().position(|h| out.contains(h))
    }
}

/// Tells where a body is, also where it is there already: only a change makes rapier move the colliders along, and after
/// a restored state they are elsewhere.
fn place(body: &mut RigidBody, pose: Pose) {
    let aside = Pose::from_parts(pose.translation + Vector::X, pose.rotation);
    body.set_position(aside, false);
    body.set_position(pose, false);
}

/// How a body moved beside its velocity.
///
/// rapier advances a pose by `x + h v` and `q + h/2 ω q`, with the velocities of its first pass, and then changes the
/// velocities alone. What is smaller than the rounding of the pose is left out, so that a body may creep.
fn shift(body: &RigidBody, before: &Pose, dt: f32) -> Shift {
    let h = f64::from(dt);
    let (from, to, v) = (double(before.translation), double(body.translation()), double(body.linvel()));
    let linear = to - from - v * h;
    let ulp = from.abs().sup(&to.abs()) * f64::from(f32::EPSILON);
    let clear = |k: usize| linear[k].abs() > 0.75 * ulp[k] + h * v[k].abs() * 2.0 * f64::from(f32::EPSILON);
    let aside = linear.norm() > ASIDE * v.norm() * h + 4.0 * ulp.norm();
    let q = turned(before.rotation);
    let spin = nalgebra::Quaternion::from_imag(double(body.angvel()) * (0.5 * h));
    let predicted = Turn::new_normalize(q.quaternion() + spin * q.quaternion());
    let angular = (turned(*body.rotation()) * predicted.inverse()).scaled_axis();
    Shift {
        linear: V3::from_fn(|k, _| if clear(k) { linear[k] } else { 0.0 }),
        angular: if angular.norm() > SAME_TURN { angular } else { V3::zeros() },
        velocity: v,
        aside,
    }
}

fn parameters(model: &Model) -> IntegrationParameters {
    IntegrationParameters {
        // The substep is this solver's own: one solver step each, with sweeps instead.
        num_solver_iterations: 1,
        num_internal_pgs_iterations: model.params.iterations,
        num_internal_stabilization_iterations: model.params.iterations,
        length_unit: model.unit as f32,
        // Bodies too fast to mean anything are an error here, not something to slow down.
        normalized_max_linear_velocity: f32::MAX,
        // Clusters would move friction from the points at which it acts.
        contact_clustering: false,
        contact_recycling: false,
        // One friction per manifold at its middle, and one about its normal. One per point would be solved point by
        // point: those of a sliding face then do not point against its motion, and a seventh of the friction is lost.
        friction_model: FrictionModel::Simplified,
        ..IntegrationParameters::default()
    }
}

fn add_body(inner: &mut PhysicsWorld, model: &Model, state: &State, thing: usize, body: &Body) -> RigidBodyHandle {
    let moving = &state.bodies[thing];
    let place = pose(moving.position - model.origin, &moving.turn);
    let built = if body.motion.is_some() {
        RigidBodyBuilder::kinematic_position_based()
    } else {
        let moments = vector(body.moments);
        // rapier's body is the principal frame: mass at its origin, moments along its axes.
        RigidBodyBuilder::dynamic().additional_mass_properties(MassProperties::with_principal_inertia_frame(
            Vector::ZERO,
            body.mass as f32,
            moments,
            Rotation::IDENTITY,
        ))
    };
    let built = built
        .pose(place)
        .can_sleep(false)
        .gyroscopic_forces_enabled(true)
        .allow_fast_rotation(true)
        .soft_ccd_prediction(if model.params.ccd { 0.5 * body.extent as f32 } else { 0.0 });
    let handle = inner.insert_body(built);
    for part in &body.parts {
        inner.insert_collider(collider(thing, part, V3::zeros(), &body.axes.inverse()), Some(handle));
    }
    handle
}

fn collider(thing: usize, part: &Part, offset: V3, frame: &Turn) -> Collider {
    ColliderBuilder::new(part.shape.clone())
        .position(Pose::from_parts(vector(offset), rotation(&(frame * part.turn))))
        .density(0.0)
        .user_data(thing as u128)
        .active_hooks(ActiveHooks::FILTER_CONTACT_PAIRS | ActiveHooks::MODIFY_SOLVER_CONTACTS)
        .build()
}

/// The joint with its springs, without its frames.
fn springs(joint: &Joint) -> GenericJointBuilder {
    let (locked, free): (_, &[JointAxis]) = match joint.kind {
        JointKind::Prismatic => (JointAxesMask::LOCKED_PRISMATIC_AXES, &[JointAxis::LinX]),
        JointKind::Ball => (JointAxesMask::LOCKED_SPHERICAL_AXES, &[JointAxis::AngX, JointAxis::AngY, JointAxis::AngZ]),
        JointKind::Fixed => (JointAxesMask::LOCKED_FIXED_AXES, &[]),
    };
    let plain = GenericJointBuilder::new(locked);
    if joint.stiffness == 0.0 && joint.damping == 0.0 {
        return plain;
    }
    free.iter().fold(plain, |built, &axis| {
        let (k, c) = (joint.stiffness as f32, joint.damping as f32);
        built.motor_model(axis, MotorModel::ForceBased).motor_position(axis, 0.0, k, c)
    })
}
