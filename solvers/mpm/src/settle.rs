//! Contact with walls and partners in one substep: impulses at the touching places.
//!
//! Each place may close its gap and no more: `u_n ≥ -g⁺/dt`, with Coulomb friction, or is held. The impulses follow
//! from projected Gauss–Seidel over the places: every step is the exact answer of one place with all others fixed, taken
//! at once by the nodes and by the partner's stand-in, so that the energy of the relative motion never rises and no ratio
//! of masses makes it diverge. Source: Moreau, "Unilateral contact and dry friction in finite freedom dynamics" (1988);
//! the same scheme for particles: Jean, "The non-smooth contact dynamics method" (1999).
//!
//! Sliding costs `-j·u` with the velocity after contact: what resting bodies push down and walls push back within one
//! substep is no loss.
//!
//! What the nodes took, rounding included, is what the books say and what the partner is given.

use cosplat_core::boundary::{Vec3, add, dot, norm, scale, sub};

use nalgebra::Vector3;

use crate::grid::{Grid, Substep};
use crate::nodes::Nodes;
use crate::proxy::{Free, Partner, Proxy};
use crate::real::{Lanes, Real};
use crate::store::Store;
use crate::swarm::{Cloud, Swarm};
use crate::tally::Tally;
use crate::tile::node_position;
use crate::touch::{Colliders, Moved, Touch, least_speed, relative, touches};
use crate::walls::{Surface, Walls};

/// Most passes over all places in one substep.
const PASSES: usize = 30;
/// Change of a velocity, over the largest that any place owes to its whole impulse, below which all are settled.
const SETTLED: f64 = 1e-3;

/// What happened at the colliders in one substep.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Contact {
    /// Walls' impulses.
    pub(crate) walls: Tally,
    /// Energy lost to sliding \[J\].
    pub(crate) lost: f64,
    /// Places with an impulse.
    pub(crate) places: u64,
    /// Passes over the places.
    pub(crate) passes: u64,
    /// Whether the passes ended before the impulses were settled.
    pub(crate) unsettled: bool,
}

/// The other sides of contact.
pub(crate) struct Others<'a> {
    /// Rigid partners and their stand-ins.
    pub(crate) partners: &'a [Partner],
    pub(crate) proxies: &'a mut [Proxy],
    /// Partners that show samples, and these.
    pub(crate) clouds: &'a [Cloud],
    pub(crate) swarms: &'a mut [Swarm],
    /// Half the width of the widest own particle \[m\].
    pub(crate) half: f64,
}

/// Contact of all bodies with all walls and partners.
pub(crate) fn collide<R: Real>(
    step: &Substep,
    (store, grid): (&Store<R>, &mut Grid<R>),
    walls: &Walls,
    others: &mut Others,
    nodes: &mut Nodes,
) -> Contact {
    others.proxies.iter_mut().for_each(|proxy| proxy.push(step.dt));
    for (cloud, swarm) in others.clouds.iter().zip(&mut *others.swarms) {
        swarm.push(step.dt);
        swarm.look(&store.blocks, step.dx, cloud.marks.reach(others.half));
    }
    let moved: Vec<Moved> = others.proxies.iter().map(|p| p.moved(&others.partners[p.partner])).collect();
    let mut contact = Contact::default();
    if !(walls.list.is_empty() && moved.is_empty() && others.swarms.is_empty()) {
        let (clouds, swarms, half) = (others.clouds, &*others.swarms, others.half);
        let colliders = Colliders { walls, moved: &moved, clouds, swarms, half };
        let mut list = touches(step, store, grid, &colliders, nodes);
        if !list.is_empty() {
            let twists = others.proxies.iter_mut().map(Proxy::free).collect();
            let mut sides = Sides { walls: walls.list.len(), others, twists };
            contact.settle(step, &mut list, nodes, &mut sides);
            hand_out(step, grid, &list, nodes, &mut sides, &mut contact.walls);
        }
        nodes.remember(&list);
    }
    others.proxies.iter_mut().for_each(|proxy| proxy.drift(step.dt));
    others.swarms.iter_mut().for_each(|swarm| swarm.drift(step.dt));
    contact
}

/// The other sides while impulses are sought.
struct Sides<'s, 'a> {
    walls: usize,
    others: &'s mut Others<'a>,
    twists: Vec<Free>,
}

/// What a touch is caused by.
enum Side {
    Wall,
    Proxy(usize),
    Swarm(usize),
}

