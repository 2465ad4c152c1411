//! The energy budget of a run: energy and what was dissipated of it, less the work from outside, may not rise above the start.
//!
//! Where a potential is zero is a choice: a scene that stands on a hill has more energy at the start than the same one in a
//! valley, and a share of that says nothing. So the scale is what was there to be spent: the energy at the start with the
//! potential of each process measured from the lowest that it came to, and the most that was supplied at any time: of what
//! flows in or out, its potential from the origin. It is never less than what a scene at rest trembles by, a part of the energy
//! as it is booked. The share of the energy at the start as it is booked, with the potential zero at the origin of the scene,
//! is told beside it.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::STILL;
use crate::folder::summary::Summary;
use crate::report::short;

/// Part of what could be spent by which the budget may be exceeded.
const LIMIT: f64 = 1e-3;

/// How far energy and what was dissipated of it, less the work from outside, rose above the start.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub(crate) struct EnergyBudget {
    /// Energy at t = 0 [J]: kinetic, stored, and potential, which is zero at the origin of the scene.
    pub(crate) initial_j: f64,
    /// What could be spent [J]: the same with each process's potential measured from its lowest, and the most that was supplied.
    pub(crate) free_j: f64,
    /// Largest after any window of energy + dissipated - supplied - initial [J]; negative where it stayed below.
    pub(crate) excess_j: f64,
    /// Excess over what could be spent.
    pub(crate) share: f64,
    /// Excess over the energy at the start as booked; null where that is not positive.
    pub(crate) share_of_initial: Option<f64>,
    /// Share up to which the budget is kept.
    pub(crate) limit: f64,
    /// Whether it is.
    pub(crate) is_kept: bool,
}

impl EnergyBudget {
    /// Of a run whose energy at t = 0 is known, and all of whose energies are numbers.
    pub(crate) fn of(summary: &Summary) -> Option<Self> {
        let total = summary.energy.iter().find(|e| e.name == "total").filter(|_| summary.windows > 0)?;
        let initial_j = total.initial_j?;
        let lowest_j: f64 = summary.energy.iter().filter(|e| e.name != "total").map(|e| e.min_potential_j).sum();
        // What a scene at rest trembles by is no scale.
        let still_j = STILL * total.max_j.abs().max(total.min_j.abs());
        let free_j = (initial_j - lowest_j + total.max_supplied_j).max(still_j);
        let excess_j = total.max_balance_j - initial_j;
        // Where nothing could be spent, nothing may appear.
        let share = if excess_j == 0.0 { 0.0 } else { excess_j / free_j };
        if !(share.is_finite() && initial_j.is_finite()) {
            return None;
        }
        let share_of_initial = (initial_j > 0.0).then(|| excess_j / initial_j);
        Some(Self { initial_j, free_j, excess_j, share, share_of_initial, limit: LIMIT, is_kept: share <= LIMIT })
    }

    /// In one line.
    pub(crate) fn words(&self) -> String {
        let rose = if self.excess_j < 0.0 {
            format!("stayed at least {} J below", short(-self.excess_j))
        } else {
            format!("rose at most {} J above", short(self.excess_j))
        };
        let booked = self.share_of_initial.map_or_else(String::new, |share| format!(" and {share:.1e} of the start"));
        format!(
            "energy + dissipated - work from outside {rose} the {} J at the start (potential from the scene's origin): \
             {:.1e} of the {} J that could be spent (potential from its lowest){booked}, {} {:.0e}",
            short(self.initial_j),
            self.share,
            short(self.free_j),
            if self.is_kept { "within" } else { "not within" },
            self.limit
        )
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests::summary;
    use super::*;
    use crate::folder::summary::Energy;

    /// A run of two processes that begins with `start` \[J\], of which `lowest` \[J\] can never be spent.
    fn budget([start, lowest, most, supplied]: [f64; 4]) -> EnergyBudget {
        let part = |name: &str, min_potential_j| Energy { name: name.into(), min_potential_j, ..Energy::default() };
        let total =
            Energy { initial_j: Some(start), max_balance_j: most, max_supplied_j: supplied, ..part("total", f64::NAN) };
        let energy = vec![part("left", lowest - 7.0), part("right", 7.0), total];
        EnergyBudget::of(&Summary { energy, ..summary() }).unwrap()
    }

    #[test]
    fn the_scale_does_not_depend_on_where_the_potential_is_zero() {
        for hill in [0.0, 4096.0, -4096.0] {
            let found = budget([100.0 + hill, 60.0 + hill, 100.03125 + hill, 0.0]);
            assert_eq!((found.free_j, found.excess_j, found.is_kept), (40.0, 0.03125, true), "{hill}");
            assert_eq!(found.share_of_initial.is_some(), hill >= 0.0);
            assert!(found.words().contains("rose at most 0.0312 J above"), "{}", found.words());
            assert!(!budget([100.0 + hill, 60.0 + hill, 100.0625 + hill, 0.0]).is_kept, "{hill}");
        }
    }

    #[test]
    fn what_was_supplied_can_be_spent_and_what_is_lost_is_told() {
        let found = budget([0.0, 0.0, 0.0625, 100.0]);
        assert_eq!((found.free_j, found.share_of_initial, found.is_kept), (100.0, None, true));
        assert_eq!(budget([0.0, 0.0, 0.0, 0.0]).share.to_bits(), 0);
        let lost = budget([10.0, 0.0, 9.0, 0.0]);
        assert!(lost.is_kept && lost.words().contains("stayed at least 1 J below the 10 J"), "{}", lost.words());
        assert!(lost.words().ends_with("-1.0e-1 of the start, within 1e-3"), "{}", lost.words());
        assert!(budget([10.0, 0.0, 11.0, 0.0]).words().contains("not within 1e-3"));
    }

    #[test]
    fn without_a_start_there_is_no_budget() {
        let mut summary = summary();
        assert!(EnergyBudget::of(&summary).is_some());
        summary.windows = 0;
        assert_eq!(EnergyBudget::of(&summary), None);
        (summary.windows, summary.energy[1].initial_j) = (3, None);
        assert_eq!(EnergyBudget::of(&summary), None);
        (summary.energy[1].initial_j, summary.energy[1].max_balance_j) = (Some(1.0), f64::NAN);
        assert_eq!(EnergyBudget::of(&summary), None, "not a number cannot be read back");
    }
}
