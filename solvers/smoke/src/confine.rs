//! Vorticity confinement: gives back the swirl that a grid smears out (Fedkiw, Stam and Jensen 2001).
//!
//! `a = ε h N × ω`, `N = ∇|ω| / |∇|ω||`; ε is a rate \[1/s\]. It is a force from outside and is booked as one.

use cosplat_core::boundary::{Vec3, cross, norm, scale};

use crate::grid::{Faces, Grid};

/// Curl in the middle of a cell from the velocities around it \[1/s\].
fn curl(grid: &Grid, u: &Faces, at: usize) -> Vec3 {
    let middle = |a: usize, at: usize| 0.5 * (u[a][at] + u[a][at + grid.s[a]]);
    let slope = |a: usize, b: usize| (middle(a, at + grid.s[b]) - middle(a, at - grid.s[b])) / (2.0 * grid.h);
    [slope(2, 1) - slope(1, 2), slope(0, 2) - slope(2, 0), slope(1, 0) - slope(0, 1)]
}

/// Accelerations on the lower faces of all cells \[m/s²\]: half of each of the two cells'. Those of the outermost cells
/// are none.
pub(crate) fn confine(grid: &Grid, u: &Faces, rate: f64) -> Faces {
    let mut out = grid.faces();
    let mut swirl = vec![[0.0; 3]; grid.size];
    let n = grid.n.map(|n| n as isize);
    let mut cells = |by: isize, each: &mut dyn FnMut(usize, &mut [Vec3])| {
        for z in by..n[2] - by {
            for y in by..n[1] - by {
                for x in by..n[0] - by {
                    each(grid.at([x, y, z]), &mut swirl);
                }
            }
        }
    };
    cells(0, &mut |at, swirl| swirl[at] = curl(grid, u, at));
    cells(1, &mut |at, swirl| {
        let size = |at: usize| norm(swirl[at]);
        let steep = grid.s.map(|s| size(at + s) - size(at - s));
        let length = norm(steep);
        // Where nothing is to be told apart there is nothing to confine.
        if length <= 1e-12 * size(at) || length == 0.0 {
            return;
        }
        let push = scale(cross(scale(steep, 1.0 / length), swirl[at]), rate * grid.h);
        for a in 0..3 {
            out[a][at] += 0.5 * push[a];
            out[a][at + grid.s[a]] += 0.5 * push[a];
        }
    });
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_vortex_is_turned_faster_and_a_uniform_stream_left_alone() {
        let grid = Grid::new([-0.5, -0.5, 0.0], [16, 16, 8], 1.0 / 16.0);
        let mut u = grid.faces();
        for k in -2..10 {
            for j in -2..18 {
                for i in -2..18 {
                    for (a, u) in u.iter_mut().take(2).enumerate() {
                        let x = grid.face(a, [i, j, k]);
                        let whirl = (-(x[0] * x[0] + x[1] * x[1]) / 0.04).exp();
                        u[grid.at([i, j, k])] = if a == 0 { -x[1] * whirl } else { x[0] * whirl };
                    }
                }
            }
        }
        let push = confine(&grid, &u, 1.0);
        // It works for the swirl, which is what it is there for.
        let power: f64 = (0..2).map(|a| push[a].iter().zip(&u[a]).map(|(f, u)| f * u).sum::<f64>()).sum();
        assert!(power > 0.0, "{power}");
        let still = confine(&grid, &[grid.field(), grid.field(), grid.field()], 1.0);
        assert!(still.iter().flatten().all(|f| *f == 0.0));
    }
}