impl Sides<'_, '_> {
    fn of(&self, touch: &Touch) -> Side {
        let Some(k) = touch.cause.checked_sub(self.walls) else { return Side::Wall };
        k.checked_sub(self.twists.len()).map_or(Side::Proxy(k), Side::Swarm)
    }

    /// Velocity of the other side \[m/s\].
    fn at(&self, touch: &Touch) -> Vec3 {
        match self.of(touch) {
            Side::Wall => [0.0; 3],
            Side::Proxy(k) => self.twists[k].at(&self.others.proxies[k], touch.x),
            Side::Swarm(k) => self.others.swarms[k].at(&touch.shares),
        }
    }

    /// Gives the other side the reaction to an impulse \[N s\].
    fn react(&mut self, touch: &Touch, impulse: Vec3) {
        let reaction = scale(impulse, -1.0);
        match self.of(touch) {
            Side::Wall => {}
            Side::Proxy(k) => self.twists[k].take(&self.others.proxies[k], touch.x, reaction),
            Side::Swarm(k) => self.others.swarms[k].take(&self.others.clouds[k].marks, &touch.shares, reaction),
        }
    }

    /// Change of the impulse at a place.
    fn change(&self, step: &Substep, touch: &Touch, nodes: &Nodes) -> Vec3 {
        let u = relative(nodes, touch, self.at(touch));
        match self.of(touch) {
            Side::Proxy(k) => on_rigid(step, touch, u, &self.others.proxies[k]),
            Side::Wall | Side::Swarm(_) => on_round(step, touch, u),
        }
    }
}

fn touching(touch: &Touch) -> bool {
    touch.impulse.iter().any(|j| j.abs() > 0.0)
}

impl Contact {
    /// Finds the impulses.
    fn settle(&mut self, step: &Substep, list: &mut [Touch], nodes: &mut Nodes, sides: &mut Sides) {
        // What they were in the last substep is close to what they will be.
        for touch in list.iter().filter(|t| touching(t)) {
            nodes.give(touch, touch.impulse);
            sides.react(touch, touch.impulse);
        }
        self.unsettled = true;
        for pass in 0..PASSES {
            let (mut largest, mut whole) = (0.0_f64, 0.0_f64);
            // Back and forth, so that what one end does reaches the other.
            for i in 0..list.len() {
                let touch = &mut list[if pass % 2 == 0 { i } else { list.len() - 1 - i }];
                let change = sides.change(step, touch, nodes);
                if change.iter().any(|j| j.abs() > 0.0) {
                    nodes.give(touch, change);
                    sides.react(touch, change);
                    touch.impulse = add(touch.impulse, change);
                    largest = largest.max(norm(change) * touch.inverse);
                }
                whole = whole.max(norm(touch.impulse) * touch.inverse);
            }
            self.passes += 1;
            if largest <= SETTLED * whole {
                self.unsettled = false;
                break;
            }
        }
        for touch in list.iter().filter(|t| touching(t)) {
            self.places += 1;
            let u = relative(nodes, touch, sides.at(touch));
            // How samples move along the normal is foreseen and not known: what that makes of energy is the interface's.
            let foreseen =
                if touch.shares.is_empty() { 0.0 } else { dot(touch.impulse, touch.normal) * dot(u, touch.normal) };
            self.lost -= dot(touch.impulse, u) - foreseen;
        }
    }
}

/// Change of the impulse where the other side gives way alike in all directions: a wall not at all, samples by their
/// masses.
fn on_round(step: &Substep, touch: &Touch, u: Vec3) -> Vec3 {
    let inverse = touch.inverse + touch.gives;
    let least = least_speed(touch, step.dt, step.dx);
    if touch.held {
        return scale(sub(scale(touch.normal, least.max(0.0)), u), 1.0 / inverse);
    }
    let missing = least - dot(u, touch.normal);
    let before = dot(touch.impulse, touch.normal);
    let normal = (before + missing / inverse).max(0.0);
    if normal <= 0.0 {
        return scale(touch.impulse, -1.0);
    }
    let along = sub(u, scale(touch.normal, dot(u, touch.normal)));
    let dragged = sub(touch.impulse, scale(touch.normal, before));
    let drag = rub(touch.surface, normal, sub(dragged, scale(along, 1.0 / inverse)));
    sub(add(scale(touch.normal, normal), drag), touch.impulse)
}

