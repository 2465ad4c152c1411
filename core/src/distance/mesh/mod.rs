//! Signed distance of a closed triangle mesh: exact by a tree of boxes, and cached on a regular grid for points that are
//! asked about in every substep.

mod closest;
mod field;
mod height;
mod tree;

use crate::asset::{AssetError, TriangleMesh};
use crate::boundary::{norm, sub};

use crate::distance::{Distance, SignedDistance};
use field::Field;
use tree::Tree;

pub use height::HeightField;

/// A solid whose surface is a mesh.
#[derive(Debug)]
pub struct MeshSolid {
    tree: Tree,
    /// Missing where a grid fine enough would be too large: the tree then answers alone.
    field: Option<Field>,
    /// Corners of its box \[m\].
    low: [f64; 3],
    high: [f64; 3],
    /// Radius about the origin that holds it \[m\].
    radius: f64,
}

impl MeshSolid {
    /// The mesh with `origin` \[m\] moved to zero, cached for contact on cells of size `dx` \[m\].
    ///
    /// # Errors
    /// [`AssetError`] where it encloses no solid.
    pub fn new(mesh: &TriangleMesh, origin: [f64; 3], dx: f64) -> Result<Self, AssetError> {
        let exact = Self::exact(mesh, origin)?;
        let field = Field::new(&exact.tree, exact.low, exact.high, dx);
        Ok(Self { field, ..exact })
    }

    /// The mesh with `origin` \[m\] moved to zero, without a cache: for those who ask once.
    ///
    /// # Errors
    /// [`AssetError`] where it encloses no solid.
    pub fn exact(mesh: &TriangleMesh, origin: [f64; 3]) -> Result<Self, AssetError> {
        mesh.solid()?;
        let vertices: Vec<[f64; 3]> = mesh.vertices_m.iter().map(|&v| sub(v, origin)).collect();
        let tree = Tree::new(&vertices, &mesh.triangles);
        let fold = |f: fn(f64, f64) -> f64, start: f64| [0, 1, 2].map(|k| vertices.iter().map(|v| v[k]).fold(start, f));
        let (low, high) = (fold(f64::min, f64::INFINITY), fold(f64::max, f64::NEG_INFINITY));
        let radius = vertices.iter().map(|&v| norm(v)).fold(0.0, f64::max);
        Ok(Self { tree, field: None, low, high, radius })
    }

    /// Corners of its box \[m\].
    pub fn bounds(&self) -> [[f64; 3]; 2] {
        [self.low, self.high]
    }

    /// Radius about the origin that holds it \[m\].
    pub fn radius(&self) -> f64 {
        self.radius
    }

    /// Distance from its box \[m\]; 0 inside.
    pub fn box_distance(&self, x: [f64; 3]) -> f64 {
        norm([0, 1, 2].map(|k| (self.low[k] - x[k]).max(x[k] - self.high[k]).max(0.0)))
    }
}

