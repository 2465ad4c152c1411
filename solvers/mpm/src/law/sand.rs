//! Sand: Hencky elasticity inside the Drucker-Prager cone, without dilatancy, and gaps where grains have come apart.
//!
//! `|dev τ| ≤ r (p + c cot φ)` with the pressure `p = -K Σe` and the cohesion `c`; in strain `|dev e| ≤ s (t - Σe)`,
//! `s = r K / 2μ`, `t = c cot φ / K`. Flow changes the deviator alone, so the volume of what stays in contact is that of
//! the motion. Where `Σe` would pass `t` the grains part: no stress, and `gap = ln J` of the opening is the history of the
//! particle, to be closed before it bears load again; the cohesion holds anew from then on. Sources: Klár et al.,
//! "Drucker-Prager elastoplasticity for sand animation" (2016), with the volume correction of Tampubolon et al.,
//! "Multi-species simulation of porous sand and water mixtures" (2017), for which the elastic and the open part of
//! `ln J` add up to what the motion says.
//!
//! A lone particle keeps the velocity gradient that it left with, and its gap would grow for ever; so `ln J` follows what
//! the grid shows, see [`Room`].

use cosplat_core::scene::Lame;

use super::log::Log;
use super::solid::Moduli;
use super::{Cone, Returned, Room};
use crate::math::{Sym, all};
use crate::real::{Lanes, Real};

/// Drucker-Prager grains.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Sand<R: Real> {
    pub(super) solid: Moduli<R>,
    /// s.
    slope: R::V,
    /// t.
    tip: f64,
}

impl<R: Real> Sand<R> {
    pub(super) fn new(lame: Lame, friction_angle_deg: f64, cohesion: f64, cone: Cone) -> Self {
        let (solid, angle) = (Moduli::new(lame), friction_angle_deg.to_radians());
        let slope = cone.ratio(angle) * solid.bulk() / (2.0 * lame.mu_pa);
        Self { solid, slope: all::<R>(slope), tip: cohesion / (libm::tan(angle) * solid.bulk()) }
    }

