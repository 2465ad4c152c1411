//! Boundary particles of solids: a lattice below the surface, as deep as the kernel reaches, so that a wall continues the
//! liquid's own lattice (Adami, Hu and Adams, "A generalized wall boundary condition for smoothed particle
//! hydrodynamics", 2012).
//!
//! A cell that the surface cuts keeps the share of its volume that lies inside, in the middle of that share: the volume
//! of a solid, and so its buoyancy, does not depend on where the lattice lies.

use std::ops::Range;

use cosplat_core::boundary::{Vec3, add, norm, scale, sub};
use cosplat_core::distance::{Distance, Shape, SignedDistance};

use crate::frame::bounds;

/// Boundary particles above which a spacing is refused as too fine for a solid.
const MOST_PIECES: usize = 3_000_000;
/// Shares of a cell below which it is left out.
const LEAST_SHARE: f64 = 0.05;

/// A place below a surface and the volume that it stands for \[m, m³\].
pub(crate) type Piece = (Vec3, f64);

/// What a cell of the lattice, its middle at that signed distance along that normal, has inside.
fn piece(x: Vec3, (distance, normal): Distance, spacing: f64) -> Option<Piece> {
    let share = (0.5 - distance / spacing).clamp(0.0, 1.0);
    let whole = spacing * spacing * spacing;
    if share >= 1.0 {
        return Some((x, whole));
    }
    (share >= LEAST_SHARE).then(|| (add(x, scale(normal, -0.5 * share * spacing - distance)), share * whole))
}

/// A lattice of cells over the box around a shape.
struct Lattice<'a> {
    shape: &'a Shape,
    low: Vec3,
    step: Vec3,
    /// Distances from the surface of the cells looked for \[m\].
    above: f64,
    below: f64,
}

impl Lattice<'_> {
    /// Calls `found` with the middle of each cell in `range` that is near the surface, until it says no.
    ///
    /// Blocks of cells are left out together where their middle is farther than their corners reach.
    fn visit(&self, range: &[Range<usize>; 3], found: &mut impl FnMut(Vec3, Distance) -> bool) -> bool {
        let at = |i: [usize; 3]| [0, 1, 2].map(|k| self.low[k] + (i[k] as f64 + 0.5) * self.step[k]);
        let [first, last] = [at([0, 1, 2].map(|k| range[k].start)), at([0, 1, 2].map(|k| range[k].end - 1))];
        let (middle, radius) = (scale(add(first, last), 0.5), 0.5 * norm(sub(last, first)));
        let near = self.shape.distance(middle);
        if near.0 - radius > self.above || near.0 + radius <= -self.below {
            return true;
        }
        let longest = (1..3).fold(0, |a, k| if range[k].len() > range[a].len() { k } else { a });
        if range[longest].len() == 1 {
            return found(middle, near);
        }
        let split = range[longest].start + range[longest].len() / 2;
        let (mut lower, mut upper) = (range.clone(), range.clone());
        (lower[longest].end, upper[longest].start) = (split, split);
        self.visit(&lower, found) && self.visit(&upper, found)
    }
}

/// Boundary particles of a shape that is not a plane, in its own frame; `Err` in words.
pub(crate) fn shell(shape: &Shape, spacing: f64, depth: f64) -> Result<Vec<Piece>, String> {
    let Some([low, high]) = bounds(shape) else { return Err("a plane that moves".into()) };
    // A box is filled exactly; the lattice of the others begins outside.
    let fits = matches!(shape, Shape::Box(_));
    let size = sub(high, low);
    let count = size.map(|s| (s / spacing).round().max(1.0) + if fits { 0.0 } else { 2.0 });
    let step = if fits { [0, 1, 2].map(|k| size[k] / count[k]) } else { [spacing; 3] };
    let low = [0, 1, 2].map(|k| 0.5 * (low[k] + high[k] - count[k] * step[k]));
    let above = if fits { 0.0 } else { 0.5 * spacing };
    let lattice = Lattice { shape, low, step, above, below: depth };
    let mut pieces = Vec::new();
    let whole = lattice.visit(&count.map(|n| 0..n as usize), &mut |x, near| {
        pieces.extend(if fits { Some((x, step.iter().product())) } else { piece(x, near, spacing) });
        pieces.len() <= MOST_PIECES
    });
    if whole {
        return Ok(pieces);
    }
    Err(format!("more than {MOST_PIECES} boundary particles at a spacing of {spacing} m; a coarser one helps"))
}

