//! How far a curve is from its reference.

use super::case::{Comparison, Measure, Reference};

/// Time \[s\] and value.
pub(crate) type Curve = [(f64, f64)];

/// Error of a curve, relative to the norm of the reference or to the scale that replaces it. Infinite where the curve
/// has values that are no numbers; none where curve and reference share no time, or where the reference is zero.
///
/// `other` stands in for [`Reference::Finest`] and [`Reference::Twin`].
pub(crate) fn error(curve: &Curve, comparison: &Comparison, other: &Curve) -> Option<f64> {
    let pairs = pairs(curve, comparison, other);
    if pairs.iter().any(|p| !p.value.is_finite()) {
        return Some(f64::INFINITY);
    }
    if comparison.measure == Measure::Period {
        return apart(period(&pairs, |p| p.value), period(&pairs, |p| p.reference));
    }
    if comparison.measure == Measure::Mean {
        let apart = (mean(&pairs, |p| p.value)? - mean(&pairs, |p| p.reference)?).abs() - comparison.spread;
        let norm = comparison.scale.or_else(|| Some(mean(&pairs, |p| p.reference)?.abs()))?;
        return (norm > 0.0).then(|| apart.max(0.0) / norm);
    }
    let beyond = |p: &Pair| ((p.value - p.reference).abs() - comparison.spread).max(0.0);
    relative(&pairs, comparison, beyond)
}

/// Distance of two runs in the norm of their errors: what is left of the error when both have the same solvers.
pub(crate) fn distance(curve: &Curve, other: &Curve, comparison: &Comparison) -> Option<f64> {
    let pairs = pairs(curve, comparison, other);
    let difference = |p: &Pair| Some(p.value - at(other, p.time)?);
    if pairs.iter().any(|p| difference(p).is_none_or(|d| !d.is_finite())) {
        return None;
    }
    if comparison.measure == Measure::Period {
        return apart(period(&pairs, |p| p.value), period(&pairs, |p| p.value - difference(p).unwrap_or_default()));
    }
    if comparison.measure == Measure::Mean {
        let norm = comparison.scale.or_else(|| Some(mean(&pairs, |p| p.reference)?.abs()))?;
        return Some(mean(&pairs, |p| difference(p).unwrap_or_default())?.abs() / norm).filter(|d| d.is_finite());
    }
    relative(&pairs, comparison, |p| difference(p).map_or(0.0, f64::abs))
}

/// A value beside what it should be, for the time it stands for.
struct Pair {
    time: f64,
    weight: f64,
    value: f64,
    reference: f64,
}

fn pairs(curve: &Curve, comparison: &Comparison, other: &Curve) -> Vec<Pair> {
    let (from, until) = interval(comparison);
    let triples: Vec<(f64, f64, f64)> = match &comparison.reference {
        Reference::Exact(formula) => curve.iter().map(|&(t, v)| (t, v, formula.at(t))).collect(),
        Reference::Table(table) => table.iter().filter_map(|&(t, r)| Some((t, at(curve, t)?, r))).collect(),
        Reference::Between([least, most]) => curve.iter().map(|&(t, v)| (t, v, v.clamp(*least, *most))).collect(),
        Reference::Finest | Reference::Twin(_) => {
            curve.iter().filter_map(|&(t, v)| Some((t, v, at(other, t)?))).collect()
        }
    };
    let mut before = None;
    let mut pairs = Vec::new();
    for (time, value, reference) in triples.into_iter().filter(|p| p.0 >= from && p.0 <= until) {
        // The state at the begin of the interval is given, not computed, and stands for no time.
        pairs.push(Pair { time, weight: before.map_or(0.0, |b| time - b), value, reference });
        before = Some(time);
    }
    if let [only] = pairs.as_mut_slice() {
        only.weight = 1.0;
    }
    pairs
}

/// The interval that is judged, with room for the rounding of times.
fn interval(comparison: &Comparison) -> (f64, f64) {
    let room = |t: f64| 1e-9 * t.abs().min(1e9);
    (comparison.from_s - room(comparison.from_s), comparison.until_s + room(comparison.until_s))
}

