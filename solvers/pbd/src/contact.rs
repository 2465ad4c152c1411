//! Contact of vertices and of points of triangles with walls, rigid partners and samples, with Coulomb friction.
//!
//! A place may approach no faster than closes its gap within the substep; the impulse for that at the inverse mass of
//! both sides is the normal impulse, and friction is at most its share of it. Impulses of one substep are summed per
//! place while all places are solved in turn, so that they end up inside the cone whatever the order.

use cosplat_core::boundary::{Vec3, add, dot, norm, scale, sub};
use nalgebra::{Matrix3, Vector3};

use crate::place::Place;
use crate::proxy::Proxy;
use crate::samples::Swarm;
use crate::tally::Tally;
use crate::vertex::Vertex;

/// Share of an overlap that is undone in a substep, and the speed at which at most \[m/s\].
const GIVEN_BACK: [f64; 2] = [0.1, 0.5];
/// The same at samples. They are held by what is behind them, which a window does not know: under a load `F` cloth of
/// mass `m` sinks in by about `F h/m` a second more than they say, and comes to rest where that much is given back.
const BY_SAMPLES: [f64; 2] = [0.5, 2.0];

/// Gap up to which a surface that sticks takes hold \[m\].
pub(crate) const HOLDS: f64 = 1e-6;

/// What a surface does to what touches it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Surface {
    /// Holds on in every direction.
    Stick,
    /// Static and kinetic friction; may separate.
    Coulomb(f64, f64),
}

/// Other side of a contact.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Cause {
    /// A static collider.
    Wall,
    /// A rigid partner.
    Proxy(usize),
    /// A sample of a partner.
    Sample(usize, u32),
    /// A point between two of its samples, so far from the first to the second.
    Seam(usize, [u32; 2], f64),
}

/// A place in reach of something.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Touch {
    pub(crate) place: Place,
    pub(crate) cause: Cause,
    /// Outward from the other side.
    pub(crate) normal: Vec3,
    /// Distance of the surfaces at the start of the substep \[m\].
    pub(crate) gap: f64,
    pub(crate) surface: Surface,
    /// Impulse on the vertex so far \[N s\]: along the normal, and across.
    pressed: f64,
    rubbed: Vec3,
}

impl Touch {
    /// Without an impulse.
    pub(crate) fn new(place: Place, cause: Cause, normal: Vec3, gap: f64, surface: Surface) -> Self {
        Self { place, cause, normal, gap, surface, pressed: 0.0, rubbed: [0.0; 3] }
    }

    /// Impulse that is missing, for a velocity relative to the other side and the velocity per impulse \[1/kg\].
    fn missing(&mut self, velocity: Vec3, mobility: &Mobility, h: f64) -> Vec3 {
        let n = self.normal;
        let holds = self.surface == Surface::Stick && self.gap <= HOLDS;
        let along = mobility.along(n);
        if along <= 0.0 {
            return [0.0; 3];
        }
        let by_samples = matches!(self.cause, Cause::Sample(..) | Cause::Seam(..));
        let back = if by_samples { BY_SAMPLES } else { GIVEN_BACK };
        let wanted = self.pressed + (least_of(back, self.gap, h) - dot(velocity, n)) / along;
        let pressed = if holds { wanted } else { wanted.max(0.0) };
        let push = scale(n, pressed - self.pressed);
        self.pressed = pressed;
        let velocity = add(velocity, mobility.times(push));
        let across = sub(velocity, scale(n, dot(velocity, n)));
        let speed = norm(across);
        let mut rubbed = self.rubbed;
        if speed > 0.0 {
            let along = mobility.along(scale(across, 1.0 / speed));
            rubbed = sub(rubbed, scale(across, 1.0 / along));
        }
        if let (Surface::Coulomb(fixed, sliding), false) = (self.surface, holds) {
            let size = norm(rubbed);
            if size > fixed * pressed {
                rubbed = scale(rubbed, sliding.min(fixed) * pressed / size);
            }
        }
        let rub = sub(rubbed, self.rubbed);
        self.rubbed = rubbed;
        add(push, rub)
    }
}

/// Least speed at which surfaces that are `gap` \[m\] apart must separate in a substep \[m/s\].
pub(crate) fn least(gap: f64, h: f64) -> f64 {
    least_of(GIVEN_BACK, gap, h)
}

fn least_of([share, fastest]: [f64; 2], gap: f64, h: f64) -> f64 {
    if gap > 0.0 { -gap / h } else { (-gap * share / h).min(fastest) }
}

