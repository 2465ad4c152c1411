//! Sections that are more than a table: verdicts, facts, the split of the time, how to repeat the run.

use maud::{Markup, html};

use super::Report;
use super::number::{count, limit, maybe, quantity};
use super::tables::table;
use crate::folder::summary::{Frames, Process, Summary};
use crate::verdict::Verdict;

/// The run in a few numbers.
pub(super) fn facts(summary: &Summary) -> Markup {
    let rate = summary.simulated_s / summary.wall_s;
    html! {
        dl.facts {
            (fact("Simulated", &format!("{} s", quantity(summary.simulated_s))))
            (fact("Wall time", &format!("{} s", quantity(summary.wall_s))))
            @if rate.is_finite() { (fact("Speed", &format!("{} × real time", quantity(rate)))) }
            (fact("Windows", &count(summary.windows)))
            (fact("Window", &format!("{} s, bound by {}", quantity(summary.window_s), summary.window_bound_by)))
        }
    }
}

fn fact(name: &str, value: &str) -> Markup {
    html! { div { dt { (name) } dd { (value) } } }
}

/// What decides whether the result is to be trusted.
pub(super) fn verdicts(summary: &Summary) -> Markup {
    if summary.verdicts.is_empty() {
        return html! { p { "No window was settled, so nothing could be judged." } };
    }
    let failed = summary.verdicts.iter().filter(|v| !v.passed).count();
    let rows = summary.verdicts.iter().map(verdict).collect();
    html! {
        p {
            @if failed == 0 { "All " (summary.verdicts.len()) " gates are passed." }
            @else { (failed) " of " (summary.verdicts.len()) " gates failed." }
            " What arrives over an interface must be what was sent, to the last bit. The momentum of each solver, \
             summed over its own state, must be explained by the impulses that act on it, relative to the largest \
             gross momentum of the run."
        }
        (table(&[("Verdict", ""), ("Gate", ""), ("Of", ""), ("Measured", "n"), ("Limit", "n"), ("Of the limit", "n")], rows))
    }
}

fn verdict(verdict: &Verdict) -> Vec<Markup> {
    let (class, word) = if verdict.passed { ("good", "passed") } else { ("bad", "failed") };
    let share = 100.0 * verdict.value / verdict.limit;
    let share = if share.is_nan() { "–".into() } else { format!("{} %", quantity(share)) };
    vec![
        html! { strong class=(class) { (word) } },
        html! { (gate(&verdict.name)) },
        html! { code { (verdict.of) } },
        html! { (quantity(verdict.value)) },
        html! { @if verdict.limit == 0.0 { "exactly 0" } @else { (limit(verdict.limit)) } },
        html! { (share) },
    ]
}

/// A gate in words.
fn gate(name: &str) -> &str {
    match name {
        "transfer-defect" => "Impulses given minus received [N s]",
        "closure-window" => "Closure of the worst window [1]",
        "closure-run" => "Closure summed over the run [1]",
        other => other,
    }
}

/// Where the time of each process went.
pub(super) fn times(summary: &Summary) -> Option<Markup> {
    let longest = summary.processes.iter().map(total).fold(0.0, f64::max);
    if longest <= 0.0 {
        return None;
    }
    let head = [
        ("Process", ""),
        ("Compute [s]", "n"),
        ("Wait [s]", "n"),
        ("Transfer [s]", "n"),
        ("CPU [s]", "n"),
        ("Peak memory [MiB]", "n"),
        ("Threads", "n"),
        ("Substeps", "n"),
        ("Substep bound by", ""),
    ];
    let rows = summary.processes.iter().map(|p| {
        vec![
            html! { code { (p.name) } @if p.solver != p.name { " (" (p.solver) ")" } },
            html! { (quantity(p.compute_s)) },
            html! { (quantity(p.wait_s)) },
            html! { (quantity(p.transfer_s)) },
            html! { (maybe(p.cpu_s)) },
            html! { (maybe(p.peak_rss_mib)) },
            html! { (p.threads) },
            html! { (count(p.substeps)) },
            html! { (p.substep_bound_by) },
        ]
    });
    Some(html! {
        p.legend {
            @for (class, name) in PARTS { span { i.swatch.(class) {} (name) } }
        }
        div.bars { @for process in &summary.processes { (bar(process, longest)) } }
        (table(&head, rows.collect()))
        @if let Some(frames) = &summary.frames { (frame_times(frames)) }
    })
}

/// What pictures, files and recordings of the scene cost beside the solvers.
fn frame_times(frames: &Frames) -> Markup {
    let parts = [
        ("moving Gaussians", frames.skin_s),
        ("drawing", frames.draw_s),
        ("writing splat files", frames.write_s),
        ("recording", frames.record_s),
    ];
    let spent: Vec<String> =
        parts.iter().filter(|(_, s)| *s > 0.0).map(|(name, s)| format!("{name} {} s", quantity(*s))).collect();
    html! {
        p {
            (count(frames.taken)) " frames were taken beside the solvers"
            @if !spent.is_empty() { ": " (spent.join(", ")) }
            "."
        }
    }
}

/// What a process does with its time, and the class that colours it.
const PARTS: [(&str, &str); 3] = [
    ("compute", "computing"),
    ("wait", "waiting for partners or the clock"),
    ("transfer", "encoding, sending, decoding"),
];

fn total(process: &Process) -> f64 {
    process.compute_s + process.wait_s + process.transfer_s
}

fn bar(process: &Process, longest: f64) -> Markup {
    let parts = [process.compute_s, process.wait_s, process.transfer_s];
    let width = |seconds: f64| format!("width:{:.2}%", 100.0 * seconds / longest);
    html! {
        div.row {
            code { (process.name) }
            div.bar {
                @for (seconds, (class, name)) in parts.into_iter().zip(PARTS) {
                    div class=(class) style=(width(seconds)) title={ (name) ": " (quantity(seconds)) " s" } {}
                }
            }
        }
    }
}

/// What is needed to do the run again and to see that it is the same.
pub(super) fn again(report: &Report<'_>) -> Markup {
    let versions = report.versions.iter().map(|(name, version)| vec![html! { (name) }, html! { code { (version) } }]);
    let files = report.summary.files.iter().map(|(part, file)| vec![html! { (part) }, html! { code { (file) } }]);
    html! {
        @if !report.command.is_empty() { pre { code { (command(report.command)) } } }
        @if let Some(hash) = &report.summary.state_hash {
            p {
                "The same scene with the same versions must end with this hash of all states, whatever the number of \
                 threads: " code.hash { (hash) }
            }
        }
        @if !report.versions.is_empty() { (table(&[("Part", ""), ("Version", "")], versions.collect())) }
        @if !report.summary.files.is_empty() {
            details {
                summary { "Files of the run" }
                (table(&[("Part", ""), ("File", "")], files.collect()))
            }
        }
    }
}

/// A command line that a shell reads back as the same arguments.
pub(super) fn command(arguments: &[String]) -> String {
    let plain = |c: char| c.is_ascii_alphanumeric() || "-_./=:,+@%".contains(c);
    let quoted = |argument: &String| {
        if !argument.is_empty() && argument.chars().all(plain) {
            argument.clone()
        } else {
            format!("'{}'", argument.replace('\'', r"'\''"))
        }
    };
    arguments.iter().map(quoted).collect::<Vec<_>>().join(" ")
}
