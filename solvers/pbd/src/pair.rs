//! Contact of a cloth with itself and with other cloths: a vertex and a triangle, or two edges, a thickness apart.
//!
//! With `d` the vector between the nearest points of the two sides and shares `c` that sum to zero over their four
//! vertices, `Σ c u` is how fast they separate. Normal impulses act along `d` and turn nothing. Friction acts across it,
//! and would turn the pair by `d × j`, as it acts at two middle surfaces a thickness apart; so slip is what is left
//! after the rotation of the four vertices, `Σ c u - ω × d` with `ω` fitted by least squares, and the impulses are the
//! transpose of that: friction then does not oppose a cloth that turns as a whole, takes energy only, and keeps both
//! momenta to rounding.

use cosplat_core::boundary::{Vec3, add, cross, dot, norm, scale, sub};
use nalgebra::{Matrix3, Vector3};

use crate::contact::least;
use crate::tally::Tally;
use crate::vertex::Vertex;

/// Two pieces of cloth that touch.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Pair {
    pub(crate) ends: [u32; 4],
    /// Of sum zero.
    pub(crate) share: [f64; 4],
    /// From the second side to the first.
    pub(crate) normal: Vec3,
    /// Distance of the nearest points \[m\].
    pub(crate) apart: f64,
    /// Distance of the surfaces \[m\].
    pub(crate) gap: f64,
    /// Static and kinetic friction.
    pub(crate) friction: [f64; 2],
    /// Impulse so far \[N s\]: along the normal, and across.
    pub(crate) pressed: f64,
    pub(crate) rubbed: Vec3,
    /// Once it has rubbed.
    pub(crate) turn: Option<Turn>,
}

impl Pair {
    /// How fast the sides separate \[m/s\].
    pub(crate) fn velocity(&self, vertices: &[Vertex]) -> Vec3 {
        self.ends.iter().zip(self.share).fold([0.0; 3], |sum, (&i, c)| add(sum, scale(vertices[i as usize].u, c)))
    }

    /// Gives what is missing; `held` is what the world gets of vertices that are fixed.
    pub(crate) fn solve(&mut self, vertices: &mut [Vertex], h: f64, held: &mut Tally) {
        let at = self.ends.map(|i| vertices[i as usize]);
        let weight: f64 = at.iter().zip(self.share).map(|(v, c)| v.w * c * c).sum();
        if weight <= 0.0 {
            return;
        }
        let along = dot(self.velocity(vertices), self.normal);
        let pressed = (self.pressed + (least(self.gap, h) - along) / weight).max(0.0);
        let push = scale(self.normal, pressed - self.pressed);
        self.pressed = pressed;
        if norm(push) > 0.0 {
            self.give(self.share.map(|c| scale(push, c)), vertices, held);
        }
        if self.friction[0] <= 0.0 || (pressed <= 0.0 && norm(self.rubbed) <= 0.0) {
            return;
        }
        // Positions are those of the start of the substep in all turns.
        self.turn = self.turn.or_else(|| Turn::of(at.map(|v| v.x), scale(self.normal, self.apart)));
        let Some(turn) = self.turn else { return };
        let slip = sub(self.velocity(vertices), turn.drag(self.ends.map(|i| vertices[i as usize].u)));
        let slip = sub(slip, scale(self.normal, dot(slip, self.normal)));
        let speed = norm(slip);
        let mut rubbed = self.rubbed;
        if speed > 0.0 {
            let across = scale(slip, 1.0 / speed);
            let parts = turn.parts(self.share, across);
            let weight: f64 = at.iter().zip(parts).map(|(v, p)| v.w * dot(p, p)).sum();
            rubbed = sub(rubbed, scale(slip, 1.0 / weight));
        }
        let size = norm(rubbed);
        if size > self.friction[0] * pressed {
            rubbed = scale(rubbed, self.friction[1].min(self.friction[0]) * pressed / size);
        }
        let rub = sub(rubbed, self.rubbed);
        self.rubbed = rubbed;
        if norm(rub) > 0.0 {
            self.give(turn.parts(self.share, rub), vertices, held);
        }
    }

    fn give(&self, impulses: [Vec3; 4], vertices: &mut [Vertex], held: &mut Tally) {
        for (&i, j) in self.ends.iter().zip(impulses) {
            let vertex = &mut vertices[i as usize];
            if vertex.w > 0.0 {
                vertex.take(j);
            } else {
                held.hold(vertex, j);
            }
        }
    }
}