    /// Returns the strain to the cone and the gap to what is open. The energy lost is `2 μ |dev e| Δγ` with the returned
    /// deviator, and what the cohesion held where it breaks; what the correction to the grid's density puts in is no more
    /// than the motion gives.
    pub(super) fn flow(&self, b: &Sym<R>, gap: R::V, room: &Room<R>) -> Option<Returned<R>> {
        let (log, zero, one) = (Log::<R>::of(b), R::V::default(), all::<R>(1.0));
        let (sum, norm) = (log.sum(), log.deviator());
        let moved = sum + gap;
        let wanted = room.correct(moved, gap);
        let by = R::V::if_less(wanted, zero, (moved - wanted).max(zero), zero);
        let cost = R::V::default() - by * wanted * all::<R>(self.solid.bulk());
        // The pressure rises with the way, so that a share of the way costs less than that share of the energy.
        let share = R::V::if_less(room.gives, cost, room.gives / cost.max(all::<R>(1e-30)), one);
        let total = wanted + by * (one - share);
        let apex = all::<R>(self.tip);
        let tip = R::V::if_less(zero, gap, zero, apex);
        let bears = self.slope * (apex - total).max(zero);
        let (open, slips) = (R::V::if_less(tip, total, one, zero), R::V::if_less(bears, norm, one, zero));
        let touched = open + slips + gap.abs() + (moved - total).abs();
        if touched.array() == [R::default(); 4] {
            return None;
        }
        let closed = one - open;
        let kept = closed * bears.min(norm);
        let new = log.returned(kept / norm.max(all::<R>(1e-30)), closed * total);
        let held = all::<R>(0.5 * self.solid.bulk() * self.tip * self.tip);
        let broken = open * R::V::if_less(zero, gap, zero, held);
        let work = closed * (moved - total) * total * all::<R>(self.solid.bulk());
        Some(Returned {
            // Untouched where nothing flows.
            b: [0, 1, 2, 3, 4, 5].map(|i| R::V::if_less(zero, touched, new[i], b[i])),
            past: open * total,
            lost: kept * (closed * norm - kept) * self.solid.mu * all::<R>(2.0) + broken + work.max(zero),
            put: (zero - work).max(zero),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::law::Law;
    use crate::math::congruence;

    const LAME: Lame = Lame::from_young_poisson(1e6, 0.2);

    fn one(v: wide::f64x4) -> f64 {
        v.to_array()[0]
    }

    /// Strains by `l` in small steps, with the flow of `law`, on a grid that shows what the motion says: strain and gap.
    fn driven(law: &Law<f64>, start: (Sym<f64>, f64), l: [[f64; 3]; 3], steps: usize) -> (Sym<f64>, f64) {
        let l = l.map(|r| r.map(|x| all::<f64>(x / steps as f64)));
        let (mut b, mut gap) = (start.0, all::<f64>(start.1));
        for _ in 0..steps {
            b = congruence::<f64>(&l, &b);
            let space = all::<f64>(libm::exp(one(Log::<f64>::of(&b).sum() + gap)));
            if let Some(new) = law.flow(&b, gap, &Room { space, ..Room::endless() }) {
                (b, gap) = (new.b, new.past);
            }
        }
        (b, one(gap))
    }

    fn stress(law: &Law<f64>, b: &Sym<f64>) -> [f64; 6] {
        law.stress(b, all::<f64>(0.0), &[[all::<f64>(0.0); 3]; 3]).map(one)
    }

    #[test]
    fn triaxial_compression_yields_where_mohr_and_coulomb_say() {
        // q/p = 6 sin φ / (3 - sin φ) is Mohr-Coulomb's σ1/σ3 = (1 + sin φ)/(1 - sin φ) in triaxial compression, where
        // q = σ1 - σ3 and p = (σ1 + 2 σ3)/3.
        for angle in [20.0_f64, 30.0, 45.0] {
            let law = Law::<f64>::sand(LAME, angle, 0.0, Cone::Compression);
            let pressed = driven(
                &law,
                ([all::<f64>(0.0); 6], 0.0),
                [[-0.01, 0.0, 0.0], [0.0, -0.01, 0.0], [0.0, 0.0, -0.01]],
                10,
            );
            // Half as much again along z, sides pushed out so that the volume stays.
            let (b, gap) = driven(&law, pressed, [[0.05, 0.0, 0.0], [0.0, 0.05, 0.0], [0.0, 0.0, -0.1]], 4000);
            let tau = stress(&law, &b);
            let (q, p) = (tau[0] - tau[2], -(tau[0] + tau[1] + tau[2]) / 3.0);
            let s = angle.to_radians().sin();
            println!("{angle}: q/p = {}, gap {gap}", q / p);
            // Algebra in f64.
            assert!((q / p / (6.0 * s / (3.0 - s)) - 1.0).abs() < 1e-9, "{}", q / p);
            assert!((tau[2] / tau[0] / ((1.0 + s) / (1.0 - s)) - 1.0).abs() < 1e-9);
        }
    }

    #[test]
    fn simple_shear_yields_at_the_slope_of_the_cone_of_shear() {
        let (angle, shear) = (30.0_f64, 0.2);
        let law = Law::<f64>::sand(LAME, angle, 500.0, Cone::Shear);
        let pressed =
            driven(&law, ([all::<f64>(0.0); 6], 0.0), [[-0.01, 0.0, 0.0], [0.0, -0.01, 0.0], [0.0, 0.0, -0.01]], 10);
        let (b, _) = driven(&law, pressed, [[0.0, 0.0, shear], [0.0; 3], [0.0; 3]], 20_000);
        let tau = stress(&law, &b);
        let p = -(tau[0] + tau[1] + tau[2]) / 3.0;
        let wanted = 500.0 + p * angle.to_radians().tan();
        println!("{} of {wanted}, normal {:?}", tau[4], &tau[..3]);
        // The stress lags behind the shear by the rotation over one elastic strain: second order in 0.01.
        assert!((tau[4] / wanted - 1.0).abs() < 3e-4, "{} of {wanted}", tau[4]);
    }

    #[test]
    fn a_cycle_of_opening_and_closing_gains_no_volume() {
        // Pressed, drawn out by 20 %, sheared while open, pushed back, unloaded: ln J of the motion is Σe + gap throughout,
        // and at the end of a closed cycle the pressure is that of the start.
        let law = Law::<f64>::sand(LAME, 30.0, 0.0, Cone::Compression);
        let iso = |x: f64| [[x, 0.0, 0.0], [0.0, x, 0.0], [0.0, 0.0, x]];
        let start = driven(&law, ([all::<f64>(0.0); 6], 0.0), iso(-1e-3), 10);
        let log_volume = |b: &Sym<f64>, gap: f64| one(Log::<f64>::of(b).sum()) + gap;
        let before = log_volume(&start.0, start.1);
        let mut now = start;
        for _ in 0..5 {
            now = driven(&law, now, iso(0.2), 100);
            assert!(stress(&law, &now.0).iter().all(|t| t.abs() < 1e-6), "no stress across a gap");
            let shear = [[0.0, 0.1, 0.0], [0.1, 0.0, 0.0], [0.0; 3]];
            now = driven(&law, now, shear, 100);
            now = driven(&law, now, shear.map(|r| r.map(|x| -x)), 100);
            // The inverse of the opening: 100 steps of 1/(1 + 0.002), and of the two shears, steps of (1 - s²)(1 - s²).
            let shrink = (1.0 / 1.002_f64) - 1.0;
            now = driven(&law, now, iso(100.0 * shrink), 100);
            let undo = (1.0 - 1e-3_f64.powi(2)).powf(-2.0 / 3.0) - 1.0;
            now = driven(&law, now, iso(100.0 * undo), 100);
        }
        let after = log_volume(&now.0, now.1);
        println!("ln J {before} before, {after} after, gap {}", now.1);
        // 2000 roundings of f64.
        assert!((after - before).abs() < 1e-12, "{after} instead of {before}");
        assert!(now.1 == 0.0 && one(Log::<f64>::of(&now.0).sum()) < 0.0, "it bears load again");
    }

    #[test]
    fn cohesion_breaks_at_its_tension_and_loses_what_it_held() {
        let (cohesion, angle) = (1e3, 35.0_f64);
        let law = Law::<f64>::sand(LAME, angle, cohesion, Cone::Compression);
        let limit = cohesion / angle.to_radians().tan();
        let mut b = [all::<f64>(0.0); 6];
        let (mut most, mut lost, step) = (0.0_f64, 0.0, 1e-7);
        let l = [[step, 0.0, 0.0], [0.0, step, 0.0], [0.0, 0.0, step]].map(|r| r.map(all::<f64>));
        let mut gap = all::<f64>(0.0);
        while one(gap) == 0.0 {
            b = congruence::<f64>(&l, &b);
            if let Some(new) = law.flow(&b, gap, &Room::endless()) {
                (b, gap, lost) = (new.b, new.past, lost + one(new.lost));
            }
            most = most.max(stress(&law, &b)[0]);
        }
        let bulk = LAME.lambda_pa + 2.0 / 3.0 * LAME.mu_pa;
        println!("broke at {most} Pa of {limit}, lost {lost} J/m³");
        // One step of strain below the limit: 3e-7 of a strain of 2.6e-3.
        assert!((most / limit - 1.0).abs() < 2e-4, "{most}");
        assert!((lost / (0.5 * limit * limit / bulk) - 1.0).abs() < 1e-9, "{lost}");
        assert!(stress(&law, &b).iter().all(|t| *t == 0.0));
    }
}
