//! Which samples of a partner each point of a cloth can meet, looked for again only when something has moved too far.
//!
//! What is in a list beyond what can be met never counts: what comes of a list does not depend on its age, so that it is
//! no part of the state.

use cosplat_core::boundary::{Vec3, dot, norm, sub};

use crate::cells::Cells;

/// Motion that a list allows for, in widths of the samples and in ways of one window.
const WIDTHS: f64 = 0.5;
const WINDOWS: f64 = 4.0;

/// Samples near points.
#[derive(Clone, Debug, Default)]
pub(crate) struct List {
    /// Where the list of each point begins, and the lists.
    begin: Vec<u32>,
    near: Vec<u32>,
    /// Points with a list.
    pub(crate) points: Vec<u32>,
    /// Samples in any of the lists.
    pub(crate) active: Vec<u32>,
    /// Where points and samples were \[m\].
    from: [Vec<Vec3>; 2],
    /// How far they may move towards each other since \[m\].
    allowed: f64,
}

/// Calls `f` with the points within a distance of one \[m\].
pub(crate) fn within(cells: &Cells, all: &[Vec3], (x, reach): (Vec3, f64), mut f: impl FnMut(u32)) {
    cells.near(x, [reach; 3], |range| {
        for &i in &cells.items()[range] {
            let d = sub(all[i as usize], x);
            if dot(d, d) < reach * reach {
                f(i);
            }
        }
    });
}

impl List {
    /// Looks again where that is needed: for samples up to `reach` from points that move by `way` towards each other in
    /// this window \[m\]; `width` is that of the samples \[m\].
    pub(crate) fn renew(&mut self, points: &[Vec3], samples: &[Vec3], (reach, way, width): (f64, f64, f64)) {
        let moved =
            |now: &[Vec3], then: &[Vec3]| now.iter().zip(then).map(|(&a, &b)| norm(sub(a, b))).fold(0.0, f64::max);
        let same = points.len() == self.from[0].len() && samples.len() == self.from[1].len();
        if same && way + moved(points, &self.from[0]) + moved(samples, &self.from[1]) <= self.allowed {
            return;
        }
        self.allowed = (WINDOWS * way).min(2.0 * width).max(WIDTHS * width).max(way);
        let reach = reach + self.allowed;
        let cells = Cells::new(samples, 0.5 * reach);
        let inside = inside(samples, reach);
        self.near.clear();
        self.points.clear();
        self.begin = vec![0];
        for (place, &x) in (0..).zip(points) {
            let first = self.near.len();
            if inside(x) {
                within(&cells, samples, (x, reach), |i| self.near.push(i));
            }
            if self.near.len() > first {
                self.points.push(place);
            }
            self.begin.push(self.near.len() as u32);
        }
        self.active = self.near.clone();
        self.active.sort_unstable();
        self.active.dedup();
        self.from = [points.to_vec(), samples.to_vec()];
    }

    /// Samples near a point.
    pub(crate) fn of(&self, point: usize) -> &[u32] {
        &self.near[self.begin[point] as usize..self.begin[point + 1] as usize]
    }
}

/// Whether a point is within `reach` of a box around some points \[m\].
pub(crate) fn inside(points: &[Vec3], reach: f64) -> impl Fn(Vec3) -> bool + use<> {
    let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
    for x in points {
        low = std::array::from_fn(|k| low[k].min(x[k]));
        high = std::array::from_fn(|k| high[k].max(x[k]));
    }
    move |x| (0..3).all(|k| x[k] > low[k] - reach && x[k] < high[k] + reach)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_old_list_misses_nobody_who_can_be_met() {
        let at = |i: u32, t: f64| [0.01 * f64::from(i % 20) + t, 0.01 * f64::from(i / 20), 0.002 * f64::from(i % 3)];
        let samples: Vec<Vec3> = (0..400).map(|i| at(i, 0.0)).collect();
        let (mut list, mut renewed) = (List::default(), 0);
        for window in 0..20 {
            let points: Vec<Vec3> = (0..300).map(|i| at(i, 0.001 * f64::from(window))).collect();
            let before = list.from[0].clone();
            list.renew(&points, &samples, (0.015, 0.001, 0.01));
            renewed += u32::from(before != list.from[0]);
            for (i, &x) in points.iter().enumerate() {
                let mut met = (0..400_u32).filter(|&k| norm(sub(samples[k as usize], x)) < 0.015);
                assert!(met.all(|k| list.of(i).contains(&k)), "window {window}, point {i}");
            }
        }
        // 1 mm a window, 5 mm allowed.
        assert!((4..=6).contains(&renewed), "{renewed}");
    }
}
