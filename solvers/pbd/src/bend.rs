//! Angle between two triangles with a common edge.
//!
//! `C = θ - θ0`, with θ zero in a plane sheet and the gradients of Bridson, Marino, Fedkiw ("Simulation of clothing with
//! folds and wrinkles", 2003). Angle and gradients are those at the start of the substep, `C` at its end is linear in the
//! velocities: impulses then have neither a sum nor a moment (see `stretch`). The compliance is one of an angle
//! \[rad/(N m)\], energy `C²/2α` a hinge; on a square sheet bent along its threads the bending stiffness is `1/α` \[N m\],
//! whatever the spacing.

use cosplat_core::boundary::{Vec3, add, cross, dot, scale, sub};
use wide::f64x4;

use crate::lanes::{self, Four, Fours, LANES, lanes};
use crate::vertex::{Constraint, Solve, Sweeps, Vertex};

/// A hinge.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Hinge {
    /// The two vertices beside the edge, then the edge.
    ends: [u32; 4],
    /// Angle at rest \[rad\].
    pub(crate) rest: f64,
    /// Compliance \[rad/(N m)\].
    pub(crate) compliance: f64,
    /// Multiplier of this substep, or the factor of a relaxed correction.
    lambda: f64,
    /// By how much the angle was off when the substep began \[rad\].
    off: f64,
}

impl Hinge {
    /// Over four vertices; `relaxation` counts in relaxed solves only.
    pub(crate) fn new(ends: [u32; 4], rest: f64, compliance: f64, relaxation: f64) -> Self {
        Self { ends, rest, compliance, lambda: relaxation, off: 0.0 }
    }
}

/// Angle \[rad\] and its gradients \[rad/m\]; nothing where a triangle has no area.
#[inline]
pub(crate) fn angle([x1, x2, x3, x4]: [Vec3; 4]) -> Option<(f64, [Vec3; 4])> {
    let edge = sub(x4, x3);
    let (a, b) = ([sub(x1, x3), sub(x1, x4)], [sub(x2, x4), sub(x2, x3)]);
    let (n1, n2) = (cross(a[0], a[1]), cross(b[0], b[1]));
    let (s1, s2, square) = (dot(n1, n1), dot(n2, n2), dot(edge, edge));
    // A triangle whose area is less than 1e-8 of the square of its edge has no direction left in double precision.
    if s1.min(s2) <= 1e-16 * square * square || square <= 0.0 {
        return None;
    }
    let length = square.sqrt();
    let inverse = 1.0 / length;
    let theta = arctangent(dot(cross(n2, n1), edge) * inverse, dot(n1, n2));
    let (g1, g2) = (scale(n1, 1.0 / s1), scale(n2, 1.0 / s2));
    let along = |a: Vec3| dot(a, edge) * inverse;
    let third = add(scale(g1, along(a[1])), scale(g2, along(b[0])));
    let fourth = add(scale(g1, -along(a[0])), scale(g2, -along(b[1])));
    Some((theta, [scale(g1, length), scale(g2, length), third, fourth]))
}

/// Terms of the series of the arctangent, the last first.
const SERIES: [f64; 9] =
    [1.0 / 17.0, -1.0 / 15.0, 1.0 / 13.0, -1.0 / 11.0, 1.0 / 9.0, -1.0 / 7.0, 1.0 / 5.0, -1.0 / 3.0, 1.0];
/// Tangents that divide an eighth of a turn, and their angles: nothing is further from the nearest than a tangent of 1/8,
/// where the series leaves `1/8¹⁸ / 19`, 3e-18 of the angle.
const NEAREST: [f64; 5] = [0.0, 0.25, 0.5, 0.75, 1.0];
const BETWEEN: [f64; 4] = [0.125, 0.375, 0.625, 0.875];
const ANGLE: [f64; 5] =
    [0.0, 0.244_978_663_126_864_14, 0.463_647_609_000_806_1, 0.643_501_108_793_284_4, std::f64::consts::FRAC_PI_4];

