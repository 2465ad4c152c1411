//! How the runs of one scene differ from the first of them: what each took, and by how much the results are apart.

use serde::Serialize;

use super::read::ArchivedRun;
use crate::folder::curves::Table;

/// Runs of one scene, the first of which is what the others are compared with.
#[derive(Debug, Serialize)]
pub(crate) struct Comparison {
    /// Name of the scene.
    pub(crate) scene: String,
    /// Places of the runs among all runs; the first is the reference.
    #[serde(skip)]
    pub(crate) places: Vec<usize>,
    /// Folders of the runs.
    pub(crate) runs: Vec<String>,
    /// Whether each run ended in the same state as the reference, to the last bit.
    pub(crate) same_state: Vec<bool>,
    /// Quantities of the summaries.
    pub(crate) quantities: Vec<Quantity>,
    /// Columns of the probes that the reference and another run have.
    pub(crate) probes: Vec<Apart>,
}

/// One number of each run.
#[derive(Debug, PartialEq, Serialize)]
pub(crate) struct Quantity {
    /// What.
    pub(crate) name: String,
    /// Its unit.
    pub(crate) unit: &'static str,
    /// By run; absent where a run has none.
    pub(crate) values: Vec<Option<f64>>,
}

/// By how much a curve is apart from that of the reference, over the time that both cover.
#[derive(Debug, PartialEq, Serialize)]
pub(crate) struct Apart {
    /// Column of the probes.
    pub(crate) column: String,
    /// Largest minus smallest value of the reference, in the unit of the probe.
    pub(crate) range: f64,
    /// By run: the root mean square of the difference, and the largest; absent where a run has no such column.
    pub(crate) differences: Vec<Option<Difference>>,
}

/// Difference of two curves, in the unit of the probe.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub(crate) struct Difference {
    /// Root of the mean square at the times of the reference.
    pub(crate) rms: f64,
    /// Largest magnitude.
    pub(crate) max: f64,
}

impl Comparison {
    /// Compares the runs of a scene; none where there are less than two.
    pub(crate) fn of(scene: &str, runs: &[ArchivedRun]) -> Option<Self> {
        let places: Vec<usize> = (0..runs.len()).filter(|&i| runs[i].summary.scene == scene).collect();
        let chosen: Vec<&ArchivedRun> = places.iter().map(|&i| &runs[i]).collect();
        let (first, others) = chosen.split_first()?;
        if others.is_empty() {
            return None;
        }
        let hash = &first.summary.state_hash;
        Some(Self {
            scene: scene.to_owned(),
            runs: chosen.iter().map(|run| run.folder.display().to_string()).collect(),
            same_state: chosen.iter().map(|run| hash.is_some() && run.summary.state_hash == *hash).collect(),
            quantities: quantities(&chosen),
            probes: probes(first, &chosen),
            places,
        })
    }
}

fn quantities(runs: &[&ArchivedRun]) -> Vec<Quantity> {
    let of = |name: &str, unit, value: &dyn Fn(&ArchivedRun) -> Option<f64>| Quantity {
        name: name.to_owned(),
        unit,
        values: runs.iter().map(|run| value(run)).collect(),
    };
    let worst = |values: Vec<f64>| values.into_iter().reduce(f64::max);
    let mut all = vec![
        of("Wall time", "s", &|r| Some(r.summary.wall_s)),
        of("Processor time of the solvers", "s", &|r| r.summary.processes.iter().map(|p| p.cpu_s).sum()),
        of("Peak memory of the solvers", "MiB", &|r| r.summary.processes.iter().map(|p| p.peak_rss_mib).sum()),
        of("Windows", "1", &|r| Some(r.summary.windows as f64)),
        of("Length of a window", "s", &|r| Some(r.summary.window_s)),
        of("Substeps of all solvers", "1", &|r| {
            Some(r.summary.processes.iter().map(|p| p.substeps).sum::<u64>() as f64)
        }),
        of("Worst momentum defect", "1", &|r| worst(r.summary.interfaces.iter().map(|i| i.momentum_defect).collect())),
        of("Gross impulse of all interfaces", "N s", &|r| {
            Some(r.summary.interfaces.iter().map(|i| i.gross_impulse).sum())
                .filter(|_| !r.summary.interfaces.is_empty())
        }),
        of("Work defect of all interfaces", "J", &|r| {
            Some(r.summary.interfaces.iter().map(|i| i.work_defect).sum()).filter(|_| !r.summary.interfaces.is_empty())
        }),
    ];
    let total = |r: &ArchivedRun| r.summary.energy.iter().find(|e| e.name == "total").cloned();
    all.push(of("Total energy at the end", "J", &|r| total(r).map(|e| e.final_j)));
    all.push(of("Dissipated", "J", &|r| total(r).map(|e| e.dissipated_j)));
    let mut bodies: Vec<&str> = Vec::new();
    for body in runs.iter().flat_map(|r| &r.summary.bodies) {
        if !bodies.contains(&body.name.as_str()) {
            bodies.push(&body.name);
        }
    }
    all.extend(bodies.into_iter().map(|name| {
        of(&format!("Largest displacement of {name}"), "m", &|r| {
            r.summary.bodies.iter().find(|b| b.name == name).map(|b| b.max_displacement_m)
        })
    }));
    all.retain(|quantity| quantity.values.iter().any(Option::is_some));
    all
}

