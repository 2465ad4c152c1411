//! The largest stable substep, and which term binds it.
//!
//! `1/dt = max c / (κ dx) + max |v| / (0.3 dx)`: advection adds to the wave speed; `κ` = 0.5 by default (the measured
//! limit is 0.74 to 1.09). Beside it `dt ≤ 0.25 / max |C|`, half of what the guard tolerates, and for viscosity
//! `dt ≤ ρ dx² / 12 η`, half of what an explicit seven-point Laplacian tolerates.

use rayon::prelude::*;

use crate::law::Law;
use crate::math::all;
use crate::quarantine::strained;
use crate::real::{Lanes, Real};
use crate::store::{Block, M, PAST, Store, V, VOL};
use crate::transfer::{gradient, strain};

/// Part of a cell that a particle may cross in one substep.
const WAY: f64 = 0.3;
/// Part by which a cell may stretch in one substep.
const STRETCH_RATE: f64 = 0.25;

/// The term that binds a substep.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum Bound {
    /// Elastic wave in that body.
    Wave(u32),
    /// Particles of that body cross cells.
    Speed(u32),
    /// Strain rate of that body.
    Rate(u32),
    /// Momentum that viscosity spreads in that body.
    Viscosity(u32),
    /// The user's maximum.
    User,
    /// The coupling window.
    #[default]
    Window,
}

impl Bound {
    /// In words.
    pub(crate) fn words(self, names: &[String], limits: &Limits) -> String {
        let name = |body: u32| names.get(body as usize).map_or("?", String::as_str);
        match self {
            Self::Wave(b) => format!("elastic wave in `{}` (Courant number {})", name(b), limits.courant),
            Self::Speed(b) => format!("particle speed of `{}` (0.3 cells a substep)", name(b)),
            Self::Rate(b) => format!("strain rate of `{}`", name(b)),
            Self::Viscosity(b) => format!("viscosity of `{}` (density × dx² / 12 viscosity)", name(b)),
            Self::User => "maximum given by the user".into(),
            Self::Window => "coupling window".into(),
        }
    }
}

/// A substep, what binds it, and what was seen on the way.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Stable {
    /// Length \[s\].
    pub(crate) dt: f64,
    /// What binds it.
    pub(crate) bound: Bound,
    /// Whether the strain of any particle left the range of `quarantine`.
    pub(crate) strained: bool,
}

/// Limits that do not depend on the state.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Limits {
    /// Courant number κ of the elastic wave.
    pub(crate) courant: f64,
    /// User's maximum \[s\].
    pub(crate) most: f64,
}

/// Largest wave speed, speed and rate, squared, 1 where a strain left its range, and kinematic viscosity \[m²/s\], with
/// the body of each.
type Peaks = [(f64, u32); 5];

impl Limits {
    /// Largest stable substep no longer than `longest` \[s\].
    pub(crate) fn substep<R: Real>(
        &self,
        store: &Store<R>,
        laws: &[Law<R>],
        dx: f64,
        longest: f64,
        parallel: bool,
    ) -> Stable {
        let one = |block: &Block| peaks(store, block, &laws[block.part as usize]);
        let most = |mut a: Peaks, b: Peaks| {
            for (a, b) in a.iter_mut().zip(b) {
                // On a tie the lower body, so that the order of the blocks does not matter.
                if b.0 > a.0 || (b.0 >= a.0 && b.1 < a.1) {
                    *a = b;
                }
            }
            a
        };
        let none = [(0.0, u32::MAX); 5];
        let [wave, speed, rate, strained, spread] = if parallel {
            store.blocks.par_iter().map(one).reduce(|| none, most)
        } else {
            store.blocks.iter().map(one).fold(none, most)
        };
        let (per_wave, per_way) = (wave.0.sqrt() / (self.courant * dx), speed.0.sqrt() / (WAY * dx));
        let moving = 1.0 / (per_wave + per_way);
        let choices = [
            (moving, if per_wave >= per_way { Bound::Wave(wave.1) } else { Bound::Speed(speed.1) }),
            (STRETCH_RATE / rate.0.sqrt(), Bound::Rate(rate.1)),
            (dx * dx / (12.0 * spread.0), Bound::Viscosity(spread.1)),
            (self.most, Bound::User),
            (longest, Bound::Window),
        ];
        let (dt, bound) =
            choices.into_iter().fold((f64::INFINITY, Bound::Window), |a, b| if b.0 < a.0 { b } else { a });
        Stable { dt, bound, strained: strained.0 > 0.0 }
    }
}

fn peaks<R: Real>(store: &Store<R>, block: &Block, law: &Law<R>) -> Peaks {
    let (zero, one) = (R::V::default(), all::<R>(1.0));
    let (mut wave, mut speed, mut rate, mut out, mut light) = (zero, zero, zero, zero, zero);
    for quad in &store.quads[block.range()] {
        // A dead lane has no mass: give it one, its volume is 0.
        let mass = R::V::if_less(zero, quad[M], quad[M], one);
        let b = strain::<R>(quad);
        light = light.max(quad[VOL] / mass);
        wave = wave.max(law.wave_modulus(&b, quad[PAST]) * quad[VOL] / mass);
        out = out.max(strained::<R>(&b));
        speed = speed.max(quad[V] * quad[V] + quad[V + 1] * quad[V + 1] + quad[V + 2] * quad[V + 2]);
        rate = rate.max(gradient::<R>(quad).iter().flatten().fold(zero, |s, c| s + *c * *c));
    }
    let most = |v: R::V| (v.array().iter().fold(0.0, |a: f64, b| a.max(b.f64())), block.body);
    let spread = most(light).0 * law.viscosity();
    [most(wave), most(speed), most(rate), most(out), (spread, block.body)]
}
