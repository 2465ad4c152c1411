//! Forces: the second of two passes over the pairs of particles in a substep, after that for densities (`compress`).
//!
//! Pressure `F_ij = -V_i V_j (p_i + p_j) ∇W` and continuity `ρ̇_i = ρ_i Σ V_j (v_i - v_j)·∇W` belong together: what the one
//! does as work the other stores (Colagrossi and Landrini 2003). Viscosity in Monaghan's form
//! `F_ij ~ μ V_i V_j (v_ij·x_ij)/(r² + η²) ∇W` (Monaghan, "Smoothed particle hydrodynamics", 2005, eq. 8.16 in three
//! dimensions; `drag` says why η is large) acts along the line between two particles, so that angular momentum is kept. Densities diffuse,
//! `δ h c Σ 2 (ρ_j - ρ_i - ρ_ij^H)(x_ji·∇W)/r² V_j` (Molteni and Colagrossi 2009), less what hydrostatics makes of their
//! difference (Fourtakas et al. 2019, to first order in the compression).
#![expect(clippy::inline_always, reason = "as said in `lanes`")]

use cosplat_core::boundary::{Vec3, Wrench, add, cross, dot, scale};
use fearless_simd::{Level, Simd, dispatch, f64x4, prelude::*};

use crate::felt::{Feels, Felt};
use crate::gates::is_here;
use crate::kernel::Kernel;
use crate::lanes::{LANES, Pack};
use crate::model::{Liquid, Model};
use crate::near::{CHUNK, Lists, for_chunks};
use crate::store::Store;
use crate::wall::Walls;

/// Sums over a chunk in one substep.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Sums {
    /// Power of viscosity, as a loss \[W\].
    pub(crate) lost: f64,
    /// Power of the pressures of an incompressible liquid, at the mean velocities of the substep \[W\].
    pub(crate) pressed: f64,
    /// Largest square of an acceleration and of a speed; NaN where one is not a number.
    pub(crate) acceleration: f64,
    pub(crate) speed: f64,
    /// Gravity's and static walls' force and moment about the origin \[N, N m\].
    pub(crate) weight: Wrench,
    pub(crate) walls: Wrench,
    /// Power of what drives particles against pressures \[W\].
    pub(crate) driven: f64,
}

/// The larger one, or NaN.
pub(crate) fn largest(a: f64, b: f64) -> f64 {
    if a.is_nan() || a > b { a } else { b }
}

/// Everything that the passes read beside the particles' packs.
pub(crate) struct Pass<'a> {
    pub(crate) model: &'a Model,
    pub(crate) lists: &'a Lists,
    /// Gravity of each body \[m/s²\].
    pub(crate) gravity: &'a [Vec3],
    pub(crate) dt: f64,
    pub(crate) parallel: bool,
}

/// Softening of viscous pairs over h², and the factor with which the mean over all directions of a continuum has the
/// viscosity `μ`: `10` without softening.
const SOFT: f64 = 5.5 / 1.44;
const SHEAR: f64 = 40.73;

/// Viscous part of the factor of four pairs, `40.73 μ (v·x)/(r² + 3.82 h²)` \[Pa\].
///
/// With Monaghan's `10 μ (v·x)/(r² + 0.01 h²)` a cubic lattice, in which each liquid starts, has 0.84 of the viscosity against
/// shear along its rows, 0.95 to 0.84 as they slide, and 1.22 of it across: the nearest neighbours count too much. With this
/// softening it is 0.987 to 1.003 of it in all of them, by sums over the lattice.
#[inline(always)]
pub(crate) fn drag<S: Simd>(kernel: &Kernel, viscosity: f64x4<S>, approach: f64x4<S>, square: f64x4<S>) -> f64x4<S> {
    SHEAR * viscosity * approach / (square + SOFT * kernel.h * kernel.h)
}

/// Volume \[m³\]: who is put aside acts on nobody.
pub(crate) fn volume(mass: f64, rho: f64) -> f64 {
    if rho > 0.0 { mass / rho } else { 0.0 }
}

