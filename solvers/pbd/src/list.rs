//! Which triangles of a cloth each sample of a partner can meet, looked for again only when something has moved too far.
//!
//! What is in a list beyond what can be met never counts: what comes of a list does not depend on its age, so that it is
//! no part of the state.

use cosplat_core::boundary::{Vec3, dot, norm, sub};

use crate::cells::Cells;
use crate::cover::Cover;

/// Motion that a list allows for, in widths of the samples and in ways of one window.
const WIDTHS: f64 = 0.5;
const WINDOWS: f64 = 4.0;

/// Triangles near samples.
#[derive(Clone, Debug, Default)]
pub(crate) struct List {
    /// Samples with a list, where each list begins, and the lists.
    pub(crate) samples: Vec<u32>,
    begin: Vec<u32>,
    near: Vec<u32>,
    /// Where vertices and samples were \[m\].
    from: [Vec<Vec3>; 2],
    /// How far they may move towards each other since \[m\].
    allowed: f64,
}

impl List {
    /// Looks again where that is needed: for triangles up to `reach` from samples that move by `way` towards each other in
    /// this window \[m\]; `width` is that of the samples \[m\].
    pub(crate) fn renew(&mut self, cover: &Cover, samples: &[Vec3], (reach, way, width): (f64, f64, f64)) {
        let moved = |now: &mut dyn Iterator<Item = Vec3>, then: &[Vec3]| {
            now.zip(then).map(|(a, &b)| norm(sub(a, b))).fold(0.0, f64::max)
        };
        let same = cover.places().count() == self.from[0].len() && samples.len() == self.from[1].len();
        let so_far = || moved(&mut cover.places(), &self.from[0]) + moved(&mut samples.iter().copied(), &self.from[1]);
        if same && way + so_far() <= self.allowed {
            return;
        }
        self.allowed = (WINDOWS * way).min(2.0 * width).max(WIDTHS * width).max(way);
        let reach = reach + self.allowed;
        let largest = cover.balls.iter().map(|b| b.1).fold(0.0, f64::max);
        let middles: Vec<Vec3> = cover.balls.iter().map(|b| b.0).collect();
        let cells = Cells::new(&middles, 0.5 * (reach + largest));
        let inside = inside(&middles, reach + largest);
        self.samples.clear();
        self.near.clear();
        self.begin = vec![0];
        for (sample, &x) in (0..).zip(samples).filter(|(_, x)| inside(**x)) {
            let first = self.near.len();
            cells.near(x, [reach + largest; 3], |range| {
                for &i in &cells.items()[range] {
                    let (middle, radius) = cover.balls[i as usize];
                    let d = sub(middle, x);
                    if dot(d, d) < (reach + radius) * (reach + radius) {
                        self.near.push(i + cover.range.start as u32);
                    }
                }
            });
            if self.near.len() > first {
                self.samples.push(sample);
                self.begin.push(self.near.len() as u32);
            }
        }
        self.from = [cover.places().collect(), samples.to_vec()];
    }

    /// Triangles near the sample at a place of [`List::samples`].
    pub(crate) fn of(&self, place: usize) -> &[u32] {
        &self.near[self.begin[place] as usize..self.begin[place + 1] as usize]
    }
}

/// Whether a point is within `reach` of a box around some points \[m\].
fn inside(points: &[Vec3], reach: f64) -> impl Fn(Vec3) -> bool + use<> {
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
    use crate::closest::{at, on_triangle};
    use crate::own::Mesh;
    use crate::vertex::Vertex;

    #[test]
    fn an_old_list_misses_nobody_who_can_be_met() {
        let place = |i: u32, t: f64| [0.01 * f64::from(i % 20) + t, 0.01 * f64::from(i / 20), 0.002 * f64::from(i % 3)];
        let samples: Vec<Vec3> = (0..400).map(|i| place(i, 0.0)).collect();
        let triangles: Vec<[u32; 3]> = (0..380).filter(|i| i % 20 < 19).map(|i| [i, i + 1, i + 20]).collect();
        let count = triangles.len();
        let mesh = Mesh { triangles, ..Mesh::default() };
        let (mut list, mut renewed) = (List::default(), 0);
        for window in 0..20 {
            let at_now = |i: u32| Vertex { x: place(i, 0.001 * f64::from(window)), ..Vertex::default() };
            let vertices: Vec<Vertex> = (0..400).map(at_now).collect();
            let cover = Cover::new(&mesh, &vertices, 0..count, false);
            let before = list.from[0].clone();
            list.renew(&cover, &samples, (0.015, 0.001, 0.01));
            renewed += u32::from(before != list.from[0]);
            for (sample, &x) in samples.iter().enumerate() {
                let known = list.samples.binary_search(&(sample as u32)).map_or(&[][..], |p| list.of(p));
                for t in 0..count {
                    let corners = mesh.triangles[t].map(|i| vertices[i as usize].x);
                    let apart = norm(sub(at(corners, on_triangle(corners, x)), x));
                    assert!(apart >= 0.015 || known.contains(&(t as u32)), "window {window}, sample {sample}");
                }
            }
        }
        // 1 mm a window, 5 mm allowed.
        assert!((4..=6).contains(&renewed), "{renewed}");
    }
}