fn relative(pairs: &[Pair], comparison: &Comparison, difference: impl Fn(&Pair) -> f64) -> Option<f64> {
    let last = pairs.last()?;
    let largest = |value: &dyn Fn(&Pair) -> f64| pairs.iter().map(value).fold(0.0, f64::max);
    let mean_square = |value: &dyn Fn(&Pair) -> f64| {
        let (sum, time) =
            pairs.iter().fold((0.0, 0.0), |(sum, time), p| (sum + p.weight * value(p).powi(2), time + p.weight));
        (sum / time).sqrt()
    };
    let reference = |p: &Pair| p.reference.abs();
    let (difference, norm) = match comparison.measure {
        Measure::L2 => (mean_square(&difference), mean_square(&reference)),
        Measure::Max => (largest(&difference), largest(&reference)),
        // A period and a mean are no norms of a difference, and are compared elsewhere.
        Measure::Final | Measure::Period | Measure::Mean => (difference(last), reference(last)),
    };
    let norm = comparison.scale.unwrap_or(norm);
    (norm > 0.0).then(|| difference / norm)
}

/// Mean over the time of the pairs.
fn mean(pairs: &[Pair], of: impl Fn(&Pair) -> f64) -> Option<f64> {
    let (sum, time) = pairs.iter().fold((0.0, 0.0), |(sum, time), p| (sum + p.weight * of(p), time + p.weight));
    (time > 0.0).then(|| sum / time)
}

/// Relative difference of two periods.
fn apart(period: Option<f64>, reference: Option<f64>) -> Option<f64> {
    let (period, reference) = (period?, reference?);
    Some((period / reference - 1.0).abs())
}

/// Mean period \[s\] of a swing: the time between the first and the last pass of the middle of its range in the same
/// direction. None with less than one period.
fn period(pairs: &[Pair], of: impl Fn(&Pair) -> f64) -> Option<f64> {
    let (least, most) =
        pairs.iter().map(&of).fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| (a.min(v), b.max(v)));
    let middle = f64::midpoint(least, most);
    let steps = pairs.windows(2).map(|p| [(p[0].time, of(&p[0]) - middle), (p[1].time, of(&p[1]) - middle)]);
    let passes = steps.filter(|[before, after]| (before.1 < 0.0) != (after.1 < 0.0));
    let times: Vec<f64> = passes.map(|[(t, v), (end, w)]| t + (end - t) * v / (v - w)).collect();
    let same: Vec<f64> = times.into_iter().step_by(2).collect();
    let count = same.len().checked_sub(1).filter(|n| *n > 0)?;
    Some((same[count] - same[0]) / count as f64)
}

