//! Surface tension: pairs of particles of a liquid pull each other, `F = A V² q (1 - q)²` over the kernel's support H, with
//! `q = r/H` and the mean volume V of its particles at rest (of the family of Akinci, Akinci and Teschner, "Versatile surface tension and adhesion for SPH fluids", 2013,
//! without their normals, whose force is not along the line between two and turns what it should not).
//!
//! What that is in N/m follows from the work of parting a liquid along a plane (Fowler 1937; Tartakovsky and Panchenko,
//! "Pairwise force smoothed particle hydrodynamics model for multiphase flow", 2016, eq. 12): `σ = π/8 ∫ F(r) r⁴ dr` with
//! volumes, so `A = 1344 σ/(π H⁵)`. Inside the liquid it presses with `2π/3 ∫ F(r) r³ dr = 1.6 · 16/3 σ/H`, against which the
//! pressure stands: pressures are larger by that much, and particles so pressed lock where tension's own differences of
//! pressure are small: a drop eight particles over its radius keeps half of what it is drawn out. Walls neither pull nor push: they are not wetted.

use std::f64::consts::PI;

use cosplat_core::boundary::{norm, sub};
use cosplat_core::plugin::SolverScene;
use cosplat_core::scene::ActionKind;
use fearless_simd::{Simd, f64x4};

use crate::grid::Grid;
use crate::kernel::Kernel;
use crate::model::Model;
use crate::store::Store;

/// Bond number of a particle above which surface tension is left out.
pub(crate) const WEAK: f64 = 10.0;

/// Bond number `ρ g d²/σ` of a particle: whether even a single one is too heavy for a surface tension \[N/m\].
pub(crate) fn bond(scene: &SolverScene, rho: f64, tension: f64, spacing: f64) -> f64 {
    let g = scene.actions.iter().filter_map(|a| match a.kind {
        ActionKind::Gravity { acceleration_m_s2 } => Some(norm(acceleration_m_s2)),
        _ => None,
    });
    if tension > 0.0 { rho * g.fold(0.0, f64::max) * spacing * spacing / tension } else { f64::INFINITY }
}

/// Factor `A V²` \[N\] of a surface tension \[N/m\] and the mean volume of particles \[m³\].
pub(crate) fn factor(tension: f64, volume: f64, kernel: &Kernel) -> f64 {
    1344.0 * tension * volume * volume / (PI * kernel.reach.powi(5))
}

/// Pressure inside \[Pa\] by a surface tension \[N/m\].
pub(crate) fn inside(tension: f64, kernel: &Kernel) -> f64 {
    1.6 * 16.0 / 3.0 * tension / kernel.reach
}

/// `q (1 - q)²/r` of four with `t = 1 - q` \[1/m\].
#[inline(always)]
#[expect(clippy::inline_always, reason = "as said in `lanes`")]
pub(crate) fn pull<S: Simd>(kernel: &Kernel, t: f64x4<S>) -> f64x4<S> {
    // q/r is one over the support.
    kernel.half_inverse * t * t
}

/// Energy of all pairs \[J\], against all far apart: not positive.
pub(crate) fn energy(model: &Model, store: &Store) -> f64 {
    if model.liquids.iter().all(|l| l.cohesion <= 0.0) {
        return 0.0;
    }
    let reach = model.kernel.reach;
    let part: Vec<usize> = (0..store.len()).filter(|&i| store.rho[i] > 0.0).collect();
    let x: Vec<_> = part.iter().map(|&i| store.x[i]).collect();
    let (grid, order) = Grid::new(&x, reach);
    let sorted: Vec<_> = order.iter().map(|&k| x[k as usize]).collect();
    let of = |k: usize| model.body[store.id[part[order[k] as usize]] as usize];
    let mut sum = 0.0;
    for (k, &x) in sorted.iter().enumerate() {
        let factor = model.liquids[of(k) as usize].cohesion * reach;
        grid.near(&sorted, x, reach, |other| {
            if other < k && of(other) == of(k) {
                // -∫ q (1 - q)² dq from q to 1.
                let t = 1.0 - norm(sub(x, sorted[other])) * model.kernel.half_inverse;
                sum -= factor * t * t * t * (1.0 / 3.0 - 0.25 * t);
            }
        });
    }
    sum
}
