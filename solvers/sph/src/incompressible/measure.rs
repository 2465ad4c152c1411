//! What depends on the places alone, particle by particle, and what particles feel without pressure: both need the distances.
#![expect(clippy::inline_always, reason = "as said in `lanes`")]

use cosplat_core::boundary::{Vec3, add, dot};
use fearless_simd::{Simd, f64x4, prelude::*};

use crate::felt::{Felt, Rubs};
use crate::force::Pass;
use crate::kernel::Kernel;
use crate::lanes::{Four, Pack, accumulate, gather, groups, total, zero, zeros};
use crate::near::CHUNK;
use crate::pairs::Pairs;
use crate::store::Store;
use crate::wall::Walls;

/// Range of `M`: half of a kernel beyond a surface is missing, but what is there does not swell to fill it.
const MOMENTS: [f64; 2] = [0.8, 1.2];

/// What a particle keeps over a substep.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Row {
    /// Gradient of the filled share \[1/m\].
    pub(crate) pull: Vec3,
    /// Filled share: all of it, and what the liquid and boundary particles fill.
    pub(crate) filled: f64,
    pub(crate) by_liquid: f64,
    pub(crate) by_walls: f64,
    /// Rate of the filled share's rate by the own pressure \[1/(Pa s²)\], and the same with what rigid partners answer to all
    /// that press them at once.
    pub(crate) diagonal: f64,
    /// Volume over mass \[m³/kg\].
    pub(crate) light: f64,
    /// One over `M`.
    pub(crate) swell: f64,
}

/// Pairs of a chunk, with the liquid and with boundary particles, and what its particles feel without pressure.
#[derive(Clone, Debug, Default)]
pub(crate) struct Stored {
    pub(crate) liquid: Pairs,
    pub(crate) walls: Pairs,
    pub(crate) felt: Vec<Felt>,
}

/// Sums over pairs with the liquid or with boundary particles.
#[derive(Clone, Copy, Debug, Default)]
struct Around {
    pull: Vec3,
    filled: f64,
    moment: f64,
    /// `Σ V²/m |∇W|²`.
    square: f64,
}

/// Sums over the pairs of `own` with a list, which are kept; `light` is what moves of a neighbour \[m³/kg\].
#[inline(always)]
fn around<S: Simd>(
    simd: S,
    kernel: &Kernel,
    (own, packs, list): (&Pack, &[Pack], &[u32]),
    light: impl Fn(u32) -> f64,
    kept: &mut Pairs,
    mut rubs: Option<&mut Rubs<'_, S>>,
) -> Around {
    let (mut pull, mut filled) = (zeros(simd), zero(simd));
    let (mut moment, mut square) = (zero(simd), zero(simd));
    for j in groups(list) {
        let others = Four::new(simd, own, packs, j);
        let t = kernel.inside(others.r);
        let (slope, weight) = (kernel.slopes_at(t), kernel.weights_at(t));
        let all = others.volume * slope;
        filled += others.volume * weight;
        accumulate(&mut pull, &others.apart, all);
        let length = all * others.square;
        moment -= length;
        if let Some(rubs) = &mut rubs {
            rubs.add(kernel, &others, j, (t, all));
        }
        let lights = f64x4::load_array(simd, [light(j[0]), light(j[1]), light(j[2]), light(j[3])]);
        square += lights * length * slope;
        kept.push(j, t);
    }
    kept.end(packs.len() - 1);
    Around { pull: gather(pull), filled: total(filled), moment: total(moment), square: total(square) }
}

/// Measures a particle.
#[inline(always)]
pub(crate) fn measured<S: Simd>(
    simd: S,
    pass: &Pass<'_>,
    light: &[f64],
    (store, pack, walls): (&Store, &[Pack], &Walls),
    (i, stored): (usize, &mut Stored),
) -> Row {
    let (plain, kernel, own) = (pass.model.kernel, pass.model.kernel.scaled(), &pack[i]);
    let light = |i: u32| light[i as usize];
    let mut rubs = Rubs::new(simd, pass, store, own, i);
    let list = (own, pack, pass.lists.chunks()[i / CHUNK].row(i % CHUNK));
    let liquid = around(simd, &kernel, list, light, &mut stored.liquid, Some(&mut rubs));
    let list = (own, walls.packs(), walls.near(i));
    let solid = around(simd, &kernel, list, |_| 0.0, &mut stored.walls, None);
    // Forces of viscosity have the kernel as it is.
    stored.felt.push(rubs.felt([0.0; 3], own.volume * plain.slope / kernel.slope));
    let pull = add(liquid.pull, solid.pull);
    // The pressure of a boundary particle follows: about as if its gradient counted twice.
    let twice = add(pull, solid.pull);
    let by_liquid = liquid.filled + own.volume * kernel.weight(0.0);
    let moment = (liquid.moment + solid.moment) / 3.0;
    let swell = 1.0 / moment.clamp(MOMENTS[0], MOMENTS[1]);
    let light = light(i as u32);
    let square = light * dot(pull, pull).max(dot(twice, twice)) + own.volume * liquid.square;
    Row {
        pull,
        filled: by_liquid + solid.filled,
        by_liquid,
        by_walls: solid.filled,
        diagonal: square * swell * swell,
        light,
        swell,
    }
}