/// What is left of the angles by rounding.
const LOW: [f64; 5] =
    [0.0, 1.069_875_561_873_445e-17, 2.269_877_745_296_169e-17, 1.583_478_505_144_429e-17, 3.061_616_997_868_383e-17];

/// Angle of the direction `(x, y)` \[rad\], with one division: `atan t = atan c + atan((t - c)/(1 + t c))`.
#[inline]
fn arctangent(y: f64, x: f64) -> f64 {
    use std::f64::consts::{FRAC_PI_2, PI};
    let (width, height) = (x.abs(), y.abs());
    let is_steep = height > width;
    let (long, short) = if is_steep { (height, width) } else { (width, height) };
    let place = BETWEEN.iter().filter(|t| short > **t * long).count();
    let nearest = NEAREST[place];
    let t = (short - nearest * long) / (long + nearest * short).max(f64::MIN_POSITIVE);
    let square = t * t;
    let mut angle = ANGLE[place] + (LOW[place] + t * SERIES.iter().fold(0.0, |sum, term| sum * square + term));
    if is_steep {
        angle = FRAC_PI_2 - angle;
    }
    if x < 0.0 {
        angle = PI - angle;
    }
    angle.copysign(y)
}

/// The same of four.
#[inline]
fn arctangents(y: f64x4, x: f64x4) -> f64x4 {
    use std::f64::consts::{FRAC_PI_2, PI};
    let (width, height) = (x.abs(), y.abs());
    let is_steep = height.simd_gt(width);
    let (long, short) = (is_steep.bitselect(height, width), is_steep.bitselect(width, height));
    let (mut nearest, mut angle, mut low) = (f64x4::ZERO, f64x4::ZERO, f64x4::ZERO);
    for (k, between) in BETWEEN.iter().enumerate() {
        let beyond = short.simd_gt(f64x4::splat(*between) * long);
        nearest = beyond.bitselect(f64x4::splat(NEAREST[k + 1]), nearest);
        angle = beyond.bitselect(f64x4::splat(ANGLE[k + 1]), angle);
        low = beyond.bitselect(f64x4::splat(LOW[k + 1]), low);
    }
    let t = (short - nearest * long) / (long + nearest * short).fast_max(f64x4::splat(f64::MIN_POSITIVE));
    let square = t * t;
    angle += low + t * SERIES.iter().fold(f64x4::ZERO, |sum, term| sum * square + f64x4::splat(*term));
    angle = is_steep.bitselect(f64x4::splat(FRAC_PI_2) - angle, angle);
    angle = x.simd_lt(f64x4::ZERO).bitselect(f64x4::splat(PI) - angle, angle);
    y.simd_lt(f64x4::ZERO).bitselect(-angle, angle)
}

/// Angles of four hinges \[rad\] and their gradients \[rad/m\], as [`angle`] tells them.
#[inline]
fn angles([x1, x2, x3, x4]: [Fours; 4]) -> Option<(f64x4, [Fours; 4])> {
    use lanes::{add, cross, dot, scale, sub};
    let edge = sub(x4, x3);
    let (a, b) = ([sub(x1, x3), sub(x1, x4)], [sub(x2, x4), sub(x2, x3)]);
    let (n1, n2) = (cross(a[0], a[1]), cross(b[0], b[1]));
    let (s1, s2, square) = (dot(n1, n1), dot(n2, n2), dot(edge, edge));
    let least = f64x4::splat(1e-16) * square * square;
    if !(s1.simd_gt(least) & s2.simd_gt(least) & square.simd_gt(f64x4::ZERO)).all() {
        return None;
    }
    let length = square.sqrt();
    let inverse = f64x4::ONE / length;
    let theta = arctangents(dot(cross(n2, n1), edge) * inverse, dot(n1, n2));
    let (g1, g2) = (scale(n1, f64x4::ONE / s1), scale(n2, f64x4::ONE / s2));
    let along = |a: Fours| dot(a, edge) * inverse;
    let third = add(scale(g1, along(a[1])), scale(g2, along(b[0])));
    let fourth = add(scale(g1, -along(a[0])), scale(g2, -along(b[1])));
    Some((theta, [scale(g1, length), scale(g2, length), third, fourth]))
}

