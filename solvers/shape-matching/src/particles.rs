//! Particles that fill a shape, and the points of its surface that touch others.

use std::sync::Arc;

use cosplat_core::asset::{Asset, TriangleMesh};
use cosplat_core::distance::{MeshSolid, Shape, SignedDistance};
use cosplat_core::scene::Source;

use crate::{M3, V3};

/// Particles along the longest side of a body without a spacing.
const ALONG: f64 = 10.0;
/// Most particles along a side.
const MOST_ALONG: f64 = 64.0;
/// Most vertices of a mesh that all touch; finer meshes touch with points as far apart as particles.
const MOST_VERTICES: usize = 2048;

/// A shape as particles, in the frame of its source.
#[derive(Clone, Debug)]
pub(crate) struct Particles {
    /// For contact with others; its frame has its origin at `origin`.
    pub(crate) shape: Shape,
    /// Origin of the shape \[m\].
    pub(crate) origin: V3,
    /// Centre of mass \[m\].
    pub(crate) centre: V3,
    /// Σ m q qᵀ / Σ m about the centre of mass \[m²\].
    pub(crate) spread: M3,
    /// Volume \[m³\].
    pub(crate) volume: f64,
    /// Number of particles.
    pub(crate) count: u64,
    /// Points that touch, about the centre of mass, each with a radius around it \[m\].
    pub(crate) points: Vec<(V3, f64)>,
}

impl Particles {
    /// Of a body's source; in words, where it has no volume.
    pub(crate) fn new(source: &Source, asset: Option<&Asset>, spacing: Option<f64>) -> Result<Self, String> {
        let cell = |half: V3| {
            let size = 2.0 * half.max();
            spacing.unwrap_or(size / ALONG).clamp(size / MOST_ALONG, size / 2.0)
        };
        let formula = |half: V3, shape: Shape| Self::fill(shape, V3::zeros(), (-half, half), cell(half), None);
        let sound = |sizes: &[f64]| sizes.iter().all(|s| s.is_finite() && *s > 0.0);
        let empty = || Err("rigid bodies without a size".to_owned());
        match *source {
            Source::Box { size_m } if sound(&size_m) => formula(V3::from(size_m) * 0.5, shape_of(source)?),
            Source::Sphere { radius_m } if sound(&[radius_m]) => {
                let mut ball = formula(V3::repeat(radius_m), shape_of(source)?)?;
                // One point with the radius around it rolls smoothly.
                ball.points = vec![(V3::zeros(), radius_m)];
                Ok(ball)
            }
            Source::Cylinder { radius_m: r, height_m: h } if sound(&[r, h]) => {
                formula(V3::new(r, r, 0.5 * h), shape_of(source)?)
            }
            Source::Mesh { .. } => match asset {
                Some(Asset::Mesh(mesh)) => Self::of_mesh(mesh, cell),
                _ => Err("meshes that were not prepared before the run".to_owned()),
            },
            // Without a size, or of a kind that is refused already.
            _ => empty(),
        }
    }

    fn of_mesh(mesh: &TriangleMesh, cell: impl Fn(V3) -> f64) -> Result<Self, String> {
        let wrong = |e: cosplat_core::asset::AssetError| format!("a mesh that encloses no solid: {e}");
        Asset::Mesh(mesh.clone()).check().map_err(wrong)?;
        let origin = V3::from(mesh.solid().map_err(wrong)?.centroid_m);
        let about = || mesh.vertices_m.iter().map(|&v| V3::from(v) - origin);
        let (low, high) = about().fold((V3::repeat(f64::INFINITY), V3::repeat(f64::NEG_INFINITY)), |(low, high), v| {
            (low.inf(&v), high.sup(&v))
        });
        let cell = cell((high - low) * 0.5);
        let solid = MeshSolid::new(mesh, origin.into(), cell).map_err(wrong)?;
        let vertices = (mesh.vertices_m.len() <= MOST_VERTICES).then(|| about().collect());
        Self::fill(Shape::Mesh(Arc::new(solid)), origin, (low, high), cell, vertices)
    }

