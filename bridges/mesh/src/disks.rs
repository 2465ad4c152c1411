//! Points on a surface that keep a distance from each other: so many, or as many as fit.

use cosplat_core::asset::TriangleMesh;
use cosplat_core::boundary::Vec3;
use nalgebra::Vector3;
use std::collections::HashMap;

use crate::cells::{Key, key};
use crate::error::{Fault, MeshError};
use crate::prepare::area;
use crate::random::Random;
use crate::sample::candidates;
use crate::thin::thin;

/// Candidates for each point where their number is given.
const CANDIDATES: usize = 5;
/// Candidates of one round for each square of the distance, where that is given.
const DENSITY: f64 = 4.0;
/// Rounds at most.
const ROUNDS: usize = 16;
/// Rounds end when fewer than this part of the points came in the last one.
const FULL: f64 = 1e-3;
/// Points at most.
const MOST: f64 = 4e6;

/// How many points.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Amount {
    /// So many, as far from each other as sample elimination brings them (Yuksel 2015).
    Count(usize),
    /// As many as fit with at least this distance \[m\] between any two, by throwing darts: about 0.7 times area over
    /// distance², the density at which random disks of that diameter jam.
    Spacing(f64),
}

/// Poisson disks on a surface: positions on its triangles \[m\], the same for the same seed.
///
/// With [`Amount::Count`], points whose normals point apart may lie together, as on both sides of a sheet. With
/// [`Amount::Spacing`] they may not, and nearly every place has a point within the distance.
///
/// # Errors
/// The mesh has no area, or there would be no or too many points.
pub fn poisson_disks(mesh: &TriangleMesh, amount: Amount, seed: u64) -> Result<Vec<Vec3>, MeshError> {
    let areas: Vec<Vector3<f64>> = mesh.triangles.iter().map(|t| area(mesh, *t)).collect();
    let total: f64 = areas.iter().map(Vector3::norm).sum();
    let wanted = match amount {
        Amount::Count(count) => count as f64,
        Amount::Spacing(h) if h > 0.0 => (total / (h * h)).ceil(),
        Amount::Spacing(_) => 0.0,
    };
    if !(total > 0.0 && (1.0..=MOST).contains(&wanted)) {
        let what = format!("{wanted} points are wanted on an area of {total} m²");
        return Err(MeshError::whole(Fault::Spacing, what, format!("ask for 1 to {MOST} points")));
    }
    let mut random = Random::new(seed);
    Ok(match amount {
        Amount::Count(count) => {
            let (points, normals) = candidates(mesh, &areas, CANDIDATES * count, &mut random);
            thin(&points, &normals, total, count).iter().map(|&i| points[i as usize].into()).collect()
        }
        Amount::Spacing(spacing) => {
            let round = (DENSITY * total / (spacing * spacing)).ceil() as usize;
            let mut disks = Disks { spacing, cells: HashMap::new(), points: Vec::new() };
            for _ in 0..ROUNDS {
                let before = disks.points.len();
                let (thrown, _) = candidates(mesh, &areas, round, &mut random);
                for p in thrown {
                    disks.throw(p);
                }
                if ((disks.points.len() - before) as f64) < FULL * disks.points.len() as f64 {
                    break;
                }
            }
            disks.points.iter().map(|p| (*p).into()).collect()
        }
    })
}

/// Points no two of which are nearer than the spacing. The map is only asked, never walked through.
struct Disks {
    spacing: f64,
    cells: HashMap<Key, Vec<u32>>,
    points: Vec<Vector3<f64>>,
}

impl Disks {
    fn throw(&mut self, p: Vector3<f64>) {
        let [x, y, z] = key(&p, self.spacing);
        let taken = (0..27).map(|k| [x + k / 9 - 1, y + k / 3 % 3 - 1, z + k % 3 - 1]).any(|near| {
            let close = |i: &u32| (self.points[*i as usize] - p).norm() < self.spacing;
            self.cells.get(&near).is_some_and(|cell| cell.iter().any(close))
        });
        if !taken {
            self.cells.entry([x, y, z]).or_default().push(self.points.len() as u32);
            self.points.push(p);
        }
    }
}