/// Value of a curve at a time by the cubic through the four nearest points (Lagrange), so that curves of second-order
/// methods are not spoiled by the comparison; a straight line where there are fewer. None outside of the curve.
pub(crate) fn at(curve: &Curve, time: f64) -> Option<f64> {
    let room = 1e-9 * time.abs();
    let after = curve.partition_point(|p| p.0 < time - room);
    let end = curve.get(after)?;
    if (end.0 - time).abs() <= room {
        return Some(end.1);
    }
    let start = after.checked_sub(1)?;
    let count = if curve.len() < 4 { 2 } else { 4 };
    let first = (start + 1).saturating_sub(count / 2).min(curve.len() - count);
    let nodes = &curve[first..first + count];
    let basis = |i: usize| -> f64 {
        let others = (0..count).filter(|&j| j != i);
        others.map(|j| (time - nodes[j].0) / (nodes[i].0 - nodes[j].0)).product()
    };
    Some((0..count).map(|i| nodes[i].1 * basis(i)).sum())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::study::formula::Formula;

    fn comparison(reference: Reference, measure: Measure) -> Comparison {
        Comparison { reference, measure, scale: None, from_s: 0.0, until_s: f64::INFINITY, spread: 0.0 }
    }

    fn exact(text: &str) -> Reference {
        Reference::Exact(Formula::parse(text).unwrap())
    }

    fn curve(steps: u32, of: impl Fn(f64) -> f64) -> Vec<(f64, f64)> {
        (0..=steps).map(|i| f64::from(i) / f64::from(steps)).map(|t| (t, of(t))).collect()
    }

    #[test]
    fn a_curve_that_is_ten_percent_off_has_an_error_of_ten_percent() {
        let off = curve(10, |t| 1.1 * (1.0 + t));
        for measure in [Measure::L2, Measure::Max, Measure::Final] {
            let error = error(&off, &comparison(exact("1+t"), measure), &[]).unwrap();
            // Sums of eleven numbers of order one.
            assert!((error - 0.1).abs() < 1e-14, "{measure:?}: {error}");
        }
        let mut scaled = comparison(exact("1+t"), Measure::Max);
        scaled.scale = Some(0.2);
        assert!((error(&off, &scaled, &[]).unwrap() - 1.0).abs() < 1e-14);
        scaled.spread = 0.1;
        assert!((error(&off, &scaled, &[]).unwrap() - 0.5).abs() < 1e-14);
        scaled.until_s = 0.5;
        assert!((error(&off, &scaled, &[]).unwrap() - 0.25).abs() < 1e-14);
    }

    #[test]
    fn what_cannot_be_compared_has_no_error_and_what_blew_up_an_infinite_one() {
        let zero = comparison(exact("0"), Measure::L2);
        assert_eq!(error(&curve(4, |t| t), &zero, &[]), None);
        assert_eq!(error(&[], &comparison(exact("1"), Measure::L2), &[]), None);
        let blown = curve(4, |t| if t > 0.5 { f64::NAN } else { t });
        assert_eq!(error(&blown, &comparison(exact("1"), Measure::L2), &[]), Some(f64::INFINITY));
        // Beyond the end of the run there is nothing to compare.
        let table = Reference::Table(vec![(0.5, 0.5), (2.0, 9.0)]);
        assert_eq!(error(&curve(4, |t| t), &comparison(table, Measure::Final), &[]), Some(0.0));
    }

    #[test]
    fn the_period_of_a_swing_is_found_whatever_its_place_and_size() {
        let swing = curve(400, |t| 3.0 + 0.2 * (22.0 * t).cos() * (-0.5 * t).exp());
        let comparison = comparison(exact("cos(20*t)"), Measure::Period);
        // Between two of 400 points a swing is straight to (22/400)²/8 of its size; its decay shifts the middle by less.
        assert!((error(&swing, &comparison, &[]).unwrap() - (1.0 - 20.0 / 22.0)).abs() < 5e-3);
        assert_eq!(error(&curve(9, |t| t), &comparison, &[]), None);
    }

    #[test]
    fn between_the_points_of_a_curve_lies_a_cubic() {
        let cubic = |t: f64| 1.0 - 2.0 * t + t * t * t;
        let points = curve(7, cubic);
        for t in [0.0, 0.01, 0.4, 0.99, 1.0] {
            // Exact for cubics, up to the roundings of a few products.
            assert!((at(&points, t).unwrap() - cubic(t)).abs() < 1e-14, "{t}");
        }
        assert_eq!((at(&points, -0.1), at(&points, 1.1)), (None, None));
        assert_eq!(at(&points[..2], 1.0 / 14.0), Some(f64::midpoint(points[0].1, points[1].1)));
    }

    #[test]
    fn the_split_of_an_error_is_measured_in_the_same_norm() {
        let (coarse, fine) = (curve(8, |t| 1.3 * (1.0 + t)), curve(16, |t| 1.1 * (1.0 + t)));
        let comparison = comparison(exact("1+t"), Measure::L2);
        let coupling = distance(&coarse, &fine, &comparison).unwrap();
        assert!((coupling - 0.2).abs() < 1e-14, "{coupling}");
    }
}
