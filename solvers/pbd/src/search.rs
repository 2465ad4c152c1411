//! Points of triangles that come nearer to a solid than the triangles' corners do: over its edges, corners and ridges.
//!
//! The point of a triangle with the least signed distance is looked for by steps along the distance's gradient, each
//! half as long as the one before, brought back into the triangle (local optimisation as in Macklin et al., "Local
//! optimization for robust signed distance field collision", 2020). Where the distance is linear over a triangle, as
//! beside a flat face, its corners are enough and nothing is found.

use cosplat_core::boundary::{add, dot, norm, scale, sub};
use cosplat_core::distance::{Placed, SignedDistance};
use rayon::prelude::*;

use crate::closest::{at, on_triangle};
use crate::place::Place;
use crate::vertex::Vertex;

/// Steps of the search. The first is half a side long, the last 1/64 of that, well below what a substep moves.
const STEPS: u32 = 6;

/// What a search is about.
pub(crate) struct Search<'a> {
    pub(crate) vertices: &'a [Vertex],
    pub(crate) triangles: &'a [[u32; 3]],
    /// Distance within which a triangle matters \[m\].
    pub(crate) reach: f64,
    /// How much nearer than its corners a point must be to be worth a contact of its own \[m\].
    pub(crate) tolerance: f64,
    pub(crate) parallel: bool,
}

impl Search<'_> {
    /// The points near one solid, in the order of the triangles; `takes` says which vertices it meets.
    pub(crate) fn run(&self, solid: &Placed, takes: impl Fn(usize) -> bool + Sync) -> Vec<Place> {
        let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
        for v in self.vertices {
            low = std::array::from_fn(|k| low[k].min(v.x[k]));
            high = std::array::from_fn(|k| high[k].max(v.x[k]));
        }
        if solid.at_least(scale(add(low, high), 0.5), 0.5 * norm(sub(high, low))) > self.reach {
            return Vec::new();
        }
        let corner = |i: usize| if takes(i) { solid.distance(self.vertices[i].x).0 } else { f64::INFINITY };
        let count = self.vertices.len();
        if self.parallel {
            let corners: Vec<f64> = (0..count).into_par_iter().map(corner).collect();
            self.triangles.par_iter().filter_map(|&t| self.one(solid, t, &corners)).collect()
        } else {
            let corners: Vec<f64> = (0..count).map(corner).collect();
            self.triangles.iter().filter_map(|&t| self.one(solid, t, &corners)).collect()
        }
    }

    /// The point of one triangle that is deepest, where its corners do not say as much.
    fn one(&self, solid: &Placed, triangle: [u32; 3], corners: &[f64]) -> Option<Place> {
        let x = triangle.map(|i| self.vertices[i as usize].x);
        let d = triangle.map(|i| corners[i as usize]);
        let side = norm(sub(x[1], x[0])).max(norm(sub(x[2], x[0]))).max(norm(sub(x[2], x[1])));
        // A distance changes no faster than the way.
        if d[0].min(d[1]).min(d[2]) > self.reach + side {
            return None;
        }
        let mut share = [1.0 / 3.0; 3];
        let mut step = 0.5 * side;
        let mut best: Option<(f64, [f64; 3])> = None;
        for _ in 0..=STEPS {
            let p = at(x, share);
            let (distance, normal) = solid.distance(p);
            if distance > self.reach + side {
                return None;
            }
            if distance < dot(d, share) - self.tolerance && best.is_none_or(|(least, _)| distance < least) {
                best = Some((distance, share));
            }
            share = on_triangle(x, sub(p, scale(normal, step)));
            step *= 0.5;
        }
        best.filter(|(distance, _)| *distance < self.reach).map(|(_, share)| Place::on(triangle, share))
    }
}
