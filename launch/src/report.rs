//! The end of a run for people: verdicts, budgets, and where everything is.

use std::path::Path;

use crate::folder::ledger::number;
use crate::folder::summary::{Interface, LeftOut, Status, Summary};
use crate::progress::real_time;
use crate::render::{Paint, printable};
use crate::verdict::Verdict;

/// Things left out that are listed; the summary has them all.
const LISTED: usize = 8;

/// The summary in a dozen lines.
pub(crate) fn human(summary: &Summary, folder: &Path, paint: Paint) -> String {
    let mut lines = Lines { paint, lines: Vec::new() };
    let rate = summary.simulated_s / summary.wall_s;
    let rate = if rate.is_finite() && rate > 0.0 { format!(", {}", real_time(rate)) } else { String::new() };
    lines.add("run", &format!("{} s simulated in {:.3} s{rate}", summary.simulated_s, summary.wall_s));
    for process in &summary.processes {
        let cpu = process.cpu_s.map_or_else(String::new, |s| format!(", {s:.2} s of processor time"));
        let memory = process.peak_rss_mib.map_or_else(String::new, |m| format!(", {m:.0} MiB"));
        let text = format!(
            "{}: computed {:.3} s, waited {:.3} s, transferred {:.3} s{cpu}{memory}",
            process.name, process.compute_s, process.wait_s, process.transfer_s
        );
        lines.add("", &text);
    }
    if let Some(f) = &summary.frames {
        let text = format!(
            "{}: moved in {:.2} s, drawn in {:.2} s by {}, written in {:.2} s, recorded in {:.2} s",
            f.taken,
            f.skin_s,
            f.draw_s,
            printable(&f.drawn_by),
            f.write_s,
            f.record_s
        );
        lines.add("frames", &text);
    }
    verdicts(&mut lines, summary);
    energy(&mut lines, summary);
    for (process, counters) in &summary.counters {
        let counted: Vec<String> = counters.iter().map(|(name, n)| format!("{name} {n}")).collect();
        lines.add("count", &format!("{process}: {}", counted.join(", ")));
    }
    for high in summary.estimates.iter().filter(|e| e.is_high) {
        lines.add("error", &printable(&format!("{}: {}; {}", high.of, high.meaning, high.remedy)));
    }
    for (i, left_out) in summary.left_out.iter().take(LISTED).enumerate() {
        lines.add(if i == 0 { "without" } else { "" }, &left_out_line(left_out));
    }
    if summary.left_out.len() > LISTED {
        lines.add("", &format!("and {} more in summary.json", summary.left_out.len() - LISTED));
    }
    if let Some(hash) = &summary.state_hash {
        lines.add("hash", hash);
    }
    lines.add("folder", &paint.cyan(&folder.display().to_string()));
    let (word, text) = match summary.status {
        Status::Ok => (paint.good("ok"), "all windows are settled and all verdicts are good".to_owned()),
        Status::VerdictFailed => (paint.bad("verdict failed"), "the result is not to be trusted".to_owned()),
        Status::Failed => (paint.bad("failed"), format!("after {} windows", summary.windows)),
        Status::Interrupted => (paint.warn("interrupted"), format!("after {} windows", summary.windows)),
    };
    lines.add("result", &format!("{word}: {text}"));
    lines.lines.concat()
}

/// `process x: no body belongs to it (0 of 1); saves one process`.
pub(crate) fn left_out_line(left_out: &LeftOut) -> String {
    let numbers = match (left_out.indicator, left_out.limit) {
        (Some(indicator), Some(limit)) => format!(" ({} of {})", number(indicator), number(limit)),
        (Some(indicator), None) => format!(" ({})", number(indicator)),
        _ => String::new(),
    };
    let saved = match left_out.saved.as_str() {
        "" | "not measured" => String::new(),
        saved => format!("; saves {saved}"),
    };
    printable(&format!("{}: {}{numbers}{saved}", left_out.what, left_out.why))
}

struct Lines {
    paint: Paint,
    lines: Vec<String>,
}

impl Lines {
    fn add(&mut self, label: &str, text: &str) {
        self.lines.push(format!("{} {text}\n", self.paint.bold(&format!("{label:>7}"))));
    }
}

fn verdicts(lines: &mut Lines, summary: &Summary) {
    let crossing: Vec<&Interface> = summary.interfaces.iter().filter(|i| i.resolver.is_some()).collect();
    if !crossing.is_empty() {
        let defect = worst(summary, "transfer-defect");
        let gross: f64 = crossing.iter().map(|i| i.gross_impulse).sum();
        if let Some(v) = defect {
            let text = format!("transfer defect {} N s of {} N s that crossed", short(v.value), short(gross));
            lines.add("check", &format!("{text} {}", mark(lines.paint, v)));
        }
    }
    for (name, words) in [("closure-window", "a window"), ("closure-run", "the run")] {
        if let Some(v) = worst(summary, name) {
            let text = format!("closure {} of {} in {words} ({})", short(v.value), short(v.limit), v.of);
            lines.add("check", &format!("{text} {}", mark(lines.paint, v)));
        }
    }
    for i in summary.interfaces.iter().filter(|i| i.resolver.is_none()) {
        let (defect, gross) = (short(i.transfer_defect), short(i.gross_impulse));
        let text = format!(
            "link {}~{}: both sides differ by {defect} N s of {gross} N s, work {} J",
            i.a,
            i.b,
            short(i.work_defect)
        );
        lines.add("", &text);
    }
}

