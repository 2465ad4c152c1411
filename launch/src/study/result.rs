//! What a study has found out, for pages, tables and programs. SI units; errors are relative.

use serde::Serialize;

use super::case::{Claim, Factor, Gate, Measure};
use super::front::Cheapest;
use super::order::Fit;
use super::outcome::Class;
use crate::folder::summary::Process;

/// A case with all its runs.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct CaseResult {
    /// Short name.
    pub(crate) name: String,
    /// One line for people.
    pub(crate) title: String,
    /// Scene file or built-in scene.
    pub(crate) scene: String,
    /// Where the reference is from; the finest run, where the case has none of its own.
    pub(crate) reference: String,
    /// What was measured.
    pub(crate) quantities: Vec<Measured>,
    /// What was varied; the last one is the axis of the order fits.
    pub(crate) vary: Vec<Factor>,
    /// One for each combination of what was varied.
    pub(crate) rows: Vec<Row>,
    /// Runs that differ in the axis alone.
    pub(crate) groups: Vec<Group>,
    /// Rows that no other beats in both time and error, the fastest first.
    pub(crate) front: Vec<usize>,
    /// The cheapest row for each of four errors.
    pub(crate) cheapest: Vec<Cheapest>,
    /// What had to hold.
    pub(crate) gates: Vec<Judged>,
    /// What a reader must know.
    pub(crate) notes: Vec<String>,
}

/// A quantity of a case.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(crate) struct Measured {
    /// Column of the probes, or name of the invariant.
    pub(crate) name: String,
    /// Norm of its error; absent for invariants.
    pub(crate) measure: Option<Measure>,
    /// What it is compared with, in words.
    pub(crate) reference: String,
}

/// A run, with its repetitions.
#[derive(Clone, Debug, Default, Serialize)]
pub(crate) struct Row {
    /// Key and value of all that was varied.
    pub(crate) settings: Vec<(String, String)>,
    /// All settings but the axis.
    pub(crate) group: String,
    /// Value of the axis, where it is a number.
    pub(crate) axis: Option<f64>,
    /// How it ended.
    pub(crate) outcome: Option<Class>,
    /// Exit code of `cosplat run`.
    pub(crate) exit_code: u8,
    /// What it complained about.
    pub(crate) why: Option<String>,
    /// Largest error of all quantities that have a reference; of all invariants where none has. Null where nothing
    /// could be compared, and where the result is no number.
    pub(crate) error: Option<f64>,
    /// Error of each quantity.
    pub(crate) errors: Vec<Option<f64>>,
    /// Distance from the run with the shortest window and all else the same, where windows are varied.
    pub(crate) error_coupling: Option<f64>,
    /// Error of that run: what the solvers leave when the coupling is as good as it gets here.
    pub(crate) error_solver: Option<f64>,
    /// What it took, where it has a result.
    pub(crate) cost: Option<Cost>,
    /// Length of a window \[s\].
    pub(crate) window_s: Option<f64>,
    /// Substeps of all solvers.
    pub(crate) substeps: Option<u64>,
    /// Largest deviation of the total energy from its start, relative to it.
    pub(crate) energy_drift: Option<f64>,
    /// Worst momentum defect of its interfaces.
    pub(crate) momentum_defect: Option<f64>,
    /// Clamps, quarantines, overflows and the like; counts of work done are not in it.
    pub(crate) complaints: u64,
    /// What the run says against itself: red verdicts, and what it clamped, lost or left unfinished.
    pub(crate) reported: Vec<String>,
    /// Chain of all states.
    pub(crate) state_hash: Option<String>,
    /// Folder of its first repetition.
    pub(crate) folder: String,
    /// Repetitions that an earlier study had left.
    pub(crate) cached: usize,
}

/// What a run took.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub(crate) struct Cost {
    /// Wall time inside the windows \[s\], the median of the repetitions.
    pub(crate) wall_s: f64,
    /// Largest minus smallest wall time, over the median.
    pub(crate) wall_spread: f64,
    /// Repetitions whose time counts.
    pub(crate) runs: usize,
    /// Whether other runs were made beside them: the times are upper bounds.
    pub(crate) beside_others: bool,
    /// Simulated time \[s\].
    pub(crate) simulated_s: f64,
    /// Processor time of all solvers, set-up included \[s\]; null where the system does not tell.
    pub(crate) core_s: Option<f64>,
    /// Where the time of each process went, in the repetition with the median.
    pub(crate) processes: Vec<Process>,
}

impl Cost {
    /// Sum over the processes.
    pub(crate) fn sum(&self, part: fn(&Process) -> f64) -> f64 {
        self.processes.iter().map(part).sum()
    }
}

impl Row {
    /// Whether it has a result that can be compared.
    pub(crate) fn has_result(&self) -> bool {
        matches!(self.outcome, Some(Class::Correct | Class::Degraded))
    }

