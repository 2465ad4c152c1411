//! One sweep over all constraints: blocks of vertices side by side, then blocks shifted by half, then what is wider than a
//! block, and last what is fixed to the world.

use rayon::prelude::*;

use crate::bend::Hinge;
use crate::stretch::Edge;
use crate::tally::Tally;
use crate::vertex::{Constraint, InTurn, Phases, Solve, Vertex};

/// Does something with each item, on one thread or several.
pub(crate) fn each<T: Send>(parallel: bool, items: Vec<T>, f: impl Fn(usize, T) + Sync + Send) {
    if parallel {
        items.into_par_iter().enumerate().for_each(|(i, item)| f(i, item));
    } else {
        items.into_iter().enumerate().for_each(|(i, item)| f(i, item));
    }
}

/// A sweep.
pub(crate) struct Sweep<'a> {
    pub(crate) vertices: &'a mut [Vertex],
    /// Vertices of a block.
    pub(crate) size: usize,
    pub(crate) edges: &'a mut Phases<Edge>,
    pub(crate) hinges: &'a mut Phases<Hinge>,
    /// Whether edges and hinges have their turn.
    pub(crate) turn: [bool; 2],
    pub(crate) solver: Solve,
    pub(crate) parallel: bool,
}

impl Sweep<'_> {
    /// Solves all; `before` is called with each block, its vertices and one of `rooms` first. What is fixed hands impulses on
    /// to `held`.
    pub(crate) fn run<R: Send>(
        self,
        rooms: &mut [R],
        before: impl Fn(usize, &mut [Vertex], &mut R) + Sync + Send,
        held: &mut Tally,
    ) {
        let Self { vertices, size, edges, hinges, turn, solver, parallel } = self;
        let blocks = vertices.chunks_mut(size).zip(&mut edges.first).zip(&mut hinges.first).zip(rooms);
        each(parallel, blocks.collect(), |b, (((vertices, edges), hinges), room)| {
            before(b, vertices, room);
            project(vertices, edges, hinges, turn, &solver);
        });
        let shifted = vertices.get_mut(size / 2..).unwrap_or_default().chunks_mut(size);
        let blocks = shifted.zip(&mut edges.shifted).zip(&mut hinges.shifted);
        let work = blocks.filter(|((_, e), h)| !(e.all.is_empty() && h.all.is_empty())).collect();
        each(parallel, work, |_, ((vertices, edges), hinges)| project(vertices, edges, hinges, turn, &solver));
        project(vertices, &mut edges.rest, &mut hinges.rest, turn, &solver);
        if turn[0] {
            edges.anchored.iter_mut().for_each(|c| anchor(c, vertices, &solver, held));
        }
        if turn[1] {
            hinges.anchored.iter_mut().for_each(|c| anchor(c, vertices, &solver, held));
        }
    }
}

/// Solves the constraints of a block.
fn project(
    vertices: &mut [Vertex],
    edges: &mut InTurn<Edge>,
    hinges: &mut InTurn<Hinge>,
    turn: [bool; 2],
    solver: &Solve,
) {
    if turn[0] {
        edges.solve(vertices, solver);
    }
    if turn[1] {
        hinges.solve(vertices, solver);
    }
}

/// Solves a constraint with an end that is fixed to the world, which takes that end's impulse.
fn anchor<const N: usize, C: Constraint<N>>(
    constraint: &mut C,
    vertices: &mut [Vertex],
    solver: &Solve,
    held: &mut Tally,
) {
    let ends = constraint.ends().map(|i| i as usize);
    if let Some(impulses) = constraint.impulses(ends.map(|i| &vertices[i]), solver) {
        for (i, impulse) in ends.into_iter().zip(impulses) {
            if vertices[i].w > 0.0 {
                vertices[i].take(impulse);
            } else {
                held.hold(&vertices[i], impulse);
            }
        }
    }
}
