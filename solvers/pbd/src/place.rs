//! A point of a cloth: a vertex, or a point of an edge or triangle as the mean of its vertices with given shares.
//!
//! An impulse on it is handed to the vertices by the same shares. Their sum is then the impulse, and the sum of their
//! moments is its moment at the point, so that contact of faces closes both momenta as contact of vertices does.

use cosplat_core::boundary::{Vec3, add, scale};

use crate::closest::{at, on_triangle};
use crate::vertex::Vertex;

/// A point of a cloth.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Place {
    ends: [u32; 3],
    /// Not negative, of sum 1; 0 where a vertex has no part in it.
    share: [f64; 3],
}

impl Place {
    /// A vertex.
    pub(crate) fn vertex(index: u32) -> Self {
        Self { ends: [index; 3], share: [1.0, 0.0, 0.0] }
    }

    /// A point of a triangle.
    pub(crate) fn on(ends: [u32; 3], share: [f64; 3]) -> Self {
        Self { ends, share }
    }

    /// Its vertices, also those that have no part in it, and their shares.
    pub(crate) fn raw(&self) -> ([u32; 3], [f64; 3]) {
        (self.ends, self.share)
    }

    /// Vertices that have a part in it, and their shares.
    pub(crate) fn parts(&self) -> impl Iterator<Item = (usize, f64)> + use<> {
        let pairs: [(u32, f64); 3] = std::array::from_fn(|k| (self.ends[k], self.share[k]));
        pairs.into_iter().filter(|(_, s)| *s > 0.0).map(|(i, s)| (i as usize, s))
    }

    /// The point of the same triangle that is nearest to this one moved by `way` \[m\].
    pub(crate) fn moved(&self, vertices: &[Vertex], way: Vec3) -> Self {
        let x = self.ends.map(|i| vertices[i as usize].x);
        Self { ends: self.ends, share: on_triangle(x, add(at(x, self.share), way)) }
    }

    /// Whether it is a single vertex.
    pub(crate) fn is_vertex(&self) -> bool {
        self.ends[0] == self.ends[1]
    }

    /// One of its vertices.
    pub(crate) fn first(&self) -> usize {
        self.ends[0] as usize
    }

    /// Where it is \[m\].
    pub(crate) fn position(&self, vertices: &[Vertex]) -> Vec3 {
        self.parts().fold([0.0; 3], |sum, (i, s)| add(sum, scale(vertices[i].x, s)))
    }

    /// How fast it moves \[m/s\].
    pub(crate) fn velocity(&self, vertices: &[Vertex]) -> Vec3 {
        self.parts().fold([0.0; 3], |sum, (i, s)| add(sum, scale(vertices[i].u, s)))
    }

    /// Velocity per impulse \[1/kg\].
    pub(crate) fn inverse(&self, vertices: &[Vertex]) -> f64 {
        self.parts().map(|(i, s)| s * s * vertices[i].w).sum()
    }
}
