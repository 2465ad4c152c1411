//! What a study says on a terminal.

use std::fmt::Write as _;
use std::path::Path;

use super::case::Claim;
use super::outcome::Class;
use super::result::{CaseResult, Group, Row};
use crate::render::{Paint, printable, table};

/// What a study has found out, for a terminal.
pub(crate) fn human(results: &[CaseResult], page: &Path, paint: Paint) -> String {
    let mut text = String::new();
    for case in results {
        if results.len() == 1 {
            text.push_str(&runs(case, paint));
        }
        text.push_str(&failed_gates(case, results.len() > 1, paint));
    }
    if results.len() > 1 {
        text.push_str(&matrix(results, paint));
    }
    text + &format!("\nwritten to {}\n", paint.cyan(&page.display().to_string()))
}

fn number(value: Option<f64>) -> String {
    value.map_or_else(|| "–".into(), |v| format!("{v:.3e}"))
}

/// All runs of a case, its orders, and the cheapest runs. Writing to a string cannot fail.
fn runs(case: &CaseResult, paint: Paint) -> String {
    let head = ["error", "coupling", "rest", "wall time [s]", "outcome"].map(str::to_owned);
    let mut lines: Vec<Vec<String>> = vec![case.vary.iter().map(|f| f.key.clone()).chain(head).collect()];
    lines.extend(case.rows.iter().map(|row: &Row| {
        let wall = row.cost.as_ref().map_or_else(|| "–".into(), |c| format!("{:.4}", c.wall_s));
        let why = row.why.as_ref().map(|why| format!(": {why}")).unwrap_or_default();
        let outcome = format!("{}{why}", row.outcome.map_or("", Class::word));
        let numbers = [row.error, row.error_coupling, row.error_solver].map(number);
        let cells = row.settings.iter().map(|(_, value)| value.clone()).chain(numbers).chain([wall, outcome]);
        cells.map(|cell| printable(&cell)).collect()
    }));
    let mut text = format!("{}\nreference: {}\n\n", paint.bold(&printable(&case.title)), printable(&case.reference));
    text.push_str(&table(paint, &lines));
    for group in case.groups.iter().filter(|g| g.fit.is_some()) {
        let _ = write!(text, "\norder {}", order(group));
    }
    text.push_str("\n\n");
    for wanted in &case.cheapest {
        let found = wanted.row.and_then(|i| Some((&case.rows[i], case.rows[i].cost.as_ref()?.wall_s)));
        let answer =
            found.map_or_else(|| "none of these runs".into(), |(row, wall)| format!("{wall:.4} s with {}", row.name()));
        let _ = writeln!(text, "an error of {:>4} % costs {}", 100.0 * wanted.error, printable(&answer));
    }
    for note in &case.notes {
        let _ = writeln!(text, "{} {}", paint.warn("note:"), printable(note));
    }
    text
}

fn order(group: &Group) -> String {
    let Some(fit) = &group.fit else { return String::new() };
    let interval = fit.plus_minus.map(|half| format!(" ± {half:.3}")).unwrap_or_default();
    let floor = fit.with_floor.as_ref().map(|f| format!(", or {:.3} above a floor of {:.1e}", f.order, f.floor));
    let name = if group.name.is_empty() { String::new() } else { format!("  {}", printable(&group.name)) };
    format!("{:.3}{interval}{}{name}", fit.order, floor.unwrap_or_default())
}

fn failed_gates(case: &CaseResult, with_name: bool, paint: Paint) -> String {
    let judged = case.gates.iter().filter(|g| g.passed.is_some()).count();
    let mut text = String::new();
    for gate in case.gates.iter().filter(|gate| gate.passed == Some(false)) {
        let place: Vec<String> = gate.gate.r#where.iter().map(|(key, value)| format!("{key}={value}")).collect();
        let claim = match gate.gate.claim {
            Claim::Order([least, most]) => format!("an order between {least} and {most}"),
            Claim::Decay([least, most]) => format!("a factor per unit of the axis between {least} and {most}"),
            Claim::Error(most) => format!("an error of at most {most}"),
            Claim::Outcome(class) => format!("the outcome {}", class.word()),
        };
        let line = format!(
            "{} {} should have {claim}, but has {}: {}",
            case.name,
            place.join(" "),
            gate.measured,
            gate.gate.reason
        );
        let _ = writeln!(text, "{} {}", paint.bad("gate failed:"), printable(&line));
        if let Some(why) = &gate.gate.explained {
            let _ = writeln!(text, "{} {}", paint.warn("explained:"), printable(why));
        }
    }
    for gate in case.gates.iter().filter(|gate| gate.is_out_of_date()) {
        let line = format!("{}: a gate holds although its case explains why it does not: {}", case.name, gate.measured);
        let _ = writeln!(text, "{} {}", paint.warn("out of date:"), printable(&line));
    }
    if text.is_empty() && judged > 0 && !with_name {
        text = format!("{} all {judged} gates hold\n", paint.good("ok:"));
    }
    text
}

/// One line a case.
fn matrix(results: &[CaseResult], paint: Paint) -> String {
    let head = ["case", "runs", "smallest error", "gates", "order", "time of that run [s]", "1 % costs [s]"];
    let mut lines = vec![head.map(str::to_owned).to_vec()];
    lines.extend(results.iter().map(|case| {
        let wall = |place: Option<usize>| {
            let cost = place.and_then(|i| case.rows[i].cost.as_ref());
            cost.map_or_else(|| "–".into(), |c| format!("{:.4}", c.wall_s))
        };
        vec![
            case.name.clone(),
            case.rows.len().to_string(),
            number(case.smallest_error()),
            case.gates_in_short(),
            case.orders(),
            wall(case.front.last().copied()),
            wall(case.row_of_one_percent()),
        ]
    }));
    format!("\n{}", table(paint, &lines))
}
