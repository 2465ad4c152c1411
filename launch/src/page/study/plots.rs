//! Diagrams of a case.

use crate::page::scatter::{Join, Scatter, Series};
use crate::study::evaluate::WINDOW;
use crate::study::result::{CaseResult, Group, Row};

/// Name and unit of errors.
const ERROR: &str = "relative error [1]";

/// All diagrams of a case.
pub(crate) fn diagrams(case: &CaseResult) -> Vec<Scatter> {
    let has_order = case.groups.iter().any(|g| g.fit.is_some());
    let has_split = case.rows.iter().any(|row| row.error_coupling.is_some());
    let orders = has_order.then(|| order_plot(case));
    [work_precision(case)].into_iter().chain(orders).chain(has_split.then(|| split_plot(case))).collect()
}

/// Place of a group among the colours.
pub(super) fn shown(group: &Group) -> String {
    if group.name.is_empty() { "runs".into() } else { group.name.clone() }
}

/// Error against time, with the Pareto front.
fn work_precision(case: &CaseResult) -> Scatter {
    let names: Vec<String> = case.rows.iter().map(Row::name).collect();
    let point = |i: &usize| {
        let (wall, error) = case.rows[*i].work_and_error()?;
        Some((wall, error, names[*i].clone()))
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
    Scatter {
        title: "Error against run time",
        x: "wall time inside the windows [s]".to_owned(),
        y: ERROR.to_owned(),
        note: "Each point is a run; the line of a group goes from its coarsest to its finest. Runs with a red verdict are not shown.",
        series: [front].into_iter().chain(groups).filter(|s| !s.points.is_empty()).collect(),
    }
}

/// Error against the axis, with the fits.
fn order_plot(case: &CaseResult) -> Scatter {
    let names: Vec<String> = case.rows.iter().map(Row::name).collect();
    let mut series = Vec::new();
    for (style, group) in case.groups.iter().enumerate() {
        let points: Vec<_> = group
            .rows
            .iter()
            .filter_map(|&i| Some((case.rows[i].axis?, case.rows[i].error?, names[i].clone())))
            .collect();
        let ends = points.iter().map(|p| p.0).fold((f64::INFINITY, 0.0_f64), |(a, b), x| (a.min(x), b.max(x)));
        if let Some(fit) = group.fit.as_ref().filter(|_| case.has_powers()) {
            let line = |x: f64| (x, fit.factor * x.powf(fit.order), String::new());
            let name = format!("fit of order {:.2}", fit.order);
            series.push(Series { name, style, line: Join::Dashed, points: vec![line(ends.0), line(ends.1)] });
        }
        series.push(Series { name: shown(group), style, line: Join::Apart, points });
    }
    let axis = case.axis().unwrap_or_default();
    let title = if case.has_powers() { "Order of convergence" } else { "Error against what is varied" };
    let x = format!("{axis} [{}]", unit(axis));
    Scatter { title, x, y: ERROR.to_owned(), note: "", series }
}

/// Unit of a key of the scene, where it is known.
fn unit(key: &str) -> &'static str {
    match key.rsplit('.').next() {
        Some("window" | "duration") => "s",
        Some("spacing" | "cell") => "m",
        Some("mass") => "kg",
        Some("density") => "kg/m³",
        Some("youngs_modulus" | "yield_stress") => "Pa",
        Some("viscosity") => "Pa s",
        Some("iterations" | "max_iterations" | "density_iterations" | "courant" | "poissons_ratio") => "1",
        Some(name) if name.ends_with("_friction") => "1",
        Some(name) if name.ends_with("_s") => "s",
        _ => "in the unit of the scene",
    }
}

/// Coupling and the rest of the error, against the window.
fn split_plot(case: &CaseResult) -> Scatter {
    let names: Vec<String> = case.rows.iter().map(Row::name).collect();
    let mut groups: Vec<String> = case.rows.iter().map(|row| row.without(WINDOW)).collect();
    groups.sort_unstable();
    groups.dedup();
    let mut series = Vec::new();
    for (style, group) in groups.iter().enumerate() {
        let of = |part: fn(&Row) -> Option<f64>| -> Vec<(f64, f64, String)> {
            let members = case.rows.iter().zip(&names).filter(|(row, _)| row.without(WINDOW) == *group);
            members.filter_map(|(row, name)| Some((row.value(WINDOW)?, part(row)?, name.clone()))).collect()
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
    Scatter {
        title: "Whose error it is",
        x: "clock.window [s]".to_owned(),
        y: ERROR.to_owned(),
        note: "Coupling: distance from the run with the shortest window and all else the same. Rest: error of that run, which is that of the solvers as soon as it no longer falls with the window. Only the sum is what a user sees.",
        series,
    }
}
