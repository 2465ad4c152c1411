//! What a decision is worth: what the other way round changes, and what it would cost.

use serde::Serialize;

use super::super::case::{Comparison, Kind, Measure, Reference};
use super::super::evaluate::{Finished, from_probes};
use super::super::{norm, pictures};
use super::Decision;
use crate::folder::summary::Summary;

/// What a decision is worth.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct Worth {
    /// Short name.
    pub(crate) name: String,
    /// What was done the other way round.
    pub(crate) instead: String,
    /// What the decision was taken by, in words; empty where it follows from what the scene asks for.
    pub(crate) indicator: String,
    /// Whether nothing was allowed to change.
    pub(crate) must_not_matter: bool,
    /// Whether both runs end in the same state, to the bit.
    pub(crate) same_bytes: bool,
    /// Largest distance of a probe between the two runs, relative to how far it moves; null where none moves.
    pub(crate) difference: Option<f64>,
    /// Root of the mean squared difference of the last pictures, of colours from 0 to 1; null where there are none.
    pub(crate) pictures_difference: Option<f64>,
    /// Wall time inside the windows that the decision saves \[s\], where both were run alone.
    pub(crate) saved_s: Option<f64>,
    /// Processor time of all solvers that it saves \[s\], set-up included: runs beside it disturb it least.
    pub(crate) saved_core_s: Option<f64>,
    /// Memory of all processes that it saves \[MiB\].
    pub(crate) saved_mib: Option<f64>,
    /// Wall time beside the solvers in which frames are moved, drawn, written and recorded that it saves \[s\].
    pub(crate) saved_frames_s: Option<f64>,
    /// Messages over interfaces that it saves.
    pub(crate) saved_messages: i64,
    /// Why there is nothing to compare.
    pub(crate) why_not: Option<String>,
    /// False where something changed that was not allowed to.
    pub(crate) passed: bool,
}

/// Compares the run as it is with the run the other way round.
pub(crate) fn worth(decision: &Decision, plain: &Finished, other: &Finished) -> Worth {
    let summaries = (plain.summary(), other.summary());
    let hash = |summary: Option<&Summary>| summary.and_then(|s| s.state_hash.clone());
    let same_bytes = hash(summaries.0).is_some() && hash(summaries.0) == hash(summaries.1);
    let both = summaries.0.zip(summaries.1);
    let memory = |s: &Summary| s.processes.iter().map(|p| p.peak_rss_mib).sum::<Option<f64>>();
    let messages = |s: &Summary| (2 * s.windows * s.interfaces.len() as u64).cast_signed();
    let difference = difference(plain, other);
    let same_probes = decision.by_probes && difference.is_some_and(|d| d <= 0.0);
    Worth {
        name: decision.name.clone(),
        instead: decision.instead.clone(),
        indicator: decision.indicator.clone(),
        must_not_matter: decision.must_not_matter,
        same_bytes,
        difference,
        pictures_difference: pictures::difference(plain, other),
        saved_s: both.and_then(|_| Some(other.wall_s()? - plain.wall_s()?)),
        saved_core_s: both.and_then(|_| Some(other.core_s()? - plain.core_s()?)),
        saved_mib: both.and_then(|(plain, other)| Some(memory(other)? - memory(plain)?)),
        saved_frames_s: both.map(|(plain, other)| frames_s(other) - frames_s(plain)),
        saved_messages: both.map_or(0, |(plain, other)| messages(other) - messages(plain)),
        why_not: both.is_none().then(|| other.complaint().unwrap_or_else(|| "it has no result".into())),
        passed: same_bytes || same_probes || !decision.must_not_matter,
    }
}

/// Largest distance of a probe between two runs.
fn difference(plain: &Finished, other: &Finished) -> Option<f64> {
    let quantities = from_probes(plain.probes()?);
    let apart = quantities.iter().filter_map(|quantity| {
        let Kind::Probe(known) = &quantity.kind else { return None };
        let comparison = Comparison { reference: Reference::Finest, measure: Measure::L2, ..(**known).clone() };
        norm::error(&other.curve(&quantity.name), &comparison, &plain.curve(&quantity.name))
    });
    apart.reduce(f64::max)
}

/// Wall time for frames \[s\].
fn frames_s(summary: &Summary) -> f64 {
    summary.frames.as_ref().map_or(0.0, |f| f.skin_s + f.draw_s + f.write_s + f.record_s)
}
