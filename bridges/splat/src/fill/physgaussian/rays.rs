//! Which cells are inside, by what rays along the axes meet.

/// A direction along an axis, as the method numbers them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Direction {
    /// +x.
    Right,
    /// −x.
    Left,
    /// +y.
    Forward,
    /// −y.
    Back,
    /// +z.
    Up,
    /// −z.
    Down,
}

impl Direction {
    /// In the order of their numbers.
    pub const ALL: [Direction; 6] =
        [Direction::Right, Direction::Left, Direction::Forward, Direction::Back, Direction::Up, Direction::Down];

    /// Axis, and whether it is followed towards larger numbers.
    fn axis(self) -> (usize, bool) {
        match self {
            Direction::Right => (0, true),
            Direction::Left => (0, false),
            Direction::Forward => (1, true),
            Direction::Back => (1, false),
            Direction::Up => (2, true),
            Direction::Down => (2, false),
        }
    }
}

/// Calls `step` with each cell and its neighbour in a direction, from the far end of every line on.
fn along(size: [usize; 3], direction: Direction, mut step: impl FnMut(usize, usize)) {
    let (axis, positive) = direction.axis();
    let stride = [1, size[0], size[0] * size[1]][axis];
    let count = size.iter().product();
    let place = |i: usize| i / stride % size[axis];
    if positive {
        (0..count).rev().filter(|&i| place(i) + 1 < size[axis]).for_each(|i| step(i, i + stride));
    } else {
        (0..count).filter(|&i| place(i) > 0).for_each(|i| step(i, i - stride));
    }
}

/// Cells from which a ray meets a dense cell in every direction but one, and goes an odd number of times from a cell that
/// is not dense to one that is in another.
pub(super) fn enclosed(dense: &[bool], size: [usize; 3], except: Direction, parity: Direction) -> Vec<bool> {
    let mut inside = vec![true; dense.len()];
    let mut met = vec![false; dense.len()];
    for direction in Direction::ALL.into_iter().filter(|d| *d != except) {
        met.fill(false);
        along(size, direction, |i, next| met[i] = dense[next] || met[next]);
        inside.iter_mut().zip(&met).for_each(|(inside, met)| *inside &= met);
    }
    met.fill(false);
    along(size, parity, |i, next| met[i] = met[next] != (!dense[i] && dense[next]));
    inside.iter_mut().zip(&met).for_each(|(inside, odd)| *inside &= odd);
    inside
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A hollow box of 5 cells in 7, with a second wall above.
    #[test]
    fn rays_tell_inside_from_outside_and_parity_fails_under_a_second_roof() {
        let size = [7, 7, 9];
        let at = |i: usize| [i % 7, i / 7 % 7, i / 49];
        let wall = |c: [usize; 3]| c.iter().all(|v| (1..=5).contains(v)) && c.iter().any(|v| *v == 1 || *v == 5);
        let cells: Vec<[usize; 3]> = (0..7 * 7 * 9).map(at).collect();
        let closed: Vec<bool> = cells.iter().map(|c| wall(*c)).collect();
        let within = |c: &[usize; 3]| c.iter().all(|v| (2..=4).contains(v));
        let inside = enclosed(&closed, size, Direction::Down, Direction::Up);
        let empty = |c: &[usize; 3]| !wall(*c);
        assert!(cells.iter().zip(&inside).filter(|(c, _)| empty(c)).all(|(c, inside)| *inside == within(c)));
        // Without its bottom it is the same: that side is not asked.
        let open: Vec<bool> = cells.iter().map(|c| wall(*c) && c[2] != 1).collect();
        let inside = enclosed(&open, size, Direction::Down, Direction::Up);
        assert!(cells.iter().zip(&inside).all(|(c, inside)| !within(c) || *inside));
        // Two roofs are an even number of them.
        let roofed: Vec<bool> = cells.iter().map(|c| wall(*c) || c[2] == 7).collect();
        let inside = enclosed(&roofed, size, Direction::Down, Direction::Up);
        assert!(cells.iter().zip(&inside).all(|(c, inside)| !within(c) || !*inside));
    }
}
