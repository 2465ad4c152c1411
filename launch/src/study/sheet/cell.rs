//! A run of a sheet, for pages, tables and programs.

use std::path::{Path, PathBuf};

use cosplat_core::scene::Scene;
use serde::Serialize;

use super::super::evaluate::Finished;
use super::super::outcome::Class;
use super::Impact;
use crate::folder::curves::Table;
use crate::folder::{LEDGER, PICTURES};

/// A run of a sheet. SI units.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct Cell {
    /// Name of its row; empty where there is one row alone.
    pub(crate) row: String,
    /// Name of its column; empty where there is one column alone.
    pub(crate) column: String,
    /// How it ended.
    pub(crate) outcome: Option<Class>,
    /// What it complained about.
    pub(crate) why: Option<String>,
    /// What its striker did, where the sheet names one.
    pub(crate) impact: Option<Impact>,
    /// Coupling windows.
    pub(crate) windows: Option<u64>,
    /// Substeps of all solvers.
    pub(crate) substeps: Option<u64>,
    /// Wall time of the run, its pictures included \[s\].
    pub(crate) wall_s: Option<f64>,
    /// Processor time of all solvers \[s\]; null where the system does not tell.
    pub(crate) core_s: Option<f64>,
    /// Chain of all states.
    pub(crate) state_hash: Option<String>,
    /// Folder of the run.
    pub(crate) folder: String,
    /// Its picture.
    #[serde(skip)]
    pub(crate) picture: Option<PathBuf>,
}

impl Cell {
    /// What a run has left.
    pub(crate) fn of(
        names: (&str, &str),
        run: &Finished,
        scene: &Scene,
        at_s: Option<f64>,
        body: Option<&str>,
    ) -> Self {
        let summary = run.summary();
        let folder = Path::new(&run.folder);
        let ledger = || Table::read(&folder.join(LEDGER), 0).ok();
        let impact = summary.zip(body).and_then(|(_, body)| Impact::of(body, scene, run.probes()?, &ledger()?));
        Self {
            row: names.0.to_owned(),
            column: names.1.to_owned(),
            outcome: run.trials.first().map(super::super::trial::Trial::class),
            why: run.complaint(),
            impact,
            windows: summary.map(|s| s.windows),
            substeps: summary.map(|s| s.processes.iter().map(|p| p.substeps).sum()),
            wall_s: summary.map(|s| s.wall_s),
            core_s: summary.and_then(|s| s.processes.iter().map(|p| p.cpu_s).sum()),
            state_hash: summary.and_then(|s| s.state_hash.clone()),
            folder: run.folder.clone(),
            picture: picture(&folder.join(PICTURES), scene.clock.frames_per_second, at_s),
        }
    }

    /// Whether it has a result, and no verdict says that it is not to be trusted.
    pub(crate) fn is_good(&self) -> bool {
        matches!(self.outcome, Some(Class::Correct | Class::Degraded)) && self.why.is_none()
    }
}

/// The picture of the frame that is nearest to a moment; the last one where there is none so late.
fn picture(folder: &Path, fps: Option<f64>, at_s: Option<f64>) -> Option<PathBuf> {
    let entries = std::fs::read_dir(folder).ok()?;
    let mut files: Vec<PathBuf> = entries.filter_map(|entry| Some(entry.ok()?.path())).collect();
    files.retain(|path| path.extension().is_some_and(|end| end == "png"));
    files.sort_unstable();
    let last = files.len().checked_sub(1)?;
    let wanted = at_s.zip(fps).map_or(last, |(at, fps)| (at * fps).round() as usize);
    files.into_iter().nth(wanted.min(last))
}

/// One line a run.
pub(crate) fn csv(cells: &[Cell]) -> String {
    let mut out = csv::Writer::from_writer(Vec::new());
    let head = [
        "row",
        "column",
        "outcome",
        "touch_s",
        "approach_m_s",
        "dent_m",
        "rebound",
        "windows",
        "substeps",
        "wall_s",
        "core_s",
        "state_hash",
        "folder",
        "why",
    ];
    // Writing to memory cannot fail.
    let _ = out.write_record(head);
    for cell in cells {
        let of = |part: fn(&Impact) -> f64| cell.impact.as_ref().map(|i| part(i).to_string()).unwrap_or_default();
        let dent = cell.impact.and_then(|i| i.dent_m);
        let number = |value: Option<f64>| value.map(|v| v.to_string()).unwrap_or_default();
        let count = |value: Option<u64>| value.map(|v| v.to_string()).unwrap_or_default();
        let _ = out.write_record([
            cell.row.clone(),
            cell.column.clone(),
            cell.outcome.map_or("", Class::word).to_owned(),
            of(|i| i.touch_s),
            of(|i| i.approach_m_s),
            number(dent),
            of(|i| i.rebound),
            count(cell.windows),
            count(cell.substeps),
            number(cell.wall_s),
            number(cell.core_s),
            cell.state_hash.clone().unwrap_or_default(),
            cell.folder.clone(),
            cell.why.clone().unwrap_or_default(),
        ]);
    }
    String::from_utf8(out.into_inner().unwrap_or_default()).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_frame_nearest_to_a_moment_is_shown() {
        let place = tempfile::tempdir().unwrap();
        for i in 0..4 {
            std::fs::write(place.path().join(format!("frame_{i:04}.png")), []).unwrap();
        }
        let number = |at_s| picture(place.path(), Some(24.0), at_s).unwrap().display().to_string();
        assert!(number(Some(0.08)).ends_with("frame_0002.png"), "{}", number(Some(0.08)));
        assert!(number(None).ends_with("frame_0003.png") && number(Some(9.0)).ends_with("frame_0003.png"));
        assert_eq!(picture(&place.path().join("none"), Some(24.0), None), None);
    }
}
