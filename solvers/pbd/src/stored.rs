//! Energy stored in constraints.
//!
//! What a substep of few sweeps does to a sheet that is at rest is not what its compliances say: with the multipliers
//! `λ = -L⁻¹ C`, `L` the lower triangle of `J W Jᵀ + α/h²` of one sweep, it is softer. The forces `λ/h²` that a substep
//! would give at rest hold the energy `½ Cᵀ L⁻¹ C / h²`, which is what moving against them takes where they follow the
//! displacement in proportion. It is positive: the symmetric part of `L` is.

use crate::sim::{Sim, anchor, project};
use crate::tally::Tally;
use crate::vertex::{Solve, Sweeps, Vertex};

impl Sim {
    /// Energy stored in constraints \[J\], as substeps of the longest length feel it.
    pub(crate) fn stored(&self) -> f64 {
        let (setting, size) = (&self.setting, self.size);
        let (mut edges, mut hinges) = (self.edges.clone(), self.hinges.clone());
        if !setting.relaxed {
            let at_rest = |v: &Vertex| Vertex { u: [0.0; 3], ..*v };
            let mut vertices: Vec<Vertex> = self.vertices.iter().map(at_rest).collect();
            let (h, mut world) = (setting.longest, Tally::default());
            for i in 0..setting.iterations[0].max(setting.iterations[1]) {
                let turn = setting.iterations.map(|n| i < n);
                let solver = Solve { h, per_h2: 1.0 / (h * h), first: i == 0, relaxed: false };
                for (b, v) in vertices.chunks_mut(size).enumerate() {
                    project(v, &mut edges.first[b], &mut hinges.first[b], turn, &solver);
                }
                for (b, v) in vertices.get_mut(size / 2..).unwrap_or_default().chunks_mut(size).enumerate() {
                    project(v, &mut edges.shifted[b], &mut hinges.shifted[b], turn, &solver);
                }
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
        edges.energy(&self.vertices, size, &first) + hinges.energy(&self.vertices, size, &second)
    }
}
