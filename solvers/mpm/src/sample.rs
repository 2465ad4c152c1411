//! Bodies as particles: lattices that fill a shape exactly, prepared clouds, and the particles at the surface.

use std::collections::BTreeMap;

use cosplat_core::asset::ParticleCloud;
use cosplat_core::boundary::{add, norm, scale, sub};
use cosplat_core::scene::{Body, Source};

use cosplat_core::distance::{Shape, SignedDistance};

/// A body's particles in its own frame.
#[derive(Clone, Debug, Default)]
pub(crate) struct Sampled {
    /// Places \[m\].
    pub(crate) points: Vec<[f64; 3]>,
    /// Volume of each \[m³\].
    pub(crate) volumes: Vec<f64>,
    /// Particles at the surface with their outward normals.
    pub(crate) surface: Vec<(usize, [f64; 3])>,
    /// Area of the surface \[m²\].
    pub(crate) area: f64,
}

/// Smallest extent of a source \[m\], where it has one.
pub(crate) fn extent(source: &Source) -> Option<f64> {
    let least = |size: &[f64; 3]| size.iter().copied().fold(f64::INFINITY, f64::min);
    match source {
        Source::Box { size_m } | Source::Cloud { size_m, .. } => Some(least(size_m)),
        Source::Sphere { radius_m } => Some(2.0 * radius_m),
        Source::Cylinder { radius_m, height_m } => Some(height_m.min(2.0 * radius_m)),
        _ => None,
    }
}

/// Samples a body with that spacing. `Err` names what cannot be sampled.
pub(crate) fn sample(body: &Body, spacing: f64) -> Result<Sampled, String> {
    let mut sampled = match &body.source {
        Source::Points { positions_m } => {
            let each = spacing * spacing * spacing * positions_m.len() as f64;
            let volume = body.mass_kg.zip(body.material.density()).map_or(each, |(mass, density)| mass / density);
            listed(positions_m, spacing, volume)
        }
        Source::Cloud { count, size_m } => cloud(*count, *size_m),
        source => match Shape::of(source) {
            None | Some(Shape::Plane(_)) => return Err(format!("its source (body `{}`)", body.name)),
            Some(shape) => fill(&shape, spacing),
        },
    };
    if sampled.points.is_empty() {
        // No particle at all would leave a body without mass.
        sampled.points.push([0.0; 3]);
        sampled.volumes = vec![spacing * spacing * spacing];
        sampled.surface.push((0, [0.0, 0.0, 1.0]));
    }
    Ok(sampled)
}

/// Particles that were prepared; `shown` says whether anybody asks for the surface.
pub(crate) fn prepared(cloud: &ParticleCloud, shown: bool) -> Sampled {
    let (points, volumes) = (cloud.position_m.clone(), cloud.volume_m3.clone());
    let filled = scale_all(&volumes, cloud.spacing_m.powi(-3));
    let surface = if shown { surface(&points, &filled, cloud.spacing_m) } else { Vec::new() };
    let area = surface.len() as f64 * cloud.spacing_m * cloud.spacing_m;
    Sampled { points, volumes, surface, area }
}

fn scale_all(values: &[f64], factor: f64) -> Vec<f64> {
    values.iter().map(|v| v * factor).collect()
}

fn equal(volume: f64, count: usize) -> Vec<f64> {
    vec![volume / count.max(1) as f64; count]
}

/// Middles of `n` equal parts of an edge.
fn middles(edge: f64, n: usize) -> impl Iterator<Item = f64> + Clone {
    (0..n).map(move |i| edge * ((i as f64 + 0.5) / n as f64 - 0.5))
}

fn parts(edge: f64, spacing: f64) -> usize {
    ((edge / spacing).round() as usize).max(1)
}

fn lattice(size: [f64; 3], n: [usize; 3]) -> Vec<[f64; 3]> {
    let (ys, zs) = (middles(size[1], n[1]), middles(size[2], n[2]));
    middles(size[0], n[0])
        .flat_map(|x| {
            ys.clone().flat_map({
                let zs = zs.clone();
                move |y| zs.clone().map(move |z| [x, y, z])
            })
        })
        .collect()
}

