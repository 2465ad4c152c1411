//! Curves for the report, read back from the tables of a run.

use std::fs::File;
use std::io;
use std::path::Path;

use cosplat_core::plan::{BoundaryForm, Plan};

use crate::page::{Chart, Line};
use crate::verdict::ClosureGate;

/// Points of a curve, about: more than a screen has columns.
const POINTS: u64 = 4000;
/// Columns that say which row it is.
const INDEX: [&str; 2] = ["window", "time_s"];

/// A table of numbers: the first column is the time.
#[derive(Clone, Debug, Default)]
pub(crate) struct Table {
    names: Vec<String>,
    /// One list a column; of each bunch of rows the value of largest magnitude, so that no peak is lost.
    columns: Vec<Vec<f64>>,
    time_s: Vec<f64>,
}

impl Table {
    /// Reads a table of about `rows` rows, thinned to what a screen can show; with 0 every row is kept.
    ///
    /// # Errors
    /// The file cannot be read.
    pub(crate) fn read(path: &Path, rows: u64) -> io::Result<Self> {
        let bunch = rows.div_ceil(POINTS).max(1);
        let mut reader = csv::Reader::from_reader(File::open(path)?);
        let names: Vec<String> = reader.headers()?.iter().map(str::to_owned).collect();
        let time = names.iter().position(|n| n == "time_s").unwrap_or(0);
        let mut table = Self { columns: vec![Vec::new(); names.len()], names, time_s: Vec::new() };
        for (i, row) in reader.records().enumerate() {
            let row = row?;
            let begins = (i as u64).is_multiple_of(bunch);
            if begins {
                table.time_s.push(row.get(time).and_then(|t| t.parse().ok()).unwrap_or(f64::NAN));
            }
            for (column, cell) in table.columns.iter_mut().zip(&row) {
                let value: f64 = cell.parse().unwrap_or(f64::NAN);
                match column.last_mut().filter(|_| !begins) {
                    Some(last) if value.is_nan() || value.abs() > last.abs() => *last = value,
                    Some(_) => {}
                    None => column.push(value),
                }
            }
        }
        Ok(table)
    }

    /// Names of all columns but those that count and time the rows.
    pub(crate) fn value_names(&self) -> impl Iterator<Item = &str> {
        self.names.iter().map(String::as_str).filter(|n| !INDEX.contains(n))
    }

    /// Time \[s\] and value of a column.
    pub(crate) fn curve(&self, name: &str) -> Option<Vec<(f64, f64)>> {
        self.names.iter().position(|n| n == name).map(|at| self.points(at))
    }

    fn points(&self, column: usize) -> Vec<(f64, f64)> {
        self.time_s.iter().copied().zip(self.columns[column].iter().copied()).collect()
    }

    fn line<'a>(&self, name: &'a str, column: &str, gate: Option<f64>) -> Option<Line<'a>> {
        Some(Line { name, gate, points: self.curve(column)? })
    }

    /// Curves of the ledger.
    pub(super) fn ledger<'a>(&self, plan: &'a Plan, forms: &[BoundaryForm]) -> Vec<Chart<'a>> {
        let solvers = || plan.solvers().iter().map(|p| p.name.as_str());
        let interfaces = || plan.interfaces.iter().map(|i| i.name.as_str());
        let crossing = || plan.interfaces.iter().filter(|i| i.carries_impulses()).map(|i| i.name.as_str());
        let closures = solvers().zip(forms).filter_map(|(name, form)| {
            self.line(name, &format!("{name}.closure"), Some(ClosureGate::of(*form, 1).window))
        });
        let of = |names: &mut dyn Iterator<Item = &'a str>, column: &str, gate: Option<f64>| -> Vec<Line<'a>> {
            names.filter_map(|name| self.line(name, &format!("{name}.{column}"), gate)).collect()
        };
        let mut energy = of(&mut solvers(), "kinetic_j", None);
        energy.extend(self.line("total", "total_energy_j", None));
        let charts = [
            chart(
                "Closure",
                "1",
                true,
                "Change of momentum that no impulse explains, over the largest gross momentum of the run. The gate of a single-precision solver grows with its substeps; drawn is that of one.",
                closures.collect(),
            ),
            chart(
                "Transfer defect",
                "N s",
                true,
                "Impulse given minus impulse received. It must be exactly 0.",
                of(&mut crossing(), "transfer_defect_n_s", Some(0.0)),
            ),
            chart(
                "Impulse of a window",
                "N s",
                false,
                "Sum of the magnitudes of all impulses that crossed.",
                of(&mut crossing(), "gross_n_s", None),
            ),
            chart(
                "Residual",
                "m/s",
                false,
                "By how much the stand-in of a partner went elsewhere than the partner itself.",
                of(&mut interfaces(), "residual", None),
            ),
            chart(
                "Kinetic energy, and total energy",
                "J",
                false,
                "The total has gravity and elastic energy in it.",
                energy,
            ),
            chart("Substeps of a window", "1", false, "", of(&mut solvers(), "substeps", None)),
        ];
        charts.into_iter().filter(|c| !c.lines.is_empty()).collect()
    }

    /// Curves of the probes: one chart a probe, one line a component.
    pub(super) fn probes(&self) -> Vec<Chart<'_>> {
        let mut charts: Vec<Chart<'_>> = Vec::new();
        for (at, name) in self.names.iter().enumerate().filter(|(_, n)| *n != "time_s") {
            let (probe, component) = name.rsplit_once('.').unwrap_or((name, ""));
            let line = Line { name: component, gate: None, points: self.points(at) };
            match charts.iter_mut().find(|c| c.title == probe) {
                Some(known) => known.lines.push(line),
                None => charts.push(chart(probe, "SI", false, "", vec![line])),
            }
        }
        charts
    }
}

fn chart<'a>(title: &'a str, unit: &'a str, logarithmic: bool, note: &'a str, lines: Vec<Line<'a>>) -> Chart<'a> {
    Chart { title, unit, logarithmic, note, lines }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_long_table_keeps_its_peaks_and_its_gaps() {
        let place = tempfile::tempdir().unwrap();
        let path = place.path().join("t.csv");
        let rows = 3 * POINTS;
        let value = |i: u64| match i {
            7000 => "-5".to_owned(),
            9001 => "NaN".to_owned(),
            _ => "1".to_owned(),
        };
        let lines: Vec<String> = (0..rows).map(|i| format!("{i},{}", value(i))).collect();
        std::fs::write(&path, format!("time_s,a.x\n{}\n", lines.join("\n"))).unwrap();
        let table = Table::read(&path, rows).unwrap();
        let charts = table.probes();
        let points = &charts[0].lines[0].points;
        assert_eq!(points.len() as u64, POINTS);
        assert_eq!(points[2333], (6999.0, -5.0));
        assert!(points[3000].1.is_nan() && points[3001] == (9003.0, 1.0));
    }
}
