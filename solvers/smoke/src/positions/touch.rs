//! Solids with a shape: static ones, closed sides of the domain and rigid partners.

use cosplat_core::boundary::{Vec3, Wrench, add, cross, dot, scale};
use cosplat_core::distance::{Placed, SignedDistance};
use rayon::prelude::*;

use super::density::part;
use super::kernel::Kernel;
use super::near::CHUNK;
use crate::proxy::Proxy;
use crate::solids::Crossed;

/// A solid over one window, in which none moves.
#[derive(Clone, Debug)]
pub(crate) enum Solid {
    /// A static collider.
    Fixed(Placed),
    /// A closed side: axis, place \[m\], and where its inside is, 1 above and -1 below.
    Side(usize, f64, f64),
    /// A rigid partner and the row of its interface.
    Rigid(Placed, Box<Proxy>, usize),
}

impl Solid {
    /// Distance \[m\] and outward normal where it is nearer than `reach` \[m\].
    fn near(&self, x: Vec3, reach: f64) -> Option<(f64, Vec3)> {
        let (distance, normal) = match self {
            Self::Side(axis, at, inside) => {
                let mut normal = [0.0; 3];
                normal[*axis] = *inside;
                (inside * (x[*axis] - at), normal)
            }
            Self::Fixed(placed) | Self::Rigid(placed, ..) if placed.at_least(x, reach) > 0.0 => return None,
            Self::Fixed(placed) | Self::Rigid(placed, ..) => placed.distance(x),
        };
        (distance < reach).then_some((distance, normal))
    }

    /// Velocity of its point at `x` \[m/s\].
    fn velocity(&self, x: Vec3) -> Vec3 {
        if let Self::Rigid(_, proxy, _) = self { proxy.at(x) } else { [0.0; 3] }
    }
}

/// A particle near a solid.
#[derive(Clone, Copy, Debug)]
struct Touch {
    particle: u32,
    solid: u32,
    /// Outward normal, distance \[m\] and speed along the normal of the solid's point \[m/s\].
    normal: Vec3,
    distance: f64,
    speed: f64,
    /// Part of its share that is not behind other solids too.
    alone: f64,
}

/// All solids, and who is near them at the start of a substep.
#[derive(Clone, Debug, Default)]
pub(crate) struct Walls {
    pub(crate) solids: Vec<Solid>,
    touches: Vec<Touch>,
    /// First touch of each particle, and the end.
    first: Vec<u32>,
}

/// What walls gave: what is outside the coupled system, and interfaces by row.
pub(crate) struct Given<'a> {
    pub(crate) external: &'a mut Wrench,
    pub(crate) crossed: &'a mut [Crossed],
}

impl Walls {
    /// Nobody is near yet.
    pub(crate) fn new(solids: Vec<Solid>) -> Self {
        Self { solids, ..Self::default() }
    }

    /// Finds who is near.
    pub(crate) fn find(&mut self, kernel: &Kernel, x: &[Vec3], parallel: bool) {
        let (solids, reach) = (&self.solids, kernel.reach);
        let chunk = |(c, part): (usize, &[Vec3])| {
            let mut found = Vec::new();
            for (i, &x) in part.iter().enumerate() {
                for (s, solid) in solids.iter().enumerate() {
                    if let Some((distance, normal)) = solid.near(x, reach) {
                        let speed = dot(normal, solid.velocity(x));
                        let particle = (c * CHUNK + i) as u32;
                        found.push(Touch { particle, solid: s as u32, normal, distance, speed, alone: 1.0 });
                    }
                }
            }
            found
        };
        let found: Vec<_> = if parallel {
            x.par_chunks(CHUNK).enumerate().map(chunk).collect()
        } else {
            x.chunks(CHUNK).enumerate().map(chunk).collect()
        };
        self.touches = found.concat();
        self.first.clear();
        self.first.resize(x.len() + 1, 0);
        self.touches.iter().for_each(|t| self.first[t.particle as usize + 1] += 1);
        for i in 0..x.len() {
            self.first[i + 1] += self.first[i];
            let own = self.first[i] as usize..self.first[i + 1] as usize;
            for t in own.clone().filter(|_| own.len() > 1) {
                let others = own.clone().filter(|&o| o != t).map(|o| 1.0 - kernel.covered(self.touches[o].distance));
                self.touches[t].alone = others.product();
            }
        }
    }

