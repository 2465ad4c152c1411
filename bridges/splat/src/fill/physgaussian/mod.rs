//! Filling as `PhysGaussian` does (Xie et al. 2024, equation 11, and the program that was published with it), for comparison.
//!
//! 1. Every Gaussian is spread over the cells within one standard deviation: the density field.
//! 2. Cells denser than a threshold that hold fewer particles than wanted get more, at random: the shell.
//! 3. Empty cells get particles if rays along the axes meet dense cells in all directions but one, and if a ray in a given
//!    direction enters dense cells an odd number of times.
//! 4. What was put has the attributes of the nearest Gaussian, its covariance among them. (The paper says a sphere of the
//!    particle's volume; the program copies.)
//!
//! Differences: a Gaussian reaches at most an eighth of the lattice, because one needle could take hours otherwise; places
//! depend on the cell and a seed alone; the nearest Gaussian is found by a grid. Smoothing of the field is left out, as
//! it is by default.

mod density;
mod rays;

use cosplat_core::sim::Random;

pub use rays::Direction;

use self::density::{Lattice, density};
use super::FillError;
use crate::grid::Grid;
use crate::splats::Splats;

/// Cells of the lattice at most.
const MOST_CELLS: f64 = 1e8;

/// How a body is filled. Defaults are those of the published program.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// Edge of a cell, in units of the splats: a quarter of a cell of the solver's grid.
    pub cell: f64,
    /// Cells denser than this are shell.
    pub density: f32,
    /// Rays are stopped by cells denser than this.
    pub search: f32,
    /// Particles of a cell.
    pub per_cell: usize,
    /// Particles at most, in all.
    pub most: usize,
    /// Direction in which no wall is needed.
    pub except: Direction,
    /// Direction in which walls are counted.
    pub parity: Direction,
    /// Of the random places.
    pub seed: u64,
}

impl Settings {
    /// Thresholds 5 and 3, one particle a cell, at most two millions; no wall is needed below, walls are counted above.
    pub fn new(cell: f64) -> Settings {
        Settings {
            cell,
            density: 5.0,
            search: 3.0,
            per_cell: 1,
            most: 2_000_000,
            except: Direction::Down,
            parity: Direction::Up,
            seed: 0,
        }
    }
}

/// What was put.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Filling {
    /// Places: of the shell first, then inside, each by z, then y, then x.
    pub positions: Vec<[f32; 3]>,
    /// The Gaussian whose attributes each has.
    pub kernels: Vec<u32>,
    /// How many are of the shell.
    pub shell: usize,
    /// How many more there would be without [`Settings::most`].
    pub left_out: usize,
    /// Volume of the cells that are inside.
    pub inside_volume: f64,
    /// Gaussians that would have reached farther than they may.
    pub cut: usize,
}

/// Fills the inside. Every number of the Gaussians must be finite, see [`crate::clean`].
///
/// # Errors
/// The cell does not fit, or there is no Gaussian.
pub fn fill(splats: &Splats, settings: &Settings) -> Result<Filling, FillError> {
    if !(settings.cell.is_finite() && settings.cell > 0.0) {
        return Err(FillError::Spacing);
    }
    if splats.is_empty() {
        return Err(FillError::NoSurface(0));
    }
    let lattice = Lattice::around(splats, settings.cell);
    if lattice.cells() > MOST_CELLS {
        return Err(FillError::TooFine(settings.cell, lattice.cells()));
    }
    let (field, cut) = density(splats, &lattice);
    let mut held = vec![0_usize; field.len()];
    for p in &splats.positions {
        held[lattice.index(lattice.cell_of(crate::linalg::wide(*p)))] += 1;
    }
    let mut filling = Filling { cut, ..Filling::default() };
    for i in 0..held.len() {
        if field[i] > settings.density && held[i] < settings.per_cell {
            filling.put(&lattice, i, held[i]..settings.per_cell, settings);
            held[i] = settings.per_cell;
        }
    }
    filling.shell = filling.positions.len();
    let dense: Vec<bool> = field.iter().map(|d| *d > settings.search).collect();
    let inside = rays::enclosed(&dense, lattice.size, settings.except, settings.parity);
    for i in (0..held.len()).filter(|&i| held[i] == 0 && inside[i]) {
        filling.put(&lattice, i, 0..settings.per_cell, settings);
        filling.inside_volume += settings.cell.powi(3);
    }
    let grid = Grid::new(&splats.positions);
    let mut found = Vec::new();
    for p in &filling.positions {
        grid.nearest(crate::linalg::wide(*p), 1, &mut found);
        filling.kernels.push(found.first().map_or(0, |n| n.1));
    }
    Ok(filling)
}

impl Filling {
    /// Puts particles of these numbers into a cell.
    fn put(&mut self, lattice: &Lattice, index: usize, numbers: std::ops::Range<usize>, settings: &Settings) {
        for number in numbers {
            if self.positions.len() >= settings.most {
                self.left_out += 1;
                continue;
            }
            let stream = (index * settings.per_cell + number) as u64;
            let mut random = Random::new(Random::new(settings.seed ^ stream).bits());
            let parts = [0; 3].map(|_| (random.bits() >> 11) as f64 / (1_u64 << 53) as f64);
            self.positions.push(lattice.point(index, parts).map(|v| v as f32).into());
        }
    }
}
