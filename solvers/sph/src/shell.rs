//! Boundary particles of solids: a lattice below the surface, as deep as the kernel reaches, so that a wall continues the
//! liquid's own lattice (Adami, Hu and Adams, "A generalized wall boundary condition for smoothed particle
//! hydrodynamics", 2012).
//!
//! A cell that the surface cuts keeps the share of its volume that lies inside, in the middle of that share: the volume
//! of a solid, and so its buoyancy, does not depend on where the lattice lies.

use cosplat_core::boundary::{Vec3, add, scale};

use crate::shape::Shape;

/// Cells looked at above which a spacing is refused as too fine for a solid.
const MOST_CELLS: f64 = 1e8;
/// Shares of a cell below which it is left out.
const LEAST_SHARE: f64 = 0.05;

/// A place below a surface and the volume that it stands for \[m, m³\].
pub(crate) type Piece = (Vec3, f64);

/// What a cell of the lattice, its middle at that signed distance along `normal`, has inside.
pub(crate) fn piece(x: Vec3, distance: f64, normal: impl FnOnce() -> Vec3, spacing: f64) -> Option<Piece> {
    let share = (0.5 - distance / spacing).clamp(0.0, 1.0);
    let whole = spacing * spacing * spacing;
    if share >= 1.0 {
        return Some((x, whole));
    }
    let moved = || add(x, scale(normal(), -0.5 * share * spacing - distance));
    (share >= LEAST_SHARE).then(|| (moved(), share * whole))
}

/// Boundary particles of a shape that is not a plane, in its own frame; `Err` in words.
pub(crate) fn shell(shape: &Shape, spacing: f64, depth: f64) -> Result<Vec<Piece>, String> {
    let half = shape.half().unwrap_or_default();
    // A box is filled exactly; the lattice of the others begins outside.
    let fits = matches!(shape, Shape::Box(_));
    let count = half.map(|h| (2.0 * h / spacing).round().max(1.0) + if fits { 0.0 } else { 2.0 });
    if count.iter().product::<f64>() > MOST_CELLS {
        return Err(format!("a solid of more than {MOST_CELLS:.0e} cells at a spacing of {spacing} m"));
    }
    let step = if fits { [0, 1, 2].map(|k| 2.0 * half[k] / count[k]) } else { [spacing; 3] };
    let at = |k: usize, i: usize| (i as f64 + 0.5 - 0.5 * count[k]) * step[k];
    let mut pieces = Vec::new();
    for i in 0..count[0] as usize {
        for j in 0..count[1] as usize {
            for k in 0..count[2] as usize {
                let x = [at(0, i), at(1, j), at(2, k)];
                let distance = shape.distance(x);
                if distance <= -depth {
                    continue;
                }
                if fits {
                    pieces.push((x, step[0] * step[1] * step[2]));
                } else {
                    pieces.extend(piece(x, distance, || shape.normal(x, 1e-3 * spacing), spacing));
                }
            }
        }
    }
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
            if plane.distance(x).is_finite() {
                pieces.push((x, spacing * spacing * spacing));
            }
        }
    }
    pieces
}

#[cfg(test)]
mod tests {
    use super::*;

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
            assert!(pieces.iter().all(|p| shape.distance(p.0) < -0.02 * d));
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
