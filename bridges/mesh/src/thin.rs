//! Of many points, those that are farthest from each other.

use std::collections::BTreeSet;

use nalgebra::Vector3;

use crate::cells::Cells;

/// Which of the points stay, ascending, if `count` shall: the one that is most crowded goes, again and again (Yuksel
/// 2015, "Sample Elimination for Generating Poisson Disk Sample Sets", without its weight limiting). Points whose normals
/// point apart do not crowd each other, so that both sides of a sheet are covered.
pub(crate) fn thin(points: &[Vector3<f64>], normals: &[Vector3<f64>], area: f64, count: usize) -> Vec<u32> {
    // Largest radius of `count` disks on that area, in hexagonal order.
    let reach = 2.0 * (area / (2.0 * 3.0_f64.sqrt() * count.max(1) as f64)).sqrt();
    let cells = Cells::new(points, reach);
    let crowding = |i: usize, j: usize| {
        let near = 1.0 - (points[i] - points[j]).norm() / reach;
        if i != j && near > 0.0 && normals[i].dot(&normals[j]) > 0.0 { near.powi(8) } else { 0.0 }
    };
    let of = |i: usize| {
        let mut sum = 0.0;
        cells.around(&points[i], |j| sum += crowding(i, j as usize));
        sum
    };
    let mut weights: Vec<f64> = (0..points.len()).map(of).collect();
    // Bits of numbers that are not negative are ordered as the numbers are.
    let mut order: BTreeSet<(u64, u32)> = weights.iter().enumerate().map(|(i, w)| (w.to_bits(), i as u32)).collect();
    let mut stays = vec![true; points.len()];
    while order.len() > count {
        let Some((_, out)) = order.pop_last() else { break };
        stays[out as usize] = false;
        cells.around(&points[out as usize], |j| {
            let share = crowding(out as usize, j as usize);
            if share > 0.0 && stays[j as usize] {
                let weight = &mut weights[j as usize];
                order.remove(&(weight.to_bits(), j));
                *weight = (*weight - share).max(0.0);
                order.insert((weight.to_bits(), j));
            }
        });
    }
    (0..points.len() as u32).filter(|i| stays[*i as usize]).collect()
}
