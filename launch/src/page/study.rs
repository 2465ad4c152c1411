//! `study.html`: what results are worth, and what they take. One file without scripts.

use maud::{DOCTYPE, Markup, PreEscaped, html};

use super::number::{count, limit, maybe, quantity};
use super::parts::command;
use super::scatter::{Join, Scatter, Series, figure};
use super::tables::table;
use crate::study::case::Claim;
use crate::study::outcome::Class;
use crate::study::result::{CaseResult, Group, Judged, Row};

/// Everything that the page tells.
#[derive(Debug)]
pub(crate) struct Page<'a> {
    /// Cases with their runs.
    pub(crate) cases: &'a [CaseResult],
    /// How the study was started, program first.
    pub(crate) command: &'a [String],
    /// Version of the program.
    pub(crate) version: &'a str,
    /// What it ran on.
    pub(crate) machine: &'a str,
}

/// The page.
pub(crate) fn html(page: &Page<'_>) -> String {
    let green = page.cases.iter().filter(|case| case.is_green()).count();
    let title = match page.cases {
        [only] => only.title.clone(),
        many => format!("Study of {} cases", many.len()),
    };
    let is_one = page.cases.len() == 1;
    let markup = html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta name="viewport" content="width=device-width, initial-scale=1";
                title { (title) }
                style { (PreEscaped(include_str!("style.css"))) }
            }
            body {
                header {
                    h1 { (title) }
                    @if !is_one { p.lead { "All gates of " (green) " of " (page.cases.len()) " cases hold." } }
                    p { (page.machine) ", cosplat " (page.version) }
                }
                @if !is_one {
                    nav { @for case in page.cases { a href={ "#" (case.name) } { (case.name) } } }
                }
                main {
                    @if !is_one { (matrix(page.cases)) }
                    @for case in page.cases {
                        section id=(case.name) {
                            @if !is_one { h2 { (case.title) } }
                            (self::case(case))
                        }
                    }
                    section id="again" {
                        h2 { "How to do it again" }
                        pre { code { (command(page.command)) } }
                        p { "Runs that are there already are kept: remove the folder of the study to measure their times again." }
                    }
                }
                footer { "Every number on this page was measured in the runs that it describes. SI units; errors are relative. Times are wall times inside the windows: starting processes and setting them up is not in them." }
            }
        }
    };
    markup.into_string()
}

/// One line a case.
fn matrix(cases: &[CaseResult]) -> Markup {
    let head = [
        ("Case", ""),
        ("Runs", "n"),
        ("Smallest error", "n"),
        ("Gates", ""),
        ("Order", ""),
        ("Time of that run [s]", "n"),
        ("1 % costs [s]", "n"),
    ];
    let rows = cases.iter().map(|case| {
        let best = case.front.last().map(|&i| &case.rows[i]);
        let wall = |row: &Row| row.cost.as_ref().map(|c| c.wall_s);
        let one_percent = case.cheapest.iter().find(|c| c.error == 0.01).and_then(|c| c.row);
        vec![
            html! { a href={ "#" (case.name) } { (case.name) } },
            html! { (case.rows.len()) },
            html! { (maybe(case.smallest_error())) },
            gates_in_short(case),
            html! { (orders(case)) },
            html! { (maybe(best.and_then(wall))) },
            html! { (maybe(one_percent.and_then(|i| wall(&case.rows[i])))) },
        ]
    });
    table(&head, rows.collect())
}

fn gates_in_short(case: &CaseResult) -> Markup {
    let judged = case.gates.iter().filter(|g| g.passed.is_some()).count();
    let failed = case.gates.iter().filter(|g| g.passed == Some(false)).count();
    html! {
        @if judged == 0 { "none" }
        @else if failed == 0 { strong.good { "all " (judged) " hold" } }
        @else { strong.bad { (failed) " of " (judged) " failed" } }
    }
}

/// Orders of all groups that have one.
fn orders(case: &CaseResult) -> String {
    let orders = case.groups.iter().filter_map(|g| g.fit.as_ref()).map(|fit| format!("{:.2}", fit.order));
    let orders: Vec<String> = orders.collect();
    if orders.is_empty() { "–".into() } else { orders.join(", ") }
}

