//! The diagrams and tables of a study as a recording for the rerun viewer.

use std::path::Path;

use cosplat_viewer::recording::RecordingError;
use cosplat_viewer::recording::diagram::{Diagram, Series, Text, write_diagrams};

use super::outcome::Class;
use super::result::{CaseResult, Judged, Row};
use super::stability::{Behaviour, Field};
use crate::page::scatter::{Join, colour};
use crate::page::study::plots::diagrams;
use crate::page::study::tables::claim;

/// Writes the diagrams of all cases, those of a case beside each other and beside its tables.
///
/// # Errors
/// The file cannot be written.
pub(crate) fn write(path: &Path, name: &str, cases: &[CaseResult]) -> Result<(), RecordingError> {
    let all: Vec<Diagram> = cases.iter().flat_map(of_case).collect();
    let texts: Vec<Text> = cases.iter().map(told).collect();
    write_diagrams(path, &format!("study {name}"), &format!("cosplat-study-{name}"), &all, &texts)
}

/// Writes the map of extreme settings: how many runs of each case behave how, and every run.
///
/// # Errors
/// The file cannot be written.
pub(crate) fn write_map(path: &Path, cases: &[CaseResult], fields: &[Field]) -> Result<(), RecordingError> {
    let own = |case: &CaseResult| fields.iter().filter(|f| f.case == case.name).collect::<Vec<_>>();
    let line = |case: &CaseResult| {
        let count = |how: Behaviour| own(case).iter().filter(|f| f.behaviour == how).count().to_string();
        [case.title.clone()].into_iter().chain(Behaviour::ALL.map(count)).collect()
    };
    let head: Vec<&str> = ["case"].into_iter().chain(Behaviour::ALL.map(Behaviour::word)).collect();
    let text = |group: &str, title: &str, markdown| Text { group: group.into(), title: title.into(), markdown };
    let map = text("map", "What extreme settings do", table(&head, cases.iter().map(line).collect()));
    let runs = cases.iter().map(|case| {
        let line =
            |f: &&Field| vec![f.settings.clone(), f.behaviour.word().into(), f.says.join("; "), f.broken.join("; ")];
        let head = ["run", "behaviour", "what it says", "criteria that are broken"];
        text(&case.name, &case.title, table(&head, own(case).iter().map(line).collect()))
    });
    let texts: Vec<Text> = [map].into_iter().chain(runs).collect();
    write_diagrams(path, "stability", "cosplat-study-stability", &[], &texts)
}

/// Gates, cheapest runs and all runs of a case.
fn told(case: &CaseResult) -> Text {
    let number = |value: Option<f64>| value.map_or_else(|| "–".into(), |v| format!("{v:.3e}"));
    let gate = |judged: &Judged| {
        let word = match judged.passed {
            Some(true) => "holds",
            Some(false) => "**failed**",
            None => "not judged",
        };
        let reason = [Some(&judged.gate.reason), judged.gate.explained.as_ref()];
        let reason = reason.into_iter().flatten().cloned().collect::<Vec<_>>().join(". Why it does not: ");
        let place: Vec<String> = judged.gate.r#where.iter().map(|(key, value)| format!("{key}={value}")).collect();
        vec![word.into(), place.join(" "), claim(judged.gate.claim), judged.measured.clone(), reason]
    };
    let wall = |row: &Row| number(row.cost.as_ref().map(|c| c.wall_s));
    let run = |row: &Row| {
        let outcome = row.outcome.map_or("not run", Class::word).to_owned();
        let errors = [row.error, row.error_coupling, row.error_solver].map(number);
        [row.name(), outcome].into_iter().chain(errors).chain([wall(row)]).collect()
    };
    let cheapest = case.cheapest.iter().map(|wanted| {
        let row = wanted.row.map(|i| &case.rows[i]);
        let name = row.map_or_else(|| "none of these runs".into(), Row::name);
        vec![format!("{} %", 100.0 * wanted.error), name, row.map_or_else(|| "–".into(), wall)]
    });
    let parts = [
        format!("# {}\n\nScene `{}`. Reference: {}.\n\n", case.title, case.scene, case.reference),
        case.notes.iter().flat_map(|note| [note.as_str(), "\n\n"]).collect(),
        table(&["gate", "runs", "claim", "measured", "why it must hold"], case.gates.iter().map(gate).collect()),
        table(&["error at most", "cheapest run", "time [s]"], cheapest.collect()),
        table(&["run", "outcome", "error", "coupling", "rest", "time [s]"], case.rows.iter().map(run).collect()),
    ];
    Text { group: case.name.clone(), title: "Gates and runs".into(), markdown: parts.concat() }
}

/// A table in Markdown; nothing where it has no lines.
fn table(head: &[&str], lines: Vec<Vec<String>>) -> String {
    if lines.is_empty() {
        return String::new();
    }
    let cell = |text: &str| text.replace('|', "\\|").replace('\n', " ");
    let line = |cells: Vec<String>| format!("| {} |\n", cells.join(" | "));
    let rule = line(head.iter().map(|_| "---".to_owned()).collect());
    let head = line(head.iter().map(|&name| name.to_owned()).collect());
    let lines = lines.into_iter().map(|cells| line(cells.iter().map(|text| cell(text)).collect()));
    [head, rule].into_iter().chain(lines).chain(["\n".to_owned()]).collect()
}

fn of_case(case: &CaseResult) -> Vec<Diagram> {
    let series = |s: crate::page::scatter::Series| Series {
        colour: rgb(colour(s.style)),
        marked: matches!(s.line, Join::Apart | Join::Thin),
        joined: s.line != Join::Apart,
        name: s.name,
        points: s.points,
    };
    let one = |drawn: crate::page::scatter::Scatter| Diagram {
        group: case.name.clone(),
        title: format!("{}: {}", case.name, drawn.title),
        axes: [drawn.x, drawn.y],
        series: drawn.series.into_iter().map(series).collect(),
    };
    diagrams(case).into_iter().map(one).collect()
}

/// The bytes of `#rrggbb`; black where it is none.
fn rgb(text: &str) -> [u8; 3] {
    let byte = |i: usize| text.get(i..i + 2).and_then(|two| u8::from_str_radix(two, 16).ok()).unwrap_or(0);
    [byte(1), byte(3), byte(5)]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_recording_of_no_case_can_be_written_and_colours_are_read() {
        let place = tempfile::tempdir().unwrap();
        for (name, write) in
            [("study.rrd", write as fn(&Path, &str, &[CaseResult]) -> _), ("map.rrd", |p, _, c| write_map(p, c, &[]))]
        {
            let path = place.path().join(name);
            write(&path, "nothing", &[]).unwrap();
            assert!(std::fs::read(&path).unwrap().starts_with(b"RRF2"));
        }
        assert_eq!((rgb("#0072b2"), rgb("x")), ([0, 0x72, 0xb2], [0; 3]));
    }

    #[test]
    fn a_table_keeps_its_columns() {
        let text = table(&["a", "b"], vec![vec!["x|y".into(), "1\n2".into()]]);
        assert_eq!(text, "| a | b |\n| --- | --- |\n| x\\|y | 1 2 |\n\n");
        assert_eq!(table(&["a"], Vec::new()), "");
    }
}
