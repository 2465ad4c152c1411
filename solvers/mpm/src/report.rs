//! State and budgets, summed in f64 from the particles.
//!
//! A particle's angular momentum is `x × m v` plus that of its affine velocity, `m (dx²/4) [C₃₂-C₂₃, C₁₃-C₃₁, C₂₁-C₁₂]`;
//! its kinetic energy `m v²/2 + m (dx²/8) |C|²`: with both, transfers conserve angular momentum exactly.

use cosplat_core::boundary::{Wrench, add, cross, dot, norm, scale, sub};
use cosplat_core::plugin::{BodyState, Energy, PartInfluence};
use nalgebra::{Matrix3, Vector3};
use rayon::prelude::*;

use crate::fbar::FBar;
use crate::real::{Lanes, Real};
use crate::sim::Sim;
use crate::store::{B, Block, C, M, PAST, V, VOL};

/// Sums over the particles of a block or a body.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Sums {
    body: u32,
    mass: f64,
    /// Σ m x.
    moment: [f64; 3],
    momentum: Wrench,
    gross: f64,
    kinetic: f64,
    elastic: f64,
    /// Σ m x xᵀ, without the trace: xx, yy, zz, xy, xz, yz.
    second: [f64; 6],
    farthest: f64,
    /// Largest principal stretch, or more; of what flows 0.
    stretch: f64,
}

impl Sums {
    fn add(&mut self, other: &Self) {
        self.mass += other.mass;
        self.moment = add(self.moment, other.moment);
        self.momentum = self.momentum.plus(other.momentum);
        self.gross += other.gross;
        self.kinetic += other.kinetic;
        self.elastic += other.elastic;
        self.second.iter_mut().zip(other.second).for_each(|(a, b)| *a += b);
        self.farthest = self.farthest.max(other.farthest);
        self.stretch = self.stretch.max(other.stretch);
    }

    fn state(&self) -> BodyState {
        let center = scale(self.moment, 1.0 / self.mass);
        let velocity = scale(self.momentum.linear, 1.0 / self.mass);
        BodyState {
            mass_kg: self.mass,
            position_m: center,
            orientation: [0.0, 0.0, 0.0, 1.0],
            linear_velocity_m_s: velocity,
            angular_velocity_rad_s: self.spin(center),
            momentum: self.momentum,
            gross_momentum: self.gross,
            max_displacement_m: self.farthest,
        }
    }

    /// Angular velocity of the rigid body with the same mass distribution and angular momentum; 0 for a point.
    fn spin(&self, center: [f64; 3]) -> [f64; 3] {
        let [xx, yy, zz, xy, xz, yz] = self.second;
        let (m, c) = (self.mass, center);
        let s = [xx - m * c[0] * c[0], yy - m * c[1] * c[1], zz - m * c[2] * c[2]];
        let (pxy, pxz, pyz) = (m * c[0] * c[1] - xy, m * c[0] * c[2] - xz, m * c[1] * c[2] - yz);
        let inertia = Matrix3::new(s[1] + s[2], pxy, pxz, pxy, s[0] + s[2], pyz, pxz, pyz, s[0] + s[1]);
        let about = sub(self.momentum.angular, cross(center, self.momentum.linear));
        inertia.cholesky().map_or([0.0; 3], |i| i.solve(&Vector3::from(about)).into())
    }
}

