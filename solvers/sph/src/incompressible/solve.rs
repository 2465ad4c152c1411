//! Pressures that are never negative and keep what they must: a linear complementarity problem, by projected relaxation
//! with Nesterov's momentum.
//!
//! With `c(p)` the excess of each particle, sought are `p ≥ 0`, `c ≤ 0`, `p c = 0`. One relaxation is that of Bender and
//! Koschier (2017), `p ← max(0, p + ω c/(dt² D))`; the momentum lets it converge in the square root of the iterations
//! (Nesterov 1983), and is given up whenever it leads uphill (O'Donoghue and Candès, "Adaptive restart for accelerated
//! gradient schemes", 2015).

use crate::force::{Pass, largest};
use crate::incompressible::contact::Contacts;
use crate::incompressible::operator::Operator;
use crate::lanes::Pack;
use crate::near::{CHUNK, for_chunks};

/// Relaxation: one over the largest eigenvalue of the operator over its diagonal, which on a lattice is about 3.3 (the
/// largest `|k Ŵ(k)|²` over `Σ V² |∇W|²`). With the most momentum that is stable up to 4/3 of it.
const RELAXATION: f64 = 0.3;
/// Where Nesterov's sequence begins: with momentum, as what is left of the last solution is smooth and the first iterations all
/// go one way. From 1 it takes a tenth more of them.
const BEGIN: f64 = 2.0;
/// How much more than the mean a solution may leave at a single place: half a hundredth by default, as much as a weakly
/// compressible liquid of ten times the largest speed is compressed.
const WORST: f64 = 50.0;

/// What is to be solved.
pub(crate) struct Problem<'a> {
    pub(crate) pass: &'a Pass<'a>,
    pub(crate) pack: &'a [Pack],
    /// Excess of each place without pressure.
    pub(crate) base: &'a [f64],
    /// Particles that have entered and not left.
    pub(crate) count: usize,
    /// Mean excess that may be left, and most iterations.
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
    most: f64,
    uphill: f64,
}

/// A particle in an iteration.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Trial {
    /// Pressure, and what it was relaxed to in this iteration and in the one before \[Pa\].
    pub(crate) pressure: f64,
    new: f64,
    old: f64,
    /// What its place is fuller than at rest with that pressure.
    pub(crate) excess: f64,
}

/// Working memory, and the solution.
#[derive(Clone, Debug, Default)]
pub(crate) struct Search {
    pub(crate) trials: Vec<Trial>,
    /// Pressures over `M` times volume \[J\], and velocities that they give times volume \[m⁴/s\]; then nobody's.
    pushed: Vec<f32>,
    moved: Vec<[f32; 4]>,
    /// Rates of the filled shares \[1/s\].
    rates: Vec<f64>,
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
        self.trials.clear();
        self.trials.extend(start.iter().map(|&p| Trial { pressure: p, new: p, old: p, excess: 0.0 }));
        self.pushed.resize(n + 1, 0.0);
        self.moved.resize(n + 1, [0.0; 4]);
        (self.pushed[n], self.moved[n]) = (0.0, [0.0; 4]);
        self.rates.resize(n, 0.0);
        self.judged.resize(n.div_ceil(CHUNK), Judged::default());
        let (mut step, mut iterations) = (BEGIN, 0);
        let mut momentum = 0.0;
        loop {
            self.push(problem, operator, momentum);
            let Self { pushed, moved, rates, .. } = self;
            operator.accelerate(problem.pass, problem.pack, pushed, moved);
            contacts.answer(pushed, &operator.edge, problem.pass.dt);
            operator.rates(problem.pass, problem.pack, contacts, false, (moved, rates));
            self.relax(problem, operator);
            iterations += 1;
            let excess = self.judged.iter().map(|j| j.excess).sum::<f64>() / problem.count.max(1) as f64;
            let most = self.judged.iter().map(|j| j.most).fold(0.0, largest);
            let enough = excess <= problem.accuracy && most <= WORST * problem.accuracy;
            if enough || iterations >= problem.most {
                return Found { iterations, enough };
            }
            let uphill = self.judged.iter().map(|j| j.uphill).sum::<f64>() > 0.0;
            let next = if uphill { 1.0 } else { 0.5 * (1.0 + (1.0 + 4.0 * step * step).sqrt()) };
            momentum = if uphill { 0.0 } else { (step - 1.0) / next };
            step = next;
        }
    }

    /// The next pressures to try.
    fn push(&mut self, problem: &Problem<'_>, operator: &Operator, momentum: f64) {
        let mut chunks: Vec<&mut [f32]> = self.pushed.chunks_mut(CHUNK).collect();
        for_chunks(problem.pass.parallel, &mut self.trials, &mut chunks, &|c, trials, pushed| {
            for (k, t) in trials.iter_mut().enumerate() {
                let i = c * CHUNK + k;
                t.pressure = (t.new + momentum * (t.new - t.old)).max(0.0);
                t.old = t.new;
                pushed[k] = (t.pressure * operator.rows[i].swell * problem.pack[i].volume) as f32;
            }
        });
    }

    /// The excess at the present pressures, and one relaxation.
    fn relax(&mut self, problem: &Problem<'_>, operator: &Operator) {
        let Self { trials, rates, judged, .. } = self;
        let dt = problem.pass.dt;
        for_chunks(problem.pass.parallel, trials, judged, &|c, trials, judged| {
            *judged = Judged::default();
            for (k, t) in trials.iter_mut().enumerate() {
                let i = c * CHUNK + k;
                let diagonal = operator.rows[i].diagonal;
                t.excess = problem.base[i] + dt * rates[i];
                if dt * dt * diagonal > 0.0 {
                    t.new = (t.pressure + RELAXATION * t.excess / (dt * dt * diagonal)).max(0.0);
                }
                let wrong = if t.pressure > 0.0 { t.excess.abs() } else { t.excess.max(0.0) };
                judged.excess = largest(judged.excess + wrong, f64::NEG_INFINITY);
                judged.most = largest(wrong, judged.most);
                judged.uphill += diagonal * (t.pressure - t.new) * (t.new - t.old);
            }
        });
    }
}
