//! `gallery.html`: many runs on one page, and how the runs of one scene differ.
//!
//! Pictures are in it; the reports of the runs are linked, relative to the page.

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use maud::{Markup, html};

use super::number::{count, maybe, quantity};
use super::tables::table;
use super::{Chart, Line, chart, document, parts, word};
use crate::folder::curves::Table;
use crate::folder::summary::Status;
use crate::gallery::Gallery;
use crate::gallery::compare::{Apart, Comparison, Difference, Quantity};
use crate::gallery::read::ArchivedRun;

/// The gallery as a page; `link` gives the address of the report of a run, where it has one.
pub(crate) fn html(gallery: &Gallery, link: impl Fn(&ArchivedRun) -> Option<String>) -> String {
    let good = gallery.runs.iter().filter(|run| run.summary.status == Status::Ok).count();
    let body = html! {
        header {
            h1 { "Runs" }
            p.lead { (good) " of " (gallery.runs.len()) " runs ended with all verdicts good." }
            @for (folder, why) in &gallery.unreadable { p.failure { code { (folder) } " is not shown: " (why) } }
        }
        nav {
            @for (i, run) in gallery.runs.iter().enumerate() { a href={ "#run-" (i) } { (label(gallery, i)) " (" (run.summary.scene) ")" } }
            @for compared in &gallery.comparisons { a href={ "#compare-" (compared.scene) } { "Compare " (compared.scene) } }
        }
        main {
            section.cards { @for (i, run) in gallery.runs.iter().enumerate() { (card(gallery, i, run, link(run).as_deref())) } }
            @for compared in &gallery.comparisons {
                section id={ "compare-" (compared.scene) } {
                    h2 { "Runs of " (compared.scene) }
                    (comparison(gallery, compared))
                }
            }
        }
        footer { "Every number on this page was measured in the run that it describes. SI units." }
    };
    document("Runs", &body)
}

/// A run by its folder's own name, or by the whole path where two have the same.
fn label(gallery: &Gallery, at: usize) -> String {
    let run = &gallery.runs[at];
    let name = run.name();
    let is_alone = gallery.runs.iter().filter(|other| other.name() == name).count() == 1;
    if is_alone { name } else { run.folder.display().to_string() }
}

fn card(gallery: &Gallery, at: usize, run: &ArchivedRun, report: Option<&str>) -> Markup {
    let summary = &run.summary;
    let failed = summary.verdicts.iter().filter(|v| !v.passed).count();
    html! {
        article.card id={ "run-" (at) } {
            h2 { @if let Some(report) = report { a href=(report) { (label(gallery, at)) } } @else { (label(gallery, at)) } }
            @if let Some(png) = &run.picture {
                img src={ "data:image/png;base64," (STANDARD.encode(png)) } alt={ "A picture from the middle of " (summary.scene) };
            }
            @if !run.title.is_empty() { p { (run.title) } }
            p {
                strong class=(class(summary.status)) { (word(summary.status)) }
                @if failed > 0 { ", " (failed) " of " (summary.verdicts.len()) " gates failed" }
                ": " (quantity(summary.simulated_s)) " s simulated in " (quantity(summary.wall_s)) " s"
            }
            @if let Some(failure) = &summary.failure { p.failure { (failure) } }
            details {
                summary { "How it was started" }
                p { (run.start.moment) }
                @if !run.start.command.is_empty() { pre { code { (parts::command(&run.start.command)) } } }
                @if let Some(hash) = &summary.state_hash { p { "State hash " code.hash { (hash) } } }
            }
        }
    }
}

fn class(status: Status) -> &'static str {
    match status {
        Status::Ok => "good",
        Status::VerdictFailed | Status::Failed => "bad",
        Status::Interrupted => "warn",
    }
}

fn comparison(gallery: &Gallery, compared: &Comparison) -> Markup {
    let names: Vec<String> = compared.places.iter().map(|&at| label(gallery, at)).collect();
    let runs: Vec<&ArchivedRun> = compared.places.iter().map(|&at| &gallery.runs[at]).collect();
    let mut head = vec![("", "")];
    head.extend(names.iter().map(|name| (name.as_str(), "n")));
    let mut rows = vec![
        row("Plugins", runs.iter().map(|run| plugins(run))),
        row("Changed", runs.iter().map(|run| run.start.changes.join(", "))),
        row("Ended", runs.iter().map(|run| word(run.summary.status).to_owned())),
        row("State", (0..runs.len()).map(|i| state(i, compared.same_state[i]).to_owned())),
    ];
    rows.extend(compared.quantities.iter().map(|q| row(&name(q), q.values.iter().map(|v| shown(q, *v)))));
    html! {
        p {
            "The first run, " code { (names[0]) }
            ", is what the others are compared with: a difference of a probe is taken at its times, over the time that both runs cover."
        }
        (table(&head, rows))
        @if !compared.probes.is_empty() {
            h3 { "Probes: difference from the reference" }
            (table(&probe_head(&names), probe_rows(compared)))
        }
        div.charts { @for drawn in charts(compared, &names, &runs) { (drawn) } }
    }
}

