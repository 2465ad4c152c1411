//! Pressures that are never negative and keep what they must: a linear complementarity problem, by projected relaxation
//! with Nesterov's momentum.
//!
//! With `c(p)` the excess of each particle, sought are `p ≥ 0`, `c ≤ 0`, `p c = 0`. One relaxation is that of Bender and
//! Koschier (2017), `p ← max(0, p + ω c/(dt² D))`; the momentum lets it converge in the square root of the iterations
//! (Nesterov 1983), and is given up whenever it leads uphill (O'Donoghue and Candès, "Adaptive restart for accelerated
//! gradient schemes", 2015).

use cosplat_core::boundary::{Vec3, scale};

use crate::force::{Pass, largest};
use crate::incompressible::contact::Contacts;
use crate::incompressible::operator::{Flow, Operator};
use crate::lanes::Pack;
use crate::near::{CHUNK, for_chunks};
use crate::wall::Walls;

/// Relaxation: one over the largest eigenvalue of the operator over its diagonal, which on a lattice is about 3.3 (the
/// largest `|k Ŵ(k)|²` over `Σ V² |∇W|²`), with a margin.
const RELAXATION: f64 = 0.27;
/// Mean excess that is always good enough: rounding of shares near one, with a margin.
const FLOOR: f64 = 1e-12;
/// Iterations that are always made.
const LEAST: u64 = 1;

/// What is to be solved.
pub(crate) struct Problem<'a> {
    pub(crate) pass: &'a Pass<'a>,
    pub(crate) walls: &'a Walls,
    pub(crate) pack: &'a [Pack],
    /// Velocities without pressure \[m/s\].
    pub(crate) v: &'a [Vec3],
    /// Filled shares now.
    pub(crate) share: &'a [f64],
    pub(crate) dt: f64,
    /// Share of the mean excess without pressure that is good enough.
    pub(crate) accuracy: f64,
    pub(crate) most: u64,
}

/// How it ended.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Found {
    pub(crate) iterations: u64,
    pub(crate) enough: bool,
}

/// Sums over a chunk.
#[derive(Clone, Copy, Debug, Default)]
struct Judged {
    excess: f64,
    uphill: f64,
}

/// A particle after a relaxation.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Relaxed {
    /// Newest pressure, and that before \[Pa\].
    new: f64,
    old: f64,
    /// What its place would be fuller than at rest with the pressure before the relaxation.
    pub(crate) excess: f64,
}

/// Working memory, and the solution.
#[derive(Clone, Debug, Default)]
pub(crate) struct Search {
    /// Pressures \[Pa\] and the velocities that they give \[m/s\].
    pub(crate) pressure: Vec<f64>,
    pub(crate) gained: Vec<Vec3>,
    /// Pressures times volume, gaineds times volume; then nobody.
    pub(crate) pushed: Vec<f64>,
    moved: Vec<Vec3>,
    /// Excess without pressure, and rates of the filled shares in the running iteration \[1/s\].
    base: Vec<f64>,
    rates: Vec<f64>,
    pub(crate) relaxed: Vec<Relaxed>,
    judged: Vec<Judged>,
}

impl Search {
    /// Finds the pressures, beginning with some.
    pub(crate) fn run(
        &mut self,
        problem: &Problem<'_>,
        operator: &mut Operator,
        contacts: &mut Contacts,
        start: &[f64],
    ) -> Found {
        let n = start.len();
        self.begin(problem, operator, contacts, start);
        let (mut step, mut iterations) = (1.0_f64, 0);
        let unpressed = self.base.iter().map(|b| b.max(0.0)).sum::<f64>() / n.max(1) as f64;
        let wanted = (problem.accuracy * unpressed).max(FLOOR);
        loop {
            for ((pushed, &p), pack) in self.pushed.iter_mut().zip(&self.pressure).zip(problem.pack) {
                *pushed = p * pack.volume;
            }
            let Self { pressure, gained, pushed, moved, rates, .. } = self;
            operator.accelerate(problem.pass, problem.walls, pressure, pushed, gained);
            contacts.answer(pushed, &operator.edge, problem.dt);
            for ((moved, a), pack) in moved.iter_mut().zip(gained.iter()).zip(problem.pack) {
                *moved = scale(*a, pack.volume * problem.dt);
            }
            for a in gained.iter_mut() {
                *a = scale(*a, problem.dt);
            }
            operator.rates(problem.pass, problem.walls, contacts, false, &mut Flow { v: gained, moved, rates });
            self.relax(problem, operator);
            iterations += 1;
            let excess = self.judged.iter().map(|j| j.excess).sum::<f64>() / n.max(1) as f64;
            let enough = excess <= wanted;
            if (enough && iterations >= LEAST) || iterations >= problem.most {
                contacts.keep();
                return Found { iterations, enough };
            }
            let uphill = self.judged.iter().map(|j| j.uphill).sum::<f64>() > 0.0;
            let next = if uphill { 1.0 } else { 0.5 * (1.0 + (1.0 + 4.0 * step * step).sqrt()) };
            let momentum = if uphill { 0.0 } else { (step - 1.0) / next };
            step = next;
            for (p, r) in self.pressure.iter_mut().zip(&mut self.relaxed) {
                *p = (r.new + momentum * (r.new - r.old)).max(0.0);
                r.old = r.new;
            }
        }
    }

    fn begin(&mut self, problem: &Problem<'_>, operator: &mut Operator, contacts: &Contacts, start: &[f64]) {
        let n = start.len();
        self.pressure.clear();
        self.pressure.extend_from_slice(start);
        self.relaxed.clear();
        self.relaxed.extend(start.iter().map(|&p| Relaxed { new: p, old: p, excess: 0.0 }));
        self.gained.resize(n, [0.0; 3]);
        // The last ones are nobody's.
        self.pushed.clear();
        self.pushed.resize(n + 1, 0.0);
        self.judged.resize(n.div_ceil(CHUNK), Judged::default());
        self.moved.clear();
        self.moved.extend(problem.v.iter().zip(problem.pack).map(|(&v, p)| scale(v, p.volume)));
        self.moved.push([0.0; 3]);
        self.rates.resize(n, 0.0);
        let Self { base, moved, rates, .. } = self;
        operator.rates(problem.pass, problem.walls, contacts, true, &mut Flow { v: problem.v, moved, rates });
        base.clear();
        base.extend(rates.iter().zip(problem.share).map(|(rate, share)| share - 1.0 + problem.dt * rate));
    }

    /// The excess at the present pressures, and one relaxation.
    fn relax(&mut self, problem: &Problem<'_>, operator: &Operator) {
        let Self { pressure, base, rates, relaxed, judged, .. } = self;
        let square = problem.dt * problem.dt;
        for_chunks(problem.pass.parallel, relaxed, judged, &|c, relaxed, judged| {
            *judged = Judged::default();
            for (k, r) in relaxed.iter_mut().enumerate() {
                let (i, diagonal) = (c * CHUNK + k, operator.rows[c * CHUNK + k].diagonal);
                let (p, excess) = (pressure[i], base[i] + problem.dt * rates[i]);
                r.excess = excess;
                if square * diagonal > 0.0 {
                    r.new = (p + RELAXATION * excess / (square * diagonal)).max(0.0);
                }
                let wrong = if p > 0.0 { excess.abs() } else { excess.max(0.0) };
                judged.excess = largest(judged.excess + wrong, f64::NEG_INFINITY);
                judged.uphill += diagonal * (p - r.new) * (r.new - r.old);
            }
        });
    }
}