fn probes(first: &ArchivedRun, runs: &[&ArchivedRun]) -> Vec<Apart> {
    let columns = first.probes.value_names().filter_map(|name| {
        let reference = first.probes.curve(name)?;
        let values = || reference.iter().map(|p| p.1).filter(|v| v.is_finite());
        let range = values().fold(f64::NEG_INFINITY, f64::max) - values().fold(f64::INFINITY, f64::min);
        let differences = runs.iter().map(|run| difference(&reference, &run.probes, name)).collect();
        Some(Apart { column: name.to_owned(), range, differences })
    });
    columns.filter(|apart| apart.differences.iter().skip(1).any(Option::is_some)).collect()
}

/// The difference from a reference at the times of the reference that lie within the other curve.
fn difference(reference: &[(f64, f64)], other: &Table, column: &str) -> Option<Difference> {
    let other = other.curve(column)?;
    let pairs = reference.iter().filter_map(|&(t, value)| Some(at(&other, t)? - value));
    let (mut sum, mut max, mut count) = (0.0, 0.0_f64, 0_u32);
    for apart in pairs.filter(|d| d.is_finite()) {
        sum += apart * apart;
        max = max.max(apart.abs());
        count += 1;
    }
    (count > 0).then(|| Difference { rms: (sum / f64::from(count)).sqrt(), max })
}

/// Value of a curve at a time, linear between its points; none outside.
fn at(curve: &[(f64, f64)], time: f64) -> Option<f64> {
    let after = curve.partition_point(|p| p.0 < time);
    let end = curve.get(after)?;
    // Only where the point after it lies at the time itself may there be none before it.
    if end.0 <= time {
        return Some(end.1);
    }
    let start = curve.get(after.checked_sub(1)?)?;
    Some(start.1 + (end.1 - start.1) * (time - start.0) / (end.0 - start.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn curves_with_other_windows_are_compared_where_both_are() {
        let place = tempfile::tempdir().unwrap();
        let path = place.path().join("probes.csv");
        // v = 2 t with windows of a quarter, against v = 2 t + 0.5 with windows of a third that end early.
        std::fs::write(&path, "window,time_s,p.x\n0,0.3,1.1\n1,0.6,1.7\n2,0.9,2.3\n").unwrap();
        let other = Table::read(&path, 0).unwrap();
        let reference: Vec<(f64, f64)> = (1..=4).map(|i| f64::from(i) * 0.25).map(|t| (t, 2.0 * t)).collect();
        let Difference { rms, max } = difference(&reference, &other, "p.x").unwrap();
        // Both are straight, so that interpolation is exact up to rounding.
        assert!((rms - 0.5).abs() < 1e-14 && (max - 0.5).abs() < 1e-14, "{rms} {max}");
        assert_eq!(difference(&reference, &other, "p.y"), None);
        assert_eq!(at(&reference, 0.1), None);
        assert_eq!(at(&reference, 1.0), Some(2.0));
    }
}
