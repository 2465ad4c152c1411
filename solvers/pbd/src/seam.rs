//! Cloth between two samples of a partner that are too near each other for it.
//!
//! Samples are beads, and cloth that slides in between two of them from its rim would have the right side of both. Where
//! two beads leave less room than the cloth is thick, there is a neck between them: a circle about the middle of the
//! seam from one to the other. The rim keeps out of the neck, and where the seam has come through the cloth beside its
//! rim, the rim goes back over it.

use cosplat_core::boundary::{Vec3, add, cross, dot, norm, scale, sub};

use crate::cells::Cells;
use crate::closest::{along, between};
use crate::cover::Contact;
use crate::own::Mesh;
use crate::place::Place;
use crate::vertex::Vertex;

/// A sample near cloth: its number, where it is, at which distance it touches, and the triangle that is nearest.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Bead {
    pub(crate) sample: u32,
    pub(crate) x: Vec3,
    pub(crate) touching: f64,
    /// From the cloth, when it was last looked at.
    pub(crate) distance: f64,
    pub(crate) triangle: u32,
}

/// Calls `f` with each two beads that leave no room for cloth between them, and the radius of their neck \[m\].
pub(crate) fn seams(beads: &[Bead], mut f: impl FnMut([&Bead; 2], f64)) {
    let places: Vec<Vec3> = beads.iter().map(|b| b.x).collect();
    let reach = beads.iter().map(|b| 2.0 * b.touching).fold(0.0, f64::max);
    if beads.is_empty() || reach <= 0.0 {
        return;
    }
    let cells = Cells::new(&places, reach);
    for a in beads {
        cells.near(a.x, [reach; 3], |range| {
            for b in cells.items()[range].iter().map(|&k| &beads[k as usize]).filter(|b| b.sample > a.sample) {
                let way = sub(b.x, a.x);
                let (square, touching) = (dot(way, way), 0.5 * (a.touching + b.touching));
                if square < 4.0 * touching * touching && square > 0.0 {
                    f([a, b], (touching * touching - 0.25 * square).sqrt());
                }
            }
        });
    }
}

/// Contact of rims with seams: `beads` have a triangle with a rim.
pub(crate) fn contacts(beads: &[Bead], mesh: &Mesh, vertices: &[Vertex]) -> Vec<Contact> {
    let mut found = Vec::new();
    seams(beads, |ends, neck| {
        let triangles = ends.map(|b| b.triangle);
        let count = if triangles[0] == triangles[1] { 1 } else { 2 };
        for &triangle in &triangles[..count] {
            let corners = mesh.triangles[triangle as usize];
            for k in (0..3).filter(|k| mesh.rim[triangle as usize] >> k & 1 == 1) {
                let [c, a, b] = [0, 1, 2].map(|i| corners[(k + i) % 3]);
                found.extend(contact(ends, neck, [a, b, c], vertices));
            }
        }
    });
    let key = |c: &Contact| (c.samples, c.place.raw().0);
    found.sort_by_key(key);
    found.dedup_by_key(|c| key(c));
    found
}

/// Contact of a seam with the rim `a` to `b` of the triangle with the corner `c`.
fn contact([p, q]: [&Bead; 2], neck: f64, [a, b, c]: [u32; 3], vertices: &[Vertex]) -> Option<Contact> {
    let [xa, xb, xc] = [a, b, c].map(|i| vertices[i as usize].x);
    let [s, t] = between([p.x, q.x], [xa, xb]);
    // At its ends a seam is a bead.
    if s <= 0.0 || s >= 1.0 {
        return None;
    }
    let (on_seam, on_rim) = (along([p.x, q.x], s), along([xa, xb], t));
    let way = sub(on_rim, on_seam);
    let distance = norm(way);
    if distance > 2.0 * p.touching.max(q.touching) {
        return None;
    }
    let is_cut = crosses([p.x, q.x], [xa, xb, xc]);
    let (out, gap) = if distance > 0.0 {
        let turn = if is_cut { -1.0 } else { 1.0 };
        (scale(way, turn / distance), turn * distance - neck)
    } else {
        // The rim lies on the seam: back into the cloth.
        let back = sub(xc, on_rim);
        let length = norm(back);
        (length > 0.0).then(|| (scale(back, 1.0 / length), -neck))?
    };
    let place = Place::on([a, b, c], [1.0 - t, t, 0.0]);
    Some(Contact { samples: [p.sample, q.sample], share: s, place, out, gap, triangle: p.triangle })
}

/// Whether a line from `p` to `q` goes through a triangle.
pub(crate) fn crosses([p, q]: [Vec3; 2], [a, b, c]: [Vec3; 3]) -> bool {
    let n = cross(sub(b, a), sub(c, a));
    let (below, above) = (dot(n, sub(p, a)), dot(n, sub(q, a)));
    if below * above >= 0.0 {
        return false;
    }
    let at = add(p, scale(sub(q, p), below / (below - above)));
    let inside = |u: Vec3, v: Vec3| dot(n, cross(sub(v, u), sub(at, u))) >= 0.0;
    inside(a, b) && inside(b, c) && inside(c, a)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rim;

    #[test]
    fn a_rim_is_kept_out_of_a_neck_and_sent_back_where_it_has_passed() {
        let triangles = vec![[0, 1, 2]];
        let mesh = Mesh { rim: rim::of(&triangles), triangles, ..Mesh::default() };
        // The rim at x = `rim`, the cloth on its left, a seam across z at x = 0.
        let found = |rim: f64| {
            let x = [[rim, -1.0, 0.0], [rim, 1.0, 0.0], [rim - 2.0, 0.0, 0.0]];
            let vertices: Vec<Vertex> = x.iter().map(|&x| Vertex { x, ..Vertex::default() }).collect();
            let bead =
                |sample: u32, z: f64| Bead { sample, x: [0.0, 0.1, z], touching: 0.5, distance: z.abs(), triangle: 0 };
            let all = contacts(&[bead(4, -0.3), bead(7, 0.3)], &mesh, &vertices);
            all.into_iter().map(|c| (c.out, c.gap)).min_by(|a, b| a.1.abs().total_cmp(&b.1.abs()))
        };
        // Beads of 0.5, 0.6 apart: a neck of √(0.5² - 0.3²) = 0.4.
        let (out, gap) = found(-0.45).expect("near");
        assert!(out[0] < -0.999 && (gap - 0.05).abs() < 1e-12, "{out:?} {gap}");
        let (out, gap) = found(0.1).expect("cut");
        assert!(out[0] < -0.999 && (gap + 0.5).abs() < 1e-12, "{out:?} {gap}");
        assert!(found(-2.0).is_none());
    }

    #[test]
    fn a_line_goes_through_a_triangle_or_past_it() {
        let triangle = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
        let line = |x: f64, z: [f64; 2]| [[x, 0.2, z[0]], [x, 0.2, z[1]]];
        assert!(crosses(line(0.2, [-1.0, 1.0]), triangle) && crosses(line(0.2, [1.0, -1.0]), triangle));
        assert!(!crosses(line(0.9, [-1.0, 1.0]), triangle) && !crosses(line(0.2, [0.5, 1.0]), triangle));
    }
}
