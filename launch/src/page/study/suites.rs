//! Pages of the suites: the map of extreme settings, and the negative controls.

use maud::{Markup, html};

use super::super::document;
use super::super::number::{maybe, quantity};
use super::super::parts::command;
use super::super::tables::table;
use super::Page;
use crate::study::ablation::{Kept, Worth};
use crate::study::control::Noticed;
use crate::study::result::CaseResult;
use crate::study::stability::{Behaviour, Field};

/// The map of extreme settings.
pub(crate) fn stability(page: &Page<'_>, fields: &[Field]) -> String {
    let bad = fields.iter().filter(|f| !f.behaviour.is_tolerable()).count();
    let lead = match bad {
        0 => format!("None of {} runs fails in silence.", fields.len()),
        n => format!("{n} of {} runs fail in silence or crash.", fields.len()),
    };
    let body = html! {
        (overview(page.cases, fields))
        p {
            "One sign a run: " @for (i, how) in Behaviour::ALL.into_iter().enumerate() { @if i > 0 { ", " } (sign(how)) " " (how.word()) }
            ". What each run is judged by stands in its case, with the reason."
        }
        @for case in page.cases {
            section id=(case.name) {
                h2 { (case.title) }
                p { "Scene " code { (case.scene) } ". " (case.reference) }
                (runs(fields.iter().filter(|f| f.case == case.name)))
                (criteria(case))
            }
        }
    };
    whole(page, "What extreme settings do", &lead, &body)
}

/// The negative controls.
pub(crate) fn controls(page: &Page<'_>, noticed: &[Noticed]) -> String {
    let good = noticed.iter().filter(|n| n.passed).count();
    let lead = format!("{good} of {} faults are noticed by the gate that is there for them.", noticed.len());
    let head = [("Noticed", ""), ("What was broken", ""), ("Case", ""), ("Without", "n"), ("With", "n"), ("Gate", "")];
    let row = |n: &Noticed| {
        let (class, word) = if n.passed { ("good", "yes") } else { ("bad", "no") };
        vec![
            html! { strong class=(class) { (word) } },
            html! { (n.fault) " " code { (n.name) } },
            html! { code { (n.case) } },
            html! { (n.sound.measured) },
            html! { (n.broken.measured) },
            html! { (n.sound.gate.reason) },
        ]
    };
    whole(page, "Negative controls", &lead, &table(&head, noticed.iter().map(row).collect()))
}

/// What decisions to leave something out are worth.
pub(crate) fn ablation(page: &Page<'_>, scene: &str, found: &[Worth], kept: &[Kept]) -> String {
    let head = [
        ("The other way round", ""),
        ("Decided by", ""),
        ("State", ""),
        ("Probes differ by", "n"),
        ("Pictures differ by", "n"),
        ("Saves time [s]", "n"),
        ("of cores [s]", "n"),
        ("of frames [s]", "n"),
        ("memory [MiB]", "n"),
        ("messages", "n"),
    ];
    let row = |worth: &Worth| {
        let (class, state) = match (&worth.why_not, worth.same_bytes) {
            (Some(why), _) => ("warn", why.as_str()),
            (None, true) => ("good", "the same bytes"),
            (None, false) if worth.passed => ("", "another"),
            (None, false) => ("bad", "another, although it must not matter"),
        };
        vec![
            html! { (worth.instead.replace('`', "")) div { code { (worth.name) } } },
            html! {
                @if worth.indicator.is_empty() { "what the scene asks for" } @else { (worth.indicator.replace('`', "")) }
            },
            html! { span class=(class) { (state) } },
            html! { (maybe(worth.difference)) },
            html! { (maybe(worth.pictures_difference)) },
            html! { (maybe(worth.saved_s)) },
            html! { (maybe(worth.saved_core_s)) },
            html! { (maybe(worth.saved_frames_s)) },
            html! { (maybe(worth.saved_mib)) },
            html! { (quantity(worth.saved_messages as f64)) },
        ]
    };
    let lead = "Each decision the other way round: what it changes, and what the decision saves.";
    let body = html! {
        (table(&head, found.iter().map(row).collect()))
        p { "Times are those inside the windows, of single runs unless more were asked for; core times are those of all solvers, with their set-up, which other programs disturb less. Negative numbers are costs, or noise: with more runs of each (--runs) the median counts. A state is another one as well where a solver only remembers more. Probes differ relative to how far they move, pictures by the root mean square of colours from 0 to 1." }
        h2 { "What no scene leaves out" }
        (table(&[("What", ""), ("Usually decided by", ""), ("Why it stays", "")], kept.iter().map(|k| vec![
            html! { (k.what.replace('`', "")) }, html! { (k.indicator) }, html! { (k.why.replace('`', "")) },
        ]).collect()))
    };
    whole(page, &format!("What {scene} does without"), lead, &body)
}

