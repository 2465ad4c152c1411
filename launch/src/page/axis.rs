//! Axes of a chart: their ranges, where a value lies on them, and what stands at their ticks.

use super::Chart;
use super::number::power_of_ten;

/// Decades below the lowest gate, or below 1, when nothing else tells where a logarithmic axis begins.
const DECADES: i32 = 4;

/// Values beyond are no measurement, and the drawing library loses itself in their ranges.
pub(super) const LARGEST: f64 = 1e100;
/// Smallest height of an axis, relative to its values, in which ticks can still be told apart.
pub(super) const FINEST: f64 = 1e-9;

pub(super) fn has_zero(chart: &Chart<'_>) -> bool {
    chart.lines.iter().any(|l| l.points.iter().any(|p| is_zero(p.1)))
}

/// Whether a value is 0, or so small that no axis goes down to it.
pub(super) fn is_zero(value: f64) -> bool {
    value.abs() < 1.0 / LARGEST
}

pub(super) fn drawable(chart: &Chart<'_>, value: f64) -> bool {
    value.abs() <= LARGEST && !(chart.logarithmic && value < 0.0)
}

/// The range of an axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Range {
    pub(super) from: f64,
    pub(super) to: f64,
}

impl Range {
    /// Smallest and largest of some values.
    pub(super) fn of(values: impl Iterator<Item = f64>) -> Option<Range> {
        values.fold(None, |range: Option<Range>, v| {
            let range = range.unwrap_or(Range { from: v, to: v });
            Some(Range { from: range.from.min(v), to: range.to.max(v) })
        })
    }

    /// Widened, so that no curve lies on the frame and none has a height of zero.
    pub(super) fn with_margin(self) -> Range {
        let (span, size) = (self.to - self.from, self.from.abs().max(self.to.abs()));
        let part = if span > FINEST * size { span } else { size };
        let margin = if is_zero(part) { 1.0 } else { 0.05 * part };
        Range { from: self.from - margin, to: self.to + margin }
    }

    /// Whole decades, so that the largest value does not lie on the frame.
    fn whole(self) -> Range {
        Range { from: self.from.floor(), to: self.to.floor() + 1.0 }
    }
}

/// Values as the axis takes them: on a logarithmic axis their logarithms, with zero at the lower edge.
pub(super) struct Axis {
    pub(super) range: Range,
    logarithmic: bool,
}

impl Axis {
    pub(super) fn of(chart: &Chart<'_>) -> Axis {
        let gates = chart.lines.iter().filter_map(|l| l.gate);
        let points = chart.lines.iter().flat_map(|l| &l.points).map(|p| p.1);
        let values = points.chain(gates).filter(|&v| drawable(chart, v));
        if !chart.logarithmic {
            let range = Range::of(values).unwrap_or(Range { from: 0.0, to: 1.0 });
            return Axis { range: range.with_margin(), logarithmic: false };
        }
        let lowest = chart
            .lines
            .iter()
            .filter_map(|l| l.gate)
            .filter(|&g| !is_zero(g) && drawable(chart, g))
            .fold(1.0, f64::min);
        let seen = Range::of(values.filter(|&v| !is_zero(v)).map(f64::log10));
        let mut range = seen.unwrap_or(Range { from: lowest.log10(), to: lowest.log10() }).whole();
        if has_zero(chart) {
            range.from -= 1.0;
        }
        if range.to - range.from < 2.0 {
            range.from = range.to - f64::from(DECADES);
        }
        Axis { range, logarithmic: true }
    }

    pub(super) fn place(&self, value: f64) -> f64 {
        match (self.logarithmic, is_zero(value)) {
            (false, _) => value,
            (true, true) => self.range.from,
            (true, false) => value.log10(),
        }
    }

    /// Labels that fit; at most one a decade.
    pub(super) fn labels(&self) -> usize {
        if self.logarithmic { (self.range.to - self.range.from).min(9.0) as usize + 1 } else { 6 }
    }

    pub(super) fn label(&self, place: f64) -> String {
        if !self.logarithmic {
            return tick(place, self.range);
        }
        let nearest = place.round();
        if (place - nearest).abs() < 1e-6 { power_of_ten(nearest as i32) } else { String::new() }
    }
}

/// A number at an axis, with as many decimals as its range needs.
pub(super) fn tick(value: f64, range: Range) -> String {
    let span = range.to - range.from;
    if value.abs() < 1e-9 * span {
        return "0".into();
    }
    let largest = range.from.abs().max(range.to.abs());
    if (1e-3..1e6).contains(&largest) {
        let decimals = (2.0 - span.log10().floor()).clamp(0.0, 9.0) as usize;
        let text = format!("{value:.decimals$}");
        let text = if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.') } else { &text };
        return text.replace('-', "−");
    }
    let decimals = (1.0 + (largest / span).log10().ceil()).clamp(1.0, 9.0) as usize;
    let text = format!("{value:.decimals$e}");
    let (mantissa, exponent) = text.split_once('e').unwrap_or((&text, "0"));
    let mantissa = mantissa.trim_end_matches('0').trim_end_matches('.').replace('-', "−");
    format!("{mantissa} × {}", power_of_ten(exponent.parse().unwrap_or_default()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::page::Line;

    fn chart(logarithmic: bool, points: Vec<(f64, f64)>, gate: Option<f64>) -> Chart<'static> {
        Chart { title: "x", unit: "1", logarithmic, note: "", lines: vec![Line { name: "a", gate, points }] }
    }

    #[test]
    fn axes_hold_everything_that_is_drawn() {
        let linear = Axis::of(&chart(false, vec![(0.0, -2.0), (1.0, 8.0)], Some(10.0)));
        assert!(linear.range.from < -2.0 && linear.range.to > 10.0);
        let range = |points, gate| Axis::of(&chart(true, points, gate)).range;
        assert_eq!(range(vec![(0.0, 3e-15), (1.0, 2e-14)], Some(1e-12)), Range { from: -15.0, to: -11.0 });
        // Zero gets a decade of its own below the smallest number.
        assert_eq!(range(vec![(0.0, 0.0), (1.0, 3e-15)], Some(1e-12)), Range { from: -16.0, to: -11.0 });
        let nothing = range(vec![(0.0, 0.0), (1.0, f64::NAN)], None);
        assert!(nothing.from < nothing.to);
        // A flat curve has a height as well.
        let flat = Axis::of(&chart(false, vec![(0.0, 0.0), (1.0, 0.0)], None)).range;
        assert!(flat.from < 0.0 && flat.to > 0.0);
    }

    #[test]
    fn ticks_have_the_decimals_of_their_range() {
        let range = |from, to| Range { from, to };
        assert_eq!(tick(0.5, range(0.0, 2.0)), "0.5");
        assert_eq!(tick(1e-14, range(-1.0, 1.0)), "0");
        assert_eq!(tick(-1200.0, range(-2000.0, 0.0)), "−1200");
        assert_eq!(tick(9.8102, range(9.81, 9.8104)), "9.8102");
        assert_eq!(tick(2.5e-7, range(0.0, 1e-6)), "2.5 × 10⁻⁷");
    }
}
