//! The constraints `ρ_i ≤ ρ_0` and their corrections (Macklin and Müller 2013, eqs. 8 to 12, without the artificial
//! pressure).

use cosplat_core::boundary::{Vec3, add, dot, norm, scale, sub};

use super::kernel::Kernel;
use super::near::{Pair, Pairs};
use super::touch::Walls;

/// Relaxation of a multiplier whose neighbours are few, as a part of the lattice's stiffness.
const SOFT: f64 = 0.01;
/// Part of a correction that is made, so that neighbours that correct the same error do not overshoot: half, as the
/// rows of the constraints' matrix on the lattice add up to twice its diagonal.
const PART: f64 = 0.5;

/// What one pass over the particles needs.
pub(crate) struct Pass<'a> {
    pub(crate) kernel: &'a Kernel,
    pub(crate) pairs: &'a Pairs,
    pub(crate) walls: &'a Walls,
    pub(crate) parallel: bool,
}

impl Pass<'_> {
    /// Densities over that at rest, of particles that end at `x` \[m\] and move on by `dt v`.
    pub(crate) fn densities(&self, x: &[Vec3], v: &[Vec3], dt: f64, out: &mut Vec<f64>) {
        out.resize(x.len(), 0.0);
        self.pairs.each(out, self.parallel, &|i, pairs| {
            let own = self.kernel.share(0.0) + self.walls.behind(self.kernel, i, v[i], dt).0;
            pairs.iter().fold(own, |sum, p| sum + self.kernel.share(apart(x, i, p)))
        });
    }

    /// Multipliers of the constraints \[m²\], none of them positive; `rest` is the density that each particle may have,
    /// over that at rest.
    pub(crate) fn multipliers(&self, x: &[Vec3], v: &[Vec3], rest: &[f64], dt: f64, out: &mut Vec<f64>) {
        out.resize(x.len(), 0.0);
        let soft = SOFT * self.kernel.stiffness;
        self.pairs.each(out, self.parallel, &|i, pairs| {
            let (share, mut own) = self.walls.behind(self.kernel, i, v[i], dt);
            let (mut density, mut others) = (self.kernel.share(0.0) + share, 0.0);
            for pair in pairs {
                let r = apart(x, i, pair);
                let slope = self.kernel.slope(r);
                density += self.kernel.share(r);
                own = add(own, scale(pair.away, slope));
                others += slope * slope;
            }
            -(density - rest[i]).max(0.0) / (dot(own, own) + others + soft)
        });
    }

    /// Changes of velocity by the multipliers \[m/s\], but for those by walls.
    pub(crate) fn corrections(&self, x: &[Vec3], multipliers: &[f64], dt: f64, out: &mut Vec<Vec3>) {
        out.resize(x.len(), [0.0; 3]);
        self.pairs.each(out, self.parallel, &|i, pairs| {
            let mut sum = [0.0; 3];
            for pair in pairs {
                let both = multipliers[i] + multipliers[pair.other as usize];
                if both < 0.0 {
                    sum = add(sum, scale(pair.away, both * self.kernel.slope(apart(x, i, pair))));
                }
            }
            scale(sum, PART / dt)
        });
    }

    /// Velocities after viscosity took a `share` of the differences along the lines between neighbours.
    pub(crate) fn rubbed(&self, x: &[Vec3], v: &[Vec3], share: f64, out: &mut Vec<Vec3>) {
        out.resize(x.len(), [0.0; 3]);
        self.pairs.each(out, self.parallel, &|i, pairs| {
            pairs.iter().fold(v[i], |sum, p| {
                let closing = dot(p.away, sub(v[p.other as usize], v[i]));
                add(sum, scale(p.away, share * self.kernel.share(apart(x, i, p)) * closing))
            })
        });
    }
}

/// Part of a correction that is made.
pub(crate) fn part() -> f64 {
    PART
}

/// Distance of a pair \[m\].
#[inline]
fn apart(x: &[Vec3], i: usize, pair: &Pair) -> f64 {
    norm(sub(x[i], x[pair.other as usize]))
}
