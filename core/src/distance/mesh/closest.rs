//! Nearest point of a triangle, and which part of the triangle it lies on.

use crate::boundary::{add, dot, scale, sub};

/// Part of a triangle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Part {
    /// Corner 0, 1 or 2.
    Corner(usize),
    /// Edge from that corner to the next.
    Edge(usize),
    /// The inside.
    Face,
}

/// Nearest point of a triangle to `p`. Source: Ericson, "Real-Time Collision Detection" (2005), §5.1.5.
pub(super) fn closest([a, b, c]: [[f64; 3]; 3], p: [f64; 3]) -> ([f64; 3], Part) {
    let (ab, ac, ap) = (sub(b, a), sub(c, a), sub(p, a));
    let (d1, d2) = (dot(ab, ap), dot(ac, ap));
    if d1 <= 0.0 && d2 <= 0.0 {
        return (a, Part::Corner(0));
    }
    let bp = sub(p, b);
    let (d3, d4) = (dot(ab, bp), dot(ac, bp));
    if d3 >= 0.0 && d4 <= d3 {
        return (b, Part::Corner(1));
    }
    let vc = d1 * d4 - d3 * d2;
    if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
        return (add(a, scale(ab, d1 / (d1 - d3))), Part::Edge(0));
    }
    let cp = sub(p, c);
    let (d5, d6) = (dot(ab, cp), dot(ac, cp));
    if d6 >= 0.0 && d5 <= d6 {
        return (c, Part::Corner(2));
    }
    let vb = d5 * d2 - d1 * d6;
    if vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
        return (add(a, scale(ac, d2 / (d2 - d6))), Part::Edge(2));
    }
    let va = d3 * d6 - d5 * d4;
    if va <= 0.0 && d4 - d3 >= 0.0 && d5 - d6 >= 0.0 {
        let along = (d4 - d3) / ((d4 - d3) + (d5 - d6));
        return (add(b, scale(sub(c, b), along)), Part::Edge(1));
    }
    let all = va + vb + vc;
    (add(a, add(scale(ab, vb / all), scale(ac, vc / all))), Part::Face)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_part_is_found() {
        let triangle = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
        let cases = [
            ([-1.0, -1.0, 2.0], [0.0; 3], Part::Corner(0)),
            ([2.0, -0.5, 0.0], [1.0, 0.0, 0.0], Part::Corner(1)),
            ([-0.5, 3.0, 0.0], [0.0, 1.0, 0.0], Part::Corner(2)),
            ([0.25, -1.0, 1.0], [0.25, 0.0, 0.0], Part::Edge(0)),
            ([1.0, 1.0, 1.0], [0.5, 0.5, 0.0], Part::Edge(1)),
            ([-1.0, 0.75, 0.0], [0.0, 0.75, 0.0], Part::Edge(2)),
            ([0.25, 0.25, -3.0], [0.25, 0.25, 0.0], Part::Face),
        ];
        for (p, nearest, part) in cases {
            assert_eq!(closest(triangle, p), (nearest, part), "{p:?}");
        }
    }
}
