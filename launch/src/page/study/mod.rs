//! `study.html`: what results are worth, and what they take. One file without scripts.

pub(crate) mod plots;
mod sheet;
mod suites;
pub(crate) mod tables;

use maud::{Markup, html};

use super::document;
use super::number::maybe;
use super::parts::command;
use super::scatter::figure;
use super::tables::table;
use crate::study::catalogue::Entry;
use crate::study::result::{CaseResult, Row};
use plots::diagrams;
pub(crate) use sheet::sheet;
pub(crate) use suites::{ablation, controls, stability};
use tables::{cheapest, fits, gates, quantities, runs};

/// Everything that the page tells.
#[derive(Debug)]
pub(crate) struct Page<'a> {
    /// Cases with their runs.
    pub(crate) cases: &'a [CaseResult],
    /// Published cases, and which of these answer them; empty where the study is about others.
    pub(crate) catalogue: &'a [Entry],
    /// How the study was started, program first.
    pub(crate) command: &'a [String],
    /// Version of the program.
    pub(crate) version: &'a str,
    /// What it ran on.
    pub(crate) machine: &'a str,
}

/// The page.
pub(crate) fn html(page: &Page<'_>) -> String {
    let title = match page.cases {
        [only] => only.title.clone(),
        many => format!("Study of {} cases", many.len()),
    };
    let is_one = page.cases.len() == 1;
    let body = html! {
        header {
            h1 { (title) }
            @if !is_one { p.lead { (lead(page.cases)) } }
            p { (page.machine) ", cosplat " (page.version) }
        }
        @if !is_one {
            nav { @for case in page.cases { a href={ "#" (case.name) } { (case.name) } } }
        }
        main {
            @if !is_one { (matrix(page.cases)) }
            @if !page.catalogue.is_empty() {
                section id="catalogue" { h2 { "Published cases" } (catalogue(page)) }
            }
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
    };
    document(&title, &body)
}

/// All cases in a sentence or two.
fn lead(cases: &[CaseResult]) -> String {
    let green = cases.iter().filter(|case| case.is_green()).count();
    let explained: Vec<&str> = cases
        .iter()
        .filter(|case| !case.is_green() && case.is_accounted_for())
        .map(|case| case.name.as_str())
        .collect();
    let more = match explained.as_slice() {
        [] => String::new(),
        some => format!(" Of the others these say why not, below: {}.", some.join(", ")),
    };
    format!("All gates of {green} of {} cases hold.{more}", cases.len())
}

/// One line a published case: what answers it, or why nothing does.
fn catalogue(page: &Page<'_>) -> Markup {
    let head =
        [("Published", ""), ("What it asks", ""), ("Case", ""), ("Smallest error", "n"), ("Gates", ""), ("Note", "")];
    let row = |entry: &Entry| {
        let found: Vec<&CaseResult> = page.cases.iter().filter(|case| entry.cases.contains(&case.name)).collect();
        vec![
            html! { strong { (entry.id) } },
            html! { (entry.title) },
            html! { @for case in &found { div.key { a href={ "#" (case.name) } { (case.name) } } } },
            html! { @for case in &found { div { (maybe(case.smallest_error())) } } },
            html! { @for case in &found { div.key { (gates_in_short(case)) } } },
            html! { (entry.note.replace('`', "")) },
        ]
    };
    table(&head, page.catalogue.iter().map(row).collect())
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
        vec![
            html! { a href={ "#" (case.name) } { (case.name) } },
            html! { (case.rows.len()) },
            html! { (maybe(case.smallest_error())) },
            gates_in_short(case),
            html! { (case.orders()) },
            html! { (maybe(best.and_then(wall))) },
            html! { (maybe(case.row_of_one_percent().and_then(|i| wall(&case.rows[i])))) },
        ]
    });
    table(&head, rows.collect())
}

fn gates_in_short(case: &CaseResult) -> Markup {
    let (text, is_judged) = (case.gates_in_short(), case.gates.iter().any(|g| g.passed.is_some()));
    html! {
        @if !is_judged { (text) } @else { strong class=(if case.is_green() { "good" } else { "bad" }) { (text) } }
    }
}

