//! Distance between two vertices.
//!
//! Extended position-based dynamics (Macklin, Müller, Chentanez 2016) in small substeps (Macklin et al. 2019), written
//! for velocities: with `r0` the distance at the start of a substep and `r = r0 + h (ua - ub)` at its end, the multiplier
//! is `Δλ = -(C + α̃ λ) / ((wa + wb) cos + α̃)`, `C = |r| - l`, `α̃ = α/h²`, and the impulse `Δλ/h`.
//!
//! The impulse acts along `r0`, not along `r`: a step from `x` to `x + h u` keeps `Σ x × m u` only where impulses are
//! central at `x`. That is the choice of SHAKE (Ryckaert, Ciccotti, Berendsen 1977); along `r`, angular momentum and the
//! energy of a swing decay at first order in `h`. `cos` is the cosine between the two.

use cosplat_core::boundary::{Vec3, add, dot, scale, sub};
use wide::f64x4;

use crate::lanes::{self, Four, LANES, lanes};
use crate::vertex::{Constraint, Solve, Sweeps, Vertex};

/// Least cosine between the directions at the start and the end of a substep that counts: beyond 75° a correction along
/// the old direction would overshoot.
const LEAST_COSINE: f64 = 0.25;

/// A distance constraint.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Edge {
    ends: [u32; 2],
    /// Length at rest \[m\].
    pub(crate) rest: f64,
    /// Compliance \[m/N\].
    pub(crate) compliance: f64,
    /// Multiplier of this substep \[kg m\], or the factor of a relaxed correction.
    lambda: f64,
}

impl Edge {
    /// Between two vertices; `relaxation` counts in relaxed solves only.
    pub(crate) fn new(ends: [u32; 2], rest: f64, compliance: f64, relaxation: f64) -> Self {
        Self { ends, rest, compliance, lambda: relaxation }
    }
}

impl Edge {
    /// By which part of its length it is off after a substep, beyond what its compliance gives way: what the sweeps,
    /// the relaxation and later contact have left.
    pub(crate) fn left(&self, [a, b]: [&Vertex; 2], solve: &Solve) -> f64 {
        let r = sub(a.x, b.x);
        let given = if solve.relaxed { 0.0 } else { self.compliance * solve.per_h2 * self.lambda };
        (self.rest - dot(r, r).sqrt() - given).abs() / self.rest
    }
}

impl Constraint<2> for Edge {
    #[inline]
    fn ends(&self) -> [u32; 2] {
        self.ends
    }

    fn set_ends(&mut self, ends: [u32; 2]) {
        self.ends = ends;
    }

    #[inline]
    fn impulses(&mut self, [a, b]: [&Vertex; 2], solve: &Solve) -> Option<[Vec3; 2]> {
        let start = sub(a.x, b.x);
        let end = add(start, scale(sub(a.u, b.u), solve.h));
        let square = dot(end, end);
        let length = square.sqrt();
        let alpha = self.compliance * solve.per_h2;
        // Everything times |r|, so that one root and one division are enough.
        let along = dot(end, start).max(LEAST_COSINE * square);
        let below = (a.w + b.w) * along + alpha * square;
        if below <= 0.0 {
            return None;
        }
        let change = if solve.relaxed {
            (self.rest - length) * self.lambda * length / below
        } else {
            let before = if solve.first { 0.0 } else { self.lambda };
            let change = (self.rest - length - alpha * before) * length / below;
            self.lambda = before + change * length;
            change
        };
        let impulse = scale(start, change / solve.h);
        Some([impulse, scale(impulse, -1.0)])
    }

    fn solve_four(four: &mut [Self; LANES], vertices: &mut [Vertex], solve: &Solve) -> bool {
        let end = |k: usize| Four::of(vertices, [four[0].ends[k], four[1].ends[k], four[2].ends[k], four[3].ends[k]]);
        let (a, b) = (end(0), end(1));
        let (h, per_h2) = (f64x4::splat(solve.h), f64x4::splat(solve.per_h2));
        let [rest, lambda] = [lanes(four, |e| e.rest), lanes(four, |e| e.lambda)];
        let start = lanes::sub(a.x, b.x);
        let end = lanes::add(start, lanes::scale(lanes::sub(a.u, b.u), h));
        let square = lanes::dot(end, end);
        let length = square.sqrt();
        let alpha = lanes(four, |e| e.compliance) * per_h2;
        let along = lanes::dot(end, start).fast_max(f64x4::splat(LEAST_COSINE) * square);
        let below = (a.w + b.w) * along + alpha * square;
        if !below.simd_gt(f64x4::ZERO).all() {
            return false;
        }
        let change = if solve.relaxed {
            (rest - length) * lambda * length / below
        } else {
            let before = if solve.first { f64x4::ZERO } else { lambda };
            let change = (rest - length - alpha * before) * length / below;
            let after = (before + change * length).to_array();
            four.iter_mut().zip(after).for_each(|(e, lambda)| e.lambda = lambda);
            change
        };
        let impulse = lanes::scale(start, change / h);
        a.take(impulse, vertices);
        b.take([-impulse[0], -impulse[1], -impulse[2]], vertices);
        true
    }

