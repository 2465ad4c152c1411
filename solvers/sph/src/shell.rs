//! Boundary particles of solids: a lattice below the surface, as deep as the kernel reaches, so that a wall continues the
//! liquid's own lattice (Adami, Hu and Adams, "A generalized wall boundary condition for smoothed particle
//! hydrodynamics", 2012).
//!
//! A cell that the surface cuts keeps the share of its volume that lies inside, in the middle of that share: the volume
//! of a solid, and so its buoyancy, does not depend on where the lattice lies. The share of a closed solid's cell is the mean of
//! those of its parts, each cut as by a plane along it: whole cells cut so would have `(d/R)²/4` more than a sphere's volume,
//! a fortieth where it is six spacings across.

use std::ops::Range;

use cosplat_core::boundary::{Vec3, add, norm, scale, sub};
use cosplat_core::distance::{Distance, HeightField, Shape, SignedDistance};

use crate::frame::bounds;

/// Boundary particles above which a spacing is refused as too fine for a solid.
const MOST_PIECES: usize = 3_000_000;
/// Shares of a cell below which it is left out.
const LEAST_SHARE: f64 = 0.01;

/// Parts of a cell along each axis of which its share is the mean.
const PARTS: usize = 3;
/// Widths from the middle of a cell to its corner.
pub(crate) const CORNER: f64 = 0.866_025_403_784_438_6;

/// Share of a cell that lies inside a solid, and the middle of that share; the cell's own is at `x`, `above` \[m\] the surface.
pub(crate) fn inside(solid: &impl SignedDistance, x: Vec3, width: f64, above: f64) -> (f64, Vec3) {
    if above.abs() >= CORNER * width {
        return (if above < 0.0 { 1.0 } else { 0.0 }, x);
    }
    let part = width / PARTS as f64;
    let at = |i: usize| (i as f64 + 0.5) * part - 0.5 * width;
    let (mut share, mut moment) = (0.0, [0.0; 3]);
    for i in 0..PARTS.pow(3) {
        let off = [at(i % PARTS), at(i / PARTS % PARTS), at(i / PARTS / PARTS)];
        let (distance, normal) = solid.distance(add(x, off));
        let within = (0.5 - distance / part).clamp(0.0, 1.0) / PARTS.pow(3) as f64;
        // What is left of a part has its middle half as far below the surface as it reaches.
        let left = if distance > -0.5 * part { scale(normal, -0.5 * (distance + 0.5 * part)) } else { [0.0; 3] };
        share += within;
        moment = add(moment, scale(add(off, left), within));
    }
    (share, add(x, scale(moment, 1.0 / share.max(f64::MIN_POSITIVE))))
}

/// A place below a surface, the volume that it stands for and how deep it lies \[m, m³, m\].
pub(crate) type Piece = (Vec3, f64, f64);

