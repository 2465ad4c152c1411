//! Weakly compressible liquid: `p = K/7 (J⁻⁷ - 1)` for `J ≤ 1` and none beyond, `τ = -J p I + 2 η J dev(sym C)`.
//!
//! The volume ratio J is stored as the isotropic strain `B = (J^(2/3) - 1) I`. What a liquid is drawn apart is a gap, as in
//! sand: no tension holds it, and the gap closes before there is pressure again. The state equation is Tait's with the
//! exponent of Becker and Teschner, "Weakly compressible SPH for free surface flows" (2007); the viscosity η is Newton's.

use super::viscous::Viscosity;
use super::{Returned, Room};
use crate::math::{Full, Sym, all, exp_m1, full_det_minus_one, ln_1p};
use crate::real::{Lanes, Real};
use cosplat_core::scene::TAIT_EXPONENT;

/// Newtonian liquid.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Liquid<R: Real> {
    /// K \[Pa\].
    pub(super) bulk: f64,
    pub(super) viscosity: Viscosity<R>,
    /// K / 7.
    stiffness: R::V,
}

impl<R: Real> Liquid<R> {
    pub(super) fn new(bulk: f64, viscosity: f64) -> Self {
        Self { bulk, viscosity: Viscosity::new(viscosity), stiffness: all::<R>(bulk / TAIT_EXPONENT) }
    }

    /// `J = (1 + β)^(3/2)`.
    #[inline]
    fn volume(beta: R::V) -> R::V {
        let square = all::<R>(1.0) + beta;
        square * square.sqrt()
    }

    /// Kirchhoff stress \[Pa\] at a velocity gradient \[1/s\].
    #[inline]
    pub(super) fn stress(&self, b: &Sym<R>, c: &Full<R>) -> Sym<R> {
        let volume = Self::volume(b[0]);
        let pressure = R::V::default() - volume * self.stiffness * over_pressure::<R>(b[0]);
        if !self.viscosity.acts() {
            let zero = R::V::default();
            return [pressure, pressure, pressure, zero, zero, zero];
        }
        let [xx, yy, zz, xy, xz, yz] = self.viscosity.stress(volume, c);
        [pressure + xx, pressure + yy, pressure + zz, xy, xz, yz]
    }

    /// Power that viscosity takes per volume at rest \[W/m³\].
    pub(super) fn heat(&self, b: &Sym<R>, c: &Full<R>) -> R::V {
        self.viscosity.heat(Self::volume(b[0]), c)
    }

    /// `J ← J det(I + L)`, as the particles' places move.
    #[inline]
    pub(super) fn moved(l: &Full<R>, b: &Sym<R>) -> Sym<R> {
        let log = ln_1p::<R>(b[0]) + ln_1p::<R>(full_det_minus_one::<R>(l)) * all::<R>(2.0 / 3.0);
        let (beta, zero) = (exp_m1::<R>(log), R::V::default());
        [beta, beta, beta, zero, zero, zero]
    }

    /// Moves volume beyond that at rest into the gap, and back. No energy is lost; what the correction to the grid's density
    /// puts in is no more than the motion gives.
    pub(super) fn flow(&self, b: &Sym<R>, gap: R::V, room: &Room<R>) -> Option<Returned<R>> {
        let (beta, zero) = (b[0], R::V::default());
        if gap.array() == [R::default(); 4] && !room.may_correct(beta) {
            return None;
        }
        let moved = ln_1p::<R>(beta) * all::<R>(1.5) + gap;
        let wanted = room.correct(moved, gap);
        let by = (moved.min(zero) - wanted).max(zero);
        let pressed_by = |by: R::V, total: R::V| {
            let beta = exp_m1::<R>(total.min(zero) * all::<R>(2.0 / 3.0));
            (beta, by * Self::volume(beta) * self.stiffness * over_pressure::<R>(beta))
        };
        let (mut pressed, mut put) = pressed_by(by, wanted);
        let mut total = wanted;
        if R::V::if_less(room.gives, put, put, zero).array() != [R::default(); 4] {
            // The pressure rises with the way, so that a share of the way costs less than that share of the energy.
            let share = R::V::if_less(room.gives, put, room.gives / put.max(all::<R>(1e-30)), all::<R>(1.0));
            total = wanted + by * (all::<R>(1.0) - share);
            (pressed, put) = pressed_by(by * share, total);
        }
        Some(Returned { b: [pressed, pressed, pressed, zero, zero, zero], past: total.max(zero), lost: zero, put })
    }

    /// `∫ -p dJ = K/γ (J^(1-γ)/(γ-1) + J - γ/(γ-1))` \[J/m³\].
    pub(super) fn energy(&self, b: [f64; 6]) -> f64 {
        let volume = (1.0 + b[0]) * (1.0 + b[0]).sqrt();
        let g = TAIT_EXPONENT;
        self.bulk / g * (libm::pow(volume, 1.0 - g) / (g - 1.0) + volume - g / (g - 1.0))
    }

