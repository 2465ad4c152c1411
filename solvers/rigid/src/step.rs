//! One substep: forces and rapier's contacts, joints, motion, and the books.
//!
//! With force `F`, impulses `J` of contacts and joints, torque `τ` and their moment `T` about the centre of mass, over `h`:
//!
//! - momentum `p += F h + J`, angular momentum `L += τ h + T`: nothing else changes them;
//! - a body that nothing pushed flies its parabola, and its torque acts half before and half after the turn;
//! - a body that was pushed moves by `h p / m`, as rapier's does, and by the shift that rapier adds to set contact and
//!   joints right. The shift `c` carries no momentum, but a body with momentum `p` that is set aside by `c` has
//!   `c × p` more of it about a fixed point. That is booked as outside, and its size counted.

use cosplat_core::boundary::Wrench;
use cosplat_core::plugin::{Budget, Moving, PluginError};

use crate::advance::{Account, Acting, Lever, Stage};
use crate::contacts;
use crate::joints::{Push, Pushed, Side, solve};
use crate::model::{Body, Twist};
use crate::rotation::{free, tensor};
use crate::world::{Load, Shift};
use crate::{Turn, V3};

/// Speed of a point of a body beyond which the scene has blown up \[m/s\]: far above anything that a solver of solids
/// and liquids in the open air is asked for, far below what single precision cannot hold.
const ABSURD: f64 = 1e5;
/// Part of the momenta in play by which rapier's own velocity may differ from the one kept here: contact impulses in
/// single precision, summed over some sweeps.
const DISAGREE: f64 = 1e-3;
/// Speed below which a body is at rest, and single precision has nothing to compare \[m/s\].
const QUIET: f64 = 1e-4;

/// Impulse \[N s\], angular impulse about the world origin \[N m s\] and work \[J\].
pub(crate) fn budget(linear: V3, angular: V3, work_j: f64) -> Budget {
    Budget { wrench: Wrench { linear: linear.into(), angular: angular.into() }, work_j }
}

/// Sudden impulse through a point of the world with an angular impulse about it.
///
/// Work is impulse times the mean of the velocities before and after, exact for a quadratic energy.
pub(crate) fn kick(body: &Body, moving: &mut Moving, impulse: V3, point: V3, angular: V3) -> Budget {
    let turning = angular + (point - moving.position).cross(&impulse);
    let before = body.twist(moving);
    moving.velocity += impulse / body.mass;
    moving.spin += turning;
    let mean = before.mean(body.twist(moving));
    let work = impulse.dot(&mean.linear) + turning.dot(&mean.angular);
    budget(impulse, point.cross(&impulse) + angular, work)
}