fn fill(shape: &Shape, spacing: f64) -> Sampled {
    let pi = std::f64::consts::PI;
    let (size, volume, area) = match *shape {
        Shape::Box(half) => {
            let [a, b, c] = scale(half, 2.0);
            ([a, b, c], a * b * c, 2.0 * (a * b + b * c + c * a))
        }
        Shape::Sphere(r) => ([2.0 * r; 3], 4.0 / 3.0 * pi * r * r * r, 4.0 * pi * r * r),
        Shape::Cylinder(r, half) => {
            ([2.0 * r, 2.0 * r, 2.0 * half], 2.0 * pi * r * r * half, 2.0 * pi * r * (r + 2.0 * half))
        }
        Shape::Plane(_) | Shape::Mesh(_) | Shape::HeightField(_) => ([0.0; 3], 0.0, 0.0),
    };
    let n = size.map(|edge| parts(edge, spacing));
    let step = (0..3).map(|k| size[k] / n[k] as f64).fold(0.0, f64::max);
    let mut points = lattice(size, n);
    points.retain(|&x| shape.distance(x).0 <= 1e-9 * step);
    if points.is_empty() {
        // Smaller than the lattice: one particle in the middle.
        points.push([0.0; 3]);
    }
    let surface = points.iter().enumerate().filter_map(|(i, &x)| {
        let (d, normal) = shape.distance(x);
        (d > -step * (1.0 - 1e-9)).then_some((i, normal))
    });
    Sampled { surface: surface.collect(), volumes: equal(volume, points.len()), points, area }
}

fn cloud(count: usize, size: [f64; 3]) -> Sampled {
    let volume = size[0] * size[1] * size[2];
    let edge = (volume / count.max(1) as f64).cbrt();
    let mut n = size.map(|s| parts(s, edge));
    while n[0] * n[1] * n[2] < count {
        let coarsest = (1..3).fold(0, |a, k| if size[k] / n[k] as f64 > size[a] / n[a] as f64 { k } else { a });
        n[coarsest] += 1;
    }
    let mut all = lattice(size, n);
    all.truncate(count);
    listed(&all, (volume / count.max(1) as f64).cbrt(), volume)
}

/// Points of the same volume.
fn listed(all: &[[f64; 3]], spacing: f64, volume: f64) -> Sampled {
    let surface = surface(all, &vec![1.0; all.len()], spacing);
    let area = surface.len() as f64 * spacing * spacing;
    Sampled { points: all.to_vec(), volumes: equal(volume, all.len()), area, surface }
}

/// Points within about one spacing of the surface, with outward normals: those whose neighbours lie to one side, and
/// those with fewer neighbours than inside. `filled` is the volume of each over spacing³.
///
/// Within 1.8 spacings a lattice has 27 points inside, 18 from a face, 12 from an edge: 0.8 × 27 is between the first two.
/// The sheet of a leaf has neighbours on both sides and too few; its normals are those of neither side (z).
fn surface(all: &[[f64; 3]], filled: &[f64], spacing: f64) -> Vec<(usize, [f64; 3])> {
    let reach = 1.8 * spacing;
    let cell = |x: [f64; 3]| x.map(|x| (x / reach).floor() as i64);
    let mut cells: BTreeMap<[i64; 3], Vec<usize>> = BTreeMap::new();
    for (i, &x) in all.iter().enumerate() {
        cells.entry(cell(x)).or_default().push(i);
    }
    let one = |(i, &x): (usize, &[f64; 3])| {
        let (at, mut away, mut around, mut here) = (cell(x), [0.0; 3], 0.0_f64, filled[i]);
        for k in 0..27 {
            let near = [at[0] + k / 9 - 1, at[1] + k / 3 % 3 - 1, at[2] + k % 3 - 1];
            for &j in cells.get(&near).into_iter().flatten().filter(|&&j| j != i) {
                let d = sub(x, all[j]);
                if norm(d) < reach {
                    (away, around) = (add(away, scale(d, filled[j])), around + filled[j]);
                }
            }
        }
        here += around;
        let lean = norm(away) / (around.max(f64::MIN_POSITIVE) * spacing);
        let normal = if lean > 1e-6 { scale(away, 1.0 / norm(away)) } else { [0.0, 0.0, 1.0] };
        (lean > 0.2 || here < 0.8 * 27.0).then_some((i, normal))
    };
    all.iter().enumerate().filter_map(one).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_prepared_block_has_one_layer_of_surface_and_a_sheet_is_all_surface() {
        let spacing_m = 0.01;
        let block = |n: [usize; 3]| {
            let position_m = lattice(n.map(|n| n as f64 * spacing_m), n);
            let volume_m3 = vec![spacing_m.powi(3); position_m.len()];
            prepared(&ParticleCloud { spacing_m, position_m, volume_m3 }, true)
        };
        let cube = block([8; 3]);
        assert_eq!(cube.surface.len(), 8 * 8 * 8 - 6 * 6 * 6);
        let on_top = |i: usize| cube.points[i].map(|x| x > 0.034) == [false, false, true];
        let top = cube.surface.iter().filter(|(i, _)| on_top(*i) && cube.points[*i].iter().all(|x| x > &-0.034));
        assert!(top.clone().count() > 20 && top.clone().all(|(_, n)| n[2] > 0.99));
        assert_eq!(block([10, 10, 1]).surface.len(), 100);
    }
}
