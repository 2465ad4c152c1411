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
}

/// What is known of the friction of a pair.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Rubs {
    Unknown,
    /// The points lie on a line, or there is no friction.
    Never,
    /// By its place in the list.
    At(u32),
}

/// A pair in a substep.
#[derive(Clone, Copy, Debug)]
struct Contact {
    pair: Pair,
    /// Least speed at which the sides must separate \[m/s\], and velocity per impulse \[1/kg\].
    least: f64,
    soft: f64,
    /// Impulse along the normal so far \[N s\].
    pressed: f64,
    rubs: Rubs,
}

/// Friction of a pair, along two directions across it.
#[derive(Clone, Copy, Debug)]
struct Rub {
    /// Impulses on the four vertices that are together a unit on the sides.
    parts: [[Vec3; 4]; 2],
    /// Velocity per impulse \[1/kg\]: of the first, of both, of the second.
    soft: [f64; 3],
    /// Impulse so far \[N s\].
    given: [f64; 2],
}

/// Pairs that are solved in turn, their ends counted from the first of the vertices that they are given.
#[derive(Debug, Default)]
pub(crate) struct Contacts {
    all: Vec<Contact>,
    rubs: Vec<Rub>,
}

impl Pair {
    /// How fast the sides separate \[m/s\].
    pub(crate) fn velocity(&self, vertices: &[Vertex]) -> Vec3 {
        self.ends.iter().zip(self.share).fold([0.0; 3], |sum, (&i, c)| add(sum, scale(vertices[i as usize].u, c)))
    }
}

impl Contacts {
    /// Adds a pair for a substep of `h` \[s\]; one of vertices that are all fixed is left out.
    pub(crate) fn add(&mut self, pair: Pair, vertices: &[Vertex], h: f64) {
        let soft: f64 = pair.ends.iter().zip(pair.share).map(|(&i, c)| vertices[i as usize].w * c * c).sum();
        if soft > 0.0 {
            let rubs = if pair.friction[0] > 0.0 { Rubs::Unknown } else { Rubs::Never };
            self.all.push(Contact { pair, least: least(pair.gap, h), soft, pressed: 0.0, rubs });
        }
    }

    /// Whether there are none.
    #[cfg(test)]
    pub(crate) fn is_empty(&self) -> bool {
        self.all.is_empty()
    }

    /// Gives each what is missing; `held` is what the world gets of vertices that are fixed.
    pub(crate) fn solve(&mut self, vertices: &mut [Vertex], held: &mut Tally) {
        for contact in &mut self.all {
            contact.press(vertices, held);
            if contact.rubs == Rubs::Unknown && contact.pressed > 0.0 {
                // Positions are those of the start of the substep in all turns.
                contact.rubs = Rub::of(&contact.pair, vertices).map_or(Rubs::Never, |rub| {
                    self.rubs.push(rub);
                    Rubs::At(self.rubs.len() as u32 - 1)
                });
            }
            if let Rubs::At(i) = contact.rubs {
                self.rubs[i as usize].solve(contact, vertices, held);
            }
        }
    }
}

impl Contact {
    fn press(&mut self, vertices: &mut [Vertex], held: &mut Tally) {
        let along = dot(self.pair.velocity(vertices), self.pair.normal);
        let pressed = (self.pressed + (self.least - along) / self.soft).max(0.0);
        let more = pressed - self.pressed;
        if more.abs() > 0.0 {
            self.pressed = pressed;
            let push = scale(self.pair.normal, more);
            give(&self.pair.ends, self.pair.share.map(|c| scale(push, c)), vertices, held);
        }
    }
}

impl Rub {
    /// Nothing where the points lie on a line.
    fn of(pair: &Pair, vertices: &[Vertex]) -> Option<Self> {
        let at = pair.ends.map(|i| vertices[i as usize]);
        let turn = Turn::of(at.map(|v| v.x), scale(pair.normal, pair.apart))?;
        let parts = across(pair.normal).map(|direction| turn.parts(pair.share, direction));
        let soft = [[0, 0], [0, 1], [1, 1]].map(|[a, b]: [usize; 2]| {
            at.iter().zip(parts[a].iter().zip(&parts[b])).map(|(v, (p, q))| v.w * dot(*p, *q)).sum()
        });
        Some(Self { parts, soft, given: [0.0; 2] })
    }

