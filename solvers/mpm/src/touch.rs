//! Where bodies touch colliders: places on the surface of single particles.
//!
//! A particle stands for a cube of material; its surface towards a collider lies `r = V0^(1/3)/2 √(1 + nᵀBn)` from its
//! middle, B being its elastic strain. What is kept from passing is that place `x_c = x_p - r n`, at the velocity that
//! the grid has there by linear extrapolation from the particle, `v(x_c) = Σ a_i v_i` with
//! `a_i = w_i (1 + (4/dx²) (x_i - x_p)·(x_c - x_p))`. Since `Σ a_i = 1` and `Σ a_i x_i = x_c`, an impulse spread with the
//! same weights acts exactly there, in momentum and in moment. The place moves with the particle and not with the nodes:
//! contact is neither early by the reach of the kernel nor does it move in steps of a cell. The weights of the particle's
//! own nodes bound `Σ a_i²/m_i` by a few `1/m_p`, so that nodes with almost no mass do no harm.
//!
//! A partner's samples are met where their impulses will act, in the middle of those that count (`patch`).

use cosplat_core::boundary::{add, dot, scale, sub};
use rayon::prelude::*;

use crate::grid::{Grid, Substep};
use crate::nodes::Nodes;
use crate::real::Real;
use crate::store::{B, Block, Store, VOL, X};
use crate::swarm::{Cloud, Swarm};
use crate::topology::REACH;
use crate::walls::{BLOCK_RADIUS, Surface, Walls, middle};
use cosplat_core::distance::{Placed, SignedDistance};

/// Gap up to which a place is watched, in cells: a particle crosses at most half a cell in a substep.
const WATCHED: f64 = 0.25;
/// Gap up to which a surface that sticks takes hold, in cells.
const HOLDS: f64 = 0.05;

/// Share of an overlap that is undone in a substep, and the most of it, in cells.
const GIVEN_BACK: f64 = 0.1;
const FASTEST: f64 = 0.002;

/// Farthest from a particle that an impulse acts on it, in cells: `Σ a_i²/m_i` grows by four times the square of that.
const FARTHEST: f64 = 1.0;

/// A rigid partner where it is now.
pub(crate) struct Moved {
    /// Shape and place.
    pub(crate) shape: Placed,
    /// Surface for each own body.
    pub(crate) surface: Vec<Option<Surface>>,
}

/// All that bodies can touch.
pub(crate) struct Colliders<'a> {
    /// Static colliders.
    pub(crate) walls: &'a Walls,
    /// Rigid partners.
    pub(crate) moved: &'a [Moved],
    /// Partners that show samples.
    pub(crate) clouds: &'a [Cloud],
    pub(crate) swarms: &'a [Swarm],
    /// Half the width of the widest particle \[m\].
    pub(crate) half: f64,
}

/// One place in reach of a collider.
#[derive(Clone, Debug)]
pub(crate) struct Touch {
    /// Particle.
    pub(crate) id: u32,
    /// Its body.
    pub(crate) body: usize,
    /// Collider: a wall, after the walls a rigid partner, after these a partner that shows samples.
    pub(crate) cause: usize,
    /// The place \[m\].
    pub(crate) x: [f64; 3],
    /// Outward normal of the collider.
    pub(crate) normal: [f64; 3],
    /// Distance, negative where they overlap \[m\].
    pub(crate) gap: f64,
    /// What the surface does.
    pub(crate) surface: Surface,
    /// Whether it is held in every direction.
    pub(crate) held: bool,
    /// Nodes and their weights.
    pub(crate) nodes: [u32; 27],
    pub(crate) weights: [f64; 27],
    /// `Σ a_i²/m_i` \[1/kg\].
    pub(crate) inverse: f64,
    /// The partner's samples and their shares, and the same sum of them \[1/kg\]; nothing for other colliders.
    pub(crate) shares: Vec<(u32, f64)>,
    pub(crate) gives: f64,
    /// Impulse on the body \[N s\].
    pub(crate) impulse: [f64; 3],
}

/// A place before its nodes are known.
struct Found {
    block: u32,
    slot: u32,
    cause: usize,
    /// Middle of the particle, and from there to the place \[m\].
    x: [f64; 3],
    way: [f64; 3],
    normal: [f64; 3],
    gap: f64,
    surface: Surface,
    shares: Vec<(u32, f64)>,
    gives: f64,
}

