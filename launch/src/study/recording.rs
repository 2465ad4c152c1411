//! The diagrams of a study as a recording for the rerun viewer.

use std::path::Path;

use cosplat_viewer::recording::RecordingError;
use cosplat_viewer::recording::diagram::{Diagram, Series, write_diagrams};

use super::result::CaseResult;
use crate::page::scatter::{Join, colour};
use crate::page::study::plots::diagrams;

/// Writes the diagrams of all cases, those of a case beside each other.
///
/// # Errors
/// The file cannot be written.
pub(crate) fn write(path: &Path, name: &str, cases: &[CaseResult]) -> Result<(), RecordingError> {
    let all: Vec<Diagram> = cases.iter().flat_map(of_case).collect();
    write_diagrams(path, &format!("study {name}"), &format!("cosplat-study-{name}"), &all)
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
        let path = place.path().join("study.rrd");
        write(&path, "nothing", &[]).unwrap();
        assert!(std::fs::read(&path).unwrap().starts_with(b"RRF2"));
        assert_eq!((rgb("#0072b2"), rgb("x")), ([0, 0x72, 0xb2], [0; 3]));
    }
}
