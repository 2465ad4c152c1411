//! Diagrams of a case.

use maud::Markup;

use super::super::scatter::{Join, Scatter, Series, figure};
use crate::study::evaluate::WINDOW;
use crate::study::result::{CaseResult, Group, Row};

/// Place of a group among the colours.
pub(super) fn shown(group: &Group) -> String {
    if group.name.is_empty() { "runs".into() } else { group.name.clone() }
}

/// Error against time, with the Pareto front.
pub(super) fn work_precision(case: &CaseResult) -> Markup {
    let names: Vec<String> = case.rows.iter().map(Row::name).collect();
    let point = |i: &usize| {
        let (wall, error) = case.rows[*i].work_and_error()?;
        Some((wall, error, names[*i].as_str()))
    };
    let front = Series {
        name: "no run is both faster and better (Pareto front)".into(),
        style: 7,
        line: Join::Thick,
        points: case.front.iter().filter_map(point).collect(),
    };
    let groups = case.groups.iter().enumerate().map(|(style, group)| Series {
        name: shown(group),
        style,
        line: Join::Thin,
        points: group.rows.iter().filter_map(point).collect(),
    });
    figure(&Scatter {
        title: "Error against run time",
        x: "wall time inside the windows [s]",
        y: "relative error [1]",
        note: "Each point is a run; the line of a group goes from its coarsest to its finest. Runs with a red verdict are not shown.",
        series: [front].into_iter().chain(groups).filter(|s| !s.points.is_empty()).collect(),
    })
}

/// Error against the axis, with the fits.
pub(super) fn order_plot(case: &CaseResult) -> Markup {
    let names: Vec<String> = case.rows.iter().map(Row::name).collect();
    let mut series = Vec::new();
    for (style, group) in case.groups.iter().enumerate() {
        let points: Vec<_> = group
            .rows
            .iter()
            .filter_map(|&i| Some((case.rows[i].axis?, case.rows[i].error?, names[i].as_str())))
            .collect();
        let ends = points.iter().map(|p| p.0).fold((f64::INFINITY, 0.0_f64), |(a, b), x| (a.min(x), b.max(x)));
        if let Some(fit) = &group.fit {
            let line = |x: f64| (x, fit.factor * x.powf(fit.order), "");
            let name = format!("fit of order {:.2}", fit.order);
            series.push(Series { name, style, line: Join::Dashed, points: vec![line(ends.0), line(ends.1)] });
        }
        series.push(Series { name: shown(group), style, line: Join::Apart, points });
    }
    let axis = case.axis().unwrap_or_default();
    let x = format!("{axis} [{}]", unit(axis));
    figure(&Scatter { title: "Order of convergence", x: &x, y: "relative error [1]", note: "", series })
}

/// Unit of a key of the scene, where it is known.
fn unit(key: &str) -> &'static str {
    match key.rsplit('.').next() {
        Some("window") => "s",
        Some("spacing") => "m",
        _ => "in the unit of the scene",
    }
}

/// Coupling and the rest of the error, against the window.
pub(super) fn split_plot(case: &CaseResult) -> Markup {
    let names: Vec<String> = case.rows.iter().map(Row::name).collect();
    let mut groups: Vec<String> = case.rows.iter().map(|row| row.without(WINDOW)).collect();
    groups.sort_unstable();
    groups.dedup();
    let mut series = Vec::new();
    for (style, group) in groups.iter().enumerate() {
        let of = |part: fn(&Row) -> Option<f64>| -> Vec<(f64, f64, &str)> {
            let members = case.rows.iter().zip(&names).filter(|(row, _)| row.without(WINDOW) == *group);
            members.filter_map(|(row, name)| Some((row.value(WINDOW)?, part(row)?, name.as_str()))).collect()
        };
        let parts =
            [("coupling", Join::Thin, of(|r| r.error_coupling)), ("rest", Join::Dashed, of(|r| r.error_solver))];
        series.extend(parts.into_iter().filter(|p| !p.2.is_empty()).map(|(name, line, points)| Series {
            name: format!("{name} {group}"),
            style,
            line,
            points,
        }));
    }
    figure(&Scatter {
        title: "Whose error it is",
        x: "clock.window [s]",
        y: "relative error [1]",
        note: "Coupling: distance from the run with the shortest window and all else the same. Rest: error of that run, which is that of the solvers as soon as it no longer falls with the window. Only the sum is what a user sees.",
        series,
    })
}
