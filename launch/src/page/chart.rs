//! Curves as SVG.

use std::error::Error;

use maud::{Markup, PreEscaped, html};
use plotters::prelude::{
    ChartBuilder, DashedLineSeries, IntoDrawingArea as _, LineSeries, RGBColor, SVGBackend, WHITE,
};
use plotters::style::text_anchor::{HPos, Pos, VPos};
use plotters::style::{Color as _, IntoFont as _, IntoTextStyle as _};

use super::axis::{Axis, FINEST, LARGEST, Range, drawable, has_zero, is_zero, tick};
use super::number::limit;
use super::{Chart, Line};

/// Size of a drawing \[px\]; the page scales it.
const SIZE: (u32, u32) = (720, 300);
/// Where the name of the time axis stands \[px\].
const TIME_PLACE: (i32, i32) = (390, 296);
/// Columns in which a curve may have its own smallest and largest value.
const COLUMNS: usize = 600;
/// Colours that people with any colour vision can tell apart (Okabe & Ito 2008), and grey.
const COLOURS: [RGBColor; 8] = [
    RGBColor(0, 114, 178),
    RGBColor(213, 94, 0),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(230, 159, 0),
    RGBColor(86, 180, 233),
    RGBColor(0, 0, 0),
    RGBColor(120, 120, 120),
];

