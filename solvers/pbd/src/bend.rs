//! Angle between two triangles with a common edge.
//!
//! `C = θ - θ0`, with θ zero in a plane sheet and the gradients of Bridson, Marino, Fedkiw ("Simulation of clothing with
//! folds and wrinkles", 2003). Angle and gradients are those at the start of the substep, `C` at its end is linear in the
//! velocities: impulses then have neither a sum nor a moment (see `stretch`). The compliance is one of an angle
//! \[rad/(N m)\], energy `C²/2α` a hinge; on a square sheet bent along its threads the bending stiffness is `1/α` \[N m\],
//! whatever the spacing.

use cosplat_core::boundary::{Vec3, add, cross, dot, scale, sub};

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
/// Tangent up to which the series is taken: it leaves `1/8¹⁸ / 19`, 3e-18 of the angle.
const FLAT: f64 = 0.125;

/// Angle of the direction `(x, y)` \[rad\]. Most hinges are nearly flat, where a series is enough.
#[inline]
fn arctangent(y: f64, x: f64) -> f64 {
    if x <= 0.0 || y.abs() > FLAT * x {
        return libm::atan2(y, x);
    }
    let t = y / x;
    let square = t * t;
    t * SERIES.iter().fold(0.0, |sum, term| sum * square + term)
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
    fn a_plane_is_flat_and_a_needle_is_nothing() {
        let flat = BENT.map(|[x, y, _]| [x, y, 0.0]);
        assert!(angle(flat).expect("triangles").0.abs() < 1e-15);
        assert!(angle([BENT[2], BENT[1], BENT[2], BENT[3]]).is_none());
    }
}