/// The verdict of that name that is furthest beyond its limit, or nearest to it.
fn worst<'a>(summary: &'a Summary, name: &str) -> Option<&'a Verdict> {
    let of_name = summary.verdicts.iter().filter(|v| v.name == name);
    of_name.max_by(|a, b| {
        let excess =
            |v: &Verdict| if v.value.is_nan() { f64::INFINITY } else { v.value / v.limit.max(f64::MIN_POSITIVE) };
        excess(a).total_cmp(&excess(b))
    })
}

fn mark(paint: Paint, verdict: &Verdict) -> String {
    if verdict.passed { paint.good("ok") } else { paint.bad("failed") }
}

/// Losses below this share of the energy that moved are not told.
const NEWS: f64 = 1e-3;

fn energy(lines: &mut Lines, summary: &Summary) {
    let Some(total) = summary.energy.last().filter(|_| summary.windows > 0) else { return };
    let initial = total.initial_j.map_or_else(String::new, |e| format!("{} J at the start, ", short(e)));
    let supplied = match total.supplied_j {
        0.0 => String::new(),
        some => format!(", {} J supplied from outside", short(some)),
    };
    // Roundings are no news.
    let lost = summary.lost_j().filter(|j| j.abs() > NEWS * (total.max_j - total.min_j));
    let lost =
        lost.map_or_else(String::new, |j| format!(", {} J in no book (impact, damping of the methods)", short(j)));
    let text = format!(
        "{initial}{} J at the end, between {} and {} J, {} J dissipated{lost}{supplied}",
        short(total.final_j),
        short(total.min_j),
        short(total.max_j),
        short(total.dissipated_j)
    );
    lines.add("energy", &text);
    if let Some(budget) = &summary.energy_budget {
        let (words, paint) = (budget.words(), lines.paint);
        lines.add("budget", &if budget.is_kept { words } else { paint.warn(&words) });
    }
}

/// A number in at most four digits and an exponent.
pub(crate) fn short(value: f64) -> String {
    let size = value.abs();
    if size == 0.0 {
        "0".into()
    } else if (0.01..100_000.0).contains(&size) {
        let text = format!("{value:.4}");
        text.trim_end_matches('0').trim_end_matches('.').to_owned()
    } else {
        format!("{value:.2e}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::folder::summary::Energy;
    use std::collections::BTreeMap;

    fn summary() -> Summary {
        let verdict = |name: &str, of: &str, value, limit| Verdict::new(name, of, value, limit);
        Summary {
            status: Status::VerdictFailed,
            exit_code: 7,
            failure: None,
            scene: "x".into(),
            windows: 3,
            window_s: 0.01,
            window_bound_by: "x".into(),
            simulated_s: 0.03,
            wall_s: 0.01,
            state_hash: Some("ab".into()),
            verdicts: vec![
                verdict("transfer-defect", "a~b", 0.0, 0.0),
                verdict("closure-window", "left", 1e-16, 1e-12),
                verdict("closure-window", "right", 0.5, 1e-12),
            ],
            frames: None,
            processes: Vec::new(),
            bodies: Vec::new(),
            interfaces: vec![Interface { resolver: Some("left".into()), gross_impulse: 2.0, ..Interface::default() }],
            energy: vec![Energy { name: "total".into(), initial_j: Some(1.0), ..Energy::default() }],
            counters: BTreeMap::new(),
            estimates: Vec::new(),
            energy_budget: None,
            presets: Vec::new(),
            left_out: vec![LeftOut { what: "viewer".into(), why: "not asked for".into(), ..LeftOut::default() }; 10],
            files: BTreeMap::new(),
        }
    }

    #[test]
    fn the_worst_verdict_of_a_kind_is_shown() {
        let text = human(&summary(), Path::new("out/x"), Paint::off());
        assert!(text.contains("closure 0.5 of 1.00e-12 in a window (right) failed"), "{text}");
        assert!(text.contains("transfer defect 0 N s of 2 N s that crossed ok"), "{text}");
        assert!(text.contains("and 2 more in summary.json"), "{text}");
        assert!(text.ends_with("result verdict failed: the result is not to be trusted\n"), "{text}");
    }

    #[test]
    fn what_no_book_explains_is_told() {
        let mut summary = summary();
        summary.energy[0] =
            Energy { initial_j: Some(8.0), final_j: 2.0, max_j: 8.0, dissipated_j: 1.5, ..Energy::default() };
        let told = |summary: &Summary| human(summary, Path::new("out/x"), Paint::off());
        let all = "1.5 J dissipated, 4.5 J in no book (impact, damping of the methods)\n";
        assert!(told(&summary).contains(all), "{}", told(&summary));
        summary.energy[0].dissipated_j = 6.001;
        assert!(told(&summary).contains("6.001 J dissipated\n"), "{}", told(&summary));
    }

    #[test]
    fn numbers_are_short() {
        assert_eq!([0.0, 0.25, 1234.5, 1e-9, 39.478_417_604].map(short), ["0", "0.25", "1234.5", "1.00e-9", "39.4784"]);
    }
}
