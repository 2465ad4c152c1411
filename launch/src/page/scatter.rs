//! Points on two logarithmic axes as SVG: error against time, and error against what was varied.

use maud::{Markup, html};

use super::number::{limit, power_of_ten};

/// Size of a drawing in its own units; the page scales it.
const SIZE: (f64, f64) = (720.0, 380.0);
/// Left, right, upper and lower edge of the area with points.
const AREA: [f64; 4] = [84.0, 706.0, 12.0, 330.0];
/// Colours that people with any colour vision can tell apart (Okabe & Ito 2008), and grey. Each goes with a form.
const COLOURS: [&str; 8] = ["#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#000000", "#787878"];
/// Forms of points.
const FORMS: usize = 4;

/// A diagram.
#[derive(Debug)]
pub(crate) struct Scatter {
    /// What is shown.
    pub(crate) title: &'static str,
    /// Name and unit of the horizontal axis.
    pub(crate) x: String,
    /// Name and unit of the vertical axis.
    pub(crate) y: String,
    /// What a reader must know; may be empty.
    pub(crate) note: &'static str,
    /// The points.
    pub(crate) series: Vec<Series>,
}

/// Points of one kind.
#[derive(Debug)]
pub(crate) struct Series {
    /// Name in the legend.
    pub(crate) name: String,
    /// Place of its colour and form.
    pub(crate) style: usize,
    /// How its points are joined.
    pub(crate) line: Join,
    /// Place, and what is shown when pointed at. What is not positive is left out.
    pub(crate) points: Vec<(f64, f64, String)>,
}

/// How points are joined.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Join {
    /// Not at all.
    Apart,
    /// By a thin line.
    Thin,
    /// By a dashed line without points of its own.
    Dashed,
    /// By a thick grey line without points of its own.
    Thick,
}

/// The diagram with its legend.
pub(super) fn figure(scatter: &Scatter) -> Markup {
    let places = || scatter.series.iter().flat_map(|s| &s.points).filter(|p| is_drawable(p));
    let lost = scatter.series.iter().flat_map(|s| &s.points).filter(|p| !is_drawable(p)).count();
    html! {
        figure.chart {
            h3 { (scatter.title) }
            @if places().next().is_none() { p { "There is nothing that a logarithmic axis could show." } }
            @else { div.drawing role="img" aria-label=(scatter.title) { (svg(scatter, Axis::of(places().map(|p| p.0)), Axis::of(places().map(|p| p.1)))) } }
            figcaption {
                @for series in &scatter.series { (legend(series)) }
                @if !scatter.note.is_empty() { p { (scatter.note) } }
                @if lost > 0 { p { (lost) " points are 0 or no numbers, which no logarithmic axis shows." } }
            }
        }
    }
}

fn is_drawable(point: &(f64, f64, String)) -> bool {
    [point.0, point.1].iter().all(|v| (1e-300..1e300).contains(v))
}

/// Logarithms of the ends of an axis.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Axis {
    from: f64,
    to: f64,
}

impl Axis {
    /// Around some values, with a margin.
    fn of(values: impl Iterator<Item = f64>) -> Self {
        let (from, to) =
            values.map(f64::log10).fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| (a.min(v), b.max(v)));
        let margin = (0.06 * (to - from)).max(0.12);
        Self { from: from - margin, to: to + margin }
    }

    /// Share of the axis below a value.
    fn share(self, value: f64) -> f64 {
        (value.log10() - self.from) / (self.to - self.from)
    }

    /// Round values on the axis: 1, 2 and 5 of each decade, more of them where there is less than one, and decades alone
    /// where there are many.
    fn ticks(self) -> Vec<f64> {
        let (first, last) = (self.from.floor() as i32, self.to.ceil() as i32);
        let span = self.to - self.from;
        let steps: &[f64] = match span {
            ..0.8 => &[1.0, 1.5, 2.0, 3.0, 4.0, 5.0, 7.0],
            0.8..2.5 => &[1.0, 2.0, 5.0],
            _ => &[1.0],
        };
        let every = (span / 9.0).ceil().max(1.0) as i32;
        let decades = (first..=last).filter(|d| d.rem_euclid(every) == 0);
        let all = decades.flat_map(|d| steps.iter().map(move |s| s * 10.0_f64.powi(d)));
        all.filter(|v| (0.0..=1.0).contains(&self.share(*v))).collect()
    }
}

fn tick(value: f64) -> String {
    if (1e-3..1e4).contains(&value) {
        return limit(value);
    }
    let exponent = (value.log10() + 1e-9).floor();
    let digit = (10.0 * value / 10.0_f64.powf(exponent)).round() / 10.0;
    let power = power_of_ten(exponent as i32);
    if (digit - 1.0).abs() < 0.05 { power } else { format!("{digit}·{power}") }
}