fn row(name: &str, cells: impl Iterator<Item = String>) -> Vec<Markup> {
    [name.to_owned()].into_iter().chain(cells).map(|cell| html! { (cell) }).collect()
}

fn name(quantity: &Quantity) -> String {
    format!("{} [{}]", quantity.name, quantity.unit)
}

/// Whole numbers without decimals.
fn shown(quantity: &Quantity, value: Option<f64>) -> String {
    match value {
        Some(whole) if quantity.unit == "1" && whole >= 1.0 && whole.fract() == 0.0 => count(whole as u64),
        other => maybe(other),
    }
}

fn plugins(run: &ArchivedRun) -> String {
    let each = |(process, plugin): &(String, String)| {
        if process == plugin { plugin.clone() } else { format!("{plugin} in {process}") }
    };
    run.start.plugins.iter().map(each).collect::<Vec<_>>().join(", ")
}

fn state(place: usize, same: bool) -> &'static str {
    match (place, same) {
        (0, _) => "reference",
        (_, true) => "same to the last bit",
        (_, false) => "another",
    }
}

fn probe_head(names: &[String]) -> Vec<(&str, &str)> {
    let mut head = vec![("Probe", ""), ("Range of the reference", "n")];
    head.extend(names.iter().skip(1).map(|name| (name.as_str(), "n")));
    head
}

fn probe_rows(compared: &Comparison) -> Vec<Vec<Markup>> {
    let cell = |apart: Option<Difference>| {
        html! { @if let Some(d) = apart { (quantity(d.rms)) " rms, " (quantity(d.max)) " at most" } @else { "–" } }
    };
    let row = |apart: &Apart| {
        let first = [html! { code { (apart.column) } }, html! { (quantity(apart.range)) }];
        first.into_iter().chain(apart.differences.iter().skip(1).copied().map(cell)).collect()
    };
    compared.probes.iter().map(row).collect()
}

/// Curves of all runs over each other: the energy, and each column of the probes.
fn charts(compared: &Comparison, names: &[String], runs: &[&ArchivedRun]) -> Vec<Markup> {
    let overlay = |title: &str, unit: &str, column: &str, table: fn(&ArchivedRun) -> &Table| {
        let lines: Vec<Line<'_>> = names
            .iter()
            .zip(runs)
            .filter_map(|(name, run)| Some(Line { name, gate: None, points: table(run).curve(column)? }))
            .collect();
        (lines.len() > 1).then(|| chart::figure(&Chart { title, unit, logarithmic: false, note: "", lines }))
    };
    let energy = overlay("Total energy", "J", "total_energy_j", |run| &run.ledger);
    let probes = compared.probes.iter().filter_map(|p| overlay(&p.column, "SI", &p.column, |run| &run.probes));
    energy.into_iter().chain(probes).collect()
}

#[cfg(test)]
mod tests {
    use super::super::tests::{assert_well_formed, summary};
    use super::*;
    use crate::gallery::read::Start;

    fn run(folder: &str, hash: &str, probe: f64) -> ArchivedRun {
        let place = tempfile::tempdir().unwrap();
        let path = place.path().join("t.csv");
        std::fs::write(&path, format!("time_s,tip.x\n0.5,{probe}\n1,{}\n", 2.0 * probe)).unwrap();
        let mut summary = summary();
        summary.state_hash = Some(hash.into());
        ArchivedRun {
            folder: folder.into(),
            summary,
            start: Start { changes: vec!["--solver ball=<b>".into()], ..Start::default() },
            title: "A <ball> & a plant".into(),
            picture: Some(b"\x89PNG".to_vec()),
            has_report: true,
            probes: Table::read(&path, 0).unwrap(),
            ledger: Table::default(),
        }
    }

    #[test]
    fn two_runs_of_a_scene_are_compared() {
        let gallery =
            Gallery::of(vec![run("a", "00", 1.0), run("b", "11", 1.5)], vec![("c".into(), "it was <killed>".into())]);
        let page = html(&gallery, |run| Some(format!("{}/report.html", run.name())));
        assert_well_formed(&page);
        let held = [
            "href=\"a/report.html\"",
            "another",
            "0.7906 rms, 1.000 at most",
            "--solver ball=&lt;b&gt;",
            "A &lt;ball&gt; &amp; a plant",
            "it was &lt;killed&gt;",
            "Largest displacement of plant [m]",
            "tip.x [SI]",
        ];
        for text in held {
            assert!(page.contains(text), "{text}\n{page}");
        }
        assert!(!page.contains("http://") || page.replace("http://www.w3.org/2000/svg", "").find("http").is_none());
    }

    #[test]
    fn one_run_is_compared_with_nothing() {
        let gallery = Gallery::of(vec![run("a", "00", 1.0)], Vec::new());
        let page = html(&gallery, |_| None);
        assert_well_formed(&page);
        assert!(gallery.comparisons.is_empty() && !page.contains("reference"));
    }
}
