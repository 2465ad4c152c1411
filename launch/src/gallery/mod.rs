//! Runs that have ended, side by side: what `cosplat report` tells.

pub(crate) mod compare;
pub(crate) mod read;

use compare::Comparison;
use read::ArchivedRun;

/// Runs and how those of one scene differ.
#[derive(Debug)]
pub(crate) struct Gallery {
    /// In the order in which they were asked for.
    pub(crate) runs: Vec<ArchivedRun>,
    /// Folders whose run cannot be shown, and why.
    pub(crate) unreadable: Vec<(String, String)>,
    /// One for each scene with two runs or more, in the order of their first runs.
    pub(crate) comparisons: Vec<Comparison>,
}

impl Gallery {
    /// Compares the runs of each scene.
    pub(crate) fn of(runs: Vec<ArchivedRun>, unreadable: Vec<(String, String)>) -> Self {
        let mut scenes: Vec<&str> = Vec::new();
        for run in &runs {
            if !scenes.contains(&run.summary.scene.as_str()) {
                scenes.push(&run.summary.scene);
            }
        }
        let comparisons = scenes.iter().filter_map(|scene| Comparison::of(scene, &runs)).collect();
        Self { runs, unreadable, comparisons }
    }
}
