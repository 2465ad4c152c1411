//! Sides of the domain: what is beyond them.

use cosplat_core::boundary::Vec3;

use crate::grid::{Faces, Grid};

/// A side of the domain during a substep.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Side {
    /// Nothing passes, everything slides along it.
    Closed,
    /// The ambient air, at the ambient pressure: it comes in as it is out there.
    Open,
    /// The ambient air comes in at its own speed.
    Inlet,
}

/// Lower and upper side along each axis.
pub(crate) type Sides = [[Side; 2]; 3];

/// Sides while the ambient air has that velocity \[m/s\]; `open` says which ones are not closed.
///
/// An open side is an inlet where the wind enters and has a way out opposite to it: there the ambient pressure would
/// leave the speed to what happens inside.
pub(crate) fn sides(open: [[bool; 2]; 3], ambient: Vec3) -> Sides {
    [0, 1, 2].map(|a| {
        [0, 1].map(|end| {
            let inwards = if end == 0 { ambient[a] } else { -ambient[a] };
            match (open[a][end], inwards > 0.0 && open[a][1 - end]) {
                (false, _) => Side::Closed,
                (true, true) => Side::Inlet,
                (true, false) => Side::Open,
            }
        })
    })
}

/// Indices of the faces along `axis` whose velocity is unknown, first and last; faces of walls and inlets are known.
pub(crate) fn free(grid: &Grid, sides: Sides, axis: usize) -> [isize; 2] {
    let n = grid.n[axis] as isize;
    let is_open = |end: usize| isize::from(sides[axis][end] == Side::Open);
    [1 - is_open(0), n - 1 + is_open(1)]
}

/// Numbers of the cells of one layer across `axis`, padding of the other axes included.
fn layer(grid: &Grid, axis: usize, index: isize) -> impl Iterator<Item = usize> + use<> {
    let grid = *grid;
    let [b, c] = [(axis + 1) % 3, (axis + 2) % 3];
    let range = move |k: usize| -2..=grid.n[k] as isize + 2;
    range(c).flat_map(move |w| {
        range(b).map(move |v| {
            let mut cell = [0; 3];
            (cell[axis], cell[b], cell[c]) = (index, v, w);
            grid.at(cell)
        })
    })
}

/// Sets what lies on and beyond the sides of a velocity \[m/s\].
pub(crate) fn pad_velocity(grid: &Grid, sides: Sides, ambient: Vec3, u: &mut Faces) {
    for a in 0..3 {
        let n = grid.n[a] as isize;
        for (end, side) in sides[a].into_iter().enumerate() {
            let (out, step) = if end == 0 { (-1, -1) } else { (n, 1) };
            let wall = if end == 0 { 0 } else { n };
            let s = grid.s[a];
            // Faces across this side: on it, and beyond.
            for at in layer(grid, a, wall) {
                let beyond = |by: usize| if end == 0 { at - by * s } else { at + by * s };
                let within = |by: usize| if end == 0 { at + by * s } else { at - by * s };
                match side {
                    Side::Closed => {
                        u[a][at] = 0.0;
                        (u[a][beyond(1)], u[a][beyond(2)]) = (-u[a][within(1)], -u[a][within(2)]);
                    }
                    Side::Inlet => {
                        u[a][at] = ambient[a];
                        (u[a][beyond(1)], u[a][beyond(2)]) = (ambient[a], ambient[a]);
                    }
                    Side::Open => {
                        let enters = if end == 0 { u[a][at] > 0.0 } else { u[a][at] < 0.0 };
                        let value = if enters { ambient[a] } else { u[a][at] };
                        (u[a][beyond(1)], u[a][beyond(2)]) = (value, value);
                    }
                }
            }
            for b in (0..3).filter(|b| *b != a) {
                for at in layer(grid, a, out) {
                    let (next, within) = if end == 0 { (at - s, at + s) } else { (at + s, at - s) };
                    let within_2 = if end == 0 { at + 2 * s } else { at - 2 * s };
                    let face = if end == 0 { at + s } else { at };
                    let across = u[a][face] * f64::from(step);
                    let (first, second) = match side {
                        Side::Closed => (u[b][within], u[b][within_2]),
                        Side::Open if across >= 0.0 => (u[b][within], u[b][within]),
                        Side::Open | Side::Inlet => (ambient[b], ambient[b]),
                    };
                    (u[b][at], u[b][next]) = (first, second);
                }
            }
        }
    }
}

/// Sets what lies beyond the sides of a concentration: none comes in.
pub(crate) fn pad_field(grid: &Grid, sides: Sides, u: &Faces, c: &mut [f64]) {
    for a in 0..3 {
        let n = grid.n[a] as isize;
        for (end, side) in sides[a].into_iter().enumerate() {
            let s = grid.s[a];
            for at in layer(grid, a, if end == 0 { -1 } else { n }) {
                let (next, within, face) = if end == 0 { (at - s, at + s, at + s) } else { (at + s, at - s, at) };
                let within_2 = if end == 0 { at + 2 * s } else { at - 2 * s };
                let across = if end == 0 { -u[a][face] } else { u[a][face] };
                (c[at], c[next]) = match side {
                    Side::Closed => (c[within], c[within_2]),
                    Side::Open if across >= 0.0 => (c[within], c[within]),
                    Side::Open | Side::Inlet => (0.0, 0.0),
                };
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn wind_enters_where_it_can_leave() {
        let open = [[true, true], [false, true], [true, true]];
        let found = sides(open, [1.0, -2.0, 0.0]);
        assert_eq!(found[0], [Side::Inlet, Side::Open]);
        assert_eq!(found[1], [Side::Closed, Side::Open], "without a way out the pressure decides");
        assert_eq!(found[2], [Side::Open, Side::Open]);
        let grid = Grid::new([0.0; 3], [8; 3], 0.1);
        assert_eq!([0, 1, 2].map(|a| free(&grid, found, a)), [[1, 8], [1, 8], [0, 8]]);
    }
}
