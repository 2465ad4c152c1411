//! Front to back over one tile.

use crate::beside::Beside;
use crate::exp::exp_negative;
use crate::project::{CUT, Ellipse};
use crate::tiles::{TILE, Tiles};

/// Pixels that are computed together.
pub(crate) const LANES: usize = 4;
/// Lane groups of a tile's row.
pub(crate) const GROUPS: usize = TILE / LANES;
/// No single Gaussian hides more than this.
const CAP: f32 = 0.99;
/// A pixel through which less than this would shine is finished.
const FINISHED: f32 = 1e-4;
/// Ellipses after which it is looked whether the whole tile is finished.
const LOOK: usize = 16;
/// Widening of the span of a row, in pixels, so that rounding never loses a pixel that the cut would keep.
const SLACK: f32 = 0.01;

/// The exponent of an ellipse along a row of pixels: square · dx² + linear · dx + constant.
struct Row {
    square: f32,
    linear: f32,
    constant: f32,
}

pub(crate) type Plane = [[f32; LANES]; TILE * GROUPS];

/// A value of a plane at a pixel of the tile.
pub(crate) fn at(plane: &Plane, column: usize, row: usize) -> f32 {
    plane[row * GROUPS + column / LANES][column % LANES]
}

/// What a tile has gathered.
pub(crate) struct Tile<B> {
    /// Light that still comes through.
    pub(crate) through: Plane,
    pub(crate) red: Plane,
    pub(crate) green: Plane,
    pub(crate) blue: Plane,
    /// What is gathered beside colours.
    pub(crate) beside: B,
    /// [`CAP`] while a pixel is open, 0 when it is finished.
    cap: Plane,
}

impl<B: Beside> Tile<B> {
    pub(crate) fn new() -> Tile<B> {
        let zero = [[0.0; LANES]; TILE * GROUPS];
        let of = |v: f32| [[v; LANES]; TILE * GROUPS];
        Tile { through: of(1.0), red: zero, green: zero, blue: zero, beside: B::new(), cap: of(CAP) }
    }

    /// Adds the ellipses of a list; `left` and `top` are the first pixel of the tile.
    pub(crate) fn add(&mut self, list: &[u32], tiles: &Tiles<B::Feature>, left: usize, top: usize, floor: f32) {
        for some in list.chunks(LOOK) {
            for &i in some {
                let (ellipse, feature) = (&tiles.ellipses[i as usize], &tiles.features[i as usize]);
                self.add_one(ellipse, feature, left, top, floor);
            }
            if self.cap.iter().flatten().all(|&cap| cap == 0.0) {
                return;
            }
        }
    }

    fn add_one(&mut self, e: &Ellipse, feature: &B::Feature, left: usize, top: usize, floor: f32) {
        let (first, end) =
            (usize::from(e.columns[0]).max(left) - left, usize::from(e.columns[1]).min(left + TILE) - left);
        let rows = usize::from(e.rows[0]).max(top)..usize::from(e.rows[1]).min(top + TILE);
        let (x, inverse_a, det) = (e.x - left as f32 - 0.5, 1.0 / e.a, e.a * e.c - e.b * e.b);
        for row in rows {
            let dy = row as f32 + 0.5 - e.y;
            let (mut from, mut to) = (first, end);
            if to - from > LANES {
                // a dx² + 2 b dx dy + c dy² < reach between −b dy / a ± √(a reach − det dy²) / a; not worth its root for
                // an ellipse of one or two groups.
                let middle = x - e.b * dy * inverse_a;
                let half = (e.a * e.reach - det * dy * dy).max(0.0).sqrt() * inverse_a + SLACK;
                // Conversions to integers saturate.
                from = from.max((middle - half).max(0.0) as usize);
                to = to.min((middle + half + 1.0).max(0.0) as usize);
                if from >= to {
                    continue;
                }
            }
            // The exponent along the row, −½ a dx² − b dy dx − ½ c dy², as a polynomial in dx.
            let row_of = Row { square: -0.5 * e.a, linear: -e.b * dy, constant: -0.5 * e.c * dy * dy };
            for group in from / LANES..=(to - 1) / LANES {
                let at = (row - top) * GROUPS + group;
                if self.cap[at].iter().any(|&cap| cap > 0.0) {
                    let weight = self.add_group(at, e, &row_of, x - (group * LANES) as f32, floor);
                    self.beside.add(at, weight, e, feature);
                }
            }
        }
    }

    /// One row of lanes, and the weights in it; `x` is the centre of the ellipse from that of the first lane.
    #[inline]
    fn add_group(&mut self, at: usize, e: &Ellipse, row: &Row, x: f32, floor: f32) -> [f32; LANES] {
        let cut = CUT as f32;
        let (before, cap) = (self.through[at], self.cap[at]);
        // Whole rows are made and stored: conditional stores would not be vectorised.
        let (mut weight, mut after, mut still) = ([0.0_f32; LANES], [0.0_f32; LANES], [0.0_f32; LANES]);
        for k in 0..LANES {
            let dx = k as f32 - x;
            let power = (row.square * dx + row.linear) * dx + row.constant;
            let kernel = exp_negative(power.clamp(-80.0, 0.0)) - floor;
            let alpha = (e.opacity * kernel).min(cap[k]);
            let alpha = if alpha < cut { 0.0 } else { alpha };
            let next = before[k] * (1.0 - alpha);
            let open = if next < FINISHED { 0.0 } else { 1.0 };
            weight[k] = alpha * before[k] * open;
            after[k] = next * open + before[k] * (1.0 - open);
            still[k] = cap[k] * open;
        }
        (self.through[at], self.cap[at]) = (after, still);
        let [red, green, blue] = e.colour;
        let planes = [(&mut self.red, red), (&mut self.green, green), (&mut self.blue, blue)];
        for (plane, value) in planes {
            for (p, w) in plane[at].iter_mut().zip(weight) {
                *p += w * value;
            }
        }
        weight
    }
}
