//! `report.html`: a run to be read in a browser, by somebody who was not there.
//!
//! One file that needs nothing else: pictures are in it, curves are SVG, and there is no script. The same report gives
//! the same bytes. Every text that comes from a scene or a plugin is escaped.

mod axis;
mod chart;
pub(crate) mod drop;
pub(crate) mod gallery;
mod number;
mod parts;
mod pictures;
pub(crate) mod scatter;
pub(crate) mod study;
mod tables;
#[cfg(test)]
mod tests;

use maud::{DOCTYPE, Markup, PreEscaped, html};

use crate::folder::summary::{Status, Summary};

/// A whole page that needs no other file.
fn document(title: &str, body: &Markup) -> String {
    let page = html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta name="viewport" content="width=device-width, initial-scale=1";
                title { (title) }
                style { (PreEscaped(include_str!("style.css"))) }
            }
            body { (body) }
        }
    };
    page.into_string()
}

/// Everything that a report tells.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Report<'a> {
    /// Outcome and budgets.
    pub(crate) summary: &'a Summary,
    /// What the scene says about itself; may be empty.
    pub(crate) description: &'a str,
    /// Pictures in the order of time.
    pub(crate) pictures: &'a [Picture<'a>],
    /// The animation of the pictures, an animated PNG.
    pub(crate) preview: Option<Picture<'a>>,
    /// Curves of the ledger.
    pub(crate) ledger: &'a [Chart<'a>],
    /// Curves of the probes.
    pub(crate) probes: &'a [Chart<'a>],
    /// How the run was started, program first.
    pub(crate) command: &'a [String],
    /// Versions of programs and plugins, and on what they ran: name and version.
    pub(crate) versions: &'a [(String, String)],
}

/// A picture of the scene.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Picture<'a> {
    /// What it shows, with its moment \[s\].
    pub(crate) caption: &'a str,
    /// A PNG file.
    pub(crate) png: &'a [u8],
}

/// Curves with one unit.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Chart<'a> {
    /// What is shown.
    pub(crate) title: &'a str,
    /// Unit of the values, `1` for those without.
    pub(crate) unit: &'a str,
    /// Whether equal steps are factors of ten. Values that are exactly 0 are then drawn at the lower edge.
    pub(crate) logarithmic: bool,
    /// What a reader must know to judge it; may be empty.
    pub(crate) note: &'a str,
    /// The curves.
    pub(crate) lines: Vec<Line<'a>>,
}

/// A curve.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Line<'a> {
    /// Its name in the legend.
    pub(crate) name: &'a str,
    /// Largest value that passes, drawn dashed.
    pub(crate) gate: Option<f64>,
    /// Simulated time \[s\], ascending, and value. Any number of points: they are drawn as what a pixel can show.
    pub(crate) points: Vec<(f64, f64)>,
}

/// The report as a page.
pub(crate) fn html(report: &Report<'_>) -> String {
    let summary = report.summary;
    let sections = [
        ("verdicts", "Verdicts", Some(parts::verdicts(summary))),
        ("estimates", "How large the errors are", tables::estimates(summary)),
        ("pictures", "Pictures", pictures::section(report)),
        ("ledger", "Ledger", chart::section(report.ledger)),
        ("probes", "Probes", chart::section(report.probes)),
        ("time", "Time and memory", parts::times(summary)),
        ("energy", "Energy", tables::energy(summary)),
        ("bodies", "Bodies", tables::bodies(summary)),
        ("interfaces", "Interfaces", tables::interfaces(summary)),
        ("presets", "Published materials, and how they are read", tables::presets(summary)),
        ("left-out", "What was left out, and why", tables::left_out(summary)),
        ("counters", "Counters", Some(tables::counters(summary))),
        ("again", "How to do it again", Some(parts::again(report))),
    ];
    let sections: Vec<_> = sections.into_iter().filter_map(|(id, title, body)| Some((id, title, body?))).collect();
    let body = html! {
        (headline(report))
        nav { @for (id, title, _) in &sections { a href={ "#" (id) } { (title) } } }
        main {
            @for (id, title, body) in &sections { section id=(id) { h2 { (title) } (body) } }
        }
        footer { "Every number on this page was measured in the run that it describes. SI units." }
    };
    document(&format!("{}: {}", summary.scene, word(summary.status)), &body)
}

/// A status as people say it.
fn word(status: Status) -> &'static str {
    match status {
        Status::Ok => "ok",
        Status::VerdictFailed => "verdict failed",
        Status::Failed => "failed",
        Status::Interrupted => "interrupted",
    }
}

fn headline(report: &Report<'_>) -> Markup {
    let summary = report.summary;
    let (class, sentence) = match summary.status {
        Status::Ok => ("good", "All windows are settled and all verdicts are good."),
        Status::VerdictFailed => ("bad", "All windows are settled, but the result is not to be trusted."),
        Status::Failed => ("bad", "The run ended early."),
        Status::Interrupted => ("warn", "The run was stopped at the edge of a window."),
    };
    html! {
        header {
            h1 { (summary.scene) }
            @if !report.description.is_empty() { p.lead { (report.description) } }
            p.status { strong class=(class) { (word(summary.status)) } " " (sentence) }
            @if let Some(failure) = &summary.failure { p.failure { (failure) } }
            (parts::facts(summary))
        }
    }
}