/// What a cell of a terrain's lattice, its middle at that signed distance along that normal, has inside.
fn piece(x: Vec3, (distance, normal): Distance, spacing: f64) -> Option<Piece> {
    let share = (0.5 - distance / spacing).clamp(0.0, 1.0);
    let whole = spacing * spacing * spacing;
    if share >= 1.0 {
        return Some((x, whole, -distance));
    }
    let depth = 0.5 * share * spacing;
    (share >= LEAST_SHARE).then(|| (add(x, scale(normal, -depth - distance)), share * whole, depth))
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

/// Boundary particles below a terrain, column by column; no more than one above [`MOST_PIECES`].
///
/// What lies straight below a place is never closer to the surface from within, so that a column ends where it is deep
/// enough.
fn below_terrain(field: &HeightField, spacing: f64, depth: f64) -> Vec<Piece> {
    let [low, high] = field.bounds();
    let count = [0, 1].map(|k| ((high[k] - low[k]) / spacing).ceil() as usize);
    let start = [0, 1].map(|k| 0.5 * (low[k] + high[k] - count[k] as f64 * spacing));
    let mut pieces = Vec::new();
    for i in 0..count[0] {
        for j in 0..count[1] {
            let [x, y] = [start[0] + (i as f64 + 0.5) * spacing, start[1] + (j as f64 + 0.5) * spacing];
            let Some(height) = field.height(x, y) else { continue };
            let middle = ((height / spacing).floor() + 0.5) * spacing;
            let at = |k: i32| {
                let x = [x, y, f64::from(k).mul_add(spacing, middle)];
                (x, field.distance(x))
            };
            let above = (1..).map(at).take_while(|(_, near)| near.0 < 0.5 * spacing);
            let below = (0..).map(|k| at(-k)).take_while(|(_, near)| near.0 > -depth);
            pieces.extend(above.chain(below).filter_map(|(x, near)| piece(x, near, spacing)));
            if pieces.len() > MOST_PIECES {
                return pieces;
            }
        }
    }
    pieces
}

/// Boundary particles of a shape that is not a plane, in its own frame; `Err` in words.
pub(crate) fn shell(shape: &Shape, spacing: f64, depth: f64) -> Result<Vec<Piece>, String> {
    let pieces = if let Shape::HeightField(field) = shape {
        below_terrain(field, spacing, depth)
    } else {
        below_solid(shape, spacing, depth)?
    };
    if pieces.len() <= MOST_PIECES {
        return Ok(pieces);
    }
    Err(format!("more than {MOST_PIECES} boundary particles at a spacing of {spacing} m; a coarser one helps"))
}

/// Boundary particles of a closed solid; no more than one above [`MOST_PIECES`].
fn below_solid(shape: &Shape, spacing: f64, depth: f64) -> Result<Vec<Piece>, String> {
    let Some([low, high]) = bounds(shape) else { return Err("a plane that moves".into()) };
    // A box is filled exactly; the lattice of the others begins outside.
    let fits = matches!(shape, Shape::Box(_));
    let size = sub(high, low);
    let count = size.map(|s| (s / spacing).round().max(1.0) + if fits { 0.0 } else { 2.0 });
    let step = if fits { [0, 1, 2].map(|k| size[k] / count[k]) } else { [spacing; 3] };
    let low = [0, 1, 2].map(|k| 0.5 * (low[k] + high[k] - count[k] * step[k]));
    let above = if fits { 0.0 } else { CORNER * spacing };
    let lattice = Lattice { shape, low, step, above, below: depth };
    let mut pieces = Vec::new();
    lattice.visit(&count.map(|n| 0..n as usize), &mut |x, near| {
        if fits {
            pieces.push((x, step.iter().product(), -near.0));
        } else {
            let (share, middle) = inside(shape, x, spacing, near.0);
            if share >= LEAST_SHARE {
                let depth = if share < 1.0 { -shape.distance(middle).0 } else { -near.0 };
                pieces.push((middle, share * spacing.powi(3), depth));
            }
        }
        pieces.len() <= MOST_PIECES
    });
    Ok(pieces)
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
                pieces.push((x, spacing * spacing * spacing, -x[2]));
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
            // Parts of cut cells are taken as cut by a plane along them: (0.2/3)²/4 = 0.0011 of a sphere; and of the cut cells, 0.9 of
            // its volume, those without a hundredth inside are left out, half a hundredth of a hundredth each: 5e-5.
            assert!((found / volume - 1.0).abs() < 0.0015, "{shape:?}");
            let first = pieces.iter().fold([0.0; 3], |s, p| add(s, scale(p.0, p.1)));
            assert!(first.iter().all(|x| x.abs() < 1e-6 * volume));
            assert!(pieces.iter().all(|p| shape.distance(p.0).0 < 0.0));
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
        // Parts cut by two sides at once are taken as cut by one: a quarter of their section along 1.5 m of edges at most.
        assert!((volume / exact - 1.0).abs() < 0.25 * (d / 3.0).powi(2) * 1.504 / exact);
        assert!(pieces.iter().all(|p| Shape::Box(half).distance(p.0).0 < -0.02 * d));
        assert!(shell(&Shape::Box([1.0; 3]), 1e-3, 2e-3).unwrap_err().contains("coarser"));
    }

    #[test]
    fn a_terrain_has_layers_below_it_and_nothing_beside_it() {
        // A slope of a half, of 1 m x 1 m.
        let mesh = TriangleMesh {
            vertices_m: vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.5], [1.0, 1.0, 0.5], [0.0, 1.0, 0.0]],
            triangles: vec![[0, 1, 2], [0, 2, 3]],
        };
        let (d, depth) = (0.02, 0.048);
        let slope = Shape::HeightField(Arc::new(HeightField::new(&mesh).unwrap()));
        let pieces = shell(&slope, d, depth).unwrap();
        let volume: f64 = pieces.iter().map(|p| p.1).sum();
        println!("{} pieces, {volume} m³", pieces.len());
        // Down to the last cell whose middle lies above the depth: half a cell less or more.
        let expected = 1.25_f64.sqrt() * depth;
        assert!((volume - expected).abs() < 0.5 * d * 1.25_f64.sqrt(), "{volume} {expected}");
        let inside = |x: &Vec3| (0..2).all(|k| x[k] > -1e-9 && x[k] < 1.0 + 1e-9);
        assert!(pieces.iter().all(|p| slope.distance(p.0).0 < -0.02 * d && inside(&p.0)));
        // The moment of the gradient over all pairs across the surface is what a plane of the same volumes has.
        let kernel = crate::kernel::Kernel::new(d);
        let normal = [-0.5, 0.0, 1.0].map(|n| n / 1.25_f64.sqrt());
        let spots = || (0..49).map(|i| [0.006 * f64::from(i % 7), 0.006 * f64::from(i / 7)]);
        let pull = |height: f64| {
            let one = |[u, v]: [f64; 2]| {
                let at = add([0.4 + u, 0.4 + v, 0.2 + 0.5 * u], scale(normal, height));
                let all = pieces.iter().map(|p| scale(sub(at, p.0), p.1 * kernel.slope(norm(sub(at, p.0)))));
                all.fold([0.0; 3], add)
            };
            scale(spots().map(one).fold([0.0; 3], add), 1.0 / 49.0)
        };
        let flat = |height: f64| {
            let cell = |i: i32| (f64::from(i % 9) - 4.0, f64::from(i / 9 % 9) - 4.0, f64::from(i / 81) + 0.5);
            let one = |[u, v]: [f64; 2]| {
                let all =
                    (0..243).map(cell).map(|(i, j, k)| [i.mul_add(d, u % d), j.mul_add(d, v % d), height + k * d]);
                all.map(|way| kernel.slope(norm(way)) * way[2] * d * d * d).sum::<f64>()
            };
            spots().map(one).sum::<f64>() / 49.0
        };
        for height in [0.5 * d, d] {
            let (found, wanted) = (pull(height), flat(height));
            let along = (0..3).map(|k| found[k] * normal[k]).sum::<f64>();
            println!("{height}: {along}, flat {wanted}, {found:?}");
            // In the mean over places: what is left is that cells cut by a slope are taken as cut across.
            assert!((along / wanted - 1.0).abs() < 0.05, "{along} {wanted}");
        }
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
