//! `ledger.csv`: the budgets of every window.
//!
//! One table in long form. The column `row` says what a line is about: the `window` as a whole (state hash, total
//! energy), a `solver` or an `interface`. Columns that do not apply are empty. Nothing in it depends on the wall clock
//! or on the number of threads, so that two runs of the same scene can be compared byte by byte.

use std::fs::File;
use std::io;
use std::path::Path;

use cosplat_core::control::Done;
use cosplat_core::ledger::{InterfaceRecord, SolverRecord, WindowRecord};
use cosplat_core::plan::Plan;

/// Columns; SI units.
const COLUMNS: [&str; 27] = [
    "window",
    "time_s",
    "row",
    "name",
    "state_hash",
    "total_energy_j",
    "kinetic_j",
    "potential_j",
    "dissipated_j",
    "momentum_x",
    "momentum_y",
    "momentum_z",
    "closure",
    "angular_closure",
    "substeps",
    "given_x_n_s",
    "given_y_n_s",
    "given_z_n_s",
    "received_x_n_s",
    "received_y_n_s",
    "received_z_n_s",
    "gross_n_s",
    "transfer_defect_n_s",
    "work_defect_j",
    "residual",
    "stored_j",
    "counters",
];

/// First column of the part that only `window` rows have.
const WINDOW_PART: usize = 4;
/// First column of the part that only `solver` rows have.
const SOLVER_PART: usize = 6;
/// First column of the part that only `interface` rows have.
const INTERFACE_PART: usize = 15;
/// The column of counters, which `solver` rows have.
const COUNTERS: usize = 26;

/// Writes the table.
#[derive(Debug)]
pub(crate) struct Ledger {
    out: csv::Writer<File>,
    solvers: Vec<String>,
    interfaces: Vec<String>,
    every: u64,
    windows: u64,
    /// The newest window, where it has not been written because of `every`.
    held: Option<(WindowRecord, Vec<Done>)>,
}

impl Ledger {
    /// Begins the table; `every` is the number of windows per written one.
    ///
    /// # Errors
    /// The file cannot be written.
    pub(crate) fn create(path: &Path, plan: &Plan, every: u64) -> io::Result<Self> {
        let mut out = csv::WriterBuilder::new().buffer_capacity(1 << 18).from_writer(File::create(path)?);
        out.write_record(COLUMNS)?;
        out.flush()?;
        Ok(Self {
            out,
            solvers: plan.participants.iter().map(|p| p.name.clone()).collect(),
            interfaces: plan.interfaces.iter().map(|i| i.name.clone()).collect(),
            every: every.max(1),
            windows: plan.clock.windows,
            held: None,
        })
    }

    /// Takes a settled window.
    ///
    /// # Errors
    /// The file cannot be written.
    pub(crate) fn settled(&mut self, record: &WindowRecord, done: &[Done]) -> io::Result<()> {
        if record.window.is_multiple_of(self.every) || record.window + 1 == self.windows {
            self.held = None;
            self.write(record, done)
        } else {
            self.held = Some((record.clone(), done.to_vec()));
            Ok(())
        }
    }

    /// Writes the last settled window if it has not been written.
    ///
    /// # Errors
    /// The file cannot be written.
    pub(crate) fn finish(&mut self) -> io::Result<()> {
        match self.held.take() {
            Some((record, done)) => self.write(&record, &done),
            None => Ok(()),
        }
    }

    fn write(&mut self, record: &WindowRecord, done: &[Done]) -> io::Result<()> {
        let mut row = start(record, "window", "");
        row[WINDOW_PART] = format!("{:032x}", record.state_hash);
        row[WINDOW_PART + 1] = number(record.total_energy_j);
        self.out.write_record(&row)?;
        for (i, (name, solver)) in self.solvers.iter().zip(&record.solvers).enumerate() {
            let mut row = start(record, "solver", name);
            fill(&mut row, SOLVER_PART, &solver_numbers(solver));
            if let Some(done) = done.get(i) {
                row[INTERFACE_PART - 1] = done.report.substeps.to_string();
                row[COUNTERS] = counters(done);
            }
            self.out.write_record(&row)?;
        }
        for (name, interface) in self.interfaces.iter().zip(&record.interfaces) {
            let mut row = start(record, "interface", name);
            fill(&mut row, INTERFACE_PART, &interface_numbers(interface));
            self.out.write_record(&row)?;
        }
        // One write of whole lines per window: a kill loses nothing that was settled.
        self.out.flush()
    }
}

