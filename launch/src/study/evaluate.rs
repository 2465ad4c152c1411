//! From what the runs have left to errors, orders, fronts and gates.

use super::case::{Case, Comparison, Invariant, Kind, Measure, Quantity, Reference};
use super::design::Settings;
use super::outcome::{Class, complaints, reported};
use super::result::{CaseResult, Cost, Group, Measured, Row};
use super::trial::Trial;
use super::{front, gate, norm, order, pictures};
use crate::folder::curves::Table;
use crate::folder::summary::Summary;

/// The key on which the coupling error depends.
pub(crate) const WINDOW: &str = "clock.window";
/// Errors below are made of roundings and have no order.
const ROUNDING: f64 = 1e-12;

/// The repetitions of one combination.
#[derive(Debug)]
pub(crate) struct Finished {
    /// What was varied.
    pub(crate) settings: Settings,
    /// At least one.
    pub(crate) trials: Vec<Trial>,
    /// Folder of the first.
    pub(crate) folder: String,
}

impl Finished {
    pub(crate) fn probes(&self) -> Option<&Table> {
        self.trials.first().map(|trial| &trial.probes)
    }

    /// Summary of the first, where it has a result.
    pub(crate) fn summary(&self) -> Option<&Summary> {
        let first = self.trials.first().filter(|t| matches!(t.class(), Class::Correct | Class::Degraded))?;
        first.summary.as_ref()
    }

    /// Wall time inside the windows \[s\], where a repetition had the machine to itself.
    pub(crate) fn wall_s(&self) -> Option<f64> {
        let cost = cost(&self.trials);
        (cost.runs > 0 && !cost.beside_others).then_some(cost.wall_s)
    }

    /// Processor time of all solvers \[s\], set-up included; null where the system does not tell.
    pub(crate) fn core_s(&self) -> Option<f64> {
        cost(&self.trials).core_s
    }

    /// What the first complained about.
    pub(crate) fn complaint(&self) -> Option<String> {
        self.trials.first()?.end.why.clone()
    }

    pub(crate) fn curve(&self, column: &str) -> Vec<(f64, f64)> {
        self.probes().and_then(|table| table.curve(column)).unwrap_or_default()
    }
}

/// The curve that a quantity is compared with beside its own, by its name and reference.
type Beside<'a> = dyn Fn(&str, &Reference) -> Vec<(f64, f64)> + 'a;

/// Evaluates a case. `twins` are the runs of what it is compared with, one for each of its own; none where that is no
/// other scene.
pub(crate) fn evaluate(case: &Case, finished: &[Finished], twins: &[Finished]) -> CaseResult {
    let against_finest = case.quantities.is_empty();
    let quantities = match finished.last().and_then(Finished::probes) {
        Some(probes) if against_finest => from_probes(probes),
        _ => case.quantities.clone(),
    };
    let time = case.twin.as_ref().map_or(1.0, |twin| twin.time);
    let row = |(i, f): (usize, &Finished)| {
        row(f, &quantities, &|quantity, reference| match reference {
            Reference::Twin(value) => {
                let curve = twins.get(i).map(|twin| twin.curve(quantity)).unwrap_or_default();
                curve.into_iter().map(|(t, v)| (t * time, v * value)).collect()
            }
            _ => finished.last().map(|last| last.curve(quantity)).unwrap_or_default(),
        })
    };
    let mut rows: Vec<Row> = finished.iter().enumerate().map(row).collect();
    if let Some(last) = rows.last_mut().filter(|_| against_finest) {
        // It would be compared with itself.
        (last.error, last.errors) = (None, vec![None; quantities.len()]);
    }
    let groups = groups(&rows);
    if !against_finest {
        split(&mut rows, &quantities, finished);
    }
    let costs: Vec<_> = rows.iter().map(Row::work_and_error).collect();
    CaseResult {
        name: case.name.clone(),
        title: case.title.clone(),
        scene: case.scene.clone(),
        reference: match rows.last().filter(|_| against_finest) {
            Some(last) => format!("the finest run of the study itself ({})", last.name()),
            None => case.source.clone(),
        },
        notes: notes(case, &quantities, &rows, finished),
        quantities: quantities.iter().map(measured).collect(),
        vary: case.vary.clone(),
        gates: case.gates.iter().map(|g| gate::judge(g, &quantities, &rows, &groups)).collect(),
        front: front::pareto(&costs),
        cheapest: front::cheapest(&costs),
        groups,
        rows,
    }
}

