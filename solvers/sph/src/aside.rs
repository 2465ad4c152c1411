//! Putting aside: a few thrown particles act on nobody any more, and the run goes on.
//!
//! A particle that is faster than sound, or whose density left the range of the equation of state, keeps its mass and its
//! momentum, falls, and stops at static solids, but nothing presses it and it presses nothing: its volume counts as none.
//! It passes through partners. An incompressible liquid, whose speeds have no bound, has nobody put aside. What its compression had stored counts as dissipated. The mark is a negative density, so
//! that it is sorted, saved and restored with the particle, and the bytes of a run without any are those of a run without
//! this guard.

use cosplat_core::boundary::{Wrench, add, cross, dot, norm, scale};
use cosplat_core::distance::SignedDistance;
use cosplat_core::plugin::PluginError;

use crate::force::largest;
use crate::params::Pressure;
use crate::sim::Course;

/// Speed over that of sound above which a result means nothing.
const FASTEST: f64 = 1.0;
/// Range of densities over that at rest beyond which a result means nothing.
const DENSITIES: [f64; 2] = [0.2, 2.0];
/// Share of a body's particles above which its motion is no longer that of the body.
const MOST_ASIDE: f64 = 0.01;

impl Course<'_> {
    /// Puts aside whose motion means nothing after a substep that began at `time` \[s\]; the largest speed of the others
    /// \[m/s\], given that of all.
    ///
    /// # Errors
    /// [`PluginError::Physics`] where a body has too many of them, or where a speed is not a number.
    pub(crate) fn guard(&mut self, time: f64, speed: f64) -> Result<f64, PluginError> {
        if speed.is_nan() {
            return Err(lost(time, "a velocity is not a number; a shorter `max_substep_s` would help"));
        }
        let Self { model, store, books, .. } = self;
        let weak = model.params.pressure == Pressure::Weak;
        let mut culprit = None;
        if store.rho.iter().any(|rho| rho.is_nan()) {
            return Err(lost(time, "a density is not a number; a shorter `max_substep_s` would help"));
        }
        for (i, rho) in store.rho.iter_mut().enumerate().filter(|(_, rho)| **rho > 0.0) {
            let id = store.id[i] as usize;
            let liquid = &model.liquids[model.body[id] as usize];
            let (ratio, fast) = (*rho / liquid.rho, weak && norm(store.v[i]) > FASTEST * liquid.sound);
            if !fast && (DENSITIES[0]..=DENSITIES[1]).contains(&ratio) {
                continue;
            }
            store.dissipated += model.mass[id] * liquid.stored(*rho);
            *rho = -liquid.rho;
            books.aside += 1;
            culprit.get_or_insert(if fast {
                format!(
                    "a particle moves at {:.3e} m/s, faster than sound ({:.3e} m/s)",
                    norm(store.v[i]),
                    liquid.sound
                )
            } else {
                format!("the density of particle {id} is {ratio:.3e} times that at rest")
            });
        }
        let Some(culprit) = culprit else { return Ok(speed) };
        if !weak {
            return Err(lost(time, &culprit));
        }
        let mut aside = vec![0_usize; model.liquids.len()];
        for (&id, _) in store.id.iter().zip(&store.rho).filter(|(_, rho)| **rho < 0.0) {
            aside[model.body[id as usize] as usize] += 1;
        }
        for (liquid, aside) in model.liquids.iter().zip(aside) {
            let all = liquid.ids.len();
            if aside as f64 > MOST_ASIDE * all as f64 {
                let what = format!(
                    "{aside} of the {all} particles of `{}` are put aside, more than 1 %: {culprit}; a higher stiffness, a \
                     lower speed or a shorter `max_substep_s` would help",
                    liquid.name
                );
                return Err(lost(time, &what));
            }
        }
        Ok(self.store.fastest())
    }

    /// Stops those put aside at static solids.
    pub(crate) fn land(&mut self) {
        let Self { model, store, books, .. } = self;
        for i in (0..store.len()).filter(|&i| store.rho[i] < 0.0) {
            let mass = model.mass[store.id[i] as usize];
            for (_, solid) in &model.statics {
                let (distance, normal) = solid.distance(store.x[i]);
                if distance.is_nan() || distance >= 0.0 {
                    continue;
                }
                let before = (store.x[i], store.v[i]);
                let into = dot(before.1, normal).min(0.0);
                store.x[i] = add(before.0, scale(normal, -distance));
                store.v[i] = add(before.1, scale(normal, -into));
                store.dissipated += 0.5 * mass * into * into;
                let momentum = |(x, v)| Wrench { linear: scale(v, mass), angular: cross(x, scale(v, mass)) };
                books.external = books.external.plus(momentum((store.x[i], store.v[i])).minus(momentum(before)));
            }
        }
    }
}

impl crate::store::Store {
    /// Largest speed of those that are not put aside \[m/s\], or NaN.
    pub(crate) fn fastest(&self) -> f64 {
        self.v.iter().zip(&self.rho).filter(|(_, rho)| **rho > 0.0).map(|(&v, _)| norm(v)).fold(0.0, largest)
    }
}

fn lost(time: f64, what: &str) -> PluginError {
    PluginError::Physics(format!("the sph solver lost the motion at t = {time:.6e} s: {what}"))
}