/// All charts of a section; none where there is none.
pub(super) fn section(charts: &[Chart<'_>]) -> Option<Markup> {
    (!charts.is_empty()).then(|| html! { div.charts { @for chart in charts { (figure(chart)) } } })
}

/// One chart with its legend.
pub(super) fn figure(chart: &Chart<'_>) -> Markup {
    let lost: usize = chart.lines.iter().map(|l| l.points.iter().filter(|p| !drawable(chart, p.1)).count()).sum();
    let mut values = chart.lines.iter().flat_map(|l| &l.points).map(|p| p.1).peekable();
    let all_zero = chart.logarithmic && values.peek().is_some() && values.all(|v| v == 0.0);
    html! {
        figure.chart {
            h3 { (chart.title) " [" (chart.unit) "]" }
            @if all_zero {
                p { "Every value is exactly 0." }
            } @else {
                // Drawing into a string cannot fail; should it, the reader is told.
                @match svg(chart) {
                    Ok(svg) => div.drawing role="img" aria-label=(chart.title) { (PreEscaped(svg)) },
                    Err(_) => p { "These curves cannot be drawn." },
                }
            }
            figcaption {
                @for (i, line) in chart.lines.iter().enumerate() { (legend(line, COLOURS[i % COLOURS.len()])) }
                @if !chart.note.is_empty() { p { (chart.note) } }
                @if chart.logarithmic && !all_zero && has_zero(chart) { p { "Values of exactly 0 lie on the lower edge." } }
                @if lost > 0 { p.bad { (lost) " values are not numbers that this axis can show." } }
            }
        }
    }
}

fn legend(line: &Line<'_>, colour: RGBColor) -> Markup {
    let style = format!("border-color:{}", hex(colour));
    html! {
        span.key { i.line style=(style) {} (line.name) }
        @if let Some(gate) = line.gate {
            " " span.key { i.line.dashed style=(style) {} "gate " (limit(gate)) }
        }
        " "
    }
}

fn hex(RGBColor(r, g, b): RGBColor) -> String {
    format!("#{r:02x}{g:02x}{b:02x}")
}

/// The drawing alone, without title and legend.
fn svg(chart: &Chart<'_>) -> Result<String, Box<dyn Error>> {
    let axis = Axis::of(chart);
    let times = chart.lines.iter().flat_map(|l| &l.points).map(|p| p.0).filter(|t| t.abs() <= LARGEST);
    let time = Range::of(times).unwrap_or(Range { from: 0.0, to: 1.0 });
    let time = if time.to - time.from > FINEST * time.to.abs() { time } else { time.with_margin() };
    let mut text = String::new();
    {
        let area = SVGBackend::with_string(&mut text, SIZE).into_drawing_area();
        area.fill(&WHITE)?;
        let mut plot = ChartBuilder::on(&area)
            .margin(8)
            .margin_right(18)
            .x_label_area_size(42)
            .y_label_area_size(78)
            .build_cartesian_2d(time.from..time.to, axis.range.from..axis.range.to)?;
        let letters = ("sans-serif", 13).into_font().color(&RGBColor(40, 40, 40));
        plot.configure_mesh()
            .light_line_style(WHITE)
            .bold_line_style(RGBColor(225, 225, 225))
            .axis_style(RGBColor(90, 90, 90))
            .x_labels(8)
            .y_labels(axis.labels())
            .label_style(letters.clone())
            .x_label_formatter(&|t| tick(*t, time))
            .y_label_formatter(&|v| axis.label(*v))
            .draw()?;
        let below = letters.pos(Pos::new(HPos::Center, VPos::Bottom)).into_text_style(&area);
        area.draw_text("simulated time [s]", &below, TIME_PLACE)?;
        for (i, line) in chart.lines.iter().enumerate() {
            let colour = COLOURS[i % COLOURS.len()];
            if let Some(gate) = line.gate.filter(|&g| drawable(chart, g) && !(chart.logarithmic && is_zero(g))) {
                let ends = [(time.from, axis.place(gate)), (time.to, axis.place(gate))];
                plot.draw_series(DashedLineSeries::new(ends, 6, 4, colour.stroke_width(1)))?;
            }
            for piece in pieces(chart, line, &axis, time) {
                plot.draw_series(LineSeries::new(piece, colour.stroke_width(2)))?;
            }
        }
        area.present()?;
    }
    Ok(text)
}

/// The curve without what cannot be drawn, thinned to what can be seen.
fn pieces(chart: &Chart<'_>, line: &Line<'_>, axis: &Axis, time: Range) -> Vec<Vec<(f64, f64)>> {
    let mut pieces = vec![Vec::new()];
    for &(t, value) in &line.points {
        if t.abs() <= LARGEST && drawable(chart, value) {
            if let Some(piece) = pieces.last_mut() {
                piece.push((t, axis.place(value)));
            }
        } else {
            pieces.push(Vec::new());
        }
    }
    pieces.into_iter().filter(|piece| !piece.is_empty()).map(|piece| thinned(piece, time)).collect()
}

/// First, smallest, largest and last point of every column: the drawing is the same, and its size bounded.
fn thinned(points: Vec<(f64, f64)>, time: Range) -> Vec<(f64, f64)> {
    if points.len() <= 4 * COLUMNS {
        return points;
    }
    let column = |t: f64| ((t - time.from) / (time.to - time.from) * COLUMNS as f64) as usize;
    let mut kept = Vec::new();
    for same in points.chunk_by(|a, b| column(a.0) == column(b.0)) {
        let extreme = |largest: bool| {
            let of = |i: &usize| if largest { same[*i].1 } else { -same[*i].1 };
            (0..same.len()).max_by(|a, b| of(a).total_cmp(&of(b))).unwrap_or_default()
        };
        let mut chosen = [0, extreme(false), extreme(true), same.len() - 1];
        chosen.sort_unstable();
        let mut last = None;
        for i in chosen.into_iter().filter(|&i| last.replace(i) != Some(i)) {
            kept.push(same[i]);
        }
    }
    kept
}

#[cfg(test)]
mod tests {
    use super::*;

    fn chart(logarithmic: bool, points: Vec<(f64, f64)>, gate: Option<f64>) -> Chart<'static> {
        Chart { title: "x", unit: "1", logarithmic, note: "", lines: vec![Line { name: "a", gate, points }] }
    }

    #[test]
    fn thinning_keeps_every_peak() {
        let mut points: Vec<(f64, f64)> = (0..100_000).map(|i| (f64::from(i) * 1e-3, 1.0)).collect();
        points[54_321].1 = 7.0;
        points[54_322].1 = -7.0;
        let kept = thinned(points, Range { from: 0.0, to: 99.999 });
        assert!(kept.len() <= 4 * (COLUMNS + 1), "{}", kept.len());
        assert!(kept.contains(&(54.321, 7.0)) && kept.contains(&(54.322, -7.0)));
        assert!(kept.windows(2).all(|w| w[0].0 < w[1].0));
    }

    #[test]
    fn any_numbers_draw() {
        let wild = vec![(f64::NAN, 1.0), (0.0, f64::INFINITY), (0.1, -1.0), (0.2, 1e-320), (0.3, 1e308), (0.4, 0.0)];
        for logarithmic in [false, true] {
            let fine = vec![(1.0, 1.0), (1.0 + f64::EPSILON, 1.0 + f64::EPSILON)];
            for points in [wild.clone(), fine, Vec::new(), vec![(0.0, 0.0)], vec![(0.0, -1e308), (1.0, 1e100)]] {
                for gate in [None, Some(0.0), Some(f64::NAN), Some(1e-12)] {
                    let drawing = svg(&chart(logarithmic, points.clone(), gate)).unwrap();
                    assert!(drawing.starts_with("<svg") && drawing.trim_end().ends_with("</svg>"));
                    assert!(!drawing.contains("NaN") && !drawing.contains("inf"), "{drawing}");
                }
            }
        }
    }
}