/// Every column of the probes that moves, scaled by how far its probe moves: a component that stays where it is would
/// have no norm of its own.
pub(crate) fn from_probes(table: &Table) -> Vec<Quantity> {
    let names: Vec<&str> = table.value_names().collect();
    let probe = |name: &str| name.rsplit_once('.').map_or(name, |(probe, _)| probe).to_owned();
    let motion = |name: &str| {
        let curve = table.curve(name).unwrap_or_default();
        let first = curve.first().map_or(0.0, |p| p.1);
        let squares: f64 = curve.iter().map(|p| (p.1 - first).powi(2)).sum();
        (squares / curve.len().max(1) as f64).sqrt()
    };
    let moving = names.iter().filter(|name| motion(name) > 0.0);
    let quantity = |name: &&str| {
        let others = names.iter().filter(|other| probe(other) == probe(name));
        let comparison = Comparison {
            reference: Reference::Finest,
            measure: Measure::L2,
            scale: others.map(|other| motion(other)).reduce(f64::max),
            from_s: 0.0,
            until_s: f64::INFINITY,
            spread: 0.0,
        };
        Quantity { name: (*name).to_owned(), kind: Kind::Probe(Box::new(comparison)) }
    };
    moving.map(quantity).collect()
}

/// `other` is the curve of a quantity that a reference asks for beside its own.
fn row(finished: &Finished, quantities: &[Quantity], other: &Beside<'_>) -> Row {
    let settings = &finished.settings;
    let mut row = Row {
        settings: settings.values.iter().map(|(key, level)| (key.clone(), level.shown.clone())).collect(),
        group: settings.group(),
        axis: settings.axis(),
        errors: vec![None; quantities.len()],
        folder: finished.folder.clone(),
        cached: finished.trials.iter().filter(|t| t.cached).count(),
        ..Row::default()
    };
    let Some(first) = finished.trials.first() else { return row };
    row.outcome = Some(first.class());
    row.exit_code = first.end.code;
    row.why.clone_from(&first.end.why);
    let Some(summary) = first.summary.as_ref().filter(|_| row.has_result()) else { return row };
    row.window_s = Some(summary.window_s);
    row.substeps = Some(summary.processes.iter().map(|p| p.substeps).sum());
    row.energy_drift = energy_drift(summary, None);
    row.momentum_defect = Some(momentum_defect(summary));
    row.complaints = complaints(summary).map(|c| c.2).sum();
    row.reported = reported(summary);
    row.state_hash.clone_from(&summary.state_hash);
    row.cost = Some(cost(&finished.trials));
    let error = |quantity: &Quantity| match &quantity.kind {
        Kind::Probe(comparison) => {
            let other = other(&quantity.name, &comparison.reference);
            norm::error(&finished.curve(&quantity.name), comparison, &other)
        }
        Kind::Invariant(Invariant::Energy { scale }) => energy_drift(summary, *scale),
        Kind::Invariant(Invariant::EnergyRise { scale }) => energy_rise(summary, *scale),
        Kind::Invariant(Invariant::Momentum) => row.momentum_defect,
        Kind::Invariant(Invariant::Picture) => pictures::change(finished),
    };
    row.errors = quantities.iter().map(error).collect();
    row.error = largest(&row.errors, quantities);
    if row.error.is_some_and(|error| !error.is_finite()) {
        // A run that does not notice this itself has failed in silence.
        row.outcome = Some(Class::Failed);
        row.why = Some("a probe holds values that are not numbers".into());
        row.error = None;
    }
    row
}

