//! Tables of a case.

use maud::{Markup, html};

use super::super::number::{count, limit, maybe, quantity};
use super::super::tables::table;
use super::plots::shown;
use crate::study::case::{Claim, Measure};
use crate::study::front::Cheapest;
use crate::study::outcome::Class;
use crate::study::result::{CaseResult, Group, Judged, Measured, Row};

/// What a gate claims, in words.
pub(crate) fn claim(claim: Claim) -> String {
    match claim {
        Claim::Order([least, most]) => format!("order between {} and {}", limit(least), limit(most)),
        Claim::Decay([least, most]) => format!("factor per unit of the axis between {least} and {most}"),
        Claim::Error(most) => format!("error of at most {}", limit(most)),
        Claim::Outcome(class) => format!("every run is {}", class.word()),
    }
}

/// What had to hold, and whether it did.
pub(super) fn gates(case: &CaseResult) -> Markup {
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
            html! { (judged.gate.reason) (explained(judged)) },
        ]
    };
    table(&head, case.gates.iter().map(row).collect())
}

/// Why a red gate is known to be red; that nothing has to be explained any more where it holds.
fn explained(judged: &Judged) -> Markup {
    let Some(why) = &judged.gate.explained else { return html! {} };
    html! {
        @if judged.is_out_of_date() { div.warn { "The explanation is out of date: " (why) } }
        @else { div { strong { "Why it does not: " } (why) } }
    }
}

/// The cheapest run for each of a few errors.
pub(super) fn cheapest(case: &CaseResult) -> Markup {
    let head = [("Error at most", "n"), ("Run", ""), ("Error", "n"), ("Time [s]", "n"), ("× real time", "n")];
    let row = |wanted: &Cheapest| {
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

/// Orders with their intervals and floors.
pub(super) fn fits(case: &CaseResult) -> Markup {
    let head = [
        ("Runs", ""),
        ("Order", "n"),
        ("95 % interval", "n"),
        ("Levels", "n"),
        ("Floor", "n"),
        ("Order above it", "n"),
    ];
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

/// What was measured, and how.
pub(super) fn quantities(case: &CaseResult) -> Markup {
    let head = [("Quantity", ""), ("Norm", ""), ("Against", "")];
    let row = |q: &Measured| {
        let norm = match q.measure {
            Some(Measure::L2) => "root mean square, relative",
            Some(Measure::Max) => "largest difference, relative",
            Some(Measure::Final) => "difference at the end, relative",
            Some(Measure::Mean) => "difference of the means, relative",
            Some(Measure::Period) => "difference of the periods, relative",
            None => "largest deviation, relative; not in the error of the case where something has a reference",
        };
        vec![html! { code { (q.name) } }, html! { (norm) }, html! { (q.reference) }]
    };
    table(&head, case.quantities.iter().map(row).collect())
}

/// All runs.
pub(super) fn runs(case: &CaseResult) -> Markup {
    let mut head: Vec<(&str, &str)> = case.vary.iter().map(|factor| (factor.key.as_str(), "")).collect();
    head.extend([("Outcome", ""), ("Error", "n")]);
    head.extend(case.quantities.iter().map(|q| (q.name.as_str(), "n")));
    head.extend([
        ("Coupling", "n"),
        ("Rest", "n"),
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
            html! { (maybe(cost.map(|c| c.wall_s))) @if cost.is_some_and(|c| c.beside_others) { " shared" } },
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
    let why = match (&row.why, row.complaints) {
        (Some(why), _) => format!(": {why}"),
        (None, n) if n > 0 => format!(": {} complaints counted", quantity(n as f64)),
        _ => String::new(),
    };
    html! { span class=(class) { (row.outcome.map_or("not run", Class::word)) } (why) }
}
