//! The side on which a body stands and which no camera saw.

/// Share of the points that may lie below the ground: stray ones.
const STRAY: f64 = 0.005;
/// Height of the slice whose outline is closed, in cells.
const SLICE: f32 = 6.0;
/// Free cells around the outline.
const BORDER: usize = 2;

#[derive(Clone, Copy, PartialEq, Eq)]
enum State {
    Unknown,
    Outline,
    Outside,
}

/// Points of a lattice of that cell over everything that the lowest slice of a body encloses, at its lowest height.
///
/// The slice is looked at from above: cells with points, widened by two so that gaps close, stop a flood from outside.
/// What the flood does not reach is underside, the widening taken away again.
pub(super) fn underside(points: &[[f32; 3]], cell: f64) -> Vec<[f32; 3]> {
    let mut heights: Vec<f32> = points.iter().map(|p| p[2]).collect();
    heights.sort_by(f32::total_cmp);
    let Some(&ground) = heights.get((heights.len() as f64 * STRAY) as usize) else { return Vec::new() };
    let slice: Vec<[f64; 2]> = points
        .iter()
        .filter(|p| p[2] >= ground && p[2] <= ground + SLICE * cell as f32)
        .map(|p| [f64::from(p[0]), f64::from(p[1])])
        .collect();
    let lowest = |k: usize| slice.iter().map(|p| p[k]).fold(f64::INFINITY, f64::min);
    let highest = |k: usize| slice.iter().map(|p| p[k]).fold(f64::NEG_INFINITY, f64::max);
    let widening = 2;
    let border = BORDER + widening;
    let first = [0, 1].map(|k| (lowest(k) / cell).floor() - border as f64);
    let size = [0, 1].map(|k| ((highest(k) / cell).floor() - first[k]) as usize + 1 + border);
    // A body wider than this in cells is refused by the caller, which counts lattice points of its box.
    if size[0].saturating_mul(size[1]) > 1 << 28 {
        return Vec::new();
    }
    let mut states = vec![State::Unknown; size[0] * size[1]];
    for p in &slice {
        let at = [0, 1].map(|k| ((p[k] / cell).floor() - first[k]) as usize);
        for y in at[1] - widening..=at[1] + widening {
            for x in at[0] - widening..=at[0] + widening {
                states[y * size[0] + x] = State::Outline;
            }
        }
    }
    flood(&mut states, size);
    // A cell stays if nothing outside is within the widening.
    let inside = |x: usize, y: usize| {
        let range = |c: usize, k: usize| c.saturating_sub(widening)..=(c + widening).min(size[k] - 1);
        range(y, 1).all(|v| range(x, 0).all(|u| states[v * size[0] + u] != State::Outside))
    };
    let cells = (0..size[1]).flat_map(|y| (0..size[0]).map(move |x| (x, y)));
    let centre = |x: usize, k: usize| ((first[k] + x as f64 + 0.5) * cell) as f32;
    cells.filter(|&(x, y)| inside(x, y)).map(|(x, y)| [centre(x, 0), centre(y, 1), ground]).collect()
}

fn flood(states: &mut [State], size: [usize; 2]) {
    let mut open = vec![0];
    states[0] = State::Outside;
    while let Some(at) = open.pop() {
        let (x, y) = (at % size[0], at / size[0]);
        let next = [
            (x > 0).then(|| at - 1),
            (x + 1 < size[0]).then(|| at + 1),
            (y > 0).then(|| at - size[0]),
            (y + 1 < size[1]).then(|| at + size[0]),
        ];
        for n in next.into_iter().flatten() {
            if states[n] == State::Unknown {
                states[n] = State::Outside;
                open.push(n);
            }
        }
    }
}