    /// `ρ0 dp/dρ = K J^(1-γ)` \[Pa\]: `J⁻⁶ = (1 + β)⁻⁹`.
    pub(super) fn wave(&self, b: &Sym<R>) -> R::V {
        let s = all::<R>(1.0) / (all::<R>(1.0) + b[0]);
        let cube = s * s * s;
        all::<R>(self.bulk) * (cube * cube * cube)
    }
}

/// `J⁻⁷ - 1 = (1 + β)^(-21/2) - 1`, by products of `1 + a` without their ones, so that small β lose no digit.
#[inline]
fn over_pressure<R: Real>(beta: R::V) -> R::V {
    let (one, two) = (all::<R>(1.0), all::<R>(2.0));
    let once = R::V::default() - beta / (one + beta);
    let half = once / (one + (one + once).sqrt());
    let square = |a: R::V| a * (two + a);
    let (second, eighth) = (square(once), square(square(square(once))));
    let tenth = second + eighth + second * eighth;
    tenth + half + tenth * half
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::law::Law;

    fn one(v: wide::f64x4) -> f64 {
        v.to_array()[0]
    }

    fn at(volume: f64) -> Sym<f64> {
        let beta = volume.powf(2.0 / 3.0) - 1.0;
        [beta, beta, beta, 0.0, 0.0, 0.0].map(all::<f64>)
    }

    #[test]
    fn pressure_is_that_of_tait() {
        for volume in [0.5, 0.9, 0.99, 1.0 - 1e-6] {
            let found = one(over_pressure::<f64>(at(volume)[0]));
            let wanted = volume.powi(-7) - 1.0;
            // Roundings of the two sides; the right one cancels near 1.
            assert!((found - wanted).abs() < 1e-14 * (1.0 + 10.0 * wanted), "{volume}: {found} instead of {wanted}");
        }
    }

    #[test]
    fn energy_is_the_work_of_the_pressure() {
        let law = Law::<f64>::liquid(2e5, 0.0);
        let still = [[all::<f64>(0.0); 3]; 3];
        for volume in [0.7, 0.95, 0.999] {
            let h = 1e-6;
            let energy = |v: f64| law.energy(at(v).map(one), 0.0);
            let pressure = -one(law.stress(&at(volume), all::<f64>(0.0), &still)[0]) / volume;
            let found = -(energy(volume + h) - energy(volume - h)) / (2.0 * h);
            // Second order in h over the distance from rest, and roundings of 1e-16 K over h.
            assert!((found / pressure - 1.0).abs() < 1e-6, "{volume}: {found} instead of {pressure}");
        }
    }

    #[test]
    fn shear_stress_is_viscosity_times_shear_rate() {
        let law = Law::<f64>::liquid(2e5, 3.0);
        let mut c = [[all::<f64>(0.0); 3]; 3];
        c[0][2] = all::<f64>(7.0);
        let tau = law.stress(&at(1.0), all::<f64>(0.0), &c).map(one);
        assert_eq!((tau[4], tau.iter().sum::<f64>()), (21.0, 21.0));
        assert_eq!(law.heat(&at(1.0), &c).map(one), Some(147.0));
    }

    #[test]
    fn volume_follows_the_motion_and_no_tension_holds_it() {
        let law = Law::<f64>::liquid(2e5, 0.0);
        let scale = |x: f64| [[x, 0.0, 0.0], [0.0, x, 0.0], [0.0, 0.0, x]].map(|r| r.map(all::<f64>));
        let (mut b, mut gap) = (at(0.98), all::<f64>(0.0));
        let rooms = Room { space: all::<f64>(1.1), ..Room::endless() };
        for l in [0.03, -1.0 + 1.0 / 1.03] {
            b = law.moved(&scale(l), &b);
            if let Some(new) = law.flow(&b, gap, &rooms) {
                (b, gap) = (new.b, new.past);
            }
            let open = 0.98 * 1.03_f64.powi(3);
            let wanted = if l > 0.0 { open.ln() } else { 0.0 };
            assert!((one(gap) - wanted).abs() < 1e-15, "{} instead of {wanted}", one(gap));
        }
        assert!((one(b[0]) - one(at(0.98)[0])).abs() < 1e-15);
        // With less room than the gap, the gap is what the room is.
        let new = law.flow(&at(1.5), all::<f64>(0.0), &Room { space: all::<f64>(1.2), ..rooms }).expect("open");
        assert!((one(new.past) - 1.2_f64.ln() - 0.1).abs() < 1e-15);
    }
}
