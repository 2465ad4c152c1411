//! The surface of all cloths, and which of its pieces touch.

use cosplat_core::boundary::{Vec3, add, cross, dot, norm, scale, sub};

use crate::closest::{of_edges, on_triangle};
use crate::pair::Pair;
use crate::tiles::Tiles;
use crate::vertex::Vertex;

/// Share of the thickness by which more is watched than what closes by itself.
pub(crate) const WATCHED: f64 = 0.05;

/// The surface of all cloths, by vertices in memory.
#[derive(Clone, Debug, Default)]
pub(crate) struct Mesh {
    pub(crate) triangles: Vec<[u32; 3]>,
    pub(crate) edges: Vec<[u32; 2]>,
    /// Which sides and corners of each triangle lie on a rim, as [`crate::rim`] numbers them.
    pub(crate) rim: Vec<u8>,
    /// Places of the vertices at rest, each in the frame of its body \[m\].
    pub(crate) rest: Vec<Vec3>,
    /// Static and kinetic friction of each two bodies, row by row; nothing where they pass through each other.
    pub(crate) friction: Vec<Option<[f64; 2]>>,
    /// Number of bodies.
    pub(crate) bodies: usize,
    /// Small parts of it.
    pub(crate) tiles: Tiles,
}

/// Two pieces that may touch before the next search.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Candidate {
    /// A vertex and a triangle, or two edges.
    pub(crate) ends: [u32; 4],
    pub(crate) is_vertex: bool,
    pub(crate) friction: [f64; 2],
    /// Least distance of the two when they were looked for, as far as is known \[m\].
    pub(crate) apart: f64,
}

impl Candidate {
    /// The contact of the two, where they may close their gap in a substep of `h` \[s\]. Nothing that is further apart than
    /// `touching` does but for its velocity, and no velocity counts for more than `closing` \[m\]. How far apart they are is
    /// noted, as it would have been before things moved by `spent` \[m\].
    pub(crate) fn touch(
        &mut self,
        vertices: &[Vertex],
        (thickness, h): (f64, f64),
        [touching, closing, spent]: [f64; 3],
    ) -> Option<Pair> {
        let ends = self.ends.map(|i| &vertices[i as usize]);
        let further = self.apart - spent - touching;
        if further > 0.0 && further * further > 4.0 * h * h * self.fastest(ends) {
            return None;
        }
        let x = ends.map(|v| v.x);
        let share = if self.is_vertex {
            let [a, b, c] = on_triangle([x[1], x[2], x[3]], x[0]);
            [1.0, -a, -b, -c]
        } else {
            let (first, second) = ([x[0], x[1]], [x[2], x[3]]);
            match of_edges(first, second) {
                Ok([s, t]) => [1.0 - s, s, t - 1.0, -t],
                Err(apart) => {
                    self.apart = apart + spent;
                    return None;
                }
            }
        };
        let between = x.iter().zip(share).fold([0.0; 3], |sum, (&x, c)| add(sum, scale(x, c)));
        let apart = norm(between);
        self.apart = apart + spent;
        if apart > touching + closing {
            return None;
        }
        let normal = if apart > 0.0 { scale(between, 1.0 / apart) } else { self.across(x)? };
        let pair = Pair { ends: self.ends, share, normal, apart, gap: apart - thickness, friction: self.friction };
        let velocity = pair.velocity(vertices);
        // Others may push it while contacts are solved: a little more than what closes by itself is watched.
        let watched = h * norm(velocity) + WATCHED * thickness;
        (pair.gap + h * dot(velocity, normal) < watched).then_some(pair)
    }

    /// Square of the largest speed of a corner of one relative to a corner of the other \[m²/s²\].
    #[inline]
    fn fastest(&self, ends: [&Vertex; 4]) -> f64 {
        let square = |i: usize, j: usize| {
            let u = sub(ends[i].u, ends[j].u);
            dot(u, u)
        };
        let last = if self.is_vertex { square(0, 1) } else { square(1, 2).max(square(1, 3)) };
        square(0, 2).max(square(0, 3)).max(last)
    }

    /// A direction across two pieces that meet in a point.
    fn across(&self, x: [Vec3; 4]) -> Option<Vec3> {
        let n = if self.is_vertex {
            cross(sub(x[2], x[1]), sub(x[3], x[1]))
        } else {
            cross(sub(x[1], x[0]), sub(x[3], x[2]))
        };
        let length = norm(n);
        (length > 0.0).then(|| scale(n, 1.0 / length))
    }
}
