//! State and budgets, summed from the grid and the particles.

use cosplat_core::boundary::{Vec3, add, dot, norm, scale, sub};
use cosplat_core::plugin::{BodyState, Energy};

use crate::flux::sums;
use crate::model::Model;
use crate::store::Store;

/// State of the body and the energies at time `t` \[s\].
///
/// Mass, place and velocity are those of the smoke, momentum and kinetic energy those of all gas in the domain: smoke
/// has none of its own.
pub(crate) fn state(model: &Model, store: &Store, t: f64) -> (BodyState, Energy) {
    let mass = model.cell_mass();
    let (all, gross, squares) = sums(&model.grid, model.sides, &store.u);
    let count = store.x.len().max(1) as f64;
    let mean = |sum: Vec3| scale(sum, 1.0 / count);
    let place = mean(store.x.iter().fold([0.0; 3], |s, &x| add(s, x)));
    let velocity = mean(store.x.iter().fold([0.0; 3], |s, &x| add(s, model.grid.velocity(&store.u, x))));
    let moved = store.x.iter().zip(&model.start).map(|(&x, &s)| norm(sub(x, s))).fold(0.0, f64::max);
    let body = BodyState {
        mass_kg: model.particle[0] * store.x.len() as f64,
        position_m: place,
        orientation: [0.0, 0.0, 0.0, 1.0],
        linear_velocity_m_s: velocity,
        angular_velocity_rad_s: [0.0; 3],
        momentum: cosplat_core::boundary::Wrench { linear: scale(all.linear, mass), angular: scale(all.angular, mass) },
        gross_momentum: gross * mass,
        max_displacement_m: moved,
    };
    (body, Energy { kinetic_j: 0.5 * squares * mass, potential_j: potential(model, store, t), dissipated_j: 0.0 })
}

/// Potential energy of the smoke against air at time `t` \[s\], in joules.
pub(crate) fn potential(model: &Model, store: &Store, t: f64) -> f64 {
    let mass = model.cell_mass();
    let gravity = model.gravity(t, t + f64::MIN_POSITIVE.max(1e-9));
    let mut potential = 0.0;
    let n = model.grid.n.map(|n| n as isize);
    for z in 0..n[2] {
        for y in 0..n[1] {
            for x in 0..n[0] {
                let c = store.c[model.grid.at([x, y, z])];
                if c != 0.0 {
                    potential -= mass * model.heavier * c * dot(gravity, model.grid.middle([x, y, z]));
                }
            }
        }
    }
    potential
}
