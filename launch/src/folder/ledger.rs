//! `ledger.csv`: the budgets of every window, one row a window.
//!
//! First the window itself: number, end, state hash, total energy. Then, with the name in front, the columns of each
//! solver (`left.closure`) and of each interface (`a~b.transfer_defect_n_s`). SI units. Nothing in it depends on the
//! wall clock or on the number of threads, so that two runs of the same scene can be compared byte by byte.

use std::fs::{self, File};
use std::io;
use std::path::Path;

use cosplat_core::control::Done;
use cosplat_core::ledger::{InterfaceRecord, SolverRecord, WindowRecord};
use cosplat_core::plan::Plan;

use super::replace;

/// Columns of the window itself.
const WINDOW: [&str; 4] = ["window", "time_s", "state_hash", "total_energy_j"];

/// Columns of a solver.
const SOLVER: [&str; 12] = [
    "kinetic_j",
    "potential_j",
    "dissipated_j",
    "supplied_j",
    "momentum_x",
    "momentum_y",
    "momentum_z",
    "closure",
    "angular_closure",
    "moment_closure",
    "substeps",
    "counted",
];

/// Columns of an interface.
const INTERFACE: [&str; 12] = [
    "given_x_n_s",
    "given_y_n_s",
    "given_z_n_s",
    "received_x_n_s",
    "received_y_n_s",
    "received_z_n_s",
    "gross_n_s",
    "transfer_defect_n_s",
    "moment_defect_n_m_s",
    "work_defect_j",
    "residual",
    "stored_j",
];

/// Writes the table.
#[derive(Debug)]
pub(crate) struct Ledger {
    out: csv::Writer<File>,
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
        out.write_record(header(plan))?;
        out.flush()?;
        Ok(Self { out, every: every.max(1), windows: plan.clock.windows, held: None })
    }

    /// Goes on with the table of an earlier life of the run: windows from `from` on are computed again.
    ///
    /// # Errors
    /// The file cannot be read or written, or it lacks windows.
    pub(crate) fn reopen(path: &Path, plan: &Plan, every: u64, from: u64) -> io::Result<Self> {
        let every = every.max(1);
        let text = fs::read_to_string(path)?;
        let (header, rows) = text.split_once('\n').unwrap_or_default();
        let number = |row: &&str| row.split(',').next().and_then(|window| window.parse::<u64>().ok());
        // A run that was stopped has also written the window at which it was.
        let is_kept = |row: &&str| number(row).is_some_and(|window| window < from && window.is_multiple_of(every));
        let kept: Vec<&str> = rows.lines().filter(is_kept).collect();
        if kept.len() as u64 != from.div_ceil(every) {
            return Err(io::Error::other(format!("it lacks windows before window {from}")));
        }
        let out = csv::WriterBuilder::new().buffer_capacity(1 << 18).from_writer(reopen_table(path, header, &kept)?);
        Ok(Self { out, every, windows: plan.clock.windows, held: None })
    }

    /// Waits until all that was written is on disk.
    ///
    /// # Errors
    /// It cannot be written.
    pub(crate) fn sync(&self) -> io::Result<()> {
        self.out.get_ref().sync_data()
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
        let hash = format!("{:032x}", record.state_hash);
        let mut row = vec![record.window.to_string(), number(record.end_s), hash, number(record.total_energy_j)];
        for (solver, done) in record.solvers.iter().zip(done) {
            row.extend(solver_numbers(solver).map(number));
            row.push(done.report.substeps.to_string());
            row.push(done.report.counters.values().sum::<u64>().to_string());
        }
        row.extend(record.interfaces.iter().flat_map(|i| interface_numbers(i).map(number)));
        self.out.write_record(&row)?;
        // One write of a whole line per window: a kill loses nothing that was settled.
        self.out.flush()
    }
}

/// Opens a table for more rows, with no others than these.
pub(super) fn reopen_table(path: &Path, header: &str, rows: &[&str]) -> io::Result<File> {
    let text = rows.iter().fold(format!("{header}\n"), |text, row| text + row + "\n");
    replace(path, text.as_bytes())?;
    File::options().append(true).open(path)
}

fn header(plan: &Plan) -> Vec<String> {
    let mut header: Vec<String> = WINDOW.map(str::to_owned).into();
    for participant in plan.solvers() {
        header.extend(SOLVER.iter().map(|column| format!("{}.{column}", participant.name)));
    }
    for (i, interface) in plan.interfaces.iter().enumerate() {
        // Two bodies may touch and be joined as well; the second interface of a name gets a number.
        let namesakes = plan.interfaces[..i].iter().filter(|other| other.name == interface.name).count();
        let name =
            if namesakes == 0 { interface.name.clone() } else { format!("{}#{}", interface.name, namesakes + 1) };
        header.extend(INTERFACE.iter().map(|column| format!("{name}.{column}")));
    }
    header
}

