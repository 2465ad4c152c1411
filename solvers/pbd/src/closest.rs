//! Nearest points of points, edges and triangles, as shares of their ends.

use cosplat_core::boundary::{Vec3, add, dot, scale, sub};

/// Shares of the point of a triangle that is nearest to `p`. Source: Ericson, "Real-Time Collision Detection" (2005),
/// §5.1.5. A triangle without an area answers with a point of an edge.
pub(crate) fn on_triangle([a, b, c]: [Vec3; 3], p: Vec3) -> [f64; 3] {
    let (ab, ac, ap) = (sub(b, a), sub(c, a), sub(p, a));
    let (d1, d2) = (dot(ab, ap), dot(ac, ap));
    if d1 <= 0.0 && d2 <= 0.0 {
        return [1.0, 0.0, 0.0];
    }
    let bp = sub(p, b);
    let (d3, d4) = (dot(ab, bp), dot(ac, bp));
    if d3 >= 0.0 && d4 <= d3 {
        return [0.0, 1.0, 0.0];
    }
    let vc = d1 * d4 - d3 * d2;
    if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
        let t = d1 / (d1 - d3);
        return [1.0 - t, t, 0.0];
    }
    let cp = sub(p, c);
    let (d5, d6) = (dot(ab, cp), dot(ac, cp));
    if d6 >= 0.0 && d5 <= d6 {
        return [0.0, 0.0, 1.0];
    }
    let vb = d5 * d2 - d1 * d6;
    if vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
        let t = d2 / (d2 - d6);
        return [1.0 - t, 0.0, t];
    }
    let va = d3 * d6 - d5 * d4;
    if va <= 0.0 && d4 - d3 >= 0.0 && d5 - d6 >= 0.0 {
        let t = (d4 - d3) / ((d4 - d3) + (d5 - d6));
        return [0.0, 1.0 - t, t];
    }
    let all = va + vb + vc;
    let (v, w) = (vb / all, vc / all);
    // A share that rounds below zero would be a vertex that is pulled.
    [(1.0 - v - w).max(0.0), v, w]
}

/// Two edges, `a..b` and `c..d`, as the search for their nearest points needs them. Ericson §5.1.9.
struct Lines {
    /// Squares of their lengths, and their product.
    aa: f64,
    ee: f64,
    bb: f64,
    /// What they have in common with the way from `c` to `a`.
    cc: f64,
    f: f64,
    /// Product of the squares times sin² of the angle between them.
    below: f64,
}

impl Lines {
    #[inline]
    fn of([a, b]: [Vec3; 2], [c, d]: [Vec3; 2]) -> Self {
        let (ab, cd, r) = (sub(b, a), sub(d, c), sub(a, c));
        let (aa, ee, bb) = (dot(ab, ab), dot(cd, cd), dot(ab, cd));
        Self { aa, ee, bb, cc: dot(ab, r), f: dot(cd, r), below: aa * ee - bb * bb }
    }

    /// How far along each the nearest points are, where neither is an end. Below a sin² of 1e-6 they are anywhere along.
    #[inline]
    fn inside(&self) -> Option<[f64; 2]> {
        let Self { aa, ee, bb, cc, f, below } = *self;
        let (s, t) = (bb * f - cc * ee, aa * f - bb * cc);
        let within = |v: f64| v > 0.0 && v < below;
        (below > 1e-6 * aa * ee && within(s) && within(t)).then(|| [s / below, t / below])
    }

    /// How far along each they are, ends included.
    fn between(&self) -> [f64; 2] {
        let Self { aa, ee, bb, cc, f, below } = *self;
        let (aa, ee) = (aa.max(f64::MIN_POSITIVE), ee.max(f64::MIN_POSITIVE));
        // Parallel ones have many nearest points: any will do.
        let s = if below > 1e-12 * aa * ee { ((bb * f - cc * ee) / below).clamp(0.0, 1.0) } else { 0.5 };
        let t = (bb * s + f) / ee;
        if t < 0.0 {
            [(-cc / aa).clamp(0.0, 1.0), 0.0]
        } else if t > 1.0 {
            [((bb - cc) / aa).clamp(0.0, 1.0), 1.0]
        } else {
            [s, t]
        }
    }
}

