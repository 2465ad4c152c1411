//! Whether a result is to be trusted: gates on what was measured during the run.
//!
//! Impulses that cross must arrive to the last bit, and each solver's momentum, summed over its own state, must be
//! explained by the impulses that act on it. The second is what turns red when a solver throws impulses away: an echo
//! of what was sent could not tell.

use cosplat_core::plan::BoundaryForm;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A gate, what was measured, and what that says.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub(crate) struct Verdict {
    /// What was judged: `transfer-defect`, `closure-window`, `closure-run`.
    pub(crate) name: String,
    /// Interface or process in which the value was measured.
    pub(crate) of: String,
    /// Measured value.
    pub(crate) value: f64,
    /// Largest value that passes.
    pub(crate) limit: f64,
    /// Whether it passed.
    pub(crate) passed: bool,
}

impl Verdict {
    /// Judges a value; what is no number does not pass.
    pub(crate) fn new(name: &str, of: &str, value: f64, limit: f64) -> Self {
        Self { name: name.into(), of: of.into(), value, limit, passed: value <= limit }
    }
}

/// Limits of the closure, relative to the run's largest gross momentum.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct ClosureGate {
    /// In one window.
    pub(crate) window: f64,
    /// Over the whole run.
    pub(crate) run: f64,
}

impl ClosureGate {
    /// The gate of a solver by the numbers it computes with, told by the form of its boundary: `max(1e-6, 6e-8 ×
    /// substeps)` a window and `1e-3` a run in single precision, `1e-12` and `1e-9` in double.
    pub(crate) fn of(form: BoundaryForm, substeps: u64) -> Self {
        match form {
            BoundaryForm::SamplesF32 { .. } => Self { window: (6e-8 * substeps as f64).max(1e-6), run: 1e-3 },
            BoundaryForm::SamplesF64 { .. } | BoundaryForm::Proxy => Self { window: 1e-12, run: 1e-9 },
        }
    }
}

/// Closure of a process over a run, linear and angular, whichever is larger.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub(crate) struct Closure {
    /// In the window that comes nearest to its limit or goes furthest beyond.
    pub(crate) worst: f64,
    /// Limit of that window.
    limit: f64,
    /// Sum of all windows, which the defect of the run cannot exceed.
    sum: f64,
}

impl Default for Closure {
    fn default() -> Self {
        Self { worst: 0.0, limit: f64::INFINITY, sum: 0.0 }
    }
}

impl Closure {
    /// Takes the closure of a window and its limit. What is no number is the worst of all, and stays.
    pub(crate) fn add(&mut self, value: f64, limit: f64) {
        let is_worse = value.is_nan() || value / limit >= self.worst / self.limit;
        if is_worse && !self.worst.is_nan() {
            (self.worst, self.limit) = (value, limit);
        }
        self.sum += value;
    }

    /// Judges the worst window, and the run by its own limit.
    pub(crate) fn verdicts(&self, process: &str, run_limit: f64) -> [Verdict; 2] {
        [
            Verdict::new("closure-window", process, self.worst, self.limit),
            Verdict::new("closure-run", process, self.sum, run_limit),
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_no_number_does_not_pass() {
        assert!(!Verdict::new("closure-window", "a", f64::NAN, 1.0).passed);
        assert!(!Verdict::new("transfer-defect", "a~b", f64::MIN_POSITIVE, 0.0).passed);
        assert!(Verdict::new("transfer-defect", "a~b", 0.0, 0.0).passed);
    }

    #[test]
    fn single_precision_may_lose_more_with_more_substeps() {
        let single = |substeps| ClosureGate::of(BoundaryForm::SamplesF32 { normals: false }, substeps).window;
        let double = ClosureGate::of(BoundaryForm::Proxy, 1000).window;
        assert_eq!([single(1), single(1000), double].map(|gate| format!("{gate:.0e}")), ["1e-6", "6e-5", "1e-12"]);
    }
}