/// Difference of two angles, within half a turn.
#[inline]
fn within(angle: f64) -> f64 {
    use std::f64::consts::{PI, TAU};
    if angle > PI {
        angle - TAU
    } else if angle < -PI {
        angle + TAU
    } else {
        angle
    }
}

impl Constraint<4> for Hinge {
    #[inline]
    fn ends(&self) -> [u32; 4] {
        self.ends
    }

    fn set_ends(&mut self, ends: [u32; 4]) {
        self.ends = ends;
    }

    #[inline]
    fn impulses(&mut self, at: [&Vertex; 4], solve: &Solve) -> Option<[Vec3; 4]> {
        self.off = 0.0;
        let (theta, gradient) = angle(at.map(|v| v.x))?;
        let (mut rate, mut weight) = (0.0, 0.0);
        for (v, g) in at.iter().zip(&gradient) {
            rate += dot(v.u, *g);
            weight += v.w * dot(*g, *g);
        }
        self.off = within(theta - self.rest);
        let c = self.off + solve.h * rate;
        let alpha = self.compliance * solve.per_h2;
        let below = weight + alpha;
        if below <= 0.0 {
            return None;
        }
        let change = if solve.relaxed {
            -c * self.lambda / below
        } else {
            let before = if solve.first { 0.0 } else { self.lambda };
            let change = -(c + alpha * before) / below;
            self.lambda = before + change;
            change
        };
        Some(gradient.map(|g| scale(g, change / solve.h)))
    }

    fn solve_four(four: &mut [Self; LANES], vertices: &mut [Vertex], solve: &Solve) -> bool {
        use std::f64::consts::{PI, TAU};
        let end = |k: usize| Four::of(vertices, [four[0].ends[k], four[1].ends[k], four[2].ends[k], four[3].ends[k]]);
        let at = [end(0), end(1), end(2), end(3)];
        let Some((theta, gradient)) = angles([at[0].x, at[1].x, at[2].x, at[3].x]) else { return false };
        let (mut rate, mut weight) = (f64x4::ZERO, f64x4::ZERO);
        for (v, g) in at.iter().zip(&gradient) {
            rate += lanes::dot(v.u, *g);
            weight += v.w * lanes::dot(*g, *g);
        }
        let alpha = lanes(four, |c| c.compliance) * f64x4::splat(solve.per_h2);
        let below = weight + alpha;
        if !below.simd_gt(f64x4::ZERO).all() {
            return false;
        }
        let (pi, turn, h) = (f64x4::splat(PI), f64x4::splat(TAU), f64x4::splat(solve.h));
        let mut off = theta - lanes(four, |c| c.rest);
        off = off.simd_gt(pi).bitselect(off - turn, off.simd_lt(-pi).bitselect(off + turn, off));
        four.iter_mut().zip(off.to_array()).for_each(|(c, off)| c.off = off);
        let (c, lambda) = (off + h * rate, lanes(four, |c| c.lambda));
        let change = if solve.relaxed {
            -c * lambda / below
        } else {
            let before = if solve.first { f64x4::ZERO } else { lambda };
            let change = -(c + alpha * before) / below;
            four.iter_mut().zip((before + change).to_array()).for_each(|(c, lambda)| c.lambda = lambda);
            change
        };
        let share = change / h;
        at.iter().zip(gradient).for_each(|(v, g)| v.take(lanes::scale(g, share), vertices));
        true
    }