fn svg(scatter: &Scatter, x: Axis, y: Axis) -> Markup {
    let [left, right, top, bottom] = AREA;
    let at = |point: &(f64, f64, String)| {
        (left + x.share(point.0) * (right - left), bottom - y.share(point.1) * (bottom - top))
    };
    let number = |v: f64| format!("{v:.1}");
    html! {
        svg viewBox=(format!("0 0 {} {}", SIZE.0, SIZE.1)) xmlns="http://www.w3.org/2000/svg" font-family="sans-serif" font-size="13" fill="#282828" {
            @for value in x.ticks() {
                @let place = number(left + x.share(value) * (right - left));
                line x1=(place) x2=(place) y1=(number(top)) y2=(number(bottom)) stroke="#e1e1e1" {}
                text x=(place) y=(number(bottom + 18.0)) text-anchor="middle" { (tick(value)) }
            }
            @for value in y.ticks() {
                @let place = bottom - y.share(value) * (bottom - top);
                line x1=(number(left)) x2=(number(right)) y1=(number(place)) y2=(number(place)) stroke="#e1e1e1" {}
                text x=(number(left - 8.0)) y=(number(place + 4.5)) text-anchor="end" { (tick(value)) }
            }
            rect x=(number(left)) y=(number(top)) width=(number(right - left)) height=(number(bottom - top)) fill="none" stroke="#5a5a5a" {}
            text x=(number(f64::midpoint(left, right))) y=(number(SIZE.1 - 8.0)) text-anchor="middle" { (scatter.x) }
            text x="16" y=(number(f64::midpoint(top, bottom))) text-anchor="middle" transform=(format!("rotate(-90 16 {})", number(f64::midpoint(top, bottom)))) { (scatter.y) }
            @for series in &scatter.series {
                @let points: Vec<_> = series.points.iter().filter(|p| is_drawable(p)).collect();
                @if series.line != Join::Apart {
                    @let path: Vec<String> = points.iter().map(|p| at(p)).map(|(x, y)| format!("{x:.1},{y:.1}")).collect();
                    (joined(series, &path.join(" ")))
                }
                @if matches!(series.line, Join::Apart | Join::Thin) {
                    @for point in points {
                        @let (x, y) = at(point);
                        g { title { (point.2) } (mark(x, y, series.style)) }
                    }
                }
            }
        }
    }
}

pub(crate) fn colour(style: usize) -> &'static str {
    COLOURS[style % COLOURS.len()]
}

fn joined(series: &Series, points: &str) -> Markup {
    let (width, dashes, colour) = match series.line {
        Join::Thick => ("7", "none", "#d5d8db"),
        Join::Dashed => ("1.6", "6 4", colour(series.style)),
        Join::Thin | Join::Apart => ("1.2", "none", colour(series.style)),
    };
    html! { polyline points=(points) fill="none" stroke=(colour) stroke-width=(width) stroke-dasharray=(dashes) stroke-linejoin="round" stroke-linecap="round" {} }
}

/// A point: circle, square, triangle or diamond.
fn mark(x: f64, y: f64, style: usize) -> Markup {
    let polygon = |corners: &[(f64, f64)]| {
        let points: Vec<String> = corners.iter().map(|(dx, dy)| format!("{:.1},{:.1}", x + dx, y + dy)).collect();
        html! { polygon points=(points.join(" ")) fill=(colour(style)) stroke="#fff" stroke-width="0.8" {} }
    };
    match style % FORMS {
        0 => {
            html! { circle cx=(format!("{x:.1}")) cy=(format!("{y:.1}")) r="5" fill=(colour(style)) stroke="#fff" stroke-width="0.8" {} }
        }
        1 => polygon(&[(-4.6, -4.6), (4.6, -4.6), (4.6, 4.6), (-4.6, 4.6)]),
        2 => polygon(&[(0.0, -6.0), (5.6, 4.2), (-5.6, 4.2)]),
        _ => polygon(&[(0.0, -6.4), (6.0, 0.0), (0.0, 6.4), (-6.0, 0.0)]),
    }
}

fn legend(series: &Series) -> Markup {
    html! {
        span.key {
            svg width="26" height="14" viewBox="0 0 26 14" aria-hidden="true" {
                @if series.line != Join::Apart { (joined(series, "1,7 25,7")) }
                @if matches!(series.line, Join::Apart | Join::Thin) { (mark(13.0, 7.0, series.style)) }
            }
            " " (series.name)
        }
        " "
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests::assert_well_formed;
    use super::*;

    fn drawn(points: &[(f64, f64, &str)]) -> String {
        let series = [Join::Apart, Join::Thin, Join::Dashed, Join::Thick].into_iter().enumerate();
        let points: Vec<_> = points.iter().map(|&(x, y, name)| (x, y, name.to_owned())).collect();
        let series = series.map(|(style, line)| Series { name: "<a>".into(), style, line, points: points.clone() });
        let (x, y) = ("time [s]".to_owned(), "error [1]".to_owned());
        let scatter = Scatter { title: "x", x, y, note: "", series: series.collect() };
        figure(&scatter).into_string()
    }

    #[test]
    fn any_points_draw() {
        let wild = vec![
            (0.0, 1.0, "a"),
            (f64::NAN, 1.0, "b"),
            (1.0, f64::INFINITY, "c"),
            (-1.0, 2.0, "d"),
            (1e-310, 1.0, "e"),
        ];
        for points in
            [wild, Vec::new(), vec![(1.0, 1.0, "<one>")], vec![(1e-200, 1e200, "far"), (1e200, 1e-200, "apart")]]
        {
            let page = drawn(&points);
            assert_well_formed(&format!("<!DOCTYPE html>{page}"));
            assert!(!page.contains("NaN") && !page.contains("inf"), "{page}");
        }
    }

    #[test]
    fn ticks_are_round_and_not_too_many() {
        let ticks = |from: f64, to: f64| Axis { from: from.log10(), to: to.log10() }.ticks();
        assert_eq!(ticks(0.9, 12.0).iter().map(|t| tick(*t)).collect::<Vec<_>>(), ["1", "2", "5", "10"]);
        assert!(ticks(1e-14, 1.0).len() <= 10);
        assert_eq!(ticks(2.9e-3, 5.9e-3).iter().map(|t| tick(*t)).collect::<Vec<_>>(), ["0.003", "0.004", "0.005"]);
        assert_eq!([2e-5, 1e-4, 0.05, 1e6].map(tick), ["2·10⁻⁵", "10⁻⁴", "0.05", "10⁶"]);
    }
}
