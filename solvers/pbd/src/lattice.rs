//! Points of edges and triangles between the vertices, as close together as the samples of a partner.

use std::collections::BTreeSet;

use crate::place::Place;
use crate::sim::Sim;

/// Most parts of an edge.
const MOST_PARTS: u32 = 5;
/// How far an edge may be stretched whose corrections are relaxed as published: silk over a tip doubles its length.
const STRETCHED: f64 = 2.0;

impl Sim {
    /// Points between the vertices of a body that cut its shortest edges into parts of at most `width` \[m\].
    pub(crate) fn lattice(&self, body: usize, width: f64) -> Vec<Place> {
        // A whole number of widths must not become one part more by rounding.
        let longest = self.setting.shortest * if self.setting.relaxed { STRETCHED } else { 1.0 };
        let parts = (longest / width - 1e-6).ceil().clamp(1.0, f64::from(MOST_PARTS)) as u32;
        let share = |k: u32| f64::from(k) / f64::from(parts);
        let mut places = Vec::new();
        let mut seen = BTreeSet::new();
        for &[a, b, c] in self.mesh.triangles.iter().filter(|t| self.owner[t[0] as usize] as usize == body) {
            for (i, j, other) in [(a, b, c), (b, c, a), (c, a, b)] {
                let (i, j) = (i.min(j), i.max(j));
                if seen.insert([i, j]) {
                    places.extend((1..parts).map(|k| Place::on([i, j, other], [1.0 - share(k), share(k), 0.0])));
                }
            }
            let inside = (1..parts).flat_map(|k| (1..parts - k).map(move |l| (k, l)));
            places.extend(inside.map(|(k, l)| {
                let [s, t] = [share(k), share(l)];
                Place::on([a, b, c], [1.0 - s - t, s, t])
            }));
        }
        places
    }
}