    /// Cells of a box around a shape; a cell that the surface cuts counts by the part that is inside.
    fn fill(
        shape: Shape,
        origin: V3,
        (low, high): (V3, V3),
        cell: f64,
        vertices: Option<Vec<V3>>,
    ) -> Result<Self, String> {
        // A whole number of cells must not become one more by rounding.
        let cells = (high - low).map(|l| (l / cell - 1e-9).ceil().max(2.0));
        let size = (high - low).component_div(&cells);
        let [nx, ny, nz] = [cells.x, cells.y, cells.z].map(|n| n as i32);
        let (mut inside, mut points) = (Vec::new(), Vec::new());
        for (i, j, k) in (-1..=nx).flat_map(|i| (-1..=ny).flat_map(move |j| (-1..=nz).map(move |k| (i, j, k)))) {
            let at = low + size.component_mul(&(V3::new(i.into(), j.into(), k.into()).add_scalar(0.5)));
            let (distance, normal) = shape.distance(at.into());
            // Width of the cell across the surface.
            let width = V3::from(normal).abs().dot(&size);
            let weight = (0.5 - distance / width).clamp(0.0, 1.0);
            if weight > 0.0 && (0..nx).contains(&i) && (0..ny).contains(&j) && (0..nz).contains(&k) {
                inside.push((at, weight));
            }
            // What lies just outside shows a point of the surface: of faces, of edges, and every corner.
            if distance > 0.0 && distance < size.norm() {
                points.push(onto(&shape, at));
            }
        }
        let total: f64 = inside.iter().map(|(_, w)| w).sum();
        if total <= 0.0 {
            return Err("rigid bodies thinner than a particle: give a smaller `spacing`".to_owned());
        }
        let centre = inside.iter().map(|(x, w)| x * *w).sum::<V3>() / total;
        let spread = inside.iter().map(|(x, w)| (x - centre) * (x - centre).transpose() * *w).sum::<M3>() / total;
        let points = vertices.unwrap_or(points).into_iter().map(|p| (p - centre, 0.0)).collect();
        let volume = total * size.x * size.y * size.z;
        Ok(Self { shape, origin, centre: centre + origin, spread, volume, count: inside.len() as u64, points })
    }
}

fn shape_of(source: &Source) -> Result<Shape, String> {
    Shape::of(source).ok_or_else(|| "shapes without a formula".to_owned())
}

/// Nearest point of the surface; a cached distance needs more than one step.
fn onto(shape: &Shape, mut at: V3) -> V3 {
    for _ in 0..3 {
        let (distance, normal) = shape.distance(at.into());
        at -= V3::from(normal) * distance;
    }
    at
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_box_and_a_ball_have_their_volume_and_moments() {
        let size_m = [0.1, 0.2, 0.3];
        let found = Particles::new(&Source::Box { size_m }, None, Some(0.025)).expect("a box");
        assert!((found.volume - 0.006).abs() < 1e-15 && found.centre.norm() < 1e-15);
        for (k, n) in [4.0, 8.0, 12.0].into_iter().enumerate() {
            // Cells in their middles have (1 - 1/n²) of the second moment.
            let exact = size_m[k] * size_m[k] / 12.0 * (1.0 - 1.0 / (n * n));
            assert!((found.spread[(k, k)] / exact - 1.0).abs() < 1e-12, "{k}");
        }
        let corner = |p: &(V3, f64)| (0..3).all(|k| (p.0[k].abs() - 0.5 * size_m[k]).abs() < 1e-12);
        assert_eq!(found.points.iter().filter(|p| corner(p)).count(), 8);
        let errors = [0.02, 0.01].map(|spacing| {
            let ball = Particles::new(&Source::Sphere { radius_m: 0.1 }, None, Some(spacing)).expect("a ball");
            let volume = 4.0 / 3.0 * std::f64::consts::PI * 1e-3;
            [ball.volume / volume - 1.0, ball.spread[(0, 0)] / 0.002 - 1.0].map(f64::abs)
        });
        println!("{errors:?}");
        for k in 0..2 {
            // Second order in cells of a fifth and a tenth of the radius: 4 % and 1 %, times a factor near one.
            assert!(errors[0][k] < 0.06 && errors[1][k] < 0.015, "{errors:?}");
        }
    }
}