/// Change of the impulse at a rigid partner.
fn on_rigid(step: &Substep, touch: &Touch, u: Vec3, proxy: &Proxy) -> Vec3 {
    let n = touch.normal;
    let mobility = proxy.mobility(touch.x, touch.inverse);
    let least = least_speed(touch, step.dt, step.dx).max(if touch.held { 0.0 } else { f64::NEG_INFINITY });
    // As if it stuck.
    let missing = sub(scale(n, least), u);
    let wanted = Vector3::from(missing);
    let Some(change) = mobility.cholesky().map(|c| c.solve(&wanted)) else { return [0.0; 3] };
    let change: Vec3 = change.into();
    let whole = add(touch.impulse, change);
    if touch.held {
        return change;
    }
    let normal = dot(whole, n);
    let drag = sub(whole, scale(n, normal));
    let kept = rub(touch.surface, normal.max(0.0), drag);
    if normal > 0.0 && norm(sub(kept, drag)) <= 0.0 {
        return change;
    }
    // It slides or lets go: the normal part alone, beside the drag that the surface can bear.
    let before = dot(touch.impulse, n);
    let along: [f64; 3] = (mobility * Vector3::from(n)).into();
    let normal = (before + dot(missing, n) / dot(along, n)).max(0.0);
    sub(add(scale(n, normal), rub(touch.surface, normal, drag)), touch.impulse)
}

/// Largest friction impulse towards the one that would stop all sliding.
fn rub(surface: Surface, normal: f64, stop: Vec3) -> Vec3 {
    let size = norm(stop);
    match surface {
        Surface::Stick => stop,
        Surface::Coulomb(fixed, _) if size <= fixed * normal => stop,
        Surface::Coulomb(_, kinetic) => scale(stop, (kinetic * normal / size).min(1.0)),
    }
}

/// Writes the new velocities to the grid, collider by collider, and books what each node took.
fn hand_out<R: Real>(
    step: &Substep,
    grid: &mut Grid<R>,
    list: &[Touch],
    nodes: &mut Nodes,
    sides: &mut Sides,
    at_walls: &mut Tally,
) {
    let mut share = vec![[0.0; 3]; nodes.place.len()];
    let (walls, others) = (sides.walls, &mut *sides.others);
    let rigid = others.proxies.len();
    for cause in 0..=rigid + others.swarms.len() {
        // All walls are one cause: nobody asks which.
        let of_cause = |t: &&Touch| if cause == 0 { t.cause < walls } else { t.cause == walls + cause - 1 };
        let mut any = false;
        for touch in list.iter().filter(of_cause).filter(|t| touching(t)) {
            any = true;
            for (&node, &weight) in touch.nodes.iter().zip(&touch.weights) {
                share[node as usize] = add(share[node as usize], scale(touch.impulse, weight));
            }
        }
        if !any {
            continue;
        }
        for (i, share) in share.iter_mut().enumerate() {
            let j = std::mem::take(share);
            let ((entry, n), inverse) = (nodes.place[i], nodes.inverse(i));
            if inverse <= 0.0 || j.iter().all(|j| j.abs() <= 0.0) {
                continue;
            }
            let place = step.topology.entries[entry as usize];
            let slot = &mut grid.nodes[entry as usize][n as usize];
            let [vx, vy, vz, m] = slot.array();
            let (before, x) = ([vx, vy, vz].map(R::f64), node_position(place.at, n as usize, step.dx));
            let new = [0, 1, 2].map(|k| R::of(before[k] + j[k] * inverse));
            *slot = R::V::from_array([new[0], new[1], new[2], m]);
            let after = new.map(R::f64);
            if cause == 0 {
                at_walls.change(m.f64(), x, before, after);
            } else if cause <= rigid {
                others.proxies[cause - 1].answer(place.body as usize, m.f64(), x, before, after);
            } else {
                others.swarms[cause - 1 - rigid].on_own[place.body as usize].change(m.f64(), x, before, after);
            }
        }
        if let Some(swarm) = cause.checked_sub(rigid + 1).and_then(|k| others.swarms.get_mut(k)) {
            for touch in list.iter().filter(of_cause).filter(|t| touching(t)) {
                swarm.book(touch.body, &touch.shares, scale(touch.impulse, -1.0));
            }
        }
    }
    others.proxies.iter_mut().for_each(Proxy::take);
}