    /// What walls add to the density of particle `i`, which moves on by `dt v`, and the gradient of that \[1/m\].
    ///
    /// What is behind one wall is behind another as often as if they did not know of each other. A wall does not press
    /// what is inside it.
    #[inline]
    pub(crate) fn behind(&self, kernel: &Kernel, i: usize, v: Vec3, dt: f64) -> (f64, Vec3) {
        let (mut free, mut gradient) = (1.0, [0.0; 3]);
        let own = &self.touches[self.first[i] as usize..self.first[i + 1] as usize];
        for touch in own.iter().filter(|t| t.distance >= 0.0) {
            let then = touch.distance + dt * (dot(touch.normal, v) - touch.speed);
            free *= 1.0 - kernel.covered(then);
            gradient = add(gradient, scale(touch.normal, touch.alone * kernel.behind(then).1));
        }
        ((1.0 - free) * kernel.others, gradient)
    }

    /// Pushes particles of that mass \[kg\] by their multipliers, and stops them at a distance of `apart` \[m\]; what
    /// was nearer comes no nearer.
    pub(crate) fn push(
        &mut self,
        kernel: &Kernel,
        multipliers: &[f64],
        [mass, apart, dt]: [f64; 3],
        x: &[Vec3],
        v: &mut [Vec3],
        given: &mut Given,
    ) {
        for touch in &self.touches {
            let i = touch.particle as usize;
            let solid = &mut self.solids[touch.solid as usize];
            let closing = |v: Vec3, solid: &Solid| dot(touch.normal, v) - dot(touch.normal, solid.velocity(x[i]));
            let then = touch.distance + dt * closing(v[i], solid);
            if touch.distance >= 0.0 {
                let pressed = mass * part() * multipliers[i] * touch.alone * kernel.behind(then).1 / dt;
                give(solid, touch.normal, pressed, mass, x[i], &mut v[i], given);
            }
            let short = -(touch.distance - apart).max(0.0) / dt - closing(v[i], solid);
            if short > 0.0 {
                let yields = match solid {
                    Solid::Rigid(_, proxy, _) => proxy.yields(x[i], touch.normal),
                    _ => 0.0,
                };
                give(solid, touch.normal, short / (1.0 / mass + yields), mass, x[i], &mut v[i], given);
            }
        }
    }

    /// Lets rigid partners go on by their own free motion over `dt` \[s\].
    pub(crate) fn fly(&mut self, dt: f64) {
        for solid in &mut self.solids {
            if let Solid::Rigid(_, proxy, _) = solid {
                proxy.take([0.0; 3], [0.0; 3], dt);
            }
        }
    }

    /// Particles that are inside a solid.
    pub(crate) fn swallowed(&self) -> usize {
        self.first
            .windows(2)
            .filter(|w| self.touches[w[0] as usize..w[1] as usize].iter().any(|t| t.distance < 0.0))
            .count()
    }

    /// Largest speed of a rigid partner's centre \[m/s\].
    pub(crate) fn speed(&self) -> f64 {
        self.solids
            .iter()
            .fold(0.0, |most, s| if let Solid::Rigid(_, p, _) = s { most.max(p.speed(0.0)) } else { most })
    }
}

/// Gives a particle an impulse of that size \[N s\] along `normal`, which the solid takes.
fn give(solid: &mut Solid, normal: Vec3, size: f64, mass: f64, x: Vec3, v: &mut Vec3, given: &mut Given) {
    if size == 0.0 {
        return;
    }
    let (impulse, before) = (scale(normal, size), *v);
    *v = add(before, scale(impulse, 1.0 / mass));
    let all = Wrench { linear: impulse, angular: cross(x, impulse) };
    match solid {
        Solid::Rigid(_, proxy, row) => {
            let on = all.negated().about([0.0; 3], proxy.record.position);
            proxy.take(on.linear, on.angular, 0.0);
            let crossed = &mut given.crossed[*row];
            crossed.on_rigid = crossed.on_rigid.plus(on);
            crossed.take(all, size.abs(), 0.5 * dot(impulse, add(before, *v)));
        }
        Solid::Fixed(_) | Solid::Side(..) => *given.external = given.external.plus(all),
    }
}
