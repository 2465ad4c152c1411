//! State and budgets, summed from the particles.

use cosplat_core::boundary::{Vec3, Wrench, add, cross, dot, norm, scale, sub};
use cosplat_core::plugin::{BodyState, Energy};

use crate::cohesion;
use crate::gates::is_here;
use crate::model::Model;
use crate::params::Pressure;
use crate::store::Store;

/// Sizes of the starting domain beyond which a particle has strayed.
const FAR: f64 = 20.0;

/// State of each body and the energies.
pub(crate) fn states(model: &Model, store: &Store) -> (Vec<BodyState>, Energy) {
    let at_rest = BodyState { orientation: [0.0, 0.0, 0.0, 1.0], ..BodyState::default() };
    let mut bodies = vec![at_rest; model.liquids.len()];
    let mut energy =
        Energy { dissipated_j: store.dissipated, potential_j: cohesion::energy(model, store), ..Energy::default() };
    for i in (0..store.len()).filter(|&i| is_here(store.rho[i])) {
        let id = store.id[i] as usize;
        let (b, mass, x, v) = (model.body[id] as usize, model.mass[id], store.x[i], store.v[i]);
        let (body, liquid) = (&mut bodies[b], &model.liquids[b]);
        let p = scale(v, mass);
        body.mass_kg += mass;
        body.position_m = add(body.position_m, scale(x, mass));
        body.momentum = body.momentum.plus(Wrench { linear: p, angular: cross(x, p) });
        body.gross_momentum += norm(p);
        body.max_displacement_m = body.max_displacement_m.max(norm(sub(x, model.start[id])));
        energy.kinetic_j += 0.5 * dot(p, v);
        if model.params.pressure == Pressure::Weak {
            energy.potential_j += mass * liquid.stored(store.rho[i]);
        }
        for action in model.gravity.iter().filter(|a| a.acts[b] && a.always) {
            energy.potential_j -= mass * dot(action.acceleration, x);
        }
    }
    for body in &mut bodies {
        let one = if body.mass_kg > 0.0 { 1.0 / body.mass_kg } else { 0.0 };
        body.position_m = scale(body.position_m, one);
        body.linear_velocity_m_s = scale(body.momentum.linear, one);
    }
    (bodies, energy)
}

/// Work of gravity that begins or ends, over a substep `start..end` \[s\] in which all moved with the velocities they have \[J\].
pub(crate) fn pulled(model: &Model, store: &Store, start: f64, end: f64) -> f64 {
    let mut work = 0.0;
    for action in model.gravity.iter().filter(|a| !a.always && a.share(start, end) > 0.0) {
        let all = (0..store.len()).filter(|&i| is_here(store.rho[i]));
        let moved =
            all.map(|i| (store.id[i] as usize, store.v[i])).filter(|&(id, _)| action.acts[model.body[id] as usize]);
        let momentum = moved.fold([0.0; 3], |sum, (id, v)| add(sum, scale(v, model.mass[id])));
        work += dot(action.acceleration, momentum) * (end - start) * action.share(start, end);
    }
    work
}

/// Largest compression in millionths, and the number of particles far from where all started.
pub(crate) fn quality(model: &Model, store: &Store) -> (u64, u64) {
    let fold = |f: fn(f64, f64) -> f64, start: f64| [0, 1, 2].map(|k| model.start.iter().map(|x| x[k]).fold(start, f));
    let (low, high) = (fold(f64::min, f64::INFINITY), fold(f64::max, f64::NEG_INFINITY));
    let middle: Vec3 = [0, 1, 2].map(|k| 0.5 * (low[k] + high[k]));
    let far = FAR * norm(sub(high, low)).max(model.kernel.reach);
    let (mut most, mut strayed) = (0.0_f64, 0);
    for (&id, (&x, &rho)) in store.id.iter().zip(store.x.iter().zip(&store.rho)) {
        let liquid = &model.liquids[model.body[id as usize] as usize];
        most = most.max(rho / liquid.rho - 1.0);
        strayed += u64::from(is_here(rho) && norm(sub(x, middle)) > far);
    }
    ((most * 1e6).round() as u64, strayed)
}