    /// Time and error, where it can be recommended: its verdicts are good. What it has clamped is in its error.
    pub(crate) fn work_and_error(&self) -> Option<(f64, f64)> {
        let is_good = self.has_result() && self.exit_code == 0;
        Some((self.cost.as_ref()?.wall_s, self.error?)).filter(|(_, error)| is_good && error.is_finite())
    }

    /// Value of what was varied, where it is a number.
    pub(crate) fn value(&self, key: &str) -> Option<f64> {
        self.settings.iter().find(|(k, _)| k == key)?.1.parse().ok()
    }

    /// All settings but one, for people.
    pub(crate) fn without(&self, key: &str) -> String {
        let others = self.settings.iter().filter(|(k, _)| k != key);
        others.map(|(key, value)| format!("{key}={value}")).collect::<Vec<_>>().join(" ")
    }

    /// All settings, for people.
    pub(crate) fn name(&self) -> String {
        let text: Vec<String> = self.settings.iter().map(|(key, value)| format!("{key}={value}")).collect();
        if text.is_empty() { "as the scene says".into() } else { text.join(" ") }
    }
}

/// Runs that differ in the axis alone.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(crate) struct Group {
    /// Their settings.
    pub(crate) name: String,
    /// Places of its rows, coarse to fine.
    pub(crate) rows: Vec<usize>,
    /// Order of the error in the axis.
    pub(crate) fit: Option<Fit>,
}

/// A gate and whether it held.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(crate) struct Judged {
    /// The gate.
    #[serde(flatten)]
    pub(crate) gate: Gate,
    /// Null where no run was made that it is about.
    pub(crate) passed: Option<bool>,
    /// What was measured, in words.
    pub(crate) measured: String,
}

impl Judged {
    /// Whether it does not hold, and nobody knows why.
    pub(crate) fn is_unexplained(&self) -> bool {
        self.passed == Some(false) && self.gate.explained.is_none()
    }

    /// Whether it holds although the case says why it does not.
    pub(crate) fn is_out_of_date(&self) -> bool {
        self.passed == Some(true) && self.gate.explained.is_some()
    }

    /// Whether it claims how runs end.
    pub(crate) fn is_outcome(&self) -> bool {
        matches!(self.gate.claim, Claim::Outcome(_))
    }
}

impl CaseResult {
    /// Whether every run ends as a gate says that it ends.
    pub(crate) fn has_its_outcomes(&self) -> bool {
        self.gates.iter().all(|judged| !judged.is_outcome() || judged.passed != Some(false))
    }

    /// Whether all gates held that were judged.
    pub(crate) fn is_green(&self) -> bool {
        self.gates.iter().all(|judged| judged.passed != Some(false))
    }

    /// Whether each gate held that was judged, or the case says why not.
    pub(crate) fn is_accounted_for(&self) -> bool {
        !self.gates.iter().any(Judged::is_unexplained)
    }

    /// Gates in words, for tables of many cases: how many were judged and did not hold.
    pub(crate) fn gates_in_short(&self) -> String {
        let judged = self.gates.iter().filter(|g| g.passed.is_some()).count();
        let failed = self.gates.iter().filter(|g| g.passed == Some(false)).count();
        let unexplained = self.gates.iter().filter(|g| g.is_unexplained()).count();
        match (judged, failed, unexplained) {
            (0, ..) => "none".into(),
            (1, 0, _) => "holds".into(),
            (n, 0, _) => format!("all {n} hold"),
            (n, failed, 0) => format!("{failed} of {n} failed, explained"),
            (n, failed, _) => format!("{failed} of {n} failed"),
        }
    }

    /// Whether its errors follow a power of the axis, as far as its gates know: where one claims a decay, they do not.
    pub(crate) fn has_powers(&self) -> bool {
        !self.gates.iter().any(|judged| matches!(judged.gate.claim, Claim::Decay(_)))
    }

    /// Name of the axis.
    pub(crate) fn axis(&self) -> Option<&str> {
        self.vary.last().map(|factor| factor.key.as_str())
    }

    /// Orders that are known to half an order, for tables of many cases.
    pub(crate) fn orders(&self) -> String {
        let fits = self.groups.iter().filter_map(|group| group.fit.as_ref());
        let known = fits.filter(|fit| fit.plus_minus.is_some_and(|half| half < 0.5));
        let orders: Vec<String> = known.map(|fit| format!("{:.2}", fit.order)).collect();
        if orders.is_empty() { "–".into() } else { orders.join(", ") }
    }

    /// Place of the cheapest row with an error of at most 1 %.
    pub(crate) fn row_of_one_percent(&self) -> Option<usize> {
        self.cheapest.iter().find(|wanted| (wanted.error - 0.01).abs() < 1e-9)?.row
    }

    /// Smallest error of all runs that can be recommended.
    pub(crate) fn smallest_error(&self) -> Option<f64> {
        self.rows.iter().filter_map(Row::work_and_error).map(|c| c.1).reduce(f64::min)
    }
}