/// Boundary particles of a plane near places `x` of its frame, closer to it than `reach`.
pub(crate) fn below_plane(plane: &Shape, x: impl Iterator<Item = Vec3>, reach: f64, spacing: f64) -> Vec<Piece> {
    // Tiles of 3 x 3 columns, marked around each place.
    let tile = 3.0 * spacing;
    let rings = (reach / tile).ceil() as i64;
    let mut tiles: Vec<[i64; 2]> =
        x.filter(|x| x[2] < reach && x[2] > -reach).map(|x| [x[0], x[1]].map(|x| (x / tile).floor() as i64)).collect();
    tiles.sort_unstable();
    tiles.dedup();
    let around = |[i, j]: [i64; 2]| (-rings..=rings).flat_map(move |a| (-rings..=rings).map(move |b| [i + a, j + b]));
    let mut all: Vec<[i64; 2]> = tiles.into_iter().flat_map(around).collect();
    all.sort_unstable();
    all.dedup();
    let layers = (reach / spacing).ceil() as usize;
    let mut pieces = Vec::with_capacity(all.len() * 9 * layers);
    for [i, j] in all {
        for n in 0..9 * layers {
            let at = |corner: i64, n: usize| corner as f64 * tile + (n as f64 + 0.5) * spacing;
            let x = [at(i, n % 3), at(j, n / 3 % 3), -((n / 9) as f64 + 0.5) * spacing];
            if plane.distance(x).0.is_finite() {
                pieces.push((x, spacing * spacing * spacing));
            }
        }
    }
    pieces
}

#[cfg(test)]
mod tests {
    use super::*;
    use cosplat_core::asset::TriangleMesh;
    use cosplat_core::distance::MeshSolid;
    use std::sync::Arc;

    #[test]
    fn a_solid_has_its_volume_and_its_centre_wherever_the_lattice_lies() {
        let (d, pi) = (0.02, std::f64::consts::PI);
        let solids = [
            (Shape::Sphere(0.1), 4.0 / 3.0 * pi * 1e-3),
            (Shape::Sphere(0.107), 4.0 / 3.0 * pi * 0.107_f64.powi(3)),
            (Shape::Cylinder(0.1, 0.05), pi * 1e-3),
            (Shape::Box([0.1, 0.055, 0.033]), 8.0 * 0.1 * 0.055 * 0.033),
        ];
        for (shape, volume) in solids {
            let pieces = shell(&shape, d, 10.0).unwrap();
            let found: f64 = pieces.iter().map(|p| p.1).sum();
            println!("{shape:?}: {} pieces, volume off by {:.4}", pieces.len(), found / volume - 1.0);
            // Cut cells are taken as cut by a plane along the lattice: second order in spacing over radius, (0.2)²/2.
            assert!((found / volume - 1.0).abs() < 0.02, "{shape:?}");
            let first = pieces.iter().fold([0.0; 3], |s, p| add(s, scale(p.0, p.1)));
            assert!(first.iter().all(|x| x.abs() < 1e-6 * volume));
            assert!(pieces.iter().all(|p| shape.distance(p.0).0 < -0.02 * d));
        }
    }

    #[test]
    fn a_brick_of_triangles_has_the_particles_of_a_box() {
        let (half, d) = ([0.1, 0.055, 0.033], 0.02);
        let corner = |i: usize| [0, 1, 2].map(|k| if i >> k & 1 == 1 { half[k] } else { -half[k] });
        let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
        let mesh = TriangleMesh {
            vertices_m: (0..8).map(corner).map(|v| add(v, [0.3, 0.0, 0.0])).collect(),
            triangles: quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect(),
        };
        let solid = Shape::Mesh(Arc::new(MeshSolid::exact(&mesh, [0.3, 0.0, 0.0]).unwrap()));
        let pieces = shell(&solid, d, 0.05).unwrap();
        let volume: f64 = pieces.iter().map(|p| p.1).sum();
        let exact = 8.0 * half.iter().product::<f64>();
        println!("{} pieces, {}", pieces.len(), volume / exact - 1.0);
        // Cells cut by two or three sides at once are taken as cut by one.
        assert!((volume / exact - 1.0).abs() < 0.06);
        assert!(pieces.iter().all(|p| Shape::Box(half).distance(p.0).0 < -0.02 * d));
        assert!(shell(&Shape::Box([1.0; 3]), 1e-3, 2e-3).unwrap_err().contains("coarser"));
    }

    #[test]
    fn a_plane_has_particles_only_near_what_it_may_touch() {
        let reach = 0.05;
        let one = |plane, x| below_plane(&plane, std::iter::once(x), reach, 0.02);
        let pieces = one(Shape::Plane(None), [1.0, 2.0, 0.01]);
        assert_eq!(pieces.len(), 9 * 9 * 3);
        assert!(one(Shape::Plane(None), [1.0, 2.0, 0.06]).is_empty());
        let edge = one(Shape::Plane(Some([1.0, 3.0])), [1.0, 2.0, 0.01]);
        assert!(!edge.is_empty() && edge.iter().all(|p| p.0[0] <= 1.0));
    }
}