/// The largest error of what has a reference, or of the invariants where nothing has.
fn largest(errors: &[Option<f64>], quantities: &[Quantity]) -> Option<f64> {
    let has_probes = quantities.iter().any(|q| matches!(q.kind, Kind::Probe(_)));
    let counts = |q: &Quantity| matches!(q.kind, Kind::Probe(_)) == has_probes;
    let chosen = errors.iter().zip(quantities).filter(|(_, q)| counts(q));
    chosen.filter_map(|(error, _)| *error).reduce(f64::max)
}

/// Largest deviation of the total energy from its start, over a scale \[J\] or over the start itself.
fn energy_drift(summary: &Summary, scale: Option<f64>) -> Option<f64> {
    let total = summary.energy.iter().find(|e| e.name == "total")?;
    let start = total.initial_j.unwrap_or(total.first_j);
    let deviation = (total.max_j - start).abs().max((total.min_j - start).abs());
    let scale = scale.unwrap_or(start.abs());
    (scale > 0.0).then(|| deviation / scale)
}

/// Largest rise of the total energy above its start and what was supplied, over a scale \[J\] or over the start itself.
fn energy_rise(summary: &Summary, scale: Option<f64>) -> Option<f64> {
    let total = summary.energy.iter().find(|e| e.name == "total")?;
    let start = total.initial_j.unwrap_or(total.first_j);
    let scale = scale.unwrap_or(start.abs());
    (scale > 0.0).then(|| (total.max_unsupplied_j - start).max(0.0) / scale)
}

/// The worst of all interfaces; without interfaces, the worst closure of a process.
fn momentum_defect(summary: &Summary) -> f64 {
    let interfaces = summary.interfaces.iter().map(|i| i.momentum_defect);
    let closures = summary.verdicts.iter().filter(|v| v.name.starts_with("closure")).map(|v| v.value);
    interfaces.chain(closures).fold(0.0, f64::max)
}

/// Wall time inside the windows \[s\].
fn wall_s(summary: &Summary) -> f64 {
    summary.processes.iter().map(|p| p.compute_s + p.wait_s + p.transfer_s).fold(0.0, f64::max)
}

/// From the repetitions that were made alone, where any was.
fn cost(trials: &[Trial]) -> Cost {
    let inside = |s: &&Summary| wall_s(s);
    let beside_others = trials.iter().all(|trial| trial.end.beside_others);
    let counts = |trial: &&Trial| beside_others || !trial.end.beside_others;
    let mut summaries: Vec<&Summary> = trials.iter().filter(counts).filter_map(|t| t.summary.as_ref()).collect();
    summaries.sort_by(|a, b| inside(a).total_cmp(&inside(b)));
    let Some(middle) = summaries.get((summaries.len().max(1) - 1) / 2) else { return Cost::default() };
    let wall_s = inside(middle);
    let ends = summaries.first().zip(summaries.last()).map_or(0.0, |(least, most)| inside(most) - inside(least));
    Cost {
        wall_s,
        wall_spread: if wall_s > 0.0 { ends / wall_s } else { 0.0 },
        runs: summaries.len(),
        beside_others,
        simulated_s: middle.simulated_s,
        core_s: middle.processes.iter().map(|p| p.cpu_s).sum(),
        processes: middle.processes.clone(),
    }
}

fn groups(rows: &[Row]) -> Vec<Group> {
    let mut groups: Vec<Group> = Vec::new();
    for (i, row) in rows.iter().enumerate() {
        match groups.iter_mut().find(|group| group.name == row.group) {
            Some(group) => group.rows.push(i),
            None => groups.push(Group { name: row.group.clone(), rows: vec![i], fit: None }),
        }
    }
    for group in &mut groups {
        let levels = group.rows.iter().filter_map(|&i| Some((rows[i].axis?, rows[i].error?)));
        let levels: Vec<_> = levels.filter(|level| level.1 > ROUNDING).collect();
        group.fit = order::fit(&levels);
    }
    groups
}

