//! Vertices, what connects them, and the order in which that is solved.

use cosplat_core::boundary::{Vec3, add, scale};
use rayon::prelude::*;

use crate::lanes::LANES;

/// One vertex; a cache line.
#[derive(Clone, Copy, Debug, Default)]
#[repr(align(64))]
pub(crate) struct Vertex {
    /// Position at the start of the substep \[m\].
    pub(crate) x: Vec3,
    /// Velocity with all impulses so far \[m/s\].
    pub(crate) u: Vec3,
    /// Inverse mass \[1/kg\]; 0 where it is fixed to the world.
    pub(crate) w: f64,
    /// Mass \[kg\].
    pub(crate) mass: f64,
}

impl Vertex {
    /// Takes an impulse \[N s\].
    #[inline]
    pub(crate) fn take(&mut self, impulse: Vec3) {
        self.u = add(self.u, scale(impulse, self.w));
    }
}

/// Numbers of a substep that constraints need.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Solve {
    /// Length \[s\].
    pub(crate) h: f64,
    /// 1 / length² \[1/s²\].
    pub(crate) per_h2: f64,
    /// Whether this is the first iteration: multipliers start at zero.
    pub(crate) first: bool,
    /// Published factors by which corrections are scaled, instead of the multipliers of XPBD.
    pub(crate) relaxed: bool,
}

/// How sweeps resist: the compliance that a constraint has in effect.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Sweeps {
    /// Length of a substep \[s\].
    pub(crate) h: f64,
    /// Iterations in a substep.
    pub(crate) iterations: u32,
    /// Whether published factors scale the corrections.
    pub(crate) relaxed: bool,
}

impl Sweeps {
    /// Energy \[J\] of a constraint that is off by `c`, with the sum `weight` of `w |∇C|²` and the multiplier `lambda` of
    /// a substep from rest: half of `c` times its force.
    ///
    /// A sweep leaves softness: the forces are linear in all `c` together, and are not those of the compliances. Where
    /// each of `n` corrections is scaled by the factor `r` in place of the multiplier, the share `φ = 1 - (1 - r)^n` of an
    /// error is taken in a substep, as by the compliance `h² weight (1 - φ)/φ`.
    pub(crate) fn energy(&self, c: f64, compliance: f64, weight: f64, lambda: f64) -> f64 {
        let h2 = self.h * self.h;
        if !self.relaxed {
            return -0.5 * c * lambda / h2;
        }
        let left = power(1.0 - lambda, self.iterations);
        let soft = (compliance + h2 * weight) * (left / (1.0 - left)).max(1.0);
        if soft > 0.0 { 0.5 * c * c / soft } else { 0.0 }
    }
}

/// `x` to the power of `n`, by squares.
fn power(mut x: f64, mut n: u32) -> f64 {
    let mut all = 1.0;
    while n > 0 {
        if n & 1 == 1 {
            all *= x;
        }
        x *= x;
        n >>= 1;
    }
    all
}

/// Something that holds `N` vertices together.
pub(crate) trait Constraint<const N: usize>: Copy + Send + Sync {
    /// Its vertices.
    fn ends(&self) -> [u32; N];

    /// The same with its vertices counted from another one.
    fn set_ends(&mut self, ends: [u32; N]);

    /// Impulses on its vertices \[N s\]; nothing where it has degenerated.
    fn impulses(&mut self, at: [&Vertex; N], solve: &Solve) -> Option<[Vec3; N]>;

    /// Solves four that share no vertex, as one after the other would be. Nothing is done, and the answer is no, where one
    /// of them has degenerated.
    fn solve_four(four: &mut [Self; LANES], vertices: &mut [Vertex], solve: &Solve) -> bool;

    /// Energy stored \[J\].
    fn energy(&self, at: [&Vertex; N], sweeps: &Sweeps) -> f64;
}

/// Solves one constraint.
#[inline]
pub(crate) fn solve<const N: usize, C: Constraint<N>>(constraint: &mut C, vertices: &mut [Vertex], solve: &Solve) {
    let ends = constraint.ends().map(|i| i as usize);
    let at = ends.map(|i| &vertices[i]);
    if let Some(impulses) = constraint.impulses(at, solve) {
        for (i, impulse) in ends.into_iter().zip(impulses) {
            vertices[i].take(impulse);
        }
    }
}

/// Constraints that are solved in turn.
#[derive(Clone, Debug)]
pub(crate) struct InTurn<C> {
    pub(crate) all: Vec<C>,
    /// Ends of runs in which no two share a vertex.
    runs: Vec<u32>,
}