/// All places in reach, in the order of the particles in memory and then of the colliders.
pub(crate) fn touches<R: Real>(
    step: &Substep,
    store: &Store<R>,
    grid: &Grid<R>,
    colliders: &Colliders,
    nodes: &mut Nodes,
) -> Vec<Touch> {
    let one = |(b, block): (usize, &Block)| {
        let mut found = in_block(step, store, (b, block), colliders);
        at_samples(step, store, (b, block), colliders, &mut found);
        found
    };
    let found: Vec<Vec<Found>> = if step.parallel {
        store.blocks.par_iter().enumerate().map(one).collect()
    } else {
        store.blocks.iter().enumerate().map(one).collect()
    };
    nodes.begin(step.topology.entries.len());
    found.into_iter().flatten().map(|f| touch(step, store, grid, nodes, f)).collect()
}

fn in_block<R: Real>(
    step: &Substep,
    store: &Store<R>,
    (b, block): (usize, &Block),
    colliders: &Colliders,
) -> Vec<Found> {
    let Colliders { walls, moved: partners, .. } = colliders;
    let (dx, body, at) = (step.dx, block.body as usize, middle(block, step.dx));
    let still = walls.near[b].iter().filter_map(|&w| {
        let wall = &walls.list[w as usize];
        wall.surface[body].map(|surface| (w as usize, &wall.shape, surface))
    });
    let moving = partners.iter().enumerate().filter_map(|(i, partner)| {
        let near = partner.shape.at_least(at, BLOCK_RADIUS * dx) < dx;
        partner.surface[body].filter(|_| near).map(|surface| (walls.list.len() + i, &partner.shape, surface))
    });
    let near: Vec<(usize, &Placed, Surface)> = still.chain(moving).collect();
    let mut found = Vec::new();
    if near.is_empty() {
        return found;
    }
    for slot in (0..block.live).map(|i| block.first * 4 + i) {
        let p = store.position(block, slot as usize, dx);
        for &(cause, shape, surface) in &near {
            let (phi, normal) = shape.distance(p);
            // Half a particle is never more than two cells.
            if phi > (2.0 + WATCHED) * dx {
                continue;
            }
            let reach = half_width(store, slot as usize, normal);
            let gap = phi - reach;
            if gap < WATCHED * dx {
                let way = scale(normal, -reach);
                let (shares, gives) = (Vec::new(), 0.0);
                found.push(Found { block: b as u32, slot, cause, x: p, way, normal, gap, surface, shares, gives });
            }
        }
    }
    found
}

/// Adds the places where a block's particles meet samples.
fn at_samples<R: Real>(
    step: &Substep,
    store: &Store<R>,
    (b, block): (usize, &Block),
    colliders: &Colliders,
    found: &mut Vec<Found>,
) {
    let (dx, first) = (step.dx, colliders.walls.list.len() + colliders.moved.len());
    for (k, (cloud, swarm)) in colliders.clouds.iter().zip(colliders.swarms).enumerate() {
        let Some(surface) = cloud.pairs[block.body as usize] else { continue };
        let reach = cloud.marks.reach(colliders.half);
        let (near, [low, high]) = swarm.around(block, dx, reach);
        if near.is_empty() {
            continue;
        }
        for slot in (0..block.live).map(|i| block.first * 4 + i) {
            let p = store.position(block, slot as usize, dx);
            if (0..3).any(|k| p[k] < low[k] - reach || p[k] > high[k] + reach) {
                continue;
            }
            let half = 0.5 * libm::cbrt(store.field(slot as usize, VOL));
            let Some(patch) = swarm.patch(&cloud.marks, &near, p, half) else { continue };
            let gap = patch.distance - half_width(store, slot as usize, patch.normal);
            if gap < WATCHED * dx {
                let far = dot(patch.way, patch.way).sqrt() / (FARTHEST * dx);
                let (way, gives) = (scale(patch.way, 1.0 / far.max(1.0)), cloud.marks.gives(&patch.shares));
                let (cause, normal, shares) = (first + k, patch.normal, patch.shares);
                found.push(Found { block: b as u32, slot, cause, x: p, way, normal, gap, surface, shares, gives });
            }
        }
    }
}

