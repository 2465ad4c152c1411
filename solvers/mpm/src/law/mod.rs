//! Stress, plastic flow, energy and stiffness of the materials, from the stored strain `B = b_e - I` and one number of
//! history.
//!
//! Kirchhoff stress τ, Lamé parameters λ and μ. Neo-Hookean: `τ = μ B + λ ln J I`. Hencky: `B = U diag(β) Uᵀ`,
//! `e = ln(1 + β) / 2`, `τ = U diag(2 μ e + λ Σe) Uᵀ`. The others stand in their own files.

mod liquid;
mod log;
mod sand;
mod snow;
mod solid;
#[cfg(test)]
mod tests;
mod viscous;
mod von_mises;

use cosplat_core::scene::Lame;

use crate::math::{Full, Sym, all, congruence, det_minus_one, eigen, from_eigen, ln_1p};
use crate::real::{Lanes, Real};
use liquid::Liquid;
use sand::Sand;
use snow::Snow;
use solid::Moduli;
use viscous::Viscosity;
use von_mises::VonMises;

/// Which norm of the stress is compared with the yield stress.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum YieldNorm {
    /// `|dev τ| ≤ √(2/3) Y`: yields at the yield stress Y in uniaxial tension.
    #[default]
    Physical,
    /// `|dev τ| ≤ Y`, as the first seed's simulator: yields at 1.2247 Y in uniaxial tension.
    Genesis,
}

impl YieldNorm {
    /// Largest `|dev e|` of an elastic state.
    fn limit(self, yield_stress: f64, mu: f64) -> f64 {
        let factor = match self {
            Self::Physical => (2.0_f64 / 3.0).sqrt(),
            Self::Genesis => 1.0,
        };
        factor * yield_stress / (2.0 * mu)
    }
}

/// In which test the round cone of Drucker and Prager yields at the friction angle φ of sand: it cannot in all.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum Cone {
    /// In triaxial compression, by which soil mechanics measures φ; a long slope of it stands up to
    /// `tan θ = (2/√3) 3 sin φ / (3 - sin φ)`, 34.7° for φ = 30°.
    #[default]
    Compression,
    /// In simple shear, `tan φ = shear stress over pressure`: a long slope stands up to φ.
    Shear,
}

impl Cone {
    /// `|dev τ| / p` at yield, without cohesion.
    fn ratio(self, angle: f64) -> f64 {
        match self {
            Self::Compression => (2.0_f64 / 3.0).sqrt() * 6.0 * libm::sin(angle) / (3.0 - libm::sin(angle)),
            Self::Shear => std::f64::consts::SQRT_2 * libm::tan(angle),
        }
    }
}

/// What plastic flow makes of four particles.
pub(crate) struct Returned<R: Real> {
    /// Strain.
    pub(crate) b: Sym<R>,
    /// History.
    pub(crate) past: R::V,
    /// Energy lost per volume at rest \[J/m³\].
    pub(crate) lost: R::V,
    /// Energy that the correction to the grid's density put in, to be taken from the motion, per volume at rest \[J/m³\].
    pub(crate) put: R::V,
}

/// Material of one body.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Law<R: Real> {
    /// Neo-Hookean, with or without viscosity.
    Elastic(Elastic<R>),
    /// Hencky with von Mises plasticity.
    VonMises(VonMises<R>),
    /// Grains.
    Sand(Sand<R>),
    /// Weakly compressible, Newtonian.
    Liquid(Liquid<R>),
    /// Snow.
    Snow(Snow<R>),
}

/// Neo-Hookean solid, with a viscosity beside it: Kelvin and Voigt.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Elastic<R: Real>(Moduli<R>, Viscosity<R>);

/// Bulk over shear modulus from which on a solid may lock: ν = 0.452.
const LOCKS: f64 = 10.0;

impl<R: Real> Law<R> {
    /// Neo-Hookean solid of a viscosity \[Pa s\].
    pub(crate) fn elastic(lame: Lame, viscosity: f64) -> Self {
        Self::Elastic(Elastic(Moduli::new(lame), Viscosity::new(viscosity)))
    }

    /// Hencky solid with von Mises plasticity.
    pub(crate) fn elastoplastic(lame: Lame, yield_stress: f64, norm: YieldNorm) -> Self {
        Self::VonMises(VonMises::new(lame, yield_stress, norm))
    }

    /// Hencky solid of a yield stress and hardening \[Pa\] that flows with a consistency \[Pa sⁿ\] and a flow index.
    pub(crate) fn viscoplastic(lame: Lame, yields: [f64; 2], fluid: (f64, f64), norm: YieldNorm) -> Self {
        Self::VonMises(VonMises::viscoplastic(lame, yields, fluid, norm))
    }

    /// Grains of a friction angle \[degrees\] and a cohesion \[Pa\].
    pub(crate) fn sand(lame: Lame, friction_angle_deg: f64, cohesion: f64, cone: Cone) -> Self {
        Self::Sand(Sand::new(lame, friction_angle_deg, cohesion, cone))
    }