fn solver_numbers(s: &SolverRecord) -> [f64; 10] {
    let [x, y, z] = s.momentum;
    let stays = [s.kinetic_j, s.potential_j, s.dissipated_j, s.supplied_j];
    let [kinetic, potential, dissipated, supplied] = stays;
    let [closure, angular, moment] = [s.closure, s.angular_closure, s.moment_closure];
    [kinetic, potential, dissipated, supplied, x, y, z, closure, angular, moment]
}

fn interface_numbers(i: &InterfaceRecord) -> [f64; 12] {
    let ([gx, gy, gz], [rx, ry, rz]) = (i.given, i.received);
    [gx, gy, gz, rx, ry, rz, i.gross, i.transfer_defect, i.moment_defect, i.work_defect, i.residual, i.stored_j]
}

/// The shortest decimal number that is read back as the same bits.
pub(crate) fn number(value: f64) -> String {
    let (plain, exponential) = (value.to_string(), format!("{value:e}"));
    if plain.len() <= exponential.len() { plain } else { exponential }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::folder::fixtures::{done, plan, record};

    fn table(path: &Path) -> (Vec<String>, Vec<csv::StringRecord>) {
        let mut reader = csv::Reader::from_path(path).unwrap();
        let header = reader.headers().unwrap().iter().map(str::to_owned).collect();
        (header, reader.records().map(Result::unwrap).collect())
    }

    #[test]
    fn a_settled_window_is_on_disk_at_once() {
        let place = tempfile::tempdir().unwrap();
        let path = place.path().join("ledger.csv");
        let mut ledger = Ledger::create(&path, &plan(4), 1).unwrap();
        ledger.settled(&record(0), &[done(0), done(0)]).unwrap();
        // Not finished, not dropped: what a kill would leave.
        let (header, rows) = table(&path);
        let cell = |name: &str| rows[0][header.iter().position(|h| h == name).unwrap()].to_owned();
        assert_eq!((rows.len(), rows[0].len()), (1, 4 + 2 * SOLVER.len() + INTERFACE.len()));
        assert_eq!(cell("state_hash"), "000000000000000000000000000000ab");
        assert_eq!([cell("total_energy_j"), cell("right.substeps"), cell("a~b.gross_n_s")], ["2", "3", "1"]);
    }

    #[test]
    fn a_resumed_table_is_the_same_as_an_uninterrupted_one() {
        let place = tempfile::tempdir().unwrap();
        let (whole, broken) = (place.path().join("whole.csv"), place.path().join("broken.csv"));
        let write = |mut ledger: Ledger, windows: std::ops::Range<u64>| {
            windows.for_each(|window| ledger.settled(&record(window), &[done(window), done(window)]).unwrap());
            ledger.finish().unwrap();
        };
        write(Ledger::create(&whole, &plan(100), 10).unwrap(), 0..100);
        write(Ledger::create(&broken, &plan(100), 10).unwrap(), 0..37);
        write(Ledger::reopen(&broken, &plan(100), 10, 25).unwrap(), 25..100);
        assert_eq!(fs::read_to_string(&broken).unwrap(), fs::read_to_string(&whole).unwrap());
        assert!(Ledger::reopen(&broken, &plan(100), 10, 200).is_err(), "windows are missing");
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
        let windows: Vec<u64> = table(&path).1.iter().map(|r| r[0].parse().unwrap()).collect();
        assert_eq!(windows, [0, 10, 14]);
    }

    #[test]
    fn interfaces_of_one_name_have_columns_of_their_own() {
        let mut plan = plan(4);
        plan.interfaces.push(plan.interfaces[0].clone());
        let header = header(&plan);
        assert!(header.contains(&"a~b.gross_n_s".to_owned()) && header.contains(&"a~b#2.gross_n_s".to_owned()));
    }

    #[test]
    fn numbers_come_back_as_the_same_bits() {
        for value in [0.1, 1e-300, -0.0, 4.0 * std::f64::consts::PI.powi(2), 1.0 / 3.0, 1e22] {
            assert_eq!(number(value).parse::<f64>().unwrap().to_bits(), value.to_bits(), "{value}");
        }
        assert_eq!(number(0.01), "0.01");
    }
}
