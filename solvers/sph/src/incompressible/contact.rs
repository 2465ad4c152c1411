//! Rigid partners inside the pressure iterations: their twists follow from the pressures, and the pressures from them.

use cosplat_core::boundary::{Vec3, add, cross, dot, norm, scale, sub};
use nalgebra::{Matrix3, Vector3};

use crate::force::Pass;
use crate::incompressible::wall::Edge;
use crate::lanes::Pack;
use crate::model::{Model, Solid};
use crate::near::CHUNK;
use crate::partner::Partners;
use crate::wall::{Walls, reaction};

/// How often the gradients of boundary particles count, squared, as their pressure follows that of the liquid.
const TWICE: f64 = 4.0;

/// A particle near a rigid partner.
#[derive(Clone, Copy, Debug)]
struct Contact {
    particle: usize,
    partner: usize,
    /// `Σ_b V_b ∇W_ib` \[1/m\] and its moment about the partner's centre \[1\].
    linear: Vec3,
    angular: Vec3,
}

/// A boundary particle of a rigid partner.
#[derive(Clone, Copy, Debug)]
struct Touch {
    piece: usize,
    partner: usize,
    /// Place from the partner's centre \[m\], and `Σ_i V_i ∇W_ib` \[1/m\].
    arm: Vec3,
    pull: Vec3,
}

/// A partner's velocity, angular velocity, and what an impulse does to them; and both at the start of the substep.
#[derive(Clone, Copy, Debug)]
struct Twist {
    solid: usize,
    centre: Vec3,
    start: [Vec3; 2],
    linear: Vec3,
    angular: Vec3,
    light: f64,
    nimble: Matrix3<f64>,
}

impl Twist {
    fn gain(&self, impulse: Vec3, moment: Vec3) -> [Vec3; 2] {
        [scale(impulse, self.light), (self.nimble * Vector3::from(moment)).into()]
    }
}

/// All that touch.
#[derive(Clone, Debug, Default)]
pub(crate) struct Contacts {
    all: Vec<Contact>,
    touches: Vec<Touch>,
    twists: Vec<Twist>,
    /// Velocities \[m/s\] and angular velocities \[rad/s\] that pressures have given in the running iteration.
    gained: Vec<[Vec3; 2]>,
}

impl Contacts {
    /// Finds them, with the partners' twists at the start of the substep.
    pub(crate) fn find(&mut self, model: &Model, walls: &Walls, partners: &Partners, pack: &[Pack], edge: &Edge) {
        self.all.clear();
        self.touches.clear();
        let twist = |p: &crate::proxy::Proxy| {
            let (light, nimble) = p.mobility();
            let (linear, angular) = (p.velocity, p.spin);
            Twist { solid: p.solid, centre: p.frame.origin, start: [linear, angular], linear, angular, light, nimble }
        };
        self.twists = partners.proxies().iter().map(twist).collect();
        self.gained = vec![[[0.0; 3]; 2]; self.twists.len()];
        if self.twists.is_empty() {
            return;
        }
        let kernel = model.kernel.scaled();
        let of = |b: u32| {
            let piece = walls.pieces.get(b as usize)?;
            let solid = model.faces[piece.face as usize].solid;
            let rigid = matches!(model.solids[solid], Solid::Rigid(..));
            self.twists.iter().position(|t| rigid && t.solid == solid).map(|partner| (piece, partner))
        };
        let mut touches = Vec::new();
        for b in 0..walls.pieces.len() {
            if let Some((piece, partner)) = of(b as u32) {
                let arm = sub(piece.x, self.twists[partner].centre);
                touches.push(Touch { piece: b, partner, arm, pull: edge.brims[b].pull });
            }
        }
        let mut all = Vec::new();
        for (i, own) in pack[..pack.len() - 1].iter().enumerate() {
            let first = all.len();
            for (piece, partner) in walls.near(i).iter().filter_map(|&b| of(b)) {
                let apart = sub(own.x, piece.x);
                let pull = scale(apart, piece.volume * kernel.slope(dot(apart, apart).sqrt()));
                let moment = cross(sub(piece.x, self.twists[partner].centre), pull);
                if let Some(same) = all[first..].iter_mut().find(|c: &&mut Contact| c.partner == partner) {
                    (same.linear, same.angular) = (add(same.linear, pull), add(same.angular, moment));
                } else {
                    all.push(Contact { particle: i, partner, linear: pull, angular: moment });
                }
            }
        }
        self.all = all;
        self.touches = touches;
    }

    /// Calls `add(particle, bound)` with what the partners add to the sum over each row of the operator, at most.
    ///
    /// Of a positive form `g_i·K g_k` each entry is at most the product of the lengths of `g_i` and `g_k` in it.
    pub(crate) fn bound(&mut self, pack: &[Pack], mut add: impl FnMut(usize, f64)) {
        let length = |c: &Contact| {
            let [linear, angular] = self.twists[c.partner].gain(c.linear, c.angular);
            (dot(c.linear, linear) + dot(c.angular, angular)).max(0.0).sqrt()
        };
        let mut sums = vec![0.0; self.twists.len()];
        for c in &self.all {
            sums[c.partner] += pack[c.particle].volume * length(c);
        }
        for c in &self.all {
            add(c.particle, TWICE * length(c) * sums[c.partner]);
        }
    }