impl SignedDistance for MeshSolid {
    /// Beyond the shell of two cells that is cached the distance is a lower bound, that from the mesh's box.
    fn distance(&self, x: [f64; 3]) -> Distance {
        let Some(field) = &self.field else { return self.tree.distance(x) };
        field.at(x).unwrap_or_else(|| (self.box_distance(x), [0.0, 0.0, 1.0]))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::boundary::{dot, scale};
    use crate::distance::Shape;

    /// A box with eight shared corners.
    pub(super) fn brick(half: [f64; 3]) -> TriangleMesh {
        let corner = |i: usize| [0, 1, 2].map(|k| if i >> k & 1 == 1 { half[k] } else { -half[k] });
        let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
        TriangleMesh {
            vertices_m: (0..8).map(corner).collect(),
            triangles: quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect(),
        }
    }

    fn probes() -> impl Iterator<Item = [f64; 3]> {
        (0..400).map(|i| {
            let t = f64::from(i) * 0.61;
            [0.25 * t.sin(), 0.3 * (1.3 * t).cos(), 0.35 * (0.37 * t).sin()]
        })
    }

    #[test]
    fn a_box_of_triangles_is_a_box() {
        let half = [0.1, 0.15, 0.2];
        let mesh = MeshSolid::new(&brick(half), [0.0; 3], 0.02).expect("closed");
        let exact = Shape::Box(half);
        let (mut worst, mut off) = (0.0_f64, 0.0_f64);
        for x in probes() {
            let (d, n) = mesh.tree.distance(x);
            let (wanted, normal) = exact.distance(x);
            // Rounding of coordinates of 0.3 m.
            assert!((d - wanted).abs() < 1e-15 && (d < 0.0 || norm(sub(n, normal)) < 1e-9), "{x:?}: {d} {wanted}");
            if wanted.abs() < 0.02 {
                let (cached, n) = mesh.distance(x);
                worst = worst.max((cached - wanted).abs());
                off = off.max(1.0 - dot(n, normal));
            }
        }
        println!("cached: {worst} m, {off}");
        // Linear interpolation on cells of dx/4 = 5 mm is exact beside a face; at an edge it is off by up to a quarter
        // of a cell.
        assert!(worst < 0.25 * 0.005, "{worst}");
    }

    #[test]
    fn the_origin_moves_and_an_open_mesh_is_refused() {
        let mesh = MeshSolid::new(&brick([0.1; 3]), [0.05, 0.0, 0.0], 0.02).expect("closed");
        assert!((mesh.distance([0.055, 0.0, 0.0]).0 - 0.005).abs() < 1e-7, "single precision of the cache");
        assert!((mesh.radius() - norm([0.15, 0.1, 0.1])).abs() < 1e-15);
        assert!((mesh.box_distance([0.25, 0.0, 0.0]) - 0.2).abs() < 1e-15);
        let mut open = brick([0.1; 3]);
        open.triangles.pop();
        assert_eq!(MeshSolid::new(&open, [0.0; 3], 0.02).err(), Some(AssetError::Open(3)));
    }

    #[test]
    fn a_fine_ball_is_a_ball() {
        // A cube of 12 x 12 squares a side blown up to a sphere.
        let (m, radius) = (6_i32, 0.1);
        let mut mesh = TriangleMesh::default();
        let mut known = std::collections::BTreeMap::new();
        let mut vertex = |p: [i32; 3], mesh: &mut TriangleMesh| {
            *known.entry(p).or_insert_with(|| {
                let p = p.map(f64::from);
                mesh.vertices_m.push(scale(p, radius / norm(p)));
                mesh.vertices_m.len() as u32 - 1
            })
        };
        for axis in 0..3 {
            for side in [-m, m] {
                for (i, j) in (-m..m).flat_map(|i| (-m..m).map(move |j| (i, j))) {
                    let mut at = |i: i32, j: i32| {
                        let mut p = [0; 3];
                        (p[axis], p[(axis + 1) % 3], p[(axis + 2) % 3]) = (side, i, j);
                        vertex(p, &mut mesh)
                    };
                    let mut quad = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
                    if side < 0 {
                        quad.reverse();
                    }
                    let [a, b, c, d] = quad;
                    mesh.triangles.extend([[a, b, c], [a, c, d]]);
                }
            }
        }
        let ball = MeshSolid::new(&mesh, [0.0; 3], 0.02).expect("closed");
        for x in probes().filter(|&x| (norm(x) - radius).abs() < 0.03) {
            let (d, normal) = ball.distance(x);
            // Flat triangles of up to 26 mm x 13 mm lie up to (15 mm)²/2R = 1.1 mm inside the sphere.
            assert!((d - (norm(x) - radius)).abs() < 1.2e-3, "{x:?}: {d}");
            assert!(dot(normal, scale(x, 1.0 / norm(x))) > 0.98, "{x:?}: {normal:?}");
        }
    }
}