fn case(case: &CaseResult) -> Markup {
    html! {
        p { "Scene " code { (case.scene) } ". Reference: " (case.reference) "." }
        @for note in &case.notes { p.warn { (note) } }
        @if !case.gates.is_empty() { h3 { "Gates" } (gates(case)) }
        div.charts {
            (work_precision(case))
            @if case.groups.iter().any(|g| g.fit.is_some()) { (order_plot(case)) }
            @if case.rows.iter().any(|row| row.error_coupling.is_some()) { (split_plot(case)) }
        }
        h3 { "Cheapest run below an error" }
        (cheapest(case))
        @if case.groups.iter().any(|g| g.fit.is_some()) { h3 { "Order of convergence" } (fits(case)) }
        h3 { "What is measured" }
        (quantities(case))
        details open { summary { "All runs" } (runs(case)) }
    }
}

fn claim(claim: Claim) -> String {
    match claim {
        Claim::Order([least, most]) => format!("order between {} and {}", limit(least), limit(most)),
        Claim::Error(most) => format!("error of at most {}", limit(most)),
        Claim::Outcome(class) => format!("every run is {}", class.word()),
    }
}

fn gates(case: &CaseResult) -> Markup {
    let head = [("Verdict", ""), ("Runs", ""), ("Claim", ""), ("Measured", "n"), ("Why it must hold", "")];
    let row = |judged: &Judged| {
        let (class, word) = match judged.passed {
            Some(true) => ("good", "holds"),
            Some(false) => ("bad", "failed"),
            None => ("warn", "not judged"),
        };
        let place: Vec<String> = judged.gate.r#where.iter().map(|(k, v)| format!("{k}={v}")).collect();
        let of = judged.gate.quantity.as_ref().map(|name| format!(" ({name})")).unwrap_or_default();
        vec![
            html! { strong class=(class) { (word) } },
            html! { @if place.is_empty() { "all" } @else { code { (place.join(" ")) } } },
            html! { (claim(judged.gate.claim)) (of) },
            html! { (judged.measured) },
            html! { (judged.gate.reason) },
        ]
    };
    table(&head, case.gates.iter().map(row).collect())
}

/// Place of a group among the colours.
fn shown(group: &Group) -> String {
    if group.name.is_empty() { "runs".into() } else { group.name.clone() }
}

fn work_precision(case: &CaseResult) -> Markup {
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
        note: "Each point is a run; the line of a group goes from its coarsest to its finest. Runs that complain are not shown.",
        series: [front].into_iter().chain(groups).filter(|s| !s.points.is_empty()).collect(),
    })
}