impl Pass<'_> {
    /// Packs the particles with their pressures.
    pub(crate) fn pack(&self, store: &Store, pack: &mut [Pack]) {
        self.fill(store, pack, |mass, _, rho| volume(mass, rho), Liquid::pressure);
    }

    /// Packs the particles with their volumes at rest, without pressure.
    pub(crate) fn rest(&self, store: &Store, pack: &mut [Pack]) {
        self.fill(store, pack, |mass, liquid, _| mass / liquid.rho, |_, _| 0.0);
    }

    /// Packs the particles without pressure.
    pub(crate) fn unpressed(&self, store: &Store, pack: &mut [Pack]) {
        self.fill(store, pack, |mass, _, rho| volume(mass, rho), |_, _| 0.0);
    }

    fn fill(
        &self,
        store: &Store,
        pack: &mut [Pack],
        volume: impl Fn(f64, &Liquid, f64) -> f64 + Sync,
        shown: impl Fn(&Liquid, f64) -> f64 + Sync,
    ) {
        let mut nothing = vec![(); store.len().div_ceil(CHUNK)];
        for_chunks(self.parallel, pack, &mut nothing, &|c, pack, ()| {
            for (k, pack) in pack.iter_mut().enumerate() {
                let i = c * CHUNK + k;
                let id = store.id[i] as usize;
                let liquid = &self.model.liquids[self.model.body[id] as usize];
                let rho = store.rho[i];
                let volume = volume(self.model.mass[id], liquid, rho);
                *pack = Pack { x: store.x[i], volume, v: store.v[i], pressure: shown(liquid, rho) };
            }
        });
    }

    /// Accelerations \[m/s²\], of particles that feel so much of each other.
    pub(crate) fn accelerate(
        &self,
        store: &Store,
        pack: &[Pack],
        walls: &Walls,
        felt: &impl Feels,
        (acceleration, sums): (&mut [Vec3], &mut [Sums]),
    ) {
        for_chunks(self.parallel, acceleration, sums, &|c, acceleration, sums| {
            *sums = Sums::default();
            let out = (c * CHUNK, acceleration, sums);
            dispatch!(Level::new(), simd => self.accelerate_some(simd, store, pack, walls, felt, out));
        });
    }

    /// Those of the particles from `first` on.
    #[inline(always)]
    fn accelerate_some<S: Simd>(
        &self,
        simd: S,
        store: &Store,
        pack: &[Pack],
        walls: &Walls,
        felt: &impl Feels,
        (first, acceleration, sums): (usize, &mut [Vec3], &mut Sums),
    ) {
        let model = self.model;
        for (k, acceleration) in acceleration.iter_mut().enumerate() {
            let i = first + k;
            let id = store.id[i] as usize;
            let (body, own, mass) = (model.body[id] as usize, &pack[i], model.mass[id]);
            let Felt { mut force, mut rubbed, mut lost } = felt.felt(simd, i);
            let touched = walls.near(i);
            if !touched.is_empty() {
                let by = walls.press(simd, model, own, touched);
                lost += by.lost;
                rubbed = add(rubbed, by.rubbed);
                sums.walls = sums.walls.plus(Wrench { linear: by.statics, angular: cross(own.x, by.statics) });
                force = add(force, add(by.statics, by.partners));
            }
            let g = if is_here(store.rho[i]) { self.gravity[body] } else { [0.0; 3] };
            *acceleration = add(scale(force, 1.0 / mass), g);
            // Work is force times the mean velocity over the substep: where pressure shakes particles, what viscosity takes
            // by their velocities at its start is up to twice as much.
            sums.lost += lost - 0.5 * self.dt * dot(rubbed, *acceleration);
            sums.acceleration = largest(dot(*acceleration, *acceleration), sums.acceleration);
            let weight = scale(g, mass);
            sums.weight = sums.weight.plus(Wrench { linear: weight, angular: cross(own.x, weight) });
        }
    }

    /// Viscosities of four pairs: the harmonic mean, which keeps the shear stress continuous (Cleary and Monaghan 1999).
    #[inline(always)]
    pub(crate) fn viscosities<S: Simd>(&self, simd: S, store: &Store, body: usize, j: &[u32; LANES]) -> f64x4<S> {
        self.mean(simd, store, body, j, |l| l.viscosity)
    }

    /// Implicit viscosities of four pairs, likewise.
    #[inline(always)]
    pub(crate) fn thickness<S: Simd>(&self, simd: S, store: &Store, body: usize, j: &[u32; LANES]) -> f64x4<S> {
        self.mean(simd, store, body, j, |l| l.thickness)
    }

    #[inline(always)]
    fn mean<S: Simd>(
        &self,
        simd: S,
        store: &Store,
        body: usize,
        j: &[u32; LANES],
        of: impl Fn(&Liquid) -> f64,
    ) -> f64x4<S> {
        let (liquids, own) = (&self.model.liquids, of(&self.model.liquids[body]));
        if liquids.len() == 1 {
            return f64x4::splat(simd, own);
        }
        let mean = |k: usize| {
            let Some(&id) = store.id.get(j[k] as usize) else { return own };
            let other = of(&liquids[self.model.body[id as usize] as usize]);
            2.0 * own * other / (own + other).max(f64::MIN_POSITIVE)
        };
        f64x4::load_array(simd, [mean(0), mean(1), mean(2), mean(3)])
    }

    /// Factors of the pull of four pairs: nothing between different liquids, and none of nobody.
    #[inline(always)]
    pub(crate) fn cohesions<S: Simd>(&self, simd: S, store: &Store, body: usize, j: &[u32; LANES]) -> f64x4<S> {
        let of = |k: usize| {
            let j = j[k] as usize;
            let same = store.id.get(j).is_some_and(|&id| self.model.body[id as usize] as usize == body);
            if same && store.rho[j] > 0.0 { self.model.liquids[body].cohesion } else { 0.0 }
        };
        f64x4::load_array(simd, [of(0), of(1), of(2), of(3)])
    }

    /// Velocities after the impulses, in the store and the packs.
    pub(crate) fn kick(&self, acceleration: &[Vec3], store: &mut Store, pack: &mut [Pack], sums: &mut [Sums]) {
        let Store { v, rho, .. } = store;
        for_chunks(self.parallel, v, sums, &|c, v, sums| {
            for (k, v) in v.iter_mut().enumerate() {
                *v = add(*v, scale(acceleration[c * CHUNK + k], self.dt));
                if rho[c * CHUNK + k] > 0.0 {
                    sums.speed = largest(dot(*v, *v), sums.speed);
                }
            }
        });
        let mut nothing = vec![(); sums.len()];
        for_chunks(self.parallel, &mut pack[..store.v.len()], &mut nothing, &|c, pack, ()| {
            for (pack, v) in pack.iter_mut().zip(&store.v[c * CHUNK..]) {
                pack.v = *v;
            }
        });
    }
}
