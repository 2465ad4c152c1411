//! Tables of a summary.

use maud::{Markup, html};

use super::number::{count, limit, maybe, quantity};
use crate::folder::summary::{PresetNote, Summary};

/// A table; columns of class `n` hold numbers.
pub(super) fn table(head: &[(&str, &str)], rows: Vec<Vec<Markup>>) -> Markup {
    html! {
        div.table {
            table {
                thead { tr { @for (title, class) in head { th class=(class) { (title) } } } }
                tbody {
                    @for row in rows {
                        tr { @for (cell, (_, class)) in row.into_iter().zip(head) { td class=(class) { (cell) } } }
                    }
                }
            }
        }
    }
}

/// Energies of processes, links and the whole.
pub(super) fn energy(summary: &Summary) -> Option<Markup> {
    let head = [
        ("Part", ""),
        ("At t = 0 [J]", "n"),
        ("Final [J]", "n"),
        ("Smallest [J]", "n"),
        ("Largest [J]", "n"),
        ("Dissipated [J]", "n"),
        ("Supplied [J]", "n"),
        ("Largest balance [J]", "n"),
    ];
    let rows: Vec<_> = summary
        .energy
        .iter()
        .map(|e| {
            let values = [e.final_j, e.min_j, e.max_j, e.dissipated_j, e.supplied_j, e.max_balance_j];
            let first = [html! { code { (e.name) } }, html! { (maybe(e.initial_j)) }];
            first.into_iter().chain(values.map(|v| html! { (quantity(v)) })).collect()
        })
        .collect();
    let text = "Kinetic and potential, and what links between processes store. Dissipated is what friction, damping and \
                plasticity took since t = 0, supplied what came from outside: wind, kicks, what is driven, what flows in. The \
                balance is energy and dissipated less supplied: where every loss is measured by itself it stays at the \
                start, and nothing may raise it.";
    let lost = summary
        .lost_j()
        .map(|gone| format!("{} J are in no book: impact took them, and the damping of the methods.", quantity(gone)));
    let budget = summary.energy_budget.as_ref().map(|budget| {
        let class = if budget.is_kept { "good" } else { "warn" };
        html! { p { strong class=(class) { "Budget" } ": " (budget.words()) "." } }
    });
    (!rows.is_empty()).then(|| {
        html! {
            @if let Some(budget) = budget { (budget) }
            p { (text) }
            (table(&head, rows))
            @if let Some(lost) = lost { p { (lost) } }
        }
    })
}

/// How wrong the run is by its own measurements.
pub(super) fn estimates(summary: &Summary) -> Option<Markup> {
    let head = [
        ("Estimate", ""),
        ("Of", ""),
        ("Size", "n"),
        ("Usual below", "n"),
        ("What it means", ""),
        ("What lowers it", ""),
    ];
    let rows = summary.estimates.iter().map(|e| {
        let class = if e.is_high { "warn" } else { "good" };
        vec![
            html! { span class=(class) { (e.name) } },
            html! { code { (e.of) } },
            html! { (quantity(e.value)) },
            html! { (limit(e.usual)) },
            html! { (e.meaning) },
            html! { (e.remedy) },
        ]
    });
    let text = "Measured while the run went on, without a reference: not the error of the result, but what it is made of. \
                Sizes are relative where the name says no unit.";
    (!summary.estimates.is_empty()).then(|| html! { p { (text) } (table(&head, rows.collect())) })
}

/// What moved.
pub(super) fn bodies(summary: &Summary) -> Option<Markup> {
    let head = [
        ("Body", ""),
        ("Process", ""),
        ("Mass [kg]", "n"),
        ("Particles", "n"),
        ("Gaussians", "n"),
        ("Largest displacement [m]", "n"),
    ];
    let rows: Vec<_> = summary
        .bodies
        .iter()
        .map(|b| {
            vec![
                html! { code { (b.name) } },
                html! { code { (b.solver) } },
                html! { (quantity(b.mass_kg)) },
                html! { (count(b.particles)) },
                html! { (count(b.gaussians)) },
                html! { (quantity(b.max_displacement_m)) },
            ]
        })
        .collect();
    (!rows.is_empty()).then(|| table(&head, rows))
}

/// What crossed.
pub(super) fn interfaces(summary: &Summary) -> Option<Markup> {
    let head = [
        ("Interface", ""),
        ("Kind", ""),
        ("Resolver", ""),
        ("Given x, y, z [N s]", "n"),
        ("Gross impulse [N s]", "n"),
        ("Transfer defect [N s]", "n"),
        ("Closure [1]", "n"),
        ("Work defect [J]", "n"),
        ("Residual", "n"),
    ];
    let rows: Vec<_> = summary
        .interfaces
        .iter()
        .map(|i| {
            let values = [i.gross_impulse, i.transfer_defect, i.closure, i.work_defect, i.residual];
            let given = i.impulse_given.map(quantity).join(", ");
            let first = [
                html! { code { (i.a) "~" (i.b) } },
                html! { (i.kind) },
                html! { @if let Some(resolver) = &i.resolver { code { (resolver) } } @else { "both" } },
                html! { (given) },
            ];
            first.into_iter().chain(values.map(|v| html! { (quantity(v)) })).collect()
        })
        .collect();
    let text = "Impulses are sums over the run. The work defect is energy that the exchange made (positive) or lost; the \
                residual is the largest difference between a stand-in and the partner itself.";
    (!rows.is_empty()).then(|| html! { p { (text) } (table(&head, rows)) })
}

/// What the numbers of published materials mean.
pub(super) fn presets(summary: &Summary) -> Option<Markup> {
    let head = [("Material", ""), ("Published in", ""), ("How its numbers are read", "")];
    let row = |p: &PresetNote| vec![html! { code { (p.name) } }, html! { (p.source) }, html! { (p.note) }];
    (!summary.presets.is_empty()).then(|| table(&head, summary.presets.iter().map(row).collect()))
}

/// What was not started, computed, sent or written.
pub(super) fn left_out(summary: &Summary) -> Option<Markup> {
    let head = [("What", ""), ("Why", ""), ("Indicator", "n"), ("Limit", "n"), ("Saved", "")];
    let rows: Vec<_> = summary
        .left_out
        .iter()
        .map(|l| {
            vec![
                html! { (l.what) },
                html! { (l.why) },
                html! { (maybe(l.indicator)) },
                html! { (l.limit.map_or_else(|| "–".into(), limit)) },
                html! { (l.saved) },
            ]
        })
        .collect();
    (!rows.is_empty()).then(|| table(&head, rows))
}

/// Clamps, quarantines, overflows and the like.
pub(super) fn counters(summary: &Summary) -> Markup {
    let rows: Vec<_> = summary
        .counters
        .iter()
        .flat_map(|(process, counters)| {
            counters
                .iter()
                .map(move |(name, n)| vec![html! { code { (process) } }, html! { (name) }, html! { (count(*n)) }])
        })
        .collect();
    if rows.is_empty() {
        return html! { p { "Nothing was clamped, put aside or lost." } };
    }
    table(&[("Process", ""), ("What", ""), ("Times", "n")], rows)
}