fn order_plot(case: &CaseResult) -> Markup {
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

fn split_plot(case: &CaseResult) -> Markup {
    let names: Vec<String> = case.rows.iter().map(Row::name).collect();
    let mut series = Vec::new();
    for (style, group) in case.groups.iter().enumerate() {
        let of = |part: fn(&Row) -> Option<f64>| -> Vec<(f64, f64, &str)> {
            let point = |&i: &usize| Some((case.rows[i].axis?, part(&case.rows[i])?, names[i].as_str()));
            group.rows.iter().filter_map(point).collect()
        };
        let parts = [("coupling", Join::Thin, of(|r| r.error_coupling)), ("solvers", Join::Dashed, of(|r| r.error_solver))];
        series.extend(parts.into_iter().filter(|p| !p.2.is_empty()).map(|(name, line, points)| Series {
            name: format!("{name}: {}", shown(group)),
            style,
            line,
            points,
        }));
    }
    figure(&Scatter {
        title: "Whose error it is",
        x: "clock.window [s]",
        y: "relative error [1]",
        note: "Coupling: distance from the run of the group with the shortest window. Solvers: error of that run. Only the sum is what a user sees.",
        series,
    })
}

fn cheapest(case: &CaseResult) -> Markup {
    let head = [("Error at most", "n"), ("Run", ""), ("Error", "n"), ("Time [s]", "n"), ("× real time", "n")];
    let row = |wanted: &crate::study::front::Cheapest| {
        let row = wanted.row.map(|i| &case.rows[i]);
        let cost = row.and_then(|row| row.cost.as_ref());
        vec![
            html! { (limit(100.0 * wanted.error)) " %" },
            html! { @if let Some(row) = row { code { (row.name()) } } @else { "none of these runs" } },
            html! { (maybe(row.and_then(|row| row.error))) },
            html! { (maybe(cost.map(|c| c.wall_s))) },
            html! { (maybe(cost.map(|c| c.simulated_s / c.wall_s).filter(|r| r.is_finite()))) },
        ]
    };
    table(&head, case.cheapest.iter().map(row).collect())
}

fn fits(case: &CaseResult) -> Markup {
    let head =
        [("Runs", ""), ("Order", "n"), ("95 % interval", "n"), ("Levels", "n"), ("Floor", "n"), ("Order above it", "n")];
    let row = |group: &Group| {
        let fit = group.fit.as_ref()?;
        let floor = fit.with_floor.as_ref();
        Some(vec![
            html! { (shown(group)) },
            html! { (format!("{:.3}", fit.order)) },
            html! { (fit.plus_minus.map_or_else(|| "–".into(), |half| format!("± {half:.3}"))) },
            html! { (fit.levels) },
            html! { (maybe(floor.map(|f| f.floor))) },
            html! { (floor.map_or_else(|| "–".into(), |f| format!("{:.3}", f.order))) },
        ])
    };
    let text = "Least squares on the logarithms, with the interval of Student's t distribution. A floor is what is left of \
                the error however fine the axis is; it is given where it explains at least half of what the straight line \
                leaves over.";
    html! { (table(&head, case.groups.iter().filter_map(row).collect())) p { (text) } }
}

fn quantities(case: &CaseResult) -> Markup {
    let head = [("Quantity", ""), ("Norm", ""), ("Against", "")];
    let row = |q: &crate::study::result::Measured| {
        let norm = match q.measure {
            Some(crate::study::case::Measure::L2) => "root mean square, relative",
            Some(crate::study::case::Measure::Max) => "largest difference, relative",
            Some(crate::study::case::Measure::Final) => "difference at the end, relative",
            None => "largest deviation, relative; not in the error of the case where something has a reference",
        };
        vec![html! { code { (q.name) } }, html! { (norm) }, html! { (q.reference) }]
    };
    table(&head, case.quantities.iter().map(row).collect())
}

fn runs(case: &CaseResult) -> Markup {
    let mut head: Vec<(&str, &str)> = case.vary.iter().map(|factor| (factor.key.as_str(), "")).collect();
    head.extend([("Outcome", ""), ("Error", "n")]);
    head.extend(case.quantities.iter().map(|q| (q.name.as_str(), "n")));
    head.extend([
        ("Coupling", "n"),
        ("Solvers", "n"),
        ("Time [s]", "n"),
        ("Spread", "n"),
        ("Core [s]", "n"),
        ("Waiting [s]", "n"),
        ("Substeps", "n"),
        ("Energy drift", "n"),
        ("Momentum defect", "n"),
    ]);
    let row = |row: &Row| {
        let cost = row.cost.as_ref();
        let mut cells: Vec<Markup> = row.settings.iter().map(|(_, value)| html! { (value) }).collect();
        cells.extend([outcome(row), html! { (maybe(row.error)) }]);
        cells.extend(row.errors.iter().map(|error| html! { (maybe(*error)) }));
        cells.extend([
            html! { (maybe(row.error_coupling)) },
            html! { (maybe(row.error_solver)) },
            html! { (maybe(cost.map(|c| c.wall_s))) },
            html! { (cost.map_or_else(|| "–".into(), |c| format!("{:.0} %", 100.0 * c.wall_spread))) },
            html! { (maybe(cost.and_then(|c| c.core_s))) },
            html! { (maybe(cost.map(|c| c.sum(|p| p.wait_s)))) },
            html! { (row.substeps.map_or_else(|| "–".into(), count)) },
            html! { (maybe(row.energy_drift)) },
            html! { (maybe(row.momentum_defect)) },
        ]);
        cells
    };
    table(&head, case.rows.iter().map(row).collect())
}

fn outcome(row: &Row) -> Markup {
    let class = match row.outcome {
        Some(Class::Correct) => "good",
        Some(Class::Degraded | Class::Refused) => "warn",
        Some(Class::Failed) | None => "bad",
    };
    let why = match (&row.why, row.counters) {
        (Some(why), _) => format!(": {why}"),
        (None, n) if n > 0 => format!(": {} counted", quantity(n as f64)),
        _ => String::new(),
    };
    html! { span class=(class) { (row.outcome.map_or("not run", Class::word)) } (why) }
}