fn start(record: &WindowRecord, kind: &str, name: &str) -> Vec<String> {
    let mut row = vec![String::new(); COLUMNS.len()];
    row[0] = record.window.to_string();
    row[1] = number(record.end_s);
    kind.clone_into(&mut row[2]);
    name.clone_into(&mut row[3]);
    row
}

fn fill(row: &mut [String], from: usize, numbers: &[f64]) {
    for (cell, value) in row.iter_mut().skip(from).zip(numbers) {
        *cell = number(*value);
    }
}

fn solver_numbers(s: &SolverRecord) -> [f64; 8] {
    let [x, y, z] = s.momentum;
    [s.kinetic_j, s.potential_j, s.dissipated_j, x, y, z, s.closure, s.angular_closure]
}

fn interface_numbers(i: &InterfaceRecord) -> [f64; 11] {
    let ([gx, gy, gz], [rx, ry, rz]) = (i.given, i.received);
    [gx, gy, gz, rx, ry, rz, i.gross, i.transfer_defect, i.work_defect, i.residual, i.stored_j]
}

/// Counters that are not zero, as `name=3 other=1`.
fn counters(done: &Done) -> String {
    let counted = done.report.counters.iter().filter(|(_, n)| **n > 0);
    counted.map(|(name, n)| format!("{name}={n}")).collect::<Vec<_>>().join(" ")
}

/// The shortest decimal number that is read back as the same bits.
pub(crate) fn number(value: f64) -> String {
    let mut buffer = format!("{value:e}");
    let plain = value.to_string();
    if plain.len() <= buffer.len() {
        buffer = plain;
    }
    buffer
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::folder::tally::tests::{done, plan, record};

    fn rows(path: &Path) -> Vec<csv::StringRecord> {
        csv::Reader::from_path(path).unwrap().records().map(Result::unwrap).collect()
    }

    #[test]
    fn every_solver_and_interface_of_a_window_has_a_row_at_once() {
        let place = tempfile::tempdir().unwrap();
        let path = place.path().join("ledger.csv");
        let mut ledger = Ledger::create(&path, &plan(4), 1).unwrap();
        ledger.settled(&record(0), &[done(0), done(0)]).unwrap();
        // Not finished, not dropped: what a kill would leave.
        let rows = rows(&path);
        assert_eq!(
            rows.iter().map(|r| r[2].to_owned()).collect::<Vec<_>>(),
            ["window", "solver", "solver", "interface"]
        );
        assert_eq!(&rows[0][4], "000000000000000000000000000000ab");
        assert_eq!(&rows[1][3], "left");
        assert_eq!((&rows[3][21], &rows[3][22]), ("1", "0"));
    }

    #[test]
    fn thinned_tables_still_end_with_the_last_window() {
        let place = tempfile::tempdir().unwrap();
        let path = place.path().join("ledger.csv");
        let mut ledger = Ledger::create(&path, &plan(100), 10).unwrap();
        for window in 0..15 {
            ledger.settled(&record(window), &[done(window), done(window)]).unwrap();
        }
        ledger.finish().unwrap();
        let windows: Vec<u64> =
            rows(&path).iter().filter(|r| &r[2] == "window").map(|r| r[0].parse().unwrap()).collect();
        assert_eq!(windows, [0, 10, 14]);
    }

    #[test]
    fn numbers_come_back_as_the_same_bits() {
        for value in [0.1, 1e-300, -0.0, 4.0 * std::f64::consts::PI.powi(2), 1.0 / 3.0, 1e22] {
            assert_eq!(number(value).parse::<f64>().unwrap().to_bits(), value.to_bits(), "{value}");
        }
        assert_eq!(number(0.01), "0.01");
    }
}