/// Tells the error of the coupling from that of the solvers: of the runs that differ in the window alone, the one with
/// the shortest stands for a coupling without error.
fn split(rows: &mut [Row], quantities: &[Quantity], finished: &[Finished]) {
    for i in 0..rows.len() {
        let same = |row: &&Row| row.has_result() && row.without(WINDOW) == rows[i].without(WINDOW);
        let windows = rows.iter().enumerate().filter(|(_, row)| same(row));
        let windows = windows.filter_map(|(place, row)| Some((place, row.value(WINDOW)?)));
        let Some((finest, _)) = windows.min_by(|a, b| a.1.total_cmp(&b.1)).filter(|(finest, _)| *finest != i) else {
            continue;
        };
        let apart = |quantity: &Quantity| match &quantity.kind {
            Kind::Probe(comparison) => {
                let curves = [i, finest].map(|place| finished[place].curve(&quantity.name));
                norm::distance(&curves[0], &curves[1], comparison)
            }
            Kind::Invariant(_) => None,
        };
        if rows[i].has_result() {
            rows[i].error_coupling = quantities.iter().filter_map(apart).reduce(f64::max);
            rows[i].error_solver = rows[finest].error;
        }
    }
}

fn measured(quantity: &Quantity) -> Measured {
    let (measure, reference) = match &quantity.kind {
        Kind::Probe(comparison) => {
            let reference = match &comparison.reference {
                Reference::Exact(formula) => formula.text().to_owned(),
                Reference::Table(points) => format!("a table of {} points", points.len()),
                Reference::Between([least, most]) => format!("between {least} and {most}"),
                Reference::Finest => "the finest run".to_owned(),
                Reference::Twin(factor) if (factor - 1.0).abs() < f64::EPSILON => "its twin".to_owned(),
                Reference::Twin(factor) => format!("its twin, times {factor}"),
            };
            (Some(comparison.measure), reference)
        }
        Kind::Invariant(Invariant::Energy { .. } | Invariant::EnergyRise { .. }) => {
            (None, "the total energy at the start".to_owned())
        }
        Kind::Invariant(Invariant::Momentum) => (None, "the impulses that explain it".to_owned()),
        Kind::Invariant(Invariant::Picture) => (None, "the first picture".to_owned()),
    };
    Measured { name: quantity.name.clone(), measure, reference }
}

fn notes(case: &Case, quantities: &[Quantity], rows: &[Row], finished: &[Finished]) -> Vec<String> {
    let mut notes = Vec::new();
    if case.quantities.is_empty() {
        notes.push("This scene has no reference of its own: errors are distances from the finest run.".to_owned());
    }
    if quantities.is_empty() {
        notes.push("The scene has no `[[probe]]` that moves, so there is nothing to compare.".to_owned());
    }
    for (i, quantity) in quantities.iter().enumerate() {
        let is_compared = rows.iter().any(|row| row.errors.get(i).copied().flatten().is_some());
        if !is_compared && rows.iter().any(Row::has_result) {
            notes.push(format!("`{}` could be compared in no run: no such column of the probes, no common time, or a reference that is zero.", quantity.name));
        }
    }
    let is_loud = |row: &&Row| row.cost.as_ref().is_some_and(|c| c.wall_spread > 0.1);
    let loud = rows.iter().filter(is_loud).count();
    if loud > 0 {
        notes.push(format!("The wall times of {loud} runs scatter by more than 10 %: this machine was not quiet."));
    }
    let shared = rows.iter().filter(|row| row.cost.as_ref().is_some_and(|c| c.beside_others)).count();
    if shared > 0 {
        notes.push(format!(
            "The times of {shared} runs were taken with other runs beside them, on shared cores: they are upper bounds. \
             `--runs 2` makes a second one of each alone, `--jobs 1` all of them."
        ));
    }
    let hash = |trial: &Trial| trial.summary.as_ref().and_then(|s| s.state_hash.clone());
    if finished.iter().any(|f| f.trials.windows(2).any(|w| hash(&w[0]) != hash(&w[1]))) {
        notes.push("Repetitions of a run ended in different states: something in it is not deterministic.".to_owned());
    }
    notes
}
