//! Vertices, triangles, edges and hinges of a cloth at rest.

use std::collections::{BTreeMap, BTreeSet};

use cosplat_core::asset::{Asset, AssetError, TriangleMesh};
use cosplat_core::boundary::{Vec3, cross, norm, scale, sub};

/// Squares that fit into 32-bit numbers of vertices and constraints, and into memory.
const MOST_SQUARES: f64 = 4e7;

/// A cloth in its own frame.
#[derive(Clone, Debug, Default)]
pub(crate) struct Sheet {
    /// Places at rest \[m\].
    pub(crate) points: Vec<Vec3>,
    /// Triangles.
    pub(crate) triangles: Vec<[u32; 3]>,
    /// Distance constraints, and whether each is a diagonal of a square.
    pub(crate) edges: Vec<([u32; 2], bool)>,
    /// Hinges: the vertices beside the edge, then the edge.
    pub(crate) hinges: Vec<[u32; 4]>,
    /// Area that each vertex stands for \[m²\].
    pub(crate) areas: Vec<f64>,
    /// Mean length of an edge \[m\].
    pub(crate) spacing: f64,
    /// Sides of the squares of a rectangle \[m\].
    pub(crate) squares: Option<[f64; 2]>,
}

impl Sheet {
    /// A rectangle in z = 0, centred, cut into squares of about `spacing` \[m\] with diagonals of alternating direction;
    /// vertices row by row, x running fastest.
    pub(crate) fn rectangle(size: [f64; 2], spacing: f64) -> Option<Self> {
        let cells = size.map(|s| (s / spacing).round().max(1.0));
        // Not a number fits nowhere either.
        if !(0.0..MOST_SQUARES).contains(&(cells[0] * cells[1])) {
            return None;
        }
        let [nx, ny] = cells.map(|c| c as u32);
        let at = |i: u32, j: u32| j * (nx + 1) + i;
        let place = |k: usize, i: u32| size[k] * (f64::from(i) / cells[k] - 0.5);
        let points = (0..=ny).flat_map(|j| (0..=nx).map(move |i| [place(0, i), place(1, j), 0.0])).collect();
        let squares = [size[0] / cells[0], size[1] / cells[1]];
        let (mut triangles, mut diagonals) = (Vec::new(), BTreeSet::new());
        for (i, j) in (0..ny).flat_map(|j| (0..nx).map(move |i| (i, j))) {
            let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
            if (i + j) % 2 == 0 {
                triangles.extend([[a, b, c], [a, c, d]]);
                diagonals.insert([a, c]);
            } else {
                triangles.extend([[a, b, d], [b, c, d]]);
                diagonals.insert([b, d]);
            }
        }
        Self::new(points, triangles, &|edge| diagonals.contains(&edge)).ok().map(|sheet| Self {
            spacing: 0.5 * (squares[0] + squares[1]),
            squares: Some(squares),
            ..sheet
        })
    }

    /// The triangles of a mesh, which may be open.
    ///
    /// # Errors
    /// In words, where it is no surface.
    pub(crate) fn of_mesh(mesh: &TriangleMesh) -> Result<Self, String> {
        let checked: Result<(), AssetError> = Asset::Mesh(mesh.clone()).check();
        checked.map_err(|wrong| wrong.to_string())?;
        Self::new(mesh.vertices_m.clone(), mesh.triangles.clone(), &|_| false)
    }

