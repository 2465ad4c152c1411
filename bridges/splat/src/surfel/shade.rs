//! Daylight on bodies that are nothing but particles: a surface is where their density falls.
//!
//! The density stands on nodes two spacings apart, spread linearly; its gradient by central differences, brought back the
//! same way. What lies inside is not seen and gets the light of a face that stands across.

use std::collections::HashMap;

use nalgebra::Vector3;

use super::Light;
use crate::bind::BindError;
use crate::output::OutputFrame;
use crate::splats::{Splats, dc_of_colour};
use crate::surfel::{display_of_linear, dots};

/// Distance of nodes, in units of the spacing.
const CELL: f64 = 2.0;
/// Change of density from node to node, as part of that of a full cell, from which a surface is one: half of what a plane
/// one has.
const SURFACE: f64 = 0.25;

/// [`dots`] in daylight. Positions and spacing \[m\], world; colour linear red, green, blue from 0 to 1.
///
/// # Errors
/// Not as many gradients as positions.
pub fn lit_dots(
    positions_m: &[[f64; 3]],
    gradients: &[[f32; 9]],
    spacing_m: f64,
    linear: [f64; 3],
    light: &Light,
    frame: &OutputFrame,
) -> Result<Splats, BindError> {
    let mut splats = dots(positions_m, gradients, spacing_m, linear, frame)?;
    for (dc, share) in splats.sh_dc.iter_mut().zip(shares(positions_m, spacing_m, light)) {
        *dc = linear.map(|c| dc_of_colour(display_of_linear(c * share)));
    }
    Ok(splats)
}

/// The eight nodes around a particle with their weights; none where its place is not a number.
type Around = Option<[(usize, f64); 8]>;

/// Share of the light that each particle sends back, by Lambert's law.
fn shares(positions: &[[f64; 3]], spacing: f64, light: &Light) -> Vec<f64> {
    let cell = CELL * spacing;
    let mut number = HashMap::new();
    let mut nodes: Vec<[i32; 3]> = Vec::new();
    let mut density: Vec<f64> = Vec::new();
    let mut spread = |p: &[f64; 3]| -> Around {
        let at = p.map(|x| x / cell);
        // Nodes are numbered in 32 bits; what is farther away is not seen.
        if !at.iter().all(|x| x.abs() < 1e9) {
            return None;
        }
        let (low, part) = (at.map(|x| x.floor() as i32), at.map(|x| x - x.floor()));
        Some(std::array::from_fn(|corner| {
            let far = [0, 1, 2].map(|k| corner >> k & 1);
            let node = [0, 1, 2].map(|k| low[k] + far[k] as i32);
            let weight: f64 = (0..3).map(|k| if far[k] == 1 { part[k] } else { 1.0 - part[k] }).product();
            let index = *number.entry(node).or_insert_with(|| {
                nodes.push(node);
                density.push(0.0);
                nodes.len() - 1
            });
            density[index] += weight;
            (index, weight)
        }))
    };
    let around: Vec<Around> = positions.iter().map(&mut spread).collect();
    let at = |node: [i32; 3]| number.get(&node).map_or(0.0, |&i| density[i]);
    let slope = |node: &[i32; 3]| {
        Vector3::from_fn(|k, _| {
            let next = |by: i32| std::array::from_fn(|j| node[j] + if j == k { by } else { 0 });
            0.5 * (at(next(1)) - at(next(-1)))
        })
    };
    let slopes: Vec<Vector3<f64>> = nodes.iter().map(slope).collect();
    let towards = Vector3::from(light.towards).try_normalize(0.0).unwrap_or_else(Vector3::zeros);
    let full = CELL.powi(3);
    let one = |around: &Around| {
        let Some(around) = around else { return 1.0 };
        let out = -around.iter().map(|&(i, w)| slopes[i] * w).sum::<Vector3<f64>>() / full;
        let surface = (out.norm() / SURFACE).min(1.0);
        let facing = out.try_normalize(0.0).map_or(0.0, |n| n.dot(&towards).max(0.0));
        light.ambient + (1.0 - light.ambient) * (surface * facing + (1.0 - surface) * 0.5)
    };
    around.iter().map(one).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_side_towards_the_lamp_is_bright_and_the_other_has_what_comes_from_everywhere() {
        let n = 20;
        let place = |i: usize| [i % n, i / n % n, i / n / n].map(|k| 0.01 * (k as f64 + 0.5));
        let positions: Vec<[f64; 3]> = (0..n * n * n).map(place).collect();
        let light = Light { towards: [0.0, 0.0, 1.0], ambient: 0.4 };
        let shares = shares(&positions, 0.01, &light);
        let of = |x: usize, y: usize, z: usize| shares[(z * n + y) * n + x];
        // In the middle of each side, of the middle, and of a side that the light passes by; the slope of a plane surface
        // is that of a step, whose direction is exact.
        assert!((of(10, 10, 19) - 1.0).abs() < 1e-9 && (of(10, 10, 0) - 0.4).abs() < 1e-9);
        assert!((of(19, 10, 10) - 0.4).abs() < 1e-9 && (of(10, 10, 10) - 0.7).abs() < 1e-9);
        let far = [[f64::NAN, 0.0, 0.0], [1e300, 0.0, 0.0]];
        assert!(super::shares(&far, 0.01, &light).iter().all(|s| (s - 1.0).abs() < 1e-15));
        let splats = lit_dots(&positions, &[], 0.01, [0.5; 3], &light, &OutputFrame::world()).unwrap();
        assert!(splats.sh_dc[(19 * n + 10) * n + 10][0] > splats.sh_dc[10 * n + 10][0]);
    }
}