/// Distance of a particle's surface from its middle \[m\].
fn half_width<R: Real>(store: &Store<R>, slot: usize, n: [f64; 3]) -> f64 {
    let b: [f64; 6] = std::array::from_fn(|k| store.field(slot, B + k));
    let strain = b[0] * n[0] * n[0]
        + b[1] * n[1] * n[1]
        + b[2] * n[2] * n[2]
        + 2.0 * (b[3] * n[0] * n[1] + b[4] * n[0] * n[2] + b[5] * n[1] * n[2]);
    0.5 * libm::cbrt(store.field(slot, VOL)) * (1.0 + strain).max(0.0).sqrt()
}

fn touch<R: Real>(step: &Substep, store: &Store<R>, grid: &Grid<R>, nodes: &mut Nodes, found: Found) -> Touch {
    let (slot, dx) = (found.slot as usize, step.dx);
    let tilt = scale(found.way, 4.0 / dx);
    let id = store.ids[slot / 4][slot % 4];
    let mut touch = Touch {
        id,
        body: store.blocks[found.block as usize].body as usize,
        cause: found.cause,
        x: add(found.x, found.way),
        normal: found.normal,
        gap: found.gap,
        surface: found.surface,
        held: found.surface == Surface::Stick && found.gap <= HOLDS * dx,
        nodes: [0; 27],
        weights: [0.0; 27],
        inverse: 0.0,
        shares: found.shares,
        gives: found.gives,
        impulse: nodes.guess((id, found.cause)),
    };
    for (i, (place, own, at)) in around(step, store, found.block, found.slot).into_iter().enumerate() {
        let weight = own * (1.0 + dot(tilt, at));
        let number = nodes.number(place, step, grid);
        touch.nodes[i] = number;
        touch.weights[i] = weight;
        touch.inverse += weight * weight * nodes.inverse(number as usize);
    }
    touch
}

/// Nodes that a particle reaches: entry of the topology and node in it, weight, and the way there from the particle in
/// cells.
pub(crate) fn around<R: Real>(
    step: &Substep,
    store: &Store<R>,
    block: u32,
    slot: u32,
) -> [((u32, u32), f64, [f64; 3]); 27] {
    let reached = &step.topology.reached[block as usize];
    // Per axis: tile node of the first of three, weights, distances from the particle in cells.
    let axis = |k: usize| {
        let x = store.field(slot as usize, X + k);
        let first = (x - 0.5).floor();
        let d = x - first - 1.0;
        let (low, high) = (0.5 - d, 0.5 + d);
        ((first + 1.0) as usize, [0.5 * low * low, 0.75 - d * d, 0.5 * high * high], [-1.0 - d, -d, 1.0 - d])
    };
    let axes = [axis(0), axis(1), axis(2)];
    std::array::from_fn(|i| {
        let [a, b, c] = [i / 9, i / 3 % 3, i % 3];
        let at = place([axes[0].0 + a, axes[1].0 + b, axes[2].0 + c], reached);
        (at, axes[0].1[a] * axes[1].1[b] * axes[2].1[c], [axes[0].2[a], axes[1].2[b], axes[2].2[c]])
    })
}

/// Entry and node of a tile node.
fn place(tile: [usize; 3], reached: &[u32; 27]) -> (u32, u32) {
    let (mut neighbour, mut node) = (0, 0);
    for t in tile {
        let part = if t < REACH[1].0.start { 0 } else { usize::from(t >= REACH[2].0.start) + 1 };
        neighbour = neighbour * 3 + part;
        node = node * 4 + t - REACH[part].0.start + REACH[part].1;
    }
    (reached[neighbour], node as u32)
}

/// Least speed away from the collider that a place may have: as fast as closes its gap within the substep, or, where it
/// overlaps, a little outwards, so that roundings and what the impulses left over do not add up over many substeps.
pub(crate) fn least_speed(touch: &Touch, dt: f64, dx: f64) -> f64 {
    if touch.gap > 0.0 { -touch.gap / dt } else { (-touch.gap * GIVEN_BACK).min(FASTEST * dx) / dt }
}

/// Velocity of a place relative to a collider.
pub(crate) fn relative(nodes: &Nodes, touch: &Touch, collider: [f64; 3]) -> [f64; 3] {
    sub(nodes.at(touch), collider)
}
