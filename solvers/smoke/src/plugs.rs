//! Solids that stand in an inlet close it: no air comes out of a wall.
//!
//! A face of an inlet shares its velocity with the mass on it, as all faces do. What the air outside gives for that is
//! not a force of the gas inside, and nobody's impulse.

use cosplat_core::boundary::Vec3;

use crate::grid::{Faces, Grid};
use crate::sides::{Side, Sides};

/// A face of an inlet with a solid on it.
#[derive(Clone, Copy, Debug)]
struct Plug {
    axis: usize,
    /// Numbers of the face and of the two beyond it.
    at: [usize; 3],
    /// Part of the gas in the mass on the face.
    share: f64,
}

/// All faces of inlets with solids on them.
#[derive(Clone, Debug, Default)]
pub(crate) struct Plugs(Vec<Plug>);

impl Plugs {
    /// Those where the mass ratio of solids is not zero.
    pub(crate) fn find(grid: &Grid, sides: Sides, ratio: &Faces) -> Self {
        let mut found = Vec::new();
        for axis in 0..3 {
            let n = grid.n.map(|n| n as isize);
            let [p, q] = [(axis + 1) % 3, (axis + 2) % 3];
            for (side, [first, way]) in sides[axis].into_iter().zip([[0, -1], [n[axis], 1]]) {
                if side != Side::Inlet {
                    continue;
                }
                for (i, j) in (0..n[q]).flat_map(|j| (0..n[p]).map(move |i| (i, j))) {
                    let at = [0, 1, 2].map(|by| {
                        let mut cell = [0; 3];
                        (cell[axis], cell[p], cell[q]) = (first + by * way, i, j);
                        grid.at(cell)
                    });
                    let mass = ratio[axis][at[0]];
                    if mass > 0.0 {
                        found.push(Plug { axis, at, share: 1.0 / (1.0 + mass) });
                    }
                }
            }
        }
        Self(found)
    }

    /// Sets the velocity of these faces \[m/s\], for a wind and the product of masses and velocities on them \[m/s\].
    pub(crate) fn close(&self, ambient: Vec3, pull: &Faces, u: &mut Faces) {
        for Plug { axis, at, share } in &self.0 {
            let value = share * (ambient[*axis] + pull[*axis][at[0]]);
            for &at in at {
                u[*axis][at] = value;
            }
        }
    }
}