    /// Stops the sliding of a pair as far as its friction goes.
    fn solve(&mut self, contact: &Contact, vertices: &mut [Vertex], held: &mut Tally) {
        if contact.pressed <= 0.0 && self.given[0].abs() + self.given[1].abs() <= 0.0 {
            return;
        }
        let (ends, [fixed, sliding]) = (&contact.pair.ends, contact.pair.friction);
        let mut rubbed = self.given;
        let slip = self
            .parts
            .map(|parts| ends.iter().zip(&parts).fold(0.0, |sum, (&i, p)| sum + dot(*p, vertices[i as usize].u)));
        let square = slip[0] * slip[0] + slip[1] * slip[1];
        let [xx, xy, yy] = self.soft;
        // Velocity per impulse along the slip, times its square.
        let soft = xx * slip[0] * slip[0] + 2.0 * xy * slip[0] * slip[1] + yy * slip[1] * slip[1];
        if soft > 0.0 {
            rubbed = [0, 1].map(|k| rubbed[k] - slip[k] * square / soft);
        }
        let size = rubbed[0].hypot(rubbed[1]);
        if size > fixed * contact.pressed {
            rubbed = rubbed.map(|j| j * sliding.min(fixed) * contact.pressed / size);
        }
        let more = [0, 1].map(|k| rubbed[k] - self.given[k]);
        self.given = rubbed;
        if more[0].abs() + more[1].abs() > 0.0 {
            let [p, q] = &self.parts;
            give(ends, std::array::from_fn(|k| add(scale(p[k], more[0]), scale(q[k], more[1]))), vertices, held);
        }
    }
}

fn give(ends: &[u32; 4], impulses: [Vec3; 4], vertices: &mut [Vertex], held: &mut Tally) {
    for (&i, j) in ends.iter().zip(impulses) {
        let vertex = &mut vertices[i as usize];
        if vertex.w > 0.0 {
            vertex.take(j);
        } else {
            held.hold(vertex, j);
        }
    }
}

/// Two unit vectors across one, and each other.
fn across(normal: Vec3) -> [Vec3; 2] {
    // The axis that it is least along is far from it.
    let least = (1..3).fold(0, |a: usize, k| if normal[k].abs() < normal[a].abs() { k } else { a });
    let axis = std::array::from_fn(|k| f64::from(u8::from(k == least)));
    let first = cross(normal, axis);
    let first = scale(first, 1.0 / norm(first));
    [first, cross(normal, first)]
}

/// Rotation of four points about their middle.
#[derive(Clone, Copy, Debug)]
struct Turn {
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
        };
        (vertices, pair)
    }

    fn momenta(v: &[Vertex; 4]) -> [Vec3; 2] {
        let p = |v: &Vertex| scale(v.u, v.mass);
        v.iter().fold([[0.0; 3]; 2], |[l, a], v| [add(l, p(v)), add(a, cross(v.x, p(v)))])
    }

    #[test]
    fn rubbing_keeps_both_momenta_and_takes_energy() {
        let (mut v, pair) = vertex_over_triangle([[2.0, 1.0, -3.0], [0.1, 0.0, 0.0], [0.0; 3], [0.0, 0.2, 0.1]]);
        let energy = |v: &[Vertex; 4]| v.iter().map(|v| 0.5 * v.mass * dot(v.u, v.u)).sum::<f64>();
        let (before, start) = (momenta(&v), energy(&v));
        let mut contacts = Contacts::default();
        contacts.add(pair, &v, 1e-3);
        for _ in 0..20 {
            contacts.solve(&mut v, &mut Tally::default());
        }
        let after = momenta(&v);
        // Roundings of momenta of some kg m/s.
        for k in 0..2 {
            assert!(norm(sub(after[k], before[k])) < 1e-14, "{k}: {:?} {:?}", after[k], before[k]);
        }
        assert!(energy(&v) < start);
        let (pressed, rub) = (contacts.all[0].pressed, contacts.rubs[0]);
        assert!(dot(pair.velocity(&v), pair.normal).abs() < 1e-12 && pressed > 0.0);
        assert!(rub.given[0].hypot(rub.given[1]) <= 0.5 * pressed * (1.0 + 1e-12));
    }

    #[test]
    fn what_turns_as_a_whole_does_not_rub() {
        let omega = [0.3, -2.0, 1.0];
        let (mut v, pair) = vertex_over_triangle([[0.0; 3]; 4]);
        for one in &mut v {
            one.u = cross(omega, one.x);
        }
        let rub = Rub::of(&pair, &v).expect("a triangle");
        for parts in rub.parts {
            let slip = v.iter().zip(parts).fold(0.0, |sum, (v, p)| sum + dot(p, v.u));
            // Roundings of speeds of 2 m/s.
            assert!(slip.abs() < 1e-15, "{slip:?}");
        }
    }

    #[test]
    fn what_is_fixed_on_both_sides_is_no_contact() {
        let (mut v, pair) = vertex_over_triangle([[0.0; 3]; 4]);
        for vertex in &mut v {
            vertex.w = 0.0;
        }
        let mut contacts = Contacts::default();
        contacts.add(pair, &v, 1e-3);
        assert!(contacts.is_empty());
    }
}
