//! State, energies and what partners see.

use cosplat_core::boundary::{BoundaryState, SampleStatics, Samples, Vec3, Wrench, add, cross, dot, norm, scale, sub};
use cosplat_core::plugin::{BodyState, Energy, PartInfluence};

use crate::model::{Cloth, Model};
use crate::sheet::normals;

impl Model {
    /// State of a body, summed over its vertices.
    pub(crate) fn state(&self, cloth: &Cloth) -> BodyState {
        let mut state = BodyState { orientation: [0.0, 0.0, 0.0, 1.0], ..BodyState::default() };
        for i in cloth.range.clone() {
            let v = &self.sim.vertices[i];
            let p = scale(v.u, v.mass);
            state.mass_kg += v.mass;
            state.position_m = add(state.position_m, scale(v.x, v.mass));
            state.momentum = state.momentum.plus(Wrench { linear: p, angular: cross(v.x, p) });
            state.gross_momentum += norm(p);
            state.max_displacement_m = state.max_displacement_m.max(norm(sub(v.x, self.start[i])));
        }
        state.position_m = scale(state.position_m, 1.0 / state.mass_kg);
        state.linear_velocity_m_s = scale(state.momentum.linear, 1.0 / state.mass_kg);
        state
    }

    /// Kinetic energy, and that stored in constraints \[J\].
    pub(crate) fn mechanical(&mut self, pool: Option<&rayon::ThreadPool>) -> [f64; 2] {
        let sim = &mut self.sim;
        let stored = match pool.filter(|_| sim.setting.parallel) {
            Some(pool) => pool.install(|| sim.stored(true)),
            None => sim.stored(false),
        };
        [self.sim.vertices.iter().map(|v| 0.5 * v.mass * dot(v.u, v.u)).sum(), stored]
    }

    /// Energies at time `t` \[s\], with what is kinetic and stored.
    pub(crate) fn energy(&self, t: f64, [kinetic_j, stored]: [f64; 2], dissipated_j: f64) -> Energy {
        let mut energy = Energy { kinetic_j, potential_j: stored, dissipated_j };
        for action in self.sim.setting.actions.iter().filter(|a| a.has_potential && (a.from..=a.until).contains(&t)) {
            let PartInfluence::Uniform(g) = action.influence else { continue };
            for cloth in self.cloths.iter().zip(&action.bodies).filter(|(_, acts)| **acts).map(|(cloth, _)| cloth) {
                let weights = self.sim.vertices[cloth.range.clone()].iter();
                energy.potential_j -= weights.map(|v| v.mass * dot(g, v.x)).sum::<f64>();
            }
        }
        energy
    }

    /// Unit normals of a body's vertices, in the order of the source.
    fn normals(&self, cloth: &Cloth) -> Vec<Vec3> {
        let at = |i: u32| self.sim.vertices[cloth.range.start + cloth.places[i as usize] as usize].x;
        normals(&cloth.triangles, &at, cloth.places.len())
    }

    /// Unit normals of all vertices, as in memory.
    pub(crate) fn all_normals(&self) -> Vec<Vec3> {
        let mut all = vec![[0.0; 3]; self.sim.vertices.len()];
        for cloth in &self.cloths {
            for (i, n) in cloth.order().zip(self.normals(cloth)) {
                all[i] = n;
            }
        }
        all
    }

    /// What partners see of a body: its vertices in the order of the source.
    pub(crate) fn samples(&self, cloth: &Cloth) -> BoundaryState {
        BoundaryState::Samples(Samples {
            position: cloth.order().map(|i| self.sim.vertices[i].x).collect(),
            velocity: cloth.order().map(|i| self.sim.vertices[i].u).collect(),
            normal: self.normals(cloth),
        })
    }

    /// What never changes about them.
    pub(crate) fn statics(&self, cloth: &Cloth) -> SampleStatics {
        let area = |i: usize| self.sim.area[i];
        SampleStatics {
            id: (0..cloth.places.len() as u64).collect(),
            area_m2: cloth.order().map(area).collect(),
            volume_m3: cloth.order().map(|i| area(i) * self.sim.setting.thickness).collect(),
            mass_kg: cloth.order().map(|i| self.sim.vertices[i].mass).collect(),
        }
    }
}