/// A page with a title, one sentence about all of it, and how it was made.
pub(super) fn whole(page: &Page<'_>, title: &str, lead: &str, body: &Markup) -> String {
    let body = html! {
        header { h1 { (title) } p.lead { (lead) } p { (page.machine) ", cosplat " (page.version) } }
        main {
            (body)
            section id="again" { h2 { "How to do it again" } pre { code { (command(page.command)) } } }
        }
    };
    document(title, &body)
}

fn class(how: Behaviour) -> &'static str {
    match how {
        Behaviour::Correct => "good",
        Behaviour::Degraded | Behaviour::Refused => "warn",
        Behaviour::Silent | Behaviour::Crashed => "bad",
    }
}

/// A sign that is known by its shape as well as by its colour.
fn sign(how: Behaviour) -> Markup {
    let shape = match how {
        Behaviour::Correct => "●",
        Behaviour::Degraded => "◐",
        Behaviour::Refused => "○",
        Behaviour::Silent => "✖",
        Behaviour::Crashed => "▲",
    };
    html! { span class=(class(how)) { (shape) } }
}

/// One line a case, one sign a run.
fn overview(cases: &[CaseResult], fields: &[Field]) -> Markup {
    let row = |case: &CaseResult| {
        let own: Vec<&Field> = fields.iter().filter(|f| f.case == case.name).collect();
        let count = |how: Behaviour| own.iter().filter(|f| f.behaviour == how).count();
        let signs = html! { @for f in &own { span title=(f.settings) { (sign(f.behaviour)) } " " } };
        let mut cells = vec![html! { a href={ "#" (case.name) } { (case.title) } }, signs];
        cells.extend(Behaviour::ALL.map(|how| html! { (count(how)) }));
        cells
    };
    let mut head = vec![("Case", ""), ("Runs", "")];
    head.extend([("Correct", "n"), ("Degraded", "n"), ("Refused", "n"), ("Silent", "n"), ("Crashed", "n")]);
    table(&head, cases.iter().map(row).collect())
}

fn runs<'a>(fields: impl Iterator<Item = &'a Field>) -> Markup {
    let head = [("Run", ""), ("Behaviour", ""), ("What the run says", ""), ("Criteria that are broken", "")];
    let row = |f: &Field| {
        vec![
            html! { code { (f.settings) } },
            html! { (sign(f.behaviour)) " " span class=(class(f.behaviour)) { (f.behaviour.word()) } },
            html! { @for one in &f.says { div { (one) } } },
            html! { @for one in &f.broken { div { (one) } } },
        ]
    };
    table(&head, fields.map(row).collect())
}

fn criteria(case: &CaseResult) -> Markup {
    html! {
        h3 { "Criteria" }
        (super::tables::gates(case))
    }
}

#[cfg(test)]
mod tests {
    use super::super::super::tests::assert_well_formed;
    use super::*;

    #[test]
    fn the_map_shows_every_run() {
        let field = |behaviour, says: &str| Field {
            case: "x".into(),
            settings: "clock.window=0.1".into(),
            behaviour,
            broken: vec!["too <far>".into()],
            says: vec![says.into()],
            exit_code: 0,
            folder: String::new(),
        };
        let fields = [field(Behaviour::Refused, "no <plugin>"), field(Behaviour::Silent, "")];
        let command = ["cosplat".to_owned()];
        let page = Page { cases: &[], catalogue: &[], command: &command, version: "1.2.3", machine: "a machine" };
        let text = stability(&page, &fields);
        assert_well_formed(&text);
        assert!(text.contains("1 of 2 runs fail in silence or crash."), "{text}");
        let text = controls(&page, &[]);
        assert_well_formed(&text);
    }
}
