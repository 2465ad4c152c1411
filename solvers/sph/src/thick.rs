//! Implicit viscosity, for liquids so thick that explicit viscosity would bind the substep.
//!
//! The velocities `v'` after viscosity are those of which its forces are taken: `m (v' - v) = dt F(v')`, with the pairs of the
//! explicit force (`force`), as Weiler et al. ("A physically consistent implicit viscosity solver for SPH fluids", 2018) do with
//! theirs. The forces act along the line between two particles, so the system is symmetric and positive, and conjugate
//! gradients solve it. At a wall the velocity mirrored at its surface is that of the particle itself, so that no unknown
//! depends on the means that the explicit force takes.
//!
//! What is given to the velocities is `dt F` of the solution found: momentum is kept to rounding whatever the solution's error.
#![expect(clippy::inline_always, reason = "as said in `lanes`")]

use cosplat_core::boundary::{Vec3, Wrench, add, cross, dot, scale, sub};
use fearless_simd::{Level, Simd, dispatch, f64x4, prelude::*};

use crate::force::{Pass, Sums, drag, largest};
use crate::lanes::{Four, Pack, accumulate, along_one, gather, groups, total, zero, zeros};
use crate::near::{CHUNK, for_chunks};
use crate::store::Store;
use crate::wall::Walls;

/// Residual, as a share of the first, in the mean of squares of velocities.
const ACCURACY: f64 = 1e-4;
/// Most iterations.
const MOST: u64 = 200;

/// Working memory.
#[derive(Clone, Debug, Default)]
pub(crate) struct Thick {
    /// Change of velocity \[m/s\], residual \[N s\], direction \[m/s\], and what the system makes of it \[N s\].
    change: Vec<Vec3>,
    residual: Vec<Vec3>,
    direction: Vec<Vec3>,
    image: Vec<Vec3>,
    /// One over the diagonal \[1/kg\].
    light: Vec<f64>,
    nothing: Vec<()>,
}

/// What a pass over the pairs does with them.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Walled {
    /// Walls have their velocities.
    Moving,
    /// Walls are at rest: the linear part.
    Still,
}

impl Thick {
    /// Velocities after viscosity, in the store and the packs, from those in both; iterations.
    pub(crate) fn spread(
        &mut self,
        pass: &Pass<'_>,
        store: &mut Store,
        pack: &mut [Pack],
        walls: &Walls,
        sums: &mut [Sums],
    ) -> u64 {
        let (n, dt) = (store.len(), pass.dt);
        let mass = |i: usize| pass.model.mass[store.id[i] as usize];
        self.change.clear();
        self.change.resize(n, [0.0; 3]);
        self.image.resize(n, [0.0; 3]);
        self.nothing.resize(n.div_ceil(CHUNK), ());
        self.weigh(pass, store, pack, walls);
        force(pass, store, pack, walls, Walled::Moving, &mut self.image, &mut self.nothing);
        self.residual.clear();
        self.residual.extend(self.image.iter().map(|&f| scale(f, dt)));
        let (first, mut before) = (self.size(), f64::INFINITY);
        let mut iterations = 0;
        self.direction.clear();
        self.direction.resize(n, [0.0; 3]);
        let mut left = first;
        while left > ACCURACY * ACCURACY * first && iterations < MOST {
            let carried = if before.is_finite() { left / before } else { 0.0 };
            for (d, (r, light)) in self.direction.iter_mut().zip(self.residual.iter().zip(&self.light)) {
                *d = add(scale(*r, *light), scale(*d, carried));
            }
            for (pack, d) in pack.iter_mut().zip(&self.direction) {
                pack.v = *d;
            }
            force(pass, store, pack, walls, Walled::Still, &mut self.image, &mut self.nothing);
            for (i, (image, d)) in self.image.iter_mut().zip(&self.direction).enumerate() {
                *image = sub(scale(*d, mass(i)), scale(*image, dt));
            }
            let curve: f64 = self.image.iter().zip(&self.direction).map(|(a, d)| dot(*a, *d)).sum();
            let step = if curve > 0.0 { left / curve } else { 0.0 };
            for (i, d) in self.direction.iter().enumerate() {
                self.change[i] = add(self.change[i], scale(*d, step));
                self.residual[i] = sub(self.residual[i], scale(self.image[i], step));
            }
            before = left;
            left = self.size();
            iterations += 1;
        }
        for (i, pack) in pack.iter_mut().take(n).enumerate() {
            pack.v = add(store.v[i], self.change[i]);
        }
        force(pass, store, pack, walls, Walled::Moving, &mut self.image, &mut self.nothing);
        for sum in sums.iter_mut() {
            sum.speed = 0.0;
        }
        for (i, f) in self.image.iter().enumerate() {
            let (old, new) = (store.v[i], add(store.v[i], scale(*f, dt / mass(i))));
            // Lost is what the forces take from the particles; walls at rest take no work.
            let sum = &mut sums[i / CHUNK];
            sum.lost -= 0.5 * dot(*f, add(old, new));
            if store.rho[i] > 0.0 {
                sum.speed = largest(dot(new, new), sum.speed);
            }
            if !walls.near(i).is_empty() {
                let linear = by_walls(pass, &pack[i], walls, i, Walled::Moving);
                sum.walls = sum.walls.plus(Wrench { linear, angular: cross(pack[i].x, linear) });
            }
            store.v[i] = new;
        }
        for (pack, v) in pack.iter_mut().zip(&store.v) {
            pack.v = *v;
        }
        iterations
    }