    fn energy(&self, [a, b]: [&Vertex; 2], sweeps: &Sweeps) -> f64 {
        let r = sub(a.x, b.x);
        sweeps.energy(dot(r, r).sqrt() - self.rest, self.compliance, a.w + b.w, self.lambda)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::vertex::solve;

    fn pair(u: Vec3) -> [Vertex; 2] {
        let one = |x: Vec3, u: Vec3, mass: f64| Vertex { x, u, w: 1.0 / mass, mass };
        [one([0.1, 0.2, 0.3], u, 0.5), one([0.4, 0.0, 0.3], [0.0; 3], 2.0)]
    }

    const FIRST: Solve = Solve { h: 1e-3, per_h2: 1e6, first: true, relaxed: false };

    #[test]
    fn a_rigid_edge_has_its_length_after_one_solve_and_keeps_both_momenta() {
        let mut v = pair([3.0, -20.0, 5.0]);
        let before = v;
        let mut edge = Edge::new([0, 1], 0.3, 0.0, 1.0);
        solve(&mut edge, &mut v, &FIRST);
        let end = |v: &Vertex| add(v.x, scale(v.u, FIRST.h));
        let r = sub(end(&v[0]), end(&v[1]));
        // What is left is of second order in the correction of 0.06 m that is not along the end's direction (cos 0.998).
        assert!((dot(r, r).sqrt() - 0.3).abs() < 1e-4, "{}", dot(r, r).sqrt());
        let sum = |f: &dyn Fn(&Vertex) -> Vec3, v: &[Vertex; 2]| add(f(&v[0]), f(&v[1]));
        let p = |v: &Vertex| scale(v.u, v.mass);
        let l = |v: &Vertex| cosplat_core::boundary::cross(v.x, scale(v.u, v.mass));
        for f in [&p as &dyn Fn(&Vertex) -> Vec3, &l] {
            let d = sub(sum(f, &v), sum(f, &before));
            // Roundings of momenta of some 10 kg m/s.
            assert!(dot(d, d).sqrt() < 1e-14, "{d:?}");
        }
    }

    #[test]
    fn four_are_solved_as_one_after_the_other() {
        let vertices: Vec<Vertex> = (0..8)
            .map(f64::from)
            .map(|i| Vertex {
                x: [i.sin(), (2.3 * i).cos(), 0.4 * i],
                u: [0.2 * i, 1.0 - i, (3.0 * i).sin()],
                w: 0.3 + i,
                mass: 1.0,
            })
            .collect();
        for (relaxed, first) in [(false, true), (false, false), (true, true)] {
            let solver = Solve { first, relaxed, h: 0.05, per_h2: 400.0 };
            let mut edges = [0, 2, 4, 6].map(|i| Edge::new([i, i + 1], 0.1 * f64::from(i) + 0.4, 1e-3, 0.3));
            let (mut one, mut four, mut others) = (vertices.clone(), vertices.clone(), edges);
            for edge in &mut edges {
                solve(edge, &mut one, &solver);
            }
            assert!(Edge::solve_four(&mut others, &mut four, &solver));
            let bits = |v: &[Vertex]| v.iter().flat_map(|v| v.u.map(f64::to_bits)).collect::<Vec<_>>();
            assert_eq!(bits(&one), bits(&four));
            assert_eq!(edges.map(|e| e.lambda.to_bits()), others.map(|e| e.lambda.to_bits()));
        }
    }

    #[test]
    fn what_is_left_is_what_a_compliance_does_not_explain() {
        let mut v = pair([0.0; 3]);
        let mut edge = Edge::new([0, 1], 0.3, 1e-3, 1.0);
        solve(&mut edge, &mut v, &FIRST);
        for v in &mut v {
            v.x = add(v.x, scale(v.u, FIRST.h));
        }
        let [a, b] = &v;
        // Alone it is solved at once, up to roundings of a length of 0.3 m; it is stretched by its compliance all the same.
        assert!(edge.left([a, b], &FIRST) < 1e-12, "{}", edge.left([a, b], &FIRST));
        let plain = Solve { relaxed: true, ..FIRST };
        assert!(edge.left([a, b], &plain) > 1e-3, "{}", edge.left([a, b], &plain));
    }

    #[test]
    fn iterations_with_a_multiplier_do_not_change_the_compliance() {
        let run = |iterations: usize| {
            let mut v = pair([0.0; 3]);
            let mut edge = Edge::new([0, 1], 0.3, 1e-3, 1.0);
            for i in 0..iterations {
                solve(&mut edge, &mut v, &Solve { first: i == 0, ..FIRST });
            }
            v[0].u
        };
        // One edge alone is solved at once; more iterations only round.
        let d = sub(run(1), run(50));
        assert!(dot(d, d).sqrt() < 1e-12, "{d:?}");
    }

    #[test]
    fn a_relaxed_edge_leaves_the_published_share_of_its_error() {
        // Residual (1 - r)^n of an isolated constraint without compliance.
        let mut v = pair([0.0; 3]);
        v[0].x[1] = 0.0;
        let mut edge = Edge::new([0, 1], 0.2, 0.0, 0.05);
        for i in 0..4 {
            solve(&mut edge, &mut v, &Solve { first: i == 0, relaxed: true, ..FIRST });
        }
        let end = |v: &Vertex| v.x[0] + v.u[0] * FIRST.h;
        let left = (end(&v[1]) - end(&v[0]) - 0.2) / 0.1;
        assert!((left - 0.95_f64.powi(4)).abs() < 1e-12, "{left}");
    }
}