impl<R: Real> Sim<R> {
    fn block(&self, (index, block): (usize, &Block), averages: &FBar<R>, start: &[[f64; 3]]) -> Sums {
        let (store, dx) = (&self.store, self.setting.dx);
        let mut sums = Sums { body: block.body, ..Sums::default() };
        if let Some(average) = averages.of(index, &self.setting.laws[block.part as usize]) {
            for (i, quad) in store.quads[block.range()].iter().enumerate() {
                let energy = (average.energy(quad, (block.live as usize - 4 * i).min(4)) * quad[VOL]).array();
                sums.elastic += energy.iter().map(|e| e.f64()).sum::<f64>();
            }
        }
        for slot in (0..block.live as usize).map(|i| block.first as usize * 4 + i) {
            let (m, v, x) = (store.field(slot, M), store.triple(slot, V), store.position(block, slot, dx));
            let c: [f64; 9] = std::array::from_fn(|k| store.field(slot, C + k));
            let b: [f64; 6] = std::array::from_fn(|k| store.field(slot, B + k));
            let p = scale(v, m);
            let affine = scale([c[7] - c[5], c[2] - c[6], c[3] - c[1]], m * dx * dx / 4.0);
            sums.mass += m;
            sums.moment = add(sums.moment, scale(x, m));
            sums.momentum = sums.momentum.plus(Wrench { linear: p, angular: add(cross(x, p), affine) });
            sums.gross += norm(p);
            sums.kinetic += 0.5 * dot(p, v) + m * dx * dx / 8.0 * c.iter().map(|c| c * c).sum::<f64>();
            let law = &self.setting.laws[block.part as usize];
            sums.elastic += store.field(slot, VOL) * law.energy(b, store.field(slot, PAST));
            let pairs = [(0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)];
            sums.second.iter_mut().zip(pairs).for_each(|(s, (i, j))| *s += m * x[i] * x[j]);
            let id = store.ids[slot / 4][slot % 4] as usize;
            sums.farthest = sums.farthest.max(norm(sub(x, start[id])));
            if !law.flows() {
                sums.stretch = sums.stretch.max(stretch(b));
            }
        }
        sums
    }

    /// State of each body, the energies and the largest elastic stretch at time `t` \[s\], for particles that started at
    /// `start`.
    pub(crate) fn states(&self, start: &[[f64; 3]], t: f64, dissipated: f64) -> (Vec<BodyState>, Energy, f64) {
        let averages = self.averages();
        let one = |block: (usize, &Block)| self.block(block, &averages, start);
        let blocks: Vec<Sums> = if self.parallel() {
            self.store.blocks.par_iter().enumerate().map(one).collect()
        } else {
            self.store.blocks.iter().enumerate().map(one).collect()
        };
        let mut bodies = vec![Sums::default(); self.setting.names.len()];
        for sums in &blocks {
            bodies[sums.body as usize].add(sums);
        }
        let mut energy = Energy { dissipated_j: dissipated, ..Energy::default() };
        for (i, sums) in bodies.iter().enumerate() {
            energy.kinetic_j += sums.kinetic;
            energy.potential_j += sums.elastic;
            for action in self.setting.actions.iter().filter(|a| a.has_potential && a.bodies[i]) {
                if let PartInfluence::Uniform(g) = action.influence
                    && (action.from..=action.until).contains(&t)
                {
                    energy.potential_j -= dot(g, sums.moment);
                }
            }
        }
        let stretch = bodies.iter().map(|sums| sums.stretch).fold(0.0, f64::max);
        (bodies.iter().map(Sums::state).collect(), energy, stretch)
    }
}

/// Largest principal stretch of the strain `b_e - I` (xx, yy, zz, xy, xz, yz), from above: no eigenvalue of a symmetric
/// matrix is further from their mean than `√(2/3)` times the norm of its deviator, and the largest is as far under uniaxial
/// tension (Wolkowicz and Styan, "Bounds for eigenvalues using traces", 1980).
fn stretch(b: [f64; 6]) -> f64 {
    let mean = (b[0] + b[1] + b[2]) / 3.0;
    let [x, y, z] = [b[0] - mean, b[1] - mean, b[2] - mean];
    let norm2 = x * x + y * y + z * z + 2.0 * (b[3] * b[3] + b[4] * b[4] + b[5] * b[5]);
    (1.0 + mean + (norm2 * 2.0 / 3.0).sqrt()).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_bound_of_the_stretch_is_the_stretch_of_a_pulled_bar_and_above_that_of_a_sheared_one() {
        let bar = stretch([1.5 * 1.5 - 1.0, 0.81 - 1.0, 0.81 - 1.0, 0.0, 0.0, 0.0]);
        // A few roundings of numbers of order one.
        assert!((bar - 1.5).abs() < 1e-14, "{bar}");
        // Simple shear γ: b - I has γ² and γ; its largest stretch is γ/2 + √(1 + γ²/4).
        let (shear, exact) = (stretch([0.25, 0.0, 0.0, 0.5, 0.0, 0.0]), 0.25 + 1.0625_f64.sqrt());
        assert!(shear >= exact && shear < 1.1 * exact, "{shear} {exact}");
    }
}
