//! Points of surfaces against walls and the shapes of other bodies, with Coulomb friction.

use cosplat_core::boundary::Wrench;
use cosplat_core::distance::{Placed, SignedDistance};
use cosplat_core::plugin::{Budget, Moving};

use crate::body::Body;
use crate::model::{Model, State, Surface};
use crate::{M3, V3};

/// Share of an overlap that is undone in a substep, and the speed at which at most \[m/s\].
const GIVEN_BACK: f64 = 0.1;
const FASTEST: f64 = 0.5;
/// Distance from which things are watched, whatever their speed \[m\].
const WATCHED: f64 = 1e-3;

/// A point in reach of something.
#[derive(Clone, Debug)]
pub(crate) struct Touch {
    body: usize,
    /// The other body, or a wall.
    other: Option<usize>,
    at: V3,
    normal: V3,
    /// Distance of the surfaces \[m\].
    gap: f64,
    surface: Surface,
    /// Velocity per impulse \[1/kg\].
    mobility: M3,
    /// Impulse so far \[N s\]: along the normal, and across.
    pressed: f64,
    rubbed: V3,
}

impl Touch {
    /// How deep it is inside the other \[m\]; negative where there is a gap.
    pub(crate) fn depth(&self) -> f64 {
        -self.gap
    }
}

/// Velocity per impulse at a body's point: `1/M - [r]× I⁻¹ [r]×` \[1/kg\].
fn mobility(body: &Body, moving: &Moving, inverse: &M3, at: V3) -> M3 {
    let r = (at - moving.position).cross_matrix();
    M3::identity() / body.mass - r * inverse * r
}

/// What may close its gap within `h` \[s\], in a fixed order.
pub(crate) fn find(model: &Model, state: &State, h: f64) -> Vec<Touch> {
    let placed: Vec<Placed> = model.bodies.iter().zip(&state.bodies).map(|(b, m)| b.placed(m)).collect();
    let mut found = Vec::new();
    for (i, (body, moving)) in model.bodies.iter().zip(&state.bodies).enumerate() {
        let speed = |b: &Body, m: &Moving| m.velocity.norm() + b.omega(m).norm() * b.radius;
        let own = speed(body, moving);
        for (wall, surfaces) in &model.walls {
            let Some(surface) = surfaces[i] else { continue };
            let reach = WATCHED + 2.0 * h * own;
            if wall.at_least(moving.position.into(), body.radius) < reach {
                points(model, state, (i, None), (wall, surface, reach), &mut found);
            }
        }
        for (k, (other, theirs)) in model.bodies.iter().zip(&state.bodies).enumerate().filter(|(k, _)| *k != i) {
            let Some(surface) = model.pairs[i * model.bodies.len() + k] else { continue };
            let reach = WATCHED + 2.0 * h * (own + speed(other, theirs));
            if (theirs.position - moving.position).norm() < body.radius + other.radius + reach {
                points(model, state, (i, Some(k)), (&placed[k], surface, reach), &mut found);
            }
        }
    }
    found
}

fn points(
    model: &Model,
    state: &State,
    (i, other): (usize, Option<usize>),
    (shape, surface, reach): (&Placed, Surface, f64),
    found: &mut Vec<Touch>,
) {
    let (body, moving) = (&model.bodies[i], &state.bodies[i]);
    let partner = other.map(|k| (&model.bodies[k], &state.bodies[k]));
    let inverse = body.inverse_now(moving);
    let theirs = partner.map(|(b, m)| b.inverse_now(m));
    for &(point, radius) in &body.points {
        let centre = moving.position + moving.turn * point;
        let (distance, normal) = shape.distance(centre.into());
        let gap = distance - radius;
        if gap >= reach {
            continue;
        }
        let normal = V3::from(normal);
        let at = centre - normal * radius;
        let own = mobility(body, moving, &inverse, at);
        let theirs = partner.zip(theirs).map_or_else(M3::zeros, |((b, m), inverse)| mobility(b, m, &inverse, at));
        let touch = Touch {
            body: i,
            other,
            at,
            normal,
            gap,
            surface,
            mobility: own + theirs,
            pressed: 0.0,
            rubbed: V3::zeros(),
        };
        found.push(touch);
    }
}

/// A body while its contacts are solved: it does not move meanwhile, so that its inertia is known.
struct Live {
    inverse: M3,
    omega: V3,
}

impl Live {
    fn velocity(&self, moving: &Moving, at: V3) -> V3 {
        moving.velocity + self.omega.cross(&(at - moving.position))
    }

    /// Gives an impulse at a point and notes it; answers its work \[J\].
    fn kick(&mut self, (body, moving): (&Body, &mut Moving), impulse: V3, at: V3, pushed: &mut [V3; 2]) -> f64 {
        let angular = (at - moving.position).cross(&impulse);
        let before = self.velocity(moving, at);
        moving.velocity += impulse / body.mass;
        moving.spin += angular;
        self.omega += self.inverse * angular;
        *pushed = [pushed[0] + impulse, pushed[1] + angular];
        0.5 * impulse.dot(&(before + self.velocity(moving, at)))
    }
}

/// Solves all touches in turn, so often; books what walls give all bodies, and what each is given.
pub(crate) fn settle(
    model: &Model,
    state: &mut State,
    touches: &mut [Touch],
    h: f64,
    external: &mut Budget,
    pushed: &mut [[V3; 2]],
) {
    let live = |(b, m): (&Body, &Moving)| Live { inverse: b.inverse_now(m), omega: b.omega(m) };
    let mut lives: Vec<Live> = model.bodies.iter().zip(&state.bodies).map(live).collect();
    for _ in 0..model.turns {
        for touch in touches.iter_mut() {
            let (own, other, at) = (touch.body, touch.other, touch.at);
            let theirs = other.map_or_else(V3::zeros, |k| lives[k].velocity(&state.bodies[k], at));
            let impulse = touch.missing(lives[own].velocity(&state.bodies[own], at) - theirs, h);
            let mut give = |i: usize, impulse: V3| {
                lives[i].kick((&model.bodies[i], &mut state.bodies[i]), impulse, at, &mut pushed[i])
            };
            let work_j = give(own, impulse);
            if let Some(k) = other {
                give(k, -impulse);
            } else {
                let wrench = Wrench { linear: impulse.into(), angular: at.cross(&impulse).into() };
                external.add(Budget { wrench, work_j });
            }
        }
    }
}

impl Touch {
    /// Impulse that is missing at that relative velocity.
    fn missing(&mut self, velocity: V3, h: f64) -> V3 {
        let n = self.normal;
        let along = n.dot(&(self.mobility * n));
        let least = if self.gap > 0.0 { -self.gap / h } else { (-self.gap * GIVEN_BACK / h).min(FASTEST) };
        let pressed = (self.pressed + (least - velocity.dot(&n)) / along).max(0.0);
        let push = n * (pressed - self.pressed);
        self.pressed = pressed;
        let velocity = velocity + self.mobility * push;
        let across = velocity - n * velocity.dot(&n);
        let mut rubbed = self.rubbed;
        if let Some(direction) = across.try_normalize(0.0) {
            rubbed -= across / direction.dot(&(self.mobility * direction));
        }
        let Surface(fixed, sliding) = self.surface;
        if rubbed.norm() > fixed * pressed {
            rubbed *= sliding.min(fixed) * pressed / rubbed.norm();
        }
        let rub = rubbed - self.rubbed;
        self.rubbed = rubbed;
        push + rub
    }
}