    /// Liquid of a bulk modulus \[Pa\] and a viscosity \[Pa s\].
    pub(crate) fn liquid(bulk: f64, viscosity: f64) -> Self {
        Self::Liquid(Liquid::new(bulk, viscosity))
    }

    /// Snow with its critical compression, critical stretch and hardening.
    pub(crate) fn snow(lame: Lame, constants: [f64; 3]) -> Self {
        Self::Snow(Snow::new(lame, constants))
    }

    /// History of a particle at the start: equivalent plastic strain, gap, or plastic volume ratio.
    pub(crate) fn start(&self) -> f64 {
        if let Self::Snow(_) = self { 1.0 } else { 0.0 }
    }

    /// Whether it has no shape of its own to return to.
    pub(crate) fn flows(&self) -> bool {
        matches!(self, Self::Sand(_) | Self::Liquid(_))
    }

    /// Stiffness at rest against a change of volume, of what flows \[Pa\].
    pub(crate) fn stiffness(&self) -> f64 {
        match self {
            Self::Sand(sand) => sand.solid.lame.p_wave_modulus_pa(),
            Self::Liquid(liquid) => liquid.bulk,
            Self::Elastic(_) | Self::VonMises(_) | Self::Snow(_) => 0.0,
        }
    }

    /// `λ` \[Pa\] of a solid that would lock, whose volume ratio is averaged over cells (`fbar`).
    #[inline]
    pub(crate) fn f_bar(&self) -> Option<f64> {
        let (Self::Elastic(Elastic(solid, _)) | Self::VonMises(VonMises { solid, .. })) = self else { return None };
        (solid.f_bar && solid.bulk() > LOCKS * solid.lame.mu_pa).then_some(solid.lame.lambda_pa)
    }

    /// The same without averaged volume ratios.
    pub(crate) fn without_f_bar(mut self) -> Self {
        if let Self::Elastic(Elastic(solid, _)) | Self::VonMises(VonMises { solid, .. }) = &mut self {
            solid.f_bar = false;
        }
        self
    }

    /// Kirchhoff stress \[Pa\] of a strain, a history and a velocity gradient \[1/s\].
    #[inline]
    pub(crate) fn stress(&self, b: &Sym<R>, past: R::V, c: &Full<R>) -> Sym<R> {
        match self {
            Self::Elastic(elastic) => elastic.stress(b, c),
            Self::VonMises(metal) => metal.solid.hencky(b),
            Self::Sand(sand) => sand.solid.hencky(b),
            Self::Liquid(liquid) => liquid.stress(b, c),
            Self::Snow(snow) => snow.stress(b, past),
        }
    }

    /// Strain after a motion `I + L`, before any flow.
    #[inline]
    pub(crate) fn moved(&self, l: &Full<R>, b: &Sym<R>) -> Sym<R> {
        if let Self::Liquid(_) = self { Liquid::<R>::moved(l, b) } else { congruence::<R>(l, b) }
    }

    /// Plastic flow of a strain; `None` where none of the four can have flowed.
    #[inline]
    pub(crate) fn flow(&self, b: &Sym<R>, past: R::V, room: &Room<R>) -> Option<Returned<R>> {
        match self {
            Self::Elastic(_) => None,
            Self::VonMises(metal) => metal.flow(b, past, room.dt),
            Self::Sand(sand) => sand.flow(b, past, room),
            Self::Liquid(liquid) => liquid.flow(b, past, room),
            Self::Snow(snow) => snow.flow(b, past),
        }
    }

    /// Power that viscosity takes per volume at rest \[W/m³\], where there is any.
    pub(crate) fn heat(&self, b: &Sym<R>, c: &Full<R>) -> Option<R::V> {
        match self {
            Self::Liquid(liquid) if liquid.viscosity.acts() => Some(liquid.heat(b, c)),
            Self::Elastic(Elastic(_, viscosity)) if viscosity.acts() => Some(viscosity.heat(volume::<R>(b), c)),
            _ => None,
        }
    }

    /// Dynamic viscosity \[Pa s\].
    pub(crate) fn viscosity(&self) -> f64 {
        match self {
            Self::Liquid(liquid) => liquid.viscosity.eta,
            Self::Elastic(Elastic(_, viscosity)) => viscosity.eta,
            Self::VonMises(_) | Self::Sand(_) | Self::Snow(_) => 0.0,
        }
    }

    /// Energy per volume at rest \[J/m³\] of one particle.
    pub(crate) fn energy(&self, b: [f64; 6], past: f64) -> f64 {
        match self {
            Self::Elastic(elastic) => elastic.0.neo_hookean_energy(b),
            Self::VonMises(metal) => metal.solid.hencky_energy(b),
            Self::Sand(sand) => sand.solid.hencky_energy(b),
            Self::Liquid(liquid) => liquid.energy(b),
            Self::Snow(snow) => snow.energy(b, past),
        }
    }

    /// Stiffness that carries the fastest wave through the strained material \[Pa\].
    pub(crate) fn wave_modulus(&self, b: &Sym<R>, past: R::V) -> R::V {
        match self {
            Self::Elastic(elastic) => elastic.0.wave(b),
            Self::VonMises(metal) => metal.solid.wave(b),
            Self::Sand(sand) => sand.solid.wave(b),
            Self::Liquid(liquid) => liquid.wave(b),
            Self::Snow(snow) => snow.wave(b, past),
        }
    }