    /// What pressures, times volume, over `dt` \[s\] would give the partners.
    pub(crate) fn answer(&mut self, pushed: &[f32], edge: &Edge, dt: f64) {
        let mut sums = vec![[[0.0; 3]; 2]; self.twists.len()];
        for c in &self.all {
            let [linear, angular] = &mut sums[c.partner];
            let impulse = f64::from(pushed[c.particle]) * dt;
            *linear = add(*linear, scale(c.linear, impulse));
            *angular = add(*angular, scale(c.angular, impulse));
        }
        for t in &self.touches {
            let [linear, angular] = &mut sums[t.partner];
            let impulse = scale(t.pull, edge.brims[t.piece].pushed * dt);
            *linear = add(*linear, impulse);
            *angular = add(*angular, cross(t.arm, impulse));
        }
        for (gained, (twist, [linear, angular])) in self.gained.iter_mut().zip(self.twists.iter().zip(sums)) {
            *gained = twist.gain(linear, angular);
        }
    }

    /// Calls `found(particle, rate)` with the rate of the filled share by the partners' motion \[1/s\]: by their own, or by
    /// what pressures have given.
    pub(crate) fn rates(&self, own: bool, mut found: impl FnMut(usize, f64)) {
        for c in &self.all {
            let twist = &self.twists[c.partner];
            let [linear, angular] = if own { [twist.linear, twist.angular] } else { self.gained[c.partner] };
            found(c.particle, -dot(c.linear, linear) - dot(c.angular, angular));
        }
    }

    /// Calls `found(boundary particle, rate)` likewise with `Σ_i V_i v_b·∇W_bi` \[1/s\].
    pub(crate) fn brims(&self, own: bool, mut found: impl FnMut(usize, f64)) {
        for t in &self.touches {
            let twist = &self.twists[t.partner];
            let [linear, angular] = if own { [twist.linear, twist.angular] } else { self.gained[t.partner] };
            found(t.piece, -dot(t.pull, add(linear, cross(angular, t.arm))));
        }
    }

    /// Adds to the impulses of partners on the liquid those by pressures, which are in the packs, over a substep with those
    /// velocities of the liquid before and after it. The work that pressures do on the partners \[J\], at the mean of their
    /// twists before and after.
    pub(crate) fn press(
        &self,
        walls: &mut Walls,
        pass: &Pass<'_>,
        edge: &Edge,
        pack: &[Pack],
        [before, after]: [&[Vec3]; 2],
    ) -> f64 {
        let kernel = pass.model.kernel.scaled();
        let mut sums = vec![[[0.0; 3]; 2]; self.twists.len()];
        for t in &self.touches {
            let (brim, mut piece) = (&edge.brims[t.piece], walls.pieces[t.piece]);
            let mut all = [0.0; 3];
            for &i in walls.lists().chunks()[t.piece / CHUNK].row(t.piece % CHUNK) {
                let i = i as usize;
                let (Some(v), Some(w)) = (before.get(i), after.get(i)) else { continue };
                let apart = sub(pack[i].x, piece.x);
                let slope = kernel.slope(norm(apart));
                let force = scale(apart, -(pack[i].pressure * brim.volume + brim.pushed) * pack[i].volume * slope);
                all = add(all, scale(force, pass.dt));
                piece.work += 0.5 * pass.dt * dot(force, add(*v, *w));
            }
            piece.impulse = add(piece.impulse, all);
            walls.pieces[t.piece] = piece;
            let [linear, angular] = &mut sums[t.partner];
            (*linear, *angular) = (sub(*linear, all), sub(*angular, cross(t.arm, all)));
        }
        let work = self.twists.iter().zip(sums).map(|(t, [linear, angular])| {
            let gained = t.gain(linear, angular);
            // What the pressures meet is the twist after free motion and viscosity.
            let mean = |before: Vec3, met: Vec3, gained: Vec3| scale(add(before, add(met, gained)), 0.5);
            dot(linear, mean(t.start[0], t.linear, gained[0])) + dot(angular, mean(t.start[1], t.angular, gained[1]))
        });
        work.sum()
    }

    /// Their free motion and the impulses of viscosity over `dt` \[s\].
    pub(crate) fn rub(&mut self, model: &Model, walls: &Walls, partners: &Partners, dt: f64) {
        for (twist, proxy) in self.twists.iter_mut().zip(partners.proxies()) {
            let [linear, angular] = proxy.background();
            twist.linear = add(twist.linear, scale(linear, dt));
            twist.angular = add(twist.angular, scale(angular, dt));
        }
        for piece in &walls.pieces {
            let solid = model.faces[piece.face as usize].solid;
            if let Some(twist) = self.twists.iter_mut().find(|t| t.solid == solid) {
                let (impulse, moment) = reaction(piece, twist.centre);
                let [linear, angular] = twist.gain(impulse, moment);
                (twist.linear, twist.angular) = (add(twist.linear, linear), add(twist.angular, angular));
            }
        }
    }
}