impl<C> InTurn<C> {
    fn new<const N: usize>(all: Vec<C>) -> Self
    where
        C: Constraint<N>,
    {
        let count = all.iter().flat_map(Constraint::ends).max().map_or(0, |i| i as usize + 1);
        // The run in which each vertex was last seen.
        let (mut seen, mut runs) = (vec![0; count], Vec::new());
        for (i, constraint) in (0..).zip(&all) {
            if constraint.ends().iter().any(|&v| seen[v as usize] == runs.len() + 1) {
                runs.push(i);
            }
            constraint.ends().iter().for_each(|&v| seen[v as usize] = runs.len() + 1);
        }
        runs.push(all.len() as u32);
        Self { all, runs }
    }

    /// Solves all of them.
    pub(crate) fn solve<const N: usize>(&mut self, vertices: &mut [Vertex], solver: &Solve)
    where
        C: Constraint<N>,
    {
        let mut from = 0;
        for end in self.runs.iter().map(|&end| end as usize) {
            let (fours, rest) = self.all[from..end].as_chunks_mut();
            for four in fours {
                if !C::solve_four(four, vertices, solver) {
                    for one in four {
                        solve(one, vertices, solver);
                    }
                }
            }
            for one in rest {
                solve(one, vertices, solver);
            }
            from = end;
        }
    }
}

/// Constraints sorted by who may solve them.
///
/// Vertices are cut into blocks of one size, and again into blocks shifted by half of it. What lies within a block is
/// solved by whoever has the block; no two blocks share a vertex, so the result does not depend on who that is. Inside a
/// block constraints are sorted by colour: neighbours in the list do not wait for each other.
#[derive(Clone, Debug)]
pub(crate) struct Phases<C> {
    /// Within a block, counted from its first vertex.
    pub(crate) first: Vec<InTurn<C>>,
    /// Within a shifted block, counted from its first vertex.
    pub(crate) shifted: Vec<InTurn<C>>,
    /// Wider than that: one after the other.
    pub(crate) rest: InTurn<C>,
    /// With an end that is fixed to the world, whose impulse is booked: one after the other.
    pub(crate) anchored: Vec<C>,
}

impl<C> Phases<C> {
    /// Sorts constraints of `count` vertices for blocks of `size`.
    pub(crate) fn new<const N: usize>(all: &[C], fixed: &[bool], size: usize) -> Self
    where
        C: Constraint<N>,
    {
        let blocks = fixed.len().div_ceil(size).max(1);
        let half = size / 2;
        let (mut first, mut shifted) = (vec![Vec::new(); blocks], vec![Vec::new(); blocks]);
        let (mut rest, mut anchored) = (Vec::new(), Vec::new());
        for mut constraint in by_colour(all, fixed.len()) {
            let ends = constraint.ends();
            let (low, high) = ends.iter().fold((u32::MAX, 0), |(low, high), &i| (low.min(i), high.max(i)));
            let (low, high) = (low as usize, high as usize);
            if ends.iter().any(|&i| fixed[i as usize]) {
                anchored.push(constraint);
            } else if low / size == high / size {
                constraint.set_ends(ends.map(|i| i - (low / size * size) as u32));
                first[low / size].push(constraint);
            } else if low >= half && (low - half) / size == (high - half) / size {
                let block = (low - half) / size;
                constraint.set_ends(ends.map(|i| i - (block * size + half) as u32));
                shifted[block].push(constraint);
            } else {
                rest.push(constraint);
            }
        }
        let lists = |all: Vec<Vec<C>>| all.into_iter().map(InTurn::new).collect();
        Self { first: lists(first), shifted: lists(shifted), rest: InTurn::new(rest), anchored }
    }

    /// Energy of all \[J\]: `parallel` shares blocks out.
    pub(crate) fn energy<const N: usize>(
        &self,
        (vertices, size): (&[Vertex], usize),
        sweeps: &Sweeps,
        parallel: bool,
    ) -> f64
    where
        C: Constraint<N>,
    {
        let sum = |list: &[C], from: usize| -> f64 {
            list.iter().map(|c| c.energy(c.ends().map(|i| &vertices[from + i as usize]), sweeps)).sum()
        };
        let blocks = |all: &[InTurn<C>], from: usize| -> f64 {
            if parallel {
                let each = all.par_iter().enumerate().map(|(b, list)| sum(&list.all, b * size + from));
                return each.collect::<Vec<f64>>().into_iter().sum();
            }
            all.iter().enumerate().map(|(b, list)| sum(&list.all, b * size + from)).sum()
        };
        blocks(&self.first, 0) + blocks(&self.shifted, size / 2) + sum(&self.rest.all, 0) + sum(&self.anchored, 0)
    }
}

