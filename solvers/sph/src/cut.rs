//! Liquid that would start where partners are: as much of it is left out as they take.
//!
//! Each cell of the liquid has a share inside the partner. Left out are the cells that lie deepest, as many as these shares add
//! up to, so that what remains fills the room that remains: cells left out by the places of their middles alone leave a gap
//! or an overlap around a small solid, which lifts it wrongly.

use cosplat_core::boundary::Vec3;
use cosplat_core::distance::{Placed, SignedDistance};

use crate::shell::{CORNER, inside};

/// Depths that differ by less than this share of a cell are the same.
const SAME: f64 = 1e-6;

/// Takes from cells, their middles \[m\] and volumes \[m³\], those that a solid takes; how many.
///
/// Of cells that lie equally deep those go first whose numbers come first with their bits reversed: they lie scattered, where
/// the first ones would all lie on one side.
pub(crate) fn cut(solid: &Placed, cells: &mut Vec<(Vec3, f64)>) -> usize {
    let (mut near, mut left) = (Vec::new(), 0.0);
    for (i, &(x, volume)) in cells.iter().enumerate() {
        let width = volume.cbrt();
        if solid.at_least(x, CORNER * width) > 0.0 {
            continue;
        }
        let above = solid.distance(x).0;
        if above < CORNER * width {
            left += volume * inside(solid, x, width, above).0;
            near.push(((above / width / SAME).round() as i64, (i as u32).reverse_bits(), i));
        }
    }
    near.sort_unstable();
    let mut stays = vec![true; cells.len()];
    for (.., i) in near {
        if cells[i].1 >= 2.0 * left {
            break;
        }
        (stays[i], left) = (false, left - cells[i].1);
    }
    let before = cells.len();
    let mut stays = stays.into_iter();
    cells.retain(|_| stays.next().unwrap_or(true));
    before - cells.len()
}

#[cfg(test)]
mod tests {
    use super::*;
    use cosplat_core::boundary::{add, scale};
    use cosplat_core::distance::Shape;

    const D: f64 = 0.01;

    fn lattice(n: usize) -> Vec<(Vec3, f64)> {
        let at = |i: usize| [i % n, i / n % n, i / n / n].map(|i| (i as f64 + 0.5) * D);
        (0..n * n * n).map(|i| (at(i), D * D * D)).collect()
    }

    /// Cells that a shape takes, and their volume.
    fn by(shape: Shape, at: Vec3) -> (Vec<Vec3>, f64) {
        let (all, mut cells) = (lattice(20), lattice(20));
        let count = cut(&Placed::new(shape, at, [0.0, 0.0, 0.0, 1.0]), &mut cells);
        let mut stays = cells.into_iter().peekable();
        let gone = all.into_iter().filter(|cell| stays.next_if_eq(cell).is_none());
        (gone.map(|cell| cell.0).collect(), count as f64 * D * D * D)
    }

    #[test]
    fn what_is_left_out_has_the_volume_and_the_middle_of_the_solid_wherever_it_is() {
        for off in [[0.0; 3], [0.5 * D; 3], [0.23 * D, 0.41 * D, 0.07 * D]] {
            for radius in [3.0 * D, 5.2 * D] {
                let at = add([0.1; 3], off);
                let (gone, volume) = by(Shape::Sphere(radius), at);
                let exact = 4.0 / 3.0 * std::f64::consts::PI * radius.powi(3);
                let middle = scale(gone.iter().copied().fold([0.0; 3], add), 1.0 / gone.len() as f64);
                println!("{off:?} {radius}: {} cells, {volume} of {exact}, {middle:?}", gone.len());
                // Whole cells; and parts of a quarter of a spacing, in the second order of their width over the radius.
                let parts = exact * (0.25 * D / radius).powi(2);
                assert!((volume - exact).abs() < parts + 0.5 * D * D * D, "{volume} {exact}");
                // A dozen of two dozen cells that lie equally deep, as if at random: √12 R/√3 over all, 0.06 d; three times that.
                assert!((0..3).all(|k| (middle[k] - at[k]).abs() < 0.18 * D), "{middle:?} {at:?}");
            }
        }
    }

    #[test]
    fn a_box_on_the_lattice_takes_its_cells_and_one_between_takes_as_many() {
        let half = [0.03, 0.04, 0.05];
        let shape = || Shape::Box(half);
        let (gone, _) = by(shape(), [0.1; 3]);
        assert_eq!(gone.len(), 6 * 8 * 10);
        assert!(gone.iter().all(|x| (0..3).all(|k| (x[k] - 0.1).abs() < half[k])));
        let (gone, _) = by(shape(), [0.1025, 0.1, 0.1]);
        assert_eq!(gone.len(), 6 * 8 * 10);
        assert!(by(shape(), [9.0; 3]).0.is_empty());
    }

    #[test]
    fn of_a_face_that_cuts_cells_in_two_every_other_cell_goes() {
        // The lower half of the block is solid, up to the middles of a layer.
        let (gone, _) = by(Shape::Box([0.2, 0.2, 0.095]), [0.1, 0.1, 0.0]);
        let layer: Vec<&Vec3> = gone.iter().filter(|x| (x[2] - 0.095).abs() < 1e-9).collect();
        assert_eq!((gone.len(), layer.len()), (9 * 400 + 200, 200));
        let left = layer.iter().filter(|x| x[0] < 0.1).count();
        let near = layer.iter().filter(|x| x[1] < 0.1).count();
        assert!((90..=110).contains(&left) && (90..=110).contains(&near), "{left} {near}");
    }
}