    fn new(
        points: Vec<Vec3>,
        triangles: Vec<[u32; 3]>,
        is_diagonal: &dyn Fn([u32; 2]) -> bool,
    ) -> Result<Self, String> {
        let mut beside: BTreeMap<[u32; 2], Vec<u32>> = BTreeMap::new();
        let mut areas = vec![0.0; points.len()];
        for &[a, b, c] in &triangles {
            let [p, q, r] = [a, b, c].map(|i| points[i as usize]);
            let area = 0.5 * norm(cross(sub(q, p), sub(r, p)));
            for i in [a, b, c] {
                areas[i as usize] += area / 3.0;
            }
            for (i, j, other) in [(a, b, c), (b, c, a), (c, a, b)] {
                beside.entry([i.min(j), i.max(j)]).or_default().push(other);
            }
        }
        if let Some(alone) = areas.iter().position(|a| *a <= 0.0) {
            return Err(format!("vertex {alone} belongs to no triangle that has an area"));
        }
        if let Some(([i, j], all)) = beside.iter().find(|(_, all)| all.len() > 2) {
            let count = all.len();
            return Err(format!("{count} triangles meet at the edge of the vertices {i} and {j}"));
        }
        let same = |&&[i, j]: &&[u32; 2]| norm(sub(points[i as usize], points[j as usize])) <= 0.0;
        if let Some([i, j]) = beside.keys().find(same) {
            return Err(format!("the vertices {i} and {j} of one triangle are at the same place: merge them"));
        }
        let hinge = |(&[i, j], all): (&[u32; 2], &Vec<u32>)| match all[..] {
            [p, q] => Some([p, q, i, j]),
            _ => None,
        };
        let hinges = beside.iter().filter_map(hinge).collect();
        let edges: Vec<([u32; 2], bool)> = beside.keys().map(|&edge| (edge, is_diagonal(edge))).collect();
        let length = |&([i, j], _): &([u32; 2], bool)| norm(sub(points[i as usize], points[j as usize]));
        let spacing = edges.iter().map(length).sum::<f64>() / edges.len().max(1) as f64;
        Ok(Self { points, triangles, edges, hinges, areas, spacing, squares: None })
    }

    /// Area \[m²\].
    pub(crate) fn area(&self) -> f64 {
        self.areas.iter().sum()
    }

    /// Order of the vertices along the longest extent, so that neighbours are near each other in memory: place in
    /// memory by number.
    pub(crate) fn places(&self) -> Vec<u32> {
        let range = |k: usize| {
            let along = || self.points.iter().map(|p| p[k]);
            along().fold(f64::NEG_INFINITY, f64::max) - along().fold(f64::INFINITY, f64::min)
        };
        let axis = (1..3).fold(0, |a, k| if range(k) > range(a) { k } else { a });
        let mut order: Vec<u32> = (0..self.points.len() as u32).collect();
        order.sort_by(|&i, &j| self.points[i as usize][axis].total_cmp(&self.points[j as usize][axis]).then(i.cmp(&j)));
        let mut places = vec![0; order.len()];
        for (place, &number) in order.iter().enumerate() {
            places[number as usize] = place as u32;
        }
        places
    }
}

/// Normals of vertices, weighted by area; up where there is none.
pub(crate) fn normals(triangles: &[[u32; 3]], x: &dyn Fn(u32) -> Vec3, count: usize) -> Vec<Vec3> {
    let mut sums = vec![[0.0; 3]; count];
    for &[a, b, c] in triangles {
        let [p, q, r] = [a, b, c].map(x);
        let n = cross(sub(q, p), sub(r, p));
        for i in [a, b, c] {
            sums[i as usize] = cosplat_core::boundary::add(sums[i as usize], n);
        }
    }
    let unit = |n: Vec3| {
        let length = norm(n);
        if length > 0.0 { scale(n, 1.0 / length) } else { [0.0, 0.0, 1.0] }
    };
    sums.into_iter().map(unit).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_rectangle_has_the_counts_of_its_squares() {
        let sheet = Sheet::rectangle([0.3, 0.2], 0.1).expect("small");
        assert_eq!((sheet.points.len(), sheet.triangles.len()), (12, 12));
        // 3·3 + 2·4 along the threads, 6 diagonals; all but the 10 on the rim are hinges.
        assert_eq!((sheet.edges.len(), sheet.hinges.len()), (23, 13));
        assert_eq!(sheet.edges.iter().filter(|e| e.1).count(), 6);
        assert!((sheet.area() - 0.06).abs() < 1e-15 && (sheet.spacing - 0.1).abs() < 1e-15);
    }

    #[test]
    fn what_is_no_surface_is_refused() {
        let vertices_m = vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]];
        let mesh = |triangles: Vec<[u32; 3]>| TriangleMesh { vertices_m: vertices_m.clone(), triangles };
        let fan = Sheet::of_mesh(&mesh(vec![[0, 1, 2], [0, 1, 3], [0, 1, 4]])).expect_err("three at an edge");
        assert!(fan.contains("3 triangles"), "{fan}");
        assert!(Sheet::of_mesh(&mesh(vec![[0, 1, 2]])).expect_err("loose").contains("vertex 3"));
        assert!(Sheet::of_mesh(&mesh(vec![[0, 1, 9]])).expect_err("wild").contains("names vertex 9"));
    }
}
