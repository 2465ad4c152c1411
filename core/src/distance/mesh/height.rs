//! Terrain: a mesh through which every line along z passes at most once. What lies below it is inside.

use crate::asset::{AssetError, TriangleMesh};
use crate::boundary::{norm, sub};
use crate::distance::{Distance, SignedDistance};

use super::tree::{Tree, UPRIGHT, signed, unit};

/// Heights closer than this part of the terrain's size are the same: files round their numbers.
const SAME: f64 = 1e-6;

/// Room for rounding, in parts of the terrain's size.
const ROUNDING: f64 = 1e-12;

/// Terrain in its own frame, with +z up. Beside it there is nothing.
#[derive(Debug)]
pub struct HeightField {
    tree: Tree,
    /// Corners of its box \[m\].
    low: [f64; 3],
    high: [f64; 3],
}

impl HeightField {
    /// Of a mesh, which need not be closed. Its triangles may be wound either way.
    ///
    /// # Errors
    /// [`AssetError::NoArea`] and [`AssetError::Overhang`].
    pub fn new(mesh: &TriangleMesh) -> Result<Self, AssetError> {
        let upwards = |&[a, b, c]: &[u32; 3]| {
            let [p, q, r] = mesh.corners([a, b, c]);
            let normal: [f64; 3] = (q - p).cross(&(r - p)).into();
            let up = unit(normal)[2];
            (if up < 0.0 { [a, c, b] } else { [a, b, c] }, up.abs() >= UPRIGHT && norm(normal) > 0.0)
        };
        let turned: Vec<([u32; 3], bool)> = mesh.triangles.iter().map(upwards).collect();
        if !turned.iter().any(|(_, has_area)| *has_area) {
            return Err(AssetError::NoArea);
        }
        let triangles: Vec<[u32; 3]> = turned.into_iter().map(|(triangle, _)| triangle).collect();
        let used = || triangles.iter().flatten().map(|&i| mesh.vertices_m[i as usize]);
        let fold = |f: fn(f64, f64) -> f64, start: f64| [0, 1, 2].map(|k| used().map(|v| v[k]).fold(start, f));
        let (low, high) = (fold(f64::min, f64::INFINITY), fold(f64::max, f64::NEG_INFINITY));
        let field = Self { tree: Tree::new(&mesh.vertices_m, &triangles), low, high };
        field.overhang().map_or(Ok(field), |[x, y]| Err(AssetError::Overhang(x, y)))
    }

    /// Corners of the box around its surface \[m\].
    pub fn bounds(&self) -> [[f64; 3]; 2] {
        [self.low, self.high]
    }

    /// Height of the surface above a point of the plane z = 0 \[m\]; nothing beside the terrain. At a cliff the upper one.
    pub fn height(&self, x: f64, y: f64) -> Option<f64> {
        let mut highest = None;
        self.tree.pierce(x, y, |_, z| highest = Some(highest.map_or(z, |h: f64| h.max(z))));
        highest
    }

    /// A place with two heights. Looked for in the middle of every triangle and close to its edges, where a fold begins.
    fn overhang(&self) -> Option<[f64; 2]> {
        let same = SAME * norm(sub(self.high, self.low));
        let (near, far) = (0.49, 0.02);
        let third = 1.0 / 3.0;
        let probes = [[third; 3], [near, near, far], [near, far, near], [far, near, near]];
        let mut places =
            self.tree.corners().enumerate().flat_map(|(i, [a, b, c])| {
                probes.map(|[u, v, w]| (i, [0, 1, 2].map(|k| u * a[k] + v * b[k] + w * c[k])))
            });
        places.find_map(|(i, [x, y, _])| {
            let (mut own, mut range) = (false, [f64::INFINITY, f64::NEG_INFINITY]);
            self.tree.pierce(x, y, |k, z| {
                own |= k == i;
                range = [range[0].min(z), range[1].max(z)];
            });
            (own && range[1] - range[0] > same).then_some([x, y])
        })
    }

    /// Lower bound of the distance of the terrain and of what is inside \[m\]; negative inside.
    pub(crate) fn at_least(&self, x: [f64; 3]) -> f64 {
        let beside = |k: usize| (self.low[k] - x[k]).max(x[k] - self.high[k]).max(0.0);
        // Beside the terrain what is below its level may be close to the inside.
        let (flat, above) = (beside(0).hypot(beside(1)), x[2] - self.high[2]);
        if flat > 0.0 { flat.max(above) } else { self.above_or_below(x).map_or(above, |(distance, _)| distance) }
    }

    fn above_or_below(&self, x: [f64; 3]) -> Option<Distance> {
        let height = self.height(x[0], x[1])?;
        // The point straight below bounds the search, with room for the rounding of both.
        let way = (x[2] - height).abs() + ROUNDING * norm(sub(self.high, self.low));
        let found = self.tree.nearest(x, way * way);
        Some(signed(x, found.point, found.normal, x[2] < height))
    }
}