/// Velocity per impulse between the two sides \[1/kg\].
#[derive(Clone, Copy, Debug)]
enum Mobility {
    /// The same in every direction.
    Round(f64),
    /// Of a rigid body.
    Full(Matrix3<f64>),
}

impl Mobility {
    fn times(&self, j: Vec3) -> Vec3 {
        match self {
            Self::Round(w) => scale(j, *w),
            Self::Full(m) => (m * Vector3::from(j)).into(),
        }
    }

    fn along(&self, direction: Vec3) -> f64 {
        dot(direction, self.times(direction))
    }
}

/// Solves the walls that one vertex touches; the only collider there is.
pub(crate) fn at_walls(vertex: &mut Vertex, touches: &mut [Touch], h: f64, tally: &mut Tally) {
    // One wall is exact at once; a corner settles in a few turns.
    let turns = if touches.len() == 1 { 1 } else { 4 };
    for _ in 0..turns {
        for touch in touches.iter_mut() {
            let missing = touch.missing(vertex.u, &Mobility::Round(vertex.w), h);
            tally.give(vertex, missing);
        }
    }
}

/// The other sides of contact in one substep.
pub(crate) struct Others<'s, 'a> {
    pub(crate) proxies: &'s mut [Proxy],
    pub(crate) swarms: &'s mut [Swarm<'a>],
    /// Effect of each swarm on its own body.
    pub(crate) on_own: &'s mut [Tally],
    /// Of walls, and of the world on vertices fixed to it.
    pub(crate) external: &'s mut Tally,
}

impl Others<'_, '_> {
    /// Gives the other side the reaction to an impulse on own body `body` at `x`; where that impulse is booked.
    pub(crate) fn give_back(&mut self, cause: Cause, body: usize, x: Vec3, impulse: Vec3) -> &mut Tally {
        match cause {
            Cause::Wall => &mut *self.external,
            Cause::Proxy(p) => {
                self.proxies[p].take(body, x, scale(impulse, -1.0));
                &mut self.proxies[p].on_own[body]
            }
            Cause::Sample(s, i) => {
                self.swarms[s].take(i, scale(impulse, -1.0));
                &mut self.on_own[s]
            }
            Cause::Seam(s, [i, j], share) => {
                self.swarms[s].take(i, scale(impulse, share - 1.0));
                self.swarms[s].take(j, scale(impulse, -share));
                &mut self.on_own[s]
            }
        }
    }
}

/// Solves all touches in turn.
pub(crate) fn settle(vertices: &mut [Vertex], owner: &[u32], touches: &mut [Touch], others: &mut Others, h: f64) {
    for touch in touches.iter_mut() {
        let place = touch.place;
        let (x, inverse) = (place.position(vertices), place.inverse(vertices));
        let body = owner[place.first()] as usize;
        let (other, mobility) = match touch.cause {
            Cause::Wall => ([0.0; 3], Mobility::Round(inverse)),
            Cause::Proxy(p) => {
                let proxy = &others.proxies[p];
                let full = proxy.mobility(x) + Matrix3::identity() * inverse;
                (proxy.velocity(x), Mobility::Full(full))
            }
            Cause::Sample(s, i) => {
                let swarm = &others.swarms[s];
                (swarm.velocity(i), Mobility::Round(inverse + swarm.inverse(i)))
            }
            Cause::Seam(s, ends, share) => {
                let (velocity, theirs) = others.swarms[s].between(ends, share);
                (velocity, Mobility::Round(inverse + theirs))
            }
        };
        let impulse = touch.missing(sub(place.velocity(vertices), other), &mobility, h);
        let tally = others.give_back(touch.cause, body, x, impulse);
        for (i, share) in place.parts() {
            tally.give(&mut vertices[i], scale(impulse, share));
        }
        // A vertex that is fixed hands on to the world what it is given.
        for (i, share) in place.parts().filter(|(i, _)| vertices[*i].w <= 0.0) {
            others.external.hold(&vertices[i], scale(impulse, share));
        }
    }
}

/// Books the work of partners on vertices that had the velocities `start` \[m/s\].
pub(crate) fn earn(vertices: &[Vertex], start: &[Vec3], owner: &[u32], touches: &[Touch], others: &mut Others) {
    for touch in touches {
        let impulse = add(scale(touch.normal, touch.pressed), touch.rubbed);
        let tally = match touch.cause {
            Cause::Wall => continue,
            Cause::Proxy(p) => &mut others.proxies[p].on_own[owner[touch.place.first()] as usize],
            Cause::Sample(s, _) | Cause::Seam(s, ..) => &mut others.on_own[s],
        };
        for (i, share) in touch.place.parts() {
            tally.earn(scale(impulse, share), [start[i], vertices[i].u]);
        }
    }
}
