//! Contact with walls and rigid partners in one substep: impulses at the touching places.
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
use crate::proxy::{Free, Partner, Proxy};
use crate::real::{Lanes, Real};
use crate::store::Store;
use crate::tally::Tally;
use crate::tile::node_position;
use crate::touch::{Moved, Nodes, Touch, least_speed, relative, touches};
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

/// Contact of all bodies with all walls and stand-ins.
pub(crate) fn collide<R: Real>(
    step: &Substep,
    (store, grid): (&Store<R>, &mut Grid<R>),
    walls: &Walls,
    partners: &[Partner],
    proxies: &mut [Proxy],
    nodes: &mut Nodes,
) -> Contact {
    for proxy in &mut *proxies {
        proxy.push(step.dt);
    }
    let moved: Vec<Moved> = proxies.iter().map(|p| p.moved(&partners[p.partner])).collect();
    let mut contact = Contact::default();
    if !(walls.list.is_empty() && moved.is_empty()) {
        let mut list = touches(step, store, grid, walls, &moved, nodes);
        if !list.is_empty() {
            contact.settle(step, &mut list, nodes, walls.list.len(), proxies);
            hand_out(step, grid, &list, nodes, walls.list.len(), proxies, &mut contact.walls);
        }
        nodes.remember(&list);
    }
    for proxy in proxies {
        proxy.drift(step.dt);
    }
    contact
}

fn touching(touch: &Touch) -> bool {
    touch.impulse.iter().any(|j| j.abs() > 0.0)
}

impl Contact {
    /// Finds the impulses.
    fn settle(&mut self, step: &Substep, list: &mut [Touch], nodes: &mut Nodes, walls: usize, proxies: &mut [Proxy]) {
        let mut twists: Vec<Free> = proxies.iter_mut().map(Proxy::free).collect();
        // What they were in the last substep is close to what they will be.
        for touch in list.iter().filter(|t| touching(t)) {
            nodes.give(touch, touch.impulse);
            if touch.cause >= walls {
                let k = touch.cause - walls;
                twists[k].take(&proxies[k], touch.x, scale(touch.impulse, -1.0));
            }
        }
        self.unsettled = true;
        for pass in 0..PASSES {
            let (mut largest, mut whole) = (0.0_f64, 0.0_f64);
            // Back and forth, so that what one end does reaches the other.
            for i in 0..list.len() {
                let touch = &mut list[if pass % 2 == 0 { i } else { list.len() - 1 - i }];
                let change = if touch.cause < walls {
                    on_wall(step, touch, nodes)
                } else {
                    let k = touch.cause - walls;
                    let change = on_partner(step, touch, nodes, &proxies[k], &twists[k]);
                    twists[k].take(&proxies[k], touch.x, scale(change, -1.0));
                    change
                };
                if change.iter().any(|j| j.abs() > 0.0) {
                    nodes.give(touch, change);
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
            let collider = touch.cause.checked_sub(walls).map_or([0.0; 3], |k| twists[k].at(&proxies[k], touch.x));
            self.places += 1;
            self.lost -= dot(touch.impulse, relative(nodes, touch, collider));
        }
    }
}

/// Change of the impulse at a wall.
fn on_wall(step: &Substep, touch: &Touch, nodes: &Nodes) -> Vec3 {
    let u = relative(nodes, touch, [0.0; 3]);
    let least = least_speed(touch, step.dt, step.dx);
    if touch.held {
        return scale(sub(scale(touch.normal, least.max(0.0)), u), 1.0 / touch.inverse);
    }
    let missing = least - dot(u, touch.normal);
    let before = dot(touch.impulse, touch.normal);
    let normal = (before + missing / touch.inverse).max(0.0);
    if normal <= 0.0 {
        return scale(touch.impulse, -1.0);
    }
    let along = sub(u, scale(touch.normal, dot(u, touch.normal)));
    let dragged = sub(touch.impulse, scale(touch.normal, before));
    let drag = rub(touch.surface, normal, sub(dragged, scale(along, 1.0 / touch.inverse)));
    sub(add(scale(touch.normal, normal), drag), touch.impulse)
}

/// Change of the impulse at a rigid partner.
fn on_partner(step: &Substep, touch: &Touch, nodes: &Nodes, proxy: &Proxy, twist: &Free) -> Vec3 {
    let n = touch.normal;
    let u = relative(nodes, touch, twist.at(proxy, touch.x));
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
    walls: usize,
    proxies: &mut [Proxy],
    at_walls: &mut Tally,
) {
    let mut share = vec![[0.0; 3]; nodes.place.len()];
    for cause in 0..=proxies.len() {
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
            } else {
                proxies[cause - 1].answer(place.body as usize, m.f64(), x, before, after);
            }
        }
    }
    proxies.iter_mut().for_each(Proxy::take);
}