    fn energy(&self, at: [&Vertex; 4], sweeps: &Sweeps) -> f64 {
        if !sweeps.relaxed {
            // Multiplier and angle are those of a substep from here.
            return sweeps.energy(self.off, self.compliance, 0.0, self.lambda);
        }
        let Some((theta, gradient)) = angle(at.map(|v| v.x)) else { return 0.0 };
        let weight: f64 = at.iter().zip(&gradient).map(|(v, g)| v.w * dot(*g, *g)).sum();
        sweeps.energy(within(theta - self.rest), self.compliance, weight, self.lambda)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const BENT: [Vec3; 4] = [[0.1, 0.9, 0.4], [-0.1, -0.8, 0.1], [-0.5, 0.0, 0.1], [0.6, 0.1, 0.0]];

    #[test]
    fn gradients_are_differences_and_turn_nothing() {
        let (_, gradient) = angle(BENT).expect("triangles");
        let (mut sum, mut moment) = ([0.0; 3], [0.0; 3]);
        for i in 0..4 {
            for k in 0..3 {
                let moved = |d: f64| {
                    let mut x = BENT;
                    x[i][k] += d;
                    angle(x).expect("triangles").0
                };
                let slope = (moved(1e-6) - moved(-1e-6)) / 2e-6;
                // Central differences: (1e-6)² times a third derivative of order one, and 1e-16 / 1e-6 of rounding.
                assert!((slope - gradient[i][k]).abs() < 1e-8, "{i} {k}: {slope} {}", gradient[i][k]);
            }
            sum = add(sum, gradient[i]);
            moment = add(moment, cross(BENT[i], gradient[i]));
        }
        // Roundings of numbers of order one.
        assert!(dot(sum, sum).sqrt() < 1e-14 && dot(moment, moment).sqrt() < 1e-14, "{sum:?} {moment:?}");
    }

    #[test]
    fn the_series_ends_where_rounding_begins() {
        for i in -3000..3000 {
            let theta = std::f64::consts::PI * f64::from(i) / 3000.0;
            // Roundings of the sine and the cosine, and one of the angle.
            assert!((arctangent(0.3 * theta.sin(), 0.3 * theta.cos()) - theta).abs() <= 4e-16 * theta.abs().max(0.1));
        }
    }

    #[test]
    fn four_are_solved_as_one_after_the_other() {
        let wave = |i: u32, t: f64| (0.3 + 1.7 * f64::from(i) * t).sin();
        let vertices: Vec<Vertex> = (0..16)
            .map(|i| Vertex {
                x: std::array::from_fn(|k| BENT[i as usize % 4][k] + 0.9 * wave(i, 1.3 + k as f64)),
                u: [wave(i, 0.7), wave(i, 0.9), wave(i, 1.1)],
                w: 0.4 + 0.01 * f64::from(i),
                mass: 1.0,
            })
            .collect();
        for (relaxed, first) in [(false, true), (false, false), (true, true)] {
            let solver = Solve { h: 0.1, per_h2: 100.0, first, relaxed };
            let mut hinges =
                [0, 4, 8, 12].map(|i| Hinge::new([i, i + 1, i + 2, i + 3], 0.2 * f64::from(i) - 1.0, 1e-3, 0.3));
            let (mut one, mut four, mut others) = (vertices.clone(), vertices.clone(), hinges);
            for hinge in &mut hinges {
                crate::vertex::solve(hinge, &mut one, &solver);
            }
            assert!(Hinge::solve_four(&mut others, &mut four, &solver));
            let bits = |v: &[Vertex]| v.iter().flat_map(|v| v.u.map(f64::to_bits)).collect::<Vec<_>>();
            assert_eq!(bits(&one), bits(&four));
            let known = |all: &[Hinge; 4]| all.map(|c| [c.lambda.to_bits(), c.off.to_bits()]);
            assert_eq!(known(&hinges), known(&others));
        }
        let mut needles = [0, 4, 8, 12].map(|i| Hinge::new([i, i + 1, i, i + 3], 0.0, 1e-3, 0.3));
        let solver = Solve { h: 0.1, per_h2: 100.0, first: true, relaxed: false };
        assert!(!Hinge::solve_four(&mut needles, &mut vertices.clone(), &solver));
    }

    #[test]
    fn a_plane_is_flat_and_a_needle_is_nothing() {
        let flat = BENT.map(|[x, y, _]| [x, y, 0.0]);
        assert!(angle(flat).expect("triangles").0.abs() < 1e-15);
        assert!(angle([BENT[2], BENT[1], BENT[2], BENT[3]]).is_none());
    }
}