/// Shares of the nearest points of the edges `a..b` and `c..d`: how far along each. Where they are parallel or a nearest
/// point is an end, which is a matter between a vertex and a triangle, their distance instead \[m\].
#[inline]
pub(crate) fn of_edges(e: [Vec3; 2], f: [Vec3; 2]) -> Result<[f64; 2], f64> {
    let lines = Lines::of(e, f);
    lines.inside().ok_or_else(|| {
        let [s, t] = lines.between();
        let gap = sub(along(e, s), along(f, t));
        dot(gap, gap).sqrt()
    })
}

/// How far along each of two lines with ends the nearest points are, ends included.
pub(crate) fn between(e: [Vec3; 2], f: [Vec3; 2]) -> [f64; 2] {
    Lines::of(e, f).between()
}

/// Square of the distance of two edges, ends included \[m²\].
pub(crate) fn edges_apart(e: [Vec3; 2], f: [Vec3; 2]) -> f64 {
    let [s, t] = between(e, f);
    let gap = sub(along(e, s), along(f, t));
    dot(gap, gap)
}

/// The point so far along an edge.
pub(crate) fn along([a, b]: [Vec3; 2], share: f64) -> Vec3 {
    add(scale(a, 1.0 - share), scale(b, share))
}

/// The point of a triangle with these shares.
pub(crate) fn at([a, b, c]: [Vec3; 3], share: [f64; 3]) -> Vec3 {
    add(add(scale(a, share[0]), scale(b, share[1])), scale(c, share[2]))
}

#[cfg(test)]
mod tests {
    use super::*;
    use cosplat_core::boundary::norm;

    #[test]
    fn no_point_of_a_triangle_is_nearer_than_the_nearest() {
        let triangle = [[0.1, 0.2, 0.0], [1.1, -0.1, 0.3], [0.4, 0.9, -0.2]];
        for i in 0..60 {
            let t = f64::from(i) * 0.7;
            let p = [1.2 * t.sin(), 1.1 * (1.3 * t).cos(), 0.8 * (0.37 * t).sin()];
            let share = on_triangle(triangle, p);
            assert!(share.iter().all(|s| *s >= 0.0) && (share.iter().sum::<f64>() - 1.0).abs() < 1e-15);
            let least = norm(sub(p, at(triangle, share)));
            for (a, b) in (0..=20).flat_map(|a| (0..=20 - a).map(move |b| (a, b))) {
                let [a, b] = [a, b].map(|k| f64::from(k) / 20.0);
                assert!(norm(sub(p, at(triangle, [1.0 - a - b, a, b]))) >= least - 1e-15);
            }
        }
    }

    #[test]
    fn crossing_edges_meet_where_they_are_nearest_and_others_do_not() {
        let e = [[-1.0, 0.0, 0.0], [1.0, 0.0, 0.0]];
        let found = of_edges(e, [[0.5, -1.0, 0.2], [0.5, 3.0, 0.2]]).expect("they cross");
        assert!((found[0] - 0.75).abs() < 1e-15 && (found[1] - 0.25).abs() < 1e-15, "{found:?}");
        assert!(of_edges(e, [[2.0, -1.0, 0.2], [2.0, 1.0, 0.2]]).is_err_and(|d| (d - 1.04_f64.sqrt()).abs() < 1e-15));
        assert!(of_edges(e, [[-1.0, 0.1, 0.0], [1.0, 0.1, 0.0]]).is_err_and(|d| (d - 0.1).abs() < 1e-15));
        let apart = edges_apart(e, [[2.0, -1.0, 0.0], [2.0, 1.0, 0.0]]);
        assert!((apart - 1.0).abs() < 1e-15, "{apart}");
    }
}