impl SignedDistance for HeightField {
    /// The nearest point of the surface, with the sign of what is straight below or above; nothing beside the terrain.
    fn distance(&self, x: [f64; 3]) -> Distance {
        self.above_or_below(x).unwrap_or((f64::INFINITY, [0.0, 0.0, 1.0]))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::boundary::{add, dot};
    use crate::distance::mesh::closest::closest;
    use crate::distance::{Placed, Shape};
    use std::sync::Arc;

    /// `n` x `n` squares over 2 m x 2 m with the height `z(x, y)`; every other triangle is wound the wrong way.
    fn terrain(n: u32, z: impl Fn(f64, f64) -> f64) -> TriangleMesh {
        let at = |i: u32| f64::from(i) * 2.0 / f64::from(n) - 1.0;
        let vertices_m =
            (0..=n).flat_map(|i| (0..=n).map(move |j| (at(i), at(j)))).map(|(x, y)| [x, y, z(x, y)]).collect();
        let square = |i: u32, j: u32| {
            let a = i * (n + 1) + j;
            [[a, a + n + 1, a + 1], [a + 1, a + n + 2, a + n + 1]]
        };
        TriangleMesh { vertices_m, triangles: (0..n).flat_map(|i| (0..n).flat_map(move |j| square(i, j))).collect() }
    }

    fn probes() -> impl Iterator<Item = [f64; 3]> {
        (0..500).map(|i| {
            let t = f64::from(i) * 0.61;
            [0.97 * t.sin(), 0.96 * (1.3 * t).cos(), 0.8 * (0.37 * t).sin()]
        })
    }

    #[test]
    fn a_slope_is_a_plane_and_ends_at_its_edge() {
        let field = HeightField::new(&terrain(7, |x, _| 0.5 * x)).expect("a slope");
        let normal = unit([-0.5, 0.0, 1.0]);
        for x in probes().filter(|x| x[0].abs() < 0.5) {
            let (d, n) = field.distance(x);
            // Rounding of coordinates of 1 m.
            assert!((d - dot(x, normal)).abs() < 1e-15 && norm(sub(n, normal)) < 1e-9, "{x:?}: {d} {n:?}");
        }
        assert!(field.distance([1.01, 0.0, 0.0]).0.is_infinite());
        // On the surface the way to the nearest point is rounding.
        assert!(norm(sub(field.distance([0.25, 0.5, 0.125]).1, normal)) < 1e-9);
        assert!(field.at_least([3.0, 0.0, -5.0]) <= 2.0 && field.at_least([0.0, 0.0, 1.0]) <= normal[2] + 1e-15);
    }

    #[test]
    fn hills_agree_with_a_search_through_all_triangles() {
        let hills = |x: f64, y: f64| 0.2 * (4.0 * x).sin() * (3.0 * y).cos() - 0.1 * x * y;
        let mesh = terrain(24, hills);
        let field = HeightField::new(&mesh).expect("hills");
        let placed = Placed::new(
            Shape::HeightField(Arc::new(HeightField::new(&mesh).expect("hills"))),
            [3.0, 0.0, 1.0],
            [0.0, 0.0, 0.0, 1.0],
        );
        for x in probes() {
            let corners = mesh.triangles.iter().map(|&t| mesh.corners(t).map(Into::into));
            let nearest = corners.map(|c| norm(sub(x, closest(c, x).0))).fold(f64::INFINITY, f64::min);
            let (d, n) = field.distance(x);
            // The same formula over the same triangles, with the corners of some in another order.
            assert!((d.abs() - nearest).abs() < 1e-14, "{x:?}: {d} {nearest}");
            let height = field.height(x[0], x[1]).expect("inside");
            // Squares of 1/12 m below a curvature of at most 0.2 · 4² m⁻¹: edge² · curvature / 4 between both diagonals.
            assert!((height - hills(x[0], x[1])).abs() < 6e-3, "{x:?}");
            assert_eq!(d < 0.0, x[2] < height, "{x:?}");
            let foot = field.distance(sub(x, [0, 1, 2].map(|k| d * n[k]))).0;
            assert!(foot.abs() < 1e-12, "the normal leads to the surface: {foot}");
            let moved = add(x, [3.0, 0.0, 1.0]);
            for (radius, way) in [(0.05, [0.05, 0.0, 0.0]), (0.1, [0.0, 0.0, -0.1])] {
                assert!(placed.at_least(moved, radius) <= placed.distance(add(moved, way)).0 + 1e-12);
            }
        }
    }

    #[test]
    fn what_has_two_heights_is_refused() {
        let mut overhang = terrain(10, |_, _| 0.0);
        // One vertex is pulled across its neighbours.
        overhang.vertices_m[5 * 11 + 5] = [0.45, 0.0, 0.1];
        assert!(matches!(HeightField::new(&overhang), Err(AssetError::Overhang(..))));
        let mut layers = terrain(2, |_, _| 0.0);
        let (above, count) = (terrain(3, |_, _| 1.0), layers.vertices_m.len() as u32);
        layers.vertices_m.extend(above.vertices_m);
        layers.triangles.extend(above.triangles.iter().map(|t| t.map(|i| i + count)));
        assert!(matches!(HeightField::new(&layers), Err(AssetError::Overhang(..))));
        let mut upright = terrain(3, |x, _| x);
        upright.vertices_m.iter_mut().for_each(|v| v[0] = 0.0);
        assert_eq!(HeightField::new(&upright).err(), Some(AssetError::NoArea));
        // A step of upright triangles is a cliff, which has one height everywhere.
        let cliff = terrain(2, |x, _| x);
        let mut step = cliff.clone();
        step.vertices_m.iter_mut().for_each(|v| *v = [v[0].max(0.0), v[1], if v[0] < 0.0 { 0.0 } else { 0.5 }]);
        let step = HeightField::new(&step).expect("a cliff at the edge of a plain");
        assert_eq!(step.height(0.5, 0.3), Some(0.5));
    }
}
