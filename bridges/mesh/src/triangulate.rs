//! Polygons into triangles.

use std::cell::Cell;

use cosplat_core::boundary::Vec3;
use nalgebra::{Vector2, Vector3};

/// Triangles of a polygon as places in the list of its corners, turned the same way as the polygon.
///
/// A convex polygon becomes a fan; of any other simple one ears are cut in the plane of its mean normal (Newell's
/// method). A polygon without area becomes a fan: its triangles have none either. Nothing, once the cutting has taken
/// more than `tests` of a point against a triangle; what was taken is subtracted.
pub(crate) fn triangulate(corners: &[Vec3], tests: &mut u64) -> Option<Vec<[usize; 3]>> {
    let n = corners.len();
    let fan = || Some((1..n.saturating_sub(1)).map(|k| [0, k, k + 1]).collect());
    if n < 4 {
        return fan();
    }
    let points: Vec<Vector3<f64>> = corners.iter().map(|c| Vector3::from(*c)).collect();
    let middle = points.iter().sum::<Vector3<f64>>() / n as f64;
    let newell = |k: usize| (points[k] - middle).cross(&(points[(k + 1) % n] - middle));
    let Some(normal) = (0..n).map(newell).sum::<Vector3<f64>>().try_normalize(0.0) else { return fan() };
    let axis = Vector3::ith(normal.iamin(), 1.0);
    let u = normal.cross(&axis).normalize();
    let v = normal.cross(&u);
    let flat: Vec<Vector2<f64>> =
        points.iter().map(|p| Vector2::new(u.dot(&(p - middle)), v.dot(&(p - middle)))).collect();
    let is_left = |a: usize, b: usize, c: usize| turn(&flat[a], &flat[b], &flat[c]) > 0.0;
    if (0..n).all(|k| is_left(k, (k + 1) % n, (k + 2) % n)) {
        return fan();
    }
    let mut left: Vec<usize> = (0..n).collect();
    let mut out = Vec::with_capacity(n - 2);
    while left.len() > 3 {
        let m = left.len();
        let taken = Cell::new(0);
        let ear = |k: usize| {
            let [a, b, c] = [left[(k + m - 1) % m], left[k], left[(k + 1) % m]];
            let holds = |&p: &usize| {
                taken.set(taken.get() + 1);
                p != a && p != b && p != c && !is_left(b, a, p) && !is_left(c, b, p) && !is_left(a, c, p)
            };
            is_left(a, b, c) && !left.iter().any(holds)
        };
        // A polygon that crosses itself may have no ear: the next corner is cut, so that this ends.
        let k = (0..m).find(|&k| taken.get() <= *tests && ear(k)).unwrap_or(0);
        *tests = tests.checked_sub(taken.get())?;
        out.push([left[(k + m - 1) % m], left[k], left[(k + 1) % m]]);
        left.remove(k);
    }
    out.push([left[0], left[1], left[2]]);
    Some(out)
}

/// Twice the area of a triangle, positive if it turns left.
fn turn(a: &Vector2<f64>, b: &Vector2<f64>, c: &Vector2<f64>) -> f64 {
    (b - a).perp(&(c - a))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cut(corners: &[Vec3]) -> Vec<[usize; 3]> {
        triangulate(corners, &mut 1000).unwrap()
    }

    fn area(corners: &[Vec3]) -> (f64, f64) {
        let of = |t: &[usize; 3]| {
            let [a, b, c] = t.map(|k| Vector3::from(corners[k]));
            (b - a).cross(&(c - a)) / 2.0
        };
        let all: Vec<Vector3<f64>> = cut(corners).iter().map(of).collect();
        (all.iter().map(Vector3::norm).sum(), all.iter().sum::<Vector3<f64>>().norm())
    }

    #[test]
    fn every_simple_polygon_is_covered_once() {
        let star: Vec<Vec3> = (0..10)
            .map(|k| {
                let (r, a) = (if k % 2 == 0 { 1.0 } else { 0.3 }, f64::from(k) * std::f64::consts::PI / 5.0);
                [r * a.cos(), 2.0 * r * a.sin(), r * a.cos()]
            })
            .collect();
        let arrow = [[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [0.5, 0.5, 0.0], [0.0, 2.0, 0.0]];
        let square = [[0.0, 0.0, 1.0], [1.0, 0.0, 1.0], [1.0, 1.0, 1.0], [0.0, 1.0, 1.0]];
        // Areas add up only if no triangle lies outside or turns the other way.
        for polygon in [&star[..], &arrow, &square] {
            let (sum, vector) = area(polygon);
            assert!((sum - vector).abs() < 1e-12 * sum, "{sum} {vector}");
            assert_eq!(cut(polygon).len(), polygon.len() - 2);
        }
        assert_eq!(cut(&[[0.0; 3]; 6]).len(), 4);
        assert_eq!(triangulate(&star, &mut 3), None, "a star of ten corners takes more tests");
    }
}