    /// Keeps stretches inside 0.05..=20. Returns the strain and how many of four particles needed it.
    pub(crate) fn clamp(b: &Sym<R>, volume: R::V) -> (Sym<R>, u64) {
        let (beta, u) = eigen::<R>(b);
        let (least, most) = (all::<R>(STRETCH[0] * STRETCH[0] - 1.0), all::<R>(STRETCH[1] * STRETCH[1] - 1.0));
        let clamped = beta.map(|x| x.max(least).min(most));
        let mut hit = [false; 4];
        for (a, b) in beta.iter().zip(&clamped) {
            for (lane, (a, b)) in a.array().iter().zip(b.array()).enumerate() {
                hit[lane] |= *a != b;
            }
        }
        let volumes = volume.array();
        let count = (0..4).filter(|&lane| hit[lane] && volumes[lane] > R::default()).count() as u64;
        let flag = R::V::from_array(hit.map(|h| R::of(f64::from(u8::from(h)))));
        let new = from_eigen::<R>(&clamped, &u);
        ([0, 1, 2, 3, 4, 5].map(|i| R::V::if_less(R::V::default(), flag, new[i], b[i])), count)
    }
}

impl<R: Real> Elastic<R> {
    #[inline]
    fn stress(&self, b: &Sym<R>, c: &Full<R>) -> Sym<R> {
        let elastic = self.0.neo_hookean(b);
        if !self.1.acts() {
            return elastic;
        }
        let viscous = self.1.stress(volume::<R>(b), c);
        [0, 1, 2, 3, 4, 5].map(|i| elastic[i] + viscous[i])
    }
}

/// `J = √det(I + B)`.
#[inline]
fn volume<R: Real>(b: &Sym<R>) -> R::V {
    (all::<R>(1.0) + det_minus_one::<R>(b)).max(R::V::default()).sqrt()
}

/// What the grid shows around four particles, and how long they flow.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Room<R: Real> {
    /// Volume that a particle has there, over its own at rest: density at rest over that of the grid.
    pub(crate) space: R::V,
    /// Way that sound makes in a substep, in cells.
    pub(crate) way: R::V,
    /// Length of the substep \[s\].
    pub(crate) dt: f64,
    /// Energy that the motion can give for a correction, per volume at rest \[J/m³\].
    pub(crate) gives: R::V,
}

/// Part by which what flows may be denser on the grid than its volume ratio says: twice the uncertainty of the grid's
/// density where particles lie in disorder, eight a cell. A smaller one would hear the noise, and press what it drives
/// apart. In water that has broken loose the density differs by 0.11 to 0.14 (root of the mean square), a quarter of the
/// particles is beyond this at any time, and pressing them apart costs 2 % of the energy of a dam each second; without it
/// the water would lose 20 % of its volume in 4 s.
const SLACK: f64 = 0.1;
/// Logarithm of the room that a particle at a plane surface has, whose kernel is half empty: what came apart closes when
/// the grid shows no more than that, however fast it came.
const SURFACE: f64 = 0.4;
/// Cells that sound crosses while a volume ratio goes the e-th part of the way to what the grid shows: slow, because each
/// step of it costs energy, which is taken from the motion: what nothing strains is not pressed.
const MEMORY: f64 = 100.0;

impl<R: Real> Room<R> {
    /// Nothing but what the motion says.
    #[cfg(test)]
    pub(crate) fn endless() -> Self {
        Self { space: all::<R>(1e9), way: R::V::default(), dt: 1.0, gives: all::<R>(1e30) }
    }

    /// Whether any volume ratio may have to follow: it opened, or the grid is denser than at rest.
    #[inline]
    fn may_correct(&self, total: R::V) -> bool {
        let (total, space) = (total.array(), self.space.array());
        (0..4).any(|i| total[i] > R::default() || space[i] < R::of(1.0))
    }

    /// `ln J` of the motion, of particles that had these gaps, brought back to what the grid shows: what is open at once,
    /// for a gap bears no load; what is pressed slowly.
    #[inline]
    fn correct(&self, total: R::V, gap: R::V) -> R::V {
        if gap.array() == [R::default(); 4] && !self.may_correct(total) {
            return total;
        }
        let (zero, one) = (R::V::default(), all::<R>(1.0));
        let grid = ln_1p::<R>((self.space - one).max(all::<R>(-0.999)));
        let (most, least) = (grid + all::<R>(SLACK), grid - all::<R>(SURFACE));
        let total = R::V::if_less(zero, gap, total.max(least), total);
        let share = (self.way * all::<R>(1.0 / MEMORY)).min(one);
        let pressed = total - share * (total - most).max(zero);
        R::V::if_less(zero, total, total.min(most.max(zero)), pressed)
    }
}

/// Smallest and largest stretch a particle may have.
pub(crate) const STRETCH: [f64; 2] = [0.05, 20.0];
