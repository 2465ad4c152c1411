//! Energy stored in constraints.
//!
//! What a substep of few sweeps does to a sheet that is at rest is not what its compliances say: with the multipliers
//! `λ = -L⁻¹ C`, `L` the lower triangle of `J W Jᵀ + α/h²` of one sweep, it is softer. The forces `λ/h²` that a substep
//! would give at rest hold the energy `½ Cᵀ L⁻¹ C / h²`, which is what moving against them takes where they follow the
//! displacement in proportion. It is positive: the symmetric part of `L` is.

use cosplat_core::boundary::Vec3;

use crate::sim::Sim;
use crate::sweep::Sweep;
use crate::tally::Tally;
use crate::vertex::{Solve, Sweeps};

impl Sim {
    /// Energy stored in constraints \[J\], as substeps of the longest length feel it; `parallel` shares blocks out. Multipliers
    /// are left as that substep has them: the next one begins with none.
    pub(crate) fn stored(&mut self, parallel: bool) -> f64 {
        if !self.setting.relaxed {
            let moving: Vec<Vec3> = self.vertices.iter().map(|v| v.u).collect();
            self.vertices.iter_mut().for_each(|v| v.u = [0.0; 3]);
            self.sweep(parallel);
            self.vertices.iter_mut().zip(moving).for_each(|(v, u)| v.u = u);
        }
        let (setting, now) = (&self.setting, (&self.vertices[..], self.size));
        let sweeps = |n: u32| Sweeps { h: setting.longest, iterations: n, relaxed: setting.relaxed };
        let [first, second] = setting.iterations.map(sweeps);
        self.edges.energy(now, &first, parallel) + self.hinges.energy(now, &second, parallel)
    }

    /// What sweeps do in a substep of the longest length.
    fn sweep(&mut self, parallel: bool) {
        let setting = &self.setting;
        let (h, mut world, mut rooms) = (setting.longest, Tally::default(), vec![(); self.edges.first.len()]);
        for i in 0..setting.iterations[0].max(setting.iterations[1]) {
            let sweep = Sweep {
                vertices: &mut self.vertices,
                size: self.size,
                edges: &mut self.edges,
                hinges: &mut self.hinges,
                turn: setting.iterations.map(|n| i < n),
                solver: Solve { h, per_h2: 1.0 / (h * h), first: i == 0, relaxed: false },
                parallel,
            };
            sweep.run(&mut rooms, |_, _, ()| {}, &mut world);
        }
    }
}
