//! Where outside is: a flood over voxels that the surface stops.

use nalgebra::Vector3;

use crate::linalg::wide;

/// Voxels around the surface on every side: one for its widening, the rest for the flood.
const BORDER: usize = 3;
/// How far outside is looked for along a normal, in voxels.
const LOOK: usize = 4;

/// Distance from outside within which a point belongs to the surface, in voxels.
const NEAR: usize = 3;

#[derive(Clone, Copy, PartialEq, Eq)]
enum State {
    Unknown,
    Surface,
    Outside,
}

/// A grid in which everything is surface, outside or enclosed.
pub(super) struct Voxels {
    lower: Vector3<f64>,
    pub(super) pitch: f64,
    size: [usize; 3],
    states: Vec<State>,
}

impl Voxels {
    /// Marks the voxels of the points and those around them, then floods from the border.
    pub(super) fn new(points: &[[f32; 3]], lower: Vector3<f64>, upper: Vector3<f64>, pitch: f64) -> Voxels {
        let lower = lower.add_scalar(-(BORDER as f64) * pitch);
        let size = [0, 1, 2].map(|k| ((upper[k] - lower[k]) / pitch) as usize + 1 + BORDER);
        let states = vec![State::Unknown; size.iter().product()];
        let mut voxels = Voxels { lower, pitch, size, states };
        for p in points {
            let c = voxels.cell(wide(*p));
            let around = |k: usize| c[k].saturating_sub(1)..=(c[k] + 1).min(size[k] - 1);
            for z in around(2) {
                for y in around(1) {
                    for x in around(0) {
                        let at = voxels.index([x, y, z]);
                        voxels.states[at] = State::Surface;
                    }
                }
            }
        }
        voxels.flood();
        voxels
    }

    fn cell(&self, p: Vector3<f64>) -> [usize; 3] {
        // Conversion to integers saturates.
        [0, 1, 2].map(|k| (((p[k] - self.lower[k]) / self.pitch) as usize).min(self.size[k] - 1))
    }

    fn index(&self, c: [usize; 3]) -> usize {
        (c[2] * self.size[1] + c[1]) * self.size[0] + c[0]
    }

    fn flood(&mut self) {
        let mut open = vec![[0_usize; 3]];
        self.states[0] = State::Outside;
        while let Some(c) = open.pop() {
            for k in 0..3 {
                for forward in [false, true] {
                    let mut next = c;
                    match (forward, c[k].checked_sub(1)) {
                        (false, Some(lower)) => next[k] = lower,
                        (true, _) if c[k] + 1 < self.size[k] => next[k] += 1,
                        _ => continue,
                    }
                    let at = self.index(next);
                    if self.states[at] == State::Unknown {
                        self.states[at] = State::Outside;
                        open.push(next);
                    }
                }
            }
        }
    }

    /// Volume that the flood did not reach, the surface not counted.
    pub(super) fn enclosed_volume(&self) -> f64 {
        self.states.iter().filter(|s| **s == State::Unknown).count() as f64 * self.pitch.powi(3)
    }

    /// Whether the flood reached a point.
    pub(super) fn is_outside(&self, p: Vector3<f64>) -> bool {
        self.states[self.index(self.cell(p))] == State::Outside
    }

    /// Whether the flood came within three voxels; the surface is widened by one, so a point of it has outside at two.
    pub(super) fn is_near_outside(&self, p: Vector3<f64>) -> bool {
        let c = self.cell(p);
        let around = |k: usize| c[k].saturating_sub(NEAR)..=(c[k] + NEAR).min(self.size[k] - 1);
        let outside = |x, y, z| self.states[self.index([x, y, z])] == State::Outside;
        around(2).any(|z| around(1).any(|y| around(0).any(|x| outside(x, y, z))))
    }

    /// Outside minus not outside along a normal, from −1 (behind) to 1 (ahead): the share of voxels ahead that the
    /// flood reached, minus that behind. Only those beyond the widened surface are asked.
    pub(super) fn outside_along(&self, p: Vector3<f64>, normal: &Vector3<f64>) -> f64 {
        let share = |sign: f64| {
            let hits = (2..2 + LOOK).filter(|&k| self.is_outside(p + normal * (sign * k as f64 * self.pitch))).count();
            hits as f64 / LOOK as f64
        };
        share(1.0) - share(-1.0)
    }
}
