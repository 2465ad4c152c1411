//! Energy stored in constraints.
//!
//! What a substep of few sweeps does to a sheet that is at rest is not what its compliances say: with the multipliers
//! `λ = -L⁻¹ C`, `L` the lower triangle of `J W Jᵀ + α/h²` of one sweep, it is softer. The forces `λ/h²` that a substep
//! would give at rest hold the energy `½ Cᵀ L⁻¹ C / h²`, which is what moving against them takes where they follow the
//! displacement in proportion. It is positive: the symmetric part of `L` is.

use std::borrow::Cow;

use crate::sim::{Sim, anchor, each, project};
use crate::tally::Tally;
use crate::vertex::{Solve, Sweeps, Vertex};

impl Sim {
    /// Energy stored in constraints \[J\], as substeps of the longest length feel it; `parallel` shares blocks out.
    pub(crate) fn stored(&self, parallel: bool) -> f64 {
        let (setting, size) = (&self.setting, self.size);
        let (mut edges, mut hinges) = (Cow::Borrowed(&self.edges), Cow::Borrowed(&self.hinges));
        if !setting.relaxed {
            let (edges, hinges) = (edges.to_mut(), hinges.to_mut());
            let at_rest = |v: &Vertex| Vertex { u: [0.0; 3], ..*v };
            let mut vertices: Vec<Vertex> = self.vertices.iter().map(at_rest).collect();
            let (h, mut world) = (setting.longest, Tally::default());
            for i in 0..setting.iterations[0].max(setting.iterations[1]) {
                let turn = setting.iterations.map(|n| i < n);
                let solver = Solve { h, per_h2: 1.0 / (h * h), first: i == 0, relaxed: false };
                let blocks = vertices.chunks_mut(size).zip(&mut edges.first).zip(&mut hinges.first);
                each(parallel, blocks.collect(), |_, ((v, edges), hinges)| project(v, edges, hinges, turn, &solver));
                let shifted = vertices.get_mut(size / 2..).unwrap_or_default().chunks_mut(size);
                let blocks = shifted.zip(&mut edges.shifted).zip(&mut hinges.shifted);
                each(parallel, blocks.collect(), |_, ((v, edges), hinges)| project(v, edges, hinges, turn, &solver));
                project(&mut vertices, &mut edges.rest, &mut hinges.rest, turn, &solver);
                if turn[0] {
                    edges.anchored.iter_mut().for_each(|c| anchor(c, &mut vertices, &solver, &mut world));
                }
                if turn[1] {
                    hinges.anchored.iter_mut().for_each(|c| anchor(c, &mut vertices, &solver, &mut world));
                }
            }
        }
        let sweeps = |n: u32| Sweeps { h: setting.longest, iterations: n, relaxed: setting.relaxed };
        let [first, second] = setting.iterations.map(sweeps);
        let now = (&self.vertices[..], size);
        edges.energy(now, &first, parallel) + hinges.energy(now, &second, parallel)
    }
}