    /// `Σ r² / diagonal`, chunk by chunk.
    fn size(&self) -> f64 {
        self.residual.iter().zip(&self.light).map(|(r, light)| dot(*r, *r) * light).sum()
    }

    /// Diagonals: a third of the trace of what a particle's own motion is answered with.
    fn weigh(&mut self, pass: &Pass<'_>, store: &Store, pack: &[Pack], walls: &Walls) {
        self.light.resize(store.len(), 0.0);
        for_chunks(pass.parallel, &mut self.light, &mut self.nothing, &|c, light, ()| {
            for (k, light) in light.iter_mut().enumerate() {
                let (i, all) = (c * CHUNK + k, (store, pack, walls));
                let stiff = dispatch!(Level::new(), simd => stiffness(simd, pass, all, i));
                *light = 1.0 / (pass.model.mass[store.id[i] as usize] + pass.dt * pack[i].volume * stiff / 3.0);
            }
        });
    }
}

/// Trace of what the motion of a particle is answered with, over its volume \[N s/m⁴\].
#[inline(always)]
fn stiffness<S: Simd>(simd: S, pass: &Pass<'_>, (store, pack, walls): (&Store, &[Pack], &Walls), i: usize) -> f64 {
    let (kernel, own, body) = (pass.model.kernel, &pack[i], model_body(pass, store.id[i] as usize));
    let (mut stiff, one) = (zero(simd), f64x4::splat(simd, 1.0));
    for j in groups(pass.lists.chunks()[i / CHUNK].row(i % CHUNK)) {
        let others = Four::new(simd, own, pack, j);
        let rub = drag(&kernel, pass.thickness(simd, store, body, j), one, others.square);
        stiff -= kernel.slopes(others.r) * others.volume * rub * others.square;
    }
    for b in groups(walls.near(i)) {
        let others = Four::new(simd, own, walls.packs(), b);
        let rub = drag(&kernel, walls.grips(simd, b), one, others.square);
        stiff -= kernel.slopes(others.r) * others.volume * rub * others.square;
    }
    total(stiff)
}

fn model_body(pass: &Pass<'_>, id: usize) -> usize {
    pass.model.body[id] as usize
}

/// Forces of viscosity by the velocities in the packs \[N\].
fn force(
    pass: &Pass<'_>,
    store: &Store,
    pack: &[Pack],
    walls: &Walls,
    walled: Walled,
    forces: &mut [Vec3],
    nothing: &mut [()],
) {
    for_chunks(pass.parallel, forces, nothing, &|c, forces, ()| {
        for (k, force) in forces.iter_mut().enumerate() {
            let i = c * CHUNK + k;
            *force = dispatch!(Level::new(), simd => by_liquid(simd, pass, store, pack, i));
            if !walls.near(i).is_empty() {
                *force = add(*force, by_walls(pass, &pack[i], walls, i, walled));
            }
        }
    });
}

/// Force of the liquid on a particle \[N\].
#[inline(always)]
fn by_liquid<S: Simd>(simd: S, pass: &Pass<'_>, store: &Store, pack: &[Pack], i: usize) -> Vec3 {
    let (kernel, own, body) = (pass.model.kernel, &pack[i], model_body(pass, store.id[i] as usize));
    let mut sum = zeros(simd);
    for j in groups(pass.lists.chunks()[i / CHUNK].row(i % CHUNK)) {
        let others = Four::new(simd, own, pack, j);
        let shear = drag(&kernel, pass.thickness(simd, store, body, j), others.approach(), others.square);
        accumulate(&mut sum, &others.apart, kernel.slopes(others.r) * others.volume * shear);
    }
    scale(gather(sum), own.volume)
}

/// Force of walls on a particle \[N\].
fn by_walls(pass: &Pass<'_>, own: &Pack, walls: &Walls, i: usize, walled: Walled) -> Vec3 {
    dispatch!(Level::new(), simd => by_these(simd, pass, own, walls, walls.near(i), walled))
}

/// Force of the boundary particles `near` on a particle \[N\].
#[inline(always)]
fn by_these<S: Simd>(simd: S, pass: &Pass<'_>, own: &Pack, walls: &Walls, near: &[u32], walled: Walled) -> Vec3 {
    let kernel = pass.model.kernel;
    let mut sum = zeros(simd);
    for b in groups(near) {
        let others = Four::new(simd, own, walls.packs(), b);
        let approach = if walled == Walled::Moving { others.approach() } else { along_one(&others.apart, own.v) };
        let shear = drag(&kernel, walls.grips(simd, b), approach, others.square);
        accumulate(&mut sum, &others.apart, kernel.slopes(others.r) * others.volume * shear);
    }
    scale(gather(sum), own.volume)
}