fn case(case: &CaseResult) -> Markup {
    html! {
        p { "Scene " code { (case.scene) } ". Reference: " (case.reference) "." }
        @for note in &case.notes { p.warn { (note.replace('`', "")) } }
        @if !case.gates.is_empty() { h3 { "Gates" } (gates(case)) }
        div.charts { @for diagram in diagrams(case) { (figure(&diagram)) } }
        h3 { "Cheapest run below an error" }
        (cheapest(case))
        @if case.has_powers() && case.groups.iter().any(|g| g.fit.is_some()) { h3 { "Order of convergence" } (fits(case)) }
        h3 { "What is measured" }
        (quantities(case))
        details open { summary { "All runs" } (runs(case)) }
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests::assert_well_formed;
    use super::*;
    use crate::study::case::{Claim, Factor, Gate, Level, Measure};
    use crate::study::front::{cheapest as cheapest_of, pareto};
    use crate::study::order;
    use crate::study::outcome::Class;
    use crate::study::result::{Cost, Group, Judged, Measured};

    fn row(window: f64, error: Option<f64>) -> Row {
        Row {
            settings: vec![("clock.window".into(), window.to_string())],
            axis: Some(window),
            outcome: Some(if error.is_some() { Class::Correct } else { Class::Refused }),
            why: error.is_none().then(|| "the window is <too long>".into()),
            error,
            errors: vec![error],
            error_coupling: error,
            error_solver: error.map(|_| 1e-4),
            cost: error.map(|_| Cost { wall_s: 0.01 / window, simulated_s: 1.0, runs: 3, ..Cost::default() }),
            ..Row::default()
        }
    }

    fn result(name: &str, passed: Option<bool>) -> CaseResult {
        let rows = vec![row(0.04, None), row(0.02, Some(0.04)), row(0.01, Some(0.01)), row(0.005, Some(0.0025))];
        let costs: Vec<_> = rows.iter().map(Row::work_and_error).collect();
        let fit = order::fit(&[(0.02, 0.04), (0.01, 0.01), (0.005, 0.0025)]);
        let gate = Gate {
            name: None,
            r#where: Vec::new(),
            quantity: Some("a.x".into()),
            claim: Claim::Order([1.9, 2.1]),
            reason: "theory <of> splitting".into(),
            explained: (name == "known").then(|| "the <scheme> is of first order".into()),
        };
        CaseResult {
            name: name.into(),
            title: "A <case>".into(),
            scene: "oscillator".into(),
            reference: "a & b".into(),
            quantities: vec![Measured { name: "a.x".into(), measure: Some(Measure::Max), reference: "t".into() }],
            vary: vec![Factor { key: "clock.window".into(), values: vec![Level::of("0.04")] }],
            groups: vec![Group { name: String::new(), rows: vec![0, 1, 2, 3], fit }],
            front: pareto(&costs),
            cheapest: cheapest_of(&costs),
            gates: vec![Judged { gate, passed, measured: "2.000".into() }],
            notes: vec!["a <note>".into()],
            rows,
        }
    }

    #[test]
    fn a_page_of_one_case_and_one_of_many_hold_what_was_found() {
        let command = ["cosplat".to_owned(), "study".to_owned(), "a b".to_owned()];
        let page = |cases: &[CaseResult]| {
            let catalogue =
                [Entry { id: "C<1>".into(), title: "t".into(), cases: vec!["one".into()], note: "n".into() }];
            let text =
                html(&Page { cases, catalogue: &catalogue, command: &command, version: "1.2.3", machine: "a machine" });
            assert_well_formed(&text);
            text
        };
        let one = page(&[result("one", Some(true))]);
        let held = [
            "A &lt;case&gt;",
            "a &lt;note&gt;",
            "the window is &lt;too long&gt;",
            "theory &lt;of&gt; splitting",
            "order between 1.9 and 2.1 (a.x)",
            "Error against run time",
            "Order of convergence",
            "Whose error it is",
            "2.000",
            "cosplat study 'a b'",
        ];
        for text in held {
            assert!(one.contains(text), "{text}");
        }
        assert!(!one.contains("<script") && !one.contains("href=\"http"));
        let many = page(&[result("one", Some(true)), result("two", Some(false)), result("three", None)]);
        assert!(many.contains("All gates of 2 of 3 cases hold.</p>") && many.contains("1 of 1 failed<"));
        let known = page(&[result("one", Some(true)), result("known", Some(false))]);
        for text in
            ["these say why not, below: known.", "1 of 1 failed, explained", "the &lt;scheme&gt; is of first order"]
        {
            assert!(known.contains(text), "{text}");
        }
        assert!(page(&[result("known", Some(true))]).contains("out of date"));
    }
}