impl Stage<'_> {
    /// One substep from `start` to `end` \[s\].
    pub(crate) fn substep(&mut self, start: f64, end: f64) -> Result<(), PluginError> {
        let h = end - start;
        self.check()?;
        let acting: Vec<Vec<Acting>> =
            (0..self.model.bodies.len()).map(|i| self.acting(i, 0.5 * (start + end))).collect();
        let loads: Vec<Load> = acting.iter().enumerate().map(|(i, all)| self.load(i, all)).collect();
        let shifts = self.world.step(self.model, self.state, &loads, start, end);
        if let Some(body) = self.world.quarantined() {
            return Err(self.blown(body, "is no longer finite"));
        }
        let before = self.twists(start);
        let potential = self.spring_energy();
        let mut pushes = contacts::pushes(&self.world.inner, |thing| {
            let body = self.model.bodies.get(thing)?;
            body.motion.is_none().then(|| self.state.bodies[thing].position)
        });
        let contacts = pushes.len();
        pushes.extend(self.joint_pushes(&pushes, &loads, &before, [start, end])?);
        let sums = self.sum(&pushes);
        let jointed = |i: usize| pushes[contacts..].iter().any(|p| p.a == i || p.b == Some(i));
        for i in 0..self.model.bodies.len() {
            if self.model.bodies[i].motion.is_none() {
                let touched = pushes[..contacts].iter().any(|p| p.a == i || p.b == Some(i));
                // Joints are set right by their own impulses, and need no shift where there is no contact.
                let shift = if jointed(i) && !touched { &Shift::default() } else { &shifts[i] };
                self.advance_body(i, &acting[i], &loads[i], &sums[i], shift, touched || jointed(i), h);
                if !jointed(i) {
                    self.compare(i, &shifts[i], &before[i], &sums[i], &loads[i], h);
                }
            }
        }
        self.drive_to(end);
        let places: Vec<V3> = self.start_of_substep.iter().map(|m| m.position).collect();
        let after = self.twists(end);
        let means: Vec<Twist> = before.iter().zip(&after).map(|(a, b)| a.mean(*b)).collect();
        let mut taken = 0.0;
        for push in &pushes {
            let mean = |thing: usize| {
                let arm = push.point - places.get(thing).copied().unwrap_or_else(|| self.wall_place(thing, start));
                (means[thing].at(arm), means[thing].angular)
            };
            let (va, wa) = mean(push.a);
            let (vb, wb) = push.b.map_or_else(Default::default, mean);
            taken -= push.impulse.dot(&(va - vb)) + push.couple.dot(&(wa - wb));
            // What pushes and is moved, not pushed back, works at its own speed; the rest of the work is lost between.
            if push.b.is_none_or(|b| !self.is_free(b)) {
                if self.is_free(push.a) {
                    self.supplied_j += push.impulse.dot(&vb) + push.couple.dot(&wb);
                }
                let angular = push.point.cross(&push.impulse) + push.couple;
                self.external.add(budget(push.impulse, angular, push.impulse.dot(&va) + push.couple.dot(&wa)));
            } else if !self.is_free(push.a) {
                self.supplied_j -= push.impulse.dot(&va) + push.couple.dot(&wa);
                let angular = push.point.cross(&push.impulse) + push.couple;
                self.external.add(budget(-push.impulse, -angular, 0.0));
            }
        }
        self.state.dissipated += taken - (self.spring_energy() - potential);
        for (sum, add) in self.pushed.iter_mut().zip(&sums) {
            sum.linear += add.linear;
            sum.angular += add.angular;
        }
        Ok(())
    }

    /// Moves one body over `h` \[s\] and books what acted on it.
    #[expect(clippy::too_many_arguments, reason = "the whole of what a substep knows of a body")]
    fn advance_body(
        &mut self,
        index: usize,
        acting: &[Acting],
        load: &Load,
        sum: &Pushed,
        shift: &Shift,
        touched: bool,
        h: f64,
    ) {
        let body = &self.model.bodies[index];
        let old = self.state.bodies[index];
        let velocity = old.velocity + (load.force * h + sum.linear) / body.mass;
        let flies = !touched && !shift.aside;
        let (mut new, travelled) = if flies {
            let a = load.force / body.mass;
            let position = old.position + old.velocity * h + a * (0.5 * h * h);
            // Mean position of the parabola.
            let travelled = old.velocity * (0.5 * h) + a * (h * h / 6.0);
            (Moving { position, velocity, ..old }, travelled)
        } else {
            let position = old.position + velocity * h + shift.linear;
            self.count_shift(shift);
            // `c × p`: see the head of this file.
            let moment = shift.linear.cross(&(velocity * body.mass));
            self.external.add(budget(V3::zeros(), moment, 0.0));
            (Moving { position, velocity, ..old }, V3::zeros())
        };
        let early: Vec<V3> = acting.iter().map(|a| a.torque(&old, &old.turn, travelled)).collect();
        let share = if flies { 0.5 } else { 1.0 };
        let spin = old.spin + sum.angular + early.iter().sum::<V3>() * (share * h);
        new.turn = free(&old.turn, spin, body.inverse, h);
        if !flies && shift.angular != V3::zeros() {
            new.turn = Turn::from_scaled_axis(shift.angular) * new.turn;
        }
        let late: Vec<V3> =
            if flies { acting.iter().map(|a| a.torque(&old, &new.turn, travelled)).collect() } else { early.clone() };
        let torques: Vec<V3> = early.iter().zip(&late).map(|(a, b)| (a + b) * 0.5).collect();
        new.spin = old.spin + sum.angular + torques.iter().sum::<V3>() * h;
        let mean = body.twist(&old).mean(body.twist(&new));
        for (one, torque) in acting.iter().zip(torques) {
            let (impulse, turning) = (one.force * h, torque * h);
            let work = impulse.dot(&mean.linear) + turning.dot(&mean.angular);
            let booked = budget(impulse, (old.position + travelled).cross(&impulse) + turning, work);
            match one.account {
                Account::Gravity => self.external.add(booked),
                Account::Outside => self.supply(booked),
                Account::View(view) => self.received[view].add(booked),
            }
        }
        self.state.bodies[index] = new;
    }

    /// Impulses of the joints, given those of contacts.
    fn joint_pushes(
        &self,
        contacts: &[Push],
        loads: &[Load],
        before: &[Twist],
        [start, end]: [f64; 2],
    ) -> Result<Vec<Push>, PluginError> {
        let h = end - start;
        if self.model.joints.is_empty() {
            return Ok(Vec::new());
        }
        let sums = self.sum(contacts);
        let twist = |i: usize, side: &Side, joints: &Pushed| {
            let (body, moving) = (&self.model.bodies[i], &self.state.bodies[i]);
            let linear = moving.velocity + (loads[i].force * h + sums[i].linear + joints.linear) / body.mass;
            let spin = moving.spin + loads[i].torque * h + sums[i].angular + joints.angular;
            (Twist { linear, angular: side.inverse_inertia * spin }, spin)
        };
        let side = |i: usize| {
            let side = self.side(i);
            let twist = if self.is_free(i) { twist(i, &side, &Pushed::default()).0 } else { before[i] };
            Side { twist, ..side }
        };
        // As the body is moved afterwards, but for what rapier sets aside.
        let predict = |i: usize, joints: &Pushed| {
            let side = self.side(i);
            let body = &self.model.bodies[i];
            if let Some(motion) = &body.motion {
                let moving = body.driven(motion, end).0;
                return Side { position: moving.position, turn: moving.turn, twist: before[i], ..side };
            }
            let (twist, spin) = twist(i, &side, joints);
            let turn = free(&side.turn, spin, body.inverse, h);
            Side { position: side.position + twist.linear * h, turn, twist, ..side }
        };
        solve(&self.model.joints, side, predict, h)
            .ok_or_else(|| self.blown(self.model.joints[0].a, "is held by joints that contradict each other"))
    }

    /// A body as its joints see it.
    fn side(&self, index: usize) -> Side {
        let (body, moving) = (&self.model.bodies[index], &self.state.bodies[index]);
        let side = Side { position: moving.position, turn: moving.turn, ..Side::world() };
        if body.motion.is_some() {
            return side;
        }
        Side { inverse_mass: body.mass.recip(), inverse_inertia: tensor(&moving.turn, body.inverse), ..side }
    }

    /// Notes how far the worst joint is open.
    pub(crate) fn count_gap(&mut self) {
        let side = |i: usize| self.side(i);
        let gaps = self.model.joints.iter().map(|j| j.gap(&side(j.a), &j.b.map_or_else(Side::world, side)));
        if let Some(gap) = gaps.reduce(f64::max) {
            let most = self.counters.entry("largest-gap-of-a-joint-1e-9-m".to_owned()).or_default();
            *most = (*most).max((gap * 1e9) as u64);
        }
    }

    /// Energy in the springs of all joints \[J\].
    pub(crate) fn spring_energy(&self) -> f64 {
        let side = |i: usize| self.side(i);
        self.model.joints.iter().map(|j| j.potential(&side(j.a), &j.b.map_or_else(Side::world, side))).sum()
    }

    /// Sums of pushes by body.
    fn sum(&self, pushes: &[Push]) -> Vec<Pushed> {
        let mut sums = vec![Pushed::default(); self.model.bodies.len()];
        for push in pushes {
            for i in [Some(push.a), push.b].into_iter().flatten().filter(|&i| self.is_free(i)) {
                sums[i].take(i, self.state.bodies[i].position, push);
            }
        }
        sums
    }

    /// Counts a substep in which rapier moved a body by another impulse than the ones it told of.
    fn compare(&mut self, index: usize, shift: &Shift, before: &Twist, sum: &Pushed, load: &Load, h: f64) {
        let body = &self.model.bodies[index];
        let own = self.state.bodies[index].velocity;
        let gross = sum.linear.norm() + load.force.norm() * h + DISAGREE * body.mass * (before.linear.norm() + QUIET);
        if (own - shift.velocity).norm() * body.mass > DISAGREE * gross {
            self.count("substeps in which rapier and the books disagree", 1);
        }
    }

    /// Refuses to go on with a body that is not finite or absurdly fast.
    pub(crate) fn check(&self) -> Result<(), PluginError> {
        for (i, (body, moving)) in self.model.bodies.iter().zip(&self.state.bodies).enumerate() {
            let reach = body.marks.iter().map(V3::norm).fold(0.0, f64::max);
            let twist = body.twist(moving);
            if !moving.is_finite() {
                return Err(self.blown(i, "is no longer finite"));
            }
            let speed = twist.linear.norm() + twist.angular.norm() * reach;
            if body.motion.is_none() && (speed > ABSURD || speed.is_nan()) {
                return Err(self.blown(i, &format!("moves at {speed:.3e} m/s")));
            }
        }
        Ok(())
    }
}

impl Acting {
    /// Torque about the centre of mass \[N m\] with the body turned so and moved by `travelled` \[m\] on the mean.
    fn torque(&self, old: &Moving, turn: &Turn, travelled: V3) -> V3 {
        match self.lever {
            Lever::Centre => V3::zeros(),
            Lever::Hook(arm) => (turn * arm).cross(&self.force),
            Lever::Fixed { point, torque } => torque + (point - old.position - travelled).cross(&self.force),
        }
    }

    /// Torque at the start of a substep \[N m\].
    pub(crate) fn torque_now(&self, moving: &Moving) -> V3 {
        self.torque(moving, &moving.turn, V3::zeros())
    }
}