impl<C> Phases<C> {
    /// Largest value of something that is not negative; zero without constraints. `parallel` shares blocks out.
    pub(crate) fn largest<const N: usize>(
        &self,
        (vertices, size): (&[Vertex], usize),
        parallel: bool,
        of: impl Fn(&C, [&Vertex; N]) -> f64 + Sync,
    ) -> f64
    where
        C: Constraint<N>,
    {
        let most = |list: &[C], from: usize| -> f64 {
            list.iter().map(|c| of(c, c.ends().map(|i| &vertices[from + i as usize]))).fold(0.0, f64::max)
        };
        let blocks = |all: &[InTurn<C>], from: usize| -> f64 {
            let one = |(b, list): (usize, &InTurn<C>)| most(&list.all, b * size + from);
            if parallel {
                all.par_iter().enumerate().map(one).reduce(|| 0.0, f64::max)
            } else {
                all.iter().enumerate().map(one).fold(0.0, f64::max)
            }
        };
        let within = blocks(&self.first, 0).max(blocks(&self.shifted, size / 2));
        within.max(most(&self.rest.all, 0)).max(most(&self.anchored, 0))
    }
}

/// Size of blocks such that nearly all constraints lie within one: a power of two, four times the widest constraint.
pub(crate) fn block_size<const N: usize, C: Constraint<N>>(all: &[C]) -> usize {
    let width = |c: &C| {
        let ends = c.ends();
        ends.iter().max().zip(ends.iter().min()).map_or(0, |(high, low)| high - low)
    };
    let widest = all.iter().map(width).max().unwrap_or(0) as usize;
    (4 * widest).next_power_of_two().clamp(SMALLEST_BLOCK, LARGEST_BLOCK)
}

/// Vertices of a block: enough work for a task, few enough for the second-level cache.
const SMALLEST_BLOCK: usize = 512;
const LARGEST_BLOCK: usize = 8192;

/// Sorted by greedy colours; of one colour, in the given order.
fn by_colour<const N: usize, C: Constraint<N>>(all: &[C], vertices: usize) -> Vec<C> {
    let mut taken = vec![0_u64; vertices];
    let mut coloured: Vec<(u32, C)> = Vec::with_capacity(all.len());
    for constraint in all {
        let ends = constraint.ends();
        let used = ends.iter().fold(0, |used, &i| used | taken[i as usize]);
        // More than 64 colours at one vertex: the last is shared, which costs order, not correctness.
        let colour = used.trailing_ones().min(63);
        for i in ends {
            taken[i as usize] |= 1 << colour;
        }
        coloured.push((colour, *constraint));
    }
    coloured.sort_by_key(|&(colour, _)| colour);
    coloured.into_iter().map(|(_, constraint)| constraint).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::stretch::Edge;

    #[test]
    fn a_list_is_solved_in_its_order_and_nothing_of_a_run_shares_a_vertex() {
        let at = |i: u32| f64::from(i) * 0.7;
        let vertices: Vec<Vertex> = (0..40)
            .map(at)
            .map(|t| Vertex { x: [t.sin(), (1.3 * t).cos(), t], u: [t.cos(), 0.1 * t, 0.0], w: 1.0, mass: 1.0 })
            .collect();
        // Triangles of edges: greedy colours leave short runs and long ones.
        let edges: Vec<Edge> =
            (0..38).flat_map(|i| [[i, i + 1], [i, i + 2]]).map(|ends| Edge::new(ends, 0.5, 1e-3, 0.3)).collect();
        let mut list = InTurn::new(by_colour(&edges, vertices.len()));
        let mut from = 0;
        for &end in &list.runs {
            let mut ends: Vec<u32> = list.all[from..end as usize].iter().flat_map(Constraint::ends).collect();
            ends.sort_unstable();
            assert!(ends.windows(2).all(|w| w[0] != w[1]), "{from}..{end}");
            from = end as usize;
        }
        assert!(from == edges.len() && list.runs.len() < edges.len() / LANES, "{:?}", list.runs);
        let solver = Solve { h: 0.1, per_h2: 100.0, first: true, relaxed: false };
        let (mut one, mut other, mut alone) = (vertices.clone(), vertices, list.all.clone());
        for edge in &mut alone {
            solve(edge, &mut one, &solver);
        }
        list.solve(&mut other, &solver);
        assert!(one.iter().zip(&other).all(|(a, b)| a.u.map(f64::to_bits) == b.u.map(f64::to_bits)));
    }
}