/// Rotation of four points about their middle.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Turn {
    arm: [Vec3; 4],
    inverse: Matrix3<f64>,
    across: Vec3,
}

impl Turn {
    /// Nothing where the points lie on a line.
    fn of(x: [Vec3; 4], across: Vec3) -> Option<Self> {
        let middle = scale(x.iter().fold([0.0; 3], |sum, &x| add(sum, x)), 0.25);
        let arm = x.map(|x| sub(x, middle));
        let inertia = arm.iter().fold(Matrix3::zeros(), |sum, &r| {
            let r = Vector3::from(r);
            sum + Matrix3::identity() * r.norm_squared() - r * r.transpose()
        });
        // Relative to a regular figure; a needle thinner than this would be turned without bound.
        let size = inertia.trace() / 3.0;
        let inverse = inertia.try_inverse().filter(|_| inertia.determinant() > 1e-6 * size.powi(3))?;
        Some(Self { arm, inverse, across })
    }

    /// `ω × d` of the rotation that fits the velocities best \[m/s\].
    fn drag(&self, u: [Vec3; 4]) -> Vec3 {
        let spin = self.arm.iter().zip(u).fold([0.0; 3], |sum, (&r, u)| add(sum, cross(r, u)));
        cross((self.inverse * Vector3::from(spin)).into(), self.across)
    }

    /// Impulses on the four points that together are `impulse` on the sides and turn nothing.
    fn parts(&self, share: [f64; 4], impulse: Vec3) -> [Vec3; 4] {
        let back: Vec3 = (self.inverse * Vector3::from(cross(self.across, impulse))).into();
        std::array::from_fn(|k| sub(scale(impulse, share[k]), cross(back, self.arm[k])))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn vertex_over_triangle(u: [Vec3; 4]) -> ([Vertex; 4], Pair) {
        let x = [[0.3, 0.3, 0.01], [0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
        let mass = [0.5, 1.0, 2.0, 3.0];
        let vertices = std::array::from_fn(|k| Vertex { x: x[k], u: u[k], w: 1.0 / mass[k], mass: mass[k] });
        let pair = Pair {
            ends: [0, 1, 2, 3],
            share: [1.0, -0.4, -0.3, -0.3],
            normal: [0.0, 0.0, 1.0],
            apart: 0.01,
            gap: 0.0,
            friction: [0.5, 0.5],
            pressed: 0.0,
            rubbed: [0.0; 3],
            turn: None,
        };
        (vertices, pair)
    }

    fn momenta(v: &[Vertex; 4]) -> [Vec3; 2] {
        let p = |v: &Vertex| scale(v.u, v.mass);
        v.iter().fold([[0.0; 3]; 2], |[l, a], v| [add(l, p(v)), add(a, cross(v.x, p(v)))])
    }

    #[test]
    fn rubbing_keeps_both_momenta_and_takes_energy() {
        let (mut v, mut pair) = vertex_over_triangle([[2.0, 1.0, -3.0], [0.1, 0.0, 0.0], [0.0; 3], [0.0, 0.2, 0.1]]);
        let energy = |v: &[Vertex; 4]| v.iter().map(|v| 0.5 * v.mass * dot(v.u, v.u)).sum::<f64>();
        let (before, start) = (momenta(&v), energy(&v));
        for _ in 0..20 {
            pair.solve(&mut v, 1e-3, &mut Tally::default());
        }
        let after = momenta(&v);
        // Roundings of momenta of some kg m/s.
        for k in 0..2 {
            assert!(norm(sub(after[k], before[k])) < 1e-14, "{k}: {:?} {:?}", after[k], before[k]);
        }
        assert!(energy(&v) < start);
        assert!(dot(pair.velocity(&v), pair.normal).abs() < 1e-12 && pair.pressed > 0.0);
        assert!(norm(pair.rubbed) <= 0.5 * pair.pressed * (1.0 + 1e-12));
    }

    #[test]
    fn what_turns_as_a_whole_does_not_rub() {
        let omega = [0.3, -2.0, 1.0];
        let (mut v, mut pair) = vertex_over_triangle([[0.0; 3]; 4]);
        for one in &mut v {
            one.u = cross(omega, one.x);
        }
        pair.pressed = 1.0;
        let turn = Turn::of(v.map(|v| v.x), scale(pair.normal, pair.apart)).expect("a triangle");
        let slip = sub(pair.velocity(&v), turn.drag(v.map(|v| v.u)));
        // Roundings of speeds of 2 m/s.
        assert!(norm(slip) < 1e-15, "{slip:?}");
    }
}
